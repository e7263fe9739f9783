// Tests the output of commands for scripts.
#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "editor/session/file/image_statistics.h"
#include "renderer/scene/gltf/document.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_json_test {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::RunProgram;

json OutputOf(const std::string& line) {
    const ProgramResult result = RunProgram(test::TemporaryFolder(), line);
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_TRUE(result.output.ends_with("}\n")) << result.output;
    return json::parse(result.output);
}

TEST(ProgramJson, InfoOfASceneHasAllThatItsFileHas) {
    const json file = json::parse(std::ifstream(test::SceneFile("many_lights.gltf")));
    const json info = OutputOf("info @many_lights.gltf --json");
    EXPECT_EQ(info.at("schema"), 1);
    EXPECT_EQ(info.at("file"), "many_lights.gltf");
    ASSERT_EQ(info.at("materials").size(), file.at("materials").size());
    for (size_t i = 0; i < info.at("materials").size(); ++i)
        EXPECT_EQ(info["materials"][i].at("name"), file["materials"][i].at("name"));
    const json& lights = file.at("extensions").at("KHR_lights_punctual").at("lights");
    ASSERT_EQ(info.at("lights").size(), lights.size());
    for (const json& light : info.at("lights")) {
        const bool isDirectional = light.at("type") == "directional";
        EXPECT_GT(light.at(isDirectional ? "illuminance_lx" : "intensity_cd"), 0.0) << light;
    }
    EXPECT_GT(info.at("triangles_placed"), 0);
    EXPECT_EQ(info.at("bounds_m").at("min").size(), 3u);
}

TEST(ProgramJson, NumbersOfInfoAreThoseOfTheFile) {
    const json file = json::parse(std::ifstream(test::SceneFile("cornell.gltf")));
    const json info = OutputOf("info @cornell.gltf --json");
    ASSERT_EQ(info.at("materials").size(), file.at("materials").size());
    for (size_t i = 0; i < info["materials"].size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double inFile = file["materials"][i]["pbrMetallicRoughness"]["baseColorFactor"][c];
            EXPECT_NEAR(info["materials"][i]["base_color"][c], inFile, 1e-6) << i;
        }
    EXPECT_EQ(info.at("variant"), json());
    EXPECT_EQ(info.at("animations"), json::array());
    const json varied = OutputOf("info @variants_grid.gltf --json --variant 1");
    EXPECT_EQ(varied.at("variant"), 1);
    EXPECT_GE(varied.at("variants").size(), 2u);
}

// Adds the members of the object, nested ones by their path: "a.b". An empty object becomes true.
void FlattenInto(json& flat, const json& object, const std::string& way) {
    for (const auto& [key, value] : object.items()) {
        const std::string place = way.empty() || key == "extensions" ? key : way + "." + key;
        if (value.is_object() && value.empty())
            flat[place] = true;
        else if (value.is_object())
            FlattenInto(flat, value, key == "extensions" ? "" : place);
        else
            flat[place] = value;
    }
}

TEST(ProgramJson, FieldsOfMaterialsAreThoseOfTheFile) {
    for (const char* scene : {"material_row.gltf", "layers_grid.gltf", "texture_coordinates_grid.gltf"}) {
        SCOPED_TRACE(scene);
        const json file = json::parse(std::ifstream(test::SceneFile(scene))).at("materials");
        const json info = OutputOf(std::string("info --json @") + scene).at("materials");
        ASSERT_EQ(info.size(), file.size());
        for (size_t i = 0; i < info.size(); ++i) {
            json flat;
            FlattenInto(flat, file[i], "");
            for (const auto& [place, value] : info[i].at("fields").items()) {
                const std::string inFile = value.is_number_unsigned() ? place + ".index" : place;
                ASSERT_TRUE(flat.contains(inFile)) << info[i];
                if (value.is_string() || value.is_boolean() || value.is_number_unsigned())
                    EXPECT_EQ(value, flat[inFile]) << place;
                else
                    for (size_t c = 0; c < value.size(); ++c)
                        EXPECT_NEAR(value.is_array() ? value[c] : value,
                                    value.is_array() ? flat[inFile][c] : flat[inFile], 1e-6)
                            << place;
            }
        }
    }
}

