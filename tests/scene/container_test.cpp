// Files of glTF: containers, JSON against the schema, extensions, and accessors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <regex>
#include <set>
#include <string_view>

#include "renderer/scene/gltf/document.h"
#include "renderer/scene/gltf/schema.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/material_extensions.h"
#include "tests/support/peak_memory.h"
#include "tests/support/source_file.h"

// The container: .glb chunks, JSON text, version, extensions.
namespace raygraph::test::container_test {
namespace {

Bytes TriangleGlb(const Bytes& positions) {
    GltfDocument document;
    document.json["buffers"] = {{{"byteLength", 36}}};
    document.json["bufferViews"] = {{{"buffer", 0}, {"byteLength", 36}}};
    const size_t accessor = document.AddAccessorOver(0, kFloat, 3, 3, false);
    document.AddNode({{"mesh", document.AddMesh({{"attributes", {{"POSITION", accessor}}}})}});
    return MakeGlb(document.Text(), &positions);
}

const Bytes kPositions = BytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0});

TEST(Glb, BinaryChunkIsTheFirstBuffer) {
    const scene::SceneData scene = SceneFolder().Load(TriangleGlb(kPositions));
    EXPECT_EQ(OnlyPrimitive(scene).positions[1], glm::vec3(1, 0, 0));
}

TEST(Glb, ShortBinaryChunkIsRefused) {
    const Bytes few(kPositions.begin(), kPositions.begin() + 20);
    EXPECT_EQ(SceneFolder().LoadError(TriangleGlb(few)),
              "scene.gltf: buffers[0].byteLength: is 36, but the buffer has 20 bytes");
}

TEST(Glb, CutAnywhereIsRefused) {
    const Bytes whole = TriangleGlb(kPositions);
    SceneFolder folder;
    for (size_t size = 0; size < whole.size(); ++size) {
        const std::string message =
            folder.LoadError(Bytes(whole.begin(), whole.begin() + static_cast<long>(size)));
        EXPECT_EQ(message.find("scene.gltf: "), 0u) << size << ": " << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << size << ": " << message;
    }
}

TEST(Glb, WrongHeadersAreRefused) {
    const auto error = [](size_t at, uint8_t value) {
        Bytes file = MakeGlb(GltfDocument().Text(), nullptr);
        file[at] = static_cast<std::byte>(value);
        return SceneFolder().LoadError(file);
    };
    const size_t size = MakeGlb(GltfDocument().Text(), nullptr).size();
    EXPECT_EQ(error(4, 1), "scene.gltf: is a .glb of version 1, must be 2");
    EXPECT_EQ(error(11, 0x7F).find("scene.gltf: the .glb header claims 21"), 0u);
    EXPECT_EQ(error(15, 0x7F).find("scene.gltf: chunk 0: claims 21"), 0u);
    EXPECT_EQ(error(16, 'j'), "scene.gltf: the first chunk is not JSON");
    EXPECT_EQ(error(8, 8), "scene.gltf: the .glb header claims 8 bytes, the file has " + std::to_string(size))
        << "a length that does not hold the header";
}

TEST(Glb, BytesAfterItsLengthAreIgnored) {
    Bytes file = TriangleGlb(kPositions);
    file.resize(file.size() + 5, std::byte{0x55});
    EXPECT_EQ(SceneFolder().LoadError(file), "loaded");
}

TEST(Json, DeepNestingIsRefusedBeforeParsing) {
    const std::string open = "{\"a\":" + std::string(1000000, '[');
    EXPECT_EQ(SceneFolder().LoadError(ToBytes(open)),
              "scene.gltf: JSON is nested deeper than 64 levels at byte 68");
    // Brackets in strings do not nest; a quote behind a backslash does not end a string.
    GltfDocument document;
    document.json["asset"]["generator"] = "\\\"" + std::string(100, '[') + "\"" + std::string(100, '{');
    EXPECT_EQ(LoadError(document), "loaded");
}

TEST(Json, LongTextIsRefusedBeforeParsing) {
    scene::LoadOptions options;
    options.limits.maxJsonBytes = 10;
    EXPECT_EQ(LoadError(GltfDocument(), options), "scene.gltf: JSON of " +
                                                      std::to_string(GltfDocument().Text().size()) +
                                                      " bytes exceeds the limit of 10");
}

