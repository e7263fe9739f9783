// KHR_materials_variants: which materials there are to choose from, and that saving keeps them.
#include <gtest/gtest.h>

#include "renderer/scene/gltf/save_gltf.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/variants.h"
#include "tests/scene/gltf_document.h"
#include "tests/scene/same_scene.h"
#include "tests/support/error_of.h"

namespace raygraph::test::import_variants_test {
namespace {

constexpr const char* kExtension = "KHR_materials_variants";
constexpr const char* kMappings = "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings";

// Three materials and three variants: the first two map the triangle, the other one does not.
GltfDocument Shoe() {
    GltfDocument document;
    document.json["extensions"][kExtension]["variants"] = {
        {{"name", "red"}}, {{"name", "blue"}}, {{"name", "plain"}}};
    Json& triangle = document.AddTriangle();
    for (const char* name : {"leather", "paint", "cloth"}) document.AddMaterial({{"name", name}});
    triangle["material"] = 0;
    triangle["extensions"][kExtension]["mappings"] = {{{"material", 2}, {"variants", {1}}},
                                                      {{"material", 1}, {"variants", {0}}, {"name", "x"}}};
    return document;
}

// The materials of the triangle without a variant, then in each.
std::vector<uint32_t> MaterialsByVariant(scene::SceneData scene) {
    std::vector<uint32_t> materials{OnlyPrimitive(scene).material};
    for (uint32_t i = 0; i < scene.variants.size(); ++i) {
        scene::SetVariant(scene, i);
        EXPECT_EQ(scene.variant, i);
        EXPECT_EQ(scene::MaterialOf(OnlyPrimitive(scene), i), OnlyPrimitive(scene).material);
        materials.push_back(OnlyPrimitive(scene).material);
    }
    scene::SetVariant(scene, scene::kNone);
    EXPECT_EQ(OnlyPrimitive(scene).material, materials[0]);
    return materials;
}

TEST(Variants, EachGivesAPrimitiveItsMaterial) {
    GltfDocument document = Shoe();
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(scene.variants, (std::vector<std::string>{"red", "blue", "plain"}));
    EXPECT_EQ(scene.variant, scene::kNone);
    EXPECT_EQ(MaterialsByVariant(scene), (std::vector<uint32_t>{0, 1, 2, 0}));
    // One mapping of several variants, of a primitive whose own material is glTF's default
    document.json["meshes"][0]["primitives"][0].erase("material");
    document.json[Json::json_pointer(kMappings)] = {{{"material", 1}, {"variants", {2, 0}}}};
    EXPECT_EQ(MaterialsByVariant(Load(document)), (std::vector<uint32_t>{3, 1, 3, 1}));
    document.json["meshes"][0]["primitives"][0].erase("extensions");
    EXPECT_EQ(MaterialsByVariant(Load(document)), (std::vector<uint32_t>{3, 3, 3, 3}));
}

TEST(Variants, AreFoundByNameThenByIndex) {
    GltfDocument document = Shoe();
    scene::SceneData scene = Load(document);
    EXPECT_EQ(scene::FindVariant(scene, "blue"), 1u);
    EXPECT_EQ(scene::FindVariant(scene, "1"), 1u);
    EXPECT_EQ(scene::FindVariant(scene, ""), scene::kNone);
    for (const char* absent : {"green", "3", "-1", "1x", "4294967295"}) {
        const Error error = testing::ErrorOf([&] { scene::FindVariant(scene, absent); });
        EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
        EXPECT_EQ(error.what(), "there is no variant \"" + std::string(absent) +
                                    "\"; the scene has 0 \"red\", 1 \"blue\", 2 \"plain\"");
    }
    const Error none = testing::ErrorOf([] { scene::FindVariant({}, "red"); });
    EXPECT_STREQ(none.what(), "there is no variant \"red\"; the scene has no variants");
    EXPECT_EQ(testing::ErrorOf([&] { scene::SetVariant(scene, 3); }).Kind(), ErrorKind::Usage);
    // The name stands for the first, and none for nothing
    scene.variants = {"2", "red", "red", ""};
    for (uint32_t i = 0; i < scene.variants.size(); ++i)
        EXPECT_EQ(scene::FindVariant(scene, scene::VariantText(scene, i)), i == 2 ? 0u : i) << i;
    EXPECT_EQ(scene::VariantText(scene, 1), "red");
    EXPECT_EQ(scene::VariantText(scene, 3), "3");
    EXPECT_EQ(scene::VariantText(scene, scene::kNone), "");
}

TEST(Variants, WhatIsOutOfRangeIsRefused) {
    const std::string at = "meshes[0].primitives[0].extensions.KHR_materials_variants.mappings";
    const auto message = [&](const std::string& rest) { return at + rest; };
    const std::string refusals[] = {
        message("[0].variants[0]: is 3, but there are 3 variants"),
        message("[1].material: is 3, but there are 3 materials"),
        message("[0].variants: is absent, must be an array"),
        message("[0].material: is absent, must be a whole number of at least 0"),
        message("[0].variants[0]: is -1, must be a whole number of at least 0"),
        message("[0].variants: is 1, must be an array"),
        message("[0]: is 1, must be an object"),
        message(": is an object, must be an array"),
    };
    const std::string mappings = kMappings;
    const std::string first = mappings + "/0", variants = first + "/variants", index = variants + "/0",
                      material = mappings + "/1/material";
    ExpectRefused(Shoe(), {
                              {index.c_str(), 3, refusals[0].c_str()},
                              {material.c_str(), 3, refusals[1].c_str()},
                              {first.c_str(), {{"material", 1}}, refusals[2].c_str()},
                              {first.c_str(), {{"variants", {1}}}, refusals[3].c_str()},
                              {index.c_str(), -1, refusals[4].c_str()},
                              {variants.c_str(), 1, refusals[5].c_str()},
                              {first.c_str(), 1, refusals[6].c_str()},
                              {kMappings, Json::object(), refusals[7].c_str()},
                              {"/extensions/KHR_materials_variants", Json::object(),
                               (at + "[0].variants[0]: is 1, but there are 0 variants").c_str()},
                          });
}

TEST(Variants, OneThatIsMappedTwiceKeepsItsFirstMaterial) {
    GltfDocument document = Shoe();
    document.json[Json::json_pointer(kMappings)] = {{{"material", 2}, {"variants", {1, 1}}},
                                                    {{"material", 1}, {"variants", {0, 1}}}};
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.warnings, std::vector<std::string>{
                                  "scene.gltf: meshes[0].primitives[0].extensions.KHR_materials_variants: "
                                  "variant 1 has materials 2 and 1, the first is shown"});
    EXPECT_EQ(MaterialsByVariant(scene), (std::vector<uint32_t>{0, 1, 2, 0}));
}

// Vertices are made once, for all variants.
TEST(Variants, NormalMapOfOneHasTangents) {
    GltfDocument document = Shoe();
    document.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] =
        document.AddAccessor<float>({0, 0, 1, 0, 0, 1}, 2);
    EXPECT_TRUE(OnlyPrimitive(Load(document)).tangents.empty());
    document.Add("images", {{"uri", DataUri(MakePng(1, 1, {128, 128, 255, 255}))}});
    document.Add("textures", {{"source", 0}});
    document.json["materials"][2]["normalTexture"]["index"] = 0;
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).tangents.size(), 3u);
    EXPECT_TRUE(scene.warnings.empty());
    // The normal map of another variant is turned, which only matters where it is read
    document.json["materials"][1]["normalTexture"] = {
        {"index", 0}, {"extensions", {{"KHR_texture_transform", {{"rotation", 1}}}}}};
    EXPECT_TRUE(Load(document).warnings.empty());
}

