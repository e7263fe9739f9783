// Tests that the raster view is lit as the path tracer lights: by the same materials, BSDFs and punctual
// lights.
#include <cmath>
#include <span>

#include "passes/raster.h"
#include "passes/shadow_maps.h"
#include "shaders/shared/shadow_records.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::raster_shade_test {

using passes::FilmPosition;
using passes::TraceSettings;

namespace {

constexpr uint32_t kSamples = 64;

constexpr passes::RasterSettings kUnshadowed{
    .shadows = passes::RasterShadows::Off, .hasOcclusion = false, .hasTransmission = false};

// Centers of the surfaces that Row makes.
constexpr glm::vec3 kRowCenters[] = {{-1.95f, 0, 0}, {-0.65f, 0, 0}, {0.65f, 0, 0}, {1.95f, 0, 0}};

class RasterShade : public VulkanTest {
  protected:
    // Returns the mean of kSamples drawn pictures.
    FloatImage Draw(TraceSettings settings, uint32_t samples = kSamples,
                    FilmPosition film = FilmPosition::Jittered) {
        passes::Accumulation accumulation("drawn");
        for (uint32_t i = 0;; ++i) {
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            const passes::RasterVisibility seen =
                passes::DrawVisibility(render.renderer, ids, settings, film);
            const TextureId mean = passes::Accumulate(render.renderer,
                                                      passes::RasterShade(render.renderer, ids, settings,
                                                                          seen, environment, kUnshadowed),
                                                      accumulation)
                                       .mean;
            ++settings.sampleIndex;
            if (i + 1 == samples) {
                const Readback readback = render.renderer.ReadBack(mean);
                render.renderer.Execute();
                return ToFloatImage(readback);
            }
            render.renderer.Present(mean);
            render.renderer.Execute();
        }
    }

    // Expects for direct light without shadows that both views differ by less than 1 % at positions around
    // the center of each surface, some of which are lit, and by less than 0.3 % in the picture's mean.
    void ExpectSameDirectLight(TraceSettings settings, std::span<const glm::vec3> centers = kRowCenters) {
        settings.biases.maxDepth = 1;
        const glm::dvec3 traced = render.Render(settings, 16).mean.Mean();
        const glm::dvec3 drawn = Draw(settings, 16).Mean();
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(drawn[c], traced[c], 0.003 * traced[c]);

        // The view is so narrow that the position within a pixel does not matter
        settings.extent = {1, 1};
        settings.camera.right = 1e-5f * glm::normalize(settings.camera.right);
        settings.camera.up = 1e-5f * glm::normalize(settings.camera.up);
        for (const glm::vec3& center : centers) {
            uint32_t lit = 0;
            for (float y = -0.3f; y < 0.4f; y += 0.3f)
                for (float x = -0.3f; x < 0.4f; x += 0.15f) {
                    const glm::vec3 target = center + glm::vec3(x, y, 0);
                    settings.camera.forward = glm::normalize(target - settings.camera.origin);
                    const glm::vec4 a = render.TraceOnce(settings).At(0, 0);
                    const glm::vec4 b = Draw(settings, 1).At(0, 0);
                    EXPECT_EQ(a.w, 1.0f);
                    EXPECT_EQ(b.w, 1.0f);
                    for (int c = 0; c < 3; ++c)
                        EXPECT_NEAR(a[c], b[c], 0.01 * a[c] + 1e-3 * traced[c])
                            << target.x << ", " << target.y;
                    lit += a.y > 0.1 * traced.y;
                }
            EXPECT_GE(lit, 3u) << "at " << center.x;
        }
    }

