// From the text of a glTF file to the records on the device, and to what is seen: every field arrives. The
// numbers expected here are those of the text, not those of what the importer made of it.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <sstream>
#include <type_traits>

#include "renderer/scene/model/material_fields.h"
#include "tests/passes/gltf_square.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::imported_scene_test {

namespace {

using test::GltfDocument;
using test::Json;

template <typename T>
std::vector<T> Records(const Readback& readback) {
    readback.Wait();
    std::vector<T> records(readback.Bytes().size() / sizeof(T));
    std::memcpy(records.data(), readback.Bytes().data(), records.size() * sizeof(T));
    return records;
}

class ImportedScene : public VulkanTest {
  protected:
    template <typename T>
    std::vector<T> TableOf(const GltfDocument& document, BufferId SceneIds::*table) {
        return TableOf<T>(test::Load(document), table);
    }
    template <typename T>
    std::vector<T> TableOf(scene::SceneData scene, BufferId SceneIds::*table) {
        render.scene.SetScene(std::move(scene));
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback readback = render.renderer.ReadBack(ids.*table);
        render.renderer.Execute();
        return Records<T>(readback);
    }
    SceneRender render{Device()};
};

// A value that no default is, and that every field of its type may have.
void Change(float& value) {
    value = 0.625f;
}
template <int Length>
void Change(glm::vec<Length, float>& value) {
    value = glm::vec<Length, float>(0.625f);
}
void Change(bool& value) {
    value = true;
}
void Change(uint32_t& value) {
    value = 7;
}
void Change(scene::AlphaMode& value) {
    value = scene::AlphaMode::Blend;
}
void Change(scene::TextureRef& value) {
    value = {0, 1};
}

}  // namespace

TEST_F(ImportedScene, EveryFactorOfAMaterialIsInItsRecord) {
    GltfDocument document;
    document.AddMaterial(Json::object());
    document.AddMaterial(R"({
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.11, 0.22, 0.33, 0.44], "metallicFactor": 0.55, "roughnessFactor": 0.66
        },
        "emissiveFactor": [0.1, 0.2, 0.4], "alphaMode": "MASK", "alphaCutoff": 0.77, "doubleSided": true,
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 5},
            "KHR_materials_specular": {"specularFactor": 0.88, "specularColorFactor": [0.9, 0.8, 1.5]},
            "KHR_materials_ior": {"ior": 1.7}, "KHR_materials_transmission": {"transmissionFactor": 0.35},
            "KHR_materials_clearcoat": {"clearcoatFactor": 0.45, "clearcoatRoughnessFactor": 0.15},
            "KHR_materials_sheen": {"sheenColorFactor": [0.7, 0.8, 0.9], "sheenRoughnessFactor": 0.25},
            "KHR_materials_diffuse_transmission": {
                "diffuseTransmissionFactor": 0.65, "diffuseTransmissionColorFactor": [0.15, 0.25, 0.35]
            },
            "KHR_materials_anisotropy": {"anisotropyStrength": 0.65, "anisotropyRotation": -1.5},
            "KHR_materials_retroreflection": {"retroreflectionFactor": 0.55},
            "KHR_materials_volume": {
                "thicknessFactor": 0.1, "attenuationColor": [0.5, 0.25, 0.125], "attenuationDistance": 2
            }
        },
        "extras": {"priority": 7}
    })"_json);
    document.AddMaterial({{"alphaMode", "BLEND"},
                          {"doubleSided", true},
                          {"extensions", {{"KHR_materials_unlit", Json::object()}}}});
    document.AddTriangle()["material"] = 1;
    const auto records = TableOf<gpu::MaterialRecord>(document, &SceneIds::materials);
    ASSERT_GE(records.size(), 3u);
    const gpu::MaterialRecord& plain = records[0];
    EXPECT_EQ(plain.baseColor, glm::vec4(1.0f));
    EXPECT_EQ(plain.emission, glm::vec3(0.0f));
    EXPECT_EQ(glm::vec2(plain.metallic, plain.roughness), glm::vec2(1.0f));
    EXPECT_EQ(plain.alphaMode, 0u);
    EXPECT_EQ(plain.flags, 0u);
    EXPECT_EQ(plain.ior, 1.5f);
    EXPECT_EQ(glm::vec2(plain.specular, plain.transmission), glm::vec2(1.0f, 0.0f));
    const gpu::MaterialRecord& record = records[1];
    EXPECT_EQ(record.baseColor, glm::vec4(0.11f, 0.22f, 0.33f, 0.44f));
    EXPECT_EQ(glm::vec2(record.metallic, record.roughness), glm::vec2(0.55f, 0.66f));
    EXPECT_EQ(glm::vec2(record.clearcoat, record.clearcoatRoughness), glm::vec2(0.45f, 0.15f));
    EXPECT_EQ(glm::vec4(record.sheenColor, record.sheenRoughness), glm::vec4(0.7f, 0.8f, 0.9f, 0.25f));
    EXPECT_EQ(glm::vec4(record.diffuseTransmissionColor, record.diffuseTransmission),
              glm::vec4(0.15f, 0.25f, 0.35f, 0.65f));
    EXPECT_EQ(glm::vec2(record.anisotropy, record.anisotropyRotation), glm::vec2(0.65f, -1.5f));
    EXPECT_EQ(record.retroreflection, 0.55f);
    ExpectNear(record.emission, {0.5f, 1.0f, 2.0f}, 1e-6f, "emission");
    EXPECT_EQ(record.alphaMode, 1u);
    EXPECT_EQ(record.alphaCutoff, 0.77f);
    EXPECT_EQ(record.flags, gpu::kMaterialTwoSided | gpu::kMaterialVolume | gpu::kMaterialGlass);
    EXPECT_EQ(record.ior, 1.7f);
    EXPECT_EQ(record.specular, 0.88f);
    EXPECT_EQ(record.specularColor, glm::vec3(0.9f, 0.8f, 1.5f));
    EXPECT_EQ(record.transmission, 0.35f);
    // exp(-extinction * 2 m) is the color
    const float ln2 = std::numbers::ln2_v<float>;
    ExpectNear(record.extinction, glm::vec3(0.5f, 1.0f, 1.5f) * ln2, 1e-5f, "extinction");
    EXPECT_EQ(record.priority, 7u);
    EXPECT_EQ(records[2].alphaMode, 2u);
    EXPECT_EQ(records[2].flags, gpu::kMaterialUnlit | gpu::kMaterialTwoSided);
}

