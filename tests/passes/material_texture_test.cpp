#include <algorithm>
#include <cmath>
#include <string>

#include "passes/views.h"
#include "renderer/gpu_scene/materials/texture_set.h"
#include "renderer/graph/pass_harness.h"
#include "rhi/shader_compiler.h"
#include "tests/rhi/fake_loader.h"
#include "tests/support/direct_light_reference.h"
#include "tests/support/error_of.h"
#include "tests/support/same_image.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

// Textures of materials on the device: slots, channels, color spaces, texture coordinate sets, wrap modes,
// filters, normal maps. Expected values are worked out here and in support/direct_light_reference.
namespace raygraph::testing::material_texture_test {

using passes::TraceSettings;
using scene::ColorSpace;
using scene::FilterMode;
using scene::Material;
using scene::WrapMode;

namespace {

constexpr scene::Sampler kNearest{.magFilter = FilterMode::Nearest, .minFilter = FilterMode::Nearest};

constexpr float kDecoding = 0.5f / 255.0f;  // a device's sRGB curve, in linear values

class MaterialTextures : public VulkanTest {
  protected:
    FloatImage Values(const TraceSettings& settings, passes::View view) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback readback = render.renderer.ReadBack(passes::SurfaceView(
            render.renderer, ids, settings,
            passes::TraceVisibility(render.renderer, ids, settings, passes::FilmPosition::Center), view));
        render.renderer.Execute();
        return ToFloatImage(readback);
    }
    SceneRender render{Device()};
};

TraceSettings Orthographic(float height, Extent2D extent, glm::vec3 eye = {0, 0, 4}) {
    scene::CameraView view = scene::CameraView::LookAt(eye, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = height;
    view.aspect = float(extent.width) / float(extent.height);
    TraceSettings settings;
    settings.extent = extent;
    settings.camera = ToRecord(view);
    return settings;
}

// 4 x 3 texels, no two alike in any channel.
scene::ImageData TwelveTexels() {
    scene::ImageData image{.name = "twelve texels", .width = 4, .height = 3, .rgba = {}};
    for (uint32_t i = 0; i < 12; ++i)
        for (const uint32_t step : {83u, 131u, 37u, 59u})
            image.rgba.push_back(static_cast<uint8_t>((20 + step * i) % 256));
    return image;
}

// Two texels side by side: uv0 points at the left one everywhere, uv1 at the right one.
constexpr uint8_t kTexels[2][4] = {{60, 130, 190, 90}, {210, 70, 110, 160}};

scene::Mesh TwoTexelQuad(uint32_t material = 0) {
    scene::Mesh mesh = QuadMesh(1.0f, material);
    mesh.primitives[0].uv0.assign(4, {0.25f, 0.5f});
    mesh.primitives[0].uv1.assign(4, {0.75f, 0.5f});
    mesh.primitives[0].tangents.assign(4, {1.0f, 0.0f, 0.0f, 1.0f});
    return mesh;
}

void AddTwoTexels(scene::SceneData& scene) {
    scene.images = {{.name = "two texels",
                     .width = 2,
                     .height = 1,
                     .rgba = std::vector<uint8_t>(&kTexels[0][0], &kTexels[0][0] + sizeof(kTexels))}};
    for (const ColorSpace space : {ColorSpace::Linear, ColorSpace::Srgb})
        scene.textures.push_back(
            {.name = "two texels", .image = 0, .sampler = kNearest, .colorSpace = space});
}

// A texel as a material's slot reads it.
glm::vec4 Texel(int set, ColorSpace space) {
    glm::dvec4 value;
    for (int channel = 0; channel < 4; ++channel) {
        const double stored = kTexels[set][channel] / 255.0;
        value[channel] = space == ColorSpace::Srgb && channel < 3 ? test::DecodeSrgb(stored) : stored;
    }
    return value;
}

struct Slot {
    const char* name;
    scene::TextureRef Material::*texture;
    ColorSpace space;
    // Does to the factors what the texture does to the material.
    void (*apply)(Material&, const glm::vec4& texel);
};

// With the channels that glTF says.
const Slot kKnownSlots[] = {
    {"base color", &Material::baseColorTexture, ColorSpace::Srgb,
     [](Material& material, const glm::vec4& texel) { material.baseColorFactor *= texel; }},
    {"metallic and roughness", &Material::metallicRoughnessTexture, ColorSpace::Linear,
     [](Material& material, const glm::vec4& texel) {
         material.roughnessFactor *= texel.y;
         material.metallicFactor *= texel.z;
     }},
    {"emission", &Material::emissiveTexture, ColorSpace::Srgb,
     [](Material& material, const glm::vec4& texel) { material.emissiveFactor *= glm::vec3(texel); }},
    {"specular", &Material::specularTexture, ColorSpace::Linear,
     [](Material& material, const glm::vec4& texel) { material.specularFactor *= texel.w; }},
    {"specular color", &Material::specularColorTexture, ColorSpace::Srgb,
     [](Material& material, const glm::vec4& texel) { material.specularColorFactor *= glm::vec3(texel); }},
    {"transmission", &Material::transmissionTexture, ColorSpace::Linear,
     [](Material& material, const glm::vec4& texel) { material.transmissionFactor *= texel.x; }},
    {"clear coat", &Material::clearcoatTexture, ColorSpace::Linear,
     [](Material& material, const glm::vec4& texel) { material.clearcoatFactor *= texel.x; }},
    {"roughness of the clear coat", &Material::clearcoatRoughnessTexture, ColorSpace::Linear,
     [](Material& material, const glm::vec4& texel) { material.clearcoatRoughnessFactor *= texel.y; }},
    {"sheen color", &Material::sheenColorTexture, ColorSpace::Srgb,
     [](Material& material, const glm::vec4& texel) { material.sheenColorFactor *= glm::vec3(texel); }},
    {"roughness of the sheen", &Material::sheenRoughnessTexture, ColorSpace::Linear,
     [](Material& material, const glm::vec4& texel) { material.sheenRoughnessFactor *= texel.w; }},
    {"weight of the thin film", &Material::iridescenceTexture, ColorSpace::Linear,
     [](Material& material, const glm::vec4& texel) { material.iridescenceFactor *= texel.x; }},
    {"thickness of the thin film", &Material::iridescenceThicknessTexture, ColorSpace::Linear,
     [](Material& material, const glm::vec4& texel) {
         material.iridescenceThicknessMaximum =
             glm::mix(material.iridescenceThicknessMinimum, material.iridescenceThicknessMaximum, texel.y);
     }},
    {"diffuse transmission", &Material::diffuseTransmissionTexture, ColorSpace::Linear,
     [](Material& material, const glm::vec4& texel) { material.diffuseTransmissionFactor *= texel.w; }},
    {"color of the diffuse transmission", &Material::diffuseTransmissionColorTexture, ColorSpace::Srgb,
     [](Material& material, const glm::vec4& texel) {
         material.diffuseTransmissionColorFactor *= glm::vec3(texel);
     }},
    {"anisotropy", &Material::anisotropyTexture, ColorSpace::Linear,
     [](Material& material, const glm::vec4& texel) {
         material.anisotropyRotation += std::atan2(2.0f * texel.y - 1.0f, 2.0f * texel.x - 1.0f);
         material.anisotropyStrength *= texel.z;
     }},
    {"retroreflection", &Material::retroreflectionTexture, ColorSpace::Linear,
     [](Material& material, const glm::vec4& texel) { material.retroreflectionFactor *= texel.x; }},
};

struct Channels {
    float x, y, z, w;
    glm::vec3 xyz{x, y, z};
};

// And those of other rows of the list of fields.
std::vector<Slot> Slots() {
    std::vector<Slot> slots(std::begin(kKnownSlots), std::end(kKnownSlots));
#define RAYGRAPH_MATERIAL_FACTOR(type, name, object, key, channels, space, feature, quantity)                \
    if (std::ranges::find(slots, &Material::name##Texture, &Slot::texture) == slots.end())                   \
        slots.push_back({#name, &Material::name##Texture, ColorSpace::space,                                 \
                         [](Material& material, const glm::vec4& texel) {                                    \
                             material.name##Factor *= Channels{texel.x, texel.y, texel.z, texel.w}.channels; \
                         }});
#include "shaders/shared/material_list.h"
    return slots;
}

// Every factor matters and none is 1. A film, highlights that are stretched and lobes of an extension alone are there
// for their own textures alone: they make the shader several times as long to compile.
Material OfEverythingFor(const Slot& slot) {
    Material material;
    material.baseColorFactor = {0.8f, 0.6f, 0.9f, 0.7f};
    material.metallicFactor = 0.6f;
    material.roughnessFactor = 0.8f;
    material.specularFactor = 0.9f;
    material.specularColorFactor = {0.9f, 0.8f, 0.7f};
    material.transmissionFactor = 0.5f;
    material.emissiveFactor = {0.3f, 0.5f, 0.7f};
    material.emissiveStrength = 2.0f;
    material.ior = 2.4f;
    material.clearcoatFactor = 0.9f;
    material.clearcoatRoughnessFactor = 0.7f;
    material.sheenColorFactor = {0.9f, 0.8f, 0.7f};
    material.sheenRoughnessFactor = 0.9f;
    material.diffuseTransmissionFactor = 0.6f;
    material.diffuseTransmissionColorFactor = {0.9f, 0.7f, 0.8f};
    if (slot.texture == &Material::iridescenceTexture ||
        slot.texture == &Material::iridescenceThicknessTexture) {
        material.iridescenceFactor = 0.9f;
        material.iridescenceIor = 1.8f;
        material.iridescenceThicknessMinimum = 90.0f;
        material.iridescenceThicknessMaximum = 330.0f;
    }
    if (slot.texture == &Material::anisotropyTexture) {
        material.anisotropyStrength = 0.8f;
        material.anisotropyRotation = 0.4f;
    }
    std::string_view extension;
#define RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space) \
    if (slot.texture == &Material::name##Texture) extension = #object;
#include "shaders/shared/material_list.h"
#define RAYGRAPH_MATERIAL_FACTOR(type, name, object, key, channels, space, feature, quantity)   \
    if (extension == #object && material.name##Factor == decltype(material.name##Factor)(0.0f)) \
        material.name##Factor = decltype(material.name##Factor)(0.9f);
#include "shaders/shared/material_list.h"
    return material;
}

// The quad between the sky before it and an emitting wall behind it. The wall has a texture, and it is
// transformed, so that a picture without one on the quad is made by the same pipeline.
scene::SceneData QuadOf(const Material& material) {
    Material wall = Lambert({}, {0.4f, 0.8f, 1.2f});
    wall.emissiveTexture = {.texture = 1, .texCoord = 0, .transform = {.scale = {1.0f, 0.5f}}};
    scene::SceneData scene =
        SceneOf({TwoTexelQuad(0), TwoTexelQuad(1)}, {material, wall},
                {glm::mat4x3(1.0f), glm::mat4x3(9.0f, 0, 0, 0, 9.0f, 0, 0, 0, 9.0f, 0, 0, -1.0f)});
    AddTwoTexels(scene);
    return scene;
}

double MeanDifference(const FloatImage& a, const FloatImage& b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.values.size(); ++i)
        for (int channel = 0; channel < 3; ++channel)
            sum += std::abs(double{a.values[i][channel]} - double{b.values[i][channel]});
    return sum / (3.0 * double(a.values.size()));
}

}  // namespace

// Paths do not depend on the texels, but where a path turns on a chance that they move: the
// picture of a texture is that of the factors it stands for, to rounding.
TEST_F(MaterialTextures, EverySlotIsMultipliedWithItsFactorByChannelSpaceAndUvSet) {
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    render.scene.SetEnvironmentMap(EveningSky());
    for (const scene::AlphaMode alphaMode : {scene::AlphaMode::Opaque, scene::AlphaMode::Blend}) {
        for (const Slot& slot : Slots()) {
            // Seen from straight above, light that goes back goes where a mirror sends it
            const bool goesBack = slot.texture == &Material::retroreflectionTexture;
            TraceSettings settings =
                Orthographic(1.8f, {16, 16}, goesBack ? glm::vec3(1.0f, 3.0f, 4.0f) : glm::vec3(0, 0, 4));
            settings.biases.maxDepth = 2;
            settings.lights.isOn = false;  // which compiles in half of the time
            if (alphaMode == scene::AlphaMode::Blend && slot.texture != &Material::baseColorTexture) continue;
            Material plain = OfEverythingFor(slot);
            plain.alphaMode = alphaMode;
            render.scene.SetScene(QuadOf(plain));
            const FloatImage without = render.TraceOnce(settings);
            FloatImage bySet[2];
            for (int set = 0; set < 2; ++set) {
                SCOPED_TRACE(std::string(slot.name) + ", set " + std::to_string(set));
                Material expected = plain, textured = plain;
                slot.apply(expected, Texel(set, slot.space));
                textured.*slot.texture = {.texture = slot.space == ColorSpace::Srgb ? 1 : 0, .texCoord = set};
                render.scene.SetScene(QuadOf(expected));
                const FloatImage byFactor = render.TraceOnce(settings);
                render.scene.SetScene(QuadOf(textured));
                bySet[set] = render.TraceOnce(settings);
                const double change = MeanDifference(bySet[set], without);
                EXPECT_GT(change, 0.003) << "the texture does not matter here";
                EXPECT_LT(MeanDifference(bySet[set], byFactor), 0.003 * change);
            }
            EXPECT_GT(MeanDifference(bySet[0], bySet[1]), 2e-3) << slot.name << ": the set does not matter";
            // From the left texel to the right one
            Material moved = plain;
            moved.*slot.texture = {.texture = slot.space == ColorSpace::Srgb ? 1 : 0,
                                   .texCoord = 0,
                                   .transform = {.offset = {0.5f, 0.0f}}};
            render.scene.SetScene(QuadOf(moved));
            EXPECT_LT(MeanDifference(render.TraceOnce(settings), bySet[1]), 1e-5)
                << slot.name << ": its transform";
        }
    }
}

// One tile of the picture for each way to wrap and filter, and for either set of texture coordinates.
TEST_F(MaterialTextures, EveryWrapModeAndFilterReadsWhatItsDefinitionSays) {
    constexpr uint32_t kTile = 24, kColumns = 6, kRows = 6;
    constexpr WrapMode kModes[] = {WrapMode::Repeat, WrapMode::MirroredRepeat, WrapMode::ClampToEdge};
    const glm::vec2 first(-2.313f, -1.427f),
        last(2.637f, 2.881f);  // at the upper left and lower right corner
    scene::SceneData scene;
    std::vector<scene::Mesh> meshes;
    std::vector<Material> materials;
    std::vector<glm::mat4x3> transforms;
    for (uint32_t tile = 0; tile < kColumns * kRows; ++tile) {
        const int set = int(tile / 18);
        scene.textures.push_back(
            {.name = "tile",
             .image = 0,
             .sampler = {.wrapU = kModes[tile % 3],
                         .wrapV = kModes[tile / 3 % 3],
                         .magFilter = tile / 9 % 2 ? FilterMode::Linear : FilterMode::Nearest,
                         .minFilter = tile / 9 % 2 ? FilterMode::Nearest : FilterMode::Linear},
             .colorSpace = ColorSpace::Srgb});
        Material material = Lambert(glm::vec3(1.0f));
        material.baseColorTexture = {.texture = int32_t(tile), .texCoord = set};
        materials.push_back(material);
        scene::Mesh mesh = QuadMesh(0.5f, tile);
        const std::vector<glm::vec2> uv = {
            {first.x, last.y}, {last.x, last.y}, {last.x, first.y}, {first.x, first.y}};
        const std::vector<glm::vec2> other = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        mesh.primitives[0].uv0 = set == 0 ? uv : other;
        mesh.primitives[0].uv1 = set == 1 ? uv : other;
        meshes.push_back(mesh);
        transforms.push_back(Translation({float(tile % kColumns) - 2.5f, 2.5f - float(tile / kColumns), 0}));
    }
    scene::SceneData placed = SceneOf(meshes, materials, transforms);
    placed.textures = scene.textures;
    placed.images = {TwelveTexels()};
    scene = placed;  // a copy to look things up in
    render.scene.SetScene(std::move(placed));
    const FloatImage albedo =
        render.PrimaryHits(Orthographic(float(kRows), {kColumns * kTile, kRows * kTile})).albedo;
    for (uint32_t tile = 0; tile < kColumns * kRows; ++tile) {
        const bool isLinear = tile / 9 % 2 != 0;
        // A device may round the weights of a linear filter to 8 bits, and its result to as many
        const double tolerance = isLinear ? 3.0 / 255.0 : kDecoding;
        double worst = 0.0;
        for (uint32_t y = 0; y < kTile; ++y)
            for (uint32_t x = 0; x < kTile; ++x) {
                const glm::dvec2 share((x + 0.5) / kTile, (y + 0.5) / kTile);
                const glm::dvec2 uv = glm::dvec2(first) + share * glm::dvec2(last - first);
                const glm::dvec4 expected = test::ReadTexture(scene, tile, uv);
                const glm::vec4& seen = albedo.At(tile % kColumns * kTile + x, tile / kColumns * kTile + y);
                for (int channel = 0; channel < 3; ++channel)
                    worst = std::max(worst, std::abs(double{seen[channel]} - expected[channel]));
            }
        EXPECT_LT(worst, tolerance) << "wrap " << tile % 3 << " by " << tile / 3 % 3
                                    << (isLinear ? ", linear" : ", nearest") << ", set " << tile / 18;
    }
}

// KHR_texture_transform: T * R * S of (u, v), as its example of a quarter of the image has the rotation.
// Seen by a path, by the raster view, and after an edit.
TEST_F(MaterialTextures, TransformsScaleThenRotateThenMove) {
    constexpr uint32_t kTile = 32;
    const scene::TextureTransform kTransforms[] = {
        {.offset = {0.3f, -0.2f}},
        {.rotation = 0.7f},
        {.scale = {1.7f, -0.6f}},
        {.offset = {0.3f, -0.2f}, .rotation = -0.7f, .scale = {0.4f, 2.0f}}};
    Material material = Lambert(glm::vec3(1.0f));
    material.baseColorTexture = {.texture = 0, .texCoord = 0};
    scene::Mesh mesh = QuadMesh(0.5f, 0);
    mesh.primitives[0].uv0 = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    scene::SceneData data = SceneOf({mesh}, {material});
    data.textures = {{.name = "twelve", .image = 0, .sampler = kNearest, .colorSpace = ColorSpace::Srgb}};
    data.images = {TwelveTexels()};
    render.scene.SetScene(scene::SceneData(data));
    const TraceSettings settings = Orthographic(1.0f, {kTile, kTile});
    for (const scene::TextureTransform& transform : kTransforms) {
        material.baseColorTexture.transform = transform;
        render.scene.SetMaterial(0, material);
        const FloatImage pictures[] = {render.PrimaryHits(settings).albedo,
                                       Values(settings, passes::View::Albedo)};
        const double c = std::cos(double{transform.rotation}), s = std::sin(double{transform.rotation});
        for (const FloatImage& albedo : pictures) {
            uint32_t differing = 0;
            for (uint32_t y = 0; y < kTile; ++y)
                for (uint32_t x = 0; x < kTile; ++x) {
                    const glm::dvec2 uv =
                        glm::dvec2((x + 0.5) / kTile, (y + 0.5) / kTile) * glm::dvec2(transform.scale);
                    const glm::dvec2 read =
                        glm::dvec2(c * uv.x + s * uv.y, -s * uv.x + c * uv.y) + glm::dvec2(transform.offset);
                    const glm::dvec3 expected(test::ReadTexture(data, 0, read));
                    differing += glm::distance(glm::dvec3(albedo.At(x, y)), expected) > 2.0 * kDecoding;
                }
            // Where rounding decides between two texels
            EXPECT_LE(differing, 4u) << transform.rotation << ' ' << transform.scale.x;
        }
    }
    // A host that names no textures leaves them as they are
    const FloatImage before = render.PrimaryHits(settings).albedo;
    render.scene.SetMaterial(0, Lambert(glm::vec3(1.0f)));
    EXPECT_EQ(render.PrimaryHits(settings).albedo.values, before.values);
}

// glTF 2.0, 3.8.3: a primitive may lack the set that its material names; then (0, 0) is read.
TEST_F(MaterialTextures, TextureWithoutItsCoordinatesIsReadAtItsCorner) {
    Material material = Lambert(glm::vec3(1.0f));
    material.baseColorTexture = {.texture = 1, .texCoord = 1};
    scene::SceneData scene = SceneOf({TwoTexelQuad()}, {material});
    scene.meshes[0].primitives[0].uv1.clear();
    scene.meshes[0].primitives[0].uv0.assign(4, {0.75f, 0.5f});
    AddTwoTexels(scene);
    render.scene.SetScene(std::move(scene));
    const glm::vec3 seen = render.PrimaryHits(Orthographic(1.0f, {4, 4})).albedo.At(2, 2);
    EXPECT_LT(glm::distance(seen, glm::vec3(Texel(0, ColorSpace::Srgb))), kDecoding);
}

// The values that views show are those that the textures hold: glTF packs roughness into green and metallic
// into blue.
TEST_F(MaterialTextures, ViewsShowWhatTexturesHold) {
    Material material;
    material.baseColorTexture = {.texture = 1, .texCoord = 0};
    material.metallicRoughnessTexture = {.texture = 0, .texCoord = 1};
    material.emissiveFactor = glm::vec3(1.0f);
    material.emissiveTexture = {.texture = 1, .texCoord = 1};
    scene::SceneData scene = SceneOf({TwoTexelQuad()}, {material});
    AddTwoTexels(scene);
    render.scene.SetScene(std::move(scene));
    const TraceSettings settings = Orthographic(1.0f, {4, 4});
    const glm::vec4 data = Texel(1, ColorSpace::Linear);
    const std::pair<passes::View, glm::vec3> kExpected[] = {
        {passes::View::Albedo, Texel(0, ColorSpace::Srgb)},
        {passes::View::Roughness, glm::vec3(data.y)},
        {passes::View::Metallic, glm::vec3(data.z)},
        {passes::View::Emissive, Texel(1, ColorSpace::Srgb)}};
    for (const auto& [view, value] : kExpected)
        EXPECT_LT(glm::distance(glm::vec3(Values(settings, view).At(2, 2)), value), kDecoding)
            << passes::Name(view);
}

// glTF 2.0, 3.9.3: red is along the tangent, green along cross(normal, tangent) * w, blue along the normal;
// the scale is on red and green.
TEST_F(MaterialTextures, NormalMapBendsTheNormalAlongItsTangents) {
    glm::mat4x3 placement = Translation({0.1f, -0.1f, 0.0f});
    placement[0] = {0.0f, 0.5f, 0.3f};
    placement[1] = {-1.5f, 0.0f, 0.2f};
    placement[2] = {0.0f, 0.1f, 2.0f};
    for (const glm::mat4x3& toWorld : {glm::mat4x3(1.0f), placement})
        for (const float sign : {1.0f, -1.0f})
            for (const float scale : {1.0f, 0.4f})
                for (const int set : {0, 1}) {
                    Material material = Lambert(glm::vec3(1.0f));
                    material.normalTexture = {.texture = 0, .texCoord = set};
                    if (scale != 1.0f)  // the other set, moved to this one's texel
                        material.normalTexture = {
                            .texture = 0, .texCoord = 1 - set, .transform = {.offset = {0.5f, 0}}};
                    material.normalScale = scale;
                    scene::Mesh mesh = TwoTexelQuad();
                    const glm::vec3 tangent(0.8f, 0.6f, 0.0f), normal(0.0f, 0.0f, 1.0f);
                    mesh.primitives[0].tangents.assign(4, {tangent, sign});
                    scene::SceneData scene = SceneOf({mesh}, {material}, {toWorld});
                    AddTwoTexels(scene);
                    // Tilts that leave the mirrored view above the surface: no other normal is put in place
                    scene.images[0].rgba = {140, 155, 250, 0, 145, 115, 245, 0};
                    const uint8_t* texel = scene.images[0].rgba.data() + 4 * set;
                    const glm::vec3 read =
                        2.0f * glm::vec3(texel[0], texel[1], texel[2]) / 255.0f - glm::vec3(1.0f);
                    const glm::vec3 bitangent = sign * glm::cross(normal, tangent);
                    const glm::vec3 bent = scale * (read.x * tangent + read.y * bitangent) + read.z * normal;
                    const glm::vec3 expected =
                        glm::normalize(glm::transpose(glm::inverse(glm::mat3(toWorld))) * bent);
                    render.scene.SetScene(std::move(scene));
                    const glm::vec3 seen = render.PrimaryHits(Orthographic(0.2f, {4, 4})).normal.At(2, 2);
                    EXPECT_LT(glm::distance(seen, expected), 2e-3f)
                        << "sign " << sign << ", scale " << scale << ", set " << set << ": " << seen.x << ' '
                        << seen.y << ' ' << seen.z;
                }
}

}  // namespace raygraph::testing::material_texture_test

// The textures of a GpuScene on the device: their levels, and what a budget leaves of them.
namespace raygraph::testing::scene_textures_test {

namespace {

constexpr uint32_t kMaxLevels = 8;

// For each slot a row: levels, width and height of level 0; then the first texel of each level.
constexpr std::string_view kReadSlots = R"(#version 460
#extension GL_EXT_nonuniform_qualifier : require
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba32f) writeonly uniform image2D rows;
layout(set = 1, binding = 0) uniform sampler2D textures[];
void main() {
    ivec2 place = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(place, imageSize(rows)))) return;
    int levels = textureQueryLevels(textures[nonuniformEXT(place.y)]);
    vec4 value = vec4(vec2(textureSize(textures[nonuniformEXT(place.y)], 0)), levels, 0);
    if (place.x > levels) value = vec4(-1);
    else if (place.x > 0) value = texelFetch(textures[nonuniformEXT(place.y)], ivec2(0), place.x - 1);
    imageStore(rows, place, value);
})";

struct OnDevice {
    Extent2D extent;
    std::vector<glm::vec4> firstTexels;  // of each level, as shaders see them
};

class SceneTextures : public VulkanTest {
  protected:
    // Returns what is on the device of the textures of a scene of its own.
    std::vector<OnDevice> Set(const GpuSceneDesc& desc, scene::SceneData&& data) {
        const auto count = static_cast<uint32_t>(data.textures.size());
        SceneRender render(Device(), desc);
        render.scene.SetScene(std::move(data));
        statistics = render.scene.Statistics();
        render.renderer.AddShader("test/read_slots.comp", rhi::CompileGlsl({.name = "test/read_slots.comp",
                                                                            .text = std::string(kReadSlots),
                                                                            .stage = {},
                                                                            .includeRoot = {}}));
        const Extent2D extent{kMaxLevels + 1, count};
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        makesMipLevels = ids.features.Has(kTraceTextureLod);
        TextureId rows = render.renderer.CreateTexture("rows", {.extent = extent});
        render.renderer.AddPass(
            "ReadSlots", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/read_slots.comp");
                pass.Uses(ids.textures);
                rows = pass.Writes("rows", rows);
            },
            [extent](CommandList& commands) { commands.DispatchOver(extent); });
        const Readback readback = render.renderer.ReadBack(rows);
        render.renderer.Execute();
        const FloatImage read = ToFloatImage(readback);
        std::vector<OnDevice> textures;
        for (uint32_t slot = 0; slot < count; ++slot) {
            const glm::vec4 head = read.At(0, slot);
            OnDevice& texture = textures.emplace_back(
                OnDevice{{static_cast<uint32_t>(head.x), static_cast<uint32_t>(head.y)}, {}});
            for (uint32_t level = 0; level < static_cast<uint32_t>(head.z); ++level)
                texture.firstTexels.push_back(read.At(level + 1, slot));
        }
        return textures;
    }

