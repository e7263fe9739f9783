// Runs the built program as a user does.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <string_view>

#include "tests/support/environment_variable.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::test {

struct ProgramResult {
    int exitCode = -1;     // -1: ended by a signal
    std::string output;    // stdout
    std::string messages;  // stderr
};

// `raygraph` with the words of `line` (cli_test.h), run in `folder`, which the files that it names are
// relative to; @cornell.gltf is a scene of the source tree. Its stdout and stderr are files: no terminal.
ProgramResult RunProgram(const TemporaryFolder& folder, std::string_view line);

// The same, while `meanwhile` is called again and again, at least once before the program's end is known,
// with what stderr has so far. It may send signals to the process. `prepare` is called in the process before
// it becomes the program, and may change only signals, limits and streams.
ProgramResult RunProgramBeside(
    const TemporaryFolder& folder, std::string_view line,
    const std::function<void(pid_t process, const std::string& messages)>& meanwhile,
    const std::function<void()>& prepare = {});

// The same on a terminal of its own, so that progress is shown. `onText` is called with all that the terminal
// has shown so far and may send signals to the process. `messages` stays empty: a terminal does not tell the
// two apart.
ProgramResult RunProgramOnTerminal(
    const TemporaryFolder& folder, std::string_view line,
    const std::function<void(pid_t process, const std::string& shown)>& onText);

// A scene of the source tree: "cornell.gltf".
std::string SceneFile(const char* name);

}  // namespace raygraph::test

// After a run of `edit`: skips the test where the program was built without the editor.
#define RAYGRAPH_SKIP_WITHOUT_EDITOR(result) \
    if ((result).messages.find("no editor") != std::string::npos) GTEST_SKIP() << (result).messages
