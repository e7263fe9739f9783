// The lists of a material's and a light's fields, and that importer, saver and Check go by them.
#include "renderer/scene/model/scene_fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/gtc/constants.hpp>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include "base/error.h"
#include "renderer/scene/gltf/choice.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "renderer/scene/model/check.h"
#include "tests/scene/same_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::scene::material_fields_test {
namespace {

template <typename Field>
constexpr bool kIsNumber =
    std::is_same_v<Field, MaterialField<float>> || std::is_same_v<Field, MaterialField<glm::vec3>> ||
    std::is_same_v<Field, MaterialField<glm::vec4>>;

std::string Refusal(const Material& material) {
    return testing::ErrorTextOf([&] { Check(material, "paint"); });
}

// The hash of a scene goes over the fields in this order: another one would have old renders not be resumed. Fields
// that have come since may stand between them.
TEST(MaterialFields, EachHasANameAndAPlaceOfItsOwnAndTheirOrderStays) {
    std::vector<std::string> names;
    std::set<std::string> places;
    ForEachMaterialField([&](const auto& field) {
        names.emplace_back(field.name);
        places.insert(std::string(field.object) + "/" + field.key);
    });
    EXPECT_EQ(places.size(), names.size());
    std::istringstream first(
        R"(baseColorFactor baseColorTexture metallicFactor roughnessFactor metallicRoughnessTexture
normalTexture normalScale occlusionTexture occlusionStrength emissiveFactor emissiveStrength
emissiveTexture alphaMode alphaCutoff isDoubleSided ior specularFactor specularTexture
specularColorFactor specularColorTexture transmissionFactor transmissionTexture thicknessFactor
attenuationColor attenuationDistance isUnlit clearcoatFactor clearcoatTexture
clearcoatRoughnessFactor clearcoatRoughnessTexture clearcoatNormalTexture clearcoatNormalScale
sheenColorFactor sheenColorTexture sheenRoughnessFactor sheenRoughnessTexture anisotropyStrength
anisotropyRotation anisotropyTexture iridescenceFactor iridescenceTexture iridescenceIor
iridescenceThicknessMinimum iridescenceThicknessMaximum iridescenceThicknessTexture dispersion
diffuseTransmissionFactor diffuseTransmissionTexture diffuseTransmissionColorFactor
diffuseTransmissionColorTexture retroreflectionFactor retroreflectionTexture multiscatterColorFactor
scatterAnisotropy isSpecularGlossiness priority)");
    const std::vector<std::string> expected{std::istream_iterator<std::string>(first), {}};
    std::erase_if(names, [&](const std::string& name) { return std::ranges::count(expected, name) == 0; });
    EXPECT_EQ(names, expected);
    constexpr auto kThickness = FieldOf(&Material::thicknessFactor);
    EXPECT_STREQ(kThickness.unit, "m");
    constexpr auto kSpecularColor = FieldOf(&Material::specularColorFactor);
    EXPECT_STREQ(kSpecularColor.name, "specularColorFactor");
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
void Change(TextureRef&) {}  // only its transform is edited, see below
template <typename Field>
void Change(Material& material, const Field& field) {
    Change(material.*field.member);
    if constexpr (std::is_same_v<typename Field::Value, float>)
        material.*field.member = std::max(material.*field.member, field.range.min);
}

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

// Has the textures that some fields require.
const nlohmann::json kTextured = {
    {"normalTexture", {{"index", 0}}},
    {"occlusionTexture", {{"index", 0}}},
    {"extensions", {{"KHR_materials_clearcoat", {{"clearcoatNormalTexture", {{"index", 0}}}}}}}};

// Every field of a material goes to its place in the file and comes back from there.
TEST(MaterialFields, EachComesBackFromAFile) {
    const test::TemporaryFolder folder;
    const std::filesystem::path source = folder.Path() / "source.gltf", target = folder.Path() / "saved.gltf";
    Write(source, kTextured);
    const SceneData loaded = LoadGltf(source);
    ForEachMaterialField([&](const auto& field) {
        SCOPED_TRACE(field.name);
        // A material stays what it is: import_glossiness_test.cpp
        if (std::string(field.name) == "isSpecularGlossiness") return;
        SceneData edited = loaded;
        Change(edited.materials.at(0), field);
        SaveGltf(source, edited, target);
        test::ExpectSame(edited, LoadGltf(target));
    });
}

std::string TextOf(const std::filesystem::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
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
    const KeyParts parts = KeyPartsOf(field.key);
    if (!parts.object.empty())
        place[parts.object][parts.key] = value;
    else if (*field.key != 0)
        place[field.key] = value;
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

// Sets each mode by its glTF name, from any other mode.
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

// A value within the range is read; one outside of it is clamped to the range.
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
            if (std::string(field.key) != "clearcoatNormalTexture")
                file["extensions"]["KHR_materials_clearcoat"].erase("clearcoatNormalTexture");
            Write(path, file);
            const SceneData scene = LoadGltf(path);
            const TextureRef read = scene.materials.at(0).*field.member;
            ASSERT_EQ(read.texture, 0);
            EXPECT_EQ(read.texCoord, 1);
            ASSERT_EQ(scene.textures.size(), 1u) << "and no other of its textures";
            EXPECT_EQ(scene.textures[0].colorSpace, field.colorSpace);
        }
    });
    constexpr auto kBaseColor = FieldOf(&Material::baseColorTexture);
    EXPECT_EQ(kBaseColor.colorSpace, ColorSpace::Srgb);
    constexpr auto kSpecular = FieldOf(&Material::specularTexture);
    EXPECT_EQ(kSpecular.colorSpace, ColorSpace::Linear);
}