    GpuSceneStatistics statistics;
    bool makesMipLevels = false;
};

// Black and white columns of `stripe` texels.
scene::ImageData Stripes(Extent2D extent, uint32_t stripe) {
    scene::ImageData image{.name = "stripes", .width = extent.width, .height = extent.height, .rgba = {}};
    for (uint32_t i = 0; i < extent.width * extent.height; ++i)
        for (int c = 0; c < 4; ++c)
            image.rgba.push_back(c == 3 || (i % extent.width) / stripe % 2 == 1 ? 255 : 0);
    return image;
}

scene::SceneData SceneWith(std::vector<scene::ImageData> images) {
    scene::SceneData scene = SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))});
    for (uint32_t i = 0; i < images.size(); ++i)
        scene.textures.push_back({.name = "stripes", .image = i, .colorSpace = scene::ColorSpace::Srgb});
    scene.images = std::move(images);
    return scene;
}

constexpr float kCode = 0.01f;  // of 8 bits, in linear light at half of white

// Blocks of BC1: two colors, and which of them each texel has. On a device without them the texels are used.
scene::ImageData Blocks(uint16_t color, uint32_t levelCount) {
    const uint32_t side = 16;
    scene::ImageData image{.name = "blocks", .width = side, .height = side, .rgba = {}};
    image.blocks.coding = image::BlockCoding::Bc1;
    for (uint32_t level = 0; level < levelCount; ++level) {
        std::vector<std::byte>& bytes = image.blocks.levels.emplace_back();
        const uint32_t blocks = std::max((side >> level) / 4, 1u);
        for (uint32_t i = 0; i < blocks * blocks; ++i)
            for (const uint32_t byte :
                 {color & 0xFFu, uint32_t{color} >> 8, 0u, 0u, 0x44u, 0x11u, 0x44u, 0x11u})
                bytes.push_back(static_cast<std::byte>(byte));
    }
    // 0x44 and 0x11: the first color where column and row are both even or both odd
    for (uint32_t i = 0; i < side * side; ++i) {
        const bool isSecond = (i % side + i / side) % 2 == 1;
        image.rgba.insert(image.rgba.end(),
                          {uint8_t(isSecond ? 0 : 255), 0, uint8_t(isSecond ? 0 : 255), 255});
    }
    return image;
}
constexpr uint16_t kMagenta = 0xF81F;

}  // namespace

