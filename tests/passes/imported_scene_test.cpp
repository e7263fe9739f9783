#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <set>
#include <sstream>
#include <type_traits>

#include "passes/raster.h"
#include "renderer/scene/model/scene_fields.h"
#include "renderer/scene/model/variants.h"
#include "tests/passes/gltf_square.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

// From the text of a glTF file to the records on the device, and to what is seen: every field arrives. The
// numbers expected here are those of the text, not those of what the importer made of it.
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

// From the nodes of a glTF file to what is seen: which meshes are there, where, and whether they shine.
namespace raygraph::testing::imported_nodes_test {

namespace {

using test::GltfDocument;
using test::Json;

// A view along -z that is six high around the origin, of 24 pixels: four of them a unit.
passes::TraceSettings Facing() {
    scene::CameraView view = scene::CameraView::LookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = 6.0f;
    passes::TraceSettings settings;
    settings.extent = {24, 24};
    settings.camera = ToRecord(view);
    return settings;
}

// Red, where the pixel shows the point.
float SeenAt(const FloatImage& image, float x, float y) {
    return image.At(uint32_t((x + 3.0f) * 4.0f), uint32_t((3.0f - y) * 4.0f)).x;
}

// A triangle with its corner at a node's origin, which shines.
GltfDocument ShiningTriangle() {
    GltfDocument document;
    document.AddTriangle()["material"] = document.AddMaterial({{"emissiveFactor", {1, 1, 1}}});
    return document;
}

class ImportedNodes : public VulkanTest {
  protected:
    SceneRender render{Device()};
};

}  // namespace

TEST_F(ImportedNodes, EachOfTheInstancesOfANodeIsSeenAndShines) {
    GltfDocument document = ShiningTriangle();
    const size_t places = document.AddAccessor<float>({-2, 0, 0, 0, 0, 0, 1, 1, 0}, 3);
    document.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = places;
    render.scene.SetScene(test::Load(document));
    const FloatImage radiance = render.TraceOnce(Facing());
    for (const glm::vec2 corner : {glm::vec2(-2, 0), glm::vec2(0, 0), glm::vec2(1, 1)})
        EXPECT_EQ(SeenAt(radiance, corner.x + 0.3f, corner.y + 0.3f), 1.0f) << corner.x;
    EXPECT_EQ(SeenAt(radiance, -0.7f, 0.3f), 0.0f);
    EXPECT_EQ(render.scene.Statistics().emissiveTriangleCount, 3u);
    std::set<uint32_t> instances;
    for (const glm::uvec4& id : render.PrimaryHits(Facing()).ids) instances.insert(id.x);
    EXPECT_EQ(instances.size(), 4u) << "three, and none";
}

// Two nodes, each with a triangle that shines and one with a light, of which the second is hidden and shown.
TEST_F(ImportedNodes, HiddenNodesAreNotSeenAndDoNotShine) {
    GltfDocument document = ShiningTriangle();
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({{{"type", "point"}}});
    document.AddNode({{"translation", {-2, 0, 0}},
                      {"children", {2}},
                      {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
    document.Add("nodes", {{"mesh", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    render.scene.SetScene(test::Load(document));
    const auto expectSeen = [&](float hidden) {
        const FloatImage radiance = render.TraceOnce(Facing());
        EXPECT_EQ(SeenAt(radiance, 0.3f, 0.3f), 1.0f);
        EXPECT_EQ(SeenAt(radiance, -1.7f, 0.3f), hidden);
    };
    expectSeen(0.0f);
    EXPECT_FALSE(render.scene.IsVisible(1));
    EXPECT_FALSE(render.scene.IsLightVisible(0));
    EXPECT_EQ(render.scene.Statistics().emissiveTriangleCount, 1u);
    EXPECT_EQ(render.scene.Statistics().lightCount, 1u);
    render.scene.SetVisible(1, true);
    const SceneRevisions before = render.scene.Revisions();
    render.scene.SetLightVisible(0, true);
    EXPECT_EQ(render.scene.Revisions().lights, before.lights + 1);
    render.scene.SetLightVisible(0, true);
    EXPECT_EQ(render.scene.Revisions().lights, before.lights + 1) << "changes nothing";
    expectSeen(1.0f);
    EXPECT_EQ(render.scene.Statistics().emissiveTriangleCount, 2u);
    EXPECT_EQ(render.scene.Statistics().lightCount, 3u);
    EXPECT_THROW(render.scene.SetLightVisible(1, true), Error);
}

// A white floor under a light that is hidden, in both views.
TEST_F(ImportedNodes, HiddenLightLightsNothing) {
    GltfDocument document;
    document.AddTriangle()["material"] =
        document.AddMaterial({{"pbrMetallicRoughness", {{"metallicFactor", 0}}}});
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({{{"type", "point"}}});
    document.AddNode(
        {{"translation", {0.3f, 0.3f, 1}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    render.scene.SetScene(test::Load(document));
    passes::FilteredEnvironment environment{"environment"};
    const auto raster = [&] {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, Facing(), passes::FilmPosition::Center);
        const Readback drawn = render.renderer.ReadBack(
            passes::RasterShade(render.renderer, ids, Facing(), seen, environment, {}));
        render.renderer.Execute();
        return SeenAt(ToFloatImage(drawn), 0.3f, 0.3f);
    };
    EXPECT_GT(SeenAt(render.TraceOnce(Facing()), 0.3f, 0.3f), 0.1f);
    EXPECT_GT(raster(), 0.1f);
    render.scene.SetLightVisible(0, false);
    EXPECT_EQ(SeenAt(render.TraceOnce(Facing()), 0.3f, 0.3f), 0.0f);
    EXPECT_EQ(raster(), 0.0f);
}

}  // namespace raygraph::testing::imported_nodes_test

// From the vertices, images and samplers of a glTF file to what is seen of a surface.
namespace raygraph::testing::imported_surfaces_test {

namespace {

class ImportedSurfaces : public VulkanTest {
  protected:
    SceneRender render{Device()};
};

}  // namespace

// Attributes of vertices are seen as the file has them: colors and both sets of coordinates, of bytes and
// shorts too.
TEST_F(ImportedSurfaces, VertexAttributesOfEveryWidthAreSeen) {
    // Rows from the top: black, dark, light, white, by levels that sRGB encodes as 0, 64, 128 and 255
    const test::Bytes rows =
        test::MakePngOf(1, 4, {0, 0, 0, 255, 64, 64, 64, 255, 128, 128, 128, 255, 255, 255, 255, 255});
    const float levels[] = {0.0f, 0.0513f, 0.2159f, 1.0f};
    for (const int set : {0, 1}) {
        GltfDocument document;
        const Json nearest{{"magFilter", 9728}, {"minFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33071}};
        const size_t texture = AddTexture(document, rows, nearest);
        document.AddMaterial(
            {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}, {"texCoord", set}}}}}});
        Json primitive = Square(document, {}, 0);
        // Set 0: bytes, left column the second row, right column the last. Set 1: shorts, first and third
        primitive["attributes"]["TEXCOORD_0"] =
            document.AddAccessor<uint8_t>({0, 96, 0, 224, 0, 224, 0, 96}, 2, true);
        primitive["attributes"]["TEXCOORD_1"] =
            document.AddAccessor<uint16_t>({0, 8192, 0, 40960, 0, 40960, 0, 8192}, 2, true);
        primitive["attributes"]["COLOR_0"] = document.AddAccessor<uint8_t>(
            {255, 128, 0, 255, 255, 128, 0, 255, 255, 128, 0, 255, 255, 128, 0, 255}, 4, true);
        document.AddNode({{"mesh", document.AddMesh(primitive)}});
        render.scene.SetScene(test::Load(document));
        const FloatImage albedo = render.PrimaryHits(Facing(2.0f, 16)).albedo;
        const float left = levels[set == 0 ? 1 : 0], right = levels[set == 0 ? 3 : 2];
        const glm::vec3 color(1.0f, 128.0f / 255.0f, 0.0f);
        ExpectNear(albedo.At(0, 5), left * color, 3e-3f, "left");
        ExpectNear(albedo.At(15, 5), right * color, 3e-3f, "right");
    }
}

// glTF 2.0, 3.9.3: the green channel points up in texture space, that is to the image's top. The tangents are
// made by the importer.
TEST_F(ImportedSurfaces, NormalMapIsBumpyTowardsTheImagesTopAndRight) {
    // How the image lies on the square: upright, mirrored from left to right, upside down
    const std::vector<float> kMirrored{1, 1, 0, 1, 0, 0, 1, 0}, kUpsideDown{0, 0, 1, 0, 1, 1, 0, 1};
    const glm::vec3 read = 2.0f * glm::vec3(140, 155, 250) / 255.0f - 1.0f;
    const std::pair<std::vector<float>, glm::vec3> kCases[] = {{kUpright, {read.x, read.y, read.z}},
                                                               {kMirrored, {-read.x, read.y, read.z}},
                                                               {kUpsideDown, {read.x, -read.y, read.z}}};
    for (const auto& [uv, bent] : kCases) {
        GltfDocument document;
        const size_t texture = AddTexture(document, test::MakePng(2, 2, {140, 155, 250, 255}));
        document.AddMaterial({{"normalTexture", {{"index", texture}}}});
        document.AddNode({{"mesh", document.AddMesh(Square(document, uv, 0))}});
        render.scene.SetScene(test::Load(document));
        ExpectNear(render.PrimaryHits(Facing(1.0f, 4)).normal.At(1, 1), glm::normalize(bent), 2e-3f,
                   "normal");
    }
}

// Wrap modes and filters by glTF's own numbers. The image: black, then white.
TEST_F(ImportedSurfaces, SamplersOfTheFileWrapAndFilterWhatIsSeen) {
    const test::Bytes png = test::MakePngOf(2, 1, {0, 0, 0, 255, 255, 255, 255, 255});
    constexpr int kRepeat = 10497, kMirror = 33648, kClamp = 33071, kNearest = 9728, kLinear = 9729;
    struct Case {
        int wrap, filter;
        float at[4];  // u = -0.375, 0.375, 0.875, 1.375
    };
    // Texel centers are at 0.25 and 0.75; what is asked for lies between centers a quarter or half of the way
    const Case kCases[] = {
        {kRepeat, kNearest, {1, 0, 1, 0}},
        {kMirror, kNearest, {0, 0, 1, 1}},
        {kClamp, kNearest, {0, 0, 1, 1}},
        {kRepeat, kLinear, {0.75f, 0.25f, 0.75f, 0.25f}},
        {kMirror, kLinear, {0.25f, 0.25f, 1, 0.75f}},
        {kClamp, kLinear, {0, 0.25f, 1, 1}},
    };
    for (const Case& expected : kCases)
        for (const bool isAlongU : {true, false}) {
            GltfDocument document;
            Json sampler{{"magFilter", expected.filter}};
            sampler[isAlongU ? "wrapS" : "wrapT"] = expected.wrap;
            sampler[isAlongU ? "wrapT" : "wrapS"] = expected.wrap == kClamp ? kRepeat : kClamp;
            const size_t texture = AddTexture(
                document, isAlongU ? png : test::MakePngOf(1, 2, {0, 0, 0, 255, 255, 255, 255, 255}),
                sampler);
            document.AddMaterial({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}});
            const float places[] = {-0.375f, 0.375f, 0.875f, 1.375f};
            for (size_t i = 0; i < 4; ++i) {
                std::vector<float> uv;
                for (int corner = 0; corner < 4; ++corner) {
                    uv.push_back(isAlongU ? places[i] : 0.5f);
                    uv.push_back(isAlongU ? 0.5f : places[i]);
                }
                document.AddNode({{"mesh", document.AddMesh(Square(document, uv, 0))},
                                  {"translation", {-3 + 2 * static_cast<int>(i), 0, 0}}});
            }
            render.scene.SetScene(test::Load(document));
            const FloatImage albedo = render.PrimaryHits(Facing(8.0f, 8)).albedo;
            for (uint32_t i = 0; i < 4; ++i)
                EXPECT_NEAR(albedo.At(2 * i, 3).y, expected.at[i], 0.01f)
                    << "wrap " << expected.wrap << ", filter " << expected.filter << ", at " << places[i]
                    << (isAlongU ? " along u" : " along v");
        }
}

}  // namespace raygraph::testing::imported_surfaces_test

// KHR_materials_variants, from the file to what is seen: by the scene that is set, and by one that is shown.
namespace raygraph::testing::imported_variants_test {

namespace {

using test::GltfDocument;
using test::Json;

constexpr const char* kExtension = "KHR_materials_variants";

// A view along -z that is six high around the origin, of 24 pixels: four of them a unit.
passes::TraceSettings Facing() {
    scene::CameraView view = scene::CameraView::LookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = 6.0f;
    passes::TraceSettings settings;
    settings.extent = {24, 24};
    settings.camera = ToRecord(view);
    return settings;
}

glm::vec3 SeenAt(const FloatImage& image, float x, float y) {
    return image.At(uint32_t((x + 3.0f) * 4.0f), uint32_t((3.0f - y) * 4.0f));
}

Json Glowing(const Json& color) {
    return {{"emissiveFactor", color}, {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}}}};
}

// Two triangles: one in front of the origin, which variants give other materials, and to the left one that
// stays as it is. Behind them a wall that glows, below a shelf that leans towards the viewer, in their light.
class ImportedVariants : public VulkanTest {
  protected:
    enum Material : uint32_t { Red, Green, Hole, Lamp, Dark, Glass, TwoSided, MaterialCount };
    static constexpr uint32_t kWall = MaterialCount;

    ImportedVariants() {
        Json& triangle = document.AddTriangle();
        triangle["attributes"]["TEXCOORD_0"] = document.AddAccessor<float>({0, 0, 1, 0, 0, 1}, 2);
        triangle["material"] = Red;
        document.Add("images",
                     {{"uri", test::DataUri(test::MakePngOf(2, 1, {255, 255, 255, 255, 0, 0, 0, 0}))}});
        document.Add("samplers", {{"magFilter", 9728}, {"minFilter", 9728}, {"wrapS", 33071}});
        document.Add("textures", {{"source", 0}, {"sampler", 0}});
        document.AddMaterial(Glowing({1, 0, 0}));
        document.AddMaterial(Glowing({0, 1, 0}));
        Json hole = Glowing({0, 0, 1}), lamp = Glowing({4, 4, 4}), twoSided = Glowing({1, 1, 0});
        hole["alphaMode"] = "MASK";
        hole["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
        lamp["emissiveTexture"]["index"] = 0;
        twoSided["doubleSided"] = true;
        document.AddMaterial(hole);
        document.AddMaterial(lamp);
        document.AddMaterial({{"pbrMetallicRoughness", {{"metallicFactor", 0}}}});
        document.AddMaterial({{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0}}},
                              {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}}}});
        document.AddMaterial(twoSided);
        document.AddMaterial(Glowing({0.25, 0.25, 0.25}));
        Json variants, mappings;
        for (uint32_t i = 0; i < MaterialCount; ++i) {
            variants.push_back({{"name", "variant " + std::to_string(i)}});
            mappings.push_back({{"material", i}, {"variants", {i}}});
        }
        variants.push_back({{"name", "not mapped"}});
        document.json["extensions"][kExtension]["variants"] = variants;
        Json& first = document.json["meshes"][0]["primitives"][0];
        first["extensions"][kExtension]["mappings"] = mappings;
        Json other = first;
        other["material"] = Green;
        other.erase("extensions");
        document.AddNode({{"mesh", document.AddMesh(other)}, {"translation", {-2, 0, 0}}});
        other["material"] = kWall;
        document.AddNode(
            {{"mesh", document.AddMesh(other)}, {"translation", {-3, -1, -2}}, {"scale", {6, 6, 1}}});
        other["material"] = Dark;
        document.AddNode({{"mesh", document.AddMesh(other)},
                          {"translation", {-2, -2.5, 1.5}},
                          {"rotation", {-0.38268343, 0, 0, 0.92387953}},
                          {"scale", {4, 2, 1}}});
    }

    void Set(uint32_t variant) {
        scene::SceneData data = test::Load(document);
        scene::SetVariant(data, variant);
        render.scene.SetScene(std::move(data));
        EXPECT_EQ(render.scene.Variant(), variant);
    }
    FloatImage Raster() {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, Facing(), passes::FilmPosition::Center);
        const Readback drawn = render.renderer.ReadBack(
            passes::RasterShade(render.renderer, ids, Facing(), seen, environment, {}));
        render.renderer.Execute();
        return ToFloatImage(drawn);
    }
    // Returns the ids that the frame is declared with.
    SceneIds Ids() {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        render.renderer.DropFrame();
        return ids;
    }