TEST(ProgramJson, AnglesAreInDegreesAndPlacesInMeters) {
    constexpr double kDegrees = 180.0 / std::numbers::pi;
    const json file = json::parse(std::ifstream(test::SceneFile("terrace.gltf")));
    const json info = OutputOf("info @terrace.gltf --json");
    const json& lights = file.at("extensions").at("KHR_lights_punctual").at("lights");
    size_t spots = 0;
    for (const json& light : info.at("lights")) {
        const auto inFile =
            std::ranges::find_if(lights, [&](const json& one) { return one.at("type") == light.at("type"); });
        ASSERT_NE(inFile, lights.end()) << light;
        EXPECT_EQ(light.contains("cone_degrees"), inFile->contains("spot"));
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(light.at("color")[c], inFile->at("color")[c], 1e-6);
        if (!inFile->contains("spot")) continue;
        ++spots;
        const double outer = inFile->at("spot").at("outerConeAngle");
        EXPECT_NEAR(light.at("cone_degrees"), 2.0 * kDegrees * outer, 1e-3);
    }
    EXPECT_GT(spots, 0u);

    const json box = json::parse(std::ifstream(test::SceneFile("cornell.gltf")));
    const json seen = OutputOf("info @cornell.gltf --json");
    const json& camera = seen.at("cameras").at(0);
    EXPECT_EQ(camera.at("projection"), "perspective");
    const double yFov = box.at("cameras")[0].at("perspective").at("yfov");
    EXPECT_NEAR(camera.at("fov_degrees"), kDegrees * yFov, 1e-3);
    const auto node =
        std::ranges::find_if(box.at("nodes"), [](const json& n) { return n.contains("camera"); });
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(camera.at("eye")[c], node->at("translation")[c], 1e-5);
    const json& bounds = seen.at("bounds_m");
    for (int c = 0; c < 3; ++c) EXPECT_LT(bounds.at("min")[c], bounds.at("max")[c]);
    EXPECT_NEAR(bounds["max"][1], 0.5488, 0.01) << "its height";
}

TEST(ProgramJson, ACameraOfInfoIsOneThatRenderTakes) {
    const test::TemporaryFolder folder;
    const std::string camera = OutputOf("info @cornell.gltf --json").at("cameras")[0].at("option");
    const std::string line = "render @cornell.gltf --view depth --size 24x16 --quiet -o ";
    ASSERT_EQ(RunProgram(folder, line + "a.exr").exitCode, 0);
    ASSERT_EQ(RunProgram(folder, line + "b.exr --camera '" + camera + "'").exitCode, 0);
    const session::RenderFile a = session::ReadRenderFile(folder / "a.exr");
    const session::RenderFile b = session::ReadRenderFile(folder / "b.exr");
    ASSERT_EQ(a.radiance.size(), b.radiance.size());
    for (size_t i = 0; i < a.radiance.size(); ++i) ASSERT_NEAR(a.radiance[i], b.radiance[i], 1e-3f) << i;
}

TEST(ProgramJson, ExtensionsAreThoseOfTheText) {
    const json listed = OutputOf("info --extensions --json").at("extensions");
    ASSERT_EQ(listed.size(), scene::KnownExtensions().size());
    for (size_t i = 0; i < listed.size(); ++i) {
        EXPECT_EQ(listed[i].at("name"), scene::KnownExtensions()[i].name);
        EXPECT_EQ(listed[i].at("read"), scene::KnownExtensions()[i].isRead);
    }
}

TEST(ProgramJson, DevicesAreThoseOfTheText) {
    const std::string text = RunProgram(test::TemporaryFolder(), "info --devices").output;
    const json devices = OutputOf("info --devices --json").at("devices");
    ASSERT_FALSE(devices.empty());
    for (const json& device : devices) {
        const std::string line =
            std::to_string(device.at("index").get<int>()) + "  " + device.at("name").get<std::string>();
        EXPECT_NE(text.find(line + "\n"), std::string::npos) << text << "lacks " << line;
        EXPECT_EQ(device.at("suitable"), device.at("refusals").empty());
    }
}

