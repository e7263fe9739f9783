#include <gtest/gtest.h>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "passes/raster.h"
#include "passes/views.h"
#include "renderer/gpu_scene/deform/deform_set.h"
#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/instances/group_kinds.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "renderer/gpu_scene/materials/scene_materials.h"
#include "shaders/shared/trace_options.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/reference_assets.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

// glTF materials on the device: energy, alpha, media and what the file's flags say.
namespace raygraph::testing::trace_materials_test {

using passes::TraceSettings;

namespace {

class TraceMaterials : public VulkanTest {
  protected:
    TraceMaterials() { render.more |= SceneRender::kPlainLobes; }

    // The mean radiance of the pixels that show a body in an environment of unit radiance. Where the picture
    // shows the environment, it is 1 and tells nothing.
    glm::dvec3 InUnitEnvironment(scene::Mesh mesh, const scene::Material& material,
                                 const TraceSettings& settings, uint32_t samples) {
        render.scene.SetScene(SceneOf({std::move(mesh)}, {material}));
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        const RenderedImage image = render.Render(settings, samples);
        double covered = 0.0;
        for (const glm::vec4& texel : image.mean.values)
            covered += texel.w / double(image.mean.values.size());
        EXPECT_LT(4.0 * image.StandardErrorOfMean().y, 0.02 * covered) << "too noisy to prove anything";
        return 1.0 + (image.mean.Mean() - 1.0) / covered;
    }
    static TraceSettings Gltf(const glm::vec3& eye, const glm::vec3& target, float yFov, uint32_t size) {
        TraceSettings settings = LookAt(eye, target, yFov, size);
        settings.scattering.brdf = BrdfModel::Gltf;
        return settings;
    }

    SceneRender render{Device()};
};

scene::Material Metal(float roughness, const glm::vec3& color = glm::vec3(1.0f)) {
    scene::Material material;
    material.baseColorFactor = glm::vec4(color, 1.0f);
    material.metallicFactor = 1.0f;
    material.roughnessFactor = roughness;
    material.isDoubleSided = true;
    return material;
}

scene::Material Glass(float roughness, float ior, float thickness) {
    scene::Material material;
    material.metallicFactor = 0.0f;
    material.roughnessFactor = roughness;
    material.transmissionFactor = 1.0f;
    material.ior = ior;
    material.thicknessFactor = thickness;
    return material;
}

// A camera far off that sees the middle of a quad of the xy plane at an angle whose cosine is given.
glm::vec3 EyeAt(float cosTheta) {
    return 100.0f * glm::vec3(std::sqrt(1.0f - cosTheta * cosTheta), 0.0f, cosTheta);
}

}  // namespace

TEST_F(TraceMaterials, Trace_WhiteMetalHasTheAlbedoOfQuadrature) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    std::ifstream file(*test::ReferenceAssets() / "references/ggx_white_metal_albedo.json");
    const nlohmann::json table = nlohmann::json::parse(file);
    for (const auto& [key, value] : table.items()) {
        const float roughness = std::stof(key), cosTheta = std::stof(key.substr(key.find(',') + 1));
        for (const auto& [masking, name] :
             {std::pair(MaskingModel::Correlated, "corr"), std::pair(MaskingModel::Separable, "sep")}) {
            TraceSettings settings = Gltf(EyeAt(cosTheta), {0, 0, 0}, 1e-4f, 16);
            settings.scattering.multiscatter = MultiscatterKind::Off;
            settings.scattering.masking = masking;
            const glm::dvec3 albedo = InUnitEnvironment(QuadMesh(1.0f), Metal(roughness), settings, 64);
            const double expected = value[name];
            EXPECT_NEAR(albedo.y, expected, 0.003 * expected) << key << ", " << name;
        }
    }
}

TEST_F(TraceMaterials, Trace_WhiteMetalReturnsAllLightWithMultiscatter) {
    for (const float roughness : {0.0f, 0.3f, 0.7f, 1.0f})
        for (const float cosTheta : {0.9f, 0.3f}) {
            TraceSettings settings = Gltf(EyeAt(cosTheta), {0, 0, 0}, 1e-4f, 64);
            settings.scattering.multiscatter = MultiscatterKind::Lut;
            EXPECT_NEAR(InUnitEnvironment(QuadMesh(1.0f), Metal(roughness), settings, 16).y, 1.0, 0.015)
                << "lut, roughness " << roughness << ", cosine " << cosTheta;
            // Every walk that leaves a white metal brings all: no noise
            settings.scattering.multiscatter = MultiscatterKind::Walk;
            settings.lights.isOn = false;
            EXPECT_NEAR(InUnitEnvironment(QuadMesh(1.0f), Metal(roughness), settings, 4).y, 1.0, 1e-4)
                << "walk, roughness " << roughness << ", cosine " << cosTheta;
        }
}

