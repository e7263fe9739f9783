// Squares in the cells of a grid, of colors that tell which is which, seen from above: for tests of parts of a
// scene that come and go.
#pragma once

#include <vector>

#include "renderer/gpu_scene/streaming/prepared_scene.h"
#include "tests/passes/cells.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

inline constexpr uint32_t kPartSide = 8;
inline constexpr uint32_t kCells = kPartSide * kPartSide;

inline glm::vec3 PartPlace(uint32_t cell) {
    return CellCenter(cell, kPartSide);
}

// Different for each number, and exact in 8 bits.
inline glm::vec3 ColorOf(uint32_t number) {
    const glm::uvec3 steps(number % 5, number / 5 % 5, number / 25 % 5);
    return glm::vec3(51u * (steps + 1u)) / 255.0f;
}

// A square of that color, by a factor or by a texture of one texel.
inline scene::SceneData SquareOf(uint32_t number, uint32_t cell, bool isTextured) {
    scene::SceneData part =
        SceneOf({QuadMesh(0.4f)}, {Lambert(ColorOf(number))}, {Translation(PartPlace(cell))});
    if (!isTextured) return part;
    part.materials[0].baseColorFactor = glm::vec4(1.0f);
    part.materials[0].baseColorTexture.texture = 0;
    part.textures.resize(1);
    scene::ImageData& image = part.images.emplace_back();
    image.width = image.height = 1;
    const glm::vec3 color = ColorOf(number) * 255.0f;
    image.rgba = {uint8_t(color.x), uint8_t(color.y), uint8_t(color.z), 255};
    part.meshes[0].primitives[0].uv0.assign(4, glm::vec2(0.5f));
    return part;
}

class SceneParts : public VulkanTest {
  protected:
    struct Cell {
        uint32_t instance = kMiss;
        glm::vec3 color{0.0f};

        bool operator==(const Cell&) const = default;
    };

    explicit SceneParts(const GpuSceneDesc& desc = {}) : render(Device(), desc) {
        render.scene.SetScene(SquareOf(0, 0, false));
    }
    static passes::TraceSettings View() {
        scene::CameraView view = scene::CameraView::LookAt(
            {0.5f * kPartSide, 0.5f * kPartSide, 5}, {0.5f * kPartSide, 0.5f * kPartSide, 0}, {0, 1, 0});
        view.projection = scene::Projection::Orthographic;
        view.height = float(kPartSide);
        passes::TraceSettings settings;
        settings.extent = {kPartSide, kPartSide};
        settings.camera = ToRecord(view);
        settings.scattering.brdf = BrdfModel::Lambert;
        return settings;
    }
    // Colors of 8 bits, to the digits that they have.
    std::vector<Cell> Seen() { return SeenOf(render); }
    static std::vector<Cell> SeenOf(SceneRender& shown) {
        const SceneRender::Hits hits = shown.PrimaryHits(View());
        std::vector<Cell> seen(kCells);
        for (uint32_t i = 0; i < kCells; ++i) {
            const uint32_t pixel = (kPartSide - 1 - i / kPartSide) * kPartSide + i % kPartSide;
            if (hits.ids[pixel].x == kMiss) continue;
            seen[i] = {hits.ids[pixel].x, glm::round(255.0f * glm::vec3(hits.albedo.values[pixel])) / 255.0f};
        }
        return seen;
    }
    void Drop() {
        render.renderer.BeginFrame();
        (void)render.scene.Declare(render.renderer);
        render.renderer.DropFrame();
    }

    SceneRender render;
};

}  // namespace raygraph::testing
