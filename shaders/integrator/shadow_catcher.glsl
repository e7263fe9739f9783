// The shadow catcher: a horizontal diffuse surface, of which the camera sees only the shadow. Where it is the
// first surface of a path, the sample is black, and its alpha is the share of the surface's radiance that the
// other surfaces take away,
//
//     1 - L / L0,  L0 = albedo / pi * (irradiance of the environment and of all punctual lights, unoccluded),
//
// in luminance, where L is all light that the surface reflects. Where other surfaces send it more than they
// take, alpha is negative. Its mean over samples is unbiased: L0 is exact, and L - L0 is estimated by
// subtracting the light that each sample would have found without other surfaces. Where nothing is in the
// way, the two cancel, and there is no noise. In mirrors, behind glass and for all other paths the surface is
// as any other. Light of emissive surfaces is no part of L0.
//
// While the path is traced, its alpha is -L0.
#ifndef RAYGRAPH_INTEGRATOR_SHADOW_CATCHER_GLSL
#define RAYGRAPH_INTEGRATOR_SHADOW_CATCHER_GLSL

#include "core/color.glsl"
#include "integrator/direct_light.glsl"
#include "integrator/path_state.glsl"
#include "lights/lights.glsl"

SHADING_BEGIN

INLINE bool IsCaught(PathState path) { return HasTraceFeature(kTraceShadowCatcher) && path.alpha < 0.0f; }

// Notes that the path has met what hides the backdrop.
INLINE void Cover(INOUT(PathState) path) {
    if (!IsCaught(path)) path.alpha = 1.0f;
}

// Returns whether the path shows the shadow on the surface.
INLINE bool IsCatcher(PathState path, SurfaceInteraction surface) {
    return HasTraceFeature(kTraceShadowCatcher) && path.alpha == 0.0f && path.depth == 0u &&
           (surface.material.flags & kMaterialShadowCatcher) != 0u;
}

// Returns the luminance, W/m^2, of the light of environment and punctual lights on a surface there that faces
// +y.
INLINE float UnoccludedIrradiance(vec3 position) {
    LightSetRecord lights = LightSet();
    float irradiance = lights.skyIrradiance;
    LightContext context;
    context.position = position;
    context.normal = vec3(0.0f, 1.0f, 0.0f);
    if (HasTraceFeature(kTracePunctualLights)) {
        for (uint i = lights.firstPunctual; i < lights.lightCount; ++i) {
            LightSample light = SamplePunctual(LightAt(i), context);
            irradiance += Luminance(light.radiance) * max(light.wi.y, 0.0f);
        }
    }
    return irradiance;
}

// Begins a sample of the shadow. False: no light has a shadow there, and the sample is transparent.
INLINE bool Catch(INOUT(PathState) path, SurfaceInteraction surface) {
    float reflectance = Luminance(surface.material.baseColor);
    path.alpha = -reflectance * (1.0f / kPi) * UnoccludedIrradiance(surface.position);
    return IsCaught(path);
}

// Subtracts the light that the path has begun to sample at the catcher, as if there were no other surface.
INLINE void SubtractUnoccluded(INOUT(PathState) path, DirectLight direct, bool isAlive) {
    LightSetRecord lights = LightSet();
    // The environment has the number after the punctual lights
    if (MaxComponent(direct.radiance) > 0.0f && direct.light >= lights.firstPunctual)
        path.radiance -= direct.radiance;
    if (!isAlive) return;
    float lightPDF = 0.0f;
    if (HasTraceFeature(kTraceLightSampling))
        lightPDF = LightPDF(path.scatter, lights.lightCount, 0u, path.ray.direction, kInfinity);
    path.radiance -= path.throughput * EnvironmentRadiance(path.ray.direction) *
                     ScatterWeight(path.scatterPDF, lightPDF);
}

// Makes the radiance of a path that has ended its sample.
INLINE void FinishCaught(INOUT(PathState) path) {
    path.alpha = Luminance(path.radiance) / path.alpha;
    path.radiance = vec3(0.0f);
    if (kKeepsParts) path.parts = NoParts();
}

SHADING_END

#endif
