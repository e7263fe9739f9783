// EXT_lights_ies: point lights with measured profiles.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "renderer/scene/gltf/save_gltf.h"
#include "renderer/scene/model/check.h"
#include "tests/scene/gltf_document.h"
#include "tests/scene/same_scene.h"
#include "tests/support/ies_text.h"

namespace raygraph::test::import_ies_test {
namespace {

using glm::vec3;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Two nodes with a profile, and one below the second that has the first one, too.
GltfDocument WithProfiles(const Json& first, const Json& second) {
    GltfDocument document;
    document.json["extensionsUsed"] = {"EXT_lights_ies"};
    document.json["extensions"]["EXT_lights_ies"]["lights"] = Json::array({first, second});
    const auto node = [&](const char* name, const Json& light) {
        document.AddNode({{"name", name}, {"extensions", {{"EXT_lights_ies", light}}}});
    };
    node("a", {{"light", 1}});
    node("b", {{"light", 0}, {"multiplier", 2.5}, {"color", {1, 0.5, 0.25}}});
    node("c", {{"light", 1}, {"multiplier", 0}});
    return document;
}

Json UriOf(const IesText& file) {
    return {{"uri", DataUri(ToBytes(file.Text()))}};
}

IesText Constant(double candela) {
    return {.candela = [=](double, double) { return candela; }};
}

TEST(IesLights, ProfilesAreReadOfUrisAndBufferViewsAndLightsPlaced) {
    SceneFolder folder;
    folder.Write("lamp.ies", Constant(7).Text());
    GltfDocument document = WithProfiles({{"uri", "lamp.ies"}}, Json::object());
    Json& second = document.json["extensions"]["EXT_lights_ies"]["lights"][1];
    second = {{"name", "panel"}, {"mimeType", "application/x-ies-lm-63"}};
    second["bufferView"] = document.AddBufferView(ToBytes(Constant(9).Text()));
    document.json["extensions"]["KHR_lights_punctual"]["lights"] =
        Json::array({{{"type", "spot"}, {"spot", Json::object()}}});
    document.json["nodes"][2]["extensions"]["KHR_lights_punctual"]["light"] = 0;
    document.json["nodes"][1]["translation"] = {1, 2, 3};
    const scene::SceneData scene = folder.Load(document);
    EXPECT_THAT(scene.warnings, ElementsAre());
    ASSERT_EQ(scene.profiles.size(), 2u);
    EXPECT_EQ(scene.profiles[0].MaxIntensity(), 7.0f);
    EXPECT_EQ(scene.profiles[1].MaxIntensity(), 9.0f);
    EXPECT_EQ(scene.profiles[1].name, "panel");
    // Punctual ones first, then by profile
    ASSERT_EQ(scene.lights.size(), 4u);
    EXPECT_EQ(scene.lights[0].type, scene::LightType::Spot);
    EXPECT_EQ(scene.lights[0].profile, scene::kNone);
    EXPECT_EQ(scene.lights[0].node, 2u);
    const scene::Light& b = scene.lights[1];
    EXPECT_EQ(b.name, "b");
    EXPECT_EQ(b.node, 1u);
    EXPECT_EQ(b.type, scene::LightType::Point);
    EXPECT_EQ(b.profile, 0u);
    EXPECT_EQ(b.intensity, 2.5f);
    EXPECT_EQ(b.color, vec3(1, 0.5f, 0.25f));
    EXPECT_EQ(b.lightToWorld[3], vec3(1, 2, 3));
    EXPECT_EQ(scene.lights[2].node, 0u);
    EXPECT_EQ(scene.lights[2].name, "panel");
    EXPECT_EQ(scene.lights[2].intensity, 1.0f);
    EXPECT_EQ(scene.lights[2].color, vec3(1.0f));
    EXPECT_EQ(scene.lights[3].node, 2u);
    EXPECT_EQ(scene.lights[3].intensity, 0.0f);
    EXPECT_EQ(scene.lights[3].profile, 1u);
}

TEST(IesLights, OnlyProfilesOfPlacedNodesAreOpened) {
    GltfDocument document = WithProfiles({{"uri", "missing.ies"}}, UriOf(Constant(1)));
    document.Add("scenes", {{"nodes", {0}}});
    document.json["scene"] = 1;
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.profiles.size(), 1u);
    EXPECT_EQ(scene.lights.at(0).profile, 0u);
    document.json["scene"] = 0;
    EXPECT_THAT(LoadError(document),
                HasSubstr("scene.gltf: extensions.EXT_lights_ies.lights[0].uri: \"missing.ies\": "));
}

TEST(IesLights, MalformedOnesAreRefused) {
    const GltfDocument document = WithProfiles(UriOf(Constant(1)), UriOf(Constant(2)));
    const Json bad = UriOf({.type = 7});
    ExpectRefused(
        document,
        {{"/extensions/EXT_lights_ies/lights/0", bad,
          "extensions.EXT_lights_ies.lights[0].uri: line 5: the photometric type is 7, must be 1, 2 or 3"},
         {"/extensions/EXT_lights_ies/lights/0", Json::object(),
          "extensions.EXT_lights_ies.lights[0]: must have either a uri or a bufferView"},
         {"/extensions/EXT_lights_ies/lights/0/bufferView", 0,
          "extensions.EXT_lights_ies.lights[0].bufferView: is 0, but there are 0 bufferViews"},
         {"/extensions/EXT_lights_ies/lights/0/mimeType", "text/plain",
          "extensions.EXT_lights_ies.lights[0].mimeType: is \"text/plain\", must be application/x-ies-lm-63"},
         {"/nodes/1/extensions/EXT_lights_ies/light", 2,
          "nodes[1].extensions.EXT_lights_ies.light: is 2, but there are 2 lights"},
         {"/nodes/1/extensions/EXT_lights_ies/light", nullptr,
          "nodes[1].extensions.EXT_lights_ies.light: is null, must be a whole number of at least 0"},
         {"/nodes/1/extensions/EXT_lights_ies/multiplier", "x",
          "nodes[1].extensions.EXT_lights_ies.multiplier: is \"x\", must be a number"},
         {"/nodes/1/extensions/EXT_lights_ies/color",
          {1, 1},
          "nodes[1].extensions.EXT_lights_ies.color: has 2 elements, must have 3"}});
}

TEST(IesLights, NumbersOutOfRangeArePutIntoIt) {
    GltfDocument document = WithProfiles(UriOf(Constant(1)), UriOf(Constant(2)));
    document.json["nodes"][1]["extensions"]["EXT_lights_ies"]["color"] = {2, -1, 0.5};
    document.json["nodes"][1]["extensions"]["EXT_lights_ies"]["multiplier"] = -3;
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.lights.at(0).color, vec3(1, 0, 0.5f));
    EXPECT_EQ(scene.lights.at(0).intensity, 0.0f);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_THAT(scene.warnings[0], HasSubstr("(and 2 more)"));
}