// Light sampling asks walks for estimates of f, which are noisy.
TEST_F(TraceMaterials, Trace_WalksTowardsSampledLightsReturnAllLight) {
    TraceSettings settings = Gltf(EyeAt(0.3f), {0, 0, 0}, 1e-4f, 64);
    settings.scattering.multiscatter = MultiscatterKind::Walk;
    EXPECT_NEAR(InUnitEnvironment(QuadMesh(1.0f), Metal(0.7f), settings, 64).y, 1.0, 0.005);
}

TEST_F(TraceMaterials, Trace_WhiteDielectricReturnsAllLight) {
    for (const float roughness : {0.0f, 0.5f, 1.0f}) {
        scene::Material material;
        material.metallicFactor = 0.0f;
        material.roughnessFactor = roughness;
        const TraceSettings settings = Gltf({0, 0, 4}, {0, 0, 0}, 0.45f, 48);
        EXPECT_NEAR(InUnitEnvironment(SphereMesh(1.0f, 64), material, settings, 48).y, 1.0, 0.015)
            << "roughness " << roughness;
    }
}

// Pipelines have only the lobes of the scene's materials: an edit brings new ones, and takes old ones away.
TEST_F(TraceMaterials, Trace_LobesComeAndGoWithTheMaterial) {
    render.more = {};
    render.scene.SetScene(SceneOf({QuadMesh(10.0f)}, {Glass(0.0f, 1.5f, 0.0f)}));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    const TraceSettings settings = Gltf(EyeAt(0.8f), {0, 0, 0}, 1e-4f, 8);
    scene::Material plastic = Metal(0.4f);
    plastic.metallicFactor = 0.0f;
    scene::Material blend = plastic;
    blend.metallicFactor = 0.5f;
    blend.transmissionFactor = 0.5f;
    for (const scene::Material& material :
         {Metal(0.4f), plastic, Glass(0.0f, 1.5f, 0.0f), blend, Metal(0.0f), plastic}) {
        render.scene.SetMaterial(0, material);
        EXPECT_NEAR(render.Render(settings, 64).mean.Mean().y, 1.0, 0.02)
            << "metallic " << material.metallicFactor << " transmission " << material.transmissionFactor;
    }
}

// A pipeline takes a CPU a second: there is none for lobes that are not shaded.
TEST_F(TraceMaterials, Trace_ModelsWithoutLobesAndUnlitMaterialsNeedNoOtherPipeline) {
    Renderer renderer(Device());
    GpuScene scene(renderer);
    scene.SetScene(SceneOf({QuadMesh(10.0f)}, {Metal(0.4f)}));
    scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings settings = Gltf(EyeAt(0.8f), {0, 0, 0}, 1e-4f, 8);
    const auto pipelines = [&](const scene::Material& material, BrdfModel brdf) {
        scene.SetMaterial(0, material);
        settings.scattering.brdf = brdf;
        renderer.BeginFrame();
        const SceneIds ids = scene.Declare(renderer);
        renderer.ReadBack(passes::Trace(renderer, ids, settings).radiance);
        renderer.Execute();
        return renderer.PipelineCount();
    };
    scene::Material plastic = Metal(0.4f);
    plastic.metallicFactor = 0.0f;
    const uint32_t lambert = pipelines(Metal(0.4f), BrdfModel::Lambert);
    for (const scene::Material& material : {plastic, Glass(0.4f, 1.5f, 0.0f)})
        EXPECT_EQ(pipelines(material, BrdfModel::Lambert), lambert);

    scene::Material unlit = Metal(0.4f);
    unlit.isUnlit = true;
    scene::Material unlitGlass = Glass(0.4f, 1.5f, 0.0f);
    unlitGlass.isUnlit = true;
    const uint32_t withUnlit = pipelines(unlit, BrdfModel::Gltf);
    EXPECT_EQ(pipelines(unlitGlass, BrdfModel::Gltf), withUnlit);
    EXPECT_GT(pipelines(plastic, BrdfModel::Gltf), withUnlit);
}

// Files carry materials that no triangle of theirs has.
TEST_F(TraceMaterials, Trace_MaterialsThatNothingUsesNeedNoOtherPipeline) {
    Renderer renderer(Device());
    GpuScene scene(renderer);
    const auto pipelines = [&](std::vector<scene::Material> materials) {
        scene.SetScene(SceneOf({QuadMesh(10.0f)}, std::move(materials)));
        scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        renderer.BeginFrame();
        const SceneIds ids = scene.Declare(renderer);
        renderer.ReadBack(passes::Trace(renderer, ids, Gltf(EyeAt(0.8f), {0, 0, 0}, 1e-4f, 8)).radiance);
        renderer.Execute();
        return renderer.PipelineCount();
    };
    scene::Material volume = Glass(0.0f, 1.5f, 1.0f);
    ASSERT_TRUE(volume.BoundsMedium());
    const uint32_t metal = pipelines({Metal(0.4f)});
    EXPECT_EQ(pipelines({Metal(0.4f), volume}), metal);
    scene::Material metalOnly = Metal(0.4f);
    metalOnly.transmissionFactor = 1.0f;  // of its dielectric share, which is 0
    metalOnly.roughnessFactor = 0.9f;
    EXPECT_EQ(pipelines({metalOnly}), metal);
    EXPECT_GT(pipelines({volume}), metal);
}