    // Shows each of the first `count` instances alone, as two halves of the picture: the means of its direct
    // light agree in both views, to `tolerance`.
    void ExpectSameSurfaces(TraceSettings settings, uint32_t count, double tolerance) {
        settings.biases.maxDepth = 1;
        const uint32_t all = render.scene.Statistics().instanceCount;
        for (uint32_t instance = 0; instance < count; ++instance) {
            for (uint32_t i = 0; i < all; ++i) render.scene.SetVisible(i, i == instance);
            const FloatImage traced = render.Render(settings, 16).mean;
            const FloatImage drawn = Draw(settings, 16);
            const std::vector<glm::uvec4> ids = render.PrimaryHits(settings).ids;
            glm::dvec3 a[2] = {}, b[2] = {};
            for (size_t i = 0; i < ids.size(); ++i) {
                if (ids[i].x != instance) continue;
                const bool isLower = i / settings.extent.width >= settings.extent.height / 2;
                a[isLower] += glm::dvec3(traced.values[i]);
                b[isLower] += glm::dvec3(drawn.values[i]);
            }
            for (int part = 0; part < 2; ++part)
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(b[part][c], a[part][c], tolerance * a[part][c])
                        << "instance " << instance << ", half " << part;
        }
    }

    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

scene::Material Glossy(const glm::vec3& color, float metallic, float roughness) {
    scene::Material material;
    material.baseColorFactor = glm::vec4(color, 1.0f);
    material.metallicFactor = metallic;
    material.roughnessFactor = roughness;
    return material;
}

// Makes spheres of chalk, plastic and gold and a pane of rough glass in a row, none of which lights another.
scene::SceneData Row(std::vector<scene::Light> lights) {
    std::vector<scene::Mesh> meshes;
    std::vector<glm::mat4x3> transforms;
    for (uint32_t i = 0; i < 4; ++i) {
        meshes.push_back(SphereMesh(0.45f, 64, i));
        transforms.push_back(Translation(kRowCenters[i]));
    }
    transforms[1][0] = {-1, 0, 0};  // mirrored
    meshes[3] = QuadMesh(0.45f, 3);
    scene::Material glass = Glossy({0.9f, 1.0f, 0.9f}, 0, 0.5f);
    glass.transmissionFactor = 1.0f;
    scene::SceneData scene = SceneOf(std::move(meshes),
                                     {Glossy(glm::vec3(0.8f), 0, 1), Glossy({0.6f, 0.05f, 0.04f}, 0, 0.35f),
                                      Glossy({1.0f, 0.766f, 0.336f}, 1, 0.45f), glass},
                                     std::move(transforms));
    scene.lights = std::move(lights);
    return scene;
}

TraceSettings ViewOfRow(BrdfModel brdf) {
    TraceSettings settings = LookAt({0.5f, 0.6f, 6}, {0, 0, 0}, 0.3f, 64);
    settings.extent = {224, 64};
    settings.camera.right *= 3.5f;
    settings.scattering.brdf = brdf;
    return settings;
}

scene::Light Punctual(scene::LightType type, const glm::vec3& color, float intensity,
                      const glm::vec3& position) {
    scene::Light light;
    light.type = type;
    light.color = color;
    light.intensity = intensity;
    light.lightToWorld = Translation(position);
    return light;
}

scene::Light PointLight() {
    return Punctual(scene::LightType::Point, {1.0f, 0.9f, 0.8f}, 300.0f, {1, 4, 9});
}
scene::Light SpotLight() {
    scene::Light light = Punctual(scene::LightType::Spot, {0.7f, 0.9f, 1.0f}, 400.0f, {-1, 1, 10});
    light.innerConeAngle = 0.02f;
    light.outerConeAngle = 0.45f;  // all surfaces are inside
    return light;
}
scene::Light Sun() {
    return Punctual(scene::LightType::Directional, {1, 1, 1}, 3.0f, {0, 0, 0});
}

// Makes a bright patch in a blue sky over a dark ground.
image::ImageF PatchInTheSky() {
    const uint32_t width = 64, height = 32;
    image::ImageF map{.width = width, .height = height, .rgba = {}};
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            glm::vec3 value = y < 16 ? glm::vec3(0.4f, 0.6f, 1.0f) : glm::vec3(0.1f);
            if (y >= 8 && y < 12 && x >= 40 && x < 46) value = glm::vec3(30.0f);
            map.rgba.insert(map.rgba.end(), {value.x, value.y, value.z, 1.0f});
        }
    return map;
}

}  // namespace

TEST_F(RasterShade, EachPunctualLightIsAsPathTraced) {
    for (const BrdfModel brdf : {BrdfModel::Lambert, BrdfModel::Gltf})
        for (const scene::Light& light : {PointLight(), SpotLight(), Sun()}) {
            SCOPED_TRACE(std::to_string(int(brdf)) + " " + std::to_string(int(light.type)));
            render.scene.SetScene(Row({light}));
            ExpectSameDirectLight(ViewOfRow(brdf));
        }
}

// Light comes from punctual lights, from a uniform environment, and from one with a patch that a stretched
// reflection smears.
TEST_F(RasterShade, StretchedHighlightsAreAsPathTraced) {
    const auto brushed = [](std::vector<scene::Light> lights) {
        scene::SceneData scene = Row(std::move(lights));
        for (scene::Material& material : scene.materials) {
            material.anisotropyStrength = 0.7f;
            material.anisotropyRotation = 0.5f;
        }
        return scene;
    };
    render.scene.SetScene(brushed({PointLight()}));
    ExpectSameDirectLight(ViewOfRow(BrdfModel::Gltf));
    render.scene.SetScene(brushed({}));
    render.scene.SetEnvironment({.radiance = {1.0f, 0.8f, 0.6f}});
    ExpectSameSurfaces(ViewOfRow(BrdfModel::Gltf), 4, 0.04);
    render.scene.SetEnvironmentMap(PatchInTheSky());
    render.scene.SetEnvironment({.radiance = glm::vec3(0.7f), .rotation = 1.0f});
    ExpectSameSurfaces(ViewOfRow(BrdfModel::Gltf), 3, 0.25);  // the spheres
}