TEST_F(SceneTextures, HaveOneLevelUnlessAskedFor) {
    const auto textures = Set({}, SceneWith({Stripes({8, 4}, 1)}));
    EXPECT_EQ(textures[0].firstTexels.size(), 1u);
    EXPECT_EQ(statistics.textureBytes, 8u * 4 * 4);
    EXPECT_EQ(statistics.reducedTextures, 0u);
    EXPECT_FALSE(makesMipLevels);
}

TEST_F(SceneTextures, LevelsAreMeansInLinearLight) {
    scene::SceneData scene = SceneWith({Stripes({8, 4}, 1)});
    scene.textures.push_back({.name = "data", .image = 0});
    scene.textures.push_back({.name = "alone", .image = 0, .sampler = {.usesMips = false}});
    const auto textures = Set({.textureLevels = true}, std::move(scene));
    EXPECT_TRUE(makesMipLevels);
    for (const size_t texture : {0u, 1u}) {
        EXPECT_EQ(textures[texture].extent, (Extent2D{8, 4}));
        ASSERT_EQ(textures[texture].firstTexels.size(), 4u);
        EXPECT_EQ(textures[texture].firstTexels[0], glm::vec4(0, 0, 0, 1));
        for (size_t level = 1; level < 4; ++level) {
            EXPECT_NEAR(textures[texture].firstTexels[level].g, 0.5f, kCode) << texture;
            EXPECT_EQ(textures[texture].firstTexels[level].a, 1.0f);
        }
    }
    // Its sampler filters without levels
    EXPECT_EQ(textures[2].firstTexels.size(), 1u);
    EXPECT_EQ(statistics.textureBytes, 4u * (2 * (32 + 8 + 2 + 1) + 32));
}

