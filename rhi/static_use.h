// Finds the resources that the entry point of a SPIR-V module uses statically: those that any function which
// it calls names, in any branch. Reads the module once, while SPIRV-Cross reads a function again for each
// call of it. Threads: pure functions. For rhi/ alone.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <unordered_set>

namespace raygraph::rhi {

struct UsedVariable {
    bool isWhole = false;                  // more than single members are used
    std::unordered_set<uint32_t> members;  // numbers of the used members of a block
    bool Uses(uint32_t member) const { return isWhole || members.contains(member); }
};

// Returns the used variables outside of functions, by id, for the first entry point. The words must be those
// of a module that has been parsed.
std::unordered_map<uint32_t, UsedVariable> StaticUse(std::span<const uint32_t> spirv);

}  // namespace raygraph::rhi