TEST(Json, MalformedTextIsRefusedInOneLine) {
    for (const char* text : {"", "{", "{\"asset\":}", "[]", "null", "{\"a\n\":\x01}", "{\"a\":\"\xff\xfe\"}",
                             "{\"asset\":{\"version\":\"2.0\"},\"n\":1e999}"}) {
        const std::string message = SceneFolder().LoadError(ToBytes(text));
        EXPECT_EQ(message.find("scene.gltf: "), 0u) << text << ": " << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
        EXPECT_EQ(message.find('\x01'), std::string::npos) << message;
        EXPECT_EQ(message.find('\xff'), std::string::npos) << message;
    }
}

TEST(Json, ByteOrderMarkIsSkipped) {
    EXPECT_EQ(SceneFolder().LoadError(ToBytes("\xEF\xBB\xBF{\"asset\":{\"version\":\"2.0\"}}")), "loaded");
}

TEST(Asset, OtherVersionsAreRefused) {
    ExpectRefused(
        GltfDocument(),
        {{"/asset/version", "1.0", "asset.version: is \"1.0\", must be 2.x"},
         {"/asset", {{"version", "2.1"}, {"minVersion", "2.1"}}, "asset.minVersion: is \"2.1\", must be 2.0"},
         {"/asset/version", "2.1", "loaded"},
         {"/asset/version", 2.0, "asset.version: is 2.0, must be a string"}});
    GltfDocument document;
    document.json.erase("asset");
    EXPECT_EQ(LoadError(document), "scene.gltf: not a glTF file: its JSON has no \"asset\"");
}

TEST(Container, OtherFilesAreNamed) {
    const auto error = [](std::string_view text) {
        return SceneFolder().LoadError(ToBytes(std::string(text)));
    };
    EXPECT_EQ(error("hello"), "scene.gltf: not a glTF file: it begins with neither { nor glTF");
    EXPECT_EQ(error("\x89PNG\r\n"), "scene.gltf: not a glTF file, but a PNG picture");
    EXPECT_EQ(error("<html>"), "scene.gltf: not a glTF file, but an XML or HTML text, as COLLADA");
    EXPECT_THAT(error("version https://git-lfs.github.com/spec/v1\n"),
                ::testing::HasSubstr("run git lfs pull"));
    EXPECT_THAT(error("{\"asset\": {\"version\": \"2.0\"},"),
                ::testing::HasSubstr("cut short: not valid JSON"));
}

TEST(Extensions, UsedButUnknownOnesGiveAWarningEach) {
    GltfDocument document;
    document.json["extensionsUsed"] = {"ACME_shiny", "KHR_materials_emissive_strength", "ACME_dull"};
    EXPECT_EQ(
        Load(document).warnings,
        (std::vector<std::string>{"scene.gltf: extensionsUsed[0]: \"ACME_shiny\" is not supported, ignored",
                                  "scene.gltf: extensionsUsed[2]: \"ACME_dull\" is not supported, ignored"}));
}

TEST(Extensions, ManyWarningsAreCut) {
    GltfDocument document;
    for (int i = 0; i < 1000; ++i) document.Add("extensionsUsed", "ACME_" + std::to_string(i));
    const std::vector<std::string> warnings = Load(document).warnings;
    EXPECT_LE(warnings.size(), 65u);
    EXPECT_EQ(warnings.back(), "further kinds of warnings are not shown");
}

TEST(Extensions, RequiredButUnknownOneIsRefusedByName) {
    GltfDocument document;
    document.json["extensionsUsed"] = {"EXT_invented"};
    document.json["extensionsRequired"] = {"EXT_invented"};
    EXPECT_EQ(LoadError(document),
              "scene.gltf: extensionsRequired[0]: the file requires \"EXT_invented\", which is not "
              "supported");
}

TEST(Indices, ThoseOfSkinsAnimationsAndTargetsAreChecked) {
    GltfDocument document;
    document.AddTriangle();
    ExpectRefused(document, {{"/meshes/0/primitives/0/targets",
                              {{{"POSITION", 5}}},
                              "meshes[0].primitives[0].targets[0].POSITION: is 5, but there are 2 accessors"},
                             {"/skins", {{{"joints", {3}}}}, "skins[0].joints[0]: is 3, but there is 1 node"},
                             {"/animations",
                              {{{"samplers", {{{"input", 0}, {"output", 9}}}}, {"channels", Json::array()}}},
                              "animations[0].samplers[0].output: is 9, but there are 2 accessors"}});
}

