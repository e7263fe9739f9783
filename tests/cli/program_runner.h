// Runs the built program as a user does.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace raygraph::test {

struct ProgramResult {
    int exitCode = -1;     // -1: ended by a signal
    std::string output;    // stdout
    std::string messages;  // stderr
};

// `raygraph WORDS...` with stdout and stderr in files: no terminal.
ProgramResult RunProgram(const std::vector<std::string>& words);

// The same on a terminal of its own, so that progress is shown. `onText` is called with all that the terminal
// has shown so far and may send signals to the process. `messages` stays empty: a terminal does not tell the
// two apart.
ProgramResult RunProgramOnTerminal(
    const std::vector<std::string>& words,
    const std::function<void(pid_t process, const std::string& shown)>& onText);

// A variable of the environment for as long as it lives, for programs that are started meanwhile.
class EnvironmentVariable {
  public:
    EnvironmentVariable(const char* name, const std::string& value);
    ~EnvironmentVariable();
    EnvironmentVariable(const EnvironmentVariable&) = delete;
    EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

  private:
    const char* m_name;
    std::optional<std::string> m_old;
};

// A scene of the source tree: "cornell.gltf".
std::string SceneFile(const char* name);

}  // namespace raygraph::test

// After a run of `edit`: skips the test where the program was built without the editor.
#define RAYGRAPH_SKIP_WITHOUT_EDITOR(result) \
    if ((result).messages.find("no editor") != std::string::npos) GTEST_SKIP() << (result).messages
