// The list of a light's fields: each is checked, read and saved.
#include "renderer/scene/model/scene_fields.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "renderer/scene/gltf/choice.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "renderer/scene/model/check.h"
#include "tests/scene/same_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

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