TEST_F(RasterShade, AnEvenEnvironmentLightsAsPathTraced) {
    for (const BrdfModel brdf : {BrdfModel::Lambert, BrdfModel::Gltf}) {
        render.scene.SetScene(Row({}));
        render.scene.SetEnvironment({.radiance = {1.0f, 0.8f, 0.6f}});
        // Each surface is alone, and is seen face on and from the side
        ExpectSameSurfaces(ViewOfRow(brdf), 4, 0.03);
    }
}

TEST_F(RasterShade, AnEnvironmentMapLightsAboutAsPathTraced) {
    render.scene.SetScene(Row({}));
    render.scene.SetEnvironmentMap(PatchInTheSky());
    for (const float rotation : {0.0f, 1.0f}) {
        render.scene.SetEnvironment({.radiance = glm::vec3(0.7f), .rotation = rotation});
        ExpectSameSurfaces(ViewOfRow(BrdfModel::Gltf), 3, 0.2);  // the spheres
    }
}

// The levels lie below each other: the last row of one is next to the first row, the zenith, of the one
// below.
TEST_F(RasterShade, WhatFacesTheNadirReflectsNoZenith) {
    const uint32_t width = 8, height = 4;
    image::ImageF map{.width = width, .height = height, .rgba = {}};
    for (uint32_t texel = 0; texel < width * height; ++texel) {
        const float value = texel < width ? 40.0f : 1.0f;
        map.rgba.insert(map.rgba.end(), {value, value, value, 1.0f});
    }
    scene::SceneData scene = SceneOf({QuadMesh(1.0f)}, {Glossy(glm::vec3(1.0f), 1, 0.4f)});
    scene.meshes[0].primitives[0].positions = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
    scene.meshes[0].primitives[0].normals.assign(4, {0, -1, 0});
    scene.meshes[0].primitives[0].bounds = {{-1, 0, -1}, {1, 0, 1}};
    render.scene.SetScene(std::move(scene));
    render.scene.SetEnvironmentMap(map);
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings settings = LookAt({0, -3, 0.001f}, {0, 0, 0}, 0.1f, 8);
    settings.scattering = {};
    const glm::dvec3 drawn = Draw(settings, 1, FilmPosition::Center).Mean();
    EXPECT_NEAR(drawn.y, 1.0, 0.1);
}

TEST_F(RasterShade, AMapIsFilteredOnce) {
    image::ImageF map{.width = 4, .height = 2, .rgba = std::vector<float>(32, 0.5f)};
    const auto wasFiltered = [&] {
        render.renderer.BeginFrame();
        const TextureId filtered =
            passes::FilterEnvironment(render.renderer, render.scene.Declare(render.renderer), environment);
        const Readback readback = render.renderer.ReadBack(filtered);
        render.renderer.Execute();
        float worst = 0.0f;
        for (const glm::vec4& value : ToFloatImage(readback).values)
            worst = std::max(worst, glm::distance(glm::vec3(value), glm::vec3(map.rgba[0])));
        EXPECT_LT(worst, 1e-4f);
        return render.renderer.DescribePlan().find("FilterEnvironment") != std::string::npos;
    };
    render.scene.SetEnvironment({.radiance = glm::vec3(2.0f)});
    render.scene.SetEnvironmentMap(map);
    EXPECT_TRUE(wasFiltered());
    EXPECT_FALSE(wasFiltered());
    render.scene.SetEnvironment({.radiance = glm::vec3(3.0f), .rotation = 1.0f});
    EXPECT_FALSE(wasFiltered());
    map.rgba.assign(32, 0.25f);
    render.scene.SetEnvironmentMap(map);
    EXPECT_TRUE(wasFiltered());
    EXPECT_FALSE(wasFiltered());
}

TEST_F(RasterShade, LightsAddUp) {
    const TraceSettings settings = ViewOfRow(BrdfModel::Gltf);
    const auto drawn = [&](std::vector<scene::Light> lights) {
        render.scene.SetScene(Row(std::move(lights)));
        return Draw(settings, 1);
    };
    const FloatImage all = drawn({PointLight(), SpotLight(), Sun()});
    const FloatImage parts[] = {drawn({PointLight()}), drawn({SpotLight()}), drawn({Sun()})};
    EXPECT_GT(all.Mean().y, 0.05);
    for (size_t i = 0; i < all.values.size(); ++i) {
        const glm::vec4 sum = parts[0].values[i] + parts[1].values[i] + parts[2].values[i];
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(all.values[i][c], sum[c], 1e-4f * (1.0f + sum[c]));
    }
}

