// The members of a push-constant block, for programs that fill one by name. Threads: a pure function.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/api.h"
#include "rhi/reflection.h"

namespace raygraph::rhi {

struct BlockMember {
    std::string name;
    uint32_t offset = 0;  // bytes
    ConstantType type = ConstantType::Float;
    uint32_t count = 0;  // components of a scalar or vector; 0: it is something else
};

// Returns the members of the module's push-constant block in order; none if it has no block.
RAYGRAPH_API std::vector<BlockMember> PushConstantMembers(std::span<const uint32_t> spirv);

}  // namespace raygraph::rhi