TEST(Load, ProgressRisesFromNoughtToOne) {
    std::vector<float> seen;
    scene::LoadOptions options;
    options.progress = [&](std::string_view, float fraction) { seen.push_back(fraction); };
    GltfDocument document;
    document.AddTriangle();
    Load(document, options);
    ASSERT_GE(seen.size(), 3u);
    EXPECT_EQ(seen.front(), 0.0f);
    EXPECT_EQ(seen.back(), 1.0f);
    EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
}

}  // namespace
}  // namespace raygraph::test::container_test

// The schema tables: what the tests of the properties do not cover.
namespace raygraph::test::schema_test {
namespace {

// A property of the type that the checker does not support cannot be declared.
template <typename Row>
concept CanBePutIntoRange = requires(const Row& row) {
    row.ClampToRange();
};
template <typename Row>
concept CanBeLeftOut = requires(const Row& row) {
    row.OrOmitted("", "");
};
using scene::schema::NumberRow, scene::schema::NumbersRow, scene::schema::WholeRow, scene::schema::TextRow;
static_assert(CanBePutIntoRange<NumberRow> && CanBePutIntoRange<NumbersRow>);
static_assert(!CanBePutIntoRange<WholeRow> && !CanBePutIntoRange<TextRow>);
static_assert(CanBeLeftOut<NumberRow> && CanBeLeftOut<WholeRow>);
static_assert(!CanBeLeftOut<NumbersRow> && !CanBeLeftOut<TextRow> && !CanBeLeftOut<scene::schema::ObjectRow>);

TEST(Schema, RowsThatContradictThemselvesAreNoConstants) {
    using namespace scene::schema;
    EXPECT_ANY_THROW(Number("a").Required().OrOmitted("", ""));
    EXPECT_ANY_THROW(Whole("a").OrOmittedIfInvalid("", "").Required());
    EXPECT_ANY_THROW(Number("a").Above(0.0f).ClampToRange());
    EXPECT_ANY_THROW(Number("a").ClampToRange().Below(1.0f));
    EXPECT_NO_THROW(Number("a").Between(0.0f, 1.0f).ClampToRange().Required());
}

TEST(Schema, WhatHasNoRowMayBeAnything) {
    GltfDocument document;
    document.AddTriangle()["attributes"]["_ACME"] = "anything";
    document.json["nodes"][0]["weight"] = "anything";
    document.json["nodes"][0]["extras"] = {{"mesh", -1}};
    document.json["nodes"][0]["extensions"]["ACME_node"] = 7;
    document.json["accessors"][0]["min"] = nullptr;
    document.json["extras"] = true;
    document.json["extensions"]["ACME_root"] = Json::array();
    EXPECT_EQ(LoadError(document), "loaded");
}

TEST(Schema, WholeNumbersMayBeWrittenWithAPoint) {
    GltfDocument document;
    document.AddTriangle()["attributes"]["POSITION"] = 0.0;
    document.json["accessors"][0]["count"] = 3.0;
    document.json["nodes"][0]["mesh"] = 0.0;
    document.json["scene"] = 0.0;
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(OnlyPrimitive(scene).positions.size(), 3u);
}

TEST(Schema, DescriptionOfAnotherTypeIsNotRead) {
    GltfDocument document;
    document.AddNode({{"camera", 0}});
    document.Add("cameras", {{"type", "perspective"},
                             {"perspective", {{"yfov", 1}, {"znear", 0.1}}},
                             {"orthographic", "another program's"}});
    EXPECT_EQ(Load(document).cameras.size(), 1u);
    document.json["cameras"][0]["type"] = "orthographic";
    EXPECT_EQ(LoadError(document),
              "scene.gltf: cameras[0].orthographic: is \"another program's\", must be an object");
}

TEST(Schema, RequiredPropertiesOfAnExtensionAreRequired) {
    GltfDocument document;
    document.AddNode({{"extensions", {{"KHR_lights_punctual", Json::object()}}}});
    EXPECT_EQ(
        LoadError(document),
        "scene.gltf: nodes[0].extensions.KHR_lights_punctual.light: is absent, must be a whole number of "
        "at least 0");
}

// tinygltf refuses some of what follows, cuts or drops the rest: it is never given it.

TEST(Model, IndicesWithoutABufferViewAreZeros) {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    primitive["indices"] =
        document.Add("accessors", {{"componentType", kUint8}, {"count", 3}, {"type", "SCALAR"}});
    EXPECT_EQ(OnlyPrimitive(Load(document)).indices, (std::vector<uint32_t>{0, 0, 0}));
}

TEST(Model, OrthographicCameraMayLackItsNearPlane) {
    GltfDocument document;
    document.AddNode({{"camera", 0}});
    document.Add("cameras",
                 {{"type", "orthographic"}, {"orthographic", {{"xmag", 2}, {"ymag", 1}, {"zfar", 10}}}});
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.cameras.at(0).zNear, 0.0f);
    EXPECT_EQ(scene.cameras.at(0).xMag, 2.0f);
}

TEST(Model, WholeNumbersOfExtensionsMayBeGreaterThanAnInt) {
    GltfDocument document;
    document.AddMaterial(
        {{"extensions",
          {{"KHR_materials_emissive_strength", {{"emissiveStrength", 3000000000u}}},
           {"KHR_materials_volume", {{"thicknessFactor", 1}, {"attenuationDistance", 9000000000000u}}},
           {"KHR_materials_specular", {{"specularColorFactor", {1, 5000000000u, 0}}}}}},
         {"extras", {{"priority", 4294967295u}}}});
    const scene::SceneData scene = Load(document);
    const scene::Material& material = scene.materials.at(0);
    EXPECT_EQ(material.emissiveStrength, 3e9f);
    EXPECT_EQ(material.attenuationDistance, 9e12f);
    EXPECT_EQ(material.specularColorFactor, glm::vec3(1.0f, 5e9f, 0.0f));
    EXPECT_EQ(material.priority, 4294967295u);
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(Model, PrimitiveThatCannotBeReadRefusesTheFile) {
    GltfDocument document;
    document.AddTriangle();
    document.json["meshes"][0]["primitives"].push_back({{"mode", 4}});
    EXPECT_EQ(LoadError(document),
              "scene.gltf: meshes[0].primitives[1].attributes: is absent, must be an object");
}

TEST(Model, ManyEmptyObjectsAreRefusedBeforeTheyTakeMemory) {
    GltfDocument document;
    document.json["materials"] = Json::array();
    for (int i = 0; i < 10000; ++i) document.json["materials"].push_back(Json::object());
    scene::LoadOptions options;
    EXPECT_EQ(Load(document, options).materials.size(), 10000u);
    options.limits.maxGeometryBytes = 1 << 20;
    const std::string refusal = "scene.gltf: a model of its objects exceeds the limit of ";
    EXPECT_EQ(LoadError(document, options).substr(0, refusal.size()), refusal);
    // Bytes that are not text do not raise the limit
    const Bytes binary(1 << 20);
    SceneFolder folder;
    EXPECT_EQ(folder.LoadError(MakeGlb(document.Text(), &binary), options).substr(0, refusal.size()),
              refusal);
    options.limits.maxGeometryBytes = std::numeric_limits<uint64_t>::max();
    EXPECT_EQ(Load(document, options).materials.size(), 10000u) << "the limit does not begin again at 0";
}

// Many elements of any list are refused, or take memory that is bounded by the length of the text.
TEST(Model, EachListIsCounted) {
    const Json empty = Json::object();
    const Json triangle = {{"primitives", {{{"attributes", empty}}}}};
    struct Many {
        const char* where;
        const char* list;  // a JSON pointer
        Json element;
        Json around = Json::object();
    };
    const std::vector<Many> all{
        {"accessors", "/accessors", {{"componentType", 5121}, {"count", 1}, {"type", "SCALAR"}}},
        {"bufferViews",
         "/bufferViews",
         {{"buffer", 0}, {"byteLength", 1}},
         {{"buffers", {{{"byteLength", 1}}}}}},
        {"buffers", "/buffers", {{"byteLength", 1}}},
        {"cameras", "/cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}},
        {"images", "/images", {{"uri", ""}}},
        {"lights", "/extensions/KHR_lights_punctual/lights", {{"type", "point"}}},
        {"materials", "/materials", empty},
        {"extensions of materials", "/materials", {{"extensions", {{"KHR_materials_ior", empty}}}}},
        {"extras of materials", "/materials", {{"extras", {{"priority", 1}}}}},
        {"meshes", "/meshes", {{"primitives", Json::array()}}},
        {"primitives", "/meshes/0/primitives", {{"attributes", empty}}, {{"meshes", {triangle}}}},
        {"targets", "/meshes/0/primitives/0/targets", empty, {{"meshes", {triangle}}}},
        {"nodes", "/nodes", empty},
        {"samplers", "/samplers", empty},
        {"scenes", "/scenes", empty},
        {"textures", "/textures", empty},
    };
    scene::LoadOptions options;
    options.limits.maxGeometryBytes = 0;
    for (const Many& many : all) {
        SCOPED_TRACE(many.where);
        GltfDocument document;
        document.json.merge_patch(many.around);
        Json list = Json::array();
        for (int i = 0; i < 20000; ++i) list.push_back(many.element);
        document.json[Json::json_pointer(many.list)] = std::move(list);
        const std::string text = document.Text();
        SceneFolder folder;
        const testing::PeakMemory peak;
        const std::string outcome = folder.LoadError(ToBytes(text), options);
        const double bytesPerCharacter = double(peak.Bytes()) / double(text.size());
        RecordProperty(many.where, std::to_string(bytesPerCharacter) + " " + outcome);
        EXPECT_LT(bytesPerCharacter, 64.0 + 48.0) << outcome;
    }
}

TEST(Model, NamesInUrisAreTakenAsTheyAre) {
    GltfDocument document;
    document.AddTriangle();
    SceneFolder folder;
    folder.Write("a+b.bin", BytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}));
    document.json["buffers"][0]["uri"] = "a+b.bin";
    EXPECT_EQ(OnlyPrimitive(folder.Load(document)).positions.size(), 3u);
}

}  // namespace
}  // namespace raygraph::test::schema_test

