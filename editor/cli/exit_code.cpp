#include "editor/cli/exit_code.h"

namespace raygraph::cli {

ExitCode ExitCodeFor(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::Usage:
            return ExitCode::Usage;
        case ErrorKind::BadInput:
            return ExitCode::BadInput;
        case ErrorKind::NoDevice:
            return ExitCode::NoDevice;
        case ErrorKind::OutOfMemory:
        case ErrorKind::DeviceLost:
            return ExitCode::DeviceFailure;
        case ErrorKind::Io:
        case ErrorKind::Vulkan:
            return ExitCode::Failure;
    }
    return ExitCode::Failure;
}

}  // namespace raygraph::cli
