// The lists of a material's and a light's fields, and that importer, saver and Check go by them.
#include "renderer/scene/material_fields.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/scene/check.h"
#include "renderer/scene/gltf_choice.h"
#include "renderer/scene/light_fields.h"
#include "renderer/scene/load_gltf.h"
#include "renderer/scene/save_gltf.h"
#include "tests/scene/same_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::scene {
namespace {

template <typename Field>
constexpr bool kIsNumber =
    std::is_same_v<Field, MaterialField<float>> || std::is_same_v<Field, MaterialField<glm::vec3>> ||
    std::is_same_v<Field, MaterialField<glm::vec4>>;

std::string Refusal(const Material& material) {
    return testing::ErrorTextOf([&] { Check(material, "paint"); });
}

// The hash of a scene goes over the fields in this order: another one would have old renders not be resumed.
TEST(MaterialFields, EachHasANameAndAPlaceOfItsOwnAndTheirOrderStays) {
    std::vector<std::string> names;
    std::set<std::string> places;
    ForEachMaterialField([&](const auto& field) {
        names.emplace_back(field.name);
        places.insert(std::string(field.object) + "/" + field.key);
    });
    EXPECT_EQ(places.size(), names.size());
    const std::vector<std::string> expected{"baseColorFactor",
                                            "baseColorTexture",
                                            "metallicFactor",
                                            "roughnessFactor",
                                            "metallicRoughnessTexture",
                                            "normalTexture",
                                            "normalScale",
                                            "occlusionTexture",
                                            "occlusionStrength",
                                            "emissiveFactor",
                                            "emissiveStrength",
                                            "emissiveTexture",
                                            "alphaMode",
                                            "alphaCutoff",
                                            "isDoubleSided",
                                            "ior",
                                            "specularFactor",
                                            "specularTexture",
                                            "specularColorFactor",
                                            "specularColorTexture",
                                            "transmissionFactor",
                                            "transmissionTexture",
                                            "thicknessFactor",
                                            "attenuationColor",
                                            "attenuationDistance",
                                            "isUnlit",
                                            "priority"};
    EXPECT_EQ(names, expected);
    EXPECT_STREQ(FieldOf(&Material::thicknessFactor).unit, "m");
    EXPECT_STREQ(FieldOf(&Material::specularColorFactor).name, "specularColorFactor");
}

TEST(MaterialFields, CheckRefusesWhatIsOutOfTheRangeOfEachAndNamesIt) {
    EXPECT_EQ(Refusal({}), "accepted") << "the defaults";
    ForEachMaterialField([&](const auto& field) {
        if constexpr (kIsNumber<std::decay_t<decltype(field)>>) {
            const auto refused = [&](float value) {
                Material material;
                material.*field.member = std::decay_t<decltype(material.*field.member)>(value);
                const std::string message = Refusal(material);
                EXPECT_TRUE(message.starts_with("paint: " + std::string(field.name) + " is "))
                    << value << ": " << message;
            };
            refused(std::nanf(""));
            refused(std::numeric_limits<float>::infinity());
            if (field.range.max < kUnboundedField) refused(std::nextafter(field.range.max, kUnboundedField));
            if (field.range.min > -kUnboundedField)
                refused(std::nextafter(field.range.min, -kUnboundedField));
        }
    });
}

// A value that is neither the default nor what `other` has, and that it may have.
void Change(float& value) {
    value = 0.625f;
}
void Change(glm::vec3& value) {
    value = {0.25f, 0.5f, 0.75f};
}
void Change(glm::vec4& value) {
    value = {0.25f, 0.5f, 0.75f, 0.875f};
}
void Change(bool& value) {
    value = !value;
}
void Change(AlphaMode& value) {
    value = AlphaMode::Mask;
}
void Change(uint32_t& value) {
    value = 7;
}
void Change(TextureRef&) {}  // not edited

// A file with a triangle of one material.
void Write(const std::filesystem::path& path, const nlohmann::json& material) {
    nlohmann::json document =
        nlohmann::json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
"min": [0, 0, 0], "max": [1, 1, 0]}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
"buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
"images": [{"uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR4nGNoaPj/HwAGggL/s75RMwAAAABJRU5ErkJggg=="}],
"textures": [{"source": 0}]})");
    document["materials"] = nlohmann::json::array({material});
    if (material.contains("extensions"))
        for (const auto& [name, extension] : material["extensions"].items())
            document["extensionsUsed"].push_back(name);
    std::ofstream(path) << document;
}

const nlohmann::json kTextured = {{"normalTexture", {{"index", 0}}}, {"occlusionTexture", {{"index", 0}}}};

