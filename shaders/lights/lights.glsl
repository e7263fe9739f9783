// One sampler over all lights: emissive triangles, KHR_lights_punctual, the environment.
//
//     LightSample SampleLight(context, uc, u)          light that may arrive: uc chooses the light, u within
//     float LightPDF(context, light, triangle, wi, distance)
//                                                      density in SampleLight of what a ray found
//
// Densities are per solid angle and include the probability of the light, as MIS with a BSDF's requires.
// Directions and distances are those from context.position; occlusion is not tested.
//
// The bridge, declared by the includer before this file:
//
//     LightSetRecord LightSet()                     counts and shares
//     LightRecord LightAt(uint light)               light < lightCount, or a triangle of a mesh
//     LightNode LightNodeAt(uint node)              node < nodeCount, or of a mesh
//     LightMeshRecord LightMeshAt(uint mesh)        of a light's record
//     mat4x3 LightPlacement(uint instance)          objectToWorld of an InstanceRecord
//     float LightProfileAt(uint word)               layout in lights/light_profile.glsl
//     AliasEntry LightAliasAt(uint slot)            layout in shared/light_records.h
//     EnvironmentEntry EnvironmentEntryAt(uint)     layout in shared/light_records.h
//     vec3 EnvironmentRadiance(vec3 direction)
//     vec3 TriangleEmission(LightRecord light, vec2 barycentrics, vec3 toViewer)
//         radiance that a hit there adds on average: emission and its texture, times the share of rays that
//         the surface stops if it has alpha. The side is checked here, not there.
#ifndef RAYGRAPH_LIGHTS_LIGHTS_GLSL
#define RAYGRAPH_LIGHTS_LIGHTS_GLSL

#include "core/record.glsl"
#include "lights/environment_light.glsl"
#include "lights/light_bvh.glsl"
#include "lights/light_profile.glsl"
#include "lights/mesh_light.glsl"
#include "lights/triangle_light.glsl"

SHADING_BEGIN

// These tell the kinds of light that the scene may have; they are constant-folded.
INLINE bool HasBoundedLights() { return HasTraceFeature(kTraceTriangleLights | kTracePunctualLights); }
INLINE bool HasUnboundedLights() { return HasTraceFeature(kTraceEnvironmentLight | kTracePunctualLights); }

// Chooses a light; the remainders of uc and u.x are uniform.
INLINE ChosenLight ChooseLight(LightSetRecord lights, LightContext context, INOUT(float) uc,
                               INOUT(float) ux) {
    if (lights.activeCount == 0u) return NoChosenLight();
    uint unboundedFirst = lights.lightCount + 1u;
    uint unboundedCount = unboundedFirst - lights.boundedCount;
    if (ActiveLightSampler() == kLightSamplerUniform) {
        uint slot = ChooseUniformly(uc, lights.activeCount);
        ChosenLight result;
        result.light = LightAliasAt(unboundedFirst + unboundedCount + slot).alias;
        result.probability = 1.0f / float(lights.activeCount);
        return result;
    }
    if (ActiveLightSampler() == kLightSamplerPower)
        return SampleLightAlias(0u, lights.lightCount + 1u, uc, ux);
    if (!HasBoundedLights() || (HasUnboundedLights() && SampleBernoulli(uc, lights.unboundedProbability))) {
        ChosenLight result = SampleLightAlias(unboundedFirst, unboundedCount, uc, ux);
        result.light += lights.boundedCount;
        result.probability *= lights.unboundedProbability;
        return result;
    }
    ChosenLight result = SampleLightTree(0u, context, uc);
    result.probability *= 1.0f - lights.unboundedProbability;
    return result;
}

// Returns the probability with which ChooseLight chooses a light; `bitTrail` is that of a bounded one.
INLINE float LightProbability(LightSetRecord lights, LightContext context, uint light, uint bitTrail) {
    AliasEntry byPower = LightAliasAt(light);
    if (byPower.probability == 0.0f) return 0.0f;  // dark
    if (ActiveLightSampler() == kLightSamplerUniform) return 1.0f / float(lights.activeCount);
    if (ActiveLightSampler() == kLightSamplerPower) return byPower.probability;
    if (HasBoundedLights() && light < lights.boundedCount)
        return (1.0f - lights.unboundedProbability) * LightTreeProbability(0u, context, bitTrail);
    uint slot = lights.lightCount + 1u + light - lights.boundedCount;
    return lights.unboundedProbability * LightAliasAt(slot).probability;
}