// One level after the other goes, of the largest, and the rest stays; with one level each, too.
TEST_F(SceneTextures, AreSmallerWhereTheyDoNotFitTheBudget) {
    for (const bool wantsLevels : {false, true}) {
        const uint64_t all = wantsLevels ? 4 * (1024 + 256 + 64 + 16 + 4 + 1) : 4 * 1024;
        const uint64_t less = wantsLevels ? 4 * (256 + 64 + 16 + 4 + 1) : 4 * 256;
        const size_t first = Log().Count();
        const auto textures =
            Set({.textureLevels = wantsLevels, .textureBudget = 2 * all},
                SceneWith({Stripes({32, 32}, 1), Stripes({16, 16}, 4), Stripes({32, 32}, 2)}));
        EXPECT_EQ(textures[0].extent, (Extent2D{16, 16}));
        EXPECT_EQ(textures[1].extent, (Extent2D{16, 16}));
        EXPECT_EQ(textures[2].extent, (Extent2D{32, 32}));
        EXPECT_EQ(textures[0].firstTexels.size(), wantsLevels ? 5u : 1u);
        EXPECT_NEAR(textures[0].firstTexels[0].g, 0.5f, kCode);
        EXPECT_EQ(textures[1].firstTexels[0].g, 0.0f);
        EXPECT_EQ(textures[2].firstTexels[0].g, 0.0f);
        EXPECT_EQ(statistics.textureBytes, all + 2 * less);
        EXPECT_EQ(statistics.textureBudget, 2 * all);
        EXPECT_EQ(statistics.reducedTextures, 1u);
        EXPECT_NE(Log().Text(first).find("1 of 3 textures is smaller on the device"), std::string::npos);
        EXPECT_NE(Log().Text(first).find("1 of 32x32 texels is 16x16"), std::string::npos);
    }
}

