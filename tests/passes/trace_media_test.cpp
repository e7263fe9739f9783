#include <cmath>
#include <numbers>

#include "shaders/shared/trace_options.h"
#include "tests/passes/gltf_square.h"
#include "tests/support/same_image.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

// Media that scatter, on the device.
namespace raygraph::testing::trace_scattering_test {

using passes::TraceSettings;

namespace {

class TraceScattering : public VulkanTest {
  protected:
    SceneRender render{Device()};
};

// Below a surface that neither reflects nor refracts, a medium without an end. Of light from all sides a medium
// that scatters alike in all directions with an albedo of 0.9 returns 1 - H(1) sqrt(0.1) straight up, with
// H(1) = 1.8501 of Chandrasekhar's function (tests/shading/media_test.cpp computes it).
TEST_F(TraceScattering, Trace_MediumReturnsLightByItsAlbedo) {
    scene::Material fog;
    fog.metallicFactor = 0.0f;
    fog.roughnessFactor = 0.0f;
    fog.ior = 1.0f;
    fog.transmissionFactor = 1.0f;
    fog.thicknessFactor = 1.0f;
    fog.attenuationDistance = 0.01f;
    fog.attenuationColor = {0.5f, 0.1f, 0.5f};
    // The color whose single-scattering albedo is 0.9 where light goes on in all directions alike; none of blue
    fog.multiscatterColorFactor = {0.47717f, 0.47717f, 0.0f};
    TraceSettings settings = LookAt({0, 0, 100.0f}, {0, 0, 0}, 1e-5f, 16);
    settings.scattering.brdf = BrdfModel::Gltf;
    render.scene.SetScene(SceneOf({QuadMesh(500.0f, 0)}, {fog}));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    const RenderedImage seen = render.Render(settings, 64);
    const glm::dvec3 error = seen.StandardErrorOfMean();
    const double expected = 1.0 - 1.8501 * std::sqrt(0.1);
    EXPECT_LT(error.x, 0.005);
    EXPECT_NEAR(seen.mean.Mean().x, expected, 4.0 * error.x + 0.003);
    EXPECT_NEAR(seen.mean.Mean().y, expected, 4.0 * error.y + 0.003) << "the denser color";
    EXPECT_EQ(seen.mean.Mean().z, 0.0f);
}

constexpr double kOpticalDepth = 0.8, kHeight = 0.5, kSunCosine = 0.6;

// A medium of index 1, as deep as kOpticalDepth over kHeight; all that it stops is scattered isotropically.
scene::Material Fog() {
    scene::Material fog;
    fog.metallicFactor = 0.0f;
    fog.roughnessFactor = 0.0f;
    fog.ior = 1.0f;
    fog.transmissionFactor = 1.0f;
    fog.thicknessFactor = 1.0f;
    fog.attenuationDistance = float(kHeight);
    fog.attenuationColor = glm::vec3(float(std::exp(-kOpticalDepth)));
    fog.multiscatterColorFactor = {1.0f, 1.0f, 1.0f};
    return fog;
}

// Sun of irradiance 3 that comes down at kSunCosine to z.
scene::Light SlantingSun() {
    const float c = float(kSunCosine), s = float(std::sqrt(1.0 - kSunCosine * kSunCosine));
    scene::Light sun;
    sun.type = scene::LightType::Directional;
    sun.intensity = 3.0f;
    sun.lightToWorld = {{c, 0, -s}, {0, 1, 0}, {s, 0, c}, {0, 0, 0}};
    return sun;
}

// A layer of fog under the sun, over a floor. Of light that is scattered once, straight up,
//     E w p (1 - exp(-depth (1 + 1 / mu))) / (1 + 1 / mu),   p = 1 / (4 pi), w = 1
// with E the irradiance across the sun's direction, of cosine mu.
TEST_F(TraceScattering, Trace_SunShinesIntoFogAndThroughIt) {
    const glm::mat4x3 turned({1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {0, 0, -float(kHeight)});
    for (const float albedo : {0.0f, 0.6f}) {
        scene::Material floor = Lambert(glm::vec3(albedo));
        floor.metallicFactor = 0.0f;
        floor.specularFactor = 0.0f;
        scene::SceneData scene =
            SceneOf({QuadMesh(500.0f, 0), QuadMesh(500.0f, 0), QuadMesh(500.0f, 1)}, {Fog(), floor},
                    {glm::mat4x3(1.0f), turned, Translation({0, 0, -0.7f})});
        scene.lights = {SlantingSun()};
        render.scene.SetScene(std::move(scene));
        TraceSettings settings = LookAt({0, 0, 3.0f}, {0, 0, 0}, 1e-4f, 16);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.biases.maxDepth = 1;
        const RenderedImage seen = render.Render(settings, 64);
        const double path = 1.0 + 1.0 / kSunCosine;
        const double passed = std::exp(-kOpticalDepth * path);
        const double expected =
            3.0 / (4.0 * M_PI) * (1.0 - passed) / path + passed * 3.0 * kSunCosine * double(albedo) / M_PI;
        const glm::dvec3 error = seen.StandardErrorOfMean();
        EXPECT_LT(error.y, 0.01 * expected) << "too noisy to prove anything";
        EXPECT_NEAR(seen.mean.Mean().y, expected, 4.0 * error.y + 1e-3 * expected) << "floor of " << albedo;
    }
}

// Light sampling goes through boundaries only where a scene has such: other glass keeps its pipelines.
TEST_F(TraceScattering, SetScene_OnlyMediaThatLightPassesStraightIntoAreMatched) {
    const auto isMatched = [&](const scene::Material& first, const scene::Material& second) {
        render.scene.SetScene(SceneOf({BoxMesh(1.0f, 0), BoxMesh(0.5f, 1)}, {first, second}));
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        render.renderer.DropFrame();
        return ids.features.Has(kTraceMatchedMedia);
    };
    scene::Material glass = Fog();
    glass.ior = 1.5f;
    glass.multiscatterColorFactor = glm::vec3(0.0f);
    scene::Material milk = Fog();
    milk.ior = 1.5f;
    scene::Material gas = glass;
    gas.ior = 1.0f;
    EXPECT_TRUE(isMatched(Fog(), glass));
    EXPECT_TRUE(isMatched(gas, glass)) << "absorbs alone";
    EXPECT_TRUE(isMatched(glass, milk)) << "of one index";
    EXPECT_FALSE(isMatched(glass, glass));
    EXPECT_FALSE(isMatched(milk, Lambert(glm::vec3(0.5f))));
    milk.ior = 1.4f;
    EXPECT_FALSE(isMatched(glass, milk)) << "refract";
    gas.transmissionFactor = 0.0f;
    EXPECT_FALSE(isMatched(gas, glass)) << "opaque";
}

}  // namespace
}  // namespace raygraph::testing::trace_scattering_test

// KHR_materials_scatter from the file to the picture: media as those of the extension that it replaces, and thin
// sheets by closed form.
namespace raygraph::testing::trace_scatter_test {

using passes::TraceSettings;

namespace {

class TraceScatter : public VulkanTest {
  protected:
    TraceScatter() {
        render.more |= SceneRender::kPlainLobes | kTraceThinScatter | kTraceDiffuseTransmission;
    }