    GltfDocument document;
    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

}  // namespace

TEST_F(ImportedVariants, PictureIsOfTheMaterialsOfTheVariant) {
    const auto seenAs = [&](uint32_t variant, const glm::vec3& color) {
        Set(variant);
        const FloatImage radiance = render.TraceOnce(Facing());
        EXPECT_EQ(SeenAt(radiance, 0.1f, 0.3f), color) << variant;
        EXPECT_EQ(SeenAt(radiance, -1.9f, 0.3f), glm::vec3(0, 1, 0)) << "is in all of them";
        EXPECT_EQ(render.PrimaryHits(Facing()).ids.size(), 24u * 24u);
    };
    seenAs(scene::kNone, {1, 0, 0});
    seenAs(Green, {0, 1, 0});
    seenAs(TwoSided, {1, 1, 0});
    seenAs(MaterialCount, {1, 0, 0});
}

// All that follows from materials: opacity, culling, straight transmission, lights, what is compiled in.
TEST_F(ImportedVariants, ShownIsWhatItWouldHaveBeenSetTo) {
    struct Picture {
        FloatImage traced, raster;
        uint32_t lights = 0;
        TraceFeatures features;
        uint64_t emissive = 0;
    };
    const auto take = [&] {
        Picture picture;
        for (int frame = 0; frame < 2; ++frame) picture.traced = render.TraceOnce(Facing());
        picture.raster = Raster();
        const SceneIds ids = Ids();
        picture.lights = render.scene.Statistics().lightCount;
        picture.emissive = render.scene.Statistics().emissiveTriangleCount;
        picture.features = ids.features;
        return picture;
    };
    std::vector<Picture> set;
    for (uint32_t variant = 0; variant < MaterialCount; ++variant) {
        Set(variant);
        set.push_back(take());
    }
    EXPECT_EQ(set[Dark].emissive + 1, set[Red].emissive);
    EXPECT_TRUE(set[Hole].features.Has(kTraceAnyHit) && set[Glass].features.Has(kTraceThinWalls));
    EXPECT_FALSE(set[Red].features.Has(kTraceAnyHit));
    EXPECT_NE(set[Red].raster.values, set[Green].raster.values);
    EXPECT_NE(set[Red].raster.values, set[Hole].raster.values);
    Set(scene::kNone);
    // From each to the next, and from the last to the first
    for (uint32_t turn = 0; turn <= MaterialCount; ++turn) {
        const uint32_t variant = turn % MaterialCount;
        SCOPED_TRACE(variant);
        render.scene.SetVariant(variant);
        EXPECT_EQ(render.scene.Variant(), variant);
        const Picture shown = take();
        EXPECT_EQ(shown.traced.values, set[variant].traced.values);
        EXPECT_EQ(shown.raster.values, set[variant].raster.values);
        EXPECT_EQ(shown.lights, set[variant].lights);
        EXPECT_EQ(shown.emissive, set[variant].emissive);
        EXPECT_EQ(shown.features, set[variant].features);
        const uint32_t next = (variant + 1) % MaterialCount;
        EXPECT_NE(shown.traced.values, set[next].traced.values);
    }
}

