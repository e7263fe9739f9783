// What is fuzzed: functions that take any bytes as a file or a text of a user, and may end in the value they
// promise or in raygraph::Error. Anything else is a finding: another exception, a crash, a broken promise, a
// report of a sanitizer. Threads: one; targets keep folders and buffers between calls.
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

// A promise that was broken.
class Finding : public std::logic_error {
  public:
    using std::logic_error::logic_error;
};

struct Target {
    const char* name;
    void (*run)(Input input);  // Throws Finding.
    size_t maxBytes;           // Longer inputs are not tried.
    // Makes lengths and checksums of a changed file right, so that what lies behind them is reached; nullptr:
    // it has none.
    void (*repair)(Bytes& file) = nullptr;
    bool isSlow = false;  // Writes files, which are waited for: the suite tries fewer inputs.
};

// All of them.
std::span<const Target> Targets();
// nullptr if there is none.
const Target* FindTarget(std::string_view name);

// The targets.
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
// Their repairs.
void RepairGlb(Bytes& file);
void RepairPng(Bytes& file);

// Throws Finding unless it holds.
void Require(bool holds, const std::string& promise);

// Runs `read`. False if it ended in an Error of one of the `kinds`, whose message is one line of readable
// length and begins with `subject`.
bool Succeeds(std::string_view subject, std::initializer_list<ErrorKind> kinds,
              const std::function<void()>& read);

inline std::string_view AsText(Input input) {
    return {reinterpret_cast<const char*>(input.data()), input.size()};
}
inline Input AsInput(std::string_view text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

}  // namespace raygraph::fuzz