// A gray square, which is left of them, is drawn.
TEST_F(SceneTextures, PictureOfATinyBudgetHasTheMeanOfItsTextures) {
    scene::SceneData scene = SceneWith({Stripes({64, 64}, 1)});
    scene.meshes[0].primitives[0].uv0 = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    scene.materials[0] = Lambert(glm::vec3(1.0f));
    scene.materials[0].baseColorTexture.texture = 0;
    SceneRender render(Device(), {.textureBudget = 1});
    render.scene.SetScene(std::move(scene));
    EXPECT_EQ(render.scene.Statistics().textureBytes, 4u);
    passes::TraceSettings settings = LookAt({0, 0, 3}, {0, 0, 0}, 0.2f, 4);
    for (const glm::vec4& albedo : render.PrimaryHits(settings).albedo.values)
        EXPECT_NEAR(albedo.g, 0.5f, kCode);
}

TEST_F(SceneTextures, BlocksGoToTheDeviceAsTheyAreAndShowTheSame) {
    const bool hasBlocks = Device().Info().optional.textureCompressionBc;
    for (const bool isRough : {false, true}) {
        std::vector<FloatImage> pictures;
        for (const bool wantsBlocks : {true, false}) {
            scene::ImageData image = Blocks(kMagenta, 1);
            if (!wantsBlocks) image.blocks = {};
            scene::SceneData scene = SceneWith({std::move(image)});
            if (isRough) scene.textures[0].colorSpace = scene::ColorSpace::Linear;
            scene.meshes[0].primitives[0].uv0 = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
            scene.materials[0] = Lambert(glm::vec3(1.0f));
            scene.materials[0].baseColorTexture.texture = 0;
            SceneRender render(Device());
            render.scene.SetScene(std::move(scene));
            EXPECT_EQ(render.scene.Statistics().textureBytes, wantsBlocks && hasBlocks ? 128u : 1024u);
            pictures.push_back(render.PrimaryHits(LookAt({0, 0, 3}, {0, 0, 0}, 0.6f, 32)).albedo);
        }
        double contrast = 0.0;
        for (size_t i = 0; i < pictures[0].values.size(); ++i)
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(pictures[0].values[i][c], pictures[1].values[i][c], 2.0f / 255.0f);
                contrast = std::max(contrast, double(pictures[0].values[i].r));
            }
        EXPECT_GT(contrast, 0.5);
    }
}

