// Specializes SPIR-V for given values of its constants, without the code that they switch off.
//
// A driver may inline every function before it looks at the constants: code that is off then takes as long to
// compile as code that runs. With Mesa's CPU driver, that is most of the time to a first picture; NVIDIA's
// compiles the shaders of the wavefront in 0.4 of the time without that code. This uses SPIRV-Tools; if the
// library was built without it, nothing is specialized here and the driver does all of it. For rhi/ alone.
// Threads: pure functions, for any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rhi/shader_stage.h"

namespace raygraph::rhi {

// Returns the versions of SPIRV-Tools and of this code. Empty without SPIRV-Tools.
std::string SpecializerVersion();

// Returns the values of constants that the module has, in the order of its declarations.
std::vector<SpecializationValue> ValuesOf(std::span<const uint32_t> spirv,
                                          std::span<const SpecializationValue> values);

// Returns the module with constants instead of its specialization constants: `values` where given, otherwise
// the defaults. Branches that they decide, functions that are no longer called, and names are removed;
// bindings and results do not change. Empty without SPIRV-Tools, or if it cannot read the module.
std::vector<uint32_t> SpecializeSpirv(std::span<const uint32_t> spirv,
                                      std::span<const SpecializationValue> values);

}  // namespace raygraph::rhi
