// Options of the command line as settings of the passes: each option changes its own setting and no other.
#include "editor/session/frames/device_scene.h"

#include <algorithm>
#include <numbers>
#include <set>
#include <string>

#include "editor/session/settings/setting_table.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::session::device_scene_test {

namespace {

using Parts = std::map<std::string, std::string>;

std::string Text(const glm::vec3& v) {
    return std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z);
}
template <typename T>
std::string Number(T value) {
    return std::to_string(static_cast<double>(value));
}

// Returns the state that determines a picture, as parts with names.
Parts PartsOf(DeviceScene& scene) {
    const passes::TraceSettings s = scene.SettingsFor(3);
    const EnvironmentSettings& environment = scene.Scene().Environment();
    constexpr uint64_t kLeastAutomatic =
        uint64_t{1} << 20;  // lower bound of the automatic budget, which depends on free memory
    const uint64_t budget = scene.Scene().Statistics().textureBudget;
    return {{"extent", Number(s.extent.width) + "x" + Number(s.extent.height)},
            {"region", Number(s.region.x) + "," + Number(s.region.y) + "," + Number(s.region.width) + "," +
                           Number(s.region.height)},
            {"eye", Text(s.camera.origin)},
            {"lens radius", Number(s.camera.lensRadius)},
            {"focus distance", Number(s.camera.focusDistance)},
            {"sampler", Number(s.sampler)},
            {"seed", Number(s.seed)},
            {"sample", Number(s.sampleIndex)},
            {"brdf", Number(s.scattering.brdf)},
            {"distribution", Number(s.scattering.distribution)},
            {"masking", Number(s.scattering.masking)},
            {"fresnel", Number(s.scattering.fresnel)},
            {"multiscatter", Number(s.scattering.multiscatter)},
            {"light sampling", Number(s.lights.isOn)},
            {"light sampler", Number(s.lights.sampler)},
            {"mis", Number(s.lights.mis)},
            {"roulette", Number(s.roulette.kind)},
            {"roulette's start", Number(s.roulette.start)},
            {"survival", Number(s.roulette.survival)},
            {"depth", Number(s.biases.maxDepth)},
            {"clamp", Number(s.biases.clampIndirect)},
            {"regularize", Number(s.biases.regularize)},
            {"shadow terminator", Number(s.biases.shadowTerminator)},
            {"hidden environment", Number(s.isEnvironmentHidden)},
            {"texture budget", budget < kLeastAutomatic ? Number(budget) : "automatic"},
            {"texture levels", Number(s.biases.textureLod)},
            {"environment", Text(environment.radiance)},
            {"environment's rotation", Number(environment.rotation)},
            {"environment is the scene's", Number(environment.usesScene)},
            {"environment is the studio",
             Number(scene.Scene().ShownEnvironment().defaultLight == DefaultLight::Studio)}};
}

class DeviceSceneTest : public testing::VulkanTest {
  protected:
    static Parts PartsWith(const SettingTexts& texts, bool hasMap = false, bool sceneHasMap = false) {
        SceneInput input;
        if (sceneHasMap) input.data.environment.map = {1, 1, {1.0f, 1.0f, 1.0f, 1.0f}};
        scene::Camera camera;
        camera.cameraToWorld[3] = {0.0f, 0.0f, 5.0f};
        input.data.cameras.push_back(camera);
        camera.cameraToWorld[3] = {1.0f, 2.0f, 3.0f};
        input.data.cameras.push_back(camera);
        if (hasMap) input.environment = {.width = 1, .height = 1, .rgba = {1.0f, 1.0f, 1.0f, 1.0f}};
        PictureSettings settings = SettingsFrom(texts);
        if (settings.light == DefaultLight::Auto) settings.light = DefaultLight::None;
        DeviceScene scene(Device(), input, settings);
        return PartsOf(scene);
    }
    struct Change {
        const char* option;
        const char* text;
        std::set<std::string> parts;
        const char* value = nullptr;  // expected value of the only part
    };
    static void ExpectChange(const Change& change, bool hasMap = false) {
        SCOPED_TRACE(std::string("--") + change.option + " " + change.text);
        const Parts before = PartsWith({}, hasMap), after = PartsWith({{change.option, change.text}}, hasMap);
        std::set<std::string> changed;
        for (const auto& [name, value] : before)
            if (after.at(name) != value) changed.insert(name);
        EXPECT_EQ(changed, change.parts);
        if (change.value != nullptr) {
            EXPECT_EQ(after.at(*change.parts.begin()), change.value);
        }
    }
};

}  // namespace

