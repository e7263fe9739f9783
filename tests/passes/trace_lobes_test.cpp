// Lobes of glTF materials on the device, against closed forms.
#include <cmath>
#include <numbers>

#include "passes/raster.h"
#include "passes/views.h"
#include "tests/passes/gltf_square.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

// Stretched highlights on the device: along which direction of a placed, textured mesh they lie. Expected values
// are those of the formula of the reflection, worked out here in double precision.
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

// The mesh of a file has texture coordinates, along which the importer makes tangents.
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

// The clear coat on the device: the light that it reflects and keeps, and its normal map.
namespace raygraph::testing::trace_clearcoat_test {

using passes::TraceSettings;

namespace {

class TraceClearcoat : public VulkanTest {
  protected:
    TraceClearcoat() { render.more |= SceneRender::kPlainLobes | kTraceClearcoat; }

    static TraceSettings Gltf(const glm::vec3& eye, const glm::vec3& target, float yFov, uint32_t size) {
        TraceSettings settings = LookAt(eye, target, yFov, size);
        settings.scattering.brdf = BrdfModel::Gltf;
        return settings;
    }

    SceneRender render{Device()};
};

// A camera far off that sees the middle of a quad of the xy plane at an angle whose cosine is given.
glm::vec3 EyeAt(float cosTheta) {
    return 100.0f * glm::vec3(std::sqrt(1.0f - cosTheta * cosTheta), 0.0f, cosTheta);
}

// Upright: its x axis is the world's z.
glm::mat4x3 Upright(const glm::vec3& center) {
    return {glm::vec3(0, 0, 1), glm::vec3(0, 1, 0), glm::vec3(-1, 0, 0), center};
}

// A coat on a black body reflects by Fresnel, on a lamp it keeps that from getting out: seen at two angles, and
// as light on a wall, where sampling the lamp and finding it must agree.
TEST_F(TraceClearcoat, Trace_CoatReflectsAndDimsWhatIsBelow) {
    scene::Material coated;
    coated.baseColorFactor = {0.0f, 0.0f, 0.0f, 1.0f};
    coated.specularFactor = 0.0f;
    coated.metallicFactor = 0.0f;
    coated.clearcoatFactor = 0.8f;
    coated.isDoubleSided = true;
    scene::Material lamp = coated;
    lamp.emissiveFactor = glm::vec3(2.0f);
    for (const float cosTheta : {0.9f, 0.3f}) {
        const TraceSettings settings = Gltf(EyeAt(cosTheta), {0, 0, 0}, 1e-4f, 8);
        const double reflected = 0.8 * (0.04 + 0.96 * std::pow(1.0 - cosTheta, 5.0));
        const auto seen = [&](const scene::Material& material) {
            render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {material}));
            render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
            return render.TraceOnce(settings).Mean().y;
        };
        EXPECT_NEAR(seen(coated), reflected, 2e-3) << cosTheta;
        EXPECT_NEAR(seen(lamp), reflected + 2.0 * (1.0 - reflected), 4e-3) << cosTheta;
    }
    // The lamp stands upright beside the wall that is seen
    scene::Material wall = coated;
    wall.clearcoatFactor = 0.0f;
    wall.baseColorFactor = glm::vec4(1.0f);
    render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), QuadMesh(1.0f, 1)}, {wall, lamp},
                                  {glm::mat4x3(1.0f), Upright({1.0f, 0.0f, 1.0f})}));
    render.scene.SetEnvironment({.radiance = glm::vec3(0.0f)});
    TraceSettings settings = Gltf({-3.0f, 0.0f, 2.0f}, {0.5f, 0, 0}, 0.1f, 16);
    settings.biases.maxDepth = 1;
    const RenderedImage sampled = render.Render(settings, 256);
    settings.lights.isOn = false;
    const RenderedImage found = render.Render(settings, 512);
    const double error = std::hypot(sampled.StandardErrorOfMean().y, found.StandardErrorOfMean().y);
    EXPECT_LT(error, 0.01 * found.mean.Mean().y);
    EXPECT_NEAR(sampled.mean.Mean().y, found.mean.Mean().y, 4.0 * error);
    EXPECT_GT(found.mean.Mean().y, 0.05);
}