// A normal map of two channels: the third one is made by the shader, or was by the importer.
TEST_F(SceneTextures, NormalMapsOfTwoChannelsBendAlikeWithAndWithoutBlocks) {
    const glm::dvec2 slope(2.0 * 200.0 / 255.0 - 1.0, 2.0 * 90.0 / 255.0 - 1.0);
    const glm::dvec3 bent(slope, std::sqrt(1.0 - glm::dot(slope, slope)));
    for (const bool hasBlocks : {true, false}) {
        scene::ImageData image{.name = "bent", .width = 4, .height = 4, .rgba = {}};
        const auto blue = uint8_t(hasBlocks ? 0 : std::lround(255.0 * (0.5 + 0.5 * bent.z)));
        for (int i = 0; i < 16; ++i) image.rgba.insert(image.rgba.end(), {200, 90, blue, 255});
        if (hasBlocks) {
            image.blocks.coding = image::BlockCoding::Bc5;
            for (const uint32_t byte : {200, 200, 0, 0, 0, 0, 0, 0, 90, 90, 0, 0, 0, 0, 0, 0}) {
                if (image.blocks.IsEmpty()) image.blocks.levels.emplace_back();
                image.blocks.levels[0].push_back(static_cast<std::byte>(byte));
            }
        }
        scene::SceneData scene = SceneWith({std::move(image)});
        scene.textures[0].colorSpace = scene::ColorSpace::Linear;
        scene.meshes[0].primitives[0].uv0 = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
        scene.meshes[0].primitives[0].tangents.assign(4, {1.0f, 0.0f, 0.0f, 1.0f});
        scene.materials[0].normalTexture.texture = 0;
        SceneRender render(Device());
        render.scene.SetScene(std::move(scene));
        for (const glm::vec4& normal :
             render.PrimaryHits(LookAt({0, 0, 3}, {0, 0, 0}, 0.3f, 4)).normal.values)
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(normal[c], bent[c], 0.01) << hasBlocks;
    }
}

