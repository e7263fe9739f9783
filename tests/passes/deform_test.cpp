// GpuScene: meshes that deform are where the CPU's formula has them, for every view.
#include "passes/raster.h"
#include "tests/passes/deforming_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {
namespace {

// All of the sheet, in every pose.
passes::TraceSettings Front(uint32_t size = 48) {
    return LookAt({0.5f, 2.5f, 9.0f}, {0, 2, 0}, 0.7f, size);
}

class DeformTest : public VulkanTest {
  protected:
    // The streams on the device, as in deform_resources.h of one group with one primitive.
    scene::DeformedStreams OnDevice(const scene::DeformedStreams& like) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback streams = render.renderer.ReadBack(ids.deformedStreams);
        render.renderer.Execute();
        streams.Wait();
        scene::DeformedStreams result;
        size_t offset = 0;
        const auto take = [&](auto& into, size_t count) {
            using Value = typename std::remove_reference_t<decltype(into)>::value_type;
            into = As<Value>(streams.Bytes().subspan(offset, count * sizeof(Value)));
            offset += (count * sizeof(Value) + 15) / 16 * 16;
        };
        take(result.positions, like.positions.size());
        take(result.normals, like.normals.size());
        take(result.tangents, like.tangents.size());
        return result;
    }
    static void ExpectNear(const scene::DeformedStreams& actual, const scene::DeformedStreams& expected) {
        constexpr float kSize = 4.0f;
        for (size_t i = 0; i < expected.positions.size(); ++i)
            ASSERT_LE(glm::length(actual.positions[i] - expected.positions[i]), 1e-5f * kSize) << i;
        for (size_t i = 0; i < expected.normals.size(); ++i)
            ASSERT_LE(glm::length(actual.normals[i] - expected.normals[i]), 2e-5f) << i;
        for (size_t i = 0; i < expected.tangents.size(); ++i)
            ASSERT_LE(glm::length(actual.tangents[i] - expected.tangents[i]), 2e-5f) << i;
    }
    void ExpectFormula(const SheetOptions& options) {
        PosedScene posed(SheetScene(options));
        scene::SceneData data = posed.scene;
        render.scene.SetScene(std::move(data));
        scene::DeformedStreams before = posed.Streams();
        ExpectNear(OnDevice(before), before);
        for (const double seconds : {0.2, 0.5, 0.9}) {
            SCOPED_TRACE(seconds);
            const scene::PoseChanges& changes = posed.MoveTo(seconds);
            render.scene.SetPose(posed.scene, posed.applier, changes);
            const scene::DeformedStreams expected = posed.Streams();
            EXPECT_NE(expected.positions, before.positions);
            ExpectNear(OnDevice(expected), expected);
            before = expected;
        }
    }
    // Same surfaces at the same places.
    static void ExpectSameHits(const SceneRender::Hits& actual, const SceneRender::Hits& expected,
                               size_t edgePixels) {
        size_t others = 0, surfaces = 0;
        for (size_t i = 0; i < expected.ids.size(); ++i) {
            if (actual.ids[i] != expected.ids[i]) {
                ++others;
                continue;
            }
            if (expected.ids[i].x == 0xFFFFFFFFu) continue;
            ++surfaces;
            ASSERT_LE(glm::length(glm::vec3(actual.position.values[i] - expected.position.values[i])), 2e-4f)
                << i;
            ASSERT_LE(glm::length(glm::vec3(actual.normal.values[i] - expected.normal.values[i])), 1e-3f)
                << i;
        }
        EXPECT_LE(others, edgePixels);
        EXPECT_GT(surfaces, 50u);
    }
    SceneRender::Hits Drawn(const passes::TraceSettings& settings) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, settings, passes::FilmPosition::Center);
        return render.TakeHits(passes::RasterHits(render.renderer, ids, settings, seen));
    }

    SceneRender render{Device()};
};

}  // namespace

TEST_F(DeformTest, SkinnedVerticesAreThoseOfTheFormula) {
    ExpectFormula({.influences = 2});
}

TEST_F(DeformTest, VerticesOfSeveralInfluenceSetsAreThoseOfTheFormula) {
    ExpectFormula({.influences = 7});
}

TEST_F(DeformTest, MorphedVerticesAreThoseOfTheFormula) {
    ExpectFormula({.influences = 0, .targets = 3});
}

TEST_F(DeformTest, MorphedThenSkinnedVerticesAreThoseOfTheFormula) {
    ExpectFormula({.influences = 4, .targets = 2});
}

TEST_F(DeformTest, FlatNormalsAreThoseOfTheDeformedTriangles) {
    ExpectFormula({.influences = 3, .targets = 1, .isFlat = true});
}

TEST_F(DeformTest, RaysAndRasterSeeTheDeformedSurface) {
    PosedScene posed(SheetScene({.influences = 3, .targets = 1}));
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    SceneRender still(Device());
    for (const double seconds : {0.0, 0.4, 0.8}) {
        SCOPED_TRACE(seconds);
        const scene::PoseChanges& changes = posed.MoveTo(seconds);
        render.scene.SetPose(posed.scene, posed.applier, changes);
        const SceneRender::Hits traced = render.PrimaryHits(Front());
        still.scene.SetScene(posed.Frozen());
        ExpectSameHits(traced, still.PrimaryHits(Front()), 2);
        ExpectSameHits(Drawn(Front()), traced, 20);
    }
    EXPECT_EQ(render.scene.Statistics().blasBuilds, 1u);
    EXPECT_EQ(render.scene.Statistics().blasRefits + render.scene.Statistics().blasRebuilds, 2u);
}

}  // namespace raygraph::testing
