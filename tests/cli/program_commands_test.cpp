// Tests the output of commands for scripts.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "base/text.h"
#include "editor/session/file/image_statistics.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf/document.h"
#include "renderer/scene/model/camera_view.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"

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
    {
        const std::string line = "graph @cornell.gltf --size 32x32 --first";
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

// Tests `raygraph bench` by the built program. It needs a device.
namespace raygraph::program_bench_test {
namespace {

using test::ProgramResult;
using test::RunProgram;

nlohmann::json JsonOf(const std::filesystem::path& path) {
    std::ifstream file(path);
    return nlohmann::json::parse(file);
}

}  // namespace

TEST(ProgramBench, TimesAViewportAgainstARender) {
    const test::TemporaryFolder folder;
    const std::string line = "bench @cornell.gltf --viewport --size 32x18 --frames 2 --rounds 3";
    const ProgramResult result = RunProgram(folder, line + " --json b.json");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    const nlohmann::json json = JsonOf(folder / "b.json"), viewport = json.at("viewport");
    EXPECT_EQ(viewport.at("budget_ms"), 120.0);
    EXPECT_DOUBLE_EQ(viewport.at("render").at("relative"), 1.0);
    EXPECT_DOUBLE_EQ(viewport.at("one_a_frame").at("samples_per_frame"), 1.0);
    for (const char* kind : {"render", "one_a_frame", "within_budget"}) {
        const nlohmann::json& cost = viewport.at(kind);
        EXPECT_GT(cost.at("cpu_s_per_sample"), 0.0) << kind;
        EXPECT_GT(cost.at("gpu_ms_per_sample"), 0.0) << kind;
        EXPECT_NEAR(cost.at("cost").at("median").get<double>(),
                    cost.at("relative").get<double>() * json.at("cost").at("median").get<double>(), 1e-6)
            << kind;
    }
    nlohmann::json faster = json;
    faster["viewport"]["one_a_frame"]["cost"]["median"] = 1e-3;
    faster["viewport"]["one_a_frame"]["cost"]["standard_error"] = 0.0;
    std::ofstream(folder / "faster.json") << faster.dump() << "\n";
    const ProgramResult slower = RunProgram(folder, line + " --compare faster.json --tolerance 20");
    EXPECT_EQ(slower.exitCode, 6) << slower.messages;
    EXPECT_NE(slower.messages.find("cornell.gltf, viewport"), std::string::npos) << slower.messages;
}

TEST(ProgramBench, PrintsOneLineOfJsonWithTheEfficiency) {
    const test::TemporaryFolder folder;
    const ProgramResult result =
        RunProgram(folder, "bench @cornell.gltf --size 64x36 --frames 2 --rounds 2 --json b.json");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_EQ(result.output.find('\n') + 1, result.output.size());
    const nlohmann::json json = nlohmann::json::parse(result.output);
    EXPECT_EQ(json, JsonOf(folder / "b.json"));
    EXPECT_EQ(json.at("settings").at("max-depth"), "16");
    EXPECT_EQ(json.at("frames"), 4);
    const double trace = json.at("trace").at("mrays_per_s"), path = json.at("limit_path").at("mrays_per_s");
    EXPECT_GT(trace, 0.0);
    EXPECT_NEAR(json.at("trace_efficiency").get<double>(), trace / path, 1e-6);
    const nlohmann::json& own = json.at("limit_path_own");
    EXPECT_NEAR(json.at("trace_efficiency_own").get<double>(), trace / own.at("mrays_per_s").get<double>(),
                1e-6);
    constexpr double kAtEdges = 23.0;  // bound on the paths, of 2,304, whose ray count depends on rounding
    EXPECT_NEAR(own.at("rays_per_sample").get<double>(),
                json.at("limit_path").at("rays_per_sample").get<double>(), kAtEdges / (64.0 * 36.0));
    EXPECT_DOUBLE_EQ(json.at("limit").at("rays_per_sample"), 1.0);
    EXPECT_GT(json.at("trace").at("rays_per_sample").get<double>(), 1.0);
    EXPECT_GT(json.at("msamples_per_cpu_s").get<double>(), 0.0);
    const nlohmann::json& recursion = json.at("recursion");
    const double loop = recursion.at("loop_ms");
    EXPECT_GT(loop, 0.0);
    if (recursion.at("recursive_ms").is_null()) {
        EXPECT_TRUE(recursion.at("loop_speedup").is_null());
        EXPECT_NE(result.messages.find("recursive not measured"), std::string::npos) << result.messages;
    } else {
        EXPECT_NEAR(recursion.at("loop_speedup"), recursion.at("recursive_ms").get<double>() / loop, 1e-6);
        EXPECT_NE(result.messages.find("recursion: loop "), std::string::npos) << result.messages;
    }
    const nlohmann::json& medians = json.at("gpu_ms_median");
    const char* tracing = medians.contains("Trace") ? "Trace" : "WaveFirst";  // depends on the form
    for (const char* pass : {tracing, "Accumulate", "Tonemap", "Limit", "LimitPath", "LambertLoop"})
        EXPECT_GT(medians.at(pass).get<double>(), 0.0) << pass;

    // It is not slower than a stored run at four times the cost
    nlohmann::json stored = json;
    stored["cost"]["median"] = 4.0 * json.at("cost").at("median").get<double>();
    stored["cost"]["standard_error"] = 0.0;
    std::ofstream(folder / "stored.json") << stored.dump() << "\n";
    const ProgramResult faster = RunProgram(
        folder,
        "bench @cornell.gltf --size 64x36 --frames 2 --rounds 2 --compare stored.json --tolerance 0.5");
    EXPECT_EQ(faster.exitCode, 0) << faster.messages;
}

}  // namespace raygraph::program_bench_test

// Tests the editor as the program runs it from a script. It needs a device.
namespace raygraph::program_edit_test {
namespace {

using test::RunProgram;
using test::SceneFile;

// Returns the fraction of texels that differ by more than their rounding.
double ShareUnlike(const std::vector<float>& a, const std::vector<float>& b) {
    EXPECT_EQ(a.size(), b.size());
    size_t unlike = 0;
    for (size_t i = 0; i < a.size(); ++i) unlike += std::abs(a[i] - b[i]) > 1e-3f * (1.0f + std::abs(b[i]));
    return static_cast<double>(unlike) / static_cast<double>(a.size());
}

TEST(ProgramEdit, SavedExrIsTheRenderOfItsSettingsAndIsResumed) {
    const test::TemporaryFolder folder;
    std::ofstream(folder.Path() / "script.txt")
        << "budget 0\nsize 120x100\nopen " << SceneFile("cornell.gltf") << "\nwait\nsamples 3\npicture "
        << (folder.Path() / "edit.exr").string() << "\nexpect message sample\n";
    const test::ProgramResult edited =
        RunProgram(folder, "edit --light none --validate --headless-script script.txt");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
    ASSERT_EQ(edited.exitCode, 0) << edited.messages;
    const session::RenderFile saved = session::ReadRenderFile(folder / "edit.exr");
    EXPECT_EQ(saved.sceneFile, "cornell.gltf");
    for (const session::Aov aov : {session::Aov::Albedo, session::Aov::Normal, session::Aov::Depth,
                                   session::Aov::Instance, session::Aov::Material})
        EXPECT_TRUE(AovsOf(saved).Has(aov)) << Name(aov);

    std::string line =
        Text("render @cornell.gltf -o render.exr --spp {} --aov depth,instance", SampleCount(saved.samples));
    for (const char* setting : {"camera", "size", "background", "seed", "texture-lod"})
        line += Text(" --{} '{}'", setting, saved.settings.at(setting));
    const test::ProgramResult rendered = RunProgram(folder, line);
    ASSERT_EQ(rendered.exitCode, 0) << rendered.messages;
    const session::RenderFile plain = session::ReadRenderFile(folder / "render.exr");
    EXPECT_EQ(saved.settings, plain.settings);
    // The camera is written as decimals, so a few paths differ
    size_t unlike = 0;
    for (size_t i = 0; i < plain.radiance.size(); ++i)
        unlike +=
            std::abs(saved.radiance[i] - plain.radiance[i]) > 1e-3f * (1.0f + std::abs(plain.radiance[i]));
    EXPECT_LT(unlike, plain.radiance.size() / 100);
    size_t otherInstance = 0;
    for (size_t i = 0; i < plain.instance.size(); ++i)
        otherInstance += saved.instance[i] != plain.instance[i];
    EXPECT_LT(otherInstance, 4u);

    // It is resumed
    const uint64_t before = SampleCount(saved.samples);

    const test::ProgramResult resumed = RunProgram(
        folder, Text("render @cornell.gltf --resume edit.exr --spp {} -o resumed.exr", before + 5));
    ASSERT_EQ(resumed.exitCode, 0) << resumed.messages;
    EXPECT_NE(resumed.output.find("5 of them new"), std::string::npos) << resumed.output;
    const session::RenderFile more = session::ReadRenderFile(folder / "resumed.exr");
    EXPECT_EQ(more.samples, (session::SampleRanges{{0, static_cast<uint32_t>(before + 5)}}));
    EXPECT_TRUE(HasSums(more)) << "it can be resumed again";

    const test::ProgramResult whole = RunProgram(
        folder, Text("render @cornell.gltf --camera '{}' --size {} --spp {} --aov albedo,normal -o whole.exr",
                     saved.settings.at("camera"), saved.settings.at("size"), before + 5));
    ASSERT_EQ(whole.exitCode, 0) << whole.messages;
    const session::RenderFile once = session::ReadRenderFile(folder / "whole.exr");
    // The camera is written as decimals, so a few paths of the first samples differ
    EXPECT_LT(ShareUnlike(more.radiance, once.radiance), 0.02);
    EXPECT_GT(ShareUnlike(saved.radiance, once.radiance), 0.2) << "there are samples to add";
    EXPECT_EQ(more.albedo, once.albedo) << "of all samples, not of the pixels' centers";
    EXPECT_EQ(more.sums.normal, once.sums.normal);
}

TEST(ProgramEdit, SavedExrSaysHowAnOrthographicCameraSawATurnedSky) {
    const test::TemporaryFolder folder;
    nlohmann::json scene = nlohmann::json::parse(std::ifstream(SceneFile("cornell.gltf")));
    scene["cameras"][0] = {
        {"type", "orthographic"},
        {"orthographic", {{"xmag", 1.0}, {"ymag", 0.75}, {"znear", 0.01}, {"zfar", 100.0}}}};
    std::ofstream(folder / "flat.gltf") << scene;
    const image::ImageF sky{8, 4, std::vector<float>(8 * 4 * 4, 0.5f)};
    image::WriteHdr(folder.Path() / "sky.hdr", sky);
    std::ofstream(folder.Path() / "script.txt")
        << "size 120x100\nopen " << (folder / "flat.gltf").string() << "\nwait\nopen "
        << (folder / "sky.hdr").string() << "\nwait\nsamples 1\npicture " << (folder / "edit.exr").string()
        << "\n";
    const test::ProgramResult edited = RunProgram(folder, "edit --headless-script script.txt");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
    ASSERT_EQ(edited.exitCode, 0) << edited.messages;
    const session::RenderFile saved = session::ReadRenderFile(folder / "edit.exr");
    EXPECT_EQ(saved.environmentFile, "sky.hdr");
    EXPECT_EQ(saved.settings.at("env-tint"), "1,1,1");
    EXPECT_TRUE(saved.settings.at("camera").ends_with("1.5m")) << saved.settings.at("camera");

    const test::ProgramResult rendered =
        RunProgram(folder, Text("render flat.gltf -o render.exr --spp 1 --aov depth,instance --env sky.hdr "
                                "--env-tint 0.5,1,2 --camera '{}' --size {}",
                                saved.settings.at("camera"), saved.settings.at("size")));
    ASSERT_EQ(rendered.exitCode, 0) << rendered.messages;
    const session::RenderFile plain = session::ReadRenderFile(folder / "render.exr");
    EXPECT_EQ(plain.settings.at("camera"), saved.settings.at("camera"));
    ASSERT_EQ(plain.instance[0], 0xFFFFFFFFu) << "the corner sees the sky";
    for (const size_t c : {0u, 1u, 2u}) {
        EXPECT_NEAR(saved.radiance[c], 0.5f, 1e-3f);
        EXPECT_NEAR(plain.radiance[c], 0.25f * float(1u << c), 1e-3f) << "tinted";
    }
    size_t otherInstance = 0;
    for (size_t i = 0; i < plain.instance.size(); ++i)
        otherInstance += saved.instance[i] != plain.instance[i];
    EXPECT_LT(otherInstance, 4u);

    const uint64_t total = SampleCount(saved.samples) + 2;
    const std::string resume = Text("render flat.gltf --resume edit.exr --spp {} -o more.exr", total);
    EXPECT_EQ(RunProgram(folder, resume).exitCode, 4) << "without the map";
    const test::ProgramResult resumed = RunProgram(folder, resume + " --env sky.hdr");
    ASSERT_EQ(resumed.exitCode, 0) << resumed.messages;
    EXPECT_NEAR(session::ReadRenderFile(folder / "more.exr").radiance[0], 0.5f, 1e-3f);
}

// A script runs with the options of a render.
TEST(ProgramEdit, OpensWithTheCameraEnvironmentAndViewThatAreAskedFor) {
    const test::TemporaryFolder folder;
    image::ImageF sky{8, 4, std::vector<float>(8 * 4 * 4, 1.0f)};
    for (size_t i = 0; i < 8 * 4; ++i) sky.rgba[4 * i] = 0.25f;  // less red
    image::WriteHdr(folder.Path() / "sky.hdr", sky);
    std::ofstream(folder / "script.txt")
        << "size 120x100\nwait\nexpect view raster\nview path-traced\nsamples 2\npicture "
        << (folder / "edit.exr").string() << "\nexpect message sample\n";
    const std::string options =
        "edit @furnace_sphere.gltf --env sky.hdr --view raster --camera '0.5 1 6 0 0 0 0 1 0 30' ";
    const test::ProgramResult edited = RunProgram(folder, options + "--headless-script script.txt");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
    ASSERT_EQ(edited.exitCode, 0) << edited.messages;
    const session::RenderFile saved = session::ReadRenderFile(folder / "edit.exr");
    EXPECT_EQ(saved.environmentFile, "sky.hdr");
    const scene::CameraView seen = scene::ViewFromText(saved.settings.at("camera"), 1.0f);
    EXPECT_NEAR(glm::distance(seen.eye, glm::dvec3(0.5, 1.0, 6.0)), 0.0, 1e-5);
    EXPECT_NEAR(glm::degrees(seen.yFov), 30.0f, 1e-3f);
    // The upper left corner shows the sky
    EXPECT_NEAR(saved.radiance[0], 0.25f, 1e-3f);
    EXPECT_NEAR(saved.radiance[1], 1.0f, 1e-2f);
}

TEST(ProgramEdit, ACameraOfTheSceneIsTakenByNameAndByIndex) {
    const test::TemporaryFolder folder;
    nlohmann::json scene = nlohmann::json::parse(std::ifstream(SceneFile("cornell.gltf")));
    scene["cameras"].push_back(
        {{"type", "perspective"}, {"name", "door"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.01}}}});
    scene["nodes"].push_back({{"camera", 1}, {"translation", {0.0, 0.2, 0.9}}});
    scene["scenes"][0]["nodes"].push_back(scene["nodes"].size() - 1);
    std::ofstream(folder / "two.gltf") << scene;
    for (const auto& [choice, eye] : {std::pair{"door", 0.9}}) {
        std::ofstream(folder / "script.txt")
            << "size 120x100\nwait\nsamples 1\npicture " << (folder / "edit.exr").string() << "\nwait\n";
        const test::ProgramResult edited = RunProgram(
            folder, Text("edit two.gltf --light none --camera {} --headless-script script.txt", choice));
        RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
        ASSERT_EQ(edited.exitCode, 0) << edited.messages;
        const session::RenderFile saved = session::ReadRenderFile(folder / "edit.exr");
        EXPECT_NEAR(scene::ViewFromText(saved.settings.at("camera"), 1.0f).eye.z, eye, 1e-4) << choice;
    }
    std::ofstream(folder / "script.txt") << "wait\nexpect message there is no camera \"window\"\n";
    const test::ProgramResult none =
        RunProgram(folder, "edit two.gltf --light none --camera window --headless-script script.txt");
    EXPECT_EQ(none.exitCode, 0) << none.messages
                                << "the status line says it, as of what else cannot be loaded";
}

TEST(ProgramEdit, EveryViewCanBeTheFirst) {
    const test::TemporaryFolder folder;
    std::ofstream(folder / "script.txt")
        << "size 120x100\nwait\nframes 2\npicture " << (folder / "a.png").string() << "\nwait\n";
    std::map<std::string, std::string> pictures;
    for (const char* view : {"raster", "normals"}) {
        const test::ProgramResult edited = RunProgram(
            folder, Text("edit @cornell.gltf --light none --view {} --headless-script script.txt", view));
        RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
        ASSERT_EQ(edited.exitCode, 0) << edited.messages;
        std::ifstream file(folder / "a.png", std::ios::binary);
        const auto [at, isNew] =
            pictures.emplace(std::string(std::istreambuf_iterator<char>(file), {}), view);
        EXPECT_TRUE(isNew) << view << " looks like " << at->second;
    }
}

TEST(ProgramEdit, TakesTheViewOfARender) {
    const test::TemporaryFolder folder;
    const std::filesystem::path saved = folder / "saved.gltf";
    std::ofstream(folder / "script.txt") << "size 120x100\nwait\nscene " << saved.string() << "\n";
    const test::ProgramResult edited =
        RunProgram(folder,
                   "edit @cornell.gltf --view raster --headless-script script.txt --exposure 1.5 "
                   "--tonemap agx --white-point 5000 --aperture .25 --focus 3 --background .5,1,2");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
    ASSERT_EQ(edited.exitCode, 0) << edited.messages;
    const nlohmann::json view = nlohmann::json::parse(std::ifstream(saved.string() + ".view.json"));
    EXPECT_EQ(view.at("display"),
              nlohmann::json({{"exposure", 1.5}, {"tonemap", "agx"}, {"whitePoint", 5000}}));
    EXPECT_EQ(view.at("camera").at("aperture"), 0.25);
    EXPECT_EQ(view.at("camera").at("focus"), 3.0);
    EXPECT_EQ(view.at("environment").at("usesScene"), false);
    EXPECT_EQ(view.at("environment").at("radiance"), nlohmann::json({0.5, 1.0, 2.0}));
}

TEST(ProgramEdit, RefusesWhatItCannotBeginWith) {
    const test::TemporaryFolder folder;
    const auto expect = [&](const std::string& line, int exitCode, const std::string& text) {
        const test::ProgramResult result = RunProgram(folder, line + " --headless-script none.txt");
        EXPECT_EQ(result.exitCode, exitCode) << result.messages;
        EXPECT_NE(result.messages.find(text), std::string::npos) << result.messages;
    };
    expect("edit --camera 0", 2, "--camera looks at a scene: it needs a FILE");
    expect("edit @cornell.gltf --camera '0 0 0 0 0 0 0 1 0 40'", 2, "--camera");
    expect("edit @cornell.gltf --white-point auto", 2, "render knows it");
    expect("edit @cornell.gltf --view cubist", 2, "side-by-side, difference, relative-error, flip");
    const test::ProgramResult edited = RunProgram(folder, "edit --env sky.png --headless-script none.txt");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
    expect("edit --env sky.png", 4, "sky.png: an environment map ends in .hdr or .exr");
}

}  // namespace
// Without a display it says how to render what was named, and never onto that.
TEST(ProgramEdit, WithoutADisplayNamesACommandForAScene) {
    const test::TemporaryFolder folder;
    const test::EnvironmentVariable x11("DISPLAY", ""), wayland("WAYLAND_DISPLAY", "");
    test::Put(folder / "bad.png", "\x89PNG\r\n\x1a\n");
    std::filesystem::copy_file(test::SceneFile("furnace_sphere.gltf"), folder / "a b.png");
    struct Row {
        const char* file;
        int exitCode;
        const char* message;
    };
    for (const Row& row :
         {Row{"bad.png", 4, "raygraph: bad.png: not a glTF file, but "},
          Row{"'a b.png'", 3, "; without one: raygraph render \"a b.png\" -o \"a b.png.png\"\n"},
          Row{"sky.hdr", 3, "; without one: raygraph render FILE --env sky.hdr -o FILE.png\n"}}) {
        const test::ProgramResult result = RunProgram(folder, Text("edit {}", row.file));
        RAYGRAPH_SKIP_WITHOUT_EDITOR(result);
        EXPECT_NE(result.messages.find(row.message), std::string::npos) << result.messages;
        EXPECT_EQ(result.exitCode, row.exitCode) << row.file;
        EXPECT_EQ(result.messages.find("without one") == std::string::npos, row.exitCode == 4) << row.file;
    }
}

}  // namespace raygraph::program_edit_test