// Every field of a material goes to its place in the file and comes back from there.
TEST(MaterialFields, EachComesBackFromAFile) {
    const test::TemporaryFolder folder;
    const std::filesystem::path source = folder.Path() / "source.gltf", target = folder.Path() / "saved.gltf";
    Write(source, kTextured);
    const SceneData loaded = LoadGltf(source);
    ForEachMaterialField([&](const auto& field) {
        SCOPED_TRACE(field.name);
        SceneData edited = loaded;
        Change(edited.materials.at(0).*field.member);
        if (std::string(field.name) == "ior") edited.materials[0].ior = 1.25f;
        SaveGltf(source, edited, target);
        test::ExpectSame(edited, LoadGltf(target));
    });
}

// The JSON of a material with one thing in the place of a field.
template <typename Field, typename Value>
nlohmann::json With(const Field& field, const Value& value) {
    nlohmann::json material = kTextured;
    const std::string object = field.object;
    nlohmann::json& place = object.empty()               ? material
                            : object.starts_with("KHR_") ? material["extensions"][object]
                                                         : material[object];
    if (place.is_null()) place = nlohmann::json::object();
    if (*field.key != 0) place[field.key] = value;
    return material;
}

// A file with nothing in a place has the default of Material, whatever the importer does with it.
TEST(MaterialFields, DefaultsAreThoseOfTheStruct) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "scene.gltf";
    nlohmann::json bare = nlohmann::json::object();
    for (const bool hasObjects : {false, true}) {
        if (hasObjects)
            ForEachMaterialField([&](const auto& field) {
                const std::string object = field.object;
                if (object.starts_with("KHR_") && *field.key != 0)
                    bare["extensions"][object] = nlohmann::json::object();
                else if (object == "pbrMetallicRoughness" || object == "extras")
                    bare[object] = nlohmann::json::object();
            });
        Write(path, bare);
        const Material material = LoadGltf(path).materials.at(0);
        ForEachMaterialField([&](const auto& field) {
            if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>)
                EXPECT_EQ((material.*field.member).texture, -1) << field.name;
            else
                EXPECT_EQ(material.*field.member, Material().*field.member) << field.name;
        });
    }
}

// By glTF's name of each mode, from any other.
TEST(MaterialFields, EachAlphaModeIsReadAndSaved) {
    EXPECT_EQ(std::vector(kGltfNames<AlphaMode>.begin(), kGltfNames<AlphaMode>.end()),
              (std::vector<std::string_view>{"OPAQUE", "MASK", "BLEND"}));
    const test::TemporaryFolder folder;
    const std::filesystem::path source = folder.Path() / "source.gltf", target = folder.Path() / "saved.gltf";
    for (const AlphaMode mode : Values<AlphaMode>()) {
        Write(source, {{"alphaMode", GltfName(mode)}});
        SceneData edited = LoadGltf(source);
        EXPECT_EQ(edited.materials.at(0).alphaMode, mode) << Name(mode);
        for (const AlphaMode other : Values<AlphaMode>()) {
            edited.materials[0].alphaMode = other;
            SaveGltf(source, edited, target);
            EXPECT_EQ(LoadGltf(target).materials.at(0).alphaMode, other) << Name(mode) << ", " << Name(other);
        }
    }
}

// What is in the range is read, and what is out of it is put to the end of the range that is nearest.
TEST(MaterialFields, EachIsReadFromItsPlaceAndPutIntoItsRange) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "scene.gltf";
    ForEachMaterialField([&](const auto& field) {
        using FieldType = std::decay_t<decltype(field)>;
        if constexpr (kIsNumber<FieldType>) {
            SCOPED_TRACE(field.name);
            using Value = typename FieldType::Value;
            const auto read = [&](float number) {
                if constexpr (std::is_same_v<Value, float>)
                    Write(path, With(field, number));
                else
                    Write(path, With(field, std::vector<float>(size_t{Value::length()}, number)));
                return LoadGltf(path).materials.at(0).*field.member;
            };
            const FieldRange& range = field.range;
            const float within = range.min > 0.625f ? range.min + 0.25f : 0.625f;
            EXPECT_EQ(read(within), Value(within));
            if (range.HasMin()) {
                EXPECT_EQ(read(range.min), Value(range.min));
                EXPECT_EQ(read(range.min - 0.5f), Value(range.min));
            }
            if (range.HasMax()) {
                EXPECT_EQ(read(range.max), Value(range.max));
                EXPECT_EQ(read(1.5f * range.max), Value(range.max));
            }
            if (range.mayBeZero) {
                EXPECT_EQ(read(0.0f), Value(0.0f));
            }
        }
    });
}