// The list of extensions is true: the importer reads those that it says, each has its test, and the page has all.
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

// Each property of each material extension, with values of other types in its place: the file is refused with
// one line that names the place, or loads.
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

// Numbers out of accessors: component types, strides, normalization, sparse ones, and every way they can be
// wrong.
namespace raygraph::test::import_accessor_test {
namespace {

using glm::vec2;
using glm::vec3;
using glm::vec4;

// A triangle whose TEXCOORD_0 is an accessor of the given integers.
template <typename T>
std::vector<vec2> LoadTexCoords(const std::vector<T>& values, bool isNormalized) {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    primitive["attributes"]["TEXCOORD_0"] = document.AddAccessor(values, 2, isNormalized);
    return OnlyPrimitive(Load(document)).uv0;
}

TEST(Accessor, NormalizedIntegersCoverZeroToOne) {
    EXPECT_EQ(LoadTexCoords<uint8_t>({0, 255, 51, 0, 0, 0}, true),
              (std::vector<vec2>{{0, 1}, {0.2f, 0}, {0, 0}}));
    EXPECT_EQ(LoadTexCoords<uint16_t>({0, 65535, 13107, 0, 0, 0}, true),
              (std::vector<vec2>{{0, 1}, {0.2f, 0}, {0, 0}}));
}

TEST(Accessor, SignedNormalizedIntegersReachMinusOneTwice) {
    EXPECT_EQ(LoadTexCoords<int8_t>({-128, -127, 127, 0, 0, 0}, true),
              (std::vector<vec2>{{-1, -1}, {1, 0}, {0, 0}}));
    EXPECT_EQ(LoadTexCoords<int16_t>({-32768, -32767, 32767, 0, 0, 0}, true),
              (std::vector<vec2>{{-1, -1}, {1, 0}, {0, 0}}));
}

TEST(Accessor, PlainIntegersKeepTheirValue) {
    EXPECT_EQ(LoadTexCoords<int16_t>({-300, 7, 1, 2, 3, 4}, false),
              (std::vector<vec2>{{-300, 7}, {1, 2}, {3, 4}}));
    EXPECT_EQ(LoadTexCoords<uint8_t>({200, 7, 1, 2, 3, 4}, false),
              (std::vector<vec2>{{200, 7}, {1, 2}, {3, 4}}));
}

TEST(Accessor, InterleavedStreamsShareOneView) {
    // position.xyz, normal.xyz, a byte pair padded to four.
    Bytes bytes;
    for (int i = 0; i < 3; ++i) {
        const std::vector<float> vertex{
            static_cast<float>(i), static_cast<float>(i * i), 2.0f, 0.0f, 0.0f, 1.0f};
        const Bytes part = BytesOf(vertex);
        bytes.insert(bytes.end(), part.begin(), part.end());
        for (int k : {255, 0, 99, 99}) bytes.push_back(static_cast<std::byte>(k));
    }
    GltfDocument document;
    const size_t view = document.AddBufferView(bytes);
    document.json["bufferViews"][view]["byteStride"] = 28;
    const size_t positions = document.AddAccessorOver(view, kFloat, 3, 3, false);
    const size_t normals = document.AddAccessorOver(view, kFloat, 3, 3, false);
    document.json["accessors"][normals]["byteOffset"] = 12;
    const size_t uv = document.AddAccessorOver(view, kUint8, 3, 2, true);
    document.json["accessors"][uv]["byteOffset"] = 24;
    const size_t mesh = document.AddMesh(
        {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uv}}}});
    document.AddNode({{"mesh", mesh}});

    const scene::SceneData scene = Load(document);
    const scene::Primitive& primitive = OnlyPrimitive(scene);
    EXPECT_EQ(primitive.positions, (std::vector<vec3>{{0, 0, 2}, {1, 1, 2}, {2, 4, 2}}));
    EXPECT_EQ(primitive.normals, std::vector<vec3>(3, vec3(0, 0, 1)));
    EXPECT_EQ(primitive.uv0, std::vector<vec2>(3, vec2(1, 0)));
}

