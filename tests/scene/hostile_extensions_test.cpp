// Each property of each material extension, with values of other types in its place: the file is refused with
// one line that names the place, or loads.
#include <gtest/gtest.h>

#include "tests/scene/gltf_document.h"
#include "tests/support/material_extensions.h"

namespace raygraph::test::hostile_extensions_test {
namespace {

GltfDocument WithExtensions(const Json& extensions) {
    GltfDocument document;
    document.AddTriangle()["material"] = document.AddMaterial({{"extensions", extensions}});
    for (int i = 0; i < 2; ++i) {
        document.Add("images", {{"uri", DataUri(MakePng(1, 1, {1, 2, 3, 4}))}});
        document.Add("textures", {{"source", i}});
    }
    return document;
}

const Json kAll = MaterialExtensions();
const Json kGlossiness = R"({"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 0.5, 0.25, 1],
    "diffuseTexture": {"index": 0}, "specularFactor": [0, 0, 1], "glossinessFactor": 0.5,
    "specularGlossinessTexture": {"index": 1}}})"_json;

TEST(HostileExtensions, FilesLoadBeforeTheyAreChanged) {
    EXPECT_EQ(LoadError(WithExtensions(kAll)), "loaded");
    EXPECT_EQ(LoadError(WithExtensions(kGlossiness)), "loaded");
}

// Calls visit(pointer) for each value below an extension.
void ForEachPlace(const Json& value, const std::string& pointer, const auto& visit) {
    if (!pointer.empty()) visit(pointer);
    if (value.is_object())
        for (const auto& [key, child] : value.items()) ForEachPlace(child, pointer + "/" + key, visit);
    else if (value.is_array())
        for (size_t i = 0; i < value.size(); ++i)
            ForEachPlace(value[i], pointer + "/" + std::to_string(i), visit);
}

TEST(HostileExtensions, ValuesOfOtherTypesAreRefusedWithTheirPlace) {
    const Json hostile[] = {"x",
                            true,
                            nullptr,
                            -1,
                            1e60,
                            Json::array({nullptr}),
                            -1e60,
                            Json::array(),
                            Json::object(),
                            Json::array({Json::array({1})})};
    const std::string start = "scene.gltf: materials[0].extensions.";
    for (const Json& extensions : {kAll, kGlossiness}) {
        ForEachPlace(extensions, "", [&](const std::string& pointer) {
            if (pointer.find("thicknessTexture") != pointer.npos) return;  // nothing reads it
            size_t refusedCount = 0;
            for (const Json& value : hostile) {
                Json changed = extensions;
                changed[Json::json_pointer(pointer)] = value;
                const std::string error = LoadError(WithExtensions(changed));
                EXPECT_EQ(error.find_first_of("\n\r"), std::string::npos) << error;
                if (error == "loaded") continue;
                ++refusedCount;
                const std::string extension = pointer.substr(1, pointer.find('/', 1) - 1);
                EXPECT_TRUE(error.starts_with(start + extension)) << pointer << " " << value << ": " << error;
            }
            // Not a string, not a flag, not an array of arrays
            EXPECT_GE(refusedCount, 3u) << pointer;
        });
    }
}

}  // namespace
}  // namespace raygraph::test::hostile_extensions_test