TEST_F(SceneTextures, OfBlocksTheLevelsOfTheFileAreTaken) {
    if (!Device().Info().optional.textureCompressionBc)
        GTEST_SKIP() << "the device lacks textureCompressionBC";
    const auto three = Set({.textureLevels = true}, SceneWith({Blocks(kMagenta, 3)}));
    EXPECT_EQ(three[0].firstTexels.size(), 3u);
    EXPECT_EQ(statistics.textureBytes, 128u + 32 + 8);
    EXPECT_EQ(Set({}, SceneWith({Blocks(kMagenta, 3)}))[0].firstTexels.size(), 1u);
    EXPECT_EQ(statistics.textureBytes, 128u);
    // The budget takes the second; below the third, levels are made of the texels
    const auto smaller = Set({.textureLevels = true, .textureBudget = 40}, SceneWith({Blocks(kMagenta, 3)}));
    EXPECT_EQ(smaller[0].extent, (Extent2D{8, 8}));
    EXPECT_EQ(smaller[0].firstTexels.size(), 2u);
    EXPECT_EQ(smaller[0].firstTexels[1].r, 1.0f);
    EXPECT_EQ(statistics.textureBytes, 40u);
    const auto tiny = Set({.textureBudget = 4}, SceneWith({Blocks(kMagenta, 3)}));
    EXPECT_EQ(tiny[0].extent, (Extent2D{1, 1}));
    EXPECT_NEAR(tiny[0].firstTexels[0].r, 0.5f, kCode);
}

std::unique_ptr<rhi::Device> DeviceOf(FakeLoader& loader) {
    return rhi::Device::Create({.savePipelineCache = false, .getInstanceProcAddr = loader.Entry()});
}

TEST(SceneTexturesElsewhere, DecodedOnADeviceWithoutBlocks) {
    FakeLoader loader;
    loader.Tell().hasNoBlocks = true;
    const std::unique_ptr<rhi::Device> device = DeviceOf(loader);
    Renderer renderer(*device);
    GpuScene scene(renderer);
    scene.SetScene(SceneWith({Blocks(kMagenta, 3)}));
    EXPECT_EQ(scene.Statistics().textureBytes, 1024u);
    EXPECT_NE(std::string(
                  ErrorOf([&] {
                      device->CreateTexture({.name = "t", .extent = {4, 4}, .format = rhi::Format::Bc7Unorm});
                  }).what())
                  .find("has no compressed textures (textureCompressionBC)"),
              std::string::npos);
}

TEST(SceneTexturesElsewhere, BudgetIsHalfOfWhatTheProcessMayUse) {
    FakeLoader loader;
    loader.Tell().hasSeparateMemory = true;
    const std::unique_ptr<rhi::Device> device = DeviceOf(loader);
    Renderer renderer(*device);
    GpuScene scene(renderer);
    scene.SetScene(SceneWith({Stripes({4, 4}, 1)}));
    EXPECT_EQ(scene.Statistics().textureBudget, kFakeDeviceBudgetBytes / 2);
}

// The old scene lives until the new one is there, as when a scene is replaced.
TEST(SceneTexturesElsewhere, BudgetIsNoMoreThanWhatIsLeft) {
    FakeLoader loader;
    loader.Tell().hasSeparateMemory = true;
    const std::unique_ptr<rhi::Device> device = DeviceOf(loader);
    Renderer renderer(*device);
    GpuScene scene(renderer);
    loader.Tell().heapUsage = kFakeDeviceBudgetBytes - 1024;
    scene.SetScene(SceneWith({Stripes({32, 32}, 1)}));
    EXPECT_EQ(scene.Statistics().textureBudget, 1024u);
    EXPECT_EQ(scene.Statistics().textureBytes, 1024u);
    loader.Tell().heapUsage = 2 * kFakeDeviceBudgetBytes;
    scene.SetScene(SceneWith({Stripes({4, 4}, 1)}));
    EXPECT_EQ(scene.Statistics().textureBudget, 0u);
}

// Limits what this process may take of the device, as long as this lives.
class MemoryLimit {
  public:
    MemoryLimit(rhi::Device& device, uint64_t more) : m_device(device) {
        device.WaitIdle();
        device.CollectGarbage();
        device.LimitMemory(device.Memory().usedBytes + more);
    }
    ~MemoryLimit() { m_device.LimitMemory(0); }
    MemoryLimit(const MemoryLimit&) = delete;
    MemoryLimit& operator=(const MemoryLimit&) = delete;

  private:
    rhi::Device& m_device;
};

TEST_F(SceneTextures, DefaultBudgetFollowsTheLimitOfMemory) {
    constexpr uint64_t kMore = 64u << 20;
    Renderer renderer(Device());
    GpuScene scene(renderer);
    {
        const MemoryLimit limit(Device(), kMore);
        scene.SetScene(SceneWith({Stripes({4, 4}, 1)}));
        EXPECT_GT(scene.Statistics().textureBudget, 0u);
        EXPECT_LE(scene.Statistics().textureBudget, std::min(kMore, Device().MemoryLimit() / 2));
    }
    const rhi::Buffer filler = Device().CreateBuffer({.name = "filler", .size = 4 * kMore});
    const MemoryLimit limit(Device(), kMore);
    scene.SetScene(SceneWith({Stripes({4, 4}, 1)}));
    EXPECT_GT(scene.Statistics().textureBudget, 0u);
    EXPECT_LE(scene.Statistics().textureBudget, kMore);
}

