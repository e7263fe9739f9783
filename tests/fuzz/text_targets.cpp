// Fuzzes text that users and programs write: the command line, the editor's settings, lines of `raygraph
// bench`, graphs in JSON.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "editor/app/script.h"
#include "editor/app/settings.h"
#include "editor/cli/arguments.h"
#include "editor/cli/bench_compare.h"
#include "editor/graph_run/graph_file.h"
#include "editor/session/file/sample_ranges.h"
#include "editor/session/settings/setting_table.h"
#include "renderer/scene/model/camera_view.h"
#include "tests/fuzz/target.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::fuzz {

namespace {

std::vector<std::string> Lines(std::string_view text) {
    std::vector<std::string> lines(1);
    for (const char c : text)
        if (c == '\n')
            lines.emplace_back();
        else
            lines.back() += c;
    return lines;
}

// Each line is a word of the command line.
void ParseCommandLine(std::string_view text) {
    const std::vector<std::string> lines = Lines(text);
    std::vector<const char*> words{"raygraph"};
    for (const std::string& line : lines) words.push_back(line.c_str());
    cli::ParseArguments(static_cast<int>(words.size()), words.data());
}

// Parses "seed=1": the text of a picture setting's value must read back as the same value.
void ParseSettings(std::string_view text) {
    for (const std::string& line : Lines(text)) {
        const size_t equals = std::min(line.find('='), line.size());
        const std::string name = line.substr(0, equals);
        for (const session::PictureSetting& setting : session::PictureSettingTable()) {
            if (name != setting.name) continue;
            session::PictureSettings settings, again;
            setting.set(settings, std::string_view(line).substr(std::min(equals + 1, line.size())));
            const std::string said = setting.text(settings);
            Require(Succeeds("", {}, [&] { setting.set(again, said); }),
                    "--" + name + " reads not what it says");
            Require(setting.text(again) == said,
                    "--" + name + " " + said + " is read as " + setting.text(again));
        }
    }
}

scene::SceneData NamedScene() {
    scene::SceneData scene;
    scene.nodes = {{.name = "lamp of the left"},
                   {.name = "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaab", .parent = 0}};
    scene.nodeOrder = {0, 1};
    scene.materials.resize(1);
    scene.meshes = {{.name = "m", .primitives = std::vector<scene::Primitive>(1)}};
    scene.instances = {{.mesh = 0, .node = 1}};
    scene.lights = {{.name = "bulb", .node = 1}};
    scene.cameras = {{.name = "front", .node = 0}};
    return scene;
}

void ParseGroups(std::string_view text) {
    const std::vector<session::LightGroupPatterns> groups = session::ParseLightGroups(text);
    Require(session::ToText(session::ParseLightGroups(session::ToText(groups))) == session::ToText(groups),
            "groups of lights are read as others");
    static const scene::SceneData scene = NamedScene();
    session::MatchLightGroups(groups, scene);
}

void ParseView(std::string_view text) {
    static const scene::SceneData scene = NamedScene();
    const scene::CameraView view = scene::ChooseView(scene, text, 1.5f);
    const glm::dvec3 all = view.eye + glm::dvec3(view.forward + view.up + view.right);
    Require(std::isfinite(all.x + all.y + all.z) && std::isfinite(view.yFov) && std::isfinite(view.height),
            "a view of the text has numbers that are not finite");
    Require(std::abs(glm::length(view.forward) - 1.0f) < 1e-3f, "a view's direction is not of unit length");
}

void ParseRanges(std::string_view text) {
    const session::SampleRanges ranges = session::ParseSampleRanges(text);
    Require(!ranges.empty() && session::ParseSampleRanges(session::ToText(ranges)) == ranges,
            "sample ranges are read as others");
    Require(session::Overlap(ranges, ranges) &&
                session::SampleCount(session::Union(ranges, {})) == session::SampleCount(ranges),
            "sample ranges are no sets");
}

void CompareLines(std::string_view text) {
    static const nlohmann::ordered_json now = {{"scene", "a.gltf"},
                                               {"device", "d"},
                                               {"settings", {{"size", "8x8"}}},
                                               {"cost",
                                                {{"limit_path_version", cli::kLimitPathVersion},
                                                 {"measure", "cpu seconds"},
                                                 {"median", 2.0},
                                                 {"standard_error", 0.1}}}};
    for (const cli::BenchChange& change : cli::CompareBench("stored", std::string(text), now, 0.05))
        cli::ToText(change, now);
}

}  // namespace

