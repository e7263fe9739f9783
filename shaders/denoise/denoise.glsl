// Windows and distances between surfaces, for the passes of the denoiser (passes/denoise.h).
#ifndef RAYGRAPH_DENOISE_DENOISE_GLSL
#define RAYGRAPH_DENOISE_DENOISE_GLSL

#include "post/pixels.glsl"

// Errors are weighed as relMSE weighs them: by the inverse of the squared radiance and 0.01.
vec3 ErrorWeight(vec3 radiance) { return 1.0f / (radiance * radiance + 0.01f); }

float Sum(vec3 value) { return value.x + value.y + value.z; }

// The first and the last pixel of the window around a pixel.
ivec2 WindowBegin(ivec2 pixel, int radius) { return max(pixel - radius, ivec2(0)); }
ivec2 WindowEnd(ivec2 pixel, int radius, ivec2 size) { return min(pixel + radius, size - 1); }

// The squared distance of two surfaces by their features (denoise/features.comp), 1 at a standard deviation.
// A difference counts for less where the features vary from pixel to pixel, as w says, near both pixels.
float FeatureDistance(vec4 albedoP, vec4 albedoQ, vec4 normalP, vec4 normalQ) {
    const float kAlbedo = 0.04f, kNormal = 0.2f;
    vec3 albedo = albedoP.xyz - albedoQ.xyz, normal = normalP.xyz - normalQ.xyz;
    return dot(albedo, albedo) / (kAlbedo * kAlbedo + min(albedoP.w, albedoQ.w)) +
           dot(normal, normal) / (kNormal * kNormal + min(normalP.w, normalQ.w));
}

// A part of the variance of a guide that it has even without noise.
float LeastVariance(vec3 value) { return 1e-5f * Sum(value * value) / 3.0f + 1e-7f; }

// The squared difference of two guides beyond what their variances (w) explain, in those times `scale`; the
// mean over channels.
float GuideDistance(vec4 p, vec4 q, float scale) {
    vec3 difference = p.xyz - q.xyz;
    return (dot(difference, difference) / (3.0f * scale) - p.w - min(p.w, q.w)) / (p.w + q.w);
}

#endif
