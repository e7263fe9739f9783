// KHR_materials_scatter from the file to the picture: media as those of the extension that it replaces, and thin
// sheets by closed form.
#include <cmath>
#include <numbers>

#include "tests/passes/gltf_square.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_scatter_test {

using passes::TraceSettings;

namespace {

class TraceScatter : public VulkanTest {
  protected:
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
