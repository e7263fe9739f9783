// Cameras and lights: punctual lights, their profiles and their fields.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/scene/formats/ies_file.h"
#include "renderer/scene/gltf/choice_names.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "renderer/scene/model/camera_view.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"
#include "tests/support/ies_text.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::test::import_camera_light_test {
namespace {

using glm::vec3;
using ::testing::ElementsAre;

// A document with one camera on one node.
GltfDocument WithCamera(const Json& camera) {
    GltfDocument document;
    document.Add("cameras", camera);
    document.AddNode({{"camera", 0}, {"name", "stand"}, {"translation", {1, 2, 3}}});
    return document;
}

GltfDocument WithLight(const Json& light) {
    GltfDocument document;
    document.json["extensionsUsed"] = {"KHR_lights_punctual"};
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({light});
    document.AddNode({{"name", "pole"},
                      {"translation", {1, 2, 3}},
                      {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    return document;
}

TEST(Cameras, PerspectiveIsRead) {
    const scene::SceneData scene = Load(
        WithCamera({{"name", "eye"},
                    {"type", "perspective"},
                    {"perspective", {{"yfov", 0.5}, {"znear", 0.25}, {"zfar", 100}, {"aspectRatio", 1.5}}}}));
    ASSERT_EQ(scene.cameras.size(), 1u);
    const scene::Camera& camera = scene.cameras[0];
    EXPECT_EQ(camera.name, "eye");
    EXPECT_EQ(camera.node, 0u);
    EXPECT_EQ(camera.projection, scene::Projection::Perspective);
    EXPECT_EQ(camera.yFov, 0.5f);
    EXPECT_EQ(camera.zNear, 0.25f);
    EXPECT_EQ(camera.zFar, 100.0f);
    EXPECT_EQ(camera.aspectRatio, 1.5f);
    EXPECT_EQ(camera.cameraToWorld[3], vec3(1, 2, 3));
}

TEST(Cameras, OptionalPropertiesMayBeMissing) {
    const scene::SceneData scene =
        Load(WithCamera({{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.25}}}}));
    EXPECT_EQ(scene.cameras[0].name, "stand") << "the node's name where the camera has none";
    EXPECT_EQ(scene.cameras[0].zFar, 0.0f);
    EXPECT_EQ(scene.cameras[0].aspectRatio, 0.0f);
}

TEST(Cameras, OrthographicIsRead) {
    const scene::SceneData scene = Load(WithCamera(
        {{"type", "orthographic"}, {"orthographic", {{"xmag", 2}, {"ymag", 3}, {"znear", 0}, {"zfar", 9}}}}));
    EXPECT_EQ(scene.cameras[0].projection, scene::Projection::Orthographic);
    EXPECT_EQ(scene.cameras[0].xMag, 2.0f);
    EXPECT_EQ(scene.cameras[0].yMag, 3.0f);
    EXPECT_EQ(scene.cameras[0].zFar, 9.0f);
}

TEST(Cameras, AreListedByIndexOncePerPlace) {
    GltfDocument document =
        WithCamera({{"name", "a"}, {"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}});
    document.Add("cameras",
                 {{"name", "b"}, {"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}});
    document.json["nodes"][0]["camera"] = 1;
    document.AddNode({{"camera", 0}});
    document.AddNode({{"camera", 1}});
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.cameras.size(), 3u);
    EXPECT_EQ(scene.cameras[0].name, "a");
    EXPECT_EQ(scene.cameras[0].node, 1u);
    EXPECT_EQ(scene.cameras[1].node, 0u);
    EXPECT_EQ(scene.cameras[2].node, 2u);
}

TEST(Cameras, MalformedOnesAreRefused) {
    ExpectRefused(
        WithCamera({{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}),
        {{"/cameras/0/perspective",
          {{"znear", 1}},
          "cameras[0].perspective.yfov: is absent, must be a number"},
         {"/cameras/0/perspective/yfov", 0, "cameras[0].perspective.yfov: is 0, must be above 0"},
         {"/cameras/0/perspective/yfov", 4, "cameras[0].perspective.yfov: is 4, must be below pi"},
         {"/cameras/0/perspective/znear", 0, "cameras[0].perspective.znear: is 0, must be above 0"},
         {"/cameras/0/perspective", nullptr, "cameras[0].perspective: is null, must be an object"},
         {"/cameras/0/type", "fisheye",
          "cameras[0].type: is \"fisheye\", must be perspective or orthographic"},
         {"/cameras/0",
          {{"type", "orthographic"}, {"orthographic", {{"xmag", 0}, {"ymag", 1}, {"znear", 0}, {"zfar", 1}}}},
          "cameras[0].orthographic.xmag: is 0, must not be"},
         {"/cameras/0",
          {{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 2}, {"zfar", 1}}}},
          "cameras[0]: zfar (1.000000) must be greater than znear (2.000000)"}});
}

TEST(Cameras, FarPlaneOfAPerspectiveViewMayBeWrongBecauseNoneIsUsed) {
    const auto warnings = [](const Json& zFar) {
        const scene::SceneData scene = Load(WithCamera(
            {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}, {"zfar", zFar}}}}));
        EXPECT_EQ(scene.cameras.at(0).zFar, 0.0f);
        return scene.warnings;
    };
    EXPECT_THAT(warnings(0.5),
                ElementsAre("scene.gltf: cameras[0]: zfar (0.500000) must be greater than znear "
                            "(1.000000), taken as infinite, as in all perspective views"));
    EXPECT_THAT(warnings(0),
                ElementsAre("scene.gltf: cameras[0].perspective.zfar: is 0, must be above 0, taken "
                            "as infinite"));
}

TEST(Lights, PointLightIsRead) {
    const scene::SceneData scene =
        Load(WithLight({{"type", "point"}, {"color", {1, 0.5, 0.25}}, {"intensity", 40}, {"range", 7}}));
    ASSERT_EQ(scene.lights.size(), 1u);
    const scene::Light& light = scene.lights[0];
    EXPECT_EQ(light.type, scene::LightType::Point);
    EXPECT_EQ(light.name, "pole");
    EXPECT_EQ(light.color, vec3(1, 0.5f, 0.25f));
    EXPECT_EQ(light.intensity, 40.0f);
    EXPECT_EQ(light.range, 7.0f);
    EXPECT_EQ(light.lightToWorld[3], vec3(1, 2, 3));
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(Lights, DirectionalOnesAndConesAreRead) {
    EXPECT_EQ(Load(WithLight({{"type", "directional"}})).lights.at(0).type, scene::LightType::Directional);
    const scene::Light spot =
        Load(WithLight({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}}))
            .lights.at(0);
    EXPECT_EQ(spot.innerConeAngle, 0.25f);
    EXPECT_EQ(spot.outerConeAngle, 0.5f);
}

// three.js writes so: a light of which no penumbra was asked.
TEST(Lights, ConeWithoutASoftEdgeIsRead) {
    const scene::SceneData scene =
        Load(WithLight({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.5}, {"outerConeAngle", 0.5}}}}));
    const scene::Light& spot = scene.lights.at(0);
    EXPECT_EQ(spot.outerConeAngle, 0.5f);
    EXPECT_EQ(spot.innerConeAngle, std::nextafter(0.5f, 0.0f));
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_THAT(scene.warnings[0],
                ::testing::HasSubstr("spot.innerConeAngle: is 0.5, which outerConeAngle is too"));
}

