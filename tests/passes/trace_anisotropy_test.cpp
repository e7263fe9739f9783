// Stretched highlights on the device: along which direction of a placed, textured mesh they lie. Expected values
// are those of the formula of the reflection, worked out here in double precision.
#include <cmath>
#include <numbers>

#include "passes/raster.h"
#include "tests/passes/gltf_square.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_anisotropy_test {

using passes::TraceSettings;

namespace {

struct Surface {
    glm::dvec3 normal, along;  // world space, unit length; `along` is the direction of the stretch
    double alphaAlong = 0.0, alphaAcross = 0.0;
};

double Lambda(const Surface& surface, const glm::dvec3& w) {
    const glm::dvec3 across = glm::cross(surface.normal, surface.along);
    const double x = surface.alphaAlong * glm::dot(w, surface.along);
    const double y = surface.alphaAcross * glm::dot(w, across);
    const double z = glm::dot(w, surface.normal);
    return 0.5 * (std::sqrt(1.0 + (x * x + y * y) / (z * z)) - 1.0);
}

// f cos of white metal, one bounce: GGX with height-correlated masking.
double Reflected(const Surface& surface, const glm::dvec3& wo, const glm::dvec3& wi) {
    const glm::dvec3 m = glm::normalize(wo + wi);
    const double x = glm::dot(m, surface.along) / surface.alphaAlong;
    const double y = glm::dot(m, glm::cross(surface.normal, surface.along)) / surface.alphaAcross;
    const double z = glm::dot(m, surface.normal);
    const double d = 1.0 / (std::numbers::pi * surface.alphaAlong * surface.alphaAcross *
                            std::pow(x * x + y * y + z * z, 2.0));
    return d / (1.0 + Lambda(surface, wo) + Lambda(surface, wi)) / (4.0 * glm::dot(wo, surface.normal));
}

class TraceAnisotropy : public VulkanTest {
  protected:
    // The radiance that a surface sends to a far viewer in the direction wo, lit by a sun of 1 lx in the
    // direction wi, traced or drawn. The mesh's middle is at the origin.
    double Seen(scene::SceneData scene, const glm::dvec3& wo, const glm::dvec3& wi, bool isDrawn) {
        scene::Light sun;
        sun.type = scene::LightType::Directional;
        sun.intensity = 1.0f;
        const glm::vec3 z(wi);
        const glm::vec3 x = glm::normalize(glm::cross(glm::vec3(0.3f, 0.9f, 0.1f), z));
        sun.lightToWorld = {x, glm::cross(z, x), z, glm::vec3(0.0f)};  // shines along -z
        scene.lights = {sun};
        render.scene.SetScene(std::move(scene));
        TraceSettings settings = LookAt(100.0f * glm::vec3(wo), {0, 0, 0}, 1e-4f, 4);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.scattering.multiscatter = MultiscatterKind::Off;
        settings.biases.maxDepth = 1;
        if (!isDrawn) return render.TraceOnce(settings).Mean().y;
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, settings, passes::FilmPosition::Center);
        passes::FilteredEnvironment environment{"environment"};
        const Readback drawn = render.renderer.ReadBack(passes::RasterShade(
            render.renderer, ids, settings, seen, environment,
            {.shadows = passes::RasterShadows::Off, .hasOcclusion = false, .hasTransmission = false}));
        render.renderer.Execute();
        return ToFloatImage(drawn).Mean().y;
    }
    void ExpectStretch(const scene::SceneData& scene, const Surface& expected, bool isDrawn = false) {
        // Where the half vector is tilted along the stretch, across it and in between
        for (const double turn : {0.0, std::numbers::pi / 2.0, 0.7, 2.2}) {
            const glm::dvec3 across = glm::cross(expected.normal, expected.along);
            const glm::dvec3 tilt = std::cos(turn) * expected.along + std::sin(turn) * across;
            const glm::dvec3 m = glm::normalize(expected.normal + 0.3 * tilt);
            const glm::dvec3 wo = glm::normalize(expected.normal - 0.1 * expected.along + 0.2 * across);
            const glm::dvec3 wi = 2.0 * glm::dot(wo, m) * m - wo;
            const double value = Reflected(expected, wo, wi);
            EXPECT_NEAR(Seen(scene, wo, wi, isDrawn), value, 2e-3 * value) << "turned by " << turn;
        }
    }

