// A defect in data is an error if a picture depends on the data, and otherwise a warning. No defect reaches
// the scene: Check, which runs after loading, refuses values that are not finite or out of range.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "renderer/scene/gltf/save_gltf.h"
#include "tests/scene/gltf_document.h"

namespace raygraph::test::unused_defects_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

Json& Primitive(GltfDocument& document) {
    return document.json["meshes"][0]["primitives"][0];
}

// Returns a triangle with tangents and two texture coordinate sets, which are not finite at vertex 1.
GltfDocument WithBrokenStreams() {
    GltfDocument document;
    Json& attributes = document.AddTriangle()["attributes"];
    attributes["TANGENT"] = document.AddAccessor<float>({1, 0, 0, 1, kNan, 0, 0, 1, 1, 0, 0, 1}, 4);
    attributes["TEXCOORD_0"] = document.AddAccessor<float>({0, 0, 1, kInfinity, 0, 1}, 2);
    attributes["TEXCOORD_1"] = document.AddAccessor<float>({0, 0, kNan, 0, 0, 1}, 2);
    return document;
}

void AddTexture(GltfDocument& document) {
    document.Add("images", {{"uri", DataUri(MakePng(1, 1, {1, 2, 3, 4}))}});
    document.Add("textures", {{"source", 0}});
}

// Returns the message of loading these streams with this material.
std::string WithMaterial(const Json& material) {
    GltfDocument document = WithBrokenStreams();
    AddTexture(document);
    Primitive(document)["material"] = document.AddMaterial(material);
    return LoadError(document);
}

TEST(UnusedDefects, StreamsThatNoMaterialReadsMayBeBroken) {
    const scene::SceneData scene = Load(WithBrokenStreams());
    // Warnings come in the order of reading, one line for each kind
    EXPECT_THAT(
        scene.warnings,
        ElementsAre(
            "scene.gltf: accessors[3]: element 1 is not finite, and no picture depends on it; replaced "
            "(and 2 more)"))
        << "what has been replaced is not warned of again";
    const scene::Primitive& primitive = OnlyPrimitive(scene);
    EXPECT_EQ(primitive.uv0[1], glm::vec2(0.0f));
    EXPECT_EQ(primitive.uv1[2], glm::vec2(0.0f, 1.0f)) << "what is whole stays";
    EXPECT_TRUE(std::isfinite(primitive.tangents[1].x));
}

TEST(UnusedDefects, StreamsThatAMaterialReadsMayNot) {
    const std::string tangent = "scene.gltf: accessors[2]: element 1 is not finite";
    const std::string uv0 = "scene.gltf: accessors[3]: element 1 is not finite";
    const std::string uv1 = "scene.gltf: accessors[4]: element 1 is not finite";
    const auto at = [](int set) { return Json{{"index", 0}, {"texCoord", set}}; };
    EXPECT_EQ(WithMaterial(Json::object()), "loaded");
    EXPECT_EQ(WithMaterial({{"emissiveTexture", at(0)}}), uv0);
    EXPECT_EQ(WithMaterial({{"emissiveTexture", at(1)}}), uv1);
    EXPECT_EQ(WithMaterial({{"occlusionTexture", at(0)}}), "loaded");
    EXPECT_EQ(WithMaterial({{"extensions", {{"KHR_materials_clearcoat", {{"clearcoatTexture", at(1)}}}}}}),
              uv1);
    EXPECT_EQ(WithMaterial({{"extensions", {{"KHR_materials_anisotropy", {{"anisotropyStrength", 1}}}}}}),
              tangent);
    // A normal map depends on its texture coordinates and on the tangents
    EXPECT_EQ(WithMaterial({{"normalTexture", at(1)}}), uv1);
}

TEST(UnusedDefects, CoordinatesThatTangentsAreMadeOfAreUsed) {
    GltfDocument document = WithBrokenStreams();
    Primitive(document)["attributes"].erase("TANGENT");
    Primitive(document)["material"] =
        document.AddMaterial({{"extensions", {{"KHR_materials_anisotropy", {{"anisotropyStrength", 1}}}}}});
    EXPECT_EQ(LoadError(document), "scene.gltf: accessors[3]: element 1 is not finite");
}