// The coat has the normal map that is named for it, and not that of the material below. From above, its mirror
// shows a lamp that stands at the side only if it is tilted.
TEST_F(TraceClearcoat, Trace_CoatHasANormalMapOfItsOwn) {
    const auto seenWith = [&](scene::TextureRef scene::Material::*map) {
        scene::Material black;
        black.baseColorFactor = {0.0f, 0.0f, 0.0f, 1.0f};
        black.specularFactor = 0.0f;
        black.clearcoatFactor = 1.0f;
        if (map) black.*map = {.texture = 0};
        scene::Mesh mirror = QuadMesh(1.0f, 0);
        mirror.primitives[0].uv0.assign(4, {0.5f, 0.5f});
        mirror.primitives[0].tangents.assign(4, {1.0f, 0.0f, 0.0f, 1.0f});
        scene::SceneData scene =
            SceneOf({mirror, QuadMesh(1.0f, 1)}, {black, Lambert(glm::vec3(0.0f), glm::vec3(10.0f))},
                    {glm::mat4x3(1.0f), Upright({4.33f, 0.0f, 2.5f})});
        // Tilted by 30 degrees towards +x
        scene.images = {{.name = "tilt", .width = 1, .height = 1, .rgba = {191, 128, 238, 255}}};
        scene.textures = {{.name = "tilt", .image = 0}};
        render.scene.SetScene(std::move(scene));
        return render.TraceOnce(Gltf({0, 0, 100.0f}, {0, 0, 0}, 1e-4f, 4)).Mean().x;
    };
    EXPECT_NEAR(seenWith(nullptr), 0.0, 1e-3);
    EXPECT_NEAR(seenWith(&scene::Material::normalTexture), 0.0, 1e-3) << "the material's own";
    EXPECT_NEAR(seenWith(&scene::Material::clearcoatNormalTexture), 0.4, 0.02);
}

// Where the shadow terminator's bias bends a surface, its coat reflects into what is then outside: here a normal
// map would mirror the view below the bent surface, though above the triangle.
TEST_F(TraceClearcoat, Trace_CoatFollowsASurfaceThatTheShadowTerminatorBends) {
    scene::Material black;
    black.baseColorFactor = {0.0f, 0.0f, 0.0f, 1.0f};
    black.specularFactor = 0.0f;
    black.metallicFactor = 0.0f;
    black.clearcoatFactor = 1.0f;
    black.clearcoatNormalTexture = {.texture = 0};
    scene::Mesh mirror = QuadMesh(1.0f, 0);
    scene::Primitive& quad = mirror.primitives[0];
    quad.uv0.assign(4, {0.5f, 0.5f});
    // 20 degrees towards +x, and by the map 60 degrees back
    quad.normals.assign(4, {0.34202f, 0.0f, 0.93969f});
    quad.tangents.assign(4, {0.93969f, 0.0f, -0.34202f, 1.0f});
    scene::SceneData scene = SceneOf({mirror}, {black});
    scene.images = {{.name = "tilt", .width = 1, .height = 1, .rgba = {17, 128, 191, 255}}};
    scene.textures = {{.name = "tilt", .image = 0}};
    render.scene.SetScene(std::move(scene));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings settings = Gltf({0, 0, 100.0f}, {0, 0, 0}, 1e-4f, 4);
    settings.biases.shadowTerminator = true;
    EXPECT_NEAR(render.TraceOnce(settings).Mean().x, 0.04, 2e-3);
}

}  // namespace
}  // namespace raygraph::testing::trace_clearcoat_test

// Diffuse transmission on the device: light from behind a sheet, and through bodies that it bounds.
namespace raygraph::testing::trace_diffuse_transmission_test {

using passes::TraceSettings;

namespace {

class TraceDiffuseTransmission : public VulkanTest {
  protected:
    TraceDiffuseTransmission() { render.more |= SceneRender::kPlainLobes | kTraceDiffuseTransmission; }

    static TraceSettings Gltf(const glm::vec3& eye, const glm::vec3& target, float yFov, uint32_t size) {
        TraceSettings settings = LookAt(eye, target, yFov, size);
        settings.scattering.brdf = BrdfModel::Gltf;
        return settings;
    }

