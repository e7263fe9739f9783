// Files saved again: what was edited is there, and everything else as it was.
#include "renderer/scene/gltf/save_gltf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <glm/gtc/matrix_transform.hpp>
#include <sstream>

#include "renderer/scene/geometry/split_mesh.h"
#include "tests/scene/gltf_document.h"
#include "tests/scene/same_scene.h"
#include "tests/support/reference_assets.h"
#include "tests/support/source_file.h"

namespace raygraph::test::save_gltf_test {
namespace {

namespace fs = std::filesystem;

std::string TextOf(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

Json JsonOf(const fs::path& file) {
    return Json::parse(TextOf(file));
}

class SaveGltf : public ::testing::Test {
  protected:
    scene::SceneData Save(const fs::path& source, const scene::SceneData& edited, const fs::path& target) {
        scene::SaveGltf(source, edited, target);
        return scene::LoadGltf(target);
    }
    std::string Failure(const fs::path& source, const scene::SceneData& edited, const fs::path& target) {
        try {
            scene::SaveGltf(source, edited, target);
        } catch (const Error& error) {
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
            return error.what();
        }
        return "saved";
    }
    SceneFolder from;
    TemporaryFolder folder;
    fs::path Target(const char* name) const { return folder.Path() / name; }
};

}  // namespace

TEST_F(SaveGltf, OwnScenesComeBackToTheBitAndTheSecondSaveIsTheFirst) {
    size_t count = 0;
    for (const auto& entry : fs::directory_iterator(test::SourceFile("scenes"))) {
        if (entry.path().extension() != ".gltf" || entry.file_size() > 400'000) continue;
        SCOPED_TRACE(entry.path().filename().string());
        const scene::SceneData scene = scene::LoadGltf(entry.path());
        ExpectSame(scene, Save(entry.path(), scene, Target("saved.gltf")));
        EXPECT_EQ(JsonOf(entry.path()), JsonOf(Target("saved.gltf")));
        const std::string first = TextOf(Target("saved.gltf"));
        scene::SaveGltf(Target("saved.gltf"), scene, Target("again.gltf"));
        EXPECT_TRUE(first == TextOf(Target("again.gltf")));
        ExpectSame(scene, Save(entry.path(), scene, Target("saved.glb")));
        ++count;
    }
    EXPECT_GE(count, 8u);
}

TEST_F(SaveGltf, PublishedScenesComeBack) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    size_t count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(*ReferenceAssets() / "scenes" / "known")) {
        const fs::path extension = entry.path().extension();
        if ((extension != ".gltf" && extension != ".glb") || entry.file_size() > 3'000'000) continue;
        SCOPED_TRACE(entry.path().filename().string());
        scene::SceneData edited;
        try {
            edited = scene::LoadGltf(entry.path());
        } catch (const Error&) {
            continue;  // it requires an extension that is not read
        }
        for (scene::Material& material : edited.materials) material.roughnessFactor = 0.375f;
        for (const uint32_t node : edited.nodeOrder) {
            glm::mat4x3 moved = edited.nodes[node].LocalTransform();
            moved[3] += glm::vec3(0.5f, -0.25f, 1.0f);
            edited.nodes[node].matrix = moved;
        }
        scene::UpdateWorldTransforms(edited);
        const fs::path name = entry.path().stem().string() + extension.string();
        fs::create_directories(Target(std::to_string(count).c_str()));
        ExpectSame(edited, Save(entry.path(), edited, Target(std::to_string(count).c_str()) / name), 1e-5f);
        ++count;
    }
    EXPECT_GE(count, 10u);
}

// Metadata: what extras and KHR_xmp_json_ld hold, wherever it stands, in its order.
TEST_F(SaveGltf, MetadataIsKeptWhereItWas) {
    GltfDocument document;
    document.AddTriangle()["material"] = document.AddMaterial({{"name", "m"}});
    document.json["extensionsUsed"] = {"KHR_xmp_json_ld"};
    document.json["extensions"]["KHR_xmp_json_ld"]["packets"] =
        Json::array({{{"@context", {{"dc", "http://purl.org/dc/elements/1.1/"}}},
                      {"dc:title", "z"},
                      {"a", {1.5, true}}}});
    for (const char* place : {"/asset", "/scenes/0", "/nodes/0", "/meshes/0", "/materials/0"}) {
        Json& object = document.json[Json::json_pointer(place)];
        object["extensions"]["KHR_xmp_json_ld"]["packet"] = 0;
        object["extras"] = {{"of", place}, {"list", {1, "two", nullptr}}};
    }
    document.json["meshes"][0]["primitives"][0]["extras"] = "a text";
    const fs::path source = from.Write("scene.gltf", document.Text());
    scene::SceneData edited = scene::LoadGltf(source);
    EXPECT_TRUE(edited.warnings.empty());
    edited.nodes[0].translation = {1, 2, 3};
    edited.materials[0].roughnessFactor = 0.5f;
    edited.materials[0].priority = 2;
    scene::UpdateWorldTransforms(edited);
    for (const char* name : {"saved.gltf", "saved.glb"})
        ExpectSame(edited, Save(source, edited, Target(name)));
    Json expected = document.json;
    expected["nodes"][0]["translation"] = {1.0, 2.0, 3.0};
    expected["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 0.5;
    expected["materials"][0]["extras"]["priority"] = 2;
    EXPECT_EQ(JsonOf(Target("saved.gltf")), expected);
    const std::string glb = TextOf(Target("saved.glb"));
    const size_t end = glb.rfind('}');
    EXPECT_EQ(Json::parse(glb.substr(20, end - 19)), expected);
}

TEST_F(SaveGltf, EditsOfOwnScenesComeBack) {
    const fs::path source = test::SourceFile("scenes/cornell.gltf");
    scene::SceneData edited = scene::LoadGltf(source);
    edited.materials[0].baseColorFactor = {0.1f, 0.7f, 1.0f / 3.0f, 1.0f};
    edited.materials[0].roughnessFactor = 0.123456789f;
    edited.materials[1].emissiveStrength = 12.5f;
    edited.materials[1].ior = 1.33f;
    edited.materials[1].transmissionFactor = 0.25f;
    edited.materials[1].thicknessFactor = 0.5f;
    edited.materials[1].attenuationDistance = 2.0f;
    edited.materials[1].isUnlit = true;
    edited.materials[1].priority = 3;
    for (const uint32_t node : edited.nodeOrder)
        edited.nodes[node].matrix = glm::mat4x3(
            glm::rotate(glm::translate(glm::mat4(edited.nodes[node].LocalTransform()), {0.1f, -2.0f, 3.0f}),
                        0.3f, glm::vec3(0.6f, 0.0f, 0.8f)));
    for (scene::Light& light : edited.lights) light.intensity *= 1.7f;
    scene::UpdateWorldTransforms(edited);
    ExpectSame(edited, Save(source, edited, Target("edited.gltf")), 1e-5f);
    const std::string first = TextOf(Target("edited.gltf"));
    scene::SaveGltf(source, edited, Target("edited.gltf"));
    EXPECT_EQ(first, TextOf(Target("edited.gltf")));
    // Saves the scene as it was read, without edits
    scene::SaveGltf(Target("edited.gltf"), scene::LoadGltf(Target("edited.gltf")), Target("again.gltf"));
    EXPECT_EQ(first, TextOf(Target("again.gltf")));
}

TEST_F(SaveGltf, MovedNodeKeepsItsRotationScaleAndAllElse) {
    GltfDocument document;
    document.AddTriangle();
    document.json["nodes"][0]["rotation"] = {0.1, 0.2, 0.3, 0.9273618495495703};
    document.json["nodes"][0]["scale"] = {2, 3, 0.1};
    document.json["nodes"][0]["extras"] = {{"studio", "kept"}, {"numbers", {1, 2.5, -0.0}}};
    document.json["nodes"][0]["extensions"] = {{"EXT_unheard_of", {{"a", 1}}}};
    document.json["extensionsUsed"] = {"EXT_unheard_of"};
    document.AddNode({{"name", "matrix"}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1}}});
    const fs::path source = from.Write("scene.gltf", document.Text());
    scene::SceneData edited = scene::LoadGltf(source);
    glm::mat4x3 moved = edited.nodes[0].LocalTransform();
    moved[3] = {0.1f, 7.0f, -1.5f};
    edited.nodes[0].matrix = moved;
    edited.nodes[1].matrix = glm::mat4x3(glm::translate(glm::mat4(1.0f), glm::vec3(9, 8, 7)));
    scene::UpdateWorldTransforms(edited);
    ExpectSame(edited, Save(source, edited, Target("moved.gltf")));
    Json expected = document.json;
    expected["nodes"][0]["translation"] = {0.1, 7.0, -1.5};
    expected["nodes"][1]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 9, 8, 7, 1};
    EXPECT_EQ(JsonOf(Target("moved.gltf")), expected);
}