// A texture of roughness 0.4, and a normal map of waves as wide as a texel.
scene::SceneData Waves(Extent2D roughnessExtent, Extent2D wavesExtent) {
    scene::ImageData waves{
        .name = "waves", .width = wavesExtent.width, .height = wavesExtent.height, .rgba = {}};
    scene::ImageData roughness{
        .name = "roughness", .width = roughnessExtent.width, .height = roughnessExtent.height, .rgba = {}};
    for (uint32_t i = 0; i < wavesExtent.width * wavesExtent.height; ++i)
        waves.rgba.insert(waves.rgba.end(), {uint8_t(i % 2 == 0 ? 78 : 177), 128, 245, 255});
    for (uint32_t i = 0; i < roughnessExtent.width * roughnessExtent.height; ++i)
        roughness.rgba.insert(roughness.rgba.end(), {0, 102, 255, 255});
    scene::SceneData scene = SceneWith({roughness, waves});
    for (scene::Texture& texture : scene.textures) texture.colorSpace = scene::ColorSpace::Linear;
    scene.materials[0] = {};
    scene.materials[0].metallicRoughnessTexture.texture = 0;
    scene.materials[0].normalTexture.texture = 1;
    return scene;
}

// Waves of a normal map become roughness of the levels that have lost them.
TEST_F(SceneTextures, RoughnessIsWidenedByTheMaterialsNormalMap) {
    scene::SceneData flat = Waves({8, 8}, {8, 8});
    flat.materials[0].normalTexture = {};
    const auto bent = Set({.textureLevels = true}, Waves({8, 8}, {8, 8}));
    const auto smooth = Set({.textureLevels = true}, std::move(flat));
    for (size_t level = 1; level < 4; ++level) {
        EXPECT_NEAR(smooth[0].firstTexels[level].g, 0.4f, 1e-4f);
        EXPECT_GT(bent[0].firstTexels[level].g, 0.5f);
        EXPECT_NEAR(bent[1].firstTexels[level].b, 1.0f, 1e-2f);  // unit vectors again
    }
    EXPECT_NEAR(bent[0].firstTexels[0].g, 0.4f, 1e-4f);
}

// Waves that the budget took from the normal map are in the roughness alone, also in that of level 0.
TEST_F(SceneTextures, RoughnessIsWidenedByWhatTheBudgetTookFromTheNormalMap) {
    for (const bool wantsLevels : {false, true})
        for (const uint32_t side : {1u, 8u}) {
            const uint64_t roughnessBytes = side == 1 ? 4 : (wantsLevels ? 4 * (64 + 16 + 4 + 1) : 4 * 64);
            const uint64_t wavesBytes = wantsLevels ? 4 * (64 + 16 + 4 + 1) : 4 * 64;
            const auto textures =
                Set({.textureLevels = wantsLevels, .textureBudget = roughnessBytes + wavesBytes},
                    Waves({side, side}, {16, 16}));
            EXPECT_EQ(statistics.reducedTextures, 1u);
            EXPECT_EQ(textures[0].extent, (Extent2D{side, side}));
            EXPECT_EQ(textures[1].extent, (Extent2D{8, 8}));
            EXPECT_EQ(textures[0].firstTexels.size(), wantsLevels && side > 1 ? 4u : 1u);
            for (const glm::vec4& texel : textures[0].firstTexels) {
                EXPECT_GT(texel.g, 0.5f) << wantsLevels << " " << side;
                EXPECT_EQ(texel.b, 1.0f);
            }
        }
}

// A sampler without levels reads the normal map's level 0 at any distance: its waves are all there.
TEST_F(SceneTextures, RoughnessIsNotWidenedByWavesThatAreStillRead) {
    // Waves of two texels: what the budget takes is flat
    scene::SceneData scene = Waves({16, 16}, {16, 16});
    for (uint32_t i = 0; i < 256; ++i) scene.images[1].rgba[4 * i] = i % 4 < 2 ? 78 : 177;
    scene.textures[1].sampler.usesMips = false;
    const auto textures =
        Set({.textureLevels = true, .textureBudget = 4 * (64 + 16 + 4 + 1) + 4 * 64}, std::move(scene));
    EXPECT_EQ(textures[0].extent, (Extent2D{8, 8}));
    EXPECT_EQ(textures[1].extent, (Extent2D{8, 8}));
    EXPECT_EQ(textures[1].firstTexels.size(), 1u);
    for (const glm::vec4& texel : textures[0].firstTexels) EXPECT_NEAR(texel.g, 0.4f, 1e-4f);
}

// One is read while the next one is copied, however many share a normal map.
TEST_F(SceneTextures, MakingLevelsTakesTheMemoryOfTwoImages) {
    constexpr uint32_t kSide = 1024, kRoughnessCount = 3;
    constexpr uint64_t kImage = 4 * kSide * kSide;
    scene::SceneData scene = Waves({kSide, kSide}, {kSide, kSide});
    for (uint32_t i = 1; i < kRoughnessCount; ++i) {
        scene.images.push_back(scene.images[0]);
        scene.textures.push_back(scene.textures[0]);
        scene.textures.back().image = i + 1;
        scene.materials.push_back(scene.materials[0]);
        scene.materials[i].metallicRoughnessTexture.texture = static_cast<int>(i) + 1;
    }
    rhi::Uploader uploader(Device(), {.stagingBytes = 128u << 10, .chunkCount = 2});
    Device().WaitIdle();
    // With the levels on the device (4/3 an image) the means of the normal map and of a roughness, as floats
    // (4/3 each), and levels on the way (1/3, of two frames)
    constexpr uint64_t kNeeded = (kRoughnessCount + 1) * kImage * 4 / 3 + 2 * kImage * 4 / 3 + kImage * 2 / 3;
    constexpr uint64_t kSpare = kImage / 2;
    Device().LimitMemory(Device().Memory().usedBytes + kNeeded + 2 * kImage + kSpare);
    std::vector<SceneTexture> textures;
    EXPECT_NO_THROW(uploader.FlushAfter([&] {
        TextureUpload upload(Device(), uploader, scene, {.makesMipLevels = true});
        for (uint32_t i = 0; i < scene.textures.size(); ++i) {
            uint64_t budget = UINT64_MAX;
            EXPECT_TRUE(upload.Continue(i, budget));
            textures.push_back(upload.Get(i));
        }
    }));
    Device().LimitMemory(0);
    Device().WaitIdle();
}

}  // namespace raygraph::testing::scene_textures_test