    SceneRender render{Device()};
};

// Without a layer, so that both of its sides are Lambert's. Single-sided.
scene::Material Paper(float transmission) {
    scene::Material paper;
    paper.baseColorFactor = {0.9f, 0.6f, 0.3f, 1.0f};
    paper.metallicFactor = 0.0f;
    paper.specularFactor = 0.0f;
    paper.diffuseTransmissionFactor = transmission;
    paper.diffuseTransmissionColorFactor = {0.2f, 0.5f, 0.8f};
    return paper;
}

scene::Light PointLight(const glm::vec3& position, float intensity) {
    scene::Light light;
    light.intensity = intensity;
    light.lightToWorld = Translation(position);
    return light;
}

}  // namespace

// A lamp behind the sheet: t c I / (pi d^2), on either side of the sheet, whose back is not culled. One before
// it: (1 - t) of what it had.
TEST_F(TraceDiffuseTransmission, Trace_LampBehindASheetLightsItsFront) {
    for (const float transmission : {0.0f, 0.4f, 1.0f})
        for (const bool isFromFront : {true, false}) {
            if (transmission == 0.0f && !isFromFront) continue;  // culled
            const scene::Material paper = Paper(transmission);
            const glm::vec3 eye(0.3f, 0.0f, isFromFront ? 4.0f : -4.0f);
            TraceSettings settings = Gltf(eye, {0, 0, 0}, 1e-4f, 2);
            settings.biases.maxDepth = 1;
            for (const bool isBehind : {true, false}) {
                scene::SceneData scene = SceneOf({QuadMesh(1.0f)}, {paper});
                scene.lights = {PointLight({0, 0, isBehind == isFromFront ? -2.0f : 2.0f}, 12.0f)};
                render.scene.SetScene(std::move(scene));
                const glm::vec3 color = isBehind ? transmission * paper.diffuseTransmissionColorFactor
                                                 : (1.0f - transmission) * glm::vec3(paper.baseColorFactor);
                const glm::dvec3 expected = glm::dvec3(color) * (12.0 / (M_PI * 4.0));
                const glm::dvec3 seen = render.TraceOnce(settings).Mean();
                EXPECT_LT(glm::distance(seen, expected), 1e-3 * glm::length(expected) + 1e-6)
                    << transmission << (isFromFront ? ", from the front" : ", from the back")
                    << (isBehind ? ", light behind: " : ", light before: ") << seen.y << " for "
                    << expected.y;
            }
        }
}

// Sampling the lamp behind the sheet and finding it agree, under the layer too.
TEST_F(TraceDiffuseTransmission, Trace_LampBehindASheetIsFoundAsItIsSampled) {
    scene::Material leaf = Paper(0.6f);
    leaf.specularFactor = 1.0f;
    leaf.roughnessFactor = 0.6f;
    render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), QuadMesh(0.7f, 1)},
                                  {leaf, Lambert(glm::vec3(0.0f), glm::vec3(5.0f))},
                                  {glm::mat4x3(1.0f), Translation({0.2f, 0.0f, -0.8f})}));
    render.scene.SetEnvironment({.radiance = glm::vec3(0.1f)});
    TraceSettings settings = Gltf({1.0f, 0.5f, 3.0f}, {0, 0, 0}, 0.2f, 16);
    settings.biases.maxDepth = 1;
    const RenderedImage sampled = render.Render(settings, 128);
    settings.lights.isOn = false;
    const RenderedImage found = render.Render(settings, 512);
    for (int channel = 0; channel < 3; ++channel) {
        const double error =
            std::hypot(sampled.StandardErrorOfMean()[channel], found.StandardErrorOfMean()[channel]);
        EXPECT_NEAR(sampled.mean.Mean()[channel], found.mean.Mean()[channel], 4.0 * error);
        EXPECT_LT(error, 0.01 * found.mean.Mean()[channel]) << "too noisy to prove anything";
    }
    EXPECT_GT(found.mean.Mean().z, 0.3) << "what the lamp adds";
}