TEST_F(RasterShade, EmittingSurfacesLightAsPathTracedWithoutOccluders) {
    // A glossy floor under a lamp that is out of the picture
    const glm::mat4x3 floor(glm::vec3(1, 0, 0), glm::vec3(0, 0, -1), glm::vec3(0, 1, 0), glm::vec3(0.0f));
    const glm::mat4x3 lamp(glm::vec3(1, 0, 0), glm::vec3(0, 0, 1), glm::vec3(0, -1, 0), glm::vec3(0, 2, 0));
    render.scene.SetScene(SceneOf(
        {QuadMesh(2.0f, 0), QuadMesh(0.3f, 1)},
        {Glossy({0.7f, 0.4f, 0.2f}, 0.3f, 0.5f), Lambert(glm::vec3(0.0f), glm::vec3(5.0f))}, {floor, lamp}));
    TraceSettings settings = LookAt({0, 1, 2}, {0, 0, 0.3f}, 0.4f, 64);
    settings.scattering.brdf = BrdfModel::Gltf;
    settings.biases.maxDepth = 1;
    const RenderedImage traced = render.Render(settings, 64);
    const glm::dvec3 drawn = Draw(settings, 64).Mean();
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(drawn[c], traced.mean.Mean()[c], 0.01 * traced.mean.Mean()[c]);
    EXPECT_LT(3.0 * traced.StandardErrorOfMean().y, 0.01 * traced.mean.Mean().y) << "too noisy";
}

// The sheet transmits light diffusely, and is lit from behind alone.
TEST_F(RasterShade, LightFromBehindASheetIsAsPathTraced) {
    scene::Material leaf = Glossy({0.3f, 0.6f, 0.1f}, 0, 0.6f);
    leaf.diffuseTransmissionFactor = 0.7f;
    leaf.diffuseTransmissionColorFactor = {0.8f, 0.9f, 0.4f};
    TraceSettings settings = LookAt({0.5f, 0.6f, 6}, {0, 0, 0}, 0.3f, 64);
    settings.scattering.brdf = BrdfModel::Gltf;
    const glm::vec3 middle(0.0f);
    scene::Light sun = Sun();
    sun.lightToWorld =
        glm::mat4x3(glm::vec3(-1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, -1), glm::vec3(0.0f));
    for (const scene::Light& light :
         {Punctual(scene::LightType::Point, {1.0f, 0.9f, 0.8f}, 60.0f, {1, 0.5f, -5}), sun}) {
        SCOPED_TRACE(int(light.type));
        scene::SceneData scene = SceneOf({QuadMesh(3.0f)}, {leaf});
        scene.lights = {light};
        render.scene.SetScene(std::move(scene));
        ExpectSameDirectLight(settings, std::span(&middle, 1));
    }
    // Light is emitted, and comes from an environment that emits where z < 0
    settings.biases.maxDepth = 1;
    const auto expectSameMean = [&](double tolerance) {
        const RenderedImage traced = render.Render(settings, 64);
        const glm::dvec3 drawn = Draw(settings, 64).Mean();
        for (int c = 0; c < 3; ++c) {
            EXPECT_GT(traced.mean.Mean()[c], 0.02);
            EXPECT_NEAR(drawn[c], traced.mean.Mean()[c], tolerance * traced.mean.Mean()[c]) << c;
        }
        EXPECT_LT(3.0 * traced.StandardErrorOfMean().y, 0.01 * traced.mean.Mean().y) << "too noisy";
    };
    render.scene.SetScene(SceneOf({QuadMesh(3.0f, 0), QuadMesh(0.5f, 1)},
                                  {leaf, Lambert(glm::vec3(0.0f), glm::vec3(5.0f))},
                                  {glm::mat4x3(1.0f), Translation({0, 0, -1.5f})}));
    expectSameMean(0.01);
    image::ImageF map{.width = 64, .height = 32, .rgba = {}};
    for (uint32_t texel = 0; texel < 64 * 32; ++texel) {
        const float value = texel % 64 < 32 ? 2.0f : 0.0f;
        map.rgba.insert(map.rgba.end(), {value, value, value, 1.0f});
    }
    render.scene.SetScene(SceneOf({QuadMesh(3.0f)}, {leaf}));
    render.scene.SetEnvironmentMap(map);
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    expectSameMean(0.04);
}

