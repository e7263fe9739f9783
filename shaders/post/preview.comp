#version 460
#extension GL_GOOGLE_include_directive : require
// Preview: surfaces lit from the camera (passes/trace.h).
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D albedo;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D normal;
layout(set = 0, binding = 2, rgba32f) writeonly uniform image2D preview;

layout(push_constant) uniform Constants {
    vec3 forward;
    float gain;
} constants;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(preview)))) return;
    vec3 n = imageLoad(normal, pixel).xyz;
    bool isMiss = dot(n, n) == 0.0;
    // Edges stay visible: what is seen at a grazing angle is darker, but never black
    float light = 0.2 + 0.8 * abs(dot(n, constants.forward));
    vec3 color = isMiss ? vec3(0.05) : light * imageLoad(albedo, pixel).rgb;
    imageStore(preview, pixel, vec4(constants.gain * color, isMiss ? 0.0 : 1.0));
}