// A place has more digits than a float.
TEST_F(SaveGltf, TurnedNodeKeepsItsRotationWhereItIsScaledToNothing) {
    GltfDocument document;
    document.AddTriangle();
    document.json["nodes"][0]["scale"] = {0, 0, 0};
    const fs::path source = from.Write("scene.gltf", document.Text());
    scene::SceneData scene = scene::LoadGltf(source);
    scene.nodes[0].rotation = glm::quat(0.0f, 0.0f, 1.0f, 0.0f);
    EXPECT_EQ(Save(source, scene, Target("saved.gltf")).nodes[0].rotation, scene.nodes[0].rotation);
}

TEST_F(SaveGltf, PlacesFarAwayKeepTheirRest) {
    GltfDocument document;
    document.AddTriangle();
    document.AddNode({{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1}}, {"mesh", 0}});
    const fs::path source = from.Write("scene.gltf", document.Text());
    scene::SceneData edited = scene::LoadGltf(source);
    const scene::SplitPlace far = scene::Split({10'000.5003, -6e6 + 0.125, 3.0});
    edited.nodes[0].translation = far.rounded;
    edited.nodes[0].translationResidual = far.rest;
    glm::mat4x3 moved = edited.nodes[1].LocalTransform();
    moved[3] = far.rounded;
    edited.nodes[1].matrix = moved;
    edited.nodes[1].translationResidual = far.rest;
    scene::UpdateWorldTransforms(edited);
    const scene::SceneData saved = Save(source, edited, Target("far.gltf"));
    ExpectSame(edited, saved);
    for (const scene::Node& node : saved.nodes) EXPECT_EQ(node.translationResidual, far.rest);
    // The rest alone
    edited = saved;
    edited.nodes[0].translationResidual += glm::vec3(1e-4f, 0, 0);
    scene::UpdateWorldTransforms(edited);
    EXPECT_EQ(Save(Target("far.gltf"), edited, Target("farther.gltf")).nodes[0].translationResidual,
              edited.nodes[0].translationResidual);
}

TEST_F(SaveGltf, TurnedAndShearedNodes) {
    GltfDocument document;
    document.AddTriangle();
    document.json["nodes"][0]["scale"] = {-2, 3, 4};
    document.AddNode({{"translation", {1, 2, 3}}, {"mesh", 0}});
    const fs::path source = from.Write("scene.gltf", document.Text());
    scene::SceneData edited = scene::LoadGltf(source);
    const glm::mat4 turn = glm::rotate(glm::mat4(1.0f), 1.2f, glm::normalize(glm::vec3(1, 2, 3)));
    edited.nodes[0].matrix = glm::mat4x3(turn * glm::mat4(edited.nodes[0].LocalTransform()));
    edited.nodes[1].matrix =
        glm::mat4x3(glm::scale(glm::mat4(1.0f), glm::vec3(1, 5, 1)) * turn *
                    glm::mat4(edited.nodes[1].LocalTransform()));  // across its axes: it shears
    scene::UpdateWorldTransforms(edited);
    ExpectSame(edited, Save(source, edited, Target("turned.gltf")), 1e-5f);
    const Json nodes = JsonOf(Target("turned.gltf"))["nodes"];
    EXPECT_EQ(nodes[0]["scale"], (Json{-2, 3, 4})) << "mirrored as before";
    EXPECT_TRUE(nodes[0].contains("rotation"));
    EXPECT_TRUE(nodes[1].contains("matrix"));
    EXPECT_FALSE(nodes[1].contains("translation"));
}

TEST_F(SaveGltf, DefaultMaterialThatWasEditedBecomesOneOfTheFile) {
    GltfDocument document;
    document.AddTriangle();
    document.AddMaterial({{"name", "unused"}});
    const fs::path source = from.Write("scene.gltf", document.Text());
    scene::SceneData edited = scene::LoadGltf(source);
    ASSERT_EQ(edited.materials.size(), 2u);
    edited.materials[1].baseColorFactor = {1, 0, 0, 1};
    ExpectSame(edited, Save(source, edited, Target("red.gltf")));
}

TEST_F(SaveGltf, SharedLightIsSplitWhereOneOfItsNodesIsEdited) {
    GltfDocument document;
    document.json["extensionsUsed"] = {"KHR_lights_punctual"};
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "point"}, {"intensity", 2.0}, {"extras", 7}},
        {{"type", "spot"}, {"intensity", 3.0}, {"spot", {{"outerConeAngle", 0.5}}}}};
    const auto place = [](int light) {
        return Json{{"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}};
    };
    for (const int light : {0, 0, 1, 1}) document.AddNode(place(light));
    const fs::path source = from.Write("scene.gltf", document.Text());
    scene::SceneData edited = scene::LoadGltf(source);
    ASSERT_EQ(edited.lights.size(), 4u);
    edited.lights[1].intensity = 5.0f;                                      // shared by two nodes
    edited.lights[2].color = edited.lights[3].color = {1.0f, 0.5f, 0.25f};  // both
    edited.lights[2].outerConeAngle = edited.lights[3].outerConeAngle = 0.7f;
    const scene::SceneData saved = Save(source, edited, Target("lights.gltf"));
    ASSERT_EQ(saved.lights.size(), 4u);
    for (const scene::Light& light : edited.lights) {
        const auto same = std::ranges::find_if(
            saved.lights, [&](const scene::Light& other) { return other.node == light.node; });
        ASSERT_NE(same, saved.lights.end());
        EXPECT_EQ(same->intensity, light.intensity);
        EXPECT_EQ(same->color, light.color);
        EXPECT_EQ(same->outerConeAngle, light.outerConeAngle);
    }
    const Json lights = JsonOf(Target("lights.gltf"))["extensions"]["KHR_lights_punctual"]["lights"];
    ASSERT_EQ(lights.size(), 3u) << "the spot stays one";
    EXPECT_EQ(lights[2]["extras"], 7);
}

TEST_F(SaveGltf, SecondSaveAfterASplitPutsEachLightsValuesOnItsOwnNode) {
    GltfDocument document;
    document.json["extensionsUsed"] = {"KHR_lights_punctual"};
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 2.0}},
                                                                    {{"type", "point"}, {"intensity", 3.0}}};
    for (const int light : {0, 0, 1})
        document.AddNode({{"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
    const fs::path source = from.Write("scene.gltf", document.Text());
    scene::SceneData edited = scene::LoadGltf(source);
    edited.lights[0].intensity = 5.0f;
    const auto expectByNode = [&](const scene::SceneData& saved) {
        ASSERT_EQ(saved.lights.size(), 3u);
        for (const scene::Light& light : saved.lights) {
            const float wanted[] = {edited.lights[0].intensity, edited.lights[1].intensity,
                                    edited.lights[2].intensity};
            EXPECT_EQ(light.intensity, wanted[light.node]) << "node " << light.node;
        }
    };
    expectByNode(Save(source, edited, Target("once.gltf")));
    expectByNode(Save(Target("once.gltf"), edited, Target("twice.gltf")));
    EXPECT_EQ(TextOf(Target("once.gltf")), TextOf(Target("twice.gltf")));
    edited.lights[2].intensity = 7.0f;
    expectByNode(Save(Target("twice.gltf"), edited, Target("twice.gltf")));
    edited.lights[1].node = 2;
    EXPECT_NE(Failure(source, edited, Target("other.gltf")).find("nodes[1] has a light in the file"),
              std::string::npos);
}

TEST_F(SaveGltf, ExtrasThatAreNoObjectStayAndTakeNoPriority) {
    GltfDocument document;
    document.AddTriangle();
    document.json["materials"] = {{{"extras", "a text"}}};
    document.json["meshes"][0]["primitives"][0]["material"] = 0;
    const fs::path source = from.Write("scene.gltf", document.Text());
    scene::SceneData edited = scene::LoadGltf(source);
    edited.materials[0].metallicFactor = 0.25f;
    ExpectSame(edited, Save(source, edited, Target("saved.gltf")));
    EXPECT_EQ(JsonOf(Target("saved.gltf"))["materials"][0]["extras"], "a text");
    edited.materials[0].priority = 3;
    EXPECT_NE(Failure(source, edited, Target("saved.gltf")).find("extras"), std::string::npos);
}

TEST_F(SaveGltf, BinaryFilesKeepTheirChunksAndChangeTheirKind) {
    GltfDocument document;
    document.AddTriangle();
    // Makes the first buffer the BIN chunk
    const Bytes binary = BytesOf(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0});
    Bytes padded = binary;
    document.json["buffers"][0] = {{"byteLength", binary.size()}};
    const fs::path source = from.Write("scene.glb", MakeGlb(document.Text(), &padded));
    scene::SceneData edited = scene::LoadGltf(source);
    edited.nodes[0].matrix = glm::mat4x3(glm::translate(glm::mat4(1.0f), glm::vec3(1, 2, 3)));
    scene::UpdateWorldTransforms(edited);
    ExpectSame(edited, Save(source, edited, Target("saved.glb")));
    ExpectSame(edited, Save(source, edited, Target("as text.gltf")));
    EXPECT_EQ(JsonOf(Target("as text.gltf"))["buffers"][0]["uri"], "as%20text.bin");
    EXPECT_EQ(fs::file_size(Target("as text.bin")), binary.size());
    ExpectSame(edited, Save(Target("as text.gltf"), edited, Target("back.glb")));
    EXPECT_NE(Failure(source, edited, Target("scene.obj")).find(".gltf or .glb"), std::string::npos);
}

TEST_F(SaveGltf, ChunkThatNoBufferIsMadeOfLeavesNothingBehind) {
    const Bytes binary(8);
    const fs::path source = from.Write("scene.glb", MakeGlb(R"({"asset":{"version":"2.0"}})", &binary));
    Save(source, scene::LoadGltf(source), Target("saved.gltf"));
    EXPECT_FALSE(JsonOf(Target("saved.gltf")).contains("buffers"));
}

TEST_F(SaveGltf, BareNamesAreOfTheCurrentFolder) {
    GltfDocument document;
    document.AddTriangle();
    const Bytes binary = BytesOf(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0});
    document.json["buffers"][0] = {{"byteLength", binary.size()}};
    const fs::path source = from.Write("scene.glb", MakeGlb(document.Text(), &binary));
    const scene::SceneData scene = scene::LoadGltf(source);
    const fs::path before = fs::current_path();
    fs::current_path(folder.Path());
    const std::string failure = Failure(source, scene, "bare.gltf");
    const std::string again = Failure("bare.gltf", scene, "again.gltf");
    fs::current_path(before);
    EXPECT_EQ(failure, "saved");
    EXPECT_EQ(again, "saved");
    EXPECT_TRUE(fs::exists(Target("bare.bin")));
    ExpectSame(scene, scene::LoadGltf(Target("again.gltf")));
}