// --- Texture transforms ---

void Change(glm::vec2& value) {
    value = {-0.25f, 1.5f};
}

// The name of each texture of a material, with what the file has there.
template <typename Visit>
void ForEachTexture(Visit&& visit) {
    ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>) visit(field);
    });
}

// The textures of every place in the file: those of glTF itself and those in extensions.
TEST(TextureTransforms, AreReadFromEveryTextureWithTheirSetOfCoordinates) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "scene.gltf";
    ForEachTexture([&](const auto& field) {
        SCOPED_TRACE(field.name);
        const nlohmann::json transform = {
            {"offset", {0.25, -3}}, {"rotation", 0.5}, {"scale", {2, -0.5}}, {"texCoord", 1}};
        Write(path, With(field, nlohmann::json{{"index", 0},
                                               {"extensions", {{"KHR_texture_transform", transform}}}}));
        const SceneData scene = LoadGltf(path);
        const TextureRef& read = scene.materials.at(0).*field.member;
        EXPECT_EQ(read.transform.offset, glm::vec2(0.25f, -3.0f));
        EXPECT_EQ(read.transform.rotation, 0.5f);
        EXPECT_EQ(read.transform.scale, glm::vec2(2.0f, -0.5f));
        EXPECT_EQ(read.texCoord, 1) << "the extension's comes before the texture's own";
        for (const std::string& warning : scene.warnings)
            EXPECT_EQ(warning.find("KHR_texture_transform"), std::string::npos) << warning;
        Write(path, With(field, nlohmann::json{
                                    {"index", 0},
                                    {"texCoord", 1},
                                    {"extensions", {{"KHR_texture_transform", nlohmann::json::object()}}}}));
        const SceneData bare = LoadGltf(path);
        EXPECT_EQ((bare.materials.at(0).*field.member).texCoord, 1);
        EXPECT_EQ((bare.materials.at(0).*field.member).transform, TextureTransform{});
    });
}

