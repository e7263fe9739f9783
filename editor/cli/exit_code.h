// ExitCode is the program's exit status.
#pragma once

#include "base/error.h"

namespace raygraph::cli {

enum class ExitCode : int {
    Done = 0,
    Failure = 1,
    Usage = 2,
    NoDevice = 3,
    BadInput = 4,
    DeviceFailure = 5,
    Slower = 6,
    Differs = 7,
    TryAgain = 75,  // EX_TEMPFAIL of sysexits.h
};

struct ExitCodeText {
    ExitCode code;
    const char* text;
};
inline constexpr ExitCodeText kExitCodes[] = {
    {ExitCode::Done, "done, also when Ctrl-C ended a render early"},
    {ExitCode::Failure, "failure: an output cannot be written, Vulkan failed, validation has a message"},
    {ExitCode::Usage, "usage: the command line is not valid"},
    {ExitCode::NoDevice, "no suitable device"},
    {ExitCode::BadInput, "bad input: a file is missing, malformed, or not what was asked for"},
    {ExitCode::DeviceFailure, "device lost or out of memory"},
    {ExitCode::Slower, "bench --compare: slower than the stored run"},
    {ExitCode::Differs, "verify: a picture is not right"},
    {ExitCode::TryAgain, "ended by SIGTERM or the like, with the samples saved: --resume continues"},
};

ExitCode ExitCodeFor(ErrorKind kind);

}  // namespace raygraph::cli
