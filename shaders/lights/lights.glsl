// One sampler over all lights: emissive triangles, KHR_lights_punctual, the environment.
//
//     LightSample SampleLight(context, uc, u)          light that may arrive: uc chooses the light, u within
//     float LightPDF(context, light, wi, distance)     density in SampleLight of what a ray found
//
// Densities are per solid angle and include the probability of the light, as MIS with a BSDF's requires.
// Directions and distances are those from context.position; occlusion is not tested.
//
// The bridge, declared by the includer before this file:
//
//     LightSetRecord LightSet()                     counts and shares
//     LightRecord LightAt(uint light)               light < lightCount
//     LightNode LightNodeAt(uint node)              node < nodeCount
//     float LightProfileAt(uint word)               layout in lights/light_profile.glsl
//     AliasEntry LightAliasAt(uint slot)            layout in shared/light_records.h
//     AliasEntry EnvironmentAliasAt(uint slot)
//     vec3 EnvironmentRadiance(vec3 direction)
//     vec3 TriangleEmission(LightRecord light, vec2 barycentrics, vec3 toViewer)
//         radiance that a hit there adds on average: emission and its texture, times the share of rays that
//         the surface stops if it has alpha. The side is checked here, not there.
#ifndef RAYGRAPH_LIGHTS_LIGHTS_GLSL
#define RAYGRAPH_LIGHTS_LIGHTS_GLSL

#include "core/ray_offset.glsl"
#include "lights/environment_light.glsl"
#include "lights/light_bvh.glsl"
#include "lights/light_profile.glsl"
#include "lights/triangle_light.glsl"

SHADING_BEGIN

// The kinds of light that the scene may have; constant-folded.
INLINE bool HasBoundedLights() { return HasTraceFeature(kTraceTriangleLights | kTracePunctualLights); }
INLINE bool HasUnboundedLights() { return HasTraceFeature(kTraceEnvironmentLight | kTracePunctualLights); }

// A light by an alias table of `count` entries from `first`; u chooses the slot, `choice` whether it is kept.
// The remainders of both are uniform.
INLINE ChosenLight SampleLightAlias(uint first, uint count, INOUT(float) u, INOUT(float) choice) {
    uint slot = ChooseUniformly(u, count);
    AliasEntry entry = LightAliasAt(first + slot);
    if (!Decide(choice, entry.keep)) {
        slot = entry.alias;
        entry = LightAliasAt(first + slot);
    }
    ChosenLight result;
    result.light = slot;
    result.probability = entry.probability;
    return result;
}

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
    if (!HasBoundedLights() || (HasUnboundedLights() && Decide(uc, lights.unboundedShare))) {
        ChosenLight result = SampleLightAlias(unboundedFirst, unboundedCount, uc, ux);
        result.light += lights.boundedCount;
        result.probability *= lights.unboundedShare;
        return result;
    }
    ChosenLight result = SampleLightTree(context, uc);
    result.probability *= 1.0f - lights.unboundedShare;
    return result;
}

// The probability with which ChooseLight chooses a light; `bitTrail` is that of a bounded one.
INLINE float LightProbability(LightSetRecord lights, LightContext context, uint light, uint bitTrail) {
    AliasEntry byPower = LightAliasAt(light);
    if (byPower.probability == 0.0f) return 0.0f;  // dark
    if (ActiveLightSampler() == kLightSamplerUniform) return 1.0f / float(lights.activeCount);
    if (ActiveLightSampler() == kLightSamplerPower) return byPower.probability;
    if (HasBoundedLights() && light < lights.boundedCount)
        return (1.0f - lights.unboundedShare) * LightTreeProbability(context, bitTrail);
    uint slot = lights.lightCount + 1u + light - lights.boundedCount;
    return lights.unboundedShare * LightAliasAt(slot).probability;
}

INLINE LightSample SampleTriangle(LightRecord light, LightContext context, vec2 u) {
    LightSample result = NoLightSample();
    SphericalTriangle seen = SphericalTriangleFrom(light, context.position);
    vec2 barycentrics = SampleTriangleLight(light, seen, context.position, u);
    vec3 point = light.p0 + barycentrics.x * light.e1 + barycentrics.y * light.e2;
    vec3 toLight = point - context.position;
    float distance2 = dot(toLight, toLight);
    if (!(distance2 > 0.0f)) return result;
    result.distance = sqrt(distance2);
    result.wi = toLight / result.distance;
    if (!EmitsTowards(light, -result.wi)) return result;
    vec3 across = cross(light.e1, light.e2);
    float facing = dot(across, result.wi);
    result.target =
        OffsetRayOrigin(point, (facing < 0.0f ? 1.0f : -1.0f) * normalize(across),
                        light.spotOffsetOrClearance);
    result.pdf = IsSampledBySolidAngle(seen) ? 1.0f / seen.solidAngle : 2.0f * distance2 / abs(facing);
    result.radiance = TriangleEmission(light, barycentrics, -result.wi);
    return result;
}

// Point, spot and directional: one direction, pdf 1. KHR_lights_punctual gives the spot's falloff.
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
    if (!(chosen.probability > 0.0f)) return result;
    if (HasTraceFeature(kTraceEnvironmentLight) && chosen.light == lights.lightCount) {
        EnvironmentSample environment = SampleEnvironmentLight(lights, uc, u);
        result.wi = environment.wi;
        result.radiance = EnvironmentRadiance(environment.wi);
        result.pdf = environment.pdf;
    } else {
        LightRecord light = LightAt(chosen.light);
        bool isTriangle = HasTraceFeature(kTraceTriangleLights) && light.kind == kLightTriangle;
        if (isTriangle) result = SampleTriangle(light, context, u);
        if (HasTraceFeature(kTracePunctualLights) && !isTriangle) result = SamplePunctual(light, context);
    }
    result.pdf *= chosen.probability;
    result.light = chosen.light;
    return result;
}

// `light` is the number of a triangle that a ray from context.position along wi hit at `distance`, or that of
// the environment, lightCount, for a ray that hit nothing.
INLINE float LightPDF(LightContext context, uint light, vec3 wi, float distance) {
    LightSetRecord lights = LightSet();
    bool isEnvironment = light == lights.lightCount;
    if (isEnvironment && lights.hasEnvironment == 0u) return 0.0f;
    uint bitTrail = 0u;
    float pdf = 0.0f;
    if (HasTraceFeature(kTraceEnvironmentLight) && isEnvironment) pdf = EnvironmentLightPDF(lights, wi);
    if (HasTraceFeature(kTraceTriangleLights) && !isEnvironment) {
        LightRecord record = LightAt(light);
        bitTrail = record.bitTrail;
        pdf = TriangleLightPDF(record, context.position, wi, distance);
    }
    return pdf > 0.0f ? pdf * LightProbability(lights, context, light, bitTrail) : 0.0f;
}

SHADING_END

#endif
