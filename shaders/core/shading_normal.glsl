// Shading normals that no viewer can see the back of.
#ifndef RAYGRAPH_CORE_SHADING_NORMAL_GLSL
#define RAYGRAPH_CORE_SHADING_NORMAL_GLSL

#include "core/glue.h"

SHADING_BEGIN

// A shading normal bent as little as it takes for wo to be above it and for the mirror direction of wo about
// it to be above the surface; else a mirror or a normal map would reflect the inside of the body, which is
// black. ng and wo are on one side; all directions of unit length. After Keller, Waechter, Raab et al. 2017,
// "The Iray Light Transport Simulation and Rendering System", section A.3.
INLINE vec3 AdaptShadingNormal(vec3 ns, vec3 ng, vec3 wo) {
    // The least height of the mirror direction; a grazing viewer's own height, so that ng itself is legal
    float least = min(0.9f * dot(wo, ng), 0.01f);
    vec3 mirrored = 2.0f * dot(ns, wo) * ns - wo;
    float height = dot(mirrored, ng);
    if (dot(ns, wo) > 0.0f && height >= least) return ns;
    if (dot(ns, wo) <= 0.0f) {  // first to the viewer's side, keeping what can be kept of its tilt
        vec3 tangential = ns - dot(ns, wo) * wo;
        mirrored = tangential;
        height = dot(mirrored, ng);
    }
    mirrored += (max(least, height) - height) * ng;
    float square = dot(mirrored, mirrored);
    if (!(square > 0.0f)) return ng;
    vec3 halfway = wo + mirrored * inversesqrt(square);
    float halfwaySquare = dot(halfway, halfway);
    return halfwaySquare > 0.0f ? halfway * inversesqrt(halfwaySquare) : ng;
}

SHADING_END

#endif