// A closed body whose boundary passes light diffusely into its medium and out of it: white and clear, it is not
// seen; the medium dims what has passed it.
TEST_F(TraceDiffuseTransmission, Trace_WhiteBodyVanishesInUnitEnvironment) {
    scene::Material wax;
    wax.metallicFactor = 0.0f;
    wax.roughnessFactor = 0.5f;
    wax.diffuseTransmissionFactor = 0.7f;
    wax.thicknessFactor = 1.0f;
    ASSERT_TRUE(wax.BoundsMedium());
    const TraceSettings settings = Gltf({0, 0, 6}, {0, 0, 0}, 0.1f, 16);
    const auto seen = [&] {
        render.scene.SetScene(SceneOf({BoxMesh(1.0f)}, {wax}));
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        const RenderedImage image = render.Render(settings, 128);
        EXPECT_LT(4.0 * image.StandardErrorOfMean().y, 0.02) << "too noisy to prove anything";
        return image.mean.Mean();
    };
    EXPECT_NEAR(seen().y, 1.0, 0.015);
    wax.attenuationColor = {1.0f, 0.5f, 1e-6f};
    wax.attenuationDistance = 1.0f;
    const glm::dvec3 tinted = seen();
    EXPECT_NEAR(tinted.x, 1.0, 0.015);
    EXPECT_LT(tinted.y, 0.8);
    // Only what the layer and the base return: nothing comes through the body
    wax.diffuseTransmissionColorFactor = glm::vec3(0.0f);
    EXPECT_NEAR(seen().z, tinted.z, 0.02);
    EXPECT_LT(tinted.z, 0.5);
}

}  // namespace raygraph::testing::trace_diffuse_transmission_test

// A thin film on the device: the colors that it reflects, and the energy of what it lets pass.
namespace raygraph::testing::trace_iridescence_test {

using passes::TraceSettings;

namespace {

class TraceIridescence : public VulkanTest {
  protected:
    TraceIridescence() { render.more |= SceneRender::kPlainLobes | kTraceIridescence; }

    // The mean of a quad of the material, seen at that cosine within white surroundings.
    RenderedImage Seen(const scene::Material& material, float cosTheta, uint32_t sampleCount = 1) {
        const glm::vec3 eye = 100.0f * glm::vec3(std::sqrt(1.0f - cosTheta * cosTheta), 0.0f, cosTheta);
        TraceSettings settings = LookAt(eye, {0, 0, 0}, 1e-4f, 8);
        settings.scattering.brdf = BrdfModel::Gltf;
        render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {material}));
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        return render.Render(settings, sampleCount);
    }

    SceneRender render{Device()};
};

scene::Material Filmed(float ior, float thickness) {
    scene::Material material;
    material.iridescenceFactor = 1.0f;
    material.iridescenceIor = ior;
    material.iridescenceThicknessMaximum = thickness;
    return material;
}

// A film over a metal that reflects nothing is a soap film. Values: Airy's formula, integrated over the spectrum
// as tests/shading/fresnel_test.cpp does.
TEST_F(TraceIridescence, Trace_ThinFilmReflectsByItsThickness) {
    const struct {
        float ior, thickness, cosTheta;
        glm::dvec3 reflected;
    } kCases[] = {{1.5f, 250.0f, 0.9f, {0.0156, 0.1158, 0.1399}},
                  {1.5f, 420.0f, 0.5f, {0.2863, 0.0406, 0.1830}},
                  {2.0f, 180.0f, 0.9f, {0.0358, 0.2698, 0.3566}}};
    for (const auto& test : kCases) {
        scene::Material film = Filmed(test.ior, test.thickness);
        film.baseColorFactor = {0.0f, 0.0f, 0.0f, 1.0f};
        film.roughnessFactor = 0.0f;
        const glm::dvec3 bare(std::pow(1.0 - test.cosTheta, 5.0));  // Schlick's curve of an F0 of 0
        const glm::dvec3 seen(Seen(film, test.cosTheta).mean.Mean());
        EXPECT_LT(glm::distance(seen, bare + test.reflected), 0.01)
            << test.thickness << " nm, cos " << test.cosTheta << ": " << seen.x << ' ' << seen.y << ' '
            << seen.z;
        film.iridescenceFactor = 0.25f;
        EXPECT_LT(
            glm::distance(glm::dvec3(Seen(film, test.cosTheta).mean.Mean()), bare + 0.25 * test.reflected),
            0.004)
            << "a film on a quarter of the facets";
    }
}