    static TraceSettings Gltf(const glm::vec3& eye, float yFov, uint32_t size) {
        TraceSettings settings = LookAt(eye, {0, 0, 0}, yFov, size);
        settings.scattering.brdf = BrdfModel::Gltf;
        return settings;
    }
    RenderedImage Seen(const scene::Material& material, const TraceSettings& settings, uint32_t sampleCount,
                       const scene::Mesh& mesh) {
        render.scene.SetScene(SceneOf({mesh}, {material}));
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        return render.Render(settings, sampleCount);
    }
    SceneRender render{Device()};
};

// A material of a file, with its first texture.
scene::Material Imported(const Json& extensions, const Json& pbr) {
    GltfDocument document;
    AddTexture(document, test::MakePng(1, 1, {188, 255, 0, 51}));
    document.AddMaterial({{"pbrMetallicRoughness", pbr}, {"extensions", extensions}});
    document.AddTriangle()["material"] = 0;
    return test::Load(document).materials.at(0);
}

Json Sheet(double transmission, const Json& scatter) {
    return {{"KHR_materials_specular", {{"specularFactor", 0.0}}},
            {"KHR_materials_transmission", {{"transmissionFactor", transmission}}},
            {"KHR_materials_scatter", scatter}};
}

}  // namespace

// At full strength it is the medium of KHR_materials_volume_scatter; strength scales the color, not the share that
// scatters.
TEST_F(TraceScatter, Trace_MediumIsThatOfVolumeScatter) {
    const Json pbr = {{"metallicFactor", 0.0}, {"roughnessFactor", 0.3}};
    const TraceSettings settings = Gltf({1, 2, 4}, 0.6f, 24);
    const auto seen = [&](const char* name, const Json& extension) {
        Json extensions = {{"KHR_materials_transmission", {{"transmissionFactor", 0.75}}},
                           {"KHR_materials_volume",
                            {{"thicknessFactor", 1.0},
                             {"attenuationColor", {0.5, 0.25, 0.75}},
                             {"attenuationDistance", 0.5}}}};
        if (!extension.is_null()) extensions[name] = extension;
        return Seen(Imported(extensions, pbr), settings, 2, BoxMesh(1.0f)).mean.values;
    };
    constexpr const char* kOld = "KHR_materials_volume_scatter";
    constexpr const char* kNew = "KHR_materials_scatter";
    const Json color = {0.5, 1.0, 0.25}, halfColor = {0.25, 0.5, 0.125};
    const auto expected = seen(kOld, {{"multiscatterColorFactor", color}, {"scatterAnisotropy", 0.5}});
    const Json whole = {
        {"scatterStrengthFactor", 1.0}, {"multiscatterColorFactor", color}, {"scatterAnisotropy", 0.5}};
    EXPECT_EQ(seen(kNew, whole), expected);
    Json half = whole;
    half["scatterStrengthFactor"] = 0.5;
    EXPECT_EQ(seen(kNew, half),
              seen(kOld, {{"multiscatterColorFactor", halfColor}, {"scatterAnisotropy", 0.5}}));
    Json none = whole;
    none["scatterStrengthFactor"] = 0.0;
    EXPECT_EQ(seen(kNew, none), seen(kOld, {}));
    EXPECT_NE(seen(kNew, half), expected);
    EXPECT_NE(seen(kOld, {}), expected);
}

// A lamp of intensity I at d, beyond the sheet or before it: of the light t that a smooth sheet without a layer would
// transmit the share s is scattered, (1 + g) / 2 of it to the other side in the color c: t s c (1 + g) / 2 I / (pi
// d^2). On the lamp's own side that is (1 - g) / 2, beside (1 - t) of the base color. Metal leaves the rest of it.
// Alpha of a texture scales s, and its color is sRGB: 188 is 0.5. A diffuse transmission is replaced, also where alpha
// is 0.
TEST_F(TraceScatter, Trace_ThinSheetSplitsLightBetweenItsSides) {
    const glm::dvec3 base(0.9, 0.6, 0.3), color(0.2, 0.5, 0.8);
    constexpr double kIntensity = 12.0, kDistance = 2.0;
    struct Row {
        double transmission, strength, meanCosine;
        int alpha = -1;  // of the texture; -1: there is none
        double metallic = 0.0;
        bool isReplacing = false;
    };
    const Row rows[] = {{1.0, 1.0, -0.75},
                        {1.0, 0.5, 0.5, 51},
                        {0.6, 0.5, -0.75},
                        {0.6, 1.0, 0.5, 51},
                        {0.6, 0.5, 0.5, -1, 0.25},
                        {0.6, 0.5, -0.75, -1, 0.0, true},
                        {0.6, 1.0, 0.5, 0, 0.0, true}};
    for (const auto& [transmission, strength, meanCosine, alpha, metallic, isReplacing] : rows) {
        const bool isTextured = alpha >= 0;
        Json scatter = {{"scatterStrengthFactor", strength},
                        {"multiscatterColorFactor", {color.x, color.y, color.z}},
                        {"scatterAnisotropy", meanCosine}};
        if (isTextured)
            scatter["scatterStrengthTexture"]["index"] = scatter["multiscatterColorTexture"]["index"] = 0;
        Json extensions = Sheet(transmission, scatter);
        if (isReplacing) extensions["KHR_materials_diffuse_transmission"]["diffuseTransmissionFactor"] = 0.75;
        const scene::Material sheet = Imported(extensions, {{"metallicFactor", metallic},
                                                            {"roughnessFactor", 0.0},
                                                            {"baseColorFactor", {0.9, 0.6, 0.3, 1.0}}});
        TraceSettings settings = Gltf({0.3f, 0.0f, 4.0f}, 1e-4f, 8);
        settings.biases.maxDepth = 1;
        const double scattered = transmission * strength * (isTextured ? alpha / 255.0 : 1.0);
        const glm::dvec3 tint = isTextured ? color * glm::dvec3(0.5029, 1.0, 0.0) : color;
        for (const float side : {-1.0f, 1.0f}) {
            scene::SceneData scene = SceneOf({QuadMesh(1.0f)}, {sheet});
            if (isTextured) {
                scene.images = {
                    {.name = "texel", .width = 1, .height = 1, .rgba = {188, 255, 0, uint8_t(alpha)}}};
                scene.textures = {{.name = "data", .colorSpace = scene::ColorSpace::Linear},
                                  {.name = "color", .colorSpace = scene::ColorSpace::Srgb}};
                ASSERT_EQ(sheet.scatterStrengthTexture.texture, 0);
                ASSERT_EQ(sheet.scatterColorTexture.texture, 1);
            }
            scene::Light lamp;
            lamp.intensity = float(kIntensity);
            lamp.lightToWorld = Translation({0, 0, side * float(kDistance)});
            scene.lights = {lamp};
            render.scene.SetScene(std::move(scene));
            const glm::dvec3 albedo =
                scattered * tint * (side < 0.0f ? 1.0 + meanCosine : 1.0 - meanCosine) / 2.0 +
                (side < 0.0f ? 0.0 : 1.0 - transmission) * base;
            const glm::dvec3 expected =
                (1.0 - metallic) * albedo * (kIntensity / (std::numbers::pi * kDistance * kDistance));
            // Samples that go straight on see nothing
            const RenderedImage seen = render.Render(settings, 64);
            for (int channel = 0; channel < 3; ++channel) {
                const double error = seen.StandardErrorOfMean()[channel];
                EXPECT_NEAR(seen.mean.Mean()[channel], expected[channel],
                            4.0 * error + 4e-3 * expected[channel] + 1e-6)
                    << "transmission " << transmission << ", strength " << strength << ", mean cosine "
                    << meanCosine << ", alpha " << alpha << ", metallic " << metallic << ", lamp at " << side
                    << ", channel " << channel;
                EXPECT_LE(error, 0.1 * expected[channel] + 1e-6) << "too noisy to prove anything";
            }
        }
    }
}

// White sheets absorb nothing, whatever they do with light, in air or within glass; and one that scatters all of it
// alike to both sides is one of KHR_materials_diffuse_transmission, whatever lies above it.
TEST_F(TraceScatter, Trace_WhiteSheetVanishesAndHalfOfAllIsDiffuseTransmission) {
    const Json pbr = {{"metallicFactor", 0.0}, {"roughnessFactor", 0.5}};
    const TraceSettings settings = Gltf({1, 1, 3}, 0.3f, 16);
    scene::Material glass;
    glass.metallicFactor = glass.roughnessFactor = 0.0f;
    glass.transmissionFactor = glass.thicknessFactor = 1.0f;
    glass.ior = 1.8f;  // not that of the sheet
    for (const double meanCosine : {-0.9, 0.0, 0.9}) {
        Json extensions = Sheet(0.8, {{"scatterStrengthFactor", 0.7}, {"scatterAnisotropy", meanCosine}});
        extensions.erase("KHR_materials_specular");
        const scene::Material sheet = Imported(extensions, pbr);
        for (const bool isInGlass : {false, true}) {
            std::vector<scene::Mesh> meshes{QuadMesh(isInGlass ? 0.9f : 2.0f, 0)};
            if (isInGlass) meshes.push_back(BoxMesh(1.0f, 1));
            render.scene.SetScene(SceneOf(std::move(meshes), {sheet, glass}));
            render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
            const RenderedImage seen = render.Render(settings, 128);
            EXPECT_LT(seen.StandardErrorOfMean().y, 0.003) << "too noisy to prove anything";
            EXPECT_NEAR(seen.mean.Mean().y, 1.0, 0.015) << meanCosine << (isInGlass ? ", in glass" : "");
        }
    }
    Json tinted = pbr;
    tinted["baseColorFactor"] = {0.9, 0.5, 0.2, 1.0};
    const std::pair<const char*, Json> layers[] = {
        {"KHR_materials_specular", {{"specularFactor", 1.0}}},
        {"KHR_materials_clearcoat", {{"clearcoatFactor", 0.8}, {"clearcoatRoughnessFactor", 0.4}}},
        {"KHR_materials_sheen", {{"sheenColorFactor", {0.5, 0.5, 0.5}}, {"sheenRoughnessFactor", 0.5}}}};
    for (const auto& [layer, values] : layers) {
        Json scatter =
            Sheet(1.0, {{"scatterStrengthFactor", 1.0}, {"multiscatterColorFactor", {0.9, 0.5, 0.2}}});
        scatter.erase("KHR_materials_specular");
        Json through = {
            {"KHR_materials_diffuse_transmission",
             {{"diffuseTransmissionFactor", 0.5}, {"diffuseTransmissionColorFactor", {0.9, 0.5, 0.2}}}}};
        scatter[layer] = through[layer] = values;
        const RenderedImage a = Seen(Imported(scatter, pbr), settings, 256, QuadMesh(2.0f));
        const RenderedImage b = Seen(Imported(through, tinted), settings, 256, QuadMesh(2.0f));
        for (int channel = 0; channel < 3; ++channel) {
            const double error =
                std::hypot(a.StandardErrorOfMean()[channel], b.StandardErrorOfMean()[channel]);
            EXPECT_NEAR(a.mean.Mean()[channel], b.mean.Mean()[channel], 4.0 * error + 1e-5)
                << layer << ", channel " << channel;
            EXPECT_LT(error, 0.01) << "too noisy to prove anything";
        }
    }
}

}  // namespace raygraph::testing::trace_scatter_test

// Boundaries of media whose indices are equal, near each other, or infinite, as Trace renders them.
namespace raygraph::testing::trace_boundary_test {

using passes::TraceSettings;

namespace {

class TraceBoundary : public VulkanTest {
  protected:
    static TraceSettings FaceOn() {
        TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 0.2f, 16);
        settings.scattering.brdf = BrdfModel::Gltf;
        return settings;
    }

