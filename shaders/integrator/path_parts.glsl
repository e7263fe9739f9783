// The radiance of a path in parts: by how often its light was scattered, and by the lobe that scattered it
// first (on the way from the camera). Only in includers of path.glsl that define PATH_PARTS; it costs the
// others nothing.
//
// Where a diffuse lobe and one of the facets scatter light in the same direction, each gets its share of f
// there. That is exact for light that was sampled, and for a direction that was drawn from any of the lobes:
// f is the sum of both, and the density that it is divided by is of both.
#ifndef RAYGRAPH_INTEGRATOR_PATH_PARTS_GLSL
#define RAYGRAPH_INTEGRATOR_PATH_PARTS_GLSL

#include "core/math.glsl"

SHADING_BEGIN

#ifdef PATH_PARTS
CONST bool kKeepsParts = true;
#else
CONST bool kKeepsParts = false;
#endif

// emission + direct + indirect is the radiance, and emission + diffuse + specular + transmission is too.
struct PathParts {
    vec3 emission;      // never scattered
    vec3 direct;        // scattered once
    vec3 indirect;      // scattered more often
    vec3 diffuse;       // reflected first by a diffuse lobe
    vec3 specular;      // ... by facets, smooth or rough
    vec3 transmission;  // transmitted first, by any lobe
};

// Holds the lobe of the first surface.
struct FirstLobe {
    vec3 diffuse;      // the diffuse lobe's share; the rest is the facets'
    bool isThrough;    // it was transmitted
};

INLINE PathParts NoParts() {
    PathParts parts;
    parts.emission = vec3(0.0f);
    parts.direct = vec3(0.0f);
    parts.indirect = vec3(0.0f);
    parts.diffuse = vec3(0.0f);
    parts.specular = vec3(0.0f);
    parts.transmission = vec3(0.0f);
    return parts;
}

INLINE FirstLobe NoLobe() {
    FirstLobe lobe;
    lobe.diffuse = vec3(0.0f);
    lobe.isThrough = false;
    return lobe;
}

INLINE float ShareOf(float part, float whole) { return whole > 0.0f ? min(part / whole, 1.0f) : 0.0f; }

// `diffuse` is the diffuse lobe's part of f.
INLINE FirstLobe FirstLobeOf(vec3 f, vec3 diffuse, bool isThrough) {
    FirstLobe lobe;
    lobe.diffuse = vec3(ShareOf(diffuse.x, f.x), ShareOf(diffuse.y, f.y), ShareOf(diffuse.z, f.z));
    lobe.isThrough = isThrough;
    return lobe;
}

// Adds light that was scattered `depth` times.
INLINE void AddPart(INOUT(PathParts) parts, vec3 value, uint depth, FirstLobe lobe) {
    if (depth == 0u) {
        parts.emission += value;
        return;
    }
    if (depth == 1u)
        parts.direct += value;
    else
        parts.indirect += value;
    if (lobe.isThrough) {
        parts.transmission += value;
    } else {
        parts.diffuse += value * lobe.diffuse;
        parts.specular += value * (vec3(1.0f) - lobe.diffuse);
    }
}

SHADING_END

#endif