TEST(IesLights, RepairsAreSaid) {
    const GltfDocument document = WithProfiles(UriOf(Constant(-1)), UriOf(Constant(2)));
    EXPECT_THAT(
        Load(document).warnings,
        ElementsAre("scene.gltf: extensions.EXT_lights_ies.lights[0].uri: 2 candela values are negative, "
                    "taken as 0"));
}

TEST(IesLights, EditsAreSavedAndFilesCopied) {
    SceneFolder from;
    from.Write("lamp.ies", Constant(7).Text());
    from.Write("unused.ies", Constant(3).Text());
    GltfDocument document = WithProfiles({{"uri", "lamp.ies"}}, UriOf(Constant(9)));
    document.json["extensions"]["EXT_lights_ies"]["lights"].push_back({{"uri", "unused.ies"}});
    document.json["extensionsUsed"].push_back("KHR_lights_punctual");
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({{{"type", "point"}}});
    document.json["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 0;
    const std::filesystem::path source = from.Write("scene.gltf", document.Text());
    scene::SceneData edited = scene::LoadGltf(source);
    ASSERT_EQ(edited.lights.size(), 4u);
    edited.lights[0].intensity = 11.0f;  // the punctual one of the same node
    edited.lights[1].intensity = 4.0f;
    edited.lights[2].color = {0.5f, 0.5f, 0.25f};
    edited.lights[3].color = {2.0f, 1.0f, 0.0f};  // beyond what the file may say
    edited.lights[3].intensity = 3.0f;
    const TemporaryFolder to;
    scene::SaveGltf(source, edited, to.Path() / "saved.gltf");
    const scene::SceneData saved = scene::LoadGltf(to.Path() / "saved.gltf");
    ASSERT_EQ(saved.lights.size(), 4u);
    for (size_t i = 0; i < 3; ++i) EXPECT_TRUE(saved.lights[i] == edited.lights[i]) << i;
    EXPECT_EQ(saved.lights[3].color, vec3(1.0f, 0.5f, 0.0f));
    EXPECT_EQ(saved.lights[3].intensity, 6.0f);
    EXPECT_TRUE(saved.profiles == edited.profiles);
    EXPECT_TRUE(std::filesystem::exists(to.Path() / "unused.ies"));
    const Json json = Json::parse(std::ifstream(to.Path() / "saved.gltf"));
    EXPECT_EQ(json["nodes"][1]["extensions"]["EXT_lights_ies"]["color"], Json({1, 0.5, 0.25})) << "as it was";
    EXPECT_FALSE(json["nodes"][0]["extensions"]["EXT_lights_ies"].contains("multiplier"));
    // Saving without edits changes nothing
    scene::SaveGltf(source, scene::LoadGltf(source), to.Path() / "again.gltf");
    EXPECT_EQ(Json::parse(std::ifstream(to.Path() / "again.gltf")), document.json);
    std::filesystem::remove(from.Path() / "lamp.ies");
    EXPECT_THROW(scene::SaveGltf(source, edited, to.Path() / "third/saved.gltf"), Error);
}

TEST(IesLights, CheckRefusesProfilesThatNoFileHas) {
    const auto refusal = [](auto&& change) {
        scene::SceneData scene = Load(WithProfiles(UriOf(Constant(1)), UriOf(Constant(2))));
        change(scene);
        try {
            scene::Check(scene, "it");
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    using scene::SceneData;
    EXPECT_EQ(refusal([](SceneData&) {}), "accepted");
    EXPECT_EQ(refusal([](SceneData& s) { s.lights[1].profile = 2; }),
              "it: lights[1]: profile is 2, there are 2");
    EXPECT_EQ(refusal([](SceneData& s) { s.lights[1].type = scene::LightType::Spot; }),
              "it: lights[1]: it has a profile, and is no point light");
    EXPECT_EQ(refusal([](SceneData& s) { s.profiles[0].candela.pop_back(); }),
              "it: profiles[0]: 1 intensities of 1 x 2 angles");
    EXPECT_EQ(refusal([](SceneData& s) { s.profiles[0].vertical[1] = 0.0f; }),
              "it: profiles[0]: its angles must be finite and increase");
    EXPECT_EQ(refusal([](SceneData& s) { s.profiles[0].vertical[1] = 4.0f; }),
              "it: profiles[0]: its vertical angles are out of range");
    EXPECT_EQ(refusal([](SceneData& s) { s.profiles[0].vertical.resize(1); }),
              "it: profiles[0]: it has too few angles");
    EXPECT_EQ(refusal([](SceneData& s) { s.profiles[1].candela[0] = -1.0f; }),
              "it: profiles[1]: an intensity is -1, must be finite and at least 0");
    EXPECT_EQ(refusal([](SceneData& s) {
                  s.profiles[1].horizontal = {0.0f, 3.0f};
                  s.profiles[1].candela.resize(4);
              }),
              "it: profiles[1]: its horizontal angles must be a turn");
}

}  // namespace
}  // namespace raygraph::test::import_ies_test