TEST(UnusedDefects, MaterialOfAVariantCountsToo) {
    GltfDocument document = WithBrokenStreams();
    AddTexture(document);
    Json& primitive = Primitive(document);
    primitive["material"] = document.AddMaterial(Json::object());
    document.json["extensionsUsed"] = {"KHR_materials_variants"};
    document.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "other"}}};
    const size_t other = document.AddMaterial({{"emissiveTexture", {{"index", 0}, {"texCoord", 1}}}});
    primitive["extensions"]["KHR_materials_variants"]["mappings"] = {
        {{"material", other}, {"variants", {0}}}};
    EXPECT_EQ(LoadError(document), "scene.gltf: accessors[4]: element 1 is not finite");
}

// Returns accessors with four vertices, of which the triangle names three: all but number `unused`.
GltfDocument WithUnusedVertex(uint16_t unused) {
    GltfDocument document;
    std::vector<float> positions, normals;
    for (size_t i = 0; i < 4; ++i) {
        const bool isBroken = i == unused;
        positions.insert(positions.end(),
                         {isBroken ? kNan : 5.0f + float(i == 1), isBroken ? kInfinity : float(i), 2});
        normals.insert(normals.end(), {0, 0, isBroken ? kNan : 1.0f});
    }
    std::vector<uint16_t> indices;
    for (uint16_t i = 0; i < 4; ++i)
        if (i != unused) indices.push_back(i);
    const Json attributes{{"POSITION", document.AddAccessor(positions, 3)},
                          {"NORMAL", document.AddAccessor(normals, 3)}};
    document.AddNode({{"mesh", document.AddMesh({{"attributes", attributes},
                                                 {"indices", document.AddAccessor(indices, 1)}})}});
    return document;
}

TEST(UnusedDefects, VertexThatNoIndexNamesMayBeBroken) {
    for (const uint16_t unused : {uint16_t{0}, uint16_t{2}, uint16_t{3}}) {
        const scene::SceneData scene = Load(WithUnusedVertex(unused));
        ASSERT_EQ(scene.warnings.size(), 1u);
        EXPECT_EQ(scene.warnings[0],
                  "scene.gltf: accessors[0]: element " + std::to_string(unused) +
                      " is not finite, and no picture depends on it; replaced (and 1 more)");
        // The bounds are those of the triangle alone, because they frame the picture
        EXPECT_EQ(scene.bounds.min.x, 5.0f);
        EXPECT_EQ(scene.bounds.max.x, 6.0f);
        EXPECT_EQ(scene.bounds.min.z, 2.0f);
    }
    GltfDocument named = WithUnusedVertex(2);
    Primitive(named)["indices"] = named.AddAccessor<uint16_t>({0, 1, 2}, 1);
    EXPECT_EQ(LoadError(named), "scene.gltf: accessors[0]: element 2 is not finite");
}

TEST(UnusedDefects, UnusedVertexMayFollowAJointThatIsNotThere) {
    GltfDocument document = SkinnedTriangle();
    Json& primitive = Primitive(document);
    const auto four = [&](const char* name, const std::vector<float>& values, size_t components) {
        primitive["attributes"][name] = document.AddAccessor(values, components);
    };
    four("POSITION", {0, 0, 0, 1, 0, 0, 0, 1, 0, 9, 9, 9}, 3);
    four("NORMAL", {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    four("WEIGHTS_0", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, 4);
    primitive["attributes"]["JOINTS_0"] =
        document.AddAccessor<uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 77, 0, 0, 0}, 4);
    primitive["indices"] = document.AddAccessor<uint16_t>({0, 1, 2}, 1);
    const scene::SceneData scene = Load(document);
    EXPECT_THAT(scene.warnings,
                ElementsAre(HasSubstr("vertex 3 follows joint 77, skins[0] has 2 joints; it is in no "
                                      "triangle")));
    EXPECT_EQ(OnlyPrimitive(scene).influences.joints.back(), 0u);
    primitive["indices"] = document.AddAccessor<uint16_t>({0, 1, 3}, 1);
    EXPECT_THAT(LoadError(document),
                HasSubstr("attributes: vertex 3 follows joint 77, skins[0] has 2 joints"));
}

