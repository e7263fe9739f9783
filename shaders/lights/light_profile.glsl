// Intensities by direction, of lights with a profile (renderer/scene/model/light_profile.h), by bilinear
// interpolation in the two angles of its web. In the buffer a profile is: its type (kProfileType*), the
// numbers of vertical and horizontal angles, these angles, and the intensities of one plane after another.
//
// The bridge, declared by the includer: float LightProfileAt(uint word).
#ifndef RAYGRAPH_LIGHTS_LIGHT_PROFILE_GLSL
#define RAYGRAPH_LIGHTS_LIGHT_PROFILE_GLSL

#include "lights/light_types.glsl"

SHADING_BEGIN

// Returns the interval of increasing angles that holds one between the first and the last: the lower end's
// number.
INLINE uint ProfileInterval(uint first, uint count, float angle) {
    uint low = 0u;
    uint high = count - 1u;
    while (high - low > 1u) {
        uint middle = (low + high) >> 1u;
        if (LightProfileAt(first + middle) <= angle)
            low = middle;
        else
            high = middle;
    }
    return low;
}

// Returns the intensity in one plane of the web; `word` is the one at the lower end.
INLINE float PlaneIntensity(uint word, float share) {
    return mix(LightProfileAt(word), LightProfileAt(word + 1u), share);
}

INLINE float ShareOf(float angle, float low, float high) {
    return clamp((angle - low) / (high - low), 0.0f, 1.0f);
}

// d is of unit length, in the light's space.
INLINE float ProfileIntensity(uint profile, vec3 d) {
    uint type = uint(LightProfileAt(profile));
    uint verticalCount = uint(LightProfileAt(profile + 1u));
    uint horizontalCount = uint(LightProfileAt(profile + 2u));
    uint verticals = profile + 3u;
    uint horizontals = verticals + verticalCount;
    uint planes = horizontals + horizontalCount;

    // Arcs by atan of two sides, which is exact near the poles
    float vertical = atan(sqrt(d.x * d.x + d.y * d.y), -d.z);
    float horizontal = atan(d.y, d.x);
    if (type == kProfileTypeB) {
        vertical = atan(d.x, -d.z);
        horizontal = atan(-d.y, sqrt(d.x * d.x + d.z * d.z));
    } else if (type == kProfileTypeA) {
        vertical = atan(d.x, sqrt(d.y * d.y + d.z * d.z));
        horizontal = atan(-d.y, -d.z);
    }
    if (vertical < LightProfileAt(verticals) || vertical > LightProfileAt(horizontals - 1u)) return 0.0f;
    uint v = ProfileInterval(verticals, verticalCount, vertical);
    float vShare = ShareOf(vertical, LightProfileAt(verticals + v), LightProfileAt(verticals + v + 1u));
    if (horizontalCount == 1u) return PlaneIntensity(planes + v, vShare);

    float first = LightProfileAt(horizontals);
    if (type == kProfileTypeC)
        horizontal = first + kTwoPi * fract((horizontal - first) * kInv2Pi);
    else if (horizontal < first || horizontal > LightProfileAt(planes - 1u))
        return 0.0f;
    uint h = ProfileInterval(horizontals, horizontalCount, horizontal);
    float hShare =
        ShareOf(horizontal, LightProfileAt(horizontals + h), LightProfileAt(horizontals + h + 1u));
    uint plane = planes + h * verticalCount + v;
    return mix(PlaneIntensity(plane, vShare), PlaneIntensity(plane + verticalCount, vShare), hShare);
}

// Returns the intensity of a light with a profile, in a unit direction of the world.
INLINE float LightProfileIntensity(LightRecord light, vec3 direction) {
    // The direction is turned by the quaternion (e1, spotScale)
    vec3 across = cross(light.e1, direction) + light.spotScale * direction;
    vec3 d = direction + 2.0f * cross(light.e1, across);
    if ((light.flags & kLightMirrored) != 0u) d.y = -d.y;
    return ProfileIntensity(light.primitive, d);
}

SHADING_END

#endif
