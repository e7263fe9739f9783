// Boxes on a square grid, of which some move, are hidden, come or go: what rays should see of them.
#pragma once

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "renderer/graph/readback_values.h"
#include "tests/passes/cells.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

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