TEST(UnusedDefects, MorphTargetsOfUnusedVerticesAndUnreadTangentsMayBeBroken) {
    GltfDocument document = WithUnusedVertex(3);
    Json& primitive = Primitive(document);
    primitive["attributes"]["TANGENT"] =
        document.AddAccessor<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}, 4);
    const size_t ofUnused = document.AddAccessor<float>({1, 0, 0, 1, 0, 0, 1, 0, 0, kNan, 0, 0}, 3);
    const size_t ofAll = document.AddAccessor<float>({kNan, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0}, 3);
    primitive["targets"] = {{{"POSITION", ofUnused}, {"TANGENT", ofAll}}};
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.warnings.size(), 1u);
    const scene::MorphTarget& target = OnlyPrimitive(scene).targets.at(0);
    EXPECT_EQ(target.positions[3], glm::vec3(1, 0, 0));
    EXPECT_EQ(target.tangents[0], glm::vec3(0.0f));
    primitive["targets"] = {{{"POSITION", ofAll}}};
    EXPECT_EQ(LoadError(document), "scene.gltf: accessors[5]: element 0 is not finite");
}

TEST(UnusedDefects, SkinThatDeformsNothingIsNotRead) {
    GltfDocument document = SkinnedTriangle();
    const size_t broken = AddMatrices(document, std::vector<float>(32, kNan));
    document.Add("skins", {{"joints", {1, 2}}, {"inverseBindMatrices", broken}, {"skeleton", 99}});
    EXPECT_THAT(Load(document).warnings, ElementsAre());
    document.json["nodes"][0]["skin"] = 1;
    EXPECT_THAT(LoadError(document), HasSubstr("element 0 is not finite"));
}

// Several primitives of one accessor are one defect.
TEST(UnusedDefects, AccessorThatPrimitivesShareIsWarnedOfOnce) {
    GltfDocument document = WithBrokenStreams();
    Json& primitives = document.json["meshes"][0]["primitives"];
    primitives[0]["attributes"].erase("TANGENT");
    primitives[0]["attributes"].erase("TEXCOORD_1");
    primitives.push_back(primitives[0]);
    EXPECT_THAT(
        Load(document).warnings,
        ElementsAre("scene.gltf: accessors[3]: element 1 is not finite, and no picture depends on it; "
                    "replaced"));
}

// The URIs of images: those that the triangle's base color and occlusion read, and one that no used material
// reads.
struct Images {
    const char *base, *occlusion, *unreferenced;
};

GltfDocument WithImages(const Images& uris) {
    GltfDocument document;
    for (const char* uri : {uris.base, uris.occlusion, uris.unreferenced}) {
        document.Add("textures", {{"source", document.Add("images", {{"uri", uri}})}});
    }
    document.AddTriangle()["material"] =
        document.AddMaterial({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                              {"occlusionTexture", {{"index", 1}}}});
    document.AddMaterial({{"emissiveTexture", {{"index", 2}}}});
    return document;
}

class UnusedImages : public ::testing::Test {
  protected:
    UnusedImages() {
        folder.Write("ok.png", MakePng(2, 2, {1, 2, 3, 4}));
        folder.Write("no.png", ToBytes("not a picture"));
    }
    SceneFolder folder;
};

TEST_F(UnusedImages, MissingOrBrokenOnesAreAWarning) {
    const scene::SceneData scene = folder.Load(WithImages({"ok.png", "gone.png", "no.png"}));
    EXPECT_THAT(
        scene.warnings,
        ElementsAre(
            "scene.gltf: images[1].uri: \"gone.png\": No such file or directory; no picture shows it, "
            "left out (and 1 more)"));
    ASSERT_EQ(scene.images.size(), 3u);
    EXPECT_EQ(scene.images[0].width, 2u);
    for (const size_t i : {size_t{1}, size_t{2}})
        EXPECT_EQ(scene.images[i].rgba, std::vector<uint8_t>(4, 255));
    EXPECT_EQ(scene.materials[0].occlusionTexture.texture, 1) << "kept as the file has it";
}

