// What the program's exit status says.
#pragma once

#include <string>

#include "base/error.h"
#include "shaders/shared/choice.h"

namespace raygraph::cli {

//   Failure:       an output that cannot be written, a failed Vulkan call, a validation message
//   Usage:         the command line asks for something that cannot be
//   NoDevice:      no device meets the requirements
//   BadInput:      a scene, picture or render that cannot be read, is malformed or does not fit
//   Slower:        a cost has risen by more than the tolerance
#define RAYGRAPH_EXIT_CODES(X, Of)                              \
    X(Of, Done, 0, "done", "")                                  \
    X(Of, Failure, 1, "failure", "")                            \
    X(Of, Usage, 2, "usage", "")                                \
    X(Of, NoDevice, 3, "no suitable device", "")                \
    X(Of, BadInput, 4, "bad input", "")                         \
    X(Of, DeviceFailure, 5, "device lost or out of memory", "") \
    X(Of, Slower, 6, "slower than the stored run (bench --compare)", "")
RAYGRAPH_CHOICE(ExitCode, RAYGRAPH_EXIT_CODES)

ExitCode ExitCodeFor(ErrorKind kind);
// "0 done, 1 failure, ...": all of them.
std::string ListOfExitCodes();

}  // namespace raygraph::cli
