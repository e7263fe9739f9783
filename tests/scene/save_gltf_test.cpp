// Saved scenes, and scenes at one time.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <glm/gtc/matrix_transform.hpp>
#include <sstream>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "renderer/scene/gltf/still_scene.h"
#include "renderer/scene/model/check.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"
#include "tests/support/reference_assets.h"
#include "tests/support/source_file.h"

// Files saved again: what was edited is there, and everything else as it was.
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
    const scene::FloatPair far = scene::ToFloatPair({10'000.5003, -6e6 + 0.125, 3.0});
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

// A scene at one time: which clips a list names, and what freezing makes of nodes, skins and targets.
namespace raygraph::test::still_scene_test {
namespace {

using glm::vec3;
using scene::ClipState;
using scene::kNone;
using scene::SceneData;
using testing::ErrorOf;

SceneData WithAnimations(const std::vector<std::string>& names) {
    SceneData scene;
    for (const std::string& name : names) scene.animations.emplace_back().name = name;
    return scene;
}

TEST(FindClips, NamesIndicesAndWeights) {
    const SceneData scene = WithAnimations({"walk", "run", "1", "look: left", "run", ""});
    const auto find = [&](std::string_view list) { return scene::FindClips(scene, list, 2.5); };
    using Clips = std::vector<ClipState>;
    EXPECT_EQ(find(""), (Clips{{0, 2.5, 1.0f}}));
    EXPECT_EQ(find("run"), (Clips{{1, 2.5, 1.0f}})) << "the first of that name";
    EXPECT_EQ(find("4"), (Clips{{4, 2.5, 1.0f}}));
    EXPECT_EQ(find("1"), (Clips{{2, 2.5, 1.0f}})) << "a name comes before an index";
    EXPECT_EQ(find("walk:0.25,3:2"), (Clips{{0, 2.5, 0.25f}, {3, 2.5, 2.0f}}));
    EXPECT_EQ(find("look: left"), (Clips{{3, 2.5, 1.0f}})) << "a colon of its name";
    EXPECT_EQ(find("look: left:0.5"), (Clips{{3, 2.5, 0.5f}}));
    EXPECT_EQ(find("all").size(), 6u);
    EXPECT_EQ(find("all")[5], (ClipState{5, 2.5, 1.0f}));
    EXPECT_TRUE(scene::FindClips(SceneData(), "", 1.0).empty());
}

TEST(FindClips, ReadsTheTextOfItsClips) {
    const SceneData scene = WithAnimations({"walk", "run", "run", "a, b", "all", "half:0.5", ""});
    const auto text = [&](const std::vector<ClipState>& clips) { return scene::ClipsText(scene, clips); };
    EXPECT_EQ(text({{0}, {1, 0, 0.25f}}), "walk,run:0.25");
    EXPECT_EQ(text({{2}}), "2") << "another one has the name before it";
    EXPECT_EQ(text({{0, 0, 0}, {1}}), "run");
    EXPECT_EQ(text({}), "");
    std::vector<ClipState> all;
    for (uint32_t i = 0; i < 7; ++i) {
        const std::vector<ClipState> one{{i, 2.5}};
        EXPECT_EQ(scene::FindClips(scene, text(one), 2.5), one) << text(one);
        all.push_back({i, 2.5});
    }
    EXPECT_EQ(text(all), "all");
    all[1].weight = 0.1f;
    EXPECT_EQ(scene::FindClips(scene, text(all), 2.5), all) << text(all);
}

TEST(FindClips, WhatIsNotThereIsRefusedWithWhatIs) {
    const SceneData scene = WithAnimations({"walk", "run"});
    for (const std::string_view list : {"fly", "2", "-1", "walk,,run", "walk:much", ",walk"}) {
        const Error error = testing::ErrorOf([&] { scene::FindClips(scene, list, 0.0); });
        EXPECT_EQ(error.Kind(), ErrorKind::BadInput) << list;
        EXPECT_NE(std::string(error.what()).find("the scene has 0 \"walk\", 1 \"run\""), std::string::npos)
            << error.what();
    }
    EXPECT_EQ(std::string(testing::ErrorOf([&] { scene::FindClips(scene, "run:-1", 0.0); }).what()),
              "the weight of \"run:-1\" is not from 0 to 1e6");
    EXPECT_EQ(std::string(testing::ErrorOf([] { scene::FindClips(SceneData(), "walk", 0.0); }).what()),
              "there is no animation \"walk\"; the scene has none");
}

vec3 WorldPosition(const SceneData& scene, uint32_t instance, uint32_t vertex) {
    const scene::Instance& of = scene.instances[instance];
    return of.objectToWorld * glm::vec4(scene.meshes[of.mesh].primitives[0].positions[vertex], 1.0f);
}

TEST(FreezePose, SceneWithoutMotionStaysAsItIs) {
    GltfDocument document = SkinnedTriangle();
    document.json.erase("skins");
    document.json["nodes"][0].erase("skin");
    const SceneData before = Load(document);
    SceneData after = before;
    scene::FreezePose(after, {});
    ExpectSame(after, before);
}

TEST(FreezePose, SkinsCountInTheRestPoseAndAtATime) {
    GltfDocument document = SkinnedTriangle();
    document.json["nodes"][2]["translation"] = {1, 0, 2};
    Animate(document, {{"node", 2}, {"path", "translation"}}, {0, 1}, {1, 0, 2, 1, 0, 4}, 3);
    for (const bool isRest : {true, false}) {
        SceneData scene = Load(document);
        std::vector<ClipState> clips;
        if (!isRest) clips.push_back({.animation = 0, .seconds = 0.5});
        scene::FreezePose(scene, clips);
        EXPECT_NO_THROW(scene::Check(scene, "frozen"));
        const float z = isRest ? 2.0f : 3.0f;
        EXPECT_EQ(WorldPosition(scene, 0, 0), vec3(0, 0, 0));
        EXPECT_EQ(WorldPosition(scene, 0, 1), vec3(1, 0, z));
        EXPECT_EQ(WorldPosition(scene, 0, 2), vec3(0, 1, 0.5f * z));
        EXPECT_EQ(scene.bounds.max, vec3(1, 1, z));
        EXPECT_EQ(scene.nodes[2].translation, vec3(1, 0, z));
        EXPECT_TRUE(scene.skins.empty());
        EXPECT_TRUE(scene.animations.empty());
    }
}

// The mesh's node is rotated, scaled and 10,000 km away; the vertices stay where the joints put them, and
// then follow the node.
TEST(FreezePose, SkinnedMeshFollowsItsNodeFromThenOn) {
    GltfDocument document = SkinnedTriangle();
    document.json["nodes"][0]["translation"] = {1e7, 2, 3};
    document.json["nodes"][0]["rotation"] = {0.5, 0.5, 0.5, 0.5};
    document.json["nodes"][0]["scale"] = {2, 4, 8};
    SceneData scene = Load(document);
    scene::FreezePose(scene, {});
    scene::UpdateWorldTransforms(scene);
    EXPECT_LT(glm::distance(WorldPosition(scene, 0, 2), vec3(0, 1, 0)), 2.0f) << "a float's step there";
    scene.nodes[0].translation = {2, 2, 3};
    scene::UpdateWorldTransforms(scene);
    const vec3 moved = WorldPosition(scene, 0, 1) - WorldPosition(scene, 0, 0);
    EXPECT_LT(glm::distance(moved, vec3(1, 0, 0)), 1e-5f);
}

// A triangle with a target that lifts it by 1 m, three times 10 m apart: with weights .5, .5 and 2.
SceneData Lifted() {
    SceneData scene;
    scene.nodes.resize(3);
    scene::Primitive triangle;
    triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    triangle.normals.assign(3, {0, 0, 1});
    triangle.indices = {0, 1, 2};
    triangle.bounds = scene::BoundsOf(triangle.positions);
    triangle.targets.resize(1);
    triangle.targets[0].positions.assign(3, {0, 0, 1});
    scene::UpdateDeformationBounds(triangle);
    scene.meshes.push_back({.name = "lifted", .primitives = {triangle}, .weights = {0.5f}});
    scene.materials.resize(1);
    for (uint32_t i = 0; i < 3; ++i) {
        scene.nodes[i].translation.x = 10.0f * float(i);
        scene.nodes[i].mesh = 0;
        scene.nodeOrder.push_back(i);
        scene.instances.push_back({.mesh = 0, .node = i});
    }
    scene.nodes[2].weights = {2.0f};
    scene::UpdateWorldTransforms(scene);
    return scene;
}

TEST(FreezePose, InstancesOfOneShapeShareItsMesh) {
    SceneData scene = Lifted();
    scene::FreezePose(scene, {});
    EXPECT_NO_THROW(scene::Check(scene, "frozen"));
    ASSERT_EQ(scene.meshes.size(), 2u);
    EXPECT_EQ(scene.instances[0].mesh, 0u);
    EXPECT_EQ(scene.instances[1].mesh, 0u);
    EXPECT_EQ(scene.instances[2].mesh, 1u);
    EXPECT_EQ(scene.meshes[1].name, "lifted");
    EXPECT_EQ(WorldPosition(scene, 1, 0), vec3(10, 0, 0.5f));
    EXPECT_EQ(WorldPosition(scene, 2, 0), vec3(20, 0, 2));
    EXPECT_EQ(scene.meshes[1].primitives[0].bounds.max, vec3(1, 1, 2));
    EXPECT_EQ(scene.bounds.min, vec3(0, 0, 0.5f));
    EXPECT_EQ(scene.bounds.max, vec3(21, 1, 2));
    for (const scene::Mesh& mesh : scene.meshes) EXPECT_TRUE(mesh.primitives[0].targets.empty());
}

// A mesh with joints that one instance has no skin for is as it was there.
TEST(FreezePose, InstanceWithoutASkinKeepsTheBaseShape) {
    GltfDocument document = SkinnedTriangle();
    document.json["nodes"][2]["translation"] = {1, 0, 2};
    document.json["nodes"].push_back({{"mesh", 0}, {"translation", {0, 5, 0}}});
    document.json["scenes"][0]["nodes"].push_back(document.json["nodes"].size() - 1);
    SceneData scene = Load(document);
    ASSERT_EQ(scene.instances.size(), 2u);
    scene::FreezePose(scene, {});
    EXPECT_NO_THROW(scene::Check(scene, "frozen"));
    const uint32_t plain = scene.instances[0].node == 0 ? 1 : 0;
    EXPECT_EQ(WorldPosition(scene, plain, 1), vec3(1, 5, 0));
    EXPECT_EQ(WorldPosition(scene, 1 - plain, 1), vec3(1, 0, 2));
}

TEST(FreezePose, InstancesOfOneMeshWithOtherSkins_AreBentByTheirOwn) {
    GltfDocument document = SkinnedTriangle();
    Json skin = document.json["skins"][0];
    skin["joints"] = {1, 3};
    document.Add("skins", std::move(skin));
    document.AddNode({{"translation", {1, 0, 4}}});
    document.AddNode({{"mesh", 0}, {"skin", 1}});
    document.json["nodes"][2]["translation"] = {1, 0, 2};
    SceneData scene = Load(document);
    scene::FreezePose(scene, {});
    ASSERT_EQ(scene.meshes.size(), 2u);
    for (const uint32_t i : {0u, 1u})
        EXPECT_EQ(WorldPosition(scene, i, 1), vec3(1, 0, scene.instances[i].node == 0 ? 2 : 4));
}

TEST(FreezePose, CopiesOfMeshesAreLimited) {
    SceneData scene = Lifted();
    const uint64_t streams = 3 * (2 * sizeof(vec3) + sizeof(uint32_t));
    const uint64_t copy = sizeof(scene::Mesh) + sizeof(scene::Primitive) + streams;
    EXPECT_EQ(testing::ErrorTextOf([&] { scene::FreezePose(scene, {}, copy - 1); }, ErrorKind::BadInput),
              "meshes[0] \"lifted\": deformed copies of meshes take more than " + std::to_string(copy - 1) +
                  " bytes");
    scene = Lifted();
    scene::FreezePose(scene, {}, copy);
    EXPECT_EQ(scene.meshes.size(), 2u);
}

// A host's mesh may have spheres beside what is morphed.
TEST(FreezePose, WhatNothingDeformsKeepsItsBox) {
    SceneData scene = Lifted();
    scene::Primitive sphere;
    sphere.positions = {{0, 0, 0}};
    sphere.indices = {0, 0};
    sphere.radii = {2};
    sphere.bounds = {vec3(-2.5f), vec3(2.5f)};
    scene.meshes[0].primitives.push_back(sphere);
    scene::Check(scene, "before");
    scene::FreezePose(scene, {});
    EXPECT_NO_THROW(scene::Check(scene, "frozen"));
    for (const scene::Mesh& mesh : scene.meshes) {
        EXPECT_EQ(mesh.primitives[1].bounds.max, vec3(2.5f));
        EXPECT_EQ(mesh.primitives[1].positions, sphere.positions);
    }
}

TEST(FreezePose, CollapsedInstancesAreLeftOut) {
    GltfDocument document;
    document.AddTriangle();
    Animate(document, {{"node", 0}, {"path", "scale"}}, {0, 1}, {0, 0, 0, 2, 2, 2}, 3);
    for (const double seconds : {0.0, 1.0}) {
        SceneData scene = Load(document);
        scene::FreezePose(scene, std::array{ClipState{0, seconds}});
        EXPECT_NO_THROW(scene::Check(scene, "frozen"));
        EXPECT_EQ(scene.instances.size(), seconds > 0.0 ? 1u : 0u);
    }
}

// The node is flat, so that the mesh cannot follow it, and hidden: without the node it would be seen.
TEST(FreezePose, HiddenInstancesOfFlatNodesStayUnseen) {
    GltfDocument document = SkinnedTriangle();
    document.json["nodes"][0]["scale"] = {1, 0, 1};
    SceneData scene = Load(document);
    ASSERT_EQ(scene.instances.size(), 1u);
    scene.nodes[0].isVisible = false;
    SceneData shown = scene;
    scene::FreezePose(scene, {});
    EXPECT_TRUE(scene.instances.empty());
    shown.nodes[0].isVisible = true;
    scene::FreezePose(shown, {});
    ASSERT_EQ(shown.instances.size(), 1u);
    EXPECT_EQ(shown.instances[0].node, kNone);
}

TEST(FreezePose, VerticesThatAreNotFiniteAreNotShown) {
    SceneData scene = Lifted();
    scene.nodes[2].weights = {3e38f};
    scene.meshes[0].primitives[0].targets[0].positions.assign(3, {0, 0, 10});
    scene::UpdateDeformationBounds(scene.meshes[0].primitives[0]);
    scene::FreezePose(scene, {});
    EXPECT_NO_THROW(scene::Check(scene, "frozen"));
    EXPECT_EQ(scene.instances.size(), 2u);
}

}  // namespace
}  // namespace raygraph::test::still_scene_test