    SceneRender render{Device()};
};

}  // namespace

// Side by side: an opaque sheet, one that lets light through, and the face of a volume.
TEST_F(TraceBoundary, Trace_IndexZeroReflectsAllAndWithAVolumeToo) {
    std::vector<scene::Material> materials(3);
    for (size_t i = 0; i < materials.size(); ++i) {
        materials[i].baseColorFactor = {0.1f, 0.2f, 0.3f, 1.0f};
        materials[i].metallicFactor = 0.0f;
        materials[i].roughnessFactor = 0.0f;
        materials[i].ior = 0.0f;
        materials[i].transmissionFactor = i > 0 ? 1.0f : 0.0f;
        materials[i].thicknessFactor = i > 1 ? 1.0f : 0.0f;
    }
    render.scene.SetScene(SceneOf({QuadMesh(0.5f, 0), QuadMesh(0.5f, 1), QuadMesh(0.5f, 2)}, materials,
                                  {Translation({-1, 0, 0}), glm::mat4x3(1.0f), Translation({1, 0, 0})}));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    for (const FresnelModel model : {FresnelModel::Schlick, FresnelModel::Dielectric}) {
        TraceSettings settings = FaceOn();
        settings.camera = LookAt({0, 0, 4}, {0, 0, 0}, 0.7f, 16).camera;
        settings.scattering.fresnel = model;
        // Where no sheet is the environment is, and as bright
        for (const glm::vec4& texel : render.Render(settings, 4).mean.values)
            for (int c = 0; c < 3; ++c) ASSERT_NEAR(texel[c], 1.0f, 1e-4f) << static_cast<int>(model);
    }
}

// Over black, seen at 80 degrees: all light is the environment's, mirrored in the sheet.
TEST_F(TraceBoundary, Trace_SheetOfTheIndexOfAirMirrorsNothing) {
    scene::Material sheet;
    sheet.metallicFactor = 0.0f;
    sheet.roughnessFactor = 0.0f;
    sheet.transmissionFactor = 1.0f;
    scene::Material black;
    black.baseColorFactor = {0, 0, 0, 1};
    black.metallicFactor = 0.0f;
    black.specularFactor = 0.0f;
    const double angle = 80.0 * 3.14159265358979 / 180.0;
    TraceSettings settings = FaceOn();
    settings.camera =
        LookAt(100.0f * glm::vec3(std::sin(angle), 0.0f, std::cos(angle)), {0, 0, 0}, 1e-4f, 8).camera;
    settings.extent = {64, 64};
    const auto mirrored = [&](float ior) {
        sheet.ior = ior;
        render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), QuadMesh(50.0f, 1)}, {sheet, black},
                                      {glm::mat4x3(1.0f), Translation({0, 0, -0.5f})}));
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        return render.Render(settings, 1).mean.Mean().y;
    };
    EXPECT_EQ(mirrored(1.0f), 0.0);
    const double schlick = 0.04 + 0.96 * std::pow(1.0 - std::cos(angle), 5.0);
    EXPECT_NEAR(mirrored(1.5f), schlick, 0.04);
}

}  // namespace raygraph::testing::trace_boundary_test

