// The fixture of tests of deforming meshes: what is on the device, and what the views see.
#pragma once

#include <type_traits>

#include "passes/raster.h"
#include "tests/passes/deforming_scene.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

// All of the sheet, in every pose.
inline passes::TraceSettings Front(uint32_t size = 48) {
    return LookAt({0.5f, 2.5f, 9.0f}, {0, 2, 0}, 0.7f, size);
}

class DeformTest : public VulkanTest {
  protected:
    // The streams on the device, of each copy and of each of its groups that deforms: the positions of all
    // parts, then normals and tangents of one part after the other.
    using Group = std::vector<scene::DeformedStreams>;
    std::vector<Group> OnDevice(const std::vector<Group>& like) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback streams = render.renderer.ReadBack(ids.deformedStreams);
        render.renderer.Execute();
        streams.Wait();
        size_t offset = 0;
        const auto take = [&](auto& into) {
            using Value = typename std::remove_reference_t<decltype(into)>::value_type;
            into = As<Value>(streams.Bytes().subspan(offset, into.size() * sizeof(Value)));
            offset += into.size() * sizeof(Value);
        };
        const auto align = [&] { offset = (offset + 15) / 16 * 16; };
        std::vector<Group> result = like;
        for (Group& group : result) {
            for (scene::DeformedStreams& part : group) take(part.positions);
            align();
            for (scene::DeformedStreams& part : group) {
                take(part.normals);
                align();
                take(part.tangents);
                align();
            }
        }
        return result;
    }
    scene::DeformedStreams OnDevice(const scene::DeformedStreams& like) {
        return OnDevice(std::vector<Group>{{like}})[0][0];
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
            const scene::DeformedStreams expected = posed.Streams(), actual = OnDevice(posed.Streams());
            EXPECT_NE(expected.positions, before.positions);
            ExpectNear(actual, expected);
            for (size_t i = 0; i < actual.tangents.size() && (options.targets > 0 || options.isFlat); ++i)
                ASSERT_NEAR(glm::dot(glm::vec3(actual.tangents[i]), actual.normals[i]), 0.0f, 1e-5f) << i;
            before = expected;
        }
    }
    // Same surfaces at the same places.
    static void ExpectSameHits(const SceneRender::Hits& actual, const SceneRender::Hits& expected,
                               size_t edgePixels, float size = 4.0f) {
        size_t others = 0, surfaces = 0;
        for (size_t i = 0; i < expected.ids.size(); ++i) {
            if (glm::uvec3(actual.ids[i]) != glm::uvec3(expected.ids[i])) {  // but for the geometry's index
                ++others;
                continue;
            }
            if (expected.ids[i].x == 0xFFFFFFFFu) continue;
            ++surfaces;
            ASSERT_LE(glm::length(glm::vec3(actual.position.values[i] - expected.position.values[i])),
                      5e-5f * size)
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
        return render.ReadHits(passes::RasterHits(render.renderer, ids, settings, seen));
    }

    SceneRender render{Device()};
};

}  // namespace raygraph::testing
