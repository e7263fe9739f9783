// What Trace does on purpose to the light of a sample: named biases, and samples that are no light at all.
#include <cmath>
#include <cstring>

#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

using passes::TraceSettings;

namespace {

class TraceBias : public VulkanTest {
  protected:
    struct Counted {
        FloatImage radiance;
        std::array<FloatImage, passes::kPathPartCount> parts;
        passes::TraceCounts counts;
    };
    Counted TraceCounted(const TraceSettings& settings) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::TraceIds traced = passes::Trace(render.renderer, ids, settings, {.parts = true});
        const Readback radiance = render.renderer.ReadBack(traced.radiance);
        const Readback counts = render.renderer.ReadBack(traced.counts);
        std::array<Readback, passes::kPathPartCount> parts;
        for (size_t i = 0; i < parts.size(); i++) parts[i] = render.renderer.ReadBack(traced.parts[i]);
        render.renderer.Execute();
        Counted result{.radiance = ToFloatImage(radiance), .parts = {}, .counts = {}};
        for (size_t i = 0; i < parts.size(); i++) result.parts[i] = ToFloatImage(parts[i]);
        counts.Wait();
        std::memcpy(&result.counts, counts.Bytes().data(), sizeof result.counts);
        return result;
    }

    SceneRender render{Device()};
};

}  // namespace

// A surface that returns four times what it gets, under a sky near the end of the range of float: its samples
// are infinite, and those that see the sky are not.
TEST_F(TraceBias, Trace_InfiniteSampleIsBlackAndCounted) {
    render.scene.SetScene(SceneOf({QuadMesh(0.5f)}, {Lambert(glm::vec3(4.0f))}));
    render.scene.SetEnvironment({.radiance = glm::vec3(2e38f)});
    TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 0.4f, 16);
    settings.lights.isOn = false;
    const Counted traced = TraceCounted(settings);
    uint32_t black = 0;
    for (size_t i = 0; i < traced.radiance.values.size(); i++) {
        const glm::vec4& texel = traced.radiance.values[i];
        const bool isOnSurface = texel.w == 1.0f;
        black += isOnSurface ? 1 : 0;
        ASSERT_EQ(glm::vec3(texel), glm::vec3(isOnSurface ? 0.0f : 2e38f)) << i;
        for (const FloatImage& part : traced.parts)
            ASSERT_TRUE(std::isfinite(part.values[i].x + part.values[i].y + part.values[i].z)) << i;
    }
    EXPECT_GT(black, 20u);
    EXPECT_LT(black, 16u * 16u);
    EXPECT_EQ(traced.counts.nonFiniteSamples, black);
    // It counts as a sample: the mean is of all of them
    EXPECT_EQ(render.Render(settings, 3).sampleCount, 3u);
}

TEST_F(TraceBias, Trace_CountsNoSampleWhereAllAreFinite) {
    render.scene.SetScene(SceneOf({QuadMesh(0.5f)}, {Lambert(glm::vec3(0.5f))}));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    EXPECT_EQ(TraceCounted(LookAt({0, 0, 4}, {0, 0, 0}, 0.4f, 16)).counts.nonFiniteSamples, 0u);
}

}  // namespace raygraph::testing
