// The list of extensions is true: the importer reads those that it says, each has its test, and the page has all.
#include "renderer/scene/gltf/document.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string_view>

#include "renderer/scene/gltf/schema.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/source_file.h"

namespace raygraph::test::extensions_test {
namespace {

namespace fs = std::filesystem;

// Names for each extension that is read the test that fails if it is ignored, as "Suite.Name".
const std::map<std::string_view, std::string_view> kTests{
    {"EXT_lights_ies", "IesLightScene.IrradianceOnAPlaneIsThatOfTheProfile"},
    {"EXT_lights_image_based", "ImageLightScene.LightsTheSceneFromEachSideAsItsFileSays"},
    {"EXT_mesh_gpu_instancing", "Instancing.EachIsTranslatedAfterRotationAfterScaleWithinItsNode"},
    {"EXT_meshopt_compression", "Meshopt.AttributesAndTrianglesAreWhatWasEncoded"},
    {"EXT_texture_webp", "Textures.WebpExtensionsImageIsPreferred"},
    {"KHR_animation_pointer", "AnimationPointer.ShowsInAFrozenScene"},
    {"KHR_draco_mesh_compression", "Draco.EveryMethodGivesBackTheMesh"},
    {"KHR_lights_punctual", "ImportedScene.EveryKindOfPunctualLightLightsAsItsFileSays"},
    {"KHR_materials_anisotropy", "TraceAnisotropy.Trace_FilesHighlightLiesAsTheFileSays"},
    {"KHR_materials_clearcoat", "TraceClearcoat.Trace_CoatReflectsAndDimsWhatIsBelow"},
    {"KHR_materials_diffuse_transmission", "TraceDiffuseTransmission.Trace_LampBehindASheetLightsItsFront"},
    {"KHR_materials_dispersion", "TraceDispersion.Trace_BluePassesAtAnotherAngleThanRed"},
    {"KHR_materials_emissive_strength", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord"},
    {"KHR_materials_ior", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord"},
    {"KHR_materials_iridescence", "TraceIridescence.Trace_ThinFilmReflectsByItsThickness"},
    {"KHR_materials_pbrSpecularGlossiness", "Glossiness.PictureIsThatOfTheSameMaterialSaidOtherwise"},
    {"KHR_materials_retroreflection", "TraceRetroreflection.Trace_LampAtTheCameraIsSeenInTheSurface"},
    {"KHR_materials_scatter", "TraceScatter.Trace_ThinSheetSplitsLightBetweenItsSides"},
    {"KHR_materials_sheen", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord"},
    {"KHR_materials_specular", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord"},
    {"KHR_materials_transmission", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord"},
    {"KHR_materials_unlit", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord"},
    {"KHR_materials_variants", "ImportedVariants.PictureIsOfTheMaterialsOfTheVariant"},
    {"KHR_materials_volume", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord"},
    {"KHR_materials_volume_scatter", "TraceScattering.Trace_MediumReturnsLightByItsAlbedo"},
    {"KHR_mesh_quantization", "Quantization.NodeScalesTheMeshBack"},
    {"KHR_meshopt_compression", "Meshopt.AttributesAndTrianglesAreWhatWasEncoded"},
    {"KHR_node_visibility", "ImportedNodes.HiddenNodesAreNotSeenAndDoNotShine"},
    {"KHR_texture_basisu", "TextureExtensions.ImageOfTheExtensionIsReadAndRequiredOnesLoad"},
    {"KHR_texture_transform", "MaterialTextures.TransformsScaleThenRotateThenMove"},
    {"KHR_xmp_json_ld", "SaveGltf.MetadataIsKeptWhereItWas"},
    {"MSFT_texture_dds", "TextureExtensions.ImageOfTheExtensionIsReadAndRequiredOnesLoad"},
};

std::string TextOf(const fs::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Extensions, FileMayRequireThoseThatAreReadAndNoOthers) {
    for (const scene::GltfExtension& extension : scene::KnownExtensions()) {
        GltfDocument document;
        document.AddTriangle();
        document.json["extensionsRequired"] = {std::string(extension.name)};
        const std::string refusal = "scene.gltf: extensionsRequired[0]: the file requires \"" +
                                    std::string(extension.name) + "\", which is not supported";
        EXPECT_EQ(LoadError(document), extension.isRead ? "loaded" : refusal);
    }
}

TEST(Extensions, WhatTheTablesHoldIsRead) {
    for (const scene::Extension& row : scene::SupportedExtensions()) {
        const auto found = std::ranges::find(scene::KnownExtensions(), row.name, &scene::GltfExtension::name);
        ASSERT_NE(found, scene::KnownExtensions().end()) << row.name;
        EXPECT_TRUE(found->isRead) << row.name;
    }
}

TEST(Extensions, EachThatIsReadHasATestAndOthersAReason) {
    std::set<std::string> tests;
    const std::regex pattern(R"(\bTEST(_F|_P)?\((\w+),\s*(\w+)\))");
    for (const auto& entry : fs::recursive_directory_iterator(SourceFile("tests"))) {
        if (entry.path().extension() != ".cpp") continue;
        const std::string text = TextOf(entry.path());
        for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match)
            tests.insert((*match)[2].str() + "." + (*match)[3].str());
    }
    for (const scene::GltfExtension& extension : scene::KnownExtensions()) {
        EXPECT_FALSE(extension.note.empty()) << extension.name;
        EXPECT_EQ(extension.isRead, kTests.contains(extension.name)) << extension.name;
    }
    for (const auto& [extension, test] : kTests)
        EXPECT_TRUE(tests.contains(std::string(test))) << extension << ": " << test;
}

TEST(Extensions, PageNamesEachThatIsRead) {
    const std::string page = TextOf(SourceFile("docs/gltf.md")) + TextOf(SourceFile("docs/materials.md"));
    for (const scene::GltfExtension& extension : scene::KnownExtensions()) {
        const bool isNamed = page.find("`" + std::string(extension.name) + "`") != std::string::npos;
        EXPECT_TRUE(isNamed || !extension.isRead) << extension.name;
    }
}

}  // namespace
}  // namespace raygraph::test::extensions_test