TEST_F(TraceMaterials, Trace_SmoothGlassSphereVanishesInUnitEnvironment) {
    const TraceSettings settings = Gltf({0, 0, 4}, {0, 0, 0}, 0.7f, 48);
    for (const float ior : {1.1f, 1.5f, 2.4f}) {
        const glm::dvec3 seen = InUnitEnvironment(SphereMesh(1.0f, 48), Glass(0.0f, ior, 1.0f), settings, 16);
        EXPECT_NEAR(seen.y, 1.0, 0.005) << "ior " << ior;
    }
}

TEST_F(TraceMaterials, Trace_RoughGlassSphereVanishesInUnitEnvironment) {
    TraceSettings settings = Gltf({0, 0, 4}, {0, 0, 0}, 0.7f, 48);
    for (const float roughness : {0.3f, 0.8f}) {
        const uint32_t samples = roughness < 0.5f ? 32 : 128;  // few paths scatter often in the smoother one
        settings.scattering.multiscatter = MultiscatterKind::Lut;
        EXPECT_NEAR(
            InUnitEnvironment(SphereMesh(1.0f, 48), Glass(roughness, 1.5f, 1.0f), settings, samples).y, 1.0,
            0.02)
            << "lut, roughness " << roughness;
        settings.scattering.multiscatter = MultiscatterKind::Walk;
        EXPECT_NEAR(
            InUnitEnvironment(SphereMesh(1.0f, 48), Glass(roughness, 1.5f, 1.0f), settings, samples).y, 1.0,
            0.01)
            << "walk, roughness " << roughness;
    }
}

// The environment is beyond every distance: what is clear passes its light, what is not passes none. The
// radiance of light that comes out of a denser medium is less by the square of the index.
TEST_F(TraceMaterials, Trace_VolumeWithoutAnEndIsClearOrBlack) {
    const TraceSettings settings = Gltf({0, 0, 4}, {0, 0, 0}, 0.2f, 64);
    scene::Material glass = Glass(0.0f, 1.5f, 1.0f);
    const double clear = 0.04 + 0.96 / (1.5 * 1.5);
    EXPECT_NEAR(InUnitEnvironment(QuadMesh(1.0f), glass, settings, 8).y, clear, 0.004);
    glass.attenuationDistance = 0.1f;
    glass.attenuationColor = {1.0f, 0.5f, 0.9f};
    const glm::dvec3 tinted = InUnitEnvironment(QuadMesh(1.0f), glass, settings, 8);
    EXPECT_NEAR(tinted.x, clear, 0.004);
    EXPECT_NEAR(tinted.y, 0.04, 0.004) << "reflected at the first surface";
    EXPECT_NEAR(tinted.z, 0.04, 0.004);
}

TEST_F(TraceMaterials, Trace_ThinWallPassesWhatItDoesNotReflect) {
    const TraceSettings settings = Gltf({0, 0, 4}, {0, 0, 0}, 0.2f, 32);
    const glm::dvec3 seen = InUnitEnvironment(QuadMesh(1.0f), Glass(0.0f, 1.5f, 0.0f), settings, 16);
    EXPECT_NEAR(seen.y, 1.0, 1e-3);
    // Tinted, with no light on the viewer's side but what comes through
    scene::Material tinted = Glass(0.0f, 1.5f, 0.0f);
    tinted.baseColorFactor = {0.25f, 0.5f, 1.0f, 1.0f};
    render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), QuadMesh(3.0f, 1)},
                                  {tinted, Lambert(glm::vec3(0.0f), glm::vec3(2.0f))},
                                  {glm::mat4x3(1.0f), Translation({0, 0, -1})}));
    render.scene.SetEnvironment({.radiance = glm::vec3(0.0f)});
    const glm::dvec3 through = render.Render(settings, 32).mean.Mean();
    const double passed = 2.0 * (1.0 - 0.04);
    EXPECT_NEAR(through.x, 0.25 * passed, 0.01 * passed);
    EXPECT_NEAR(through.y, 0.5 * passed, 0.01 * passed);
    EXPECT_NEAR(through.z, passed, 0.01 * passed);
}

TEST_F(TraceMaterials, Trace_CameraInsideAMediumLooksThroughIt) {
    scene::Material medium = Glass(0.0f, 1.0f, 1.0f);
    medium.attenuationColor = glm::vec3(0.5f);
    medium.attenuationDistance = 1.0f;
    const TraceSettings settings = Gltf({0, 0, 0.5f}, {0, 0, -1}, 0.01f, 16);
    EXPECT_NEAR(InUnitEnvironment(BoxMesh(1.0f), medium, settings, 16).y, std::pow(0.5, 1.5), 0.005);
}

