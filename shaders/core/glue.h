// The only place where GLSL and C++ differ. Sources under core/, bxdf/, lights/ and integrator/ are compiled
// twice: by glslang as GLSL 4.60 for the device, and by the tests as C++20 with glm, so that the tested code
// is the code that runs.
//
// The subset, and why:
//   - literals carry their suffix (1.0f, 1u): C++ would compute in double or in int;
//   - no swizzles (v.x only), no arrays as values: glm here has neither;
//   - no implicit conversions: float(i), uint(i), int(x), written out; vec3(s) where a vector is meant;
//   - structs have no constructors: declare, then assign each field by name;
//   - functions are INLINE, constants CONST, parameters by value or INOUT(T) / OUT(T);
//   - unsigned arithmetic wraps in both languages; signed overflow is undefined in C++, so there is none;
//   - a file starts with its #includes (paths from shaders/), then SHADING_BEGIN ... SHADING_END;
//   - bindings, specialization constants and extensions stay behind #ifndef __cplusplus.
//
// DONT_UNROLL precedes a loop whose purpose is to have its body compiled once. The shader that includes this
// file enables GL_GOOGLE_include_directive and GL_EXT_control_flow_attributes. `sampler` is a keyword of
// GLSL: variables of type Sampler are called `rng`.
#ifndef RAYGRAPH_CORE_GLUE_H
#define RAYGRAPH_CORE_GLUE_H

#ifdef __cplusplus

#include <glm/glm.hpp>

#define INOUT(T) T&
#define OUT(T)   T&
#define CONST    inline constexpr
#define INLINE   static inline  // the bridge functions that they call differ between translation units
#define DONT_UNROLL

#define SHADING_BEGIN namespace raygraph::shading {
#define SHADING_END   }

namespace raygraph::shading {

using glm::mat3;
using glm::mat4x3;
using glm::uint;
using glm::uvec2;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;

using glm::abs;
using glm::acos;
using glm::atan;
using glm::bitfieldReverse;
using glm::clamp;
using glm::cos;
using glm::cross;
using glm::dot;
using glm::exp2;
using glm::floatBitsToUint;
using glm::floor;
using glm::fract;
using glm::inversesqrt;
using glm::length;
using glm::log2;
using glm::max;
using glm::min;
using glm::mix;
using glm::normalize;
using glm::pow;
using glm::sin;
using glm::sqrt;
using glm::uintBitsToFloat;

}  // namespace raygraph::shading

#else

#define INOUT(T) inout T
#define OUT(T)   out T
#define CONST    const
#define INLINE
#define DONT_UNROLL [[dont_unroll]]

#define SHADING_BEGIN
#define SHADING_END

#endif

#endif