INLINE LightSample SampleTriangle(LightRecord light, LightContext context, vec2 u) {
    LightSample result = NoLightSample();
    SphericalTriangle seen = SphericalTriangleFrom(light, context.position);
    if (!EmitsTowards(light, -seen.volume)) return result;
    TrianglePoint point = SampleTriangleLight(light, seen, context.position, u);
    if (!(point.pdf > 0.0f)) return result;
    result.distance = point.distance;
    result.wi = point.wi;
    vec3 place = light.p0 + point.barycentrics.x * light.e1 + point.barycentrics.y * light.e2;
    result.target = OffsetRayOrigin(place, FacingNormal(light, seen), light.spotOffsetOrClearance);
    result.pdf = point.pdf;
    result.radiance = TriangleEmission(light, point.barycentrics, -result.wi);
    return result;
}

// Samples point, spot and directional lights: one direction, pdf 1. KHR_lights_punctual gives the spot's
// falloff.
INLINE LightSample SamplePunctual(LightRecord light, LightContext context) {
    LightSample result = NoLightSample();
    result.isDelta = 1u;
    result.radiance = light.e2;
    result.pdf = 1.0f;
    if (light.kind == kLightDirectional) {
        result.wi = -light.e1;
        return result;
    }
    vec3 toLight = light.p0 - context.position;
    float distance2 = dot(toLight, toLight);
    if (!(distance2 > 0.0f)) return NoLightSample();
    result.distance = sqrt(distance2);
    result.wi = toLight / result.distance;
    result.target = light.p0;
    result.radiance /= distance2;
    if (HasTraceFeature(kTraceLightProfiles) && (light.flags & kLightProfile) != 0u)
        result.radiance *= LightProfileIntensity(light, -result.wi);
    if (light.kind == kLightSpot)
        result.radiance *=
            Sqr(clamp(-dot(light.e1, result.wi) * light.spotScale + light.spotOffsetOrClearance, 0.0f, 1.0f));
    return result;
}

INLINE LightSample SampleLight(LightContext context, float uc, vec2 u) {
    LightSetRecord lights = LightSet();
    ChosenLight chosen = ChooseLight(lights, context, uc, u.x);
    LightSample result = NoLightSample();
    uint triangle = 0u;
    if (!(chosen.probability > 0.0f)) return result;
    if (HasTraceFeature(kTraceEnvironmentLight) && chosen.light == lights.lightCount) {
        EnvironmentSample environment = SampleEnvironmentLight(lights, uc, u);
        result.wi = environment.wi;
        result.radiance = EnvironmentRadiance(environment.wi);
        result.pdf = environment.pdf;
    } else {
        LightRecord light = LightAt(chosen.light);
        chosen.probability *= ResolveMeshLight(light, context, u, triangle);
        if (!(chosen.probability > 0.0f)) return result;
        bool isTriangle = HasTraceFeature(kTraceTriangleLights) && light.kind == kLightTriangle;
        if (isTriangle) result = SampleTriangle(light, context, u);
        if (HasTraceFeature(kTracePunctualLights) && !isTriangle) result = SamplePunctual(light, context);
    }
    RECORD(lightProbability, chosen.probability);
    result.pdf *= chosen.probability;
    result.light = chosen.light;
    result.triangle = triangle;
    return result;
}

// `light` is the number of a triangle that a ray from context.position along wi hit at `distance`, or that of
// a mesh, of which it hit `triangle`, or that of the environment, lightCount, for a ray that hit nothing.
INLINE float LightPDF(LightContext context, uint light, uint triangle, vec3 wi, float distance) {
    LightSetRecord lights = LightSet();
    bool isEnvironment = light == lights.lightCount;
    if (isEnvironment && lights.hasEnvironment == 0u) return 0.0f;
    uint bitTrail = 0u;
    float pdf = 0.0f;
    if (HasTraceFeature(kTraceEnvironmentLight) && isEnvironment) pdf = EnvironmentLightPDF(lights, wi);
    if (HasTraceFeature(kTraceTriangleLights) && !isEnvironment) {
        LightRecord record = LightAt(light);
        bitTrail = record.bitTrail;
        float within = ResolveHitMeshLight(record, context, triangle);
        pdf = within * TriangleLightPDF(record, context.position, distance);
    }
    return pdf > 0.0f ? pdf * LightProbability(lights, context, light, bitTrail) : 0.0f;
}

SHADING_END

#endif
