// ReduceMap: a smaller equirectangular map, whose texels are means over their solid angle.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "core/math.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform sampler2D map;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D reduced;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(reduced);
    if (any(greaterThanEqual(texel, size))) return;
    ivec2 from = textureSize(map, 0);
    ivec2 first = (texel * from + size - 1) / size, end = ((texel + 1) * from + size - 1) / size;
    vec3 sum = vec3(0.0f);
    float weights = 0.0f;
    for (int y = first.y; y < end.y; ++y) {
        float weight = sin(kPi * (float(y) + 0.5f) / float(from.y));
        vec3 row = vec3(0.0f);
        for (int x = first.x; x < end.x; ++x) row += texelFetch(map, ivec2(x, y), 0).xyz;
        sum += weight * row;
        weights += weight * float(end.x - first.x);
    }
    imageStore(reduced, texel, vec4(sum / weights, 1.0f));
}