TEST(ProgramJson, ThePlanOfAFrameIsThatOfTheText) {
    for (const char* frame : {"", " --first"}) {
        const std::string line = std::string("graph @cornell.gltf --size 32x32") + frame;
        std::istringstream text(RunProgram(test::TemporaryFolder(), line).output);
        const json plan = OutputOf(line + " --json");
        std::vector<std::string> inText, inJson;
        std::map<size_t, int> versions;  // versions of resources that passes have written
        size_t waitsInText = 0, waitsInJson = plan.at("acquire").at("barriers").size();
        for (std::string word; std::getline(text, word);) {
            waitsInText += word.starts_with("    waits ");
            if (!word.empty() && word[0] >= '1' && word[0] <= '9' && word.find('(') != word.npos &&
                word.find(',') == word.npos)
                inText.push_back(word);
        }
        for (const json& pass : plan.at("passes")) {
            waitsInJson += pass.at("barriers").size();
            inJson.push_back(std::to_string(inJson.size() + 1) + " " + pass.at("name").get<std::string>() +
                             " (" + pass.at("kind").get<std::string>() + ")");
            for (const char* uses : {"reads", "writes"})
                for (const json& use : pass.at(uses))
                    EXPECT_EQ(plan.at("resources")[use.at("resource").get<size_t>()].at("name"),
                              use.at("name"));
            for (const json& use : pass.at("reads")) {
                const auto written = versions.find(use.at("resource"));
                EXPECT_TRUE(written == versions.end() || use.at("version") == written->second) << use;
            }
            for (const json& use : pass.at("writes")) versions[use.at("resource")] = use.at("version");
        }
        waitsInJson += plan.at("end").at("barriers").size();
        EXPECT_EQ(inJson, inText);
        EXPECT_EQ(waitsInJson, waitsInText);
        EXPECT_EQ(plan.at("end").at("roots")[0].at("kind"), "presented");
        EXPECT_GT(plan.at("memory").at("bytes"), 0);
    }
}

TEST(ProgramJson, MergeReportsWhatWasMerged) {
    const test::TemporaryFolder folder;
    session::WriteRenderFile(folder / "a.exr", test::MakeRender(0, 16));
    session::WriteRenderFile(folder / "b.exr", test::MakeRender(32, 48, 1.0f));
    const ProgramResult merged = RunProgram(folder, "merge b.exr a.exr -o m.exr --report m.json");
    ASSERT_EQ(merged.exitCode, 0) << merged.messages;
    EXPECT_NE(merged.output.find("m.exr\nm.json\n"), std::string::npos) << merged.output;
    const json report = json::parse(std::ifstream(folder / "m.json"));
    const session::RenderFile whole = session::ReadRenderFile(folder / "m.exr");
    ASSERT_EQ(report.at("inputs").size(), 2u);
    EXPECT_EQ(report["inputs"][0].at("file"), "b.exr");
    EXPECT_EQ(report["inputs"][0].at("ranges"), json::parse(R"([{"first": 32, "count": 48}])"));
    EXPECT_EQ(report["inputs"][1].at("samples"), 16);
    EXPECT_EQ(report["inputs"][1].at("device"), "a device");
    EXPECT_EQ(report["inputs"][1].at("driver"), "a driver");
    const json& output = report.at("output");
    EXPECT_EQ(output.at("file"), "m.exr");
    EXPECT_EQ(output.at("samples"), 64);
    EXPECT_EQ(output.at("ranges"), json::parse(R"([{"first": 0, "count": 16}, {"first": 32, "count": 48}])"));
    const session::ImageStatistics image = session::Measure(whole.radiance, whole.variance, 64);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(output.at("image").at("mean")[c], image.mean[c], 1e-12);
    ASSERT_TRUE(image.relativeError);
    EXPECT_NEAR(output.at("image").at("relative_error"), *image.relativeError, 1e-12);
    EXPECT_EQ(report.at("width"), whole.size.width);
    EXPECT_EQ(report.at("settings").at("size"), whole.settings.at("size"));
    EXPECT_EQ(report.at("aovs"),
              json::parse(R"(["albedo", "normal", "depth", "instance", "material", "motion"])"));
}

TEST(ProgramJson, AReportThatWouldReplaceARenderIsRefused) {
    const test::TemporaryFolder folder;
    session::WriteRenderFile(folder / "a.exr", test::MakeRender(0, 16));
    session::WriteRenderFile(folder / "b.exr", test::MakeRender(16, 16));
    for (const char* report : {"a.exr", "m.exr"}) {
        const ProgramResult result =
            RunProgram(folder, std::string("merge a.exr b.exr -o m.exr --report ") + report);
        EXPECT_EQ(result.exitCode, 2) << result.messages;
        EXPECT_NE(result.messages.find(report), std::string::npos) << result.messages;
    }
    EXPECT_EQ(RunProgram(folder, "merge a.exr b.exr -o m.exr --report missing/m.json").exitCode, 1);
    EXPECT_FALSE(std::filesystem::exists(folder / "m.exr"));
}

}  // namespace
}  // namespace raygraph::program_json_test