// Over the list of the fields, so that a field which is added and then forgotten is found: a record changes with
// each, but for those that path tracer and raster view have no use for.
TEST_F(ImportedScene, EveryFieldOfAMaterialChangesItsRecord) {
    scene::SceneData scene;
    scene.images.push_back({"", 1, 1, {1, 2, 3, 4}});
    scene.textures.push_back({});
    scene::Material medium{.specularColorTexture = {0, 0}};  // whose alpha is that of isSpecularGlossiness
    medium.emissiveFactor = medium.attenuationColor = glm::vec3(0.5f);
    medium.transmissionFactor = medium.attenuationDistance = 0.5f;
    scene.materials.push_back(medium);
    std::vector<std::string> names;
    scene::ForEachMaterialField([&](const auto& field) {
        const std::string name = field.name;
        if (name.starts_with("occlusion")) return;
        if (name == "isDoubleSided") return;  // this one is, as all that transmit
        scene::Material changed = medium;
        Change(changed.*field.member);
        if constexpr (std::is_same_v<typename std::decay_t<decltype(field)>::Value, float>)
            changed.*field.member = std::max(changed.*field.member, field.range.min);
        scene.materials.push_back(changed);
        names.push_back(name);
    });
    const auto records = TableOf<gpu::MaterialRecord>(std::move(scene), &SceneIds::materials);
    ASSERT_EQ(records.size(), names.size() + 1);
    for (size_t i = 0; i < names.size(); ++i)
        EXPECT_NE(std::memcmp(&records[i + 1], records.data(), sizeof(gpu::MaterialRecord)), 0) << names[i];
}

// The slots of the table are numbered by the device: what tells textures apart here is that each is in one
// place alone. By what glTF says, colors are sRGB and all else is linear.
TEST_F(ImportedScene, EveryTextureOfAMaterialIsInItsField) {
    GltfDocument document;
    document.AddTriangle()["material"] = 0;
    Json material;
    std::vector<std::pair<std::string, scene::TextureRef scene::Material::*>> textures;
    scene::ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), scene::TextureRef scene::Material::*>) {
            if (!scene::IsShown(field.member)) return;
            const auto index = static_cast<uint32_t>(textures.size());
            AddTexture(document, test::MakePng(index + 1, 1, {1, 2, 3, 4}));
            const std::string object = field.object;
            const std::string parent = object.starts_with("KHR_") ? "/extensions/"
                                       : object.empty()           ? ""
                                                                  : "/";
            material[Json::json_pointer(parent + object + "/" + field.key)] = {{"index", index},
                                                                               {"texCoord", 1 - index % 2}};
            textures.emplace_back(field.name, field.member);
        }
    });
    material["normalTexture"]["scale"] = 0.25;
    material["extensions"]["KHR_materials_clearcoat"]["clearcoatNormalTexture"]["scale"] = 0.5;
    document.AddMaterial(material);
    const scene::SceneData scene = test::Load(document);
    const scene::Material& imported = scene.materials.at(0);
    const auto record = TableOf<gpu::MaterialRecord>(document, &SceneIds::materials).at(0);
    EXPECT_EQ(glm::vec2(record.normalScale, record.clearcoatNormalScale), glm::vec2(0.25f, 0.5f));
    std::vector<std::pair<std::string, uint32_t>> slots;