TEST_F(RasterShade, EmissionUnlitColorAndBackgroundAreShownAsTheyAre) {
    scene::Material unlit = Lambert({0.2f, 0.4f, 0.6f});
    unlit.isUnlit = true;
    scene::SceneData scene = SceneOf({QuadMesh(0.5f, 0), QuadMesh(0.5f, 1)},
                                     {Lambert(glm::vec3(0.0f), {0.5f, 0.25f, 0.75f}), unlit},
                                     {Translation({-1, 0, 0}), Translation({1, 0, 0})});
    scene.lights = {Punctual(scene::LightType::Point, {1, 1, 1}, 100.0f, {1, 0, 3})};
    scene.lights[0].intensity = 0.0f;
    render.scene.SetScene(std::move(scene));
    render.scene.SetEnvironment({.radiance = {0.1f, 0.2f, 0.3f}});
    const FloatImage drawn = Draw(LookAt({0, 0, 4}, {0, 0, 0}, 0.9f, 64), 1);
    const auto expect = [&](uint32_t x, uint32_t y, const glm::vec4& value) {
        for (int c = 0; c < 4; ++c) EXPECT_NEAR(drawn.At(x, y)[c], value[c], 1e-5f) << x << ", " << c;
    };
    expect(15, 32, {0.5f, 0.25f, 0.75f, 1});
    expect(48, 32, {0.2f, 0.4f, 0.6f, 1});
    expect(32, 32, {0.1f, 0.2f, 0.3f, 0});
    expect(32, 2, {0.1f, 0.2f, 0.3f, 0});
}

TEST_F(RasterShade, BlendIsRightInTheMeanWhateverTheOrder) {
    // Two veils of alpha 1/2 and 1/4 that shine, in front of the background
    scene::Material half = Lambert(glm::vec3(0.0f), {1, 0, 0}), quarter = Lambert(glm::vec3(0.0f), {0, 1, 0});
    half.alphaMode = quarter.alphaMode = scene::AlphaMode::Blend;
    half.baseColorFactor.a = 0.5f;
    quarter.baseColorFactor.a = 0.25f;
    for (const bool isHalfInFront : {false, true}) {
        render.scene.SetScene(
            SceneOf({QuadMesh(2.0f, 0), QuadMesh(2.0f, 1)}, {half, quarter},
                    {Translation({0, 0, isHalfInFront ? 0.5f : -0.5f}), Translation({0, 0, 0})}));
        render.scene.SetEnvironment({.radiance = {0, 0, 1}});
        const glm::dvec3 mean = Draw(LookAt({0, 0, 4}, {0, 0, 0}, 0.4f, 64), 16).Mean();
        EXPECT_NEAR(mean.x, isHalfInFront ? 0.5 : 0.375, 0.01);
        EXPECT_NEAR(mean.y, isHalfInFront ? 0.125 : 0.25, 0.01);
        EXPECT_NEAR(mean.z, 0.375, 0.01);
    }
}

TEST_F(RasterShade, JitteredSamplesSmoothEdgesAsTracedOnesDo) {
    render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.0f), glm::vec3(1.0f))}));
    TraceSettings settings = LookAt({0.3f, 0.2f, 6}, {0.1f, 0, 0}, 0.6f, 48);
    const FloatImage drawn = Draw(settings, 64);
    const FloatImage traced = render.Render(settings, 64).mean;
    for (size_t i = 0; i < drawn.values.size(); ++i)
        ASSERT_NEAR(drawn.values[i].x, traced.values[i].x, 0.06f) << "pixel " << i;
}

}  // namespace raygraph::testing::raster_shade_test

// Tests shadows of the raster view: rays give those of the path tracer, maps the same except near edges.
namespace raygraph::testing::raster_shadow_test {

using passes::FilmPosition;
using passes::RasterShadows;
using passes::TraceSettings;

namespace {

class RasterShadow : public VulkanTest {
  protected:
    FloatImage Draw(TraceSettings settings, RasterShadows shadows, uint32_t samples = 1) {
        const FilmPosition film = samples > 1 ? FilmPosition::Jittered : FilmPosition::Center;
        passes::Accumulation accumulation("drawn");
        for (uint32_t i = 0;; ++i) {
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            const passes::RasterVisibility seen =
                passes::DrawVisibility(render.renderer, ids, settings, film);
            const TextureId radiance =
                passes::RasterShade(render.renderer, ids, settings, seen, environment,
                                    {.shadows = shadows, .hasOcclusion = false, .hasTransmission = false});
            const Readback mean =
                render.renderer.ReadBack(passes::Accumulate(render.renderer, radiance, accumulation).mean);
            render.renderer.Execute();
            ++settings.sampleIndex;
            if (i + 1 == samples) return ToFloatImage(mean);
        }
    }

    // Returns whether light arrives at, or is seen in, another pixel of the square of this size around a
    // pixel.
    static bool IsNearEdge(const FloatImage& image, uint32_t x, uint32_t y, uint32_t reach) {
        const glm::vec4& here = image.At(x, y);
        for (uint32_t j = y < reach ? 0 : y - reach; j <= std::min(y + reach, image.extent.height - 1); ++j)
            for (uint32_t i = x < reach ? 0 : x - reach; i <= std::min(x + reach, image.extent.width - 1);
                 ++i)
                if (std::abs(image.At(i, j).y - here.y) > 0.15f * std::max(image.At(i, j).y, here.y))
                    return true;
        return false;
    }