// Two primitives of one mesh, which are one list of triangles until a variant parts them.
TEST_F(ImportedVariants, PrimitivesOfOneMeshAreShownEachWithItsOwn) {
    Json second = document.json["meshes"][1]["primitives"][0];
    second["attributes"]["POSITION"] = document.AddAccessor<float>({1, 1, 0, 2, 1, 0, 1, 2, 0}, 3);
    document.json["meshes"][0]["primitives"].push_back(second);
    Set(scene::kNone);
    const auto expectSeen = [&](uint32_t variant, const glm::vec3& solid, const glm::vec3& cut) {
        render.scene.SetVariant(variant);
        const FloatImage radiance = render.TraceOnce(Facing());
        EXPECT_EQ(SeenAt(radiance, 0.1f, 0.3f), solid) << variant;
        EXPECT_EQ(SeenAt(radiance, 1.1f, 1.3f), glm::vec3(0, 1, 0)) << variant;
        EXPECT_EQ(SeenAt(radiance, 0.8f, 0.1f), cut) << variant;
        EXPECT_EQ(render.PrimaryHits(Facing()).ids.size(), 24u * 24u);
    };
    expectSeen(scene::kNone, {1, 0, 0}, {1, 0, 0});
    expectSeen(Green, {0, 1, 0}, {0, 1, 0});
    expectSeen(Hole, {0, 0, 1}, glm::vec3(0.25f));
    const auto materialAt = [&](float x, float y) {
        const auto ids = render.PrimaryHits(Facing()).ids;
        return ids[size_t{uint32_t((3.0f - y) * 4.0f)} * 24 + uint32_t((x + 3.0f) * 4.0f)].y;
    };
    EXPECT_EQ(materialAt(0.8f, 0.1f), kWall) << "through the hole";
    EXPECT_EQ(materialAt(0.1f, 0.3f), Hole);
    EXPECT_EQ(materialAt(1.1f, 1.3f), Green);
    expectSeen(TwoSided, {1, 1, 0}, {1, 1, 0});
}

