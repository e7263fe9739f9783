// Writes the planes that the network sees: 16 numbers of each pixel, as 64 channels of a picture of half
// the size, and the radiance over the albedo, which it filters.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"
#include "denoise/network/network.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D target;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D noise;
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D albedo;
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D normal;
layout(set = 0, binding = 4, r32f) readonly uniform image2D exposure;
layout(set = 0, binding = 5, rgba32f) writeonly uniform image2D light;
layout(set = 0, binding = 6) writeonly buffer Planes { uvec2 at[]; } planes;

layout(push_constant) uniform Constants {
    float samplesToMinusHalf;
} constants;

vec3 Log(vec3 value) {
    return log(1.0f + value);
}

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy), size = imageSize(target), half_ = (size + 1) / 2;
    if (!IsInside(block, half_)) return;
    float scale = imageLoad(exposure, ivec2(0)).x;
    for (int i = 0; i < 4; ++i) {
        ivec2 inside = 2 * block + ivec2(i & 1, i >> 1), pixel = min(inside, size - 1);
        vec3 radiance = max(imageLoad(target, pixel).xyz, vec3(0.0f));
        vec3 color = imageLoad(albedo, pixel).xyz, facing = imageLoad(normal, pixel).xyz;
        vec3 lit = radiance / (max(color, vec3(0.0f)) + kDarkest);
        float deviation = Sum(sqrt(max(imageLoad(noise, pixel).xyz, vec3(0.0f)))) / 3.0f;
        float relative = deviation / (Sum(radiance) / 3.0f + 0.01f / scale);
        if (inside == pixel) imageStore(light, pixel, vec4(lit, 0.0f));
        vec3 a = Log(scale * lit), b = Log(scale * radiance);
        vec2 c = Log(vec3(scale * deviation, relative, 0.0f)).xy;
        uint first = 4u * uint(i);
        planes.at[IndexOf(first, block, half_)] = PackHalves(vec4(a, b.x));
        planes.at[IndexOf(first + 1u, block, half_)] = PackHalves(vec4(b.yz, c));
        planes.at[IndexOf(first + 2u, block, half_)] = PackHalves(vec4(color, facing.x));
        planes.at[IndexOf(first + 3u, block, half_)] =
            PackHalves(vec4(facing.yz, dot(facing, facing), constants.samplesToMinusHalf));
    }
}
