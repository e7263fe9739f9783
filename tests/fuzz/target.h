// A fuzzing target is a function that takes any bytes as a file or a text of a user. It may end in the
// promised value or in raygraph::Error. Anything else is a finding: another exception, a crash, a broken
// promise, a report of a sanitizer. Threads: one; targets keep folders and buffers between calls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace raygraph::fuzz {

using Bytes = std::vector<std::byte>;
using Input = std::span<const std::byte>;

// Reports a broken promise.
class Finding : public std::logic_error {
  public:
    using std::logic_error::logic_error;
};

struct Target {
    const char* name;
    void (*run)(Input input);  // throws Finding
    size_t maxBytes;           // longer inputs are not tried
    // Repairs lengths and checksums of a mutated file, so that the code after them is reached; nullptr: there
    // are none.
    void (*repair)(Bytes& file) = nullptr;
    bool isSlow = false;  // writes files and waits for them, so the suite tries fewer inputs
};

// Returns all targets.
std::span<const Target> Targets();
// Returns nullptr if there is no such target.
const Target* FindTarget(std::string_view name);

// Target functions.
void RunGltfText(Input input);
void RunGltfContainer(Input input);
void RunGltfAccessors(Input input);
void RunGltfCompressed(Input input);
void RunGltfSave(Input input);
void RunImages(Input input);
void RunEnvironment(Input input);
void RunProfiles(Input input);
void RunRenderFile(Input input);
void RunSettings(Input input);
void RunTexts(Input input);
void RunScripts(Input input);
void RunGraphFiles(Input input);
// Repair functions.
void RepairGlb(Bytes& file);
void RepairPng(Bytes& file);

// Throws Finding unless `holds`.
void Require(bool holds, const std::string& promise);

// Runs `read`. Returns false if it throws an Error of one of the `kinds`, whose message must be one line of
// readable length that begins with `subject`.
bool Succeeds(std::string_view subject, std::initializer_list<ErrorKind> kinds,
              const std::function<void()>& read);

inline std::string_view AsText(Input input) {
    return {reinterpret_cast<const char*>(input.data()), input.size()};
}
inline Input AsInput(std::string_view text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

}  // namespace raygraph::fuzz