TEST_F(TraceMaterials, Trace_MediumOfHigherPriorityIsThereWhereTwoOverlap) {
    // Boxes from z = -1 to 1 and from 0 to 2 seen along z: 1 m of the first alone, 1 m of both, 1 m of the
    // second alone
    const double first = 0.5, second = 0.8;  // of what passes a meter
    for (const uint32_t priority : {0u, 2u}) {
        scene::Material a = Glass(0.0f, 1.0f, 1.0f), b = a;
        a.attenuationColor = glm::vec3(float(first));
        b.attenuationColor = glm::vec3(float(second));
        a.attenuationDistance = b.attenuationDistance = 1.0f;
        a.priority = priority;
        b.priority = 1;
        render.scene.SetScene(SceneOf({BoxMesh(1.0f, 0), BoxMesh(1.0f, 1)}, {a, b},
                                      {glm::mat4x3(1.0f), Translation({0, 0, 1})}));
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        const double expected = first * second * (priority > 1 ? first : second);
        TraceSettings settings = Gltf({0, 0, 20}, {0, 0, 0}, 0.01f, 8);
        settings.roulette.kind = Roulette::Off;
        EXPECT_NEAR(render.Render(settings, 16).mean.Mean().y, expected, 1e-4 * expected)
            << "priority of the first: " << priority;
    }
}

TEST_F(TraceMaterials, Trace_BlendStopsItsShareOfRaysOfBothKinds) {
    scene::Material card = Lambert(glm::vec3(0.0f), glm::vec3(1.0f));
    card.alphaMode = scene::AlphaMode::Blend;
    card.baseColorFactor = {0.0f, 0.0f, 0.0f, 0.25f};
    render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), QuadMesh(3.0f, 1)},
                                  {card, Lambert(glm::vec3(0.0f), glm::vec3(3.0f))},
                                  {glm::mat4x3(1.0f), Translation({0, 0, -1})}));
    const double seen = render.Render(LookAt({0, 0, 4}, {0, 0, 0}, 0.1f, 64), 64).mean.Mean().y;
    EXPECT_NEAR(seen, 0.25 * 1.0 + 0.75 * 3.0, 0.01);

    // The card's shadow on a floor under a point light passes three quarters
    card.emissiveFactor = glm::vec3(0.0f);
    scene::SceneData scene =
        SceneOf({QuadMesh(0.001f, 1), QuadMesh(0.2f, 0)}, {card, Lambert(glm::vec3(1.0f))},
                {glm::mat4x3(1.0f), Translation({0, 0, 1})});
    scene::Light light;
    light.intensity = 4.0f;
    light.lightToWorld = Translation({0, 0, 2});
    scene.lights = {light};
    render.scene.SetScene(std::move(scene));
    TraceSettings settings = LookAt({0.5f, 0.0f, 0.5f}, {0, 0, 0}, 0.0005f, 32);
    settings.biases.maxDepth = 1;
    EXPECT_NEAR(render.Render(settings, 64).mean.Mean().y, 0.75 / M_PI, 0.01 / M_PI);
}

TEST_F(TraceMaterials, Trace_MaskStopsAllOrNothing) {
    scene::Material card = Lambert(glm::vec3(0.0f), glm::vec3(1.0f));
    card.alphaMode = scene::AlphaMode::Mask;
    for (const float alpha : {0.39f, 0.41f}) {
        card.alphaCutoff = 0.4f;
        card.baseColorFactor.w = alpha;
        render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {card}));
        render.scene.SetEnvironment(
            {});  // A card that is cut away shows nothing, and so the studio lights it.
        EXPECT_EQ(render.Render(LookAt({0, 0, 4}, {0, 0, 0}, 0.1f, 8), 4).mean.Mean().y,
                  alpha > 0.4f ? 1.0 : 0.0);
    }
}

TEST_F(TraceMaterials, Trace_UnlitShowsItsBaseColorAndNothingElse) {
    scene::Material material = Lambert(glm::vec3(0.2f, 0.4f, 0.6f), glm::vec3(7.0f));
    material.isUnlit = true;
    const glm::dvec3 seen =
        InUnitEnvironment(QuadMesh(1.0f), material, Gltf({0, 0, 4}, {0, 0, 0}, 0.1f, 4), 4);
    EXPECT_NEAR(seen.x, 0.2, 1e-6);
    EXPECT_NEAR(seen.y, 0.4, 1e-6);
    EXPECT_NEAR(seen.z, 0.6, 1e-6);
}

TEST_F(TraceMaterials, Trace_LafortuneKeepsItsShares) {
    TraceSettings settings = Gltf({0, 0, 4}, {0, 0, 0}, 0.2f, 32);
    settings.scattering.brdf = BrdfModel::Lafortune;
    scene::Material material = Metal(0.5f, glm::vec3(0.7f));
    const double metal = InUnitEnvironment(QuadMesh(1.0f), material, settings, 64).y;
    EXPECT_LE(metal, 0.7 + 1e-3);
    EXPECT_GT(metal, 0.6) << "face on, little of the lobe is cut off by the surface";
}

