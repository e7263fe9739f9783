// SPIR-V made for given values of its specialization constants, without the code that they switch off.
//
// A driver may inline every function before it looks at the constants: code that is off then costs as much
// time to compile as code that runs. On Mesa's CPU driver that is most of the time to a first picture;
// NVIDIA's compiles the wavefront's shaders in 0.4 of the time without that code.
// Stands on SPIRV-Tools; where the library was built without it, nothing is specialized here and the driver
// does it all. For rhi/ alone. Threads: pure functions, for any.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rhi/shader_stage.h"

namespace raygraph::rhi {

// Identifies the specializer: the versions of SPIRV-Tools and of this code. Empty without SPIRV-Tools.
std::string SpecializerVersion();

// Returns those of `values` that the module has a constant for, in the order of its declarations.
std::vector<SpecializationValue> ValuesOf(std::span<const uint32_t> spirv,
                                          std::span<const SpecializationValue> values);

// The module with constants in place of its specialization constants: those of `values`, otherwise the
// defaults. Branches that they decide, functions that are no longer called and names are gone; what is bound
// and what is computed is as before. Empty: without SPIRV-Tools, or if it cannot read the module.
std::vector<uint32_t> SpecializeSpirv(std::span<const uint32_t> spirv,
                                      std::span<const SpecializationValue> values);

}  // namespace raygraph::rhi