// The first byte selects the kind of text.
void RunTexts(Input input) {
    if (input.empty()) return;
    constexpr void (*kParsers[])(std::string_view) = {ParseCommandLine, ParseSettings, ParseGroups,
                                                      ParseView,        ParseRanges,   CompareLines};
    const auto parse = kParsers[std::to_integer<size_t>(input[0]) % std::size(kParsers)];
    Succeeds("", {ErrorKind::Usage, ErrorKind::BadInput}, [&] { parse(AsText(input.subspan(1))); });
}

void RunScripts(Input input) {
    Succeeds("script:", {ErrorKind::BadInput}, [&] {
        for (const editor::ScriptLine& line : editor::ParseScript(AsText(input), "script")) {
            // The text of a line reads back as the same line
            const std::vector<editor::ScriptLine> again = editor::ParseScript(line.text, "script");
            Require(again.size() == 1 && again[0].text == line.text &&
                        again[0].command.index() == line.command.index(),
                    "a line is read as another: " + line.text);
        }
    });
}

// A description that is accepted names only resources that exist, and files below its folder.
void RunGraphFiles(Input input) {
    graph_run::GraphFile graph;
    const auto read = [&] { graph = graph_run::ParseGraphFile(AsText(input), "graph"); };
    if (!Succeeds("graph: ", {ErrorKind::BadInput}, read)) return;
    const auto requireBelow = [](const std::filesystem::path& file) {
        Require(file.is_relative() && (file.empty() || *file.begin() != ".."),
                "a file leads out of its folder");
    };
    const auto isThere = [&](const std::string& name) {
        return graph.textures.contains(name) || graph.buffers.contains(name);
    };
    for (const auto& [name, texture] : graph.textures) {
        requireBelow(texture.file);
        const auto bytes = graph_run::TextureBytes(texture.format, texture.size, texture.layers);
        Require(bytes <= graph_run::kMaxResourceBytes, "a texture is larger than any may be");
        Require(texture.sizeOf.empty() || graph.textures.contains(texture.sizeOf), "a size is of no texture");
    }
    for (const auto& [name, buffer] : graph.buffers) requireBelow(buffer.file);
    for (const graph_run::FilePass& pass : graph.passes) {
        requireBelow(pass.shader);
        for (const auto& [name, resource] : pass.bind)
            Require(isThere(resource), "what is bound is not there");
        for (const std::string& target : pass.targets)
            Require(graph.textures.contains(target), "a target is not there");
    }
    for (const graph_run::FileOutput& output : graph.outputs) {
        Require(isThere(output.resource), "an output is not there");
        Require(output.file.find('/') == output.file.npos, "an output leads into a folder");
    }
    Require(!graph.outputs.empty() && graph.frames > 0, "there is nothing to do");
}

void RunSettings(Input input) {
    static const test::TemporaryFolder folder;
    std::ofstream(folder / "editor.json", std::ios::binary) << AsText(input);
    std::string message;
    const editor::Settings settings = editor::ReadSettings(folder.Path(), message);
    Require(std::ranges::none_of(message,
                                 [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }),
            "the message is no line: " + message);
    Require(message.empty() || settings == editor::Settings(), "settings that are ignored count");
    Require(settings.recent.size() <= editor::Settings::kMaxRecent, "too many recent files");
    editor::WriteSettings(folder.Path(), settings);
    Require(editor::ReadSettings(folder.Path(), message) == settings, "settings are read as others");
}

}  // namespace raygraph::fuzz
