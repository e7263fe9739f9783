// The list of a material's fields, and that Check and the saver go by it.
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
#include "renderer/scene/load_gltf.h"
#include "renderer/scene/save_gltf.h"
#include "tests/scene/same_scene.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::scene {
namespace {

template <typename Field>
constexpr bool kIsNumber =
    std::is_same_v<Field, MaterialField<float>> || std::is_same_v<Field, MaterialField<glm::vec3>> ||
    std::is_same_v<Field, MaterialField<glm::vec4>>;

std::string Refusal(const Material& material) {
    try {
        Check(material, "paint");
    } catch (const Error& error) {
        return error.what();
    }
    return "accepted";
}

TEST(MaterialFields, EachHasANameAndAPlaceOfItsOwn) {
    std::set<std::string> names, places;
    size_t count = 0;
    ForEachMaterialField([&](const auto& field) {
        names.insert(field.name);
        places.insert(std::string(field.object) + "/" + field.key);
        count++;
    });
    EXPECT_EQ(names.size(), count);
    EXPECT_EQ(places.size(), count);
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
            if (field.range.most < kUnboundedField)
                refused(std::nextafter(field.range.most, kUnboundedField));
            if (field.range.least > -kUnboundedField)
                refused(std::nextafter(field.range.least, -kUnboundedField));
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

// The importer's own tables say the same of each place: what is in the range is read, what is out of it is not.
TEST(MaterialFields, EachIsReadFromItsPlaceAndNotOutOfItsRange) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "scene.gltf";
    ForEachMaterialField([&](const auto& field) {
        using Field = std::decay_t<decltype(field)>;
        if constexpr (kIsNumber<Field>) {
            SCOPED_TRACE(field.name);
            const auto read = [&](float number) {
                nlohmann::json material = kTextured;
                const std::string object = field.object;
                nlohmann::json& place = object.empty()               ? material
                                        : object.starts_with("KHR_") ? material["extensions"][object]
                                                                     : material[object];
                if constexpr (std::is_same_v<Field, MaterialField<float>>)
                    place[field.key] = number;
                else
                    place[field.key] = std::vector<float>(
                        static_cast<size_t>(std::decay_t<decltype(Material{}.*field.member)>::length()),
                        number);
                Write(path, material);
                return LoadGltf(path).materials.at(0).*field.member;
            };
            using Value = std::decay_t<decltype(Material{}.*field.member)>;
            const float within = field.range.least > 0.625f ? field.range.least + 0.25f : 0.625f;
            EXPECT_EQ(read(within), Value(within));
            Material material;
            if (field.range.least > -kUnboundedField) {
                material.*field.member = read(field.range.least - 0.5f);
                EXPECT_EQ(Refusal(material), "accepted");
            }
            if (field.range.most < kUnboundedField) {
                material.*field.member = read(field.range.most + 0.5f * field.range.most);
                EXPECT_EQ(Refusal(material), "accepted");
            }
        }
    });
}

}  // namespace
}  // namespace raygraph::scene
