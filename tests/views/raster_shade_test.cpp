// Tests that the raster view is lit as the path tracer lights: by the same materials, BSDFs and punctual
// lights.
#include "passes/raster.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::raster_shade_test {

using passes::FilmPosition;
using passes::TraceSettings;

namespace {

constexpr uint32_t kSamples = 64;

constexpr passes::RasterSettings kUnshadowed{
    .shadows = passes::RasterShadows::Off, .hasOcclusion = false, .hasTransmission = false};

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

    // Expects for direct light without shadows that both views differ by less than 1 % at positions all over
    // the picture, and by less than 0.3 % in its mean.
    void ExpectSameDirectLight(TraceSettings settings) {
        settings.biases.maxDepth = 1;
        const glm::dvec3 traced = render.Render(settings, 16).mean.Mean();
        const glm::dvec3 drawn = Draw(settings, 16).Mean();
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(drawn[c], traced[c], 0.003 * traced[c]);

        // The view is so narrow that the position within a pixel does not matter
        uint32_t lit = 0, edges = 0;
        for (float y = -0.95f; y < 1.0f; y += 0.2f)
            for (float x = -0.99f; x < 1.0f; x += 0.06f) {
                TraceSettings narrow = settings;
                narrow.extent = {1, 1};
                narrow.camera.forward = glm::normalize(settings.camera.forward + x * settings.camera.right +
                                                       y * settings.camera.up);
                narrow.camera.right = 1e-5f * glm::normalize(settings.camera.right);
                narrow.camera.up = 1e-5f * glm::normalize(settings.camera.up);
                const glm::vec4 a = render.TraceOnce(narrow).At(0, 0);
                const glm::vec4 b = Draw(narrow, 1).At(0, 0);
                edges += a.w != b.w;
                if (a.w != 1.0f || b.w != 1.0f) continue;
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(a[c], b[c], 0.01 * a[c] + 1e-3 * traced[c]) << x << ", " << y;
                lit += a.y > 0.1 * traced.y;
            }
        EXPECT_GT(lit, 50u);
        EXPECT_LE(edges, 1u);
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
        transforms.push_back(Translation({1.3f * (float(i) - 1.5f), 0, 0}));
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
    light.outerConeAngle = 0.3f;
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

TEST_F(RasterShade, LambertUnderEachPunctualLightIsAsPathTraced) {
    for (const scene::Light& light : {PointLight(), SpotLight(), Sun()}) {
        SCOPED_TRACE(int(light.type));
        render.scene.SetScene(Row({light}));
        ExpectSameDirectLight(ViewOfRow(BrdfModel::Lambert));
    }
}

TEST_F(RasterShade, GltfMaterialsUnderEachPunctualLightAreAsPathTraced) {
    for (const scene::Light& light : {PointLight(), SpotLight(), Sun()}) {
        SCOPED_TRACE(int(light.type));
        render.scene.SetScene(Row({light}));
        ExpectSameDirectLight(ViewOfRow(BrdfModel::Gltf));
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
    scene::Light sun = Sun();
    sun.lightToWorld =
        glm::mat4x3(glm::vec3(-1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, -1), glm::vec3(0.0f));
    for (const scene::Light& light :
         {Punctual(scene::LightType::Point, {1.0f, 0.9f, 0.8f}, 60.0f, {1, 0.5f, -5}), sun}) {
        SCOPED_TRACE(int(light.type));
        scene::SceneData scene = SceneOf({QuadMesh(3.0f)}, {leaf});
        scene.lights = {light};
        render.scene.SetScene(std::move(scene));
        ExpectSameDirectLight(settings);
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
