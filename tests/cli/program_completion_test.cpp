// Tests the completion of shells with the programs that read them.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>

#include "base/text.h"
#include "editor/cli/completion.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/environment_variable.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_completion_test {
namespace {

using test::RunProgram;
using test::TemporaryFolder;

// Runs a line of sh in the folder, and returns its output, stderr included.
std::string Shell(const TemporaryFolder& folder, const std::string& line) {
    const std::string whole = Text("cd '{}' && {{ {}; }} 2>&1", folder.Path().string(), line);
    std::FILE* pipe = popen(whole.c_str(), "r");
    std::string text;
    for (int c = 0; (c = std::fgetc(pipe)) != EOF;) text += static_cast<char>(c);
    pclose(pipe);
    return text;
}

bool Has(const char* program) {
    return !Shell(TemporaryFolder(), Text("command -v {}", program)).empty();
}

// Writes the output of `raygraph LINE` to a file in the folder.
void Store(const TemporaryFolder& folder, const char* line, const char* file) {
    const test::ProgramResult result = RunProgram(folder, line);
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    std::ofstream(folder / file) << result.output;
}

// Returns all names that the --help of each command lists; "" is the program's own.
std::map<std::string, std::vector<std::string>> NamesInHelp() {
    std::map<std::string, std::vector<std::string>> names;
    const TemporaryFolder folder;
    std::vector<std::string> commands{""};
    const std::string overview = RunProgram(folder, "--help").output;
    std::istringstream list(overview.substr(overview.find("Commands:")));
    for (std::string line; std::getline(list, line) && !line.empty();)
        if (line.starts_with("  ") && line[2] != ' ')
            commands.push_back(line.substr(2, line.find(' ', 2) - 2));
    EXPECT_GE(commands.size(), 8u) << overview;
    const std::regex name("--?[a-z][a-z-]*");
    for (const std::string& command : commands) {
        std::istringstream help(
            RunProgram(folder, command + (command.empty() ? " --help" : " --help-all")).output);
        for (std::string line; std::getline(help, line);) {
            if (!line.starts_with("  -")) continue;
            const std::string first = line.substr(2, line.find(' ', 2) - 2);  // "-o,--output"
            for (std::sregex_iterator i(first.begin(), first.end(), name), end; i != end; ++i)
                names[command].push_back(i->str());
        }
    }
    return names;
}

TEST(Completion, BashCompletesCommandsOptionsAndWhatTheyTake) {
    const TemporaryFolder folder;
    Store(folder, "completion bash", "c.bash");
    for (const char* file : {"my scene.gltf", "sky.hdr", "a.exr", "notes.txt"}) std::ofstream(folder / file);
    std::filesystem::create_directory(folder / "shaders");
    std::ofstream(folder / "try.bash") << R"(source ./c.bash
complete -p raygraph
try() {
    COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
    _raygraph
    printf '%s\n' "${COMPREPLY[@]}" | sort | tr '\n' '|'
    echo
}
)";
    EXPECT_EQ(Shell(folder, "bash -n c.bash"), "");
    EXPECT_EQ(Shell(folder, "bash -c 'source ./try.bash'"), "complete -F _raygraph raygraph\n");
    const auto completed = [&](const char* words) {
        std::string text = Shell(folder, Text("bash -c '. ./try.bash; try {}' | tail -n 1", words));
        while (text.ends_with('\n') || text.ends_with('|')) text.pop_back();
        return text;
    };
    EXPECT_EQ(completed("raygraph ren"), "render");
    EXPECT_EQ(completed("raygraph me"), "merge");
    EXPECT_EQ(completed("raygraph render --sam"), "--sample-offset|--sampler");
    EXPECT_EQ(completed("raygraph merge --sam"), "");
    EXPECT_EQ(completed("raygraph render --view ra"), "raster|ray-cost");
    EXPECT_EQ(completed("raygraph render --view = ra"), "raster|ray-cost") << "--view=ra, as bash has it";
    EXPECT_EQ(completed("raygraph render --progress \"\""), "auto|json|none|plain");
    EXPECT_EQ(completed("raygraph render --nee o"), "off|on");
    EXPECT_EQ(completed("raygraph render --aov albedo,no"), "albedo,normal");
    EXPECT_EQ(completed("raygraph render --size \"\""), "");
    EXPECT_EQ(completed("raygraph render \"\""), "my scene.gltf|shaders");
    EXPECT_EQ(completed("raygraph render a.gltf --env \"\""), "a.exr|shaders|sky.hdr");
    EXPECT_EQ(completed("raygraph render --resume \"\""), "a.exr|shaders");
    EXPECT_EQ(completed("raygraph render --log n"), "notes.txt");
    EXPECT_EQ(completed("raygraph edit --shaders \"\""), "shaders");
    EXPECT_EQ(completed("raygraph completion z"), "zsh");
}

