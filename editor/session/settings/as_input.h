// AsInput reads a file that a user named.
#pragma once

#include "base/error.h"

namespace raygraph::session {

// Runs `read` on a file that the user named. If the file cannot be read, the input is bad, and no output has
// failed: Error{Io} becomes Error{BadInput}.
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
