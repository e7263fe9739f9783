// Runs the built program as a user does.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
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

// A scene of the source tree: "cornell.gltf".
std::string SceneFile(const char* name);

}  // namespace raygraph::test