TEST(Completion, EveryShellKnowsEveryOptionOfHelp) {
    const TemporaryFolder folder;
    const std::string bash = RunProgram(folder, "completion bash").output;
    const std::string zsh = RunProgram(folder, "completion zsh").output;
    const std::string fish = RunProgram(folder, "completion fish").output;
    const auto expect = [](const std::string& script, const std::string& text) {
        EXPECT_NE(script.find(text), std::string::npos) << "lacks " << text;
    };
    for (const auto& [command, names] : NamesInHelp()) {
        EXPECT_FALSE(names.empty()) << command;
        // Search only the command's part of the script
        const size_t inBash = bash.find("\n        " + (command.empty() ? "''" : command) + ")");
        const size_t inZsh = command.empty() ? 0 : zsh.find("\n            " + command + ") _arguments");
        ASSERT_TRUE(inBash != std::string::npos && inZsh != std::string::npos) << command;
        const std::string ofBash = bash.substr(inBash, bash.find(";;\n", inBash) - inBash) + " ";
        const std::string ofZsh = zsh.substr(inZsh, zsh.find(";;\n", inZsh) - inZsh);
        for (const std::string& name : names) {
            EXPECT_TRUE(std::regex_search(ofBash, std::regex("[ ']" + name + "[ ']"))) << command << name;
            EXPECT_NE(ofZsh.find(name + "["), std::string::npos) << command << name;
            const std::string condition =
                command.empty() ? "__fish_use_subcommand" : "__fish_seen_subcommand_from " + command;
            const std::string option =
                name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
            EXPECT_TRUE(
                std::regex_search(fish, std::regex("-n '" + condition + "'[^\n]*" + option + "[ \n]")))
                << command << name;
        }
    }
    expect(zsh, "'--sampler[Random numbers]:SAMPLER:(sobol pcg tea)'");
    expect(zsh, "'--max-depth[Bias\\: end paths after N bounces");
    expect(zsh, "'1:FILE:_files -g \"*.(gltf|glb)\"'");
    expect(zsh, "'*:FILES:_files -g \"*.exr\"'");
    expect(fish, " -l sampler -x -a 'sobol pcg tea' -d 'Random numbers'");
}

TEST(Completion, ZshReadsItsScript) {
    if (!Has("zsh")) GTEST_SKIP() << "there is no zsh";
    const TemporaryFolder folder;
    Store(folder, "completion zsh", "_raygraph");
    EXPECT_EQ(Shell(folder, "zsh -n _raygraph"), "");
}

TEST(Completion, FishReadsItsScriptAndCompletes) {
    if (!Has("fish")) GTEST_SKIP() << "there is no fish";
    const TemporaryFolder folder;
    Store(folder, "completion fish", "c.fish");
    EXPECT_EQ(Shell(folder, "fish --no-execute c.fish"), "");
    EXPECT_EQ(
        Shell(folder, "fish --no-config -c 'source ./c.fish; complete -C \"raygraph render --view ra\"'"),
        "raster\tWhat the picture shows\nray-cost\tWhat the picture shows\n");
}

TEST(Environment, ChoosesTheDeviceWhereNoOptionDoes) {
    const TemporaryFolder folder;
    const std::string line = "graph @small_light.gltf --size 16x16";
    const test::EnvironmentVariable chosen("RAYGRAPH_DEVICE", "no such device");
    const test::ProgramResult refused = RunProgram(folder, line);
    EXPECT_EQ(refused.exitCode, 3);
    EXPECT_EQ(refused.messages.find("raygraph: RAYGRAPH_DEVICE: "), 0u) << refused.messages;
    EXPECT_NE(refused.messages.find("'no such device'"), std::string::npos) << refused.messages;
    const test::ProgramResult other = RunProgram(folder, line + " --device 'another one'");
    EXPECT_EQ(other.exitCode, 3);
    EXPECT_EQ(other.messages.find("RAYGRAPH_DEVICE"), std::string::npos) << other.messages;

    // The name of the device that is used if none is chosen
    const test::EnvironmentVariable none("RAYGRAPH_DEVICE", "");
    const std::string render = "render @small_light.gltf --size 8x8 --spp 1 --quiet -o ";
    ASSERT_EQ(RunProgram(folder, render + "a.exr").exitCode, 0);
    const std::string name = session::ReadRenderFile(folder / "a.exr").device;
    const test::EnvironmentVariable named("RAYGRAPH_DEVICE", name);
    ASSERT_EQ(RunProgram(folder, render + "b.exr").exitCode, 0);
    EXPECT_EQ(session::ReadRenderFile(folder / "b.exr").device, name);
}

}  // namespace
}  // namespace raygraph::program_completion_test
