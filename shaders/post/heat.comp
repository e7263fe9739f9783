// Heat: one number a pixel as colours, from dark blue over red to a light yellow.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, r32f) readonly uniform image2D values;
layout(set = 0, binding = 1, rgba8) writeonly uniform image2D display;

layout(push_constant) uniform Constants { float most; } constants;  // shown in the last colour

// Display-encoded; the lightness rises evenly from stop to stop.
const vec3 kStops[7] = vec3[](vec3(0.00f, 0.00f, 0.02f), vec3(0.13f, 0.06f, 0.36f), vec3(0.42f, 0.08f, 0.51f),
                              vec3(0.72f, 0.18f, 0.44f), vec3(0.95f, 0.39f, 0.28f), vec3(1.00f, 0.70f, 0.32f),
                              vec3(1.00f, 0.98f, 0.75f));

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(display)))) return;
    float value = imageLoad(values, pixel).x / constants.most;
    float place = (value > 0.0f ? min(value, 1.0f) : 0.0f) * 6.0f;  // NaN is 0
    int below = min(int(place), 5);
    imageStore(display, pixel, vec4(mix(kStops[below], kStops[below + 1], place - float(below)), 1.0f));
}