    SceneRender render{Device()};
};

scene::Material Brushed(float strength, float rotation) {
    scene::Material metal;
    metal.roughnessFactor = 0.5f;
    metal.anisotropyStrength = strength;
    metal.anisotropyRotation = rotation;
    metal.isDoubleSided = true;
    return metal;
}

scene::SceneData QuadOf(const scene::Material& material, const glm::vec4& tangent,
                        const glm::mat4x3& toWorld = glm::mat4x3(1.0f)) {
    scene::Mesh mesh = QuadMesh(1.0f);
    mesh.primitives[0].uv0.assign(4, {0.5f, 0.5f});
    if (tangent != glm::vec4(0.0f)) mesh.primitives[0].tangents.assign(4, tangent);
    return SceneOf({mesh}, {material}, {toWorld});
}

// KHR_materials_anisotropy: alpha along the direction is mix(alpha, 1, strength^2), across it alpha.
Surface Expected(const glm::dvec3& normal, const glm::dvec3& along, double strength) {
    return {glm::normalize(normal), glm::normalize(along), 0.25 + 0.75 * strength * strength, 0.25};
}

}  // namespace

TEST_F(TraceAnisotropy, Trace_HighlightLiesAlongTheTurnedTangent) {
    const glm::dvec3 up(0, 0, 1), tangent(0.8, 0.6, 0.0);
    for (const float sign : {1.0f, -1.0f})
        for (const float rotation : {0.0f, 0.6f, -2.0f}) {
            SCOPED_TRACE("sign " + std::to_string(sign) + ", rotation " + std::to_string(rotation));
            const glm::dvec3 bitangent = double{sign} * glm::cross(up, tangent);
            const double angle = rotation;
            ExpectStretch(QuadOf(Brushed(0.7f, rotation), {0.8f, 0.6f, 0.0f, sign}),
                          Expected(up, std::cos(angle) * tangent + std::sin(angle) * bitangent, 0.7f));
        }
}

// The texture's red and green are the direction, which the rotation turns further; its blue scales the strength.
TEST_F(TraceAnisotropy, Trace_TextureGivesDirectionAndStrength) {
    scene::Material material = Brushed(0.9f, 0.5f);
    material.anisotropyTexture = {.texture = 0};
    scene::SceneData scene = QuadOf(material, {1.0f, 0.0f, 0.0f, -1.0f});
    scene.images = {{.name = "brush", .width = 1, .height = 1, .rgba = {40, 200, 180, 255}}};
    scene.textures = {{.name = "brush", .image = 0}};
    const double angle = std::atan2(2.0 * 200.0 / 255.0 - 1.0, 2.0 * 40.0 / 255.0 - 1.0) + 0.5;
    ExpectStretch(
        scene, Expected({0, 0, 1}, {std::cos(angle), -std::sin(angle), 0.0}, double{0.9f} * 180.0 / 255.0));
}

// The same from a file: its mesh has texture coordinates, along which the importer makes tangents.
TEST_F(TraceAnisotropy, Trace_FilesHighlightLiesAsTheFileSays) {
    test::GltfDocument document;
    // u to the upper right
    const size_t positions = document.AddAccessor<float>({-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, 3);
    const size_t normals = document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    const size_t uv = document.AddAccessor<float>({0, 0, 1, 1, 2, 0, 1, -1}, 2);
    const size_t indices = document.AddAccessor<uint16_t>({0, 1, 2, 0, 2, 3}, 1);
    const size_t material = document.AddMaterial(
        {{"pbrMetallicRoughness", {{"roughnessFactor", 0.5}}},
         {"extensions",
          {{"KHR_materials_anisotropy", {{"anisotropyStrength", 0.7}, {"anisotropyRotation", 0.3}}}}}});
    document.AddNode(
        {{"mesh", document.AddMesh(
                      {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uv}}},
                       {"indices", indices},
                       {"material", material}})}});
    const double angle = 0.25 * std::numbers::pi + 0.3;
    ExpectStretch(test::Load(document), Expected({0, 0, 1}, {std::cos(angle), std::sin(angle), 0.0}, 0.7));
}