TEST_F(UnusedImages, ThoseThatAPictureShowsAreAnError) {
    EXPECT_EQ(folder.LoadError(WithImages({"gone.png", "ok.png", "ok.png"})),
              "scene.gltf: images[0].uri: \"gone.png\": No such file or directory");
    // One image has occlusion and roughness, which pictures depend on
    GltfDocument shared = WithImages({"ok.png", "gone.png", "ok.png"});
    shared.json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"] = 1;
    EXPECT_EQ(folder.LoadError(shared), "scene.gltf: images[1].uri: \"gone.png\": No such file or directory");
    // A variant's material may be chosen
    GltfDocument chosen = WithImages({"ok.png", "ok.png", "no.png"});
    chosen.json["extensionsUsed"] = {"KHR_materials_variants"};
    chosen.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "other"}}};
    Primitive(chosen)["extensions"]["KHR_materials_variants"]["mappings"] = {
        {{"material", 1}, {"variants", {0}}}};
    EXPECT_THAT(folder.LoadError(chosen), HasSubstr("images[2] \"no.png\": is of an unknown format"));
    // A mesh that no node places is not shown
    GltfDocument apart = WithImages({"ok.png", "ok.png", "no.png"});
    Json other = Primitive(apart);
    other["material"] = 1;
    const size_t mesh = apart.AddMesh(other);
    EXPECT_EQ(folder.LoadError(apart), "loaded");
    apart.AddNode({{"mesh", mesh}});
    EXPECT_THAT(folder.LoadError(apart), HasSubstr("images[2] \"no.png\": is of an unknown format"));
}

TEST_F(UnusedImages, SceneIsSavedElsewhereWithoutThem) {
    const std::filesystem::path source =
        folder.Write("scene.gltf", WithImages({"ok.png", "gone.png", "no.png"}).Text());
    const TemporaryFolder to;
    scene::SaveGltf(source, scene::LoadGltf(source), to / "saved.gltf");
    EXPECT_TRUE(std::filesystem::exists(to / "ok.png"));
    EXPECT_FALSE(std::filesystem::exists(to / "no.png"));
    EXPECT_EQ(scene::LoadGltf(to / "saved.gltf").images[0].width, 2u);
}

TEST_F(UnusedImages, PictureThatLacksOnlyTheEndOfItsFileIsReadWithAWarning) {
    Bytes png = MakePng(8, 8, {1, 2, 3, 4});
    png.resize(png.size() - 12);  // the chunk that ends it
    folder.Write("cut.png", png);
    const scene::SceneData scene = folder.Load(WithImages({"cut.png", "ok.png", "ok.png"}));
    EXPECT_THAT(scene.warnings,
                ElementsAre("scene.gltf: images[0] \"cut.png\": the file is cut off behind its last pixel"));
    EXPECT_EQ(scene.images[0].rgba.back(), 4);
    png.resize(png.size() / 2);
    folder.Write("cut.png", png);
    EXPECT_THAT(folder.LoadError(WithImages({"cut.png", "ok.png", "ok.png"})),
                HasSubstr("images[0] \"cut.png\": PNG: "));
}

TEST(UnusedDefects, NamesAndNumbersThatNothingReadsAreLeftOut) {
    GltfDocument document;
    document.AddTriangle();
    document.json["nodes"][0]["name"] = 5;
    document.json["meshes"][0]["name"] = Json::array();
    document.AddNode(
        {{"camera",
          document.Add("cameras", {{"type", "perspective"},
                                   {"perspective", {{"yfov", 1}, {"znear", 1}, {"aspectRatio", 0}}}})}});
    const scene::SceneData scene = Load(document);
    EXPECT_THAT(
        scene.warnings,
        ElementsAre("scene.gltf: meshes[0].name: is an array, must be a string, left out (and 1 more)",
                    "scene.gltf: cameras[0].perspective.aspectRatio: is 0, must be above 0, ignored"));
    EXPECT_EQ(scene.nodes[0].name, "");
    EXPECT_EQ(scene.cameras[0].aspectRatio, 0.0f);
}

// Returns a triangle whose node has the name that the JSON text gives between the quotes.
std::string Named(std::string_view name) {
    GltfDocument document;
    document.AddTriangle();
    document.json["nodes"][0]["name"] = "NAME";
    std::string text = document.Text();
    return text.replace(text.find("NAME"), 4, name);
}

