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

// Runs `raygraph` with the words of `line` (cli_test.h) in `folder`, to which the files in it are relative;
// @cornell.gltf is a scene of the source tree. Its stdout and stderr are files, not a terminal.
ProgramResult RunProgram(const TemporaryFolder& folder, std::string_view line);

// Also calls `meanwhile` with the text of stderr so far, again and again, at least once before the program's
// end is known. It may send signals to the process. `prepare` is called in the process before it becomes the
// program, and may change only signals, limits and streams.
ProgramResult RunProgramBeside(
    const TemporaryFolder& folder, std::string_view line,
    const std::function<void(pid_t process, const std::string& messages)>& meanwhile,
    const std::function<void()>& prepare = {});

// Runs the program on a terminal of its own, so that progress is shown. `onText` is called with all that the
// terminal has shown so far, and may send signals to the process. `messages` stays empty: a terminal does not
// tell stdout from stderr.
ProgramResult RunProgramOnTerminal(
    const TemporaryFolder& folder, std::string_view line,
    const std::function<void(pid_t process, const std::string& shown)>& onText);

// Returns the path of a scene of the source tree: "cornell.gltf".
std::string SceneFile(const char* name);

// Writes box.gltf: the Cornell box, in which "rise" lifts the first node that has a mesh by 0.1 m per second,
// and "sink" lowers it.
void WriteBox(const TemporaryFolder& folder);

}  // namespace raygraph::test

// Skips a test after a run of `edit` if the program was built without the editor.
#define RAYGRAPH_SKIP_WITHOUT_EDITOR(result) \
    if ((result).messages.find("no editor") != std::string::npos) GTEST_SKIP() << (result).messages
