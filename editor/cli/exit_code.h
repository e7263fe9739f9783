// What the program's exit status says.
#pragma once

#include <string>

#include "base/error.h"

namespace raygraph::cli {

enum class ExitCode : int {
    Done = 0,
    Failure = 1,        // an output that cannot be written, a failed Vulkan call, a validation message
    Usage = 2,          // the command line asks for something that cannot be
    NoDevice = 3,       // no device meets the requirements
    BadInput = 4,       // a scene, picture or render that cannot be read, is malformed or does not fit
    DeviceFailure = 5,  // lost, or out of memory
    Slower = 6,         // a cost has risen by more than the tolerance
    TryAgain = 75,      // asked to end before the work was done, which is saved; EX_TEMPFAIL of sysexits.h
};

struct ExitCodeText {
    ExitCode code;
    const char* text;
};
inline constexpr ExitCodeText kExitCodes[] = {
    {ExitCode::Done, "done"},
    {ExitCode::Failure, "failure"},
    {ExitCode::Usage, "usage"},
    {ExitCode::NoDevice, "no suitable device"},
    {ExitCode::BadInput, "bad input"},
    {ExitCode::DeviceFailure, "device lost or out of memory"},
    {ExitCode::Slower, "slower than the stored run (bench --compare)"},
    {ExitCode::TryAgain, "saved and ended by SIGTERM or another such signal: resume it"},
};

ExitCode ExitCodeFor(ErrorKind kind);
// "0 done, 1 failure, ...": all of them.
std::string ListOfExitCodes();

}  // namespace raygraph::cli
