// Textures of materials on the device: slots, channels, color spaces, texture coordinate sets, wrap modes,
// filters, normal maps. Expected values are worked out here and in support/direct_light_reference.
#include <cmath>
#include <string>

#include "passes/views.h"
#include "tests/support/direct_light_reference.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

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
    // What the texture does to the material, said by its factors.
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

// The quad between a light before it and an emitting wall behind it. The wall has a texture, and it is
// transformed, so that a picture without one on the quad is made by the same pipeline.
scene::SceneData QuadOf(const Material& material) {
    Material wall = Lambert({}, {0.4f, 0.8f, 1.2f});
    wall.emissiveTexture = {.texture = 1, .texCoord = 0, .transform = {.scale = {1.0f, 0.5f}}};
    scene::SceneData scene =
        SceneOf({TwoTexelQuad(0), TwoTexelQuad(1)}, {material, wall},
                {glm::mat4x3(1.0f), glm::mat4x3(9.0f, 0, 0, 0, 9.0f, 0, 0, 0, 9.0f, 0, 0, -1.0f)});
    AddTwoTexels(scene);
    scene::Light light;
    light.intensity = 20.0f;
    light.lightToWorld = Translation({0.5f, 1.5f, 2.0f});
    scene.lights.push_back(light);
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

// The same paths are traced whatever the texels are, but where a path turns on a chance that they move: the
// picture of a texture is that of the factors it stands for, to rounding.
TEST_F(MaterialTextures, EverySlotIsMultipliedWithItsFactorByChannelSpaceAndUvSet) {
    for (const scene::AlphaMode alphaMode : {scene::AlphaMode::Opaque, scene::AlphaMode::Blend}) {
        for (const Slot& slot : Slots()) {
            // What goes back goes where a mirror sends it if it is seen from straight above
            const bool goesBack = slot.texture == &Material::retroreflectionTexture;
            TraceSettings settings =
                Orthographic(1.8f, {16, 16}, goesBack ? glm::vec3(1.0f, 3.0f, 4.0f) : glm::vec3(0, 0, 4));
            settings.biases.maxDepth = 2;
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