TEST_F(SaveGltf, SceneCannotHaveFilesOfItsChoiceMade) {
    GltfDocument document;
    document.AddTriangle();
    document.json["images"] = {{{"uri", "script.sh"}}, {{"uri", "unread.png"}}};
    from.Write("script.sh", "#!/bin/sh");
    from.Write("unread.png", MakePng(2, 2, {255, 0, 0, 255}));
    fs::path source = from.Write("scene.gltf", document.Text());
    const scene::SceneData scene = scene::LoadGltf(source);
    ExpectSame(scene, Save(source, scene, Target("saved.gltf")));
    EXPECT_FALSE(fs::exists(Target("script.sh"))) << "is no image";
    EXPECT_TRUE(fs::exists(Target("unread.png")));
    fs::create_directories(from.Path() / ".config");
    for (const char* hidden : {".profile", "%2Eprofile", ".config/start"}) {
        from.Write(hidden[0] == '%' ? ".profile" : hidden, "data");
        document.json["buffers"][0] = {{"uri", hidden}, {"byteLength", 4}};
        document.json.erase("meshes");
        document.json.erase("accessors");
        document.json.erase("bufferViews");
        document.json["nodes"] = {{{"name", "empty"}}};
        source = from.Write("hidden.gltf", document.Text());
        const scene::SceneData empty = scene::LoadGltf(source);
        EXPECT_NE(Failure(source, empty, Target("hidden.gltf")).find("hidden file"), std::string::npos);
        EXPECT_FALSE(fs::exists(Target("hidden.gltf")));
    }
    EXPECT_FALSE(fs::exists(Target(".profile")));
    EXPECT_FALSE(fs::exists(Target(".config")));
}

