// Helps loaders whose vkGet*ProcAddr replaces functions of the driver.
#pragma once

#include "rhi/vulkan.h"

namespace raygraph::testing {

// Returns `replacement` for `real`, which it stores in `kept` for the replacement to call. Null stays null.
template <typename Function>
PFN_vkVoidFunction Replaced(PFN_vkVoidFunction real, Function& kept, Function replacement) {
    if (!real) return nullptr;
    kept = reinterpret_cast<Function>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(replacement);
}

}  // namespace raygraph::testing