// A triangle with POSITION replaced element by element from a sparse part.
struct SparseTriangle {
    GltfDocument document;
    size_t accessor = 0;

    explicit SparseTriangle(std::vector<uint16_t> indices, bool hasBase = true) {
        document.AddTriangle();
        accessor = document.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].get<size_t>();
        const size_t indexView = document.AddBufferView(BytesOf(indices));
        std::vector<float> values;
        for (size_t i = 0; i < 3 * indices.size(); ++i) values.push_back(10.0f + static_cast<float>(i));
        const size_t valueView = document.AddBufferView(BytesOf(values));
        Json& json = document.json["accessors"][accessor];
        if (!hasBase) json.erase("bufferView");
        json["sparse"] = {{"count", indices.size()},
                          {"indices", {{"bufferView", indexView}, {"componentType", kUint16}}},
                          {"values", {{"bufferView", valueView}}}};
    }
};

TEST(Accessor, SparseValuesReplaceThoseOfTheBase) {
    EXPECT_EQ(OnlyPrimitive(Load(SparseTriangle({0, 2}).document)).positions,
              (std::vector<vec3>{{10, 11, 12}, {1, 0, 0}, {13, 14, 15}}));
}

TEST(Accessor, SparseWithoutBaseIsZeroElsewhere) {
    EXPECT_EQ(OnlyPrimitive(Load(SparseTriangle({1}, false).document)).positions,
              (std::vector<vec3>{{0, 0, 0}, {10, 11, 12}, {0, 0, 0}}));
}

