// Converts std::bad_alloc: the standard library's exceptions for exhausted memory leave as an Error.
//
// Functions that allocate by the size of their input run within it, so that a host catches one type and can
// free something. Threads: any.
#pragma once

#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.h"

namespace raygraph {

// Returns what `run` returns. std::bad_alloc and std::length_error become Error{OutOfMemory}, in which
// `subject` names the object or the call. All other exceptions pass through.
template <typename Run>
decltype(auto) WithMemoryErrors(std::string_view subject, Run&& run) {
    try {
        return std::forward<Run>(run)();
    } catch (const std::bad_alloc&) {
        throw Error(ErrorKind::OutOfMemory, std::string(subject) + ": host memory is exhausted");
    } catch (const std::length_error&) {
        throw Error(ErrorKind::OutOfMemory,
                    std::string(subject) + ": asks for more memory than a process can have");
    }
}

}  // namespace raygraph