// All combinations: tests/long.
TEST_F(TraceMaterials, Trace_MicrofacetModelsLoseOnlyLight) {
    struct Models {
        MicrofacetModel distribution;
        MaskingModel masking;
        FresnelModel fresnel;
    };
    for (const auto& [distribution, masking, fresnel] :
         {Models{MicrofacetModel::Beckmann, MaskingModel::Separable, FresnelModel::Lazanyi},
          Models{MicrofacetModel::Phong, MaskingModel::Shortcut, FresnelModel::Schlick}}) {
        TraceSettings settings = Gltf(EyeAt(0.8f), {0, 0, 0}, 1e-4f, 16);
        settings.scattering.distribution = distribution;
        settings.scattering.masking = masking;
        settings.scattering.fresnel = fresnel;
        settings.scattering.multiscatter = MultiscatterKind::Off;
        const double albedo = InUnitEnvironment(QuadMesh(1.0f), Metal(0.4f), settings, 32).y;
        EXPECT_LT(albedo, masking == MaskingModel::Shortcut ? 1.1 : 1.005) << int(distribution);
        EXPECT_GT(albedo, 0.8) << int(distribution);
    }
}

}  // namespace raygraph::testing::trace_materials_test

// KHR_materials_pbrSpecularGlossiness, from the file to what is seen.
namespace raygraph::testing::glossiness_test {

namespace {

using test::GltfDocument;
using test::Json;

constexpr const char* kExtension = "KHR_materials_pbrSpecularGlossiness";
constexpr uint8_t kSpecular[2][4] = {{60, 130, 190, 90}, {210, 70, 110, 160}};  // and glossiness

class Glossiness : public VulkanTest {
  protected:
    Glossiness() { render.more |= SceneRender::kPlainLobes; }

    // A square that fills the view, under two lights. Its texture coordinates point at the middle of either of
    // two texels.
    static GltfDocument Square(const Json& material, int texel = 0) {
        GltfDocument document;
        const size_t positions = document.AddAccessor<float>({-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, 3);
        const size_t normals = document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
        const float u = texel == 0 ? 0.25f : 0.75f;
        const size_t uv = document.AddAccessor<float>({u, 0.5f, u, 0.5f, u, 0.5f, u, 0.5f}, 2);
        const size_t indices = document.AddAccessor<uint16_t>({0, 1, 2, 0, 2, 3}, 1);
        document.AddNode(
            {{"mesh", document.AddMesh(
                          {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uv}}},
                           {"indices", indices},
                           {"material", document.AddMaterial(material)}})}});
        document.Add("images",
                     {{"uri", test::DataUri(test::MakePngOf(
                                  2, 1, std::vector<uint8_t>(&kSpecular[0][0], &kSpecular[0][0] + 8)))}});
        document.Add("samplers", {{"magFilter", 9728}, {"minFilter", 9728}});
        document.Add("textures", {{"source", 0}, {"sampler", 0}});
        document.json["extensions"]["KHR_lights_punctual"]["lights"] = {
            {{"type", "directional"}, {"intensity", 3}},
            {{"type", "point"}, {"intensity", 20}, {"color", {1, 0.5, 0.25}}}};
        document.AddNode({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}},
                          {"rotation", {-0.25881905, 0, 0, 0.96592583}}});
        document.AddNode(
            {{"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}, {"translation", {1, 0.5, 2}}});
        return document;
    }
    static passes::TraceSettings Facing() {
        scene::CameraView view = scene::CameraView::LookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0});
        view.projection = scene::Projection::Orthographic;
        view.height = 1.5f;
        passes::TraceSettings settings;
        settings.extent = {8, 8};
        settings.camera = ToRecord(view);
        return settings;
    }

    struct Picture {
        FloatImage traced, raster, roughness;
        gpu::MaterialRecord record;
    };
    Picture Take(const GltfDocument& document) {
        Picture picture;
        render.scene.SetScene(test::Load(document));
        render.scene.SetEnvironment({.radiance = glm::vec3(0.5f)});
        picture.traced = render.TraceOnce(Facing());
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, Facing(), passes::FilmPosition::Center);
        const Readback drawn = render.renderer.ReadBack(
            passes::RasterShade(render.renderer, ids, Facing(), seen, environment, {}));
        const Readback roughness = render.renderer.ReadBack(passes::SurfaceView(
            render.renderer, ids, Facing(),
            passes::TraceVisibility(render.renderer, ids, Facing(), passes::FilmPosition::Center),
            passes::View::Roughness));
        const Readback records = render.renderer.ReadBack(ids.materials);
        render.renderer.Execute();
        picture.raster = ToFloatImage(drawn);
        picture.roughness = ToFloatImage(roughness);
        records.Wait();
        std::memcpy(&picture.record, records.Bytes().data(), sizeof(picture.record));
        return picture;
    }
    static void ExpectAlike(const FloatImage& a, const FloatImage& b, float tolerance) {
        ASSERT_EQ(a.values.size(), b.values.size());
        for (size_t i = 0; i < a.values.size(); ++i)
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(a.values[i][c], b.values[i][c], tolerance * (1.0f + std::abs(b.values[i][c])))
                    << "pixel " << i << ", channel " << c;
    }

    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

}  // namespace