TEST(Accessor, SparseValuesReachSplitVertices) {
    // No normals: vertices are split, read through a list, and the sparse part must follow.
    SparseTriangle sparse({1});
    Json& primitive = sparse.document.json["meshes"][0]["primitives"][0];
    primitive["attributes"].erase("NORMAL");
    const size_t indices = sparse.document.AddAccessor<uint8_t>({2, 1, 0, 1, 2, 0}, 1);
    sparse.document.json["meshes"][0]["primitives"][0]["indices"] = indices;
    EXPECT_EQ(OnlyPrimitive(Load(sparse.document)).positions,
              (std::vector<vec3>{{0, 1, 0}, {10, 11, 12}, {0, 0, 0}, {10, 11, 12}, {0, 1, 0}, {0, 0, 0}}));
}

TEST(Accessor, SparseIndicesOutOfRangeAreRefused) {
    EXPECT_EQ(LoadError(SparseTriangle({3}).document),
              "scene.gltf: accessors[0].sparse.indices: element 0 is 3, but the accessor has 3 elements");
}

TEST(Accessor, SparseIndicesThatDoNotRiseAreRefused) {
    EXPECT_EQ(LoadError(SparseTriangle({1, 1}).document),
              "scene.gltf: accessors[0].sparse.indices: element 1 is 1, not greater than the one before it");
}