TEST_F(DeviceSceneTest, EveryOptionOfThePictureChangesItsPartAlone) {
    const Change kChanges[] = {
        {"size", "64x32", {"extent"}},
        {"crop", "3,4,5,6", {"region"}, "3.000000,4.000000,5.000000,6.000000"},
        {"camera", "1", {"eye"}, "1.000000 2.000000 3.000000"},
        {"aperture", "0.25", {"lens radius"}, "0.250000"},
        {"focus", "3.5", {"focus distance"}, "3.500000"},
        {"sampler", "tea", {"sampler"}, "2.000000"},
        {"seed", "7", {"seed"}, "7.000000"},
        {"brdf", "lafortune", {"brdf"}, "2.000000"},
        {"distribution", "phong", {"distribution"}, "2.000000"},
        {"masking", "shortcut", {"masking"}, "2.000000"},
        {"fresnel", "lazanyi", {"fresnel"}, "3.000000"},
        {"multiscatter", "walk", {"multiscatter"}, "2.000000"},
        {"nee", "off", {"light sampling"}, "0.000000"},
        {"light-sampler", "power", {"light sampler"}, "1.000000"},
        {"mis", "balance", {"mis"}, "0.000000"},
        {"rr", "off", {"roulette"}, "3.000000"},
        {"rr", "frame:0.5", {"roulette", "survival"}},
        {"rr-start", "5", {"roulette's start"}, "5.000000"},
        {"max-depth", "4", {"depth"}, "4.000000"},
        {"clamp-indirect", "2.5", {"clamp"}, "2.500000"},
        {"regularize", "0.5", {"regularize"}, "0.500000"},
        {"shadow-terminator", "on", {"shadow terminator"}, "1.000000"},
        {"texture-budget", "64K", {"texture budget"}, "65536.000000"},
        {"transparent", "on", {"hidden environment"}, "1.000000"},
        {"texture-lod", "-0.5", {"texture levels"}, "-0.500000"},
        {"light", "studio", {"environment is the studio"}, "1.000000"},
        {"background", "1,2,3", {"environment", "environment is the scene's"}, "1.000000 2.000000 3.000000"},
        {"env-rotation", "180", {"environment's rotation"}, "3.141593"},
        {"env-tint", "2,3,4", {"environment"}, "2.000000 3.000000 4.000000"},  // tints the studio
    };
    for (const Change& change : kChanges) ExpectChange(change);
    // With a map, the tint applies to it, and the background is not used
    ExpectChange({"env-tint", "2,3,4", {"environment"}, "2.000000 3.000000 4.000000"}, true);
    ExpectChange({"background", "1,2,3", {}}, true);
    // The scene's own environment is tinted, too; any background and any map replace it
    const auto environmentOf = [](const SettingTexts& texts, bool isMapGiven = false) {
        const Parts parts = PartsWith(texts, isMapGiven, true);
        return parts.at("environment") + ", " + parts.at("environment is the scene's");
    };
    EXPECT_EQ(environmentOf({}), "1.000000 1.000000 1.000000, 1.000000");
    EXPECT_EQ(environmentOf({{"env-tint", "2,3,4"}}), "2.000000 3.000000 4.000000, 1.000000");
    EXPECT_EQ(environmentOf({{"background", "1,2,3"}}), "1.000000 2.000000 3.000000, 0.000000");
    EXPECT_EQ(environmentOf({{"background", "0,0,0"}}), "0.000000 0.000000 0.000000, 0.000000");
    EXPECT_EQ(environmentOf({}, true), "1.000000 1.000000 1.000000, 0.000000");
    // Every setting is tested, except those that tell the command what to do with the picture
    for (const PictureSetting& setting : PictureSettingTable()) {
        const std::string name = setting.name;
        const bool isOfCommand = name == "view" || name == "scene" || name == "variant" || name == "at" ||
                                 name == "clips" || name == "shutter" || name == "points" ||
                                 name == "lines" || name == "shadows" || name == "light-group" ||
                                 name == "adaptive";
        const bool isHere = std::any_of(std::begin(kChanges), std::end(kChanges),
                                        [&](const Change& change) { return change.option == name; });
        EXPECT_NE(isHere, isOfCommand) << name;
    }
    EXPECT_EQ(PartsWith({}).at("sample"), "3.000000");
}

}  // namespace raygraph::session::device_scene_test
