// RasterShade: light that what was drawn sends to the camera: its own, and what it scatters of the lights, by
// the path tracer's own material, BSDF and lights, without shadows.
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

#include "raster/environment_lobes.glsl"

layout(set = 0, binding = 16, rgba32f) writeonly uniform image2D radiance;

const uint kCameraDimensions = 4u;  // of integrator/path.glsl

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

// Light from one point of one emitting triangle, chosen by the light tree with the numbers that Trace takes
// for its first bounce. None where a punctual light is drawn: those are added whole.
LightSample SampleEmitter(SurfaceInteraction surface, uint bsdfFlags, Sampler rng) {
    LightContext context;
    context.position = surface.position;
    context.normal = IsTransmissive(bsdfFlags) ? vec3(0.0f) : surface.geometricNormal;
    rng.dimension = kCameraDimensions;
    float choice = Get1D(rng);
    vec2 u = Get2D(rng);
    if (LightSet().nodeCount == 0u) return NoLightSample();
    ChosenLight chosen = SampleLightTree(context, choice);
    if (!(chosen.probability > 0.0f)) return NoLightSample();
    LightRecord light = LightAt(chosen.light);
    if (light.kind != kLightTriangle) return NoLightSample();
    LightSample result = SampleTriangle(light, context, u);
    result.pdf *= chosen.probability;
    return result;
}

// What a surface scatters towards wo of all punctual lights, and of one point of the emitting triangles.
vec3 ScatteredLight(SurfaceInteraction surface, Frame frame, SurfaceBSDF bsdf, Sampler rng) {
    vec3 sum = vec3(0.0f);
    if (!IsNonSpecular(bsdf.flags)) return sum;
    LightContext context;
    context.position = surface.position;
    context.normal = vec3(0.0f);
    uint first = LightSet().lightCount - constants.punctualLights;
    uint count = constants.punctualLights + (HasTraceFeature(kTraceTriangleLights) ? 1u : 0u);
    DONT_UNROLL
    for (uint i = 0u; i < count; i++) {
        LightSample light;
        if (i < constants.punctualLights)
            light = SamplePunctual(LightAt(first + i), context);
        else
            light = SampleEmitter(surface, bsdf.flags, rng);
        vec3 wi = ToLocal(frame, light.wi);
        bool isLeaking = dot(light.wi, surface.geometricNormal) * wi.z <= 0.0f;  // of the shading normal
        if (isLeaking || !(light.pdf > 0.0f)) continue;
        float pdf = 0.0f;
        vec3 diffuse = vec3(0.0f);
        sum += Evaluate(bsdf, wi, pdf, diffuse) * light.radiance * (abs(wi.z) / light.pdf);
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
    vec3 scattered = ScatteredLight(surface, frame, bsdf, rng);
    if (HasTraceFeature(kTraceEnvironmentLight))
        scattered += ScatteredEnvironment(bsdf, surface.material.roughness, frame);
    return vec4(surface.emission + scattered, 1.0f);
}

void main() {
    if (IsInPicture()) imageStore(radiance, Pixel(), Shade(PixelHit(), PixelRay()));
}