    struct Difference {
        double share = 0.0;     // fraction of pixels that differ by more than the tolerance
        double offEdges = 0.0;  // fraction of pixels that differ and are near no edge
        double shadowed = 0.0;  // fraction of pixels of `b` that are black
    };
    static Difference Compare(const FloatImage& a, const FloatImage& b, float tolerance, uint32_t reach) {
        const double brightest = b.Mean().y;
        Difference difference;
        for (uint32_t y = 0; y < b.extent.height; ++y)
            for (uint32_t x = 0; x < b.extent.width; ++x) {
                bool isSame = true;
                for (int c = 0; c < 3; ++c)
                    isSame = isSame && std::abs(a.At(x, y)[c] - b.At(x, y)[c]) <=
                                           tolerance * b.At(x, y)[c] + 1e-3 * brightest;
                difference.shadowed += b.At(x, y).w > 0.0f && b.At(x, y).y == 0.0f;
                if (isSame) continue;
                difference.share += 1.0;
                difference.offEdges += !IsNearEdge(b, x, y, reach);
            }
        const double pixels = double(b.extent.width) * b.extent.height;
        return {difference.share / pixels, difference.offEdges / pixels, difference.shadowed / pixels};
    }

    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

scene::Light Punctual(scene::LightType type, float intensity, const glm::mat4x3& lightToWorld) {
    scene::Light light;
    light.type = type;
    light.color = {1.0f, 0.9f, 0.8f};
    light.intensity = intensity;
    light.lightToWorld = lightToWorld;
    return light;
}

// Places an object at `eye` with its -z towards `target`.
glm::mat4x3 Aimed(const glm::vec3& eye, const glm::vec3& target) {
    const glm::vec3 z = glm::normalize(eye - target);
    const glm::vec3 x = glm::normalize(glm::cross(glm::vec3(0.1f, 1, 0.2f), z));
    return {x, glm::cross(z, x), z, eye};
}

std::vector<scene::Light> Lights() {
    scene::Light spot = Punctual(scene::LightType::Spot, 60.0f, Aimed({-2, 4, 2}, {0, 0, 0}));
    spot.innerConeAngle = 0.3f;
    spot.outerConeAngle = 0.6f;
    return {Punctual(scene::LightType::Directional, 3.0f, Aimed({1, 3, 2}, {0, 0, 0})), spot,
            Punctual(scene::LightType::Point, 40.0f, Translation({1.2f, 2.5f, 1.5f}))};
}

// Makes gold and chalk spheres, a one-sided box and a thin pane on and above a floor.
scene::SceneData Table(std::vector<scene::Light> lights) {
    scene::Material gold;
    gold.baseColorFactor = {1.0f, 0.77f, 0.34f, 1.0f};
    gold.roughnessFactor = 0.5f;
    scene::Material box = Lambert({0.3f, 0.5f, 0.8f});
    box.isDoubleSided = false;
    const glm::mat4x3 floor(glm::vec3(1, 0, 0), glm::vec3(0, 0, -1), glm::vec3(0, 1, 0), glm::vec3(0.0f));
    const glm::mat4x3 pane(glm::vec3(1, 0, 0), glm::vec3(0, 0.4f, -0.9f), glm::vec3(0, 0.9f, 0.4f),
                           glm::vec3(-0.6f, 1.3f, 0.4f));
    scene::SceneData scene = SceneOf({QuadMesh(3.0f, 0), SphereMesh(0.5f, 32, 1), SphereMesh(0.4f, 32, 0),
                                      BoxMesh(0.3f, 2), QuadMesh(0.3f, 0)},
                                     {Lambert(glm::vec3(0.7f)), gold, box},
                                     {floor, Translation({-0.9f, 0.5f, 0}), Translation({0.2f, 0.4f, 0.5f}),
                                      Translation({1.0f, 0.3f, -0.2f}), pane});
    scene.lights = std::move(lights);
    return scene;
}

TraceSettings ViewOfTable(uint32_t size) {
    TraceSettings settings = LookAt({0.5f, 2.2f, 4.5f}, {0, 0.4f, 0}, 0.7f, size);
    settings.scattering.brdf = BrdfModel::Gltf;
    settings.biases.maxDepth = 1;
    return settings;
}

}  // namespace

TEST_F(RasterShadow, WithRaysDirectLightIsAsPathTraced) {
    for (const scene::Light& light : Lights()) {
        SCOPED_TRACE(int(light.type));
        render.scene.SetScene(Table({light}));
        const TraceSettings settings = ViewOfTable(80);
        const Difference difference =
            Compare(Draw(settings, RasterShadows::Rays, 16), render.Render(settings, 16).mean, 0.01f, 2);
        EXPECT_LE(difference.offEdges, 5e-4) << "the rim of a spot is steep";
        EXPECT_LT(difference.share, 0.12);
        RecordProperty("edges, light " + std::to_string(int(light.type)), std::to_string(difference.share));
    }
}

// There are more hidden placements than invocations of one dispatch, followed by the visible ones.
TEST_F(RasterShadow, EveryPlacementIsDrawnAndCastsItsShadowHoweverManyThereAre) {
    const auto drawn = [&](size_t count) {
        scene::SceneData table = Table({Lights()[0]});
        const uint32_t speck = static_cast<uint32_t>(table.meshes.size());
        table.meshes.push_back(QuadMesh(1e-3f, 0));
        scene::Instance hidden;  // under the floor
        hidden.mesh = speck;
        hidden.objectToWorld = Translation({0, -0.01f, 0});
        table.instances.insert(table.instances.begin(), count, hidden);
        render.scene.SetScene(std::move(table));
        return Draw(ViewOfTable(64), RasterShadows::Maps);
    };
    const FloatImage few = drawn(1), many = drawn((1u << 18) + 100);
    EXPECT_EQ(few.values, many.values);
    EXPECT_GT(few.Mean().y, 0.1);
}

TEST_F(RasterShadow, WithRaysLightComesThroughThinWallsAsPathTraced) {
    scene::Material glass;
    glass.baseColorFactor = {0.9f, 0.5f, 0.7f, 1.0f};
    glass.metallicFactor = glass.roughnessFactor = 0.0f;
    glass.transmissionFactor = 1.0f;
    for (const scene::Light& light : Lights()) {
        SCOPED_TRACE(int(light.type));
        // A pane over all of it, above the picture and below the lights
        scene::SceneData table = Table({light});
        table.materials.push_back(glass);
        table.meshes.push_back(QuadMesh(9.0f, 3));
        table.instances.push_back({.mesh = uint32_t(table.meshes.size() - 1),
                                   .objectToWorld = {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, 2.4f, 0}}});
        render.scene.SetScene(std::move(table));
        const TraceSettings settings = ViewOfTable(80);
        const FloatImage drawn = Draw(settings, RasterShadows::Rays, 16);
        const Difference difference = Compare(drawn, render.Render(settings, 16).mean, 0.01f, 2);
        EXPECT_LE(difference.offEdges, 5e-4) << "the rim of a spot is steep";
        EXPECT_LT(difference.share, 0.12);
        render.scene.SetVisible(uint32_t(render.scene.Statistics().instanceCount - 1), false);
        const glm::dvec3 passed = drawn.Mean() / Draw(settings, RasterShadows::Rays, 16).Mean();
        EXPECT_NEAR(passed.x, 0.96 * 0.9, 0.05);
        EXPECT_NEAR(passed.y, 0.96 * 0.5, 0.05);
    }
}

TEST_F(RasterShadow, MapsAreAsRaysButNearShadowEdges) {
    for (const scene::Light& light : Lights()) {
        SCOPED_TRACE(int(light.type));
        render.scene.SetScene(Table({light}));
        const TraceSettings settings = ViewOfTable(160);
        const Difference difference =
            Compare(Draw(settings, RasterShadows::Maps), Draw(settings, RasterShadows::Rays), 0.02f, 2);
        EXPECT_GT(difference.shadowed, 0.03);
        EXPECT_LE(difference.share, 0.05);
        EXPECT_LE(difference.offEdges, 0.001);
        RecordProperty("differ, light " + std::to_string(int(light.type)), std::to_string(difference.share));
        RecordProperty("differ off edges, light " + std::to_string(int(light.type)),
                       std::to_string(difference.offEdges));
    }
}

TEST_F(RasterShadow, APointLightIsShadowedOnAllSides) {
    // A room with a box between the lamp and the middle of each wall
    std::vector<scene::Mesh> meshes{BoxMesh(2.0f)};
    std::vector<glm::mat4x3> transforms{Translation({0, 0, 0})};
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            glm::vec3 at(0.0f);
            at[axis] = side;
            meshes.push_back(BoxMesh(0.2f));
            transforms.push_back(Translation(at));
        }
    scene::SceneData room = SceneOf(std::move(meshes), {Lambert(glm::vec3(0.5f))}, std::move(transforms));
    room.lights = {Punctual(scene::LightType::Point, 10.0f, Translation({0.05f, 0.1f, -0.05f}))};
    render.scene.SetScene(std::move(room));
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            glm::vec3 target(0.0f);
            target[axis] = side;
            SCOPED_TRACE(std::to_string(axis) + (side < 0 ? "-" : "+"));
            const TraceSettings settings =
                LookAt(-1.5f * target + glm::vec3(0.3f, 0.35f, 0.3f), 2.0f * target, 1.2f, 48);
            const Difference difference =
                Compare(Draw(settings, RasterShadows::Maps), Draw(settings, RasterShadows::Rays), 0.02f, 2);
            EXPECT_GT(difference.shadowed, 0.02);
            EXPECT_LE(difference.offEdges, 0.002);
            EXPECT_LE(difference.share, 0.1);
        }
}

