// RasterShade: radiance of the drawn surfaces towards the camera: emission and direct light, by the path
// tracer's own material, BSDF and lights. Variants define SHADOW_MAPS, or SHADOW_RAYS in ray generation.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef SHADOW_RAYS
#define TRACES_SHADOW_RAYS
#define PIXEL_BY_RAY_GENERATION
#else
#define NO_TLAS
#endif
#include "scene/extensions.glsl"

#include "raster/pixel_footprint.glsl"
#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"
#include "scene/surface.glsl"

#include "bxdf/bsdf.glsl"
#include "bxdf/dispersion.glsl"
#include "bxdf/phase.glsl"
#include "core/frame.glsl"
#include "core/rng.glsl"
#include "lights/lights.glsl"
#include "lights/shadow_ray.glsl"
#include "shared/shade_options.h"

#include "raster/environment_lobes.glsl"
#include "raster/see_through.glsl"
#ifdef SHADOW_MAPS
#include "raster/shadow_maps.glsl"
#endif
#ifdef SHADOW_RAYS
#include "scene/trace_rays.glsl"
#endif

layout(set = 0, binding = 16, rgba32f) writeonly uniform image2D radiance;
layout(set = 0, binding = 22) uniform sampler2D ambientVisibility;

// Returns the relative index for a viewer in vacuum.
float EtaOf(SurfaceInteraction surface) {
    bool isVolume = (surface.material.flags & kMaterialVolume) != 0u;
    return isVolume && !surface.isFront ? 1.0f / surface.material.ior : surface.material.ior;
}

// Returns light from one point of one emitting triangle, chosen by the light tree with the random numbers of
// the first bounce of Trace. None where a punctual light is chosen: those are summed exactly.
LightSample SampleEmitter(SurfaceInteraction surface, uint bsdfFlags, Sampler rng) {
    LightContext context;
    context.position = surface.position;
    context.normal = IsTransmissive(bsdfFlags) ? vec3(0.0f) : surface.geometricNormal;
    rng.dimension = kCameraDimensions;
    float choice = Get1D(rng);
    vec2 u = Get2D(rng);
    if (LightSet().nodeCount == 0u) return NoLightSample();
    ChosenLight chosen = SampleLightTree(0u, context, choice);
    if (!(chosen.probability > 0.0f)) return NoLightSample();
    LightRecord light = LightAt(chosen.light);
    uint triangle = 0u;
    float within = ResolveMeshLight(light, context, u, triangle);
    if (light.kind != kLightTriangle || !(within > 0.0f)) return NoLightSample();
    LightSample result = SampleTriangle(light, context, u);
    result.pdf *= chosen.probability * within;
    return result;
}

// Returns the share of a light that reaches the surface. `ordinal` is that of a punctual light, or their
// count.
vec3 LightVisibility(SurfaceInteraction surface, LightSample light, uint ordinal, uint alphaSeed) {
#ifdef SHADOW_RAYS
    float distance = kInfinity;
    Ray ray = ShadowRayTo(surface, light, distance);
    return ShadowTransmittance(ray, distance, 1.0f, alphaSeed);
#else
#ifdef SHADOW_MAPS
    if (ordinal < constants.punctualLights) {
        uint kind = LightAt(LightSet().lightCount - constants.punctualLights + ordinal).kind;
        return vec3(ShadowMapVisibility(ordinal, kind, surface.position, surface.geometricNormal, light.wi));
    }
#endif
    return vec3(1.0f);
#endif
}

// Returns direct light scattered towards wo: of all punctual lights, and of one point of the emitting
// triangles.
vec3 ScatteredLight(SurfaceInteraction surface, Frame frame, SurfaceBSDF bsdf, Sampler rng) {
    vec3 sum = vec3(0.0f);
    if (!IsNonSpecular(bsdf.flags)) return sum;
    LightContext context;
    context.position = surface.position;
    context.normal = vec3(0.0f);
    uint first = LightSet().lightCount - constants.punctualLights;
    uint count = constants.punctualLights + (HasTraceFeature(kTraceTriangleLights) ? 1u : 0u);
    DONT_UNROLL
    for (uint i = 0u; i < count; ++i) {
        LightSample light;
        if (i < constants.punctualLights)
            light = SamplePunctual(LightAt(first + i), context);
        else
            light = SampleEmitter(surface, bsdf.flags, rng);
        vec3 wi = ToLocal(frame, light.wi);
        // The shading normal would leak light
        bool isLeaking = dot(light.wi, surface.geometricNormal) * wi.z <= 0.0f;
        // Lights behind glass are in the picture behind it; what they send through diffusely is not
        bool isSeenThrough =
            i == constants.punctualLights && (constants.option & kShadeBehind) != 0u && wi.z < 0.0f;
        if (isLeaking || !(light.pdf > 0.0f)) continue;
        if (isSeenThrough && !HasTraceFeature(kTraceDiffuseTransmission)) continue;
        float pdf = 0.0f;
        vec3 diffuse = vec3(0.0f);
        vec3 value = Evaluate(bsdf, wi, false, pdf, diffuse);
        if (HasTraceFeature(kTraceDiffuseTransmission) && isSeenThrough) value = diffuse;
        vec3 scattered = value * light.radiance * (abs(wi.z) / light.pdf);
        if (!(MaxComponent(scattered) > 0.0f)) continue;
        sum += scattered * LightVisibility(surface, light, i, AlphaSeed(rng, 2u));
    }
    return sum;
}