// An anisotropy texture is read along its own coordinates even if a normal map has others. A rotation and a
// second set, which here turn it by 90 degrees, have the effect of an anisotropyRotation; another set is
// mirrored.
TEST_F(TraceAnisotropy, TextureOfOtherCoordinatesThanTheNormalMap_HasAFrameOfItsOwn) {
    constexpr std::array<uint8_t, 4> kTilt{165, 140, 245, 255}, kBrush{240, 150, 255, 255};
    const glm::dvec3 normal =
        glm::normalize(2.0 * glm::dvec3(kTilt[0], kTilt[1], kTilt[2]) / 255.0 - glm::dvec3(1.0));
    const double texel = std::atan2(2.0 * kBrush[1] / 255.0 - 1.0, 2.0 * kBrush[0] / 255.0 - 1.0);
    const double quarter = 0.5 * std::numbers::pi;
    const auto file = [&](const Json& map, double rotation, const std::vector<float>& second = {}) {
        GltfDocument document;
        const size_t tilt = AddTexture(document, test::MakePng(1, 1, kTilt));
        Json texture = map;
        texture["index"] = AddTexture(document, test::MakePng(1, 1, kBrush));
        Json primitive = Square(document, kUpright,
                                document.AddMaterial({{"pbrMetallicRoughness", {{"roughnessFactor", 0.5}}},
                                                      {"normalTexture", {{"index", tilt}}},
                                                      {"extensions",
                                                       {{"KHR_materials_anisotropy",
                                                         {{"anisotropyStrength", 0.7},
                                                          {"anisotropyRotation", rotation},
                                                          {"anisotropyTexture", texture}}}}}}));
        if (!second.empty()) primitive["attributes"]["TEXCOORD_1"] = document.AddAccessor(second, 2);
        document.AddNode({{"mesh", document.AddMesh(primitive)}});
        return test::Load(document);
    };
    const auto expected = [&](double angle) {
        const glm::dvec3 direction(std::cos(angle), std::sin(angle), 0.0);
        return Expected(normal, direction - glm::dot(direction, normal) * normal, 0.7);
    };
    for (const bool isDrawn : {false, true}) {
        SCOPED_TRACE(isDrawn ? "drawn" : "traced");
        ExpectStretch(file({{"texCoord", 0}}, quarter), expected(texel + quarter), isDrawn);
        const Json turned{{"extensions", {{"KHR_texture_transform", {{"rotation", quarter}}}}}};
        ExpectStretch(file(turned, 0.0), expected(texel - quarter), isDrawn);
        // u grows to the bottom, v to the left
        ExpectStretch(file({{"texCoord", 1}}, 0.0, {1, 1, 1, 0, 0, 0, 0, 1}), expected(texel - quarter),
                      isDrawn);
        // u grows to the left, v to the bottom
        ExpectStretch(file({{"texCoord", 1}}, 0.6, {1, 1, 0, 1, 0, 0, 1, 0}),
                      expected(std::numbers::pi - texel - 0.6), isDrawn);
    }
}

// It is a direction within the surface: a placement moves it as it moves a scratch.
TEST_F(TraceAnisotropy, Trace_HighlightMovesWithTheSurface) {
    // Turned, stretched and mirrored
    const glm::mat4x3 placement(0.2f, 1.1f, 0.3f, 0.9f, -0.4f, 0.2f, 0.3f, 0.1f, -0.7f, 0.0f, 0.0f, 0.0f);
    const glm::dmat3 linear(placement);
    glm::dvec3 normal = glm::normalize(glm::transpose(glm::inverse(linear)) * glm::dvec3(0, 0, 1));
    for (const float rotation : {0.0f, 0.6f}) {
        const glm::dvec3 local(std::cos(double{rotation}), std::sin(double{rotation}), 0.0);
        ExpectStretch(QuadOf(Brushed(0.7f, rotation), {1, 0, 0, 1}, placement),
                      Expected(normal, linear * local, 0.7f));
        // Back faces are lit alike
        ExpectStretch(QuadOf(Brushed(0.7f, rotation), {1, 0, 0, 1}, placement),
                      Expected(-normal, linear * local, 0.7f));
    }
}

