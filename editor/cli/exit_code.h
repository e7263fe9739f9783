// ExitCode is the program's exit status.
#pragma once

#include <string>

#include "base/error.h"

namespace raygraph::cli {

enum class ExitCode : int {
    Done = 0,
    Failure = 1,        // failed write of an output, failed Vulkan call, validation message
    Usage = 2,          // the command line is not valid
    NoDevice = 3,       // no device meets the requirements
    BadInput = 4,       // unreadable, malformed or unsuitable scene, picture or render
    DeviceFailure = 5,  // device lost, or out of memory
    Slower = 6,         // a cost has increased by more than the tolerance
    TryAgain = 75,      // ended early with the work saved; EX_TEMPFAIL of sysexits.h
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
// Returns all codes with their meaning: "0 done, 1 failure, ...".
std::string ListOfExitCodes();

}  // namespace raygraph::cli