// Light that goes straight through smooth thin walls: found by light sampling, and by paths that cross them,
// as if the wall was a hole for a share of the light.
namespace raygraph::testing::trace_thin_walls_test {

using passes::TraceSettings;

namespace {

constexpr double kTolerance = 0.005;
const glm::vec3 kAlbedo(0.8f, 0.6f, 0.4f);
const glm::vec3 kTint(0.9f, 0.5f, 0.7f);

// Diffuse, and nothing else.
scene::Material Chalk(const glm::vec3& albedo) {
    scene::Material material = Lambert(albedo);
    material.metallicFactor = 0.0f;
    material.specularFactor = 0.0f;
    return material;
}

scene::Material Pane(const glm::vec3& tint = kTint) {
    scene::Material material;
    material.baseColorFactor = glm::vec4(tint, 1.0f);
    material.metallicFactor = 0.0f;
    material.roughnessFactor = 0.0f;
    material.transmissionFactor = 1.0f;
    return material;
}

// Share of light that a pane of index 1.5 does not reflect, by Schlick's curve.
double Passed(double cosine) {
    return 0.96 * (1.0 - std::pow(1.0 - cosine, 5.0));
}

// Shines along -z.
scene::Light Sun(float illuminance) {
    scene::Light light;
    light.type = scene::LightType::Directional;
    light.intensity = illuminance;
    return light;
}

scene::Light Bulb(float intensity, const glm::vec3& position) {
    scene::Light light;
    light.intensity = intensity;
    light.lightToWorld = Translation(position);
    return light;
}

class TraceThinWalls : public VulkanTest {
  protected:
    TraceThinWalls() { render.more |= SceneRender::kPlainLobes | kTraceThinWalls | kTraceAnyHit; }

