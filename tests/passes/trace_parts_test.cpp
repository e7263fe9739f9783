// The parts into which Trace separates the radiance.
#include <cmath>
#include <span>
#include <tuple>

#include "base/error.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_parts_test {

using passes::kPathPartCount;
using passes::PathPart;
using passes::PathPartIds;
using passes::TraceSettings;

namespace {

struct SplitImage {
    FloatImage radiance;
    std::array<FloatImage, kPathPartCount> parts, variances;
    uint32_t sampleCount = 0;

    const FloatImage& operator[](PathPart part) const { return parts[static_cast<size_t>(part)]; }
    glm::dvec3 Mean(PathPart part) const { return (*this)[part].Mean(); }
    glm::dvec3 StandardErrorOfMean(PathPart part) const {
        const size_t i = static_cast<size_t>(part);
        return RenderedImage{parts[i], variances[i], sampleCount}.StandardErrorOfMean();
    }
};

class TraceParts : public VulkanTest {
  protected:
    // One sample, or the mean of several.
    SplitImage Split(TraceSettings settings, uint32_t sampleCount = 1) {
        passes::Accumulation sum("whole");
        std::vector<passes::Accumulation> sums;
        for (size_t i = 0; i < kPathPartCount; ++i) sums.emplace_back("part" + std::to_string(i));
        SplitImage image;
        for (uint32_t sample = 1; sample <= sampleCount; ++sample, ++settings.sampleIndex) {
            Renderer& renderer = render.renderer;
            renderer.BeginFrame();
            const SceneIds scene = render.scene.Declare(renderer);
            const passes::TraceIds traced = passes::Trace(renderer, scene, settings, {.parts = true});
            const bool isLast = sample == sampleCount;
            Readback whole;
            std::vector<Readback> means, variances;
            const auto take = [&](TextureId texture) {
                if (isLast) return renderer.ReadBack(texture);
                renderer.Present(texture);
                return Readback();
            };
            whole = take(passes::Accumulate(renderer, traced.radiance, sum).mean);
            for (size_t i = 0; i < kPathPartCount; ++i) {
                std::ignore = passes::Accumulate(renderer, traced.parts[i], sums[i], true);
                const passes::AccumulatedIds kept = passes::Resolve(renderer, sums[i], settings.extent, true);
                means.push_back(take(kept.mean));
                variances.push_back(take(kept.variance));
            }
            renderer.Execute();
            if (!isLast) continue;
            image.radiance = ToFloatImage(whole);
            image.sampleCount = sampleCount;
            for (size_t i = 0; i < kPathPartCount; ++i) {
                image.parts[i] = ToFloatImage(means[i]);
                image.variances[i] = ToFloatImage(variances[i]);
            }
        }
        return image;
    }

    // A floor, as glossy as varnish, under a lamp, with a thin pane of tinted glass that stands on it; and by
    // themselves, 20 m off on either side: a mirror, a rough metal, and a clear pane before a wall that
    // shines.
    TraceSettings SetScene() {
        scene::Material floor = Lambert({0.7f, 0.4f, 0.2f});
        floor.metallicFactor = 0.0f;
        floor.roughnessFactor = 0.3f;
        scene::Material lamp = Lambert(glm::vec3(0.0f), {9.0f, 8.0f, 6.0f});
        lamp.metallicFactor = 0.0f;
        lamp.specularFactor = 0.0f;
        scene::Material pane = floor;
        pane.transmissionFactor = 0.8f;
        pane.roughnessFactor = 0.2f;
        pane.baseColorFactor = {0.6f, 0.9f, 0.7f, 1.0f};
        scene::Material mirror = Lambert(glm::vec3(0.9f)), metal = mirror;
        mirror.roughnessFactor = 0.0f;
        metal.roughnessFactor = 0.5f;
        scene::Material clear = floor;
        clear.transmissionFactor = 1.0f;
        clear.roughnessFactor = 0.0f;
        clear.baseColorFactor = glm::vec4(1.0f);
        const glm::mat4x3 flat({1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, 0, 0});
        const glm::mat4x3 above({1, 0, 0}, {0, 0, 1}, {0, -1, 0}, {0, 2, -1});
        render.scene.SetScene(
            SceneOf({QuadMesh(3.0f, 0), QuadMesh(0.5f, 1), QuadMesh(0.6f, 2), QuadMesh(1.0f, 3),
                     QuadMesh(1.0f, 4), QuadMesh(1.0f, 5), QuadMesh(1.0f, 1)},
                    {floor, lamp, pane, mirror, metal, clear},
                    {flat, above, Translation({0.5f, 0.6f, 0.6f}), Translation({-20, 0, 0}),
                     Translation({-20, 20, 0}), Translation({20, 0, 0}), Translation({20, 0, -1})}));
        render.scene.SetEnvironment({.radiance = {0.05f, 0.1f, 0.2f}});
        return View({0, 1.2f, 4}, {0, 1.0f, 0}, 0.9f, 64);
    }
    static TraceSettings View(const glm::vec3& eye, const glm::vec3& target, float yFov, uint32_t size) {
        TraceSettings settings = LookAt(eye, target, yFov, size);
        settings.scattering.brdf = BrdfModel::Gltf;
        return settings;
    }

