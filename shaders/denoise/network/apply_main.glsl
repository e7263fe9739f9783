// Filters one level of the light by the kernels that the network has predicted for it, and takes from the
// coarser level what those leave out: the differences between 2 x 2 pixels come from this level, their mean
// from both in shares (Vogels et al. 2018, "Denoising with Kernel Prediction and Asymmetric Loss
// Functions"). Each invocation does 2 x 2 pixels. COARSEST: there is no coarser level. FINEST: the result
// is radiance.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"
#include "denoise/network/network.glsl"

layout(set = 0, binding = 0) readonly buffer Kernels { uvec2 at[]; } kernels;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D light;
layout(set = 0, binding = 2, rgba32f) writeonly uniform image2D result;  // w: share of the pixel's own value
#ifndef COARSEST
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D coarser;
#endif
#ifdef FINEST
layout(set = 0, binding = 4, rgba32f) readonly uniform image2D albedo;
layout(set = 0, binding = 5, rgba32f) readonly uniform image2D mean;
layout(set = 0, binding = 6, rgba32f) readonly uniform image2D target;
#endif

#ifndef COARSEST
vec4 Coarser(ivec2 pixel) {
    vec2 place = (vec2(pixel) + 0.5f) / 2.0f - 0.5f;
    ivec2 first = ivec2(floor(place)), last = imageSize(coarser) - 1;
    vec2 part = place - vec2(first);
    vec4 sum = vec4(0.0f);
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1);
        vec2 along = mix(1.0f - part, part, vec2(step));
        sum += along.x * along.y * imageLoad(coarser, clamp(first + step, ivec2(0), last));
    }
    return sum;
}
#endif

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy), size = imageSize(light), half_ = (size + 1) / 2;
    if (!IsInside(block, half_)) return;
    vec4 filtered[4];
    float shares[4];
    for (int i = 0; i < 4; ++i) {
        ivec2 pixel = min(2 * block + ivec2(i & 1, i >> 1), size - 1);
        uint kernel = kKernelBlocks * uint((pixel.x & 1) + 2 * (pixel.y & 1));
        float largest = -3.4e38f;
        for (uint b = 0u; b < kKernelBlocks; ++b) {
            vec4 value = UnpackHalves(kernels.at[IndexOf(kernel + b, block, half_)]);
            if (b + 1u == kKernelBlocks) {
                shares[i] = 1.0f / (1.0f + exp(-value.y));
                value.yzw = value.xxx;
            }
            largest = max(largest, max(max(value.x, value.y), max(value.z, value.w)));
        }
        vec3 sum = vec3(0.0f);
        float weights = 0.0f, own = 0.0f;
        for (uint b = 0u; b < kKernelBlocks; ++b) {
            vec4 value = exp(UnpackHalves(kernels.at[IndexOf(kernel + b, block, half_)]) - largest);
            for (uint j = 0u; j < 4u; ++j) {
                uint tap = 4u * b + j;
                if (tap >= kKernelTaps) break;
                ivec2 at = clamp(pixel + ivec2(tap % 5u, tap / 5u) - 2, ivec2(0), size - 1);
                sum += value[j] * imageLoad(light, at).xyz;
                weights += value[j];
                if (tap == kKernelTaps / 2u) own = value[j];
            }
        }
        filtered[i] = vec4(sum, own) / weights;
    }
#ifndef COARSEST
    vec3 blurred = 0.25f * (filtered[0] + filtered[1] + filtered[2] + filtered[3]).xyz;
#endif
    for (int i = 0; i < 4; ++i) {
        ivec2 pixel = 2 * block + ivec2(i & 1, i >> 1);
        if (!IsInside(pixel, size)) continue;
        vec4 value = filtered[i];
#ifndef COARSEST
        vec4 other = Coarser(pixel);
        value.xyz += shares[i] * (other.xyz - blurred);
        value.w += shares[i] * (0.25f * other.w - value.w);
#endif
#ifdef FINEST
        value.xyz = max(value.xyz, vec3(0.0f)) * (max(imageLoad(albedo, pixel).xyz, vec3(0.0f)) + kDarkest);
        value.xyz += FiniteOr0(imageLoad(mean, pixel).xyz) - imageLoad(target, pixel).xyz;
#endif
        imageStore(result, pixel, value);
    }
}
