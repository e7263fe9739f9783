// Scattering in a homogeneous medium (KHR_materials_volume_scatter): how far light goes until it is
// scattered. In which direction it goes on: bxdf/phase.glsl.
//
// Bridge: MediumAt, see integrator/media.glsl.
#ifndef RAYGRAPH_INTEGRATOR_SCATTERING_GLSL
#define RAYGRAPH_INTEGRATOR_SCATTERING_GLSL

#include "bxdf/phase.glsl"
#include "core/math.glsl"
#include "integrator/media.glsl"

SHADING_BEGIN

INLINE bool IsScattering(uint material) {
    return material != kVacuum && MaxComponent(MediumAt(material).scattering) > 0.0f;
}

// Describes light on its way through a medium, up to a surface.
struct FreeFlight {
    bool isScattered;  // before it gets there
    float distance;    // where
    vec3 weight;       // the share of it that does, over the density with which that was drawn
};

// Draws one by the extinction of a color, which `uc` chooses with the shares of `throughput`; `u` draws the
// distance. The density is that of all colors together, so that no color's weight is large: the balance
// heuristic of Veach 1997, chapter 9, over colors.
INLINE FreeFlight SampleFreeFlight(Medium medium, vec3 throughput, float limit, float uc, float u) {
    float sum = throughput.x + throughput.y + throughput.z;
    vec3 share = sum > 0.0f ? throughput / sum : vec3(1.0f / 3.0f);
    float extinction = medium.extinction.z;
    if (uc < share.x)
        extinction = medium.extinction.x;
    else if (uc < share.x + share.y)
        extinction = medium.extinction.y;
    FreeFlight flight;
    flight.distance = extinction > 0.0f ? -0.693147180559945f * log2(1.0f - u) / extinction : kFarInMedium;
    flight.isScattered = flight.distance < min(limit, kFarInMedium);
    if (!flight.isScattered) flight.distance = limit;
    vec3 passed = Transmittance(medium, flight.distance);
    vec3 density = flight.isScattered ? medium.extinction * passed : passed;
    flight.weight = (flight.isScattered ? medium.scattering * passed : passed) / dot(share, density);
    return flight;
}

SHADING_END

#endif
