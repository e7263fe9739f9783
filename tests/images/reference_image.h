// Reads and compares reference images of other renderers. Tests that need them are skipped if RAYGRAPH_ASSETS
// is unset.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

struct ReferenceImage {
    uint32_t width = 0, height = 0;
    std::vector<float> channels[3];

    double At(uint32_t x, uint32_t y, int channel) const {
        return double{channels[channel][size_t{y} * width + x]};
    }
    glm::dvec3 Mean() const;
};

// Skips its tests if there are no references.
class ReferenceTest : public VulkanTest {
  protected:
    void SetUp() override;
    ReferenceImage Read(const std::string& name) const;  // a file of references/, e.g. "cornell_metal.exr"

    std::filesystem::path assets;
    SceneRender render{Device()};
};

// Averages the picture over blocks of `size` x `size` pixels, row by row; incomplete blocks at the edges are
// omitted.
template <typename Value>
std::vector<double> Blocks(uint32_t width, uint32_t height, uint32_t size, Value&& value) {
    const uint32_t columns = width / size, rows = height / size;
    std::vector<double> blocks(size_t{columns} * rows, 0.0);
    for (uint32_t y = 0; y < rows * size; ++y)
        for (uint32_t x = 0; x < columns * size; ++x)
            blocks[size_t{y / size} * columns + x / size] += value(x, y) / (double(size) * size);
    return blocks;
}

}  // namespace raygraph::testing