TEST_F(RasterShadow, AlphaAndSidesCastShadowsAsTheyStopRays) {
    // Before a wall: a half-covering veil, and a quad whose back is towards the light and is not there
    scene::Material veil = Lambert(glm::vec3(0.5f)), oneSided = Lambert(glm::vec3(0.5f));
    veil.alphaMode = scene::AlphaMode::Blend;
    veil.baseColorFactor.a = 0.5f;
    oneSided.isDoubleSided = false;
    const glm::mat4x3 turned(glm::vec3(-1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, -1),
                             glm::vec3(1, 0, 1));
    scene::SceneData scene =
        SceneOf({QuadMesh(3.0f), QuadMesh(0.4f, 1), QuadMesh(0.4f, 2), QuadMesh(0.4f, 2)},
                {Lambert(glm::vec3(0.5f)), veil, oneSided},
                {Translation({0, 0, 0}), Translation({-1, 0, 1}), Translation({0, 0, 1}), turned});
    scene.lights = {Punctual(scene::LightType::Directional, 1.0f, Aimed({0, 3, 3}, {0, 0, 0}))};
    render.scene.SetScene(std::move(scene));
    const TraceSettings settings = LookAt({0, -1.2f, 5}, {0, -1, 0}, 0.6f, 64);
    const FloatImage maps = Draw(settings, RasterShadows::Maps, 64);
    const FloatImage rays = Draw(settings, RasterShadows::Rays, 64);
    const float lit = rays.At(32, 60).y;
    EXPECT_GT(lit, 0.05f);
    const auto expect = [&](float x, float share) {
        const auto column = uint32_t(32.0f + x * 64.0f / (2.0f * 5.0f * std::tan(0.3f)));
        EXPECT_NEAR(maps.At(column, 32).y / lit, share, 0.1f) << x;
        EXPECT_NEAR(rays.At(column, 32).y / lit, share, 0.1f) << x;
    };
    expect(-1.0f, 0.5f);
    // A ray from the wall to the light meets the quad's back, and the turned one's front
    expect(0.0f, 1.0f);
    expect(1.0f, 0.0f);
}