    SceneRender render{Device()};
};

const std::vector<PathPart> kScatteredParts = {PathPart::Direct, PathPart::Indirect, PathPart::Diffuse,
                                               PathPart::Specular, PathPart::Transmission};

void ExpectNothingIn(const SplitImage& image, const std::vector<PathPart>& parts) {
    for (const PathPart part : parts) EXPECT_EQ(image.Mean(part), glm::dvec3(0.0)) << Name(part);
}

// That this part is all of the radiance.
void ExpectAllIn(const SplitImage& image, PathPart part) {
    ASSERT_GT(image.radiance.Mean().y, 0.0);
    for (size_t i = 0; i < image.radiance.values.size(); ++i)
        ASSERT_EQ(glm::vec3(image[part].values[i]), glm::vec3(image.radiance.values[i])) << Name(part);
}

void ExpectSumsAreTheRadiance(const SplitImage& image) {
    for (size_t i = 0; i < image.radiance.values.size(); ++i)
        for (int channel = 0; channel < 3; ++channel) {
            const auto at = [&](PathPart part) { return double{image[part].values[i][channel]}; };
            const double radiance = image.radiance.values[i][channel];
            const double tolerance = 1e-5 * radiance;
            ASSERT_NEAR(at(PathPart::Emission) + at(PathPart::Direct) + at(PathPart::Indirect), radiance,
                        tolerance)
                << "pixel " << i;
            ASSERT_NEAR(at(PathPart::Emission) + at(PathPart::Diffuse) + at(PathPart::Specular) +
                            at(PathPart::Transmission),
                        radiance, tolerance)
                << "pixel " << i;
        }
}

}  // namespace

TEST_F(TraceParts, Trace_PartsSumToTheRadianceOfEveryPixel) {
    const TraceSettings settings = SetScene();
    for (const uint32_t sampleCount : {1u, 16u}) {
        const SplitImage image = Split(settings, sampleCount);
        ExpectSumsAreTheRadiance(image);
        EXPECT_GT(image.Mean(PathPart::Emission).y, 0.0);
        for (const PathPart part : kScatteredParts)
            EXPECT_GT(image.Mean(part).y, 0.005 * image.radiance.Mean().y) << Name(part) << " is not tried";
    }
}

TEST_F(TraceParts, Trace_TellingPartsApartLeavesTheRadiance) {
    const TraceSettings settings = SetScene();
    const SplitImage image = Split(settings);
    const FloatImage alone = render.TraceOnce(settings);
    ASSERT_EQ(alone.values.size(), image.radiance.values.size());
    // Other drivers may compile the longer shader with other roundings; few of them decide where a path goes.
    const bool isExact = Device().Info().isLavapipe;
    size_t same = 0;
    for (size_t i = 0; i < alone.values.size(); ++i) {
        const glm::vec4 difference = glm::abs(alone.values[i] - image.radiance.values[i]);
        const glm::vec4 limit = isExact ? glm::vec4(0.0f) : 1e-5f * glm::abs(alone.values[i]) + 1e-7f;
        same += glm::all(glm::lessThanEqual(difference, limit));
    }
    const size_t wanted = isExact ? alone.values.size() : alone.values.size() * 99 / 100;
    EXPECT_GE(same, wanted) << "of " << alone.values.size();
}

