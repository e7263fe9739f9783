// The only place where GLSL and C++ differ. Sources under core/, bxdf/, lights/ and integrator/ are compiled
// twice: by glslang as GLSL 4.60 for the device, and by the tests as C++20 with glm, so that the tested code
// is the code that runs. So is what a path needs of scene/ and pathtrace/, for explained paths on the host.
//
// The subset, and why:
//   - literals carry their suffix (1.0f, 1u): C++ would compute in double or in int;
//   - no swizzles (v.x only), no arrays as values: glm here has neither;
//   - no implicit conversions: float(i), uint(i), int(x), written out; vec3(s) where a vector is meant;
//   - structs have no constructors: declare, then assign each field by name;
//   - functions are INLINE, constants CONST, parameters by value or INOUT(T) / OUT(T);
//   - unsigned arithmetic wraps in both languages; signed overflow is undefined in C++, so there is none;
//   - a file starts with its #includes (paths from shaders/), then SHADING_BEGIN ... SHADING_END;
//   - a variable of one invocation is PRIVATE: of a thread in C++;
//   - an address in a record has the type Address; a buffer reference is a type of the bridge, in C++ a class
//     with a member `at`; CHANNELS_OF(v, xyz) is v.xyz where a macro chooses the channels;
//   - bindings, specialization constants and extensions stay behind #ifndef __cplusplus.
//
// DONT_UNROLL precedes a loop whose purpose is to have its body compiled once. The shader that includes this
// file enables GL_GOOGLE_include_directive and GL_EXT_control_flow_attributes. `sampler` is a keyword of
// GLSL: variables of type Sampler are called `rng`.
#ifndef RAYGRAPH_CORE_GLUE_H
#define RAYGRAPH_CORE_GLUE_H

#ifdef __cplusplus

#include <cstdint>
#include <glm/glm.hpp>

#define INOUT(T) T&
#define OUT(T)   T&
#define CONST    inline constexpr
#define INLINE   static inline  // the bridge functions that they call differ between translation units
#define PRIVATE  static thread_local
#define DONT_UNROLL
#define CHANNELS_OF(v, channels) Channels_##channels(v)

#define SHADING_BEGIN namespace raygraph::shading {
#define SHADING_END   }

namespace raygraph::shading {

using Address = uint64_t;

using glm::mat3;
using glm::mat3x2;
using glm::mat4x3;
using glm::uint;
using glm::uvec2;
using glm::uvec3;
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

INLINE float Channels_x(vec4 v) {
    return v.x;
}
INLINE float Channels_y(vec4 v) {
    return v.y;
}
INLINE float Channels_w(vec4 v) {
    return v.w;
}
INLINE vec3 Channels_xyz(vec4 v) {
    return vec3(v);
}

}  // namespace raygraph::shading

#else

#define INOUT(T) inout T
#define OUT(T)   out T
#define CONST    const
#define INLINE
#define PRIVATE
#define DONT_UNROLL              [[dont_unroll]]
#define CHANNELS_OF(v, channels) (v).channels

#define Address uvec2

#define SHADING_BEGIN
#define SHADING_END

#endif

#endif