// A film on glass takes from the transmission what it adds to the reflection.
TEST_F(TraceIridescence, Trace_FilmOnAPaneLosesNothing) {
    scene::Material pane = Filmed(1.9f, 330.0f);
    pane.metallicFactor = 0.0f;
    pane.roughnessFactor = 0.0f;
    pane.transmissionFactor = 1.0f;
    for (const float cosTheta : {0.95f, 0.4f}) {
        const RenderedImage seen = Seen(pane, cosTheta, 256);
        const glm::dvec3 mean(seen.mean.Mean()), error(seen.StandardErrorOfMean());
        EXPECT_LT(glm::length(error), 0.004);
        EXPECT_LT(glm::distance(mean, glm::dvec3(1.0)), 4.0 * glm::length(error) + 1e-3) << cosTheta;
    }
}

}  // namespace
}  // namespace raygraph::testing::trace_iridescence_test

// Light that a surface reflects back to its lamp, from the file to the picture.
namespace raygraph::testing::trace_retroreflection_test {

using passes::TraceSettings;

namespace {

constexpr double kCosine = 0.5, kDistance = 4.0, kIntensity = 20.0, kAlpha = 0.16;

class TraceRetroreflection : public VulkanTest {
  protected:
    TraceRetroreflection() { render.more |= kTraceMetals | kTraceRetroreflection; }

    // A square of white metal with a point light at the camera, at 60 degrees.
    static GltfDocument Lit(const Json& retroreflection) {
        GltfDocument document;
        Json material{{"pbrMetallicRoughness", {{"roughnessFactor", std::sqrt(kAlpha)}}}};
        if (!retroreflection.is_null())
            material["extensions"]["KHR_materials_retroreflection"] = retroreflection;
        const size_t index = document.AddMaterial(material);
        document.AddNode({{"mesh", document.AddMesh(Square(document, {}, index))}});
        document.json["extensions"]["KHR_lights_punctual"]["lights"] = {
            {{"type", "point"}, {"intensity", kIntensity}}};
        document.AddNode(
            {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}},
             {"translation", {kDistance * std::sqrt(1.0 - kCosine * kCosine), 0.0, kDistance * kCosine}}});
        return document;
    }
    static TraceSettings View() {
        TraceSettings settings =
            LookAt(float(kDistance) * glm::vec3(std::sqrt(1.0 - kCosine * kCosine), 0.0, kCosine), {0, 0, 0},
                   1e-3f, 8);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.scattering.multiscatter = MultiscatterKind::Off;
        return settings;
    }
    // Returns the radiance of the single reflection D F G / (4 cos cos) at the facets' normal.
    static double Radiance(double height) {
        const double sine2 = 1.0 - kCosine * kCosine;
        const double slope2 = (1.0 / (height * height) - 1.0) / (kAlpha * kAlpha);
        const double d = 1.0 / (std::numbers::pi * kAlpha * kAlpha * std::pow(height, 4.0) * (1.0 + slope2) *
                                (1.0 + slope2));
        const double lambdaCos = 0.5 * (std::sqrt(kCosine * kCosine + kAlpha * kAlpha * sine2) - kCosine);
        const double visible = 1.0 / (kCosine * kCosine + 2.0 * lambdaCos * kCosine);
        return 0.25 * d * visible * kCosine * kIntensity / (kDistance * kDistance);
    }

    FloatImage Raster() {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, View(), passes::FilmPosition::Center);
        const Readback drawn = render.renderer.ReadBack(
            passes::RasterShade(render.renderer, ids, View(), seen, environment, {}));
        render.renderer.Execute();
        return ToFloatImage(drawn);
    }

    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

}  // namespace