TEST_F(Glossiness, PictureIsThatOfTheSameMaterialSaidOtherwise) {
    const Picture glossy = Take(Square({{"extensions",
                                         {{kExtension,
                                           {{"diffuseFactor", {0.75, 0.5, 0.25, 1}},
                                            {"specularFactor", {0.5, 0.25, 0.125}},
                                            {"glossinessFactor", 0.5}}}}}}));
    const Picture same = Take(Square(
        {{"pbrMetallicRoughness",
          {{"baseColorFactor", {0.75, 0.5, 0.25, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 0.5}}},
         {"extensions",
          {{"KHR_materials_ior", {{"ior", 0}}},
           {"KHR_materials_specular", {{"specularColorFactor", {0.5, 0.25, 0.125}}}}}}}));
    EXPECT_EQ(glossy.traced.values, same.traced.values);
    EXPECT_EQ(glossy.raster.values, same.raster.values);
    EXPECT_EQ(std::memcmp(&glossy.record, &same.record, sizeof(same.record)), 0);
    EXPECT_GT(glossy.traced.Mean().x, 0.1);
    // Without the extension the picture is another
    const Picture plain = Take(Square(Json::object()));
    EXPECT_NE(glossy.traced.values, plain.traced.values);
}

// Glossiness is linear, and scales that of the factor; the other channels are a color.
TEST_F(Glossiness, TexturesAlphaIsItsGlossiness) {
    const double factor = 0.75;
    for (const int texel : {0, 1}) {
        SCOPED_TRACE(texel);
        const Json base{{"diffuseFactor", {0.5, 0.5, 0.5, 1}}, {"glossinessFactor", factor}};
        Json textured = base, plain = base;
        textured["specularGlossinessTexture"]["index"] = 0;
        textured["specularFactor"] = {0.5, 1, 0.75};
        const double glossiness = factor * kSpecular[texel][3] / 255.0;
        plain["glossinessFactor"] = glossiness;
        const double share[3] = {0.5, 1.0, 0.75};
        for (size_t c = 0; c < 3; ++c) {
            const double stored = kSpecular[texel][c] / 255.0;
            plain["specularFactor"].push_back(share[c] * std::pow((stored + 0.055) / 1.055, 2.4));
        }
        const auto take = [&](const Json& extension) {
            return Take(Square({{"extensions", {{kExtension, extension}}}}, texel));
        };
        const Picture seen = take(textured), expected = take(plain);
        EXPECT_NEAR(seen.roughness.At(4, 4).x, 1.0 - glossiness, 1e-6);
        ExpectAlike(seen.roughness, expected.roughness, 1e-6f);
        // A device's sRGB curve has half a step of eight bits
        ExpectAlike(seen.traced, expected.traced, 4e-3f);
        ExpectAlike(seen.raster, expected.raster, 4e-3f);
        EXPECT_EQ(seen.record.flags, gpu::kMaterialGlossiness);
        EXPECT_EQ(expected.record.flags, 0u);
    }
}

// Alpha says nothing in a texture that KHR_materials_specular names.
TEST_F(Glossiness, AlphaOfOtherSpecularColorsIsNotRead) {
    const Picture seen = Take(
        Square({{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0.5}}},
                {"extensions", {{"KHR_materials_specular", {{"specularColorTexture", {{"index", 0}}}}}}}}));
    EXPECT_EQ(seen.roughness.At(4, 4).x, 0.5f);
    EXPECT_EQ(seen.record.flags, 0u);
}

// A smooth surface from straight above, where light comes from everywhere: it reflects its specular color, and
// of the rest, which is the same for all channels, the diffuse one. The extension: diffuse * (1 - max(specular)).
TEST_F(Glossiness, DiffuseColorGetsWhatTheStrongestChannelOfTheSpecularLeaves) {
    struct Case {
        glm::vec3 diffuse, specular;
    };
    for (const Case& c : {Case{{1, 1, 1}, {0.4f, 0.2f, 0.1f}}, Case{{0.5f, 0.25f, 1}, {0.1f, 0.6f, 0.3f}},
                          Case{{1, 1, 1}, {1, 1, 1}}, Case{{0.5f, 0.5f, 0.5f}, {0, 0, 0}}}) {
        GltfDocument document =
            Square({{"extensions",
                     {{kExtension,
                       {{"diffuseFactor", {c.diffuse.x, c.diffuse.y, c.diffuse.z, 1}},
                        {"specularFactor", {c.specular.x, c.specular.y, c.specular.z}}}}}}});
        document.json["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = 0;
        document.json["extensions"]["KHR_lights_punctual"]["lights"][1]["intensity"] = 0;
        render.scene.SetScene(test::Load(document));
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        const RenderedImage image = render.Render(Facing(), 256);
        const glm::dvec3 mean = image.mean.Mean(), error = image.StandardErrorOfMean();
        const float left = 1.0f - std::max({c.specular.x, c.specular.y, c.specular.z});
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(mean[channel], c.specular[channel] + left * c.diffuse[channel],
                        4.0 * error[channel] + 2e-3)
                << "specular " << c.specular.x << ", channel " << channel;
    }
}

}  // namespace raygraph::testing::glossiness_test

