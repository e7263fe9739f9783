// The container: .glb chunks, JSON text, version, extensions.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/scene/gltf_document.h"

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
    const std::string open(1000000, '[');
    EXPECT_EQ(SceneFolder().LoadError(ToBytes(open)),
              "scene.gltf: JSON is nested deeper than 64 levels at byte 64");
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
    EXPECT_EQ(LoadError(document), "scene.gltf: asset: is absent, must be an object");
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