TEST(Lights, RangeThatIsNoneIsInfinite) {
    for (const Json& range : {Json(0), Json(-1), Json(nullptr), Json(1e300)}) {
        const scene::SceneData scene = Load(WithLight({{"type", "point"}, {"range", range}}));
        EXPECT_EQ(scene.lights.at(0).range, 0.0f) << range;
        EXPECT_EQ(scene.warnings.size(), 1u) << range;
    }
}

TEST(Lights, DefaultsAreTheExtensions) {
    const scene::Light light = Load(WithLight({{"type", "spot"}, {"spot", Json::object()}})).lights.at(0);
    EXPECT_EQ(light.type, scene::LightType::Spot);
    EXPECT_EQ(light.color, vec3(1));
    EXPECT_EQ(light.intensity, 1.0f);
    EXPECT_EQ(light.range, 0.0f);
    EXPECT_EQ(light.innerConeAngle, 0.0f);
    EXPECT_EQ(light.outerConeAngle, glm::quarter_pi<float>());
}

TEST(Lights, MalformedOnesAreRefused) {
    const struct {
        Json light;
        const char* message;
    } rows[] = {
        {{{"type", "area"}}, ".type: is \"area\", must be directional, point or spot"},
        {{{"type", "point"}, {"intensity", -1}}, ".intensity: is -1, must not be negative"},
        {{{"type", "spot"}}, ".spot: is absent, must be an object"},
        {{{"type", "spot"}, {"spot", {{"innerConeAngle", 1}, {"outerConeAngle", 0.5}}}},
         ".spot: innerConeAngle must be below outerConeAngle"},
        {{{"type", "spot"}, {"spot", {{"innerConeAngle", 0}, {"outerConeAngle", 0}}}},
         ".spot: innerConeAngle must be below outerConeAngle"},
        {{{"type", "spot"}, {"spot", {{"outerConeAngle", 1.6}}}},
         ".spot.outerConeAngle: is 1.6, must be at most 1.570806"},
    };
    for (const auto& [light, message] : rows)
        EXPECT_EQ(LoadError(WithLight(light)),
                  std::string("scene.gltf: extensions.KHR_lights_punctual.lights[0]") + message);
    EXPECT_EQ(LoadError(WithLight({{"type", "spot"}, {"spot", {{"outerConeAngle", 1.570797}}}})), "loaded")
        << "pi/2, rounded up";
}

}  // namespace
}  // namespace raygraph::test::import_camera_light_test