// A material needs features of pipelines: one too few leaves a lobe out of the picture.
namespace raygraph::material_features_test {
namespace {

using scene::Material;

TraceFeatures FeaturesOf(const std::vector<Material>& materials) {
    SceneGeometry geometry;
    for (uint32_t i = 0; i < materials.size(); ++i)
        geometry.groups.emplace_back().parts.push_back({.material = i});
    return MaterialFeatures(MaterialRecords(materials, {}), 0, geometry);
}

// Rough plastic, but for what `change` makes of it.
TraceFeatures FeaturesWith(const std::function<void(Material&)>& change) {
    Material material;
    material.metallicFactor = 0.0f;
    material.roughnessFactor = 0.5f;
    change(material);
    return FeaturesOf({material});
}

constexpr scene::TextureRef kSomeTexture{.texture = 0};

TEST(MaterialFeatures, AreThoseOfTheLobesThatAMaterialMayHave) {
    struct Row {
        const char* what;
        std::function<void(Material&)> change;
        TraceFeatures features;
    };
    const auto smoothCoat = [](Material& m) {
        m.clearcoatFactor = 0.5f;
        m.clearcoatRoughnessFactor = 0.0f;
    };
    const auto film = [](Material& m) {
        m.iridescenceFactor = 0.5f;
        m.iridescenceThicknessMinimum = 100.0f;
        m.iridescenceThicknessMaximum = 400.0f;
    };
    const Row rows[] = {
        {"plastic", [](Material&) {}, kTraceOpaque},
        {"unlit", [](Material& m) { m.isUnlit = true; }, 0},
        {"metal", [](Material& m) { m.metallicFactor = 1.0f; }, kTraceMetals},
        {"half metal", [](Material& m) { m.metallicFactor = 0.5f; }, kTraceMetals | kTraceOpaque},
        {"metal by a texture, which may say that it is rough or smooth",
         [](Material& m) {
             m.metallicFactor = 1.0f;
             m.metallicRoughnessTexture = kSomeTexture;
         },
         kTraceMetals | kTraceOpaque | kTraceSmooth},
        {"smooth", [](Material& m) { m.roughnessFactor = 0.0f; }, kTraceOpaque | kTraceSmooth},
        {"glass", [](Material& m) { m.transmissionFactor = 1.0f; }, kTraceGlass},
        {"half glass", [](Material& m) { m.transmissionFactor = 0.5f; }, kTraceGlass | kTraceOpaque},
        {"glass by a texture",
         [](Material& m) {
             m.transmissionFactor = 1.0f;
             m.transmissionTexture = kSomeTexture;
         },
         kTraceGlass | kTraceOpaque},
        {"metal, whose transmission is nothing",
         [](Material& m) { m.metallicFactor = m.transmissionFactor = 1.0f; }, kTraceMetals},
        {"rough coat", [](Material& m) { m.clearcoatFactor = m.clearcoatRoughnessFactor = 0.5f; },
         kTraceOpaque | kTraceClearcoat},
        {"smooth coat", smoothCoat, kTraceOpaque | kTraceClearcoat | kTraceSmooth},
        {"coat whose roughness a texture scales down",
         [](Material& m) {
             m.clearcoatFactor = m.clearcoatRoughnessFactor = 0.5f;
             m.clearcoatRoughnessTexture = kSomeTexture;
         },
         kTraceOpaque | kTraceClearcoat | kTraceSmooth},
        {"sheen", [](Material& m) { m.sheenColorFactor.y = 0.1f; }, kTraceOpaque | kTraceSheen},
        {"film", film, kTraceOpaque | kTraceIridescence},
        {"film on metal",
         [&](Material& m) {
             film(m);
             m.metallicFactor = 1.0f;
         },
         kTraceMetals | kTraceIridescence},
        {"film without thickness",
         [&](Material& m) {
             film(m);
             m.iridescenceThicknessMaximum = 0.0f;
         },
         kTraceOpaque},
        {"film as thick as a texture says",
         [&](Material& m) {
             film(m);
             m.iridescenceThicknessMaximum = 0.0f;
             m.iridescenceThicknessTexture = kSomeTexture;
         },
         kTraceOpaque | kTraceIridescence},
        {"stretched highlights", [](Material& m) { m.anisotropyStrength = 0.1f; },
         kTraceOpaque | kTraceAnisotropy},
        {"leaf", [](Material& m) { m.diffuseTransmissionFactor = 0.1f; },
         kTraceOpaque | kTraceDiffuseTransmission},
        {"leaf of metal",
         [](Material& m) {
             m.metallicFactor = 1.0f;
             m.diffuseTransmissionFactor = 0.1f;
         },
         kTraceMetals},
        {"sheet that scatters a part",
         [](Material& m) {
             m.transmissionFactor = 1.0f;
             m.scatterStrengthFactor = 0.5f;
         },
         kTraceGlass | kTraceOpaque | kTraceThinScatter | kTraceDiffuseTransmission},
        {"sheet that scatters all",
         [](Material& m) { m.transmissionFactor = m.scatterStrengthFactor = 1.0f; },
         kTraceOpaque | kTraceThinScatter | kTraceDiffuseTransmission},
        {"sheet that scatters as much as a texture says",
         [](Material& m) {
             m.transmissionFactor = m.scatterStrengthFactor = 1.0f;
             m.scatterStrengthTexture = kSomeTexture;
         },
         kTraceGlass | kTraceOpaque | kTraceThinScatter | kTraceDiffuseTransmission},
        {"sheet that has nothing to scatter", [](Material& m) { m.scatterStrengthFactor = 1.0f; },
         kTraceOpaque},
        {"retroreflector", [](Material& m) { m.retroreflectionFactor = 0.1f; },
         kTraceOpaque | kTraceRetroreflection},
        {"dispersion without a medium", [](Material& m) { m.dispersion = 1.0f; }, kTraceOpaque},
    };
    for (const Row& row : rows) EXPECT_EQ(FeaturesWith(row.change), row.features) << row.what;
}

TEST(GroupKinds, SheetThatScattersAllIsNoThinWall) {
    Material sheet;
    sheet.metallicFactor = sheet.roughnessFactor = 0.0f;
    sheet.transmissionFactor = 1.0f;
    const auto isThinWall = [&] {
        const GroupPart part;
        const float textureAlpha = 1.0f;
        return KindOf({&part, 1}, MaterialRecords({&sheet, 1}, {}), {&textureAlpha, 1}).isThinWall;
    };
    EXPECT_TRUE(isThinWall());
    sheet.scatterStrengthFactor = 0.5f;
    EXPECT_TRUE(isThinWall());
    sheet.scatterStrengthFactor = 1.0f;
    EXPECT_FALSE(isThinWall());
    sheet.scatterStrengthTexture = kSomeTexture;
    EXPECT_TRUE(isThinWall());
}

TEST(MaterialFeatures, OfASceneAreThoseOfAllItsMaterials) {
    Material metal, glass;
    metal.metallicFactor = metal.roughnessFactor = 1.0f;
    glass.metallicFactor = 0.0f;
    glass.roughnessFactor = 1.0f;
    glass.transmissionFactor = 1.0f;
    EXPECT_EQ(FeaturesOf({metal, glass}), kTraceMetals | kTraceGlass);
    EXPECT_EQ(FeaturesOf({}), TraceFeatures{});
}

Material Medium(float ior, bool isEntered, bool scatters) {
    Material medium;
    medium.thicknessFactor = 1.0f;
    medium.metallicFactor = 0.0f;
    medium.roughnessFactor = 1.0f;
    medium.ior = ior;
    (isEntered ? medium.transmissionFactor : medium.diffuseTransmissionFactor) = 1.0f;
    if (scatters) medium.multiscatterColorFactor = glm::vec3(0.5f);
    if (scatters) medium.attenuationColor = glm::vec3(0.5f);
    if (scatters) medium.attenuationDistance = 1.0f;
    return medium;
}

TEST(MaterialFeatures, LightPassesStraightIntoAirAndBetweenMediaOfOneIndexThatScatter) {
    struct Row {
        const char* what;
        std::vector<Material> media;
        bool isMatched;
    };
    const Row rows[] = {
        {"glass", {Medium(1.5f, true, false)}, false},
        {"fog", {Medium(1.0f, true, true)}, true},
        {"air that nothing enters", {Medium(1.0f, false, true)}, false},
        {"milk", {Medium(1.33f, true, true)}, false},
        {"milk in water", {Medium(1.33f, true, false), Medium(1.33f, true, true)}, true},
        {"milk beside what nothing enters", {Medium(1.33f, true, true), Medium(1.33f, false, false)}, true},
        {"milk that nothing enters in water", {Medium(1.33f, false, true), Medium(1.33f, true, false)}, true},
        {"milk in glass", {Medium(1.5f, true, false), Medium(1.33f, true, true)}, false},
        {"two of glass", {Medium(1.5f, true, false), Medium(1.5f, true, false)}, false},
        {"none entered", {Medium(1.33f, false, true), Medium(1.33f, false, true)}, false},
        {"the last pair of many",
         {Medium(1.1f, true, true), Medium(1.5f, true, false), Medium(1.2f, true, true),
          Medium(1.3f, true, false), Medium(1.5f, true, true)},
         true},
    };
    for (const Row& row : rows)
        EXPECT_EQ(FeaturesOf(row.media).Has(kTraceMatchedMedia), row.isMatched) << row.what;
}

}  // namespace
}  // namespace raygraph::material_features_test