TEST_F(RasterShadow, CascadesMoveInWholeTexelsAndKeepTheirSize) {
    render.scene.SetScene(Table({Lights()[0]}));
    const auto views = [&](const glm::vec3& offset) {
        TraceSettings settings = ViewOfTable(32);
        settings.camera.origin += offset;
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback readback = render.renderer.ReadBack(
            passes::DrawShadowMaps(render.renderer, ids, settings, {.atlasSize = 512}).views);
        render.renderer.Execute();
        readback.Wait();
        const auto all = As<gpu::ShadowView>(readback.Bytes());
        return std::vector<gpu::ShadowView>(all.begin(), all.begin() + gpu::kShadowCascades);
    };
    const std::vector<gpu::ShadowView> before = views({0, 0, 0});
    EXPECT_LT(before[0].texel, before[3].texel);
    double moved = 0.0;
    for (int step = 1; step <= 8; ++step) {
        const std::vector<gpu::ShadowView> after = views(0.013f * float(step) * glm::vec3(1, 0.7f, -0.4f));
        for (size_t i = 0; i < after.size(); ++i) {
            EXPECT_EQ(after[i].texel, before[i].texel);
            const glm::vec3 way = after[i].camera.origin - before[i].camera.origin;
            for (const glm::vec3& axis : {after[i].camera.right, after[i].camera.up}) {
                const double texels = glm::dot(way, glm::normalize(axis)) / after[i].texel;
                EXPECT_NEAR(texels, std::round(texels), 0.02) << "cascade " << i;
                moved += std::abs(texels);
            }
        }
    }
    EXPECT_GT(moved, 5.0);
}

TEST_F(RasterShadow, LightsBeyondTheAtlasCastNoShadow) {
    std::vector<scene::Light> lights;
    for (int i = 0; i < 12; ++i)
        lights.push_back(
            Punctual(scene::LightType::Point, i < 11 ? 1e-6f : 40.0f, Translation({1.2f, 2.5f, 1.5f})));
    render.scene.SetScene(Table(lights));
    const TraceSettings settings = ViewOfTable(48);
    const FloatImage unshadowed = Draw(settings, RasterShadows::Off);
    EXPECT_LT(Compare(Draw(settings, RasterShadows::Maps), unshadowed, 0.01f, 1).share, 0.001)
        << "ten lights of six faces fill the atlas";
    for (scene::Light& light : lights)
        if (light.intensity < 1.0f) light.intensity = 0.0f;
    render.scene.SetScene(Table(lights));
    EXPECT_GT(Compare(Draw(settings, RasterShadows::Maps), unshadowed, 0.01f, 1).share, 0.05)
        << "dark lights take no tiles";
}

}  // namespace raygraph::testing::raster_shadow_test