// Returns the radiance that a lobe transmits. The picture behind shows what the environment does not.
vec3 RadianceFromBehind(LobeMean lobe, vec3 position, vec3 wi) {
    if (HasTraceFeature(kTraceDiffuseTransmission) && lobe.isDiffuse) return DiffuseEnvironment(wi);
    if ((constants.option & kShadeBehind) != 0u)
        return TransmittedRadiance(position, wi, lobe.slope, lobe.roughness);
    return GlossyEnvironment(wi, lobe.roughness);
}

// Returns light from the other side of the surface: from the picture behind it, or from the environment.
vec3 LightFromBehind(GltfBSDF g, vec3 position, Frame frame) {
    vec3 sum = vec3(0.0f);
#define ADD_LOBE(Lobe, name, feature)                                                              \
    if (HasTraceFeature(feature) && g.name##Chance > 0.0f) {                                       \
        LobeMean lobe = Transmitted(g.name, g.view);                                               \
        if (MaxComponent(lobe.albedo) > 0.0f)                                                      \
            sum += lobe.albedo * RadianceFromBehind(lobe, position, FromLocal(frame, lobe.wi));    \
    }
    GLTF_LOBES(ADD_LOBE)
#undef ADD_LOBE
    return sum;
}

// A medium that refracts colors differently shows each as at the middle of its band of wavelengths.
vec3 LightFromBehind(SurfaceInteraction surface, SurfaceBSDF bsdf, SurfaceSetting setting, Frame frame) {
    if (HasTraceFeature(kTraceDispersion) && (surface.material.flags & kMaterialVolume) != 0u) {
        float ior = surface.material.ior;
        float dispersion = MediumAt(surface.material.id).dispersion;
        vec3 seen = vec3(0.0f);
        DONT_UNROLL
        for (int color = 0; color < 3 && dispersion > 0.0f; ++color) {
            surface.material.ior = DispersedIor(ior, dispersion, kBandMean[color]);
            setting.eta = EtaOf(surface);
            GltfBSDF one = Prepare(surface.material, setting, bsdf.wo);
            seen[color] = LightFromBehind(one, surface.position, frame)[color];
        }
        if (dispersion > 0.0f) return seen;
    }
    return LightFromBehind(bsdf.gltf, surface.position, frame);
}

// A body of a medium that scatters looks like a diffuse one, as far as light does not pass through it.
void ApproximateMediumAsDiffuse(inout SurfaceMaterial material) {
    if ((material.flags & kMaterialVolume) == 0u) return;
    Medium medium = MediumAt(material.id);
    float passed = exp(-MaxComponent(medium.scattering) * materials.at[material.id].thickness);
    material.baseColor = mix(MultiscatterColor(medium), material.baseColor, passed);
    material.transmission *= passed;
}

vec4 Shade(Hit hit, Ray ray) {
    if (!IsHit(hit))
        return HasTraceFeature(kTraceHiddenEnvironment) ? vec4(0.0f)
                                                        : vec4(EnvironmentRadiance(ray.direction), 0.0f);
    SurfaceInteraction surface = SurfaceAt(hit, ray);
    if ((surface.material.flags & kMaterialUnlit) != 0u) return vec4(surface.emission, 1.0f);
    if (HasTraceFeature(kTraceScattering)) ApproximateMediumAsDiffuse(surface.material);
    Sampler rng = StartPixelSample(uvec2(Pixel()), parameters.value.sampleIndex, parameters.value.seed);
    Frame frame = FrameOf(surface);
    SurfaceSetting setting = SettingOf(surface, frame, EtaOf(surface), 0.0f, FacetSeed(rng, 1u));
    SurfaceBSDF bsdf = BSDFOf(surface.material, ToLocal(frame, -ray.direction), setting);
    vec3 scattered = ScatteredLight(surface, frame, bsdf, rng);
    float open =
        (constants.option & kShadeOcclusion) != 0u ? texelFetch(ambientVisibility, Pixel(), 0).x : 1.0f;
    float roughness = surface.material.roughness;
    if (HasTraceFeature(kTraceEnvironmentLight))
        scattered += ReflectedEnvironment(bsdf, roughness, open, frame);
    if (ActiveBrdf() == kBrdfGltf) scattered += LightFromBehind(surface, bsdf, setting, frame);
    return vec4(surface.emission * EmissionTransmittance(surface, -ray.direction) + scattered, 1.0f);
}

void main() {
    if (IsInPicture()) imageStore(radiance, Pixel(), Shade(PixelHit(), PixelRay()));
}
