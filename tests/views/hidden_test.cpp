// Tests that a hidden object is in no view, and casts no shadow: pictures have the bits of a scene that never
// showed it, after an update of the TLAS.
#include <cstring>

#include "passes/raster.h"
#include "passes/shadow_maps.h"
#include "renderer/graph/readback_values.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::hidden_test {

using passes::FilmPosition;
using passes::Rasterizer;
using passes::RasterShadows;

namespace {

constexpr uint32_t kSize = 48;
constexpr uint32_t kFloor = 0;

struct Seen {
    std::vector<std::vector<glm::vec4>> pictures;
    std::vector<std::vector<glm::uvec4>> ids;
    std::vector<gpu::InstanceRecord> records;
};

class Hidden : public VulkanTest {
  protected:
    // Makes a floor under the sun, and on it a box, a ball, a lamp and a leaf with holes.
    static scene::SceneData Table(uint32_t hidden = scene::kNone) {
        scene::Material leaf = Lambert(glm::vec3(0.7f));
        leaf.alphaMode = scene::AlphaMode::Mask;
        scene::Mesh holed = QuadMesh(0.5f, 2);
        holed.primitives[0].colors.assign(4, glm::vec4(1.0f));
        holed.primitives[0].colors[2].a = 0.0f;
        scene::SceneData scene =
            SceneOf({QuadMesh(3.0f), BoxMesh(0.4f), RoundSphere(0.4f), holed, QuadMesh(0.2f, 1)},
                    {Lambert(glm::vec3(0.5f)), Lambert(glm::vec3(0.2f), glm::vec3(6.0f)), leaf},
                    {Translation({0, 0, 0}), Translation({-1, -1, 0.6f}), Translation({1, -1, 0.6f}),
                     Translation({-1, 1, 0.7f}), Translation({1, 1, 0.8f})});
        scene::Light sun;
        sun.type = scene::LightType::Directional;
        sun.lightToWorld = glm::mat4x3(glm::vec3(1, 0, 0), glm::vec3(0, 0.8f, 0.6f),
                                       glm::vec3(0, -0.6f, 0.8f), glm::vec3(0));
        scene.lights = {sun};
        if (hidden == scene::kNone) return scene;
        scene.nodes.resize(1);
        scene.nodes[0].isVisible = false;
        scene.nodeOrder = {0};
        scene.instances[hidden].node = 0;
        return scene;
    }

    static Seen Look(SceneRender& render) {
        passes::TraceSettings settings = LookAt({0.3f, -0.4f, 7.0f}, {0, 0, 0}, 0.8f, kSize);
        settings.biases.maxDepth = 2;
        Seen seen;
        const auto add = [&](const SceneRender::Hits& hits) {
            seen.ids.push_back(hits.ids);
            seen.pictures.push_back(hits.normal.values);
        };
        add(render.PrimaryHits(settings));
        seen.pictures.push_back(render.TraceOnce(settings).values);
        for (const Rasterizer rasterizer : {Rasterizer::Compute, Rasterizer::Device}) {
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            add(render.ReadHits(passes::RasterHits(
                render.renderer, ids, settings,
                passes::DrawVisibility(render.renderer, ids, settings, FilmPosition::Center, rasterizer))));
        }
        for (const RasterShadows shadows : {RasterShadows::Rays, RasterShadows::Maps}) {
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            passes::FilteredEnvironment environment("environment");
            const Readback shaded = render.renderer.ReadBack(passes::RasterShade(
                render.renderer, ids, settings,
                passes::DrawVisibility(render.renderer, ids, settings, FilmPosition::Center), environment,
                {.shadows = shadows, .hasOcclusion = false, .hasTransmission = false}));
            const Readback records = render.renderer.ReadBack(ids.instances);
            render.renderer.Execute();
            seen.pictures.push_back(ToFloatImage(shaded).values);
            seen.records = WaitForValues<gpu::InstanceRecord>(records);
        }
        return seen;
    }

    static void ExpectSame(const Seen& actual, const Seen& expected) {
        EXPECT_EQ(actual.ids, expected.ids);
        for (size_t i = 0; i < expected.pictures.size(); ++i)
            EXPECT_EQ(std::memcmp(actual.pictures[i].data(), expected.pictures[i].data(),
                                  expected.pictures[i].size() * sizeof(glm::vec4)),
                      0)
                << "picture " << i;
        for (size_t i = 0; i < expected.records.size(); ++i) {
            EXPECT_EQ(actual.records.at(i).draw, expected.records[i].draw) << i;
            EXPECT_EQ(actual.records[i].objectToWorld, expected.records[i].objectToWorld) << i;
        }
    }

    static void Settle(SceneRender& render) {
        for (int frame = 0; frame < 8 && !render.scene.IsSettled(); ++frame)
            render.PrimaryHits(LookAt({0, 0, 7}, {0, 0, 0}, 0.8f, 1));
        ASSERT_TRUE(render.scene.IsSettled());
    }

    SceneRender edited{Device()}, expected{Device()};
};

}  // namespace

TEST_F(Hidden, IsInNoViewAndCastsNoShadow) {
    edited.scene.SetScene(Table());
    Settle(edited);
    const Seen all = Look(edited);
    const uint64_t rebuilds = edited.scene.Statistics().tlasRebuilds;
    for (uint32_t instance = 0; instance < 5; ++instance) {
        SCOPED_TRACE(instance);
        edited.scene.SetVisible(instance, false);
        const Seen hidden = Look(edited);
        expected.scene.SetScene(Table(instance));
        Settle(expected);
        ExpectSame(hidden, Look(expected));
        for (const std::vector<glm::uvec4>& ids : hidden.ids)
            for (const glm::uvec4& id : ids) ASSERT_NE(id.x, instance);
        for (size_t i = 0; i < all.ids.size(); ++i) EXPECT_NE(hidden.ids[i], all.ids[i]) << "it was seen";
        // Objects that were hidden when the scene was set can be shown
        expected.scene.SetVisible(instance, true);
        const uint64_t before = expected.scene.Statistics().tlasRebuilds;
        ExpectSame(Look(expected), all);
        EXPECT_EQ(expected.scene.Statistics().tlasRebuilds, before);
        edited.scene.SetVisible(instance, true);
        ExpectSame(Look(edited), all);
    }
    EXPECT_EQ(edited.scene.Statistics().tlasRebuilds, rebuilds) << "updates only";
}

// The camera sees the floor alone, so that only shadows and light differ.
TEST_F(Hidden, ShadowsOfWhatIsHiddenAreGone) {
    edited.scene.SetScene(Table());
    const passes::TraceSettings settings = LookAt({0.3f, -0.4f, 7.0f}, {0, 0, 0}, 0.8f, kSize);
    const auto lit = [&] {
        const SceneRender::Hits hits = edited.PrimaryHits(settings);
        const FloatImage image = edited.Render(settings, 4).mean;
        double sum = 0.0;
        for (size_t i = 0; i < hits.ids.size(); ++i)
            if (hits.ids[i].x == kFloor) sum += image.values[i].y > 0.1f ? 1.0 : 0.0;
        return sum;
    };
    edited.scene.SetEnvironment({.radiance = glm::vec3(0.0f)});
    edited.scene.SetVisible(4, false);  // the lamp
    double before = lit();
    for (const uint32_t instance : {1u, 2u, 3u}) {
        edited.scene.SetVisible(instance, false);
        const double now = lit();
        EXPECT_GT(now, before + 10.0) << instance;
        before = now;
    }
}

}  // namespace raygraph::testing::hidden_test
