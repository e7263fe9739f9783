// Deliberate changes of a sample in Trace: named biases, and samples that are not finite.
#include <cmath>
#include <cstring>

#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_bias_test {

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
        for (size_t i = 0; i < parts.size(); ++i) parts[i] = render.renderer.ReadBack(traced.parts[i]);
        render.renderer.Execute();
        Counted result{.radiance = ToFloatImage(radiance), .parts = {}, .counts = {}};
        for (size_t i = 0; i < parts.size(); ++i) result.parts[i] = ToFloatImage(parts[i]);
        counts.Wait();
        std::memcpy(&result.counts, counts.Bytes().data(), sizeof result.counts);
        return result;
    }

    SceneRender render{Device()};
};

}  // namespace

// A white surface that shines as bright as the sky around it, near the end of the range of float: its samples
// are infinite, and those that see the sky are not.
TEST_F(TraceBias, Trace_InfiniteSampleIsBlackAndCounted) {
    render.scene.SetScene(SceneOf({QuadMesh(0.5f)}, {Lambert(glm::vec3(1.0f), glm::vec3(2e38f))}));
    render.scene.SetEnvironment({.radiance = glm::vec3(2e38f)});
    TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 0.4f, 16);
    settings.lights.isOn = false;
    const Counted traced = TraceCounted(settings);
    uint32_t black = 0;
    for (size_t i = 0; i < traced.radiance.values.size(); ++i) {
        const glm::vec4& texel = traced.radiance.values[i];
        const bool isOnSurface = texel.w == 1.0f;
        black += isOnSurface ? 1 : 0;
        ASSERT_EQ(glm::vec3(texel), glm::vec3(isOnSurface ? 0.0f : 2e38f)) << i;
        for (const FloatImage& part : traced.parts)
            for (int c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(part.values[i][c])) << i;
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

// Every path of a closed box brings E, a E, a^2 E, ...; all but the first two are cut, in their own color.
TEST_F(TraceBias, Trace_ClampIndirectCutsWhatWasScatteredTwiceOrMore) {
    const glm::vec3 emitted(1.0f, 0.5f, 0.25f);
    render.scene.SetScene(SceneOf({BoxMesh(1.0f)}, {Lambert(glm::vec3(0.5f), emitted)}));
    TraceSettings settings = LookAt({0.2f, 0.1f, 0.3f}, {1.0f, 0.0f, 0.0f}, 1.0f, 8);
    settings.lights.isOn = false;
    settings.roulette.kind = Roulette::Off;
    settings.biases.maxDepth = 3;
    const auto part = [](const Counted& traced, passes::PathPart which) {
        return traced.parts[static_cast<size_t>(which)].values;
    };
    const Counted free = TraceCounted(settings);
    // 0.25 is cut and 0.125 is not, though 0.5 and 1, scattered once and never, are larger than both
    settings.biases.clampIndirect = 0.2f;
    const Counted clamped = TraceCounted(settings);
    EXPECT_EQ(part(clamped, passes::PathPart::Emission), part(free, passes::PathPart::Emission));
    EXPECT_EQ(part(clamped, passes::PathPart::Direct), part(free, passes::PathPart::Direct));
    for (size_t i = 0; i < clamped.radiance.values.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            ASSERT_NEAR(part(free, passes::PathPart::Indirect)[i][c], 0.375f * emitted[c], 1e-4f);
            ASSERT_NEAR(part(clamped, passes::PathPart::Indirect)[i][c], 0.325f * emitted[c], 1e-4f);
            ASSERT_NEAR(clamped.radiance.values[i][c], 1.825f * emitted[c], 1e-4f);
        }
    settings.biases.clampIndirect = 0.3f;  // above all
    EXPECT_EQ(TraceCounted(settings).radiance.values, free.radiance.values);
}

// The camera sees a mirror, and in it a metal behind the camera, and in that a lamp: what is regularized is
// the metal, exactly as if it had that roughness, and the mirror is not.
TEST_F(TraceBias, Trace_RegularizeRoughensWhatIsSeenAfterTheFirstBounce) {
    const auto picture = [&](float mirror, float metal, float regularize) {
        std::vector<scene::Material> materials(2);
        materials[0].roughnessFactor = mirror;
        materials[1].roughnessFactor = metal;
        for (scene::Material& material : materials) material.isDoubleSided = true;
        materials.push_back(Lambert(glm::vec3(0.0f), glm::vec3(1.0f, 2.0f, 4.0f)));
        render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), QuadMesh(3.0f, 1), QuadMesh(0.4f, 2)},
                                      std::move(materials),
                                      {glm::mat4x3(1.0f), Translation({0, 0, 3}), Translation({2, 0, 0})}));
        TraceSettings settings = LookAt({0.1f, 0.2f, 2}, {0, 0, 0}, 0.6f, 16);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.biases.maxDepth = 2;
        settings.biases.regularize = regularize;
        return render.Render(settings, 4).mean.values;
    };
    const auto sharp = picture(0.0f, 0.2f, 0.0f);
    const auto regularized = picture(0.0f, 0.2f, 0.25f);
    EXPECT_NE(regularized, sharp);
    EXPECT_EQ(regularized, picture(0.0f, 0.5f, 0.0f)) << "an alpha of 0.25";
    EXPECT_EQ(picture(0.0f, 0.8f, 0.25f), picture(0.0f, 0.8f, 0.0f)) << "rougher than that already";
    EXPECT_NE(picture(0.5f, 0.2f, 0.25f), regularized) << "the mirror that the camera sees stays one";
}

// Light from the right of the picture grazes the middle of a sphere, where a triangle has just turned away
// from it that its normals still half face.
TEST_F(TraceBias, Trace_ShadowTerminatorBrightensWhereLightGrazesASphereOfFewTriangles) {
    const float turn = 8.0f * 3.14159265f / 180.0f;
    const auto picture = [&](uint32_t rings, bool isOn) {
        scene::SceneData scene = SceneOf({SphereMesh(1.0f, rings)}, {Lambert(glm::vec3(0.8f))});
        scene::Light light;
        light.type = scene::LightType::Directional;  // along -z of its own
        light.lightToWorld[0] = {std::cos(turn), 0.0f, -std::sin(turn)};
        light.lightToWorld[2] = {std::sin(turn), 0.0f, std::cos(turn)};
        scene.lights.push_back(light);
        render.scene.SetScene(std::move(scene));
        TraceSettings settings = LookAt({8, 0, 0}, {0, 0, 0}, 0.2f, 32);
        settings.biases.shadowTerminator = isOn;
        return render.Render(settings, 4).mean;
    };
    const FloatImage truth = picture(96, false), off = picture(8, false), on = picture(8, true);
    const float brightest = 0.8f / 3.14159265f;
    glm::dvec3 grazed(0.0), lit(0.0);  // sums of the three
    for (size_t i = 0; i < truth.values.size(); ++i)
        (truth.values[i].y > 0.25f * brightest ? lit : grazed) +=
            glm::dvec3(truth.values[i].y, off.values[i].y, on.values[i].y);
    EXPECT_GT(grazed.z, 1.1 * grazed.y);
    EXPECT_LT(std::abs(grazed.z - grazed.x), 0.5 * std::abs(grazed.y - grazed.x));
    EXPECT_NEAR(lit.z, lit.y, 0.02 * lit.y);
    const double before = off.Mean().y, after = on.Mean().y;
    EXPECT_GT(after, 1.002 * before) << "the bias that docs/sampling.md names";
    EXPECT_LT(after, 1.05 * before);
}

}  // namespace raygraph::testing::trace_bias_test