TEST(TextureTransforms, AreSavedWhereTheFileHasThemAndWhereItHasNone) {
    const test::TemporaryFolder folder;
    const std::filesystem::path source = folder.Path() / "source.gltf", target = folder.Path() / "saved.gltf";
    ForEachTexture([&](const auto& field) {
        for (const bool isThere : {true, false}) {
            nlohmann::json info = {{"index", 0}, {"extras", "kept"}};
            if (isThere) info["extensions"]["KHR_texture_transform"] = {{"rotation", 0.25}, {"other", 1}};
            Write(source, With(field, info));
            const SceneData loaded = LoadGltf(source);
            ForEachTransformField([&](const auto& part) {
                SCOPED_TRACE(std::string(field.name) + ", " + part.name);
                SceneData edited = loaded;
                Change((edited.materials.at(0).*field.member).transform.*part.member);
                SaveGltf(source, edited, target);
                const SceneData saved = LoadGltf(target);
                test::ExpectSame(edited, saved);
                EXPECT_EQ((saved.materials.at(0).*field.member), (edited.materials.at(0).*field.member));
                const std::string text = TextOf(target);
                EXPECT_NE(text.find("\"kept\""), std::string::npos);
                EXPECT_EQ(text.find("\"other\"") != std::string::npos, isThere);
                const nlohmann::json used = nlohmann::json::parse(text).at("extensionsUsed");
                EXPECT_NE(std::find(used.begin(), used.end(), "KHR_texture_transform"), used.end());
            });
        }
    });
}

// Edits of what has no texture in the file leave the file as it is.
TEST(TextureTransforms, AndScalesOfAbsentTexturesAreNotSaved) {
    const test::TemporaryFolder folder;
    const std::filesystem::path source = folder.Path() / "source.gltf", target = folder.Path() / "saved.gltf";
    Write(source, {{"name", "bare"}});
    SceneData edited = LoadGltf(source);
    Material& material = edited.materials.at(0);
    ForEachTexture([&](const auto& field) { (material.*field.member).transform.rotation = 0.5f; });
    material.normalScale = material.clearcoatNormalScale = 0.25f;
    SaveGltf(source, edited, target);
    const nlohmann::json saved = nlohmann::json::parse(TextOf(target));
    EXPECT_EQ(saved.at("materials").at(0), (nlohmann::json{{"name", "bare"}}));
    EXPECT_FALSE(saved.contains("extensionsUsed"));
    EXPECT_NO_THROW(LoadGltf(target));
}

TEST(TextureTransforms, NumbersThatAreNoneAreRefused) {
    for (const float value : {std::nanf(""), std::numeric_limits<float>::infinity()})
        ForEachTransformField([&](const auto& part) {
            SceneData scene;
            scene.images = {{.name = "one", .width = 1, .height = 1, .rgba = {0, 0, 0, 255}}};
            scene.textures.resize(1);
            scene.materials.resize(1);
            TextureRef& texture = scene.materials[0].emissiveTexture;
            texture.texture = 0;
            texture.transform.*part.member = std::decay_t<decltype(texture.transform.*part.member)>(value);
            const std::string message = testing::ErrorTextOf([&] { Check(scene, "scene"); });
            EXPECT_TRUE(message.starts_with("scene: materials[0]: " + std::string(part.name) + " is "))
                << message;
            EXPECT_EQ(Refusal(scene.materials[0]).find("paint: " + std::string(part.name) + " is "), 0u)
                << "a material that is edited";
        });
}

TEST(TextureTransforms, TakeAQuarterOfTheImageAsTheExtensionsExampleSays) {
    // "Only the lower left quadrant of the source image, rotated clockwise 90 degrees"; v points down
    const TextureTransform transform{
        .offset = {0.0f, 1.0f}, .rotation = glm::half_pi<float>(), .scale = glm::vec2(0.5f)};
    const auto expect = [&](const glm::vec2& uv, const glm::vec2& expected) {
        EXPECT_LT(glm::distance(transform.Matrix() * glm::vec3(uv, 1.0f), expected), 1e-6f)
            << uv.x << ", " << uv.y;
    };
    expect({0, 0}, {0, 1});  // the lower left corner of before is at the upper left
    expect({1, 0}, {0, 0.5});
    expect({0, 1}, {0.5, 1});
    expect({1, 1}, {0.5, 0.5});
    // Scaled before it is rotated
    const TextureTransform stretched{.offset = {}, .rotation = glm::half_pi<float>(), .scale = {3.0f, 1.0f}};
    EXPECT_LT(glm::distance(stretched.Matrix() * glm::vec3(1, 0, 1), glm::vec2(0, -3)), 1e-6f);
}

}  // namespace
}  // namespace raygraph::scene::material_fields_test