#define RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space) \
    slots.emplace_back(#name "Texture", record.name##Texture);
#include "shaders/shared/material_list.h"
    ASSERT_EQ(slots.size(), textures.size());
    const uint32_t firstSlot = slots[0].second & ~gpu::kSecondTexCoord;
    const scene::TextureRef& first = imported.*textures[0].second;
    for (uint32_t i = 0; i < textures.size(); ++i) {
        const auto& [name, member] = textures[i];
        SCOPED_TRACE(name);
        const scene::TextureRef& read = imported.*member;
        ASSERT_TRUE(read.IsPresent());
        const scene::Texture& texture = scene.textures.at(static_cast<size_t>(read.texture));
        EXPECT_EQ(scene.images.at(texture.image).width, i + 1);
        const bool isColor = name.find("olor") != name.npos || name == "emissiveTexture";
        EXPECT_EQ(texture.colorSpace, isColor ? scene::ColorSpace::Srgb : scene::ColorSpace::Linear);
        EXPECT_EQ(slots[i].first, name);
        const uint32_t slot = slots[i].second;
        // A fresh table gives out slots in the order of the scene's textures
        EXPECT_EQ((slot & ~gpu::kSecondTexCoord) - firstSlot,
                  static_cast<uint32_t>(read.texture - first.texture));
        EXPECT_EQ((slot & gpu::kSecondTexCoord) != 0, i % 2 == 0);
    }
}

TEST_F(ImportedScene, EveryFieldOfAPunctualLightIsInItsRecord) {
    GltfDocument document;
    document.AddTriangle();
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = R"([
        {"type": "directional", "color": [0.5, 0.25, 1], "intensity": 4},
        {"type": "spot", "color": [1, 0.5, 0.25], "intensity": 8,
         "spot": {"innerConeAngle": 0.3, "outerConeAngle": 0.7}},
        {"type": "point", "color": [0.25, 1, 0.5], "intensity": 2}
    ])"_json;
    // A quarter turn about +x carries -z to +y
    const double half = std::numbers::sqrt2 / 2.0;
    for (int i = 0; i < 3; ++i)
        document.AddNode({{"extensions", {{"KHR_lights_punctual", {{"light", i}}}}},
                          {"translation", {1 + i, 2, 3}},
                          {"rotation", {half, 0, 0, half}}});
    const auto records = TableOf<gpu::LightRecord>(document, &SceneIds::lights);
    ASSERT_EQ(records.size(), 3u);
    // Bounded ones come first
    const gpu::LightRecord &spot = records[0], &point = records[1], &sun = records[2];
    EXPECT_EQ(spot.kind, gpu::kLightSpot);
    ExpectNear(spot.p0, {2, 2, 3}, 1e-6f, "place of the spot");
    ExpectNear(spot.e1, {0, 1, 0}, 1e-6f, "direction of the spot");
    ExpectNear(spot.e2, {8, 4, 2}, 1e-6f, "intensity of the spot");
    // KHR_lights_punctual: 1 / (cos inner - cos outer), and -cos outer times that
    const float scale = 1.0f / (std::cos(0.3f) - std::cos(0.7f));
    EXPECT_NEAR(spot.spotScale, scale, 1e-4f);
    EXPECT_NEAR(spot.spotOffsetOrClearance, -std::cos(0.7f) * scale, 1e-4f);
    EXPECT_EQ(point.kind, gpu::kLightPoint);
    ExpectNear(point.p0, {3, 2, 3}, 1e-6f, "place of the point");
    ExpectNear(point.e2, {0.5f, 2, 1}, 1e-6f, "intensity of the point");
    EXPECT_EQ(sun.kind, gpu::kLightDirectional);
    ExpectNear(sun.e1, {0, 1, 0}, 1e-6f, "direction of the sun");
    ExpectNear(sun.e2, {2, 1, 4}, 1e-6f, "illuminance of the sun");
}

