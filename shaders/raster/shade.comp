// RasterShade: light that what was drawn sends to the camera: its own, and what it scatters of the punctual
// lights, by the path tracer's own material, BSDF and lights, without shadows.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/pixel.glsl"
#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"
#include "scene/surface.glsl"

#include "bxdf/bsdf.glsl"
#include "core/frame.glsl"
#include "core/rng.glsl"
#include "lights/lights.glsl"

layout(set = 0, binding = 16, rgba32f) writeonly uniform image2D radiance;

// As seen from vacuum.
SurfaceSetting SettingOf(SurfaceInteraction surface, uint seed) {
    bool isVolume = (surface.material.flags & kMaterialVolume) != 0u;
    SurfaceSetting setting;
    setting.eta = isVolume && !surface.isFront ? 1.0f / surface.material.ior : surface.material.ior;
    setting.isThin = !isVolume;
    setting.leastAlpha = 0.0f;
    setting.seed = seed;
    return setting;
}

// What a surface scatters towards wo of all punctual lights.
vec3 ScatteredPunctual(SurfaceInteraction surface, Frame frame, SurfaceBSDF bsdf) {
    vec3 sum = vec3(0.0f);
    if (!IsNonSpecular(bsdf.flags)) return sum;
    LightContext context;
    context.position = surface.position;
    context.normal = vec3(0.0f);
    LightSetRecord set = LightSet();
    DONT_UNROLL
    for (uint light = set.lightCount - constants.punctualLights; light < set.lightCount; light++) {
        LightSample arriving = SamplePunctual(LightAt(light), context);
        vec3 wi = ToLocal(frame, arriving.wi);
        if (dot(arriving.wi, surface.geometricNormal) * wi.z <= 0.0f) continue;  // the shading normal leaks
        float pdf = 0.0f;
        vec3 diffuse = vec3(0.0f);
        sum += Evaluate(bsdf, wi, pdf, diffuse) * (abs(wi.z) * arriving.radiance);
    }
    return sum;
}

vec4 Shade(Hit hit, Ray ray) {
    if (!IsHit(hit)) return vec4(EnvironmentRadiance(ray.direction), 0.0f);
    SurfaceInteraction surface = SurfaceAt(hit, ray);
    if ((surface.material.flags & kMaterialUnlit) != 0u) return vec4(surface.emission, 1.0f);
    Sampler rng = StartPixelSample(uvec2(Pixel()), parameters.value.sampleIndex, parameters.value.seed);
    Frame frame = FrameFromZ(surface.shadingNormal);
    SurfaceBSDF bsdf =
        BSDFOf(surface.material, ToLocal(frame, -ray.direction), SettingOf(surface, AlphaSeed(rng, 1u)));
    return vec4(surface.emission + ScatteredPunctual(surface, frame, bsdf), 1.0f);
}

void main() {
    if (IsInPicture()) imageStore(radiance, Pixel(), Shade(PixelHit(), PixelRay()));
}
