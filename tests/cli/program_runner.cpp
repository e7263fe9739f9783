#include "tests/cli/program_runner.h"

#include <fcntl.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "tests/cli/cli_test.h"
#include "tests/support/source_file.h"
#include "tests/support/text_files.h"

namespace raygraph::test {

namespace {

// Called in the child: the program takes signals as if a shell with a terminal had started it, even if the
// tests run in the background of a script, which ignores some.
void SynchronizeSignals() {
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXCPU, SIGXFSZ, SIGUSR1, SIGUSR2})
        std::signal(number, SIG_DFL);
}

// Called in the child: becomes the program. Nothing may be allocated after fork(), so `words` are pointers.
[[noreturn]] void Become(const TemporaryFolder& folder, const std::vector<char*>& words) {
    if (chdir(folder.Path().c_str()) == 0) execv(words[0], words.data());
    _exit(127);
}

// Turns the leak check of sanitized programs off: leaks of the driver and the layers, which are unloaded when
// a program ends, look like ours. This process has read its own options long ago.
void LeaveLeaksOut() {
    const char* options = std::getenv("ASAN_OPTIONS");
    setenv("ASAN_OPTIONS", (std::string(options ? options : "") + ":detect_leaks=0").c_str(), 1);
}

// Programs get neither the RAYGRAPH_LOG of the tests' user nor another device than the tests. This runs
// before the first test, which may set them.
[[maybe_unused]] const int isWithoutLevels = unsetenv("RAYGRAPH_LOG") + unsetenv("RAYGRAPH_DEVICE");

// Puts the program's own path before the words.
std::vector<std::string> ProgramWords(std::string_view line) {
    static std::once_flag isSet;
    std::call_once(isSet, LeaveLeaksOut);
    std::vector<std::string> words = Words(line);
    for (std::string& word : words)
        if (word.starts_with('@')) word = SceneFile(word.c_str() + 1);
    words.insert(words.begin(), EnvironmentOr("RAYGRAPH_PROGRAM", RAYGRAPH_BUILT_PROGRAM));
    words[0] = std::filesystem::absolute(words[0]).string();
    return words;
}

std::vector<char*> Pointers(std::vector<std::string>& words) {
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    return pointers;
}

int ExitCodeIn(int status) {
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

int ExitCodeOf(pid_t process) {
    int status = 0;
    waitpid(process, &status, 0);
    return ExitCodeIn(status);
}

void Redirect(const char* path, int descriptor) {
    const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(file, descriptor);
    close(file);
}

}  // namespace

ProgramResult RunProgram(const TemporaryFolder& folder, std::string_view line) {
    return RunProgramBeside(folder, line, {});
}

ProgramResult RunProgramBeside(
    const TemporaryFolder& folder, std::string_view line,
    const std::function<void(pid_t process, const std::string& messages)>& meanwhile,
    const std::function<void()>& prepare) {
    const TemporaryFolder outputs;
    const std::string output = outputs / "stdout", messages = outputs / "stderr";
    std::vector<std::string> words = ProgramWords(line);
    const std::vector<char*> pointers = Pointers(words);
    const pid_t process = fork();
    if (process < 0) throw std::runtime_error("fork failed");
    if (process == 0) {
        SynchronizeSignals();
        Redirect(output.c_str(), STDOUT_FILENO);
        Redirect(messages.c_str(), STDERR_FILENO);
        if (prepare) prepare();
        Become(folder, pointers);
    }
    ProgramResult result;
    if (meanwhile) {
        int status = 0;
        do {
            meanwhile(process, TextOf(messages));
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        } while (waitpid(process, &status, WNOHANG) == 0);
        result.exitCode = ExitCodeIn(status);
    } else {
        result.exitCode = ExitCodeOf(process);
    }
    result.output = TextOf(output);
    result.messages = TextOf(messages);
    return result;
}

ProgramResult RunProgramOnTerminal(
    const TemporaryFolder& folder, std::string_view line,
    const std::function<void(pid_t process, const std::string& shown)>& onText) {
    std::vector<std::string> words = ProgramWords(line);
    const std::vector<char*> pointers = Pointers(words);
    int terminal = -1;
    const pid_t process = forkpty(&terminal, nullptr, nullptr, nullptr);
    if (process < 0) throw std::runtime_error("forkpty failed");
    if (process == 0) {
        SynchronizeSignals();
        Become(folder, pointers);
    }
    ProgramResult result;
    std::array<char, 4096> buffer{};
    for (;;) {
        const ssize_t count = read(terminal, buffer.data(), buffer.size());
        if (count <= 0) break;  // a terminal without a process reads as an error
        result.output.append(buffer.data(), static_cast<size_t>(count));
        onText(process, result.output);
    }
    close(terminal);
    result.exitCode = ExitCodeOf(process);
    return result;
}

std::string SceneFile(const char* name) {
    return (SourceFile("scenes") / name).string();
}

void WriteBox(const TemporaryFolder& folder) {
    nlohmann::json scene = nlohmann::json::parse(std::ifstream(SceneFile("cornell.gltf")));
    // 0 and 1; (0, 0, 0) and (0, 0.1, 0); (0, 0, 0) and (0, -0.1, 0)
    const size_t buffer = scene["buffers"].size();
    scene["buffers"].push_back(
        {{"byteLength", 56},
         {"uri",
          "data:application/"
          "octet-stream;base64,AAAAAAAAgD8AAAAAAAAAAAAAAAAAAAAAzczMPQAAAAAAAAAAAAAAAAAAAAAAAAAAzc"
          "zMvQAAAAA="}});
    const size_t view = scene["bufferViews"].size();
    scene["bufferViews"].push_back({{"buffer", buffer}, {"byteLength", 56}});
    const size_t times = scene["accessors"].size();
    scene["accessors"].push_back({{"bufferView", view},
                                  {"componentType", 5126},
                                  {"count", 2},
                                  {"type", "SCALAR"},
                                  {"min", nlohmann::json::array({0})},
                                  {"max", nlohmann::json::array({1})}});
    size_t node = 0;
    while (!scene["nodes"][node].contains("mesh")) ++node;
    for (const size_t offset : {8, 32}) {
        scene["accessors"].push_back({{"bufferView", view},
                                      {"byteOffset", offset},
                                      {"componentType", 5126},
                                      {"count", 2},
                                      {"type", "VEC3"}});
        scene["animations"].push_back(
            {{"name", offset == 8 ? "rise" : "sink"},
             {"samplers",
              nlohmann::json::array({{{"input", times}, {"output", scene["accessors"].size() - 1}}})},
             {"channels", nlohmann::json::array(
                              {{{"sampler", 0}, {"target", {{"node", node}, {"path", "translation"}}}}})}});
    }
    std::ofstream(folder / "box.gltf") << scene;
}

}  // namespace raygraph::test