// A white square under one light of each kind, by closed form.
TEST_F(ImportedScene, EveryKindOfPunctualLightLightsAsItsFileSays) {
    const Json kLights = R"([
        {"type": "directional", "intensity": 4},
        {"type": "point", "intensity": 8},
        {"type": "spot", "intensity": 8, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.5}},
        {"type": "spot", "intensity": 8, "spot": {"innerConeAngle": 0.01, "outerConeAngle": 0.3}}
    ])"_json;
    const double pi = std::numbers::pi;
    // At (0.8, 0, 2), facing -z: a point of the square's middle is at an angle of 0.381 from the axis
    const double square = 0.8 * 0.8 + 2.0 * 2.0, cosine = 2.0 / std::sqrt(square);
    const double share = (cosine - std::cos(0.5)) / (std::cos(0.2) - std::cos(0.5));
    const double kExpected[] = {4.0 / pi, 8.0 * cosine / (pi * square),
                                8.0 * cosine * share * share / (pi * square), 0.0};
    for (size_t i = 0; i < 4; ++i) {
        GltfDocument document;
        document.AddMaterial(Json::object());
        document.AddNode({{"mesh", document.AddMesh(Square(document, {}, 0))}});
        document.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({kLights[i]});
        document.AddNode(
            {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}, {"translation", {0.8, 0, 2}}});
        render.scene.SetScene(test::Load(document));
        const glm::vec3 seen = render.TraceOnce(Facing(1e-4f, 4)).At(1, 1);
        ExpectNear(seen, glm::vec3(float(kExpected[i])), float(2e-3 * kExpected[i]) + 1e-6f,
                   kLights[i].dump().c_str());
    }
}

TEST_F(ImportedScene, EveryFieldOfACameraIsInItsRecord) {
    GltfDocument document;
    document.AddTriangle();
    document.json["cameras"] = R"([
        {"type": "perspective", "perspective": {"yfov": 0.9, "aspectRatio": 3, "znear": 0.2, "zfar": 50}},
        {"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 1.5, "znear": 0.3, "zfar": 40}}
    ])"_json;
    // A quarter turn about +y carries -z to -x and +x to -z; scale does not count
    const double half = std::numbers::sqrt2 / 2.0;
    for (int i = 0; i < 2; ++i)
        document.AddNode({{"camera", i},
                          {"translation", {5 + i, 6, 7}},
                          {"rotation", {0, half, 0, half}},
                          {"scale", {2, 3, 4}}});
    const scene::SceneData scene = test::Load(document);
    ASSERT_EQ(scene.cameras.size(), 2u);
    const gpu::CameraRecord perspective = ToRecord(scene::ChooseView(scene, "0", 2.0f));
    ExpectNear(perspective.origin, {5, 6, 7}, 1e-5f, "eye");
    ExpectNear(perspective.forward, {-1, 0, 0}, 1e-5f, "forward");
    const float tangent = std::tan(0.45f);
    ExpectNear(perspective.right, {0, 0, -2.0f * tangent}, 1e-5f, "right");
    ExpectNear(perspective.up, {0, tangent, 0}, 1e-5f, "up");
    EXPECT_EQ(perspective.orthographic, 0u);
    EXPECT_EQ(perspective.lensRadius, 0.0f);
    EXPECT_EQ(perspective.zNear, 0.2f);
    EXPECT_EQ(perspective.zFar, 50.0f);
    const gpu::CameraRecord parallel = ToRecord(scene::ChooseView(scene, "1", 2.0f));
    ExpectNear(parallel.origin, {6, 6, 7}, 1e-5f, "eye");
    ExpectNear(parallel.right, {0, 0, -3}, 1e-5f, "right");
    ExpectNear(parallel.up, {0, 1.5f, 0}, 1e-5f, "up");
    EXPECT_EQ(parallel.orthographic, 1u);
    EXPECT_EQ(parallel.zNear, 0.3f);
    EXPECT_EQ(parallel.zFar, 40.0f);
}

TEST_F(ImportedScene, NestedNodesPlaceTheirMeshes) {
    GltfDocument document;
    document.AddMaterial(Json::object());
    const size_t mesh = document.AddMesh(Square(document, {}, 0));
    document.AddNode({{"scale", {2, 2, 2}}, {"translation", {0, 0, -1}}, {"children", {1}}});
    document.Add("nodes", {{"mesh", mesh}, {"translation", {1, 0, 0}}});
    const auto records = TableOf<gpu::InstanceRecord>(document, &SceneIds::instances);
    ASSERT_EQ(records.size(), 1u);
    ExpectNear(records[0].objectToWorld[0], {2, 0, 0}, 1e-6f, "x axis");
    ExpectNear(records[0].objectToWorld[1], {0, 2, 0}, 1e-6f, "y axis");
    ExpectNear(records[0].objectToWorld[2], {0, 0, 2}, 1e-6f, "z axis");
    ExpectNear(records[0].objectToWorld[3], {2, 0, -1}, 1e-6f, "place");
}

}  // namespace raygraph::testing::imported_scene_test
