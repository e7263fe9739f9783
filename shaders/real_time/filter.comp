// FilterLevel: a level of the edge-avoiding a-trous filter. Dammertz et al. 2010, "Edge-Avoiding A-Trous
// Wavelet Transform for Fast Global Illumination Filtering"; guided by variance as in Schied et al. 2017,
// "Spatiotemporal Variance-Guided Filtering". The kernel is (1/4, 1/2, 1/4) along each axis. Unlike there,
// what a tap's weight falls short of the kernel's counts for the pixel itself, so that two pixels exchange
// equal parts: a bright pixel that its neighbors reject keeps what they do not take, and no light is lost.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "core/color.glsl"
#include "real_time/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba16f) readonly uniform image2D guided;  // w: deviation of the luminance
layout(set = 0, binding = 1, rg32ui) readonly uniform uimage2D surfaces;
layout(set = 0, binding = 2, rgba16f) writeonly uniform image2D filtered;

layout(push_constant, scalar) uniform Constants {
    Film film;
    ivec2 step;  // pixels from tap to tap, and turned by 90 degrees
} constants;

// A weight falls to 1 / e at kDeviations standard deviations between both luminances, at an angle with 1 -
// cos = 1 / kNormal between both normals, and, in mirrors, at a relative difference of 1 / kShownDepth of
// the lengths of both paths. A curved surface is kBend times the distance away from its tangent plane. All
// are chosen by the errors that docs/real-time.md lists.
const float kDeviations = 1.5f;
const float kNormal = 48.0f;
const float kShownDepth = 20.0f;
const float kBend = 0.1f;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(guided);
    if (!IsInside(pixel, size)) return;
    vec4 own = imageLoad(guided, pixel);
    uvec2 texel = imageLoad(surfaces, pixel).xy;
    uint number = NumberOf(texel);
    if (number == kNothingHit) {
        imageStore(filtered, pixel, own);
        return;
    }
    Film film = constants.film;
    vec3 normal = NormalOf(texel);
    float depth = DepthOf(texel);
    vec3 offset = OffsetAt(film, vec2(pixel) + 0.5f, depth);
    ivec2 along = constants.step, across = ivec2(-along.y, along.x);
    float bend = 1.0f + kBend * length(vec2(along));
    float luminance = Luminance(own.xyz);
    vec3 sum = vec3(0.0f);
    float variance = 0.0f, weights = 0.0f;
    for (int i = 0; i < 9; ++i) {
        if (i == 4) continue;
        ivec2 step = ivec2(i % 3, i / 3) - 1;
        ivec2 at = pixel + step.x * along + step.y * across;
        if (!IsInside(at, size)) continue;
        uvec2 otherTexel = imageLoad(surfaces, at).xy;
        if (NumberOf(otherTexel) != number) continue;
        vec4 value = imageLoad(guided, at);
        float otherDepth = DepthOf(otherTexel);
        vec3 away = OffsetAt(film, vec2(at) + 0.5f, otherDepth) - offset, otherNormal = NormalOf(otherTexel);
        float fromPlane = max(abs(dot(normal, away)), abs(dot(otherNormal, away))) /
                          (bend * FootprintAt(film, min(depth, otherDepth)));
        // A surface that a mirror shows is not where it seems to be: lengths of the paths are compared
        if (IsShown(number))
            fromPlane = 1.0f + kShownDepth / bend * abs(depth - otherDepth) / min(depth, otherDepth);
        float otherLuminance = Luminance(value.xyz);
        float deviation = kDeviations * length(vec2(own.w, value.w)) +
                          1e-4f * max(luminance, otherLuminance) + 1e-7f;
        float exponent = kNormal * (1.0f - dot(otherNormal, normal)) + max(fromPlane - 1.0f, 0.0f) +
                         abs(otherLuminance - luminance) / deviation;
        float weight = (step.x * step.y == 0 ? 0.125f : 0.0625f) * exp(-exponent);
        sum += weight * value.xyz;
        variance += weight * weight * value.w * value.w;
        weights += weight;
    }
    float kept = 1.0f - weights;
    variance += kept * kept * own.w * own.w;
    imageStore(filtered, pixel, ToHalf(vec4(sum + kept * own.xyz, sqrt(variance)), kToNearest));
}
