// Reference images of other renderers: where they are, and how they are compared. Tests that need them are
// left out where RAYGRAPH_ASSETS is unset.
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

// Skips its tests where there are no references.
class ReferenceTest : public VulkanTest {
  protected:
    void SetUp() override;
    ReferenceImage Read(const std::string& name) const;  // of references/, "cornell_metal.exr"

    std::filesystem::path assets;
    SceneRender render{Device()};
};

// Averages the picture over blocks of `size` x `size` pixels, row by row; what is left over at the edges is
// left out.
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
