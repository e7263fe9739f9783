// SpreadCounts: a count a pixel as a picture that can be accumulated: the count three times, and 1.
#version 460

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D counts;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D values;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(values)))) return;
    imageStore(values, pixel, vec4(vec3(texelFetch(counts, pixel, 0).x), 1.0f));
}