TEST(Accessor, SparseCountAboveTheAccessorsIsRefused) {
    EXPECT_EQ(LoadError(SparseTriangle({0, 1, 2, 3}).document),
              "scene.gltf: accessors[0].sparse.count: is 4, more than the accessor's 3 elements");
}

TEST(Accessor, SparsePartsBeyondTheirViewsAreRefused) {
    constexpr const char* kIndices = "/accessors/0/sparse/indices/byteOffset";
    constexpr const char* kValues = "/accessors/0/sparse/values/byteOffset";
    constexpr uint64_t kMuch = uint64_t{1} << 40;  // more than an int holds
    ExpectRefused(
        SparseTriangle({0, 1}).document,
        {{kIndices, 2, "accessors[0].sparse.count: 2 elements from byte 2 exceed bufferViews[2] (4 bytes)"},
         {kIndices, kMuch,
          "accessors[0].sparse.count: 2 elements from byte 1099511627776 exceed bufferViews[2] (4 bytes)"},
         {kValues, 4, "accessors[0].sparse.count: 2 elements from byte 4 exceed bufferViews[3] (24 bytes)"},
         {kValues, kMuch,
          "accessors[0].sparse.count: 2 elements from byte 1099511627776 exceed bufferViews[3] (24 bytes)"},
         {"/accessors/0/sparse/count", kMuch,
          "accessors[0].sparse.count: is 1099511627776, more than the accessor's 3 elements"}});
}

TEST(Accessor, SparseIndicesMustBeUnsigned) {
    ExpectRefused(SparseTriangle({0}).document,
                  {{"/accessors/0/sparse/indices/componentType", kFloat,
                    "accessors[0].sparse.indices.componentType: is 5126, must be 5121, 5123 or 5125"}});
}

// Makes a document whose accessors[0] is POSITION: 3 x VEC3 float, 36 bytes.
GltfDocument Triangle() {
    GltfDocument document;
    document.AddTriangle();
    return document;
}

TEST(Accessor, CountBeyondTheViewIsRefused) {
    ExpectRefused(Triangle(), {{"/accessors/0/count", 4,
                                "accessors[0].count: 4 elements exceed bufferViews[0] (36 bytes)"}});
}

TEST(Accessor, CountThatOverflowsIsRefused) {
    ExpectRefused(Triangle(),
                  {{"/accessors/0/count", 4611686018427387904u,
                    "accessors[0].count: 4611686018427387904 elements exceed bufferViews[0] (36 bytes)"},
                   {"/accessors/0/count", std::numeric_limits<uint64_t>::max(),
                    "accessors[0].count: 18446744073709551615 elements exceed bufferViews[0] (36 bytes)"}});
}

TEST(Accessor, ByteOffsetThatOverflowsIsRefused) {
    ExpectRefused(
        Triangle(),
        {{"/accessors/0/byteOffset", std::numeric_limits<uint64_t>::max() - 3,
          "accessors[0].count: 3 elements from byte 18446744073709551612 exceed bufferViews[0] (36 bytes)"}});
}

TEST(Accessor, HugeCountWithoutAViewIsRefused) {
    GltfDocument document;
    document.AddTriangle();
    for (size_t i = 0; i < 2; ++i) {
        document.json["accessors"][i].erase("bufferView");
        document.json["accessors"][i]["count"] = 4611686018427387904u;
    }
    EXPECT_EQ(LoadError(document),
              "scene.gltf: accessors[0].count: is 4611686018427387904, must be below 2^32 - 1");
    for (size_t i = 0; i < 2; ++i) document.json["accessors"][i]["count"] = 4000000000u;
    const std::string message = LoadError(document);
    EXPECT_NE(message.find("decoded geometry exceeds the limit of"), std::string::npos) << message;
}

TEST(Accessor, CountOfTheWrongTypeIsRefused) {
    constexpr const char* kCount = "/accessors/0/count";
    ExpectRefused(
        Triangle(),
        {{kCount, 0, "accessors[0].count: is 0, must be at least 1"},
         {kCount, -1, "accessors[0].count: is -1, must be a whole number of at least 0"},
         {kCount, 2.5, "accessors[0].count: is 2.5, must be a whole number of at least 0"},
         {kCount, "3", "accessors[0].count: is \"3\", must be a whole number of at least 0"},
         {kCount, nullptr, "accessors[0].count: is null, must be a whole number of at least 0"},
         {kCount, Json::array({3}), "accessors[0].count: is an array, must be a whole number of at least 0"},
         {kCount, 1e300, "accessors[0].count: is 1e+300, must be a whole number of at least 0"}});
}

