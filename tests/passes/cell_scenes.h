// Scenes whose things lie in square cells of 1 m side by side, seen from above: a pixel a cell.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <numeric>
#include <random>
#include <vector>

#include "renderer/gpu_scene/streaming/prepared_scene.h"
#include "renderer/graph/readback_values.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

// Square cells of 1 m side by side, seen from above: where test scenes place what they tell apart.
namespace raygraph::testing {

// Hit ids of pixels without a hit.
inline constexpr uint32_t kMiss = 0xFFFFFFFFu;

// Returns the center of a cell of a square of `side` cells a side, from the origin on.
inline glm::vec3 CellCenter(uint32_t cell, uint32_t side) {
    return {float(cell % side) + 0.5f, float(cell / side) + 0.5f, 0.0f};
}

}  // namespace raygraph::testing

// Boxes on a square grid, of which some move, are hidden, come or go: what rays should see of them.
namespace raygraph::testing {

inline constexpr uint32_t kSide = 20;
inline constexpr uint32_t kCount = kSide * kSide;

inline glm::vec3 Place(uint32_t cell) {
    return CellCenter(cell, kSide);
}

// A box, and beside it a leaf: of another group.
inline scene::Mesh BoxWithLeaf() {
    scene::Mesh mesh = BoxMesh(0.3f);
    scene::Primitive leaf = QuadMesh(0.05f, 1).primitives[0];
    leaf.bounds = {};
    for (glm::vec3& position : leaf.positions) {
        position += glm::vec3(0.4f, 0.4f, 0.0f);
        leaf.bounds.Extend(position);
    }
    leaf.colors.assign(4, glm::vec4(1.0f));
    leaf.colors[0].a = 0.0f;
    mesh.primitives.insert(mesh.primitives.begin(), leaf);
    return mesh;
}

// Boxes on a square grid, seen from above: a pixel a cell. Every other one has a leaf. A roof, the instance
// behind them, is out of sight and so large that a TLAS does not decay whatever the boxes do.
class InstanceChanges : public VulkanTest {
  protected:
    explicit InstanceChanges(bool hasRoof = false) : cellOf(kCount), isHidden(kCount) {
        std::iota(cellOf.begin(), cellOf.end(), 0u);
        scene::SceneData scene =
            SceneOf({BoxMesh(0.3f), BoxWithLeaf()}, {Lambert(glm::vec3(0.5f)), Lambert(glm::vec3(0.5f))});
        scene.materials[1].alphaMode = scene::AlphaMode::Mask;
        scene.instances.clear();
        for (uint32_t i = 0; i < kCount; ++i)
            scene.instances.push_back({.mesh = i % 2, .objectToWorld = Translation(Place(i))});
        if (hasRoof) {
            scene.meshes.push_back(QuadMesh(1e4f));
            roof = kCount;
            scene.instances.push_back({.mesh = 2, .objectToWorld = Translation({0, 0, 1e3f})});
        }
        render.scene.SetScene(std::move(scene));
        for (int frame = 0; frame < 8; ++frame) Seen();
        EXPECT_TRUE(render.scene.IsSettled());
    }
    static passes::TraceSettings View() {
        scene::CameraView view = scene::CameraView::LookAt({0.5f * kSide, 0.5f * kSide, 5},
                                                           {0.5f * kSide, 0.5f * kSide, 0}, {0, 1, 0});
        view.projection = scene::Projection::Orthographic;
        view.height = float(kSide);
        passes::TraceSettings settings;
        settings.extent = {kSide, kSide};
        settings.camera = ToRecord(view);
        return settings;
    }
    // By cell.
    std::vector<uint32_t> Seen() {
        const SceneRender::Hits hits = render.PrimaryHits(View());
        std::vector<uint32_t> seen(kCount);
        for (uint32_t i = 0; i < kCount; ++i)
            seen[i] = hits.ids[(kSide - 1 - i / kSide) * kSide + i % kSide].x;
        return seen;
    }
    std::vector<uint32_t> Expected() const {
        std::vector<uint32_t> expected(kCount, kMiss);
        for (uint32_t i = 0; i < kCount; ++i)
            if (!isHidden[i]) expected[cellOf[i]] = i;
        return expected;
    }
    // Exchanges the places of two instances, so many times.
    void Scatter(uint32_t pairs) {
        for (uint32_t i = 0; i < pairs; ++i) {
            const auto a = static_cast<uint32_t>(engine() % kCount),
                       b = static_cast<uint32_t>(engine() % kCount);
            std::swap(cellOf[a], cellOf[b]);
            for (const uint32_t moved : {a, b})
                render.scene.SetTransform(moved, Translation(Place(cellOf[moved])));
        }
    }
    void Toggle(uint32_t instance) {
        isHidden[instance] = !isHidden[instance];
        render.scene.SetVisible(instance, !isHidden[instance]);
    }
    // The roof's is left out.
    std::vector<gpu::InstanceRecord> Records() {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback readback = render.renderer.ReadBack(ids.instances);
        render.renderer.Execute();
        auto records = WaitForValues<gpu::InstanceRecord>(readback);
        records.resize(ids.placementCount);  // behind them there may be room for more
        std::erase_if(records, [this](const auto& record) { return record.instance == roof; });
        return records;
    }
    TlasWork LastWork() { return render.scene.Statistics().lastTlasWork; }

    SceneRender render{Device()};
    uint32_t roof = kMiss;
    std::vector<uint32_t> cellOf;
    std::vector<bool> isHidden;
    std::mt19937 engine{7};
};

}  // namespace raygraph::testing

// Squares in the cells of a grid, of colors that tell which is which, seen from above: for tests of parts of a
// scene that come and go.
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