// A normal map bends the surface, and the direction with it as little as possible.
TEST_F(TraceAnisotropy, Trace_HighlightFollowsTheNormalMap) {
    scene::Material material = Brushed(0.7f, 0.4f);
    material.normalTexture = {.texture = 0};
    scene::SceneData scene = QuadOf(material, {1, 0, 0, 1});
    scene.images = {{.name = "tilt", .width = 1, .height = 1, .rgba = {165, 140, 245, 255}}};
    scene.textures = {{.name = "tilt", .image = 0}};
    const glm::dvec3 normal = glm::normalize(2.0 * glm::dvec3(165.0, 140.0, 245.0) / 255.0 - glm::dvec3(1.0));
    const glm::dvec3 direction(std::cos(double{0.4f}), std::sin(double{0.4f}), 0.0);
    ExpectStretch(scene, Expected(normal, direction - glm::dot(direction, normal) * normal, 0.7f));
}

// A mesh without tangents and texture coordinates is brushed around its y axis, a level one along x.
TEST_F(TraceAnisotropy, Trace_MeshesWithoutTangentsHaveAFrame) {
    ExpectStretch(QuadOf(Brushed(0.7f, 0.0f), glm::vec4(0.0f)), Expected({0, 0, 1}, {1, 0, 0}, 0.7f));
    const glm::dvec3 turned(std::cos(double{0.6f}), std::sin(double{0.6f}), 0.0);
    ExpectStretch(QuadOf(Brushed(0.7f, 0.6f), glm::vec4(0.0f)), Expected({0, 0, 1}, turned, 0.7f));
    scene::SceneData level = QuadOf(Brushed(0.7f, 0.0f), glm::vec4(0.0f));
    for (glm::vec3& position : level.meshes[0].primitives[0].positions)
        position = {position.x, 0.0f, -position.y};
    for (glm::vec3& normal : level.meshes[0].primitives[0].normals) normal = {0, 1, 0};
    level.meshes[0].primitives[0].bounds = {{-1, 0, -1}, {1, 0, 1}};
    ExpectStretch(level, Expected({0, 1, 0}, {1, 0, 0}, 0.7f));
}

// A pane that is rough along one direction is no hole: the sun does not pass through it as through a clear one.
TEST_F(TraceAnisotropy, Trace_BrushedPaneCastsAShadow) {
    for (const float strength : {0.0f, 0.5f}) {
        scene::Material pane = Brushed(strength, 0.0f);
        pane.metallicFactor = pane.roughnessFactor = 0.0f;
        pane.transmissionFactor = 1.0f;
        scene::Material floor = Lambert(glm::vec3(1.0f));
        floor.metallicFactor = floor.specularFactor = 0.0f;
        scene::SceneData scene = SceneOf({QuadMesh(1.0f, 0), QuadMesh(1.0f, 1)}, {floor, pane},
                                         {glm::mat4x3(1.0f), Translation({0.0f, 0.0f, 0.5f})});
        scene::Light sun;
        sun.type = scene::LightType::Directional;
        scene.lights = {sun};
        render.scene.SetScene(std::move(scene));
        TraceSettings settings = LookAt({0, 0, 0.25f}, {0, 0, 0}, 1e-3f, 4);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.biases.maxDepth = 1;
        EXPECT_NEAR(render.TraceOnce(settings).Mean().y, strength > 0.0f ? 0.0 : 0.96 / std::numbers::pi,
                    1e-3);
    }
}

}  // namespace raygraph::testing::trace_anisotropy_test