TEST_F(TraceParts, Trace_PartsDoNotDependOnHowLightIsFound) {
    // Lamps sampled or met by chance: each part converges to the same
    TraceSettings settings = SetScene();
    const SplitImage sampled = Split(settings, 32);
    settings.seed = 1;
    settings.lights.isOn = false;
    const SplitImage met = Split(settings, 256);
    for (const PathPart part : kScatteredParts) {
        const glm::dvec3 a = sampled.Mean(part), b = met.Mean(part);
        const double error = std::hypot(sampled.StandardErrorOfMean(part).y, met.StandardErrorOfMean(part).y);
        EXPECT_NEAR(a.y, b.y, 4.0 * error) << Name(part);
        EXPECT_LT(4.0 * error, 0.2 * b.y) << Name(part) << " is too noisy to prove anything";
    }
}

TEST_F(TraceParts, Trace_LampSeenDirectlyIsAllEmission) {
    SetScene();
    const SplitImage image = Split(View({0, 1, -1}, {0.01f, 2, -1}, 0.5f, 8));
    ExpectAllIn(image, PathPart::Emission);
    EXPECT_EQ(image.radiance.Mean(), glm::dvec3(9, 8, 6));
    ExpectNothingIn(image, kScatteredParts);
}

TEST_F(TraceParts, Trace_MetalIsAllSpecularSmoothOrRough) {
    SetScene();
    for (const float y : {0.0f, 20.0f}) {
        const SplitImage image = Split(View({-20, y, 2}, {-20, y, 0}, 0.5f, 16));
        ExpectAllIn(image, PathPart::Specular);
        ExpectNothingIn(image, {PathPart::Emission, PathPart::Diffuse, PathPart::Transmission});
    }
}

TEST_F(TraceParts, Trace_LampBehindAClearPaneIsEmissionThatIsNotScattered) {
    SetScene();
    const SplitImage image = Split(View({20, 0, 2}, {20, 0, 0}, 0.1f, 16), 64);
    // Fresnel at normal incidence: 0.04 of the environment before it, 0.96 of the lamp behind
    EXPECT_NEAR(image.Mean(PathPart::Emission).y, 0.96 * 8.0, 0.01 * 8.0);
    EXPECT_NEAR(image.Mean(PathPart::Specular).y, 0.04 * 0.1, 0.05 * 0.04);
    EXPECT_NEAR(image.Mean(PathPart::Direct).y, image.Mean(PathPart::Specular).y, 1e-5);
    ExpectNothingIn(image, {PathPart::Transmission, PathPart::Indirect, PathPart::Diffuse});
}

TEST_F(TraceParts, Trace_LambertWallUnderAPointLightIsAllDirectAndDiffuse) {
    scene::SceneData scene = SceneOf({QuadMesh(1.0f)}, {Lambert({0.8f, 0.5f, 0.2f})});
    scene::Light light;
    light.intensity = 5.0f;
    light.lightToWorld = Translation({0, 0, 1});
    scene.lights = {light};
    render.scene.SetScene(std::move(scene));
    const SplitImage image = Split(LookAt({0, 0, 2}, {0, 0, 0}, 0.5f, 16));
    ExpectAllIn(image, PathPart::Direct);
    ExpectAllIn(image, PathPart::Diffuse);
    ExpectNothingIn(image,
                    {PathPart::Emission, PathPart::Indirect, PathPart::Specular, PathPart::Transmission});
}

TEST_F(TraceParts, Trace_RefusesRayCountsBesideParts) {
    render.renderer.BeginFrame();
    const SceneIds ids = render.scene.Declare(render.renderer);
    EXPECT_THROW(std::ignore = passes::Trace(render.renderer, ids, LookAt({0, 0, 1}, {0, 0, 0}, 1.0f, 4),
                                             {.rayCounts = true, .parts = true}),
                 Error);
    render.renderer.Execute();
}

}  // namespace raygraph::testing::trace_parts_test
