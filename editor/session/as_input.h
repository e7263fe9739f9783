// Reading what a user named.
#pragma once

#include "base/error.h"

namespace raygraph::session {

// Runs `read`, which reads a file that the user named: one that cannot be read is bad input, not a failed
// output, so Error{Io} becomes Error{BadInput}.
template <typename Read>
auto AsInput(Read&& read) {
    try {
        return read();
    } catch (const Error& error) {
        if (error.Kind() != ErrorKind::Io) throw;
        throw Error(ErrorKind::BadInput, error.what());
    }
}

}  // namespace raygraph::session
