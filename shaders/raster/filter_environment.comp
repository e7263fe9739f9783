// FilterEnvironment: the levels of shared/light_records.h. Each texel is the mean of the map over the
// lobe of a surface that is seen face on, along its normal: for facets, directions by their distribution,
// weighted by the cosine (Karis 2013, "Real Shading in Unreal Engine 4"); for diffuse ones, by the cosine.
// Both the lobe and the bright parts of the map are sampled, weighted by the balance heuristic.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"

#include "bxdf/microfacet.glsl"
#include "core/frame.glsl"
#include "core/rng.glsl"
#include "core/warp.glsl"
#include "lights/environment_light.glsl"
#include "shared/light_records.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 16, rgba32f) writeonly uniform image2D filtered;

const uint kSamples = 256u;  // samples of each strategy

struct Lobe {
    bool isDiffuse;
    MicrofacetDistribution facets;
};

// Returns the density of wi, in the frame of the normal.
float LobePDF(Lobe lobe, vec3 wi) {
    if (wi.z <= 0.0f) return 0.0f;
    if (lobe.isDiffuse) return CosineHemispherePDF(wi.z);
    return 0.25f * D(lobe.facets, normalize(wi + vec3(0.0f, 0.0f, 1.0f)));
}

vec3 SampleLobe(Lobe lobe, vec2 u) {
    if (lobe.isDiffuse) return SampleCosineHemisphere(u);
    float square = Sqr(lobe.facets.alpha.x);
    float cosine = sqrt((1.0f - u.x) / (1.0f + (square - 1.0f) * u.x));
    float sine = SafeSqrt(1.0f - Sqr(cosine));
    vec2 azimuth = CosSinTurn(u.y);
    return Reflect(vec3(0.0f, 0.0f, 1.0f), vec3(sine * azimuth.x, sine * azimuth.y, cosine));
}

// Returns the weight of a sample, beside its density.
float LobeWeight(Lobe lobe, vec3 wi) { return lobe.isDiffuse ? 1.0f : max(wi.z, 0.0f); }

// All texels of a level share their samples, whose numbers do not depend on the texel.
shared vec4 lobeSamples[kSamples];    // in the frame of the normal; w: density
shared vec4 brightSamples[kSamples];  // in the world; w: density
shared vec3 brightRadiance[kSamples];

void main() {
    // Workgroups cover levels exactly: their extent is a multiple of 8
    uvec2 texel = gl_GlobalInvocationID.xy;
    uint level = texel.y / kFilteredHeight;
    vec2 place = vec2(float(texel.x), float(texel.y - level * kFilteredHeight)) + 0.5f;
    Frame frame = FrameFromZ(
        DirectionFromEquirect(place / vec2(float(kFilteredWidth), float(kFilteredHeight)), 0.0f));
    Lobe lobe;
    lobe.isDiffuse = level == kFilteredDiffuse;
    lobe.facets = MakeMicrofacetDistribution(vec2(Sqr(float(level + 1u) * kFilteredStep)));

    LightSetRecord lights = LightSet();
    for (uint i = gl_LocalInvocationIndex; i < kSamples; i += gl_WorkGroupSize.x * gl_WorkGroupSize.y) {
        Sampler rng = StartPixelSample(uvec2(0u), i, 0u);
        vec3 wi = SampleLobe(lobe, Get2D(rng));
        lobeSamples[i] = vec4(wi, LobePDF(lobe, wi));
        float choice = Get1D(rng);
        EnvironmentSample bright = SampleEnvironmentLight(lights, choice, Get2D(rng));
        brightSamples[i] = vec4(bright.wi, bright.pdf);
        brightRadiance[i] = EnvironmentRadiance(bright.wi);
    }
    barrier();
    vec3 sum = vec3(0.0f);
    float whole = 0.0f;
    for (uint i = 0u; i < kSamples; ++i) {
        vec3 wi = lobeSamples[i].xyz;
        float pdf = lobeSamples[i].w;
        if (pdf > 0.0f) {
            vec3 direction = FromLocal(frame, wi);
            float weight = LobeWeight(lobe, wi) * pdf / (pdf + EnvironmentLightPDF(lights, direction));
            sum += EnvironmentRadiance(direction) * weight;
            whole += weight;
        }
        wi = ToLocal(frame, brightSamples[i].xyz);
        pdf = LobePDF(lobe, wi);
        if (pdf > 0.0f) {
            float weight = LobeWeight(lobe, wi) * pdf / (pdf + brightSamples[i].w);
            sum += brightRadiance[i] * weight;
            whole += weight;
        }
    }
    imageStore(filtered, ivec2(texel), vec4(sum / whole, 1.0f));
}
