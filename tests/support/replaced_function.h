// For loaders that answer vkGet*ProcAddr with functions of their own in place of the driver's.
#pragma once

#include "rhi/vulkan.h"

namespace raygraph::testing {

// What to answer when `real` is asked for: `replacement`, which finds `real` in `kept`. Null stays null.
template <typename Function>
PFN_vkVoidFunction Replaced(PFN_vkVoidFunction real, Function& kept, Function replacement) {
    if (!real) return nullptr;
    kept = reinterpret_cast<Function>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(replacement);
}

}  // namespace raygraph::testing
