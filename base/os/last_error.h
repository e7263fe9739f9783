// The reason for which a call of the system, or of the C library, has just failed. Threads: any.
#pragma once

#include <cerrno>
#include <system_error>

namespace raygraph::os {

// An input/output error where the call has left no reason, as stdio may.
inline std::error_code LastError() {
    return {errno != 0 ? errno : EIO, std::generic_category()};
}

}  // namespace raygraph::os