// Ahead, the facets that reflect to the camera are turned towards it; back, those that lie in the surface.
TEST_F(TraceRetroreflection, Trace_LampAtTheCameraIsSeenInTheSurface) {
    const double ahead = Radiance(kCosine), back = Radiance(1.0);
    ASSERT_GT(back, 50.0 * ahead);
    for (const double share : {0.0, 0.3, 1.0}) {
        const Json extension = {{"retroreflectionFactor", share}};
        render.scene.SetScene(test::Load(Lit(share > 0.0 ? extension : Json())));
        const double expected = (1.0 - share) * ahead + share * back;
        EXPECT_NEAR(render.Render(View(), 1).mean.Mean().y, expected, 2e-3 * expected) << share;
        EXPECT_NEAR(Raster().Mean().y, expected, 2e-3 * expected) << "raster, " << share;
    }
}

}  // namespace raygraph::testing::trace_retroreflection_test

// Media that refract colors differently, on the device.
namespace raygraph::testing::trace_dispersion_test {

using passes::TraceSettings;

namespace {

class TraceDispersion : public VulkanTest {
  protected:
    SceneRender render{Device()};
};

constexpr double kCosine = 0.45, kIor = 1.6, kDispersion = 5.0;

// The index at a wavelength in nm (KHR_materials_dispersion).
double IorAt(double wavelength) {
    return kIor + (kIor - 1.0) * kDispersion / 20.0 * (523655.0 / (wavelength * wavelength) - 1.5168);
}

// A camera looks through the surface of glass at a floor that is lit from x = `edge` on.
scene::SceneData GlassOverAFloor(float dispersion, float edge) {
    scene::Material glass;
    glass.metallicFactor = 0.0f;
    glass.roughnessFactor = 0.0f;
    glass.ior = float(kIor);
    glass.transmissionFactor = 1.0f;
    glass.thicknessFactor = 1.0f;
    glass.dispersion = dispersion;
    const scene::Material lamp = Lambert(glm::vec3(0.0f), glm::vec3(1.0f));
    return SceneOf({QuadMesh(50.0f, 0), QuadMesh(5.0f, 1)}, {glass, lamp},
                   {glm::mat4x3(1.0f), Translation({edge + 5.0f, 0.0f, -1.0f})});
}

// Red is bent less than blue. The edge of the lamp is where light of 540.7 nm goes, the middle of green: half of
// green sees it, red sees it and blue does not.
TEST_F(TraceDispersion, Trace_BluePassesAtAnotherAngleThanRed) {
    const double sine = std::sqrt(1.0 - kCosine * kCosine);
    const double refracted = sine / IorAt(540.7);
    const auto edge = float(refracted / std::sqrt(1.0 - refracted * refracted));
    TraceSettings settings = LookAt(100.0f * glm::vec3(-sine, 0.0f, kCosine), {0, 0, 0}, 1e-5f, 16);
    settings.scattering.brdf = BrdfModel::Gltf;
    const auto passedAt = [&](double wavelength) {
        const double n = IorAt(wavelength);
        const double f0 = std::pow((n - 1.0) / (n + 1.0), 2.0);
        return (1.0 - f0) * (1.0 - std::pow(1.0 - kCosine, 5.0)) / (n * n);
    };
    render.scene.SetScene(GlassOverAFloor(float(kDispersion), edge));
    const RenderedImage seen = render.Render(settings, 64);
    const glm::dvec3 mean = seen.mean.Mean();
    const glm::dvec3 error = seen.StandardErrorOfMean();
    // By the bands' logistic curves: 1 / (1 + exp(-(609.2 - 540.7) / 14.16)) of red is beyond the edge
    EXPECT_NEAR(mean.x, 0.992 * passedAt(609.2), 4.0 * error.x + 0.002);
    EXPECT_NEAR(mean.y, 0.5 * passedAt(560.0), 4.0 * error.y + 0.002);
    EXPECT_NEAR(mean.z, 0.0005 * passedAt(540.7), 4.0 * error.z + 0.001);
    // Without dispersion the d line decides for all colors: it is beyond the edge
    render.scene.SetScene(GlassOverAFloor(0.0f, edge));
    const glm::vec3 gray = render.Render(settings, 64).mean.Mean();
    EXPECT_EQ(gray.x, gray.z);
    EXPECT_NEAR(gray.x, passedAt(587.6), 0.002);
}

}  // namespace
}  // namespace raygraph::testing::trace_dispersion_test