// EXT_lights_ies: point lights with measured profiles.
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

// Files of light profiles, as they are and as they must not be.
namespace raygraph::test::ies_file_test {
namespace {

using scene::IesFile;
using scene::LightProfile;
using scene::PhotometricType;

constexpr double kDegree = std::numbers::pi / 180.0;

LightProfile Parse(const IesText& file) {
    const IesFile parsed = scene::ParseIes(file.Text());
    EXPECT_TRUE(parsed.warnings.empty());
    return parsed.profile;
}

std::string Refusal(const std::string& text) {
    try {
        scene::ParseIes(text);
    } catch (const Error& error) {
        EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        return error.what();
    }
    return "read";
}

void ExpectAngles(const std::vector<float>& angles, const std::vector<double>& degrees) {
    ASSERT_EQ(angles.size(), degrees.size());
    for (size_t i = 0; i < degrees.size(); ++i) EXPECT_NEAR(angles[i], degrees[i] * kDegree, 1e-6) << i;
}

// Expects that a plane of the web holds 1000 h + v at the angles of the file.
void ExpectPlanes(const LightProfile& profile, const std::vector<double>& vertical,
                  const std::vector<double>& fileHorizontal) {
    ASSERT_EQ(profile.candela.size(), vertical.size() * fileHorizontal.size());
    size_t i = 0;
    for (const double h : fileHorizontal)
        for (const double v : vertical) EXPECT_EQ(profile.candela[i++], static_cast<float>(1000.0 * h + v));
}

IesText Named(int type, std::vector<double> vertical, std::vector<double> horizontal) {
    return {.type = type,
            .vertical = std::move(vertical),
            .horizontal = std::move(horizontal),
            .candela = [](double v, double h) { return 1000.0 * h + std::abs(v); }};
}

TEST(IesFile, PartsOfTypeCAreCompletedToATurn) {
    const std::vector<double> v{0, 30, 90};
    LightProfile profile = Parse(Named(1, v, {0}));
    EXPECT_EQ(profile.type, PhotometricType::C);
    ExpectAngles(profile.vertical, v);
    ExpectAngles(profile.horizontal, {0});
    ExpectPlanes(profile, v, {0});
    profile = Parse(Named(1, v, {0, 20, 90}));
    ExpectAngles(profile.horizontal, {0, 20, 90, 160, 180, 200, 270, 340, 360});
    ExpectPlanes(profile, v, {0, 20, 90, 20, 0, 20, 90, 20, 0});
    profile = Parse(Named(1, v, {0, 20, 180}));
    ExpectAngles(profile.horizontal, {0, 20, 180, 340, 360});
    ExpectPlanes(profile, v, {0, 20, 180, 20, 0});
    profile = Parse(Named(1, v, {90, 100, 270}));
    ExpectAngles(profile.horizontal, {90, 100, 270, 440, 450});
    ExpectPlanes(profile, v, {90, 100, 270, 100, 90});
    profile = Parse(Named(1, v, {0, 120, 360}));
    ExpectAngles(profile.horizontal, {0, 120, 360});
    ExpectPlanes(profile, v, {0, 120, 360});
    // The last plane may be left out
    profile = Parse(Named(1, v, {0, 120, 240}));
    ExpectAngles(profile.horizontal, {0, 120, 240, 360});
    ExpectPlanes(profile, v, {0, 120, 240, 0});
}

TEST(IesFile, HalvesOfTypesAAndBAreMirrored) {
    for (const int type : {2, 3}) {
        const std::vector<double> v{-90, 0, 90};
        LightProfile profile = Parse(Named(type, v, {0, 10, 90}));
        EXPECT_EQ(profile.type, type == 2 ? PhotometricType::B : PhotometricType::A);
        ExpectAngles(profile.vertical, v);
        ExpectAngles(profile.horizontal, {-90, -10, 0, 10, 90});
        profile =
            Parse({.type = type, .vertical = v, .horizontal = {-90, 0, 90}, .candela = [](double, double h) {
                       return 90.0 + h;
                   }});
        ExpectAngles(profile.horizontal, {-90, 0, 90});
        EXPECT_EQ(profile.candela.front(), 0.0f);
        EXPECT_EQ(profile.candela.back(), 180.0f);
    }
}

TEST(IesFile, FactorsAreMultipliedAsTheVersionSays) {
    IesText file{.multiplier = 2.0, .ballast = 0.5, .ballastLamp = 0.25};
    for (const auto& [version, factor] :
         std::vector<std::pair<std::string, float>>{{"IESNA:LM-63-1995", 1.0f},
                                                    {"IESNA:LM-63-2002", 1.0f},
                                                    {"IES:LM-63-2019", 1.0f},
                                                    {"IESNA91", 0.25f},
                                                    {"[LUMINAIRE] of 1986", 0.25f}}) {
        file.version = version;
        EXPECT_EQ(Parse(file).MaxIntensity(), 100.0f * factor) << version;
    }
}

TEST(IesFile, TiltAndSeparatorsAreReadOver) {
    IesText file;
    file.tilt = "TILT=INCLUDE\r\n1\r\n3\r\n0 45 90\r\n1 0.9 0.8";
    EXPECT_EQ(Parse(file).MaxIntensity(), 100.0f);
    file.tilt = " TILT = of_another.tlt ";
    EXPECT_EQ(Parse(file).MaxIntensity(), 100.0f);
    const IesFile loose = scene::ParseIes("TILT=NONE\n1,-1;+2e0, 2 1\t1 1 0 0 0 1 1 1\n0\n90, 0\n\n 7,\n8");
    EXPECT_EQ(loose.profile.candela, (std::vector<float>{14.0f, 16.0f}));
}

TEST(IesFile, NegativeIntensitiesAreNone) {
    const IesFile file = scene::ParseIes("TILT=NONE 1\n1 1 1 2 1 1 1 0 0 0 1 1 1 0 90 0 -1 5");
    EXPECT_EQ(file.profile.candela, (std::vector<float>{0.0f, 5.0f}));
    ASSERT_EQ(file.warnings.size(), 1u);
    EXPECT_EQ(file.warnings[0], "1 candela value is negative, taken as 0");
}

TEST(IesFile, MalformedOnesAreRefusedByLine) {
    EXPECT_EQ(Refusal(""), "line 0: there is no line with TILT=");
    EXPECT_EQ(Refusal("IESNA:LM-63-2002\n[X] y\n"), "line 2: there is no line with TILT=");
    EXPECT_EQ(Refusal("TILT=NONE\n1 1 1 2 1 1 1 0 0 0\n1 1 1\n0 90\n0\n5"),
              "line 6: ends where a candela value should be");
    const auto numbers = [](const std::string& ten, const std::string& rest = "") {
        return Refusal("TILT=NONE\n" + ten + "\n1 1 1\n" + rest);
    };
    EXPECT_EQ(numbers("1 1 x 2 1 1 1 0 0 0"), "line 2: the candela multiplier is \"x\", must be a number");
    EXPECT_EQ(numbers("1 1 nan 2 1 1 1 0 0 0"),
              "line 2: the candela multiplier is \"nan\", must be a number");
    EXPECT_EQ(numbers("1 1 -1 2 1 1 1 0 0 0"), "line 2: the candela multiplier is -1, must not be negative");
    EXPECT_EQ(numbers("1 1 1 1 1 1 1 0 0 0"),
              "line 2: the number of vertical angles is 1, must be a whole number of 2 to 10000");
    EXPECT_EQ(numbers("1 1 1 2 1e9 1 1 0 0 0"),
              "line 2: the number of horizontal angles is 1e+09, must be a whole number of 1 to 10000");
    EXPECT_EQ(numbers("1 1 1 2 1.5 1 1 0 0 0"),
              "line 2: the number of horizontal angles is 1.5, must be a whole number of 1 to 10000");
    EXPECT_EQ(numbers("1 1 1 2 1 4 1 0 0 0"), "line 2: the photometric type is 4, must be 1, 2 or 3");
    EXPECT_EQ(numbers("1 1 1 2 1 1 1 0 0 0", "0 200\n"),
              "line 4: vertical angle 1 is 200, must be 0 to 180 degrees");
    EXPECT_EQ(numbers("1 1 1 2 1 1 1 0 0 0", "90 90\n"),
              "line 4: vertical angle 1 is 90, must be above 90, the one before");
    EXPECT_EQ(
        numbers("1 1 1 2 2 1 1 0 0 0", "0 90\n30 60\n1 1 1 1"),
        "line 6: horizontal angles are 30 to 60, must be 0, 0 to 90, 0 to 180, 90 to 270, or all around "
        "from 0");
    EXPECT_EQ(numbers("1 1 1 2 1 2 1 0 0 0", "0 90\n0\n1 1"),
              "line 5: there is one horizontal angle; types A and B need two or more");
    EXPECT_EQ(numbers("1 1 1e20 2 1 1 1 0 0 0", "0 90\n0\n1 1e20"),
              "line 6: a candela value is 1e+40 with its factors, must be at most 1e+30");
}

// The intensities are polynomials of the cosine, over fine webs.
TEST(LightProfile, MeanIntensityIsTheIntegralOverAllDirections) {
    const auto cosine = [](double v, double) { return std::cos(v * kDegree); };
    const IesText lambert{.vertical = Steps(0, 90, 1), .candela = cosine};
    EXPECT_NEAR(Parse(lambert).MeanIntensity(), 0.25, 1e-4);  // pi over 4 pi
    const IesText all{
        .vertical = {0, 180}, .horizontal = {0, 360}, .candela = [](double, double) { return 3.0; }};
    EXPECT_NEAR(Parse(all).MeanIntensity(), 3.0, 1e-6);
    const IesText half{
        .vertical = {90, 180}, .horizontal = {0, 90}, .candela = [](double, double) { return 3.0; }};
    EXPECT_NEAR(Parse(half).MeanIntensity(), 1.5, 1e-6);
    // Lambert's again, along the other axes: cos h cos v of type B is -d.z, and so it is of type A
    for (const int type : {2, 3}) {
        const IesText other{.type = type,
                            .vertical = Steps(-90, 90, 1),
                            .horizontal = Steps(0, 90, 1),
                            .candela = [](double v, double h) {
                                return std::max(std::cos(v * kDegree) * std::cos(h * kDegree), 0.0);
                            }};
        EXPECT_NEAR(Parse(other).MeanIntensity(), 0.25, 1e-4) << type;
    }
}

}  // namespace
}  // namespace raygraph::test::ies_file_test

