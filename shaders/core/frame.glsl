// Orthonormal frames. In the local frame of a surface the normal is +z.
#ifndef RAYGRAPH_CORE_FRAME_GLSL
#define RAYGRAPH_CORE_FRAME_GLSL

#include "core/glue.h"

SHADING_BEGIN

// x, y, z are of unit length, orthogonal and right-handed: cross(x, y) = z.
struct Frame {
    vec3 x;
    vec3 y;
    vec3 z;
};

// The frame about a unit vector; continuous except where z.z changes sign. Duff et al. 2017, "Building an
// Orthonormal Basis, Revisited", JCGT 6(1). No special case: 1 + |z.z| is at least 1.
INLINE Frame FrameFromZ(vec3 z) {
    float s = z.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + z.z);
    float b = z.x * z.y * a;
    Frame frame;
    frame.x = vec3(1.0f + s * z.x * z.x * a, s * b, -s * z.x);
    frame.y = vec3(b, s + z.y * z.y * a, -z.y);
    frame.z = z;
    return frame;
}

// Returns a frame whose x axis is as near as possible to a direction, of any length; FrameFromZ(z) where that
// direction has no component in the plane.
INLINE Frame FrameFromZX(vec3 z, vec3 x) {
    vec3 along = x - dot(x, z) * z;
    float square = dot(along, along);
    if (!(square > 1e-10f * dot(x, x))) return FrameFromZ(z);
    Frame frame;
    frame.x = along * inversesqrt(square);
    frame.y = cross(z, frame.x);
    frame.z = z;
    return frame;
}

INLINE vec3 ToLocal(Frame frame, vec3 v) { return vec3(dot(v, frame.x), dot(v, frame.y), dot(v, frame.z)); }

INLINE vec3 FromLocal(Frame frame, vec3 v) { return v.x * frame.x + v.y * frame.y + v.z * frame.z; }

SHADING_END

#endif
