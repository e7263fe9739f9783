// What the program's exit status says.
#pragma once

#include "base/error.h"

namespace raygraph::cli {

enum class ExitCode : int {
    Done = 0,
    Failure = 1,        // an output that cannot be written, a failed Vulkan call, a validation message
    Usage = 2,          // the command line asks for something that cannot be
    NoDevice = 3,       // no device meets the requirements
    BadInput = 4,       // a scene, picture or render that cannot be read, is malformed or does not fit
    DeviceFailure = 5,  // device lost, or memory spent
    Slower = 6,         // bench --compare: a cost has risen by more than the tolerance
};

ExitCode ExitCodeFor(ErrorKind kind);

}  // namespace raygraph::cli
