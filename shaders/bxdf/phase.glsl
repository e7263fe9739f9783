// Directions in which a medium scatters light, and what a body of it looks like from outside.
#ifndef RAYGRAPH_BXDF_PHASE_GLSL
#define RAYGRAPH_BXDF_PHASE_GLSL

#include "core/math.glsl"
#include "scene/ray.glsl"

SHADING_BEGIN

// Returns the phase function of Henyey and Greenstein 1941, "Diffuse Radiation in the Galaxy": the density
// per solid angle of a scattered direction. `cosTheta` is 1 where light goes straight on; g is its mean.
INLINE float PhaseHG(float g, float cosTheta) {
    float square = Sqr(1.0f - g) + 2.0f * g * (1.0f - cosTheta);  // 1 + g^2 - 2 g cos, without cancellation
    return kInv4Pi * (1.0f - g * g) / (square * sqrt(square));
}

// Returns a direction by that density, where light comes along +z.
INLINE vec3 SamplePhaseHG(float g, vec2 u) {
    float z = 1.0f - 2.0f * u.x;
    // This inverts the cumulated density; near g = 0 it is 0 / 0, and the density constant to 0.3 %
    if (abs(g) > 1e-3f) {
        float s = (1.0f - g * g) / (1.0f + g - 2.0f * g * u.x);
        z = clamp((1.0f + g * g - s * s) / (2.0f * g), -1.0f, 1.0f);
    }
    float r = SafeSqrt(1.0f - z * z);
    vec2 turn = CosSinTurn(u.y);
    return vec3(r * turn.x, r * turn.y, z);
}

// Returns approximately the share of light from all sides that a half space of the medium returns: van de
// Hulst 1980, "Multiple Light Scattering".
INLINE vec3 MultiscatterColor(Medium medium) {
    vec3 color = vec3(0.0f);
    for (int i = 0; i < 3; ++i) {
        float albedo = medium.scattering[i] / max(medium.extinction[i], 1e-20f);
        float s = SafeSqrt((1.0f - albedo) / (1.0f - medium.anisotropy * albedo));
        color[i] = max((1.0f - s) * (1.0f - 0.139f * s) / (1.0f + 1.17f * s), 0.0f);
    }
    return color;
}

SHADING_END

#endif