TEST_F(SaveGltf, LinkInTheWayIsAnErrorOfOneLine) {
    GltfDocument document;
    document.AddTriangle();
    document.json["images"] = {{{"uri", "map.png"}}};
    from.Write("map.png", MakePng(2, 2, {255, 0, 0, 255}));
    const fs::path source = from.Write("scene.gltf", document.Text());
    const scene::SceneData scene = scene::LoadGltf(source);
    fs::create_symlink("map.png", Target("map.png"));  // leads to itself
    EXPECT_NE(Failure(source, scene, Target("saved.gltf")).find("map.png"), std::string::npos);
}

TEST_F(SaveGltf, FilesOfTheSceneComeAlongAndNoneIsReplaced) {
    GltfDocument document;
    document.AddTriangle();
    document.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
    document.json["meshes"][0]["primitives"][0]["material"] = 0;
    document.json["textures"] = {{{"source", 0}}};
    document.json["images"] = {{{"uri", "maps/red%20one.png"}}, {{"uri", "unused-and-missing.png"}}};
    fs::create_directories(from.Path() / "maps");
    from.Write("maps/red one.png", MakePng(2, 2, {255, 0, 0, 255}));
    const fs::path source = from.Write("scene.gltf", document.Text());
    const scene::SceneData scene = scene::LoadGltf(source);
    ExpectSame(scene, Save(source, scene, Target("saved.gltf")));
    EXPECT_TRUE(fs::exists(Target("maps/red one.png")));
    ExpectSame(scene, Save(source, scene, Target("saved.gltf")));  // the existing values stay the same
    std::ofstream(Target("maps/red one.png")) << "another";
    std::ofstream(Target("saved.gltf")) << "old";
    EXPECT_NE(Failure(source, scene, Target("saved.gltf")).find("red one.png: is there already"),
              std::string::npos);
    EXPECT_EQ(TextOf(Target("maps/red one.png")), "another");
    EXPECT_EQ(TextOf(Target("saved.gltf")), "old") << "the scene comes last";
}

TEST_F(SaveGltf, FailuresAreOneLineAndLeaveWhatIsThere) {
    GltfDocument document;
    document.AddTriangle();
    const fs::path source = from.Write("scene.gltf", document.Text());
    scene::SceneData scene = scene::LoadGltf(source);
    EXPECT_NE(Failure(source, scene, Target("no/such/folder/scene.gltf")).find("scene.gltf"),
              std::string::npos);
    EXPECT_NE(Failure(from.Path() / "gone.gltf", scene, Target("a.gltf")).find("gone.gltf"),
              std::string::npos);
    scene::SceneData other = scene;
    other.nodes.emplace_back();
    EXPECT_NE(Failure(source, other, Target("a.gltf")).find("has 1 nodes, the scene 2"), std::string::npos);
    for (const scene::TextureRef& map : {scene::TextureRef{.texture = 0}, scene::TextureRef{.texCoord = 1}}) {
        other = scene;
        other.materials[0].baseColorTexture = map;
        EXPECT_NE(Failure(source, other, Target("a.gltf")).find("cannot be exchanged"), std::string::npos);
    }
    EXPECT_FALSE(fs::exists(Target("a.gltf")));
}

}  // namespace raygraph::test::save_gltf_test