    // A chalk floor in the plane z = 0 under panes (material 1) that fill the planes at these heights.
    void SetFloorUnder(const std::vector<float>& heights, const scene::Light& light,
                       const scene::Material& pane = Pane(), float halfSize = 1.0f) {
        std::vector<scene::Mesh> meshes{QuadMesh(halfSize, 0)};
        std::vector<glm::mat4x3> transforms{glm::mat4x3(1.0f)};
        for (const float height : heights) {
            meshes.push_back(QuadMesh(halfSize, 1));
            transforms.push_back(Translation({0, 0, height}));
        }
        scene::SceneData scene = SceneOf(std::move(meshes), {Chalk(kAlbedo), pane}, transforms);
        scene.lights = {light};
        render.scene.SetScene(std::move(scene));
    }
    // The middle of the floor from between it and a pane at 0.5, or from above one. All pixels see the same:
    // many of them make many samples in few frames.
    static TraceSettings View(float height = 0.25f, uint32_t maxDepth = 1, uint32_t size = 8) {
        TraceSettings settings = LookAt({0, 0, height}, {0, 0, 0}, 1e-3f, size);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.biases.maxDepth = maxDepth;
        return settings;
    }
    void ExpectRadiance(const TraceSettings& settings, uint32_t samples, const glm::dvec3& expected) {
        const RenderedImage image = render.Render(settings, samples);
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(image.mean.Mean()[channel], expected[channel], kTolerance * expected[channel])
                << "channel " << channel;
        EXPECT_LE(3.0 * image.StandardErrorOfMean().y, kTolerance * expected.y)
            << "too noisy to prove anything";
    }