TEST_F(ImportedVariants, SwitchingCountsAsAChangeAndKeepsEdits) {
    Set(scene::kNone);
    for (int frame = 0; frame < 4; ++frame) render.TraceOnce(Facing());  // compaction is done by then
    ASSERT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::None);
    const SceneRevisions before = render.scene.Revisions();
    render.scene.SetVariant(scene::kNone);
    EXPECT_EQ(render.scene.Revisions(), before) << "it is shown already";
    scene::Material purple = test::Load(document).materials[Green];
    purple.emissiveFactor = {0.5f, 0, 0.5f};
    render.scene.SetMaterial(Green, purple);
    const SceneRevisions edited = render.scene.Revisions();
    render.scene.SetVariant(Green);
    EXPECT_NE(render.scene.Revisions().materials, edited.materials);
    EXPECT_NE(render.scene.Revisions().geometry, edited.geometry);
    EXPECT_EQ(SeenAt(render.TraceOnce(Facing()), 0.1f, 0.3f), purple.emissiveFactor);
    EXPECT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::None) << "rays treat both alike";
    EXPECT_THROW(render.scene.SetVariant(MaterialCount + 1), Error);
    EXPECT_EQ(render.scene.Variant(), Green);
    render.renderer.BeginFrame();
    std::ignore = render.scene.Declare(render.renderer);
    EXPECT_THROW(render.scene.SetVariant(Red), Error) << "a frame is open";
    render.renderer.DropFrame();
    render.scene.SetVariant(Red);
    // A frame that was dropped has not shown it
    render.renderer.BeginFrame();
    std::ignore = render.scene.Declare(render.renderer);
    render.renderer.DropFrame();
    EXPECT_EQ(SeenAt(render.TraceOnce(Facing()), 0.1f, 0.3f), glm::vec3(1, 0, 0));
    render.scene.SetScene({});
    EXPECT_EQ(render.scene.Variant(), scene::kNone);
    EXPECT_THROW(render.scene.SetVariant(0), Error);
}

}  // namespace raygraph::testing::imported_variants_test