TEST(MaterialFields, EachTextureIsReadFromItsPlaceInItsColorSpace) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "scene.gltf";
    ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>) {
            SCOPED_TRACE(field.name);
            nlohmann::json file = With(field, nlohmann::json{{"index", 0}, {"texCoord", 1}});
            for (const char* other : {"normalTexture", "occlusionTexture"})
                if (std::string(field.key) != other) file.erase(other);
            Write(path, file);
            const SceneData scene = LoadGltf(path);
            const TextureRef read = scene.materials.at(0).*field.member;
            ASSERT_EQ(read.texture, 0);
            EXPECT_EQ(read.texCoord, 1);
            ASSERT_EQ(scene.textures.size(), 1u) << "and no other of its textures";
            EXPECT_EQ(scene.textures[0].colorSpace, field.colorSpace);
        }
    });
    EXPECT_EQ(FieldOf(&Material::baseColorTexture).colorSpace, ColorSpace::Srgb);
    EXPECT_EQ(FieldOf(&Material::specularTexture).colorSpace, ColorSpace::Linear);
}

// --- Lights ---

std::string Refusal(const Light& light) {
    return testing::ErrorTextOf([&] { Check(light, "lamp"); });
}

Light Spot() {
    Light spot;
    spot.type = LightType::Spot;
    return spot;
}

void WriteLight(const std::filesystem::path& path, const nlohmann::json& light) {
    std::ofstream(path) << nlohmann::json{
        {"asset", {{"version", "2.0"}}},
        {"extensionsUsed", {"KHR_lights_punctual"}},
        {"extensions", {{"KHR_lights_punctual", {{"lights", {light}}}}}},
        {"nodes", {{{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}}}};
}

TEST(LightFields, CheckRefusesWhatIsOutOfTheRangeOfEachAndNamesIt) {
    EXPECT_EQ(Refusal(Spot()), "accepted") << "the defaults";
    ForEachLightField(LightType::Spot, [&](const auto& field) {
        using Value = typename std::decay_t<decltype(field)>::Value;
        const auto refused = [&](float value) {
            Light light = Spot();
            light.*field.member = Value(value);
            const std::string message = Refusal(light);
            EXPECT_TRUE(message.starts_with("lamp: " + std::string(field.name) + " is "))
                << value << ": " << message;
        };
        refused(std::nanf(""));
        refused(std::nextafter(field.range.min, -1.0f));
        if (field.range.HasMax()) refused(std::nextafter(field.range.max, kUnboundedField));
    });
    Light point = Spot();
    point.type = LightType::Point;
    point.innerConeAngle = 3.0f;
    EXPECT_EQ(Refusal(point), "accepted") << "it has no cone";
    Light sun;
    sun.type = LightType::Directional;
    sun.range = -1.0f;
    EXPECT_EQ(Refusal(sun), "accepted") << "it has no range";
}

TEST(LightFields, EachTypeOfLightIsRead) {
    EXPECT_EQ(std::vector(kGltfNames<LightType>.begin(), kGltfNames<LightType>.end()),
              (std::vector<std::string_view>{"directional", "point", "spot"}));
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "scene.gltf";
    for (const LightType type : Values<LightType>()) {
        WriteLight(path, {{"type", GltfName(type)}, {"spot", nlohmann::json::object()}});
        EXPECT_EQ(LoadGltf(path).lights.at(0).type, type) << Name(type);
    }
}

TEST(LightFields, EachIsReadFromItsPlaceAndComesBackFromAFile) {
    const test::TemporaryFolder folder;
    const std::filesystem::path source = folder.Path() / "source.gltf", target = folder.Path() / "saved.gltf";
    WriteLight(source, {{"type", "spot"}, {"range", 3}, {"spot", nlohmann::json::object()}});
    const SceneData loaded = LoadGltf(source);
    ForEachLightField(LightType::Spot, [&](const auto& field) {
        SCOPED_TRACE(field.name);
        SceneData edited = loaded;
        Change(edited.lights.at(0).*field.member);
        SaveGltf(source, edited, target);
        test::ExpectSame(edited, LoadGltf(target));
        const nlohmann::json saved =
            nlohmann::json::parse(std::ifstream(target))["extensions"]["KHR_lights_punctual"]["lights"][0];
        const nlohmann::json& object = *field.object == 0 ? saved : saved[field.object];
        EXPECT_TRUE(object.contains(field.key)) << saved;
    });
    SceneData endless = loaded;
    endless.lights.at(0).range = 0.0f;
    SaveGltf(source, endless, target);
    EXPECT_EQ(LoadGltf(target).lights.at(0).range, 0.0f) << "left out, for want of a number";
    WriteLight(source, {{"type", "directional"}, {"range", 3}});
    EXPECT_EQ(LoadGltf(source).lights.at(0).range, 0.0f) << "there is none of it";
}

}  // namespace
}  // namespace raygraph::scene