    SceneRender render{Device()};
};

}  // namespace

TEST_F(TraceThinWalls, Trace_SunThroughPanesIsDimmedByTheReflectionAndTintOfEach) {
    for (const int count : {1, 2, 5}) {
        std::vector<float> heights;
        for (int i = 0; i < count; ++i) heights.push_back(0.5f + 0.1f * float(i));
        SetFloorUnder(heights, Sun(3.0f));
        const glm::dvec3 passed = glm::pow(glm::dvec3(kTint) * 0.96, glm::dvec3(count));
        ExpectRadiance(View(), 1, glm::dvec3(kAlbedo) * passed * (3.0 / M_PI));
    }
    // Under the middle of quads, many shadow rays go through the edge between two triangles: one wall
    SetFloorUnder({0.5f}, Sun(3.0f), Pane(glm::vec3(0.01f)));
    for (const glm::vec4& texel : render.Render(View(), 1).mean.values)
        EXPECT_NEAR(texel.x, kAlbedo.x * 0.01 * 3.0 * 0.96 / M_PI, 0.005 * texel.x);
}

// A floor without an end under a pane without an end, which reflects the share R of what a diffuse surface
// sends: the floor's irradiance E is that of the sun and the floor's own, R albedo E.
TEST_F(TraceThinWalls, Trace_FloorAndPaneReflectEachOther) {
    SetFloorUnder({0.01f}, Sun(3.0f), Pane(), 100.0f);
    const double reflected = 0.04 + 0.96 / 21.0;
    const glm::dvec3 albedo(kAlbedo);
    const glm::dvec3 irradiance = glm::dvec3(kTint) * (3.0 * 0.96) / (1.0 - reflected * albedo);
    ExpectRadiance(View(0.005f, passes::kNoDepthLimit, 64), 16, albedo * irradiance / M_PI);
}

TEST_F(TraceThinWalls, Trace_PointLightThroughAPaneIsDimmedByItsAngle) {
    SetFloorUnder({0.5f}, Bulb(7.0f, {0, 0, 2}));
    ExpectRadiance(View(), 1, glm::dvec3(kAlbedo * kTint) * (7.0 / 4.0 * 0.96 / M_PI));
    SetFloorUnder({0.25f}, Bulb(7.0f, {0, 4, 3}), Pane(), 10.0f);
    ExpectRadiance(View(0.2f), 1, glm::dvec3(kAlbedo * kTint) * (7.0 * 0.6 / 25.0 * Passed(0.6) / M_PI));
}

TEST_F(TraceThinWalls, Trace_CrossingCostsNoDepth) {
    // The camera above two panes sees the floor under them by the light of one bounce
    SetFloorUnder({0.5f, 0.6f}, Sun(3.0f));
    const glm::dvec3 passed = glm::pow(glm::dvec3(kTint) * 0.96, glm::dvec3(2));
    ExpectRadiance(View(0.9f, 1, 64), 32, glm::dvec3(kAlbedo) * passed * passed * (3.0 / M_PI));
    // And what emits behind them by that of none
    render.scene.SetMaterial(0, Lambert(glm::vec3(0.0f), glm::vec3(2.0f)));
    ExpectRadiance(View(0.9f, 0, 64), 32, 2.0 * passed);
}

TEST_F(TraceThinWalls, Trace_RoughWallsAndVolumesStopShadowRays) {
    scene::Material rough = Pane(), volume = Pane();
    rough.roughnessFactor = 0.2f;
    volume.thicknessFactor = 1.0f;
    for (const scene::Material& material : {rough, volume}) {
        SetFloorUnder({0.5f}, Sun(3.0f), material);
        EXPECT_EQ(render.Render(View(), 4).mean.Mean(), glm::dvec3(0.0));
    }
}

TEST_F(TraceThinWalls, Trace_PartlyTransmissivePaneWithAlphaIsDimmedByAll) {
    scene::Material pane = Pane();
    pane.transmissionFactor = 0.7f;
    pane.metallicFactor = 0.2f;
    pane.alphaMode = scene::AlphaMode::Blend;
    pane.baseColorFactor.a = 0.6f;
    // A shadow ray loses the part that the sheet scatters.
    for (const float strength : {0.0f, 0.25f}) {
        pane.scatterStrengthFactor = strength;
        SetFloorUnder({0.5f}, Sun(3.0f), pane);
        const glm::dvec3 passed = 0.4 + 0.6 * 0.8 * 0.7 * 0.96 * (1.0 - strength) * glm::dvec3(kTint);
        ExpectRadiance(View(0.25f, 1, 64), 64, glm::dvec3(kAlbedo) * passed * (3.0 / M_PI));
    }
}

// A lamp above a pane above a floor; a second pane stands beside it, half diffuse. tests/long has the rest of
// the strategies.
TEST_F(TraceThinWalls, Trace_HowLightIsFoundThroughPanesLeavesTheImage) {
    scene::Material milky = Pane({0.6f, 0.8f, 0.9f});
    milky.transmissionFactor = 0.5f;
    const glm::mat4x3 upright({1, 0, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0.6f, 0.4f});
    const glm::mat4x3 lamp({1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {0.1f, 0.2f, 1.2f});
    render.scene.SetScene(
        SceneOf({QuadMesh(1.0f, 0), QuadMesh(0.8f, 1), QuadMesh(0.4f, 2), QuadMesh(0.3f, 3)},
                {Chalk(kAlbedo), Pane(), milky, Lambert(glm::vec3(0.0f), glm::vec3(5.0f))},
                {glm::mat4x3(1.0f), Translation({0, 0, 0.8f}), upright, lamp}));
    render.scene.SetEnvironment({.radiance = glm::vec3(0.1f)});
    TraceSettings settings = LookAt({0.3f, -1.6f, 0.5f}, {0, 0, 0.3f}, 0.7f, 32);
    settings.scattering.brdf = BrdfModel::Gltf;
    for (const uint32_t maxDepth : {1u, 4u}) {
        settings.biases.maxDepth = maxDepth;
        settings.lights = {};
        settings.seed = 0;
        const RenderedImage reference = render.Render(settings, 192);
        settings.seed = 1;
        if (maxDepth == 1) {
            settings.lights.mis = MisHeuristic::Off;
            ExpectSameImage(render.Render(settings, 96), reference, "light sampling alone");
        }
        settings.lights.isOn = false;
        ExpectSameImage(render.Render(settings, 384), reference, "BSDF sampling alone");
    }
}

TEST_F(TraceThinWalls, SetMaterial_MakesAWallThatSunGoesThrough) {
    // One-sided, with its back to the floor: to rays from there it is not there at all
    scene::Material wall = Chalk(glm::vec3(0.5f));
    wall.isDoubleSided = false;
    const glm::dvec3 lit = glm::dvec3(kAlbedo) * (3.0 / M_PI);
    SetFloorUnder({0.5f}, Sun(3.0f), wall);
    ExpectRadiance(View(), 1, lit);
    render.scene.SetMaterial(1, Pane());
    ExpectRadiance(View(), 1, lit * 0.96 * glm::dvec3(kTint));
    wall.isDoubleSided = true;
    render.scene.SetMaterial(1, wall);
    EXPECT_EQ(render.Render(View(), 1).mean.Mean(), glm::dvec3(0.0));
    render.scene.SetMaterial(1, Pane(glm::vec3(1.0f)));
    ExpectRadiance(View(), 1, lit * 0.96);
    wall.isDoubleSided = false;
    render.scene.SetMaterial(1, wall);
    ExpectRadiance(View(), 1, lit);
}

TEST_F(TraceThinWalls, SetMaterial_LeavesTheOtherWallsOfAMesh) {
    // A mesh of two one-sided walls, of which one becomes a pane
    scene::Material wall = Chalk(glm::vec3(0.5f));
    wall.isDoubleSided = false;
    scene::Mesh mesh = QuadMesh(0.5f, 1);
    scene::Primitive other = QuadMesh(0.5f, 2).primitives[0];
    for (glm::vec3& position : other.positions) position.x += 1.0f;
    other.bounds.min.x += 1.0f;
    other.bounds.max.x += 1.0f;
    mesh.primitives.push_back(other);
    for (const bool isTurned : {false, true}) {
        const glm::mat4x3 turned({1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {0, 0, 0.5f});
        scene::SceneData scene = SceneOf({QuadMesh(3.0f, 0), mesh}, {Chalk(kAlbedo), wall, wall},
                                         {glm::mat4x3(1.0f), isTurned ? turned : Translation({0, 0, 0.5f})});
        scene.lights = {Sun(3.0f)};
        render.scene.SetScene(std::move(scene));
        render.scene.SetMaterial(1, Pane());
        TraceSettings beside = View();
        beside.camera.origin.x += 1.0f;
        const glm::dvec3 lit = glm::dvec3(kAlbedo) * (3.0 / M_PI);
        ExpectRadiance(View(), 1, lit * 0.96 * glm::dvec3(kTint));
        if (isTurned)
            EXPECT_EQ(render.Render(beside, 1).mean.Mean(), glm::dvec3(0.0));
        else
            ExpectRadiance(beside, 1, lit);
    }
}

}  // namespace raygraph::testing::trace_thin_walls_test