TEST(BrokenCharacters, AreReplacedInStringsWithOneWarning) {
    const std::string kLost = "\xEF\xBF\xBD";
    const struct {
        std::string written, read;
        size_t count;
    } rows[] = {
        {"a\\ud83d", "a" + kLost, 1},
        {"\\ud83db", kLost + "b", 1},
        {"\\ude00", kLost, 1},
        {"\\ud83d\\ud83d\\ude00", kLost + "\xF0\x9F\x98\x80", 1},
        {"\\uD83D\\u0041", kLost + "A", 1},
        {"\\\\\\ud83d\\\"", "\\" + kLost + "\"", 1},
        {"caf\xE9", "caf" + kLost, 1},
        {"\xED\xA0\xBD", kLost + kLost + kLost, 3},
        {"two\nlines\ttabbed", "two" + kLost + "lines" + kLost + "tabbed", 2},
        {"\xC3", kLost, 1},
    };
    for (const auto& row : rows) {
        const std::string text = Named(row.written);
        const scene::SceneData scene = SceneFolder().Load(ToBytes(text));
        EXPECT_EQ(scene.nodes[0].name, row.read) << row.written;
        ASSERT_EQ(scene.warnings.size(), 1u) << row.written;
        EXPECT_THAT(scene.warnings[0], HasSubstr("scene.gltf: " + std::to_string(row.count) +
                                                 (row.count == 1 ? " character of its strings is"
                                                                 : " characters of its strings are") +
                                                 " not well-formed, the first at byte "));
    }
    const std::string text = Named("x\\ud83d");
    EXPECT_THAT(SceneFolder().Load(ToBytes(text)).warnings[0],
                HasSubstr("at byte " + std::to_string(text.find("\\ud83d")) + ";"));
}

TEST(BrokenCharacters, WholeOnesAreKeptWithoutAWord) {
    for (const char* name : {"\\ud83d\\ude00 \\u00e9", "\xF0\x9F\x98\x80 \xC3\xA9", "\\\\ud83d \\n\\t\\/"}) {
        const std::string text = Named(name);
        const scene::SceneData scene = SceneFolder().Load(ToBytes(text));
        EXPECT_TRUE(scene.warnings.empty()) << name;
        EXPECT_EQ(scene.nodes[0].name, Json::parse(text)["nodes"][0]["name"].get<std::string>());
    }
}

TEST(BrokenCharacters, ElsewhereOrInWhatIsUsedTheyAreErrors) {
    const std::string text = Named("x");
    EXPECT_THAT(SceneFolder().LoadError(ToBytes("\xE9" + text)), HasSubstr("not a glTF file"));
    EXPECT_THAT(SceneFolder().LoadError(ToBytes(Named("\\u12"))), HasSubstr("not valid JSON"));
    EXPECT_THAT(SceneFolder().LoadError(ToBytes(Named("\\x"))), HasSubstr("not valid JSON"));
    EXPECT_THAT(SceneFolder().LoadError(ToBytes(text.substr(0, text.find("x\"") + 1) + "\\")),
                HasSubstr("not valid JSON"));
    GltfDocument document;
    document.AddTriangle();
    document.json["buffers"][0]["uri"] = "URI";
    std::string broken = document.Text();
    broken.replace(broken.find("URI"), 3, "a\\ud83d.bin");
    EXPECT_THAT(SceneFolder().LoadError(ToBytes(broken)),
                HasSubstr("buffers[0].uri: \"a\xEF\xBF\xBD.bin\": No such file"));
}

TEST(BrokenCharacters, SceneIsSavedWithThemReplaced) {
    SceneFolder folder;
    const std::filesystem::path source = folder.Write("scene.gltf", Named("a\\ud83d"));
    scene::SceneData edited = scene::LoadGltf(source);
    edited.nodes[0].translation = {1, 2, 3};
    scene::SaveGltf(source, edited, folder.Path() / "saved.gltf");
    const scene::SceneData saved = scene::LoadGltf(folder.Path() / "saved.gltf");
    EXPECT_TRUE(saved.warnings.empty());
    EXPECT_EQ(saved.nodes[0].name, "a\xEF\xBF\xBD");
    EXPECT_EQ(saved.nodes[0].translation, glm::vec3(1, 2, 3));
}

}  // namespace
}  // namespace raygraph::test::unused_defects_test