// The list of a light's fields: each is checked, read and saved.
namespace raygraph::scene::light_fields_test {
namespace {

// A list that lacks a field of its struct does not compile.
struct Three {
    float first = 0.0f, second = 0.0f;
    std::vector<Light> third = {};
};
static_assert(IsEachFieldOf<Three>(&Three::second, &Three::first, &Three::third));
static_assert(!IsEachFieldOf<Three>(&Three::first, &Three::third));
static_assert(!IsEachFieldOf<Three>(&Three::first, &Three::first, &Three::third));

// A value that is not the default, and that a light may have.
void Change(float& value) {
    value = 0.625f;
}
void Change(glm::vec3& value) {
    value = {0.25f, 0.5f, 0.75f};
}

std::string Refusal(const Light& light) {
    return testing::ErrorTextOf([&] { Check(light, "lamp"); });
}

Light Spot() {
    Light spot;
    spot.type = LightType::Spot;
    return spot;
}

void WriteLight(const std::filesystem::path& path, const nlohmann::json& light) {
    std::ofstream(path) << nlohmann::json{
        {"asset", {{"version", "2.0"}}},
        {"extensionsUsed", {"KHR_lights_punctual"}},
        {"extensions", {{"KHR_lights_punctual", {{"lights", {light}}}}}},
        {"nodes", {{{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}}}};
}

TEST(LightFields, CheckRefusesWhatIsOutOfTheRangeOfEachAndNamesIt) {
    EXPECT_EQ(Refusal(Spot()), "accepted") << "the defaults";
    ForEachLightField(LightType::Spot, [&](const auto& field) {
        using Value = typename std::decay_t<decltype(field)>::Value;
        const auto refused = [&](float value) {
            Light light = Spot();
            light.*field.member = Value(value);
            const std::string message = Refusal(light);
            EXPECT_TRUE(message.starts_with("lamp: " + std::string(field.name) + " is "))
                << value << ": " << message;
        };
        refused(std::nanf(""));
        refused(std::nextafter(field.range.min, -1.0f));
        if (field.range.HasMax()) refused(std::nextafter(field.range.max, kUnboundedField));
    });
    Light point = Spot();
    point.type = LightType::Point;
    point.innerConeAngle = 3.0f;
    EXPECT_EQ(Refusal(point), "accepted") << "it has no cone";
    Light sun;
    sun.type = LightType::Directional;
    sun.range = -1.0f;
    EXPECT_EQ(Refusal(sun), "accepted") << "it has no range";
}

TEST(LightFields, EachTypeOfLightIsRead) {
    EXPECT_EQ(std::vector(kGltfNames<LightType>.begin(), kGltfNames<LightType>.end()),
              (std::vector<std::string_view>{"directional", "point", "spot"}));
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "scene.gltf";
    for (const LightType type : Values<LightType>()) {
        WriteLight(path, {{"type", GltfName(type)}, {"spot", nlohmann::json::object()}});
        EXPECT_EQ(LoadGltf(path).lights.at(0).type, type) << Name(type);
    }
}

TEST(LightFields, EachIsReadFromItsPlaceAndComesBackFromAFile) {
    const test::TemporaryFolder folder;
    const std::filesystem::path source = folder.Path() / "source.gltf", target = folder.Path() / "saved.gltf";
    WriteLight(source, {{"type", "spot"}, {"range", 3}, {"spot", nlohmann::json::object()}});
    const SceneData loaded = LoadGltf(source);
    ForEachLightField(LightType::Spot, [&](const auto& field) {
        SCOPED_TRACE(field.name);
        SceneData edited = loaded;
        Change(edited.lights.at(0).*field.member);
        SaveGltf(source, edited, target);
        test::ExpectSame(edited, LoadGltf(target));
        const nlohmann::json saved =
            nlohmann::json::parse(std::ifstream(target))["extensions"]["KHR_lights_punctual"]["lights"][0];
        const nlohmann::json& object = *field.object == 0 ? saved : saved[field.object];
        EXPECT_TRUE(object.contains(field.key)) << saved;
    });
    SceneData endless = loaded;
    endless.lights.at(0).range = 0.0f;
    SaveGltf(source, endless, target);
    EXPECT_EQ(LoadGltf(target).lights.at(0).range, 0.0f) << "left out, for want of a number";
    WriteLight(source, {{"type", "directional"}, {"range", 3}});
    EXPECT_EQ(LoadGltf(source).lights.at(0).range, 0.0f) << "there is none of it";
}

}  // namespace
}  // namespace raygraph::scene::light_fields_test