TEST(Accessor, IntegerWrittenAsFloatIsTaken) {
    ExpectRefused(Triangle(), {{"/accessors/0/count", 3.0, "loaded"}});
}

TEST(Accessor, UnknownTypesAreRefused) {
    ExpectRefused(Triangle(),
                  {{"/accessors/0/componentType", 5124,
                    "accessors[0].componentType: is 5124, must be 5120, 5121, 5122, 5123, 5125 or 5126"},
                   {"/accessors/0/type", "VEC5",
                    "accessors[0].type: is \"VEC5\", must be SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4"},
                   {"/accessors/0/normalized", 1, "accessors[0].normalized: is 1, must be true or false"}});
}

TEST(Accessor, ViewThatDoesNotExistIsRefused) {
    ExpectRefused(Triangle(), {{"/accessors/0/bufferView", 2,
                                "accessors[0].bufferView: is 2, but there are 2 bufferViews"}});
}

TEST(Accessor, NotANumberInVerticesIsRefused) {
    GltfDocument document;
    document.AddTriangle();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const size_t bad = document.AddAccessor<float>({0, 0, 0, 1, 0, 0, 0, nan, 0}, 3);
    document.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = bad;
    EXPECT_EQ(LoadError(document), "scene.gltf: accessors[2]: element 2 is not finite");
    const size_t infinite =
        document.AddAccessor<float>({0, std::numeric_limits<float>::infinity(), 0, 1, 0, 0, 0, 0, 0}, 3);
    document.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = infinite;
    EXPECT_EQ(LoadError(document), "scene.gltf: accessors[3]: element 0 is not finite");
}

TEST(BufferView, OutsideItsBufferIsRefused) {
    ExpectRefused(
        Triangle(),
        {{"/bufferViews/0/byteOffset", 1,
          "bufferViews[0].byteLength: 36 bytes from 1 exceed buffers[0] (36 bytes)"},
         {"/bufferViews/0/byteOffset", std::numeric_limits<uint64_t>::max(),
          "bufferViews[0].byteLength: 36 bytes from 18446744073709551615 exceed buffers[0] (36 bytes)"},
         {"/bufferViews/0/buffer", 7, "bufferViews[0].buffer: is 7, but there are 2 buffers"}});
}

TEST(BufferView, StrideOutOfRangeIsRefused) {
    constexpr const char* kStride = "/bufferViews/0/byteStride";
    ExpectRefused(
        Triangle(),
        {{kStride, 256, "bufferViews[0].byteStride: is 256, must be 4 to 252"},
         {kStride, 0, "bufferViews[0].byteStride: is 0, must be 4 to 252"},
         {kStride, 8,
          "accessors[0].bufferView: bufferViews[0].byteStride of 8 is less than the element's 12 bytes"}});
}

// glTF asks for multiples of 4, but all that is wrong with others is that they are slow to read.
TEST(BufferView, StrideNeedNotBeAMultipleOfFour) {
    const std::vector<glm::vec3> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    constexpr size_t kStride = 14;
    Bytes bytes(2 * kStride + sizeof(glm::vec3));
    for (size_t i = 0; i < positions.size(); ++i)
        std::memcpy(&bytes[kStride * i], &positions[i], sizeof(glm::vec3));
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    const size_t view = document.AddBufferView(bytes);
    primitive["attributes"] = {{"POSITION", document.AddAccessorOver(view, kFloat, 3, 3, false)}};
    document.json["bufferViews"][view]["byteStride"] = kStride;
    EXPECT_EQ(OnlyPrimitive(Load(document)).positions, positions);
}

TEST(Buffer, ShorterThanItsByteLengthIsRefused) {
    ExpectRefused(Triangle(), {{"/buffers/0/byteLength", 40,
                                "buffers[0].byteLength: is 40, but the buffer has 36 bytes"}});
}

}  // namespace
}  // namespace raygraph::test::import_accessor_test