TEST(Variants, ScenesOfHostsAreChecked) {
    const auto refusal = [](const auto& change) {
        scene::SceneData scene = Load(Shoe());
        change(scene, scene.meshes[0].primitives[0].variants);
        try {
            scene::Check(scene);
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    using List = std::vector<scene::VariantMaterial>;
    const std::string at = "scene: meshes[0].primitives[0]: ";
    EXPECT_EQ(refusal([](scene::SceneData&, List&) {}), "accepted");
    EXPECT_EQ(refusal([](scene::SceneData& scene, List&) { scene.variant = 3; }),
              "scene: its variant is 3, there are 3");
    EXPECT_EQ(refusal([](scene::SceneData&, List& list) { list[0].variant = 3; }),
              at + "a variant is 3, there are 3");
    EXPECT_EQ(refusal([](scene::SceneData&, List& list) { list[0].material = 4; }),
              at + "the material of a variant is 4, there are 3");
    EXPECT_EQ(refusal([](scene::SceneData&, List& list) { std::swap(list[0], list[1]); }),
              at + "its variants do not ascend");
    EXPECT_EQ(refusal([](scene::SceneData&, List& list) { list.pop_back(); }),
              at + "its variants do not end with one for all others");
}

TEST(Variants, SavingKeepsThemAndTheMaterialWithoutOne) {
    SceneFolder folder;
    const std::filesystem::path source = folder.Write("scene.gltf", Shoe().Text());
    scene::SceneData edited = scene::LoadGltf(source);
    scene::SetVariant(edited, 1);
    edited.materials[OnlyPrimitive(edited).material].roughnessFactor = 0.25f;
    const std::filesystem::path target = folder.Path() / "saved.gltf";
    scene::SaveGltf(source, edited, target);
    const scene::SceneData saved = scene::LoadGltf(target);
    EXPECT_EQ(saved.variants, edited.variants);
    EXPECT_EQ(MaterialsByVariant(saved), (std::vector<uint32_t>{0, 1, 2, 0}));
    EXPECT_EQ(saved.materials[2].roughnessFactor, 0.25f);
    const Bytes text = folder.Read(target, 1 << 20);
    Json json = Json::parse(reinterpret_cast<const char*>(text.data()),
                            reinterpret_cast<const char*>(text.data()) + text.size());
    json["materials"][2].erase("pbrMetallicRoughness");
    EXPECT_EQ(json, Shoe().json) << "nothing else";
    // Shown as it was saved, and as the file without a variant shows it
    scene::SetVariant(edited, scene::kNone);
    ExpectSame(edited, saved);
}

}  // namespace
}  // namespace raygraph::test::import_variants_test
