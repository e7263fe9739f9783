// Flip, third step: two filtered pictures compared. Both come from one program, so that equal ones differ by
// nothing: filtered twice in one shader, a compiler may fuse the operations of the two otherwise.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "post/flip.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D referenceLabAndEdge;
layout(set = 0, binding = 1, r32f) readonly uniform image2D referencePoint;
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D testLabAndEdge;
layout(set = 0, binding = 3, r32f) readonly uniform image2D testPoint;
layout(set = 0, binding = 4, r32f) writeonly uniform image2D error;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(error)))) return;
    vec4 reference = imageLoad(referenceLabAndEdge, pixel), test = imageLoad(testLabAndEdge, pixel);
    float colorError = FlipColorError(reference.xyz, test.xyz);
    float featureError = FlipFeatureError(vec2(reference.w, imageLoad(referencePoint, pixel).x),
                                          vec2(test.w, imageLoad(testPoint, pixel).x));
    // (3.3)
    imageStore(error, pixel, vec4(colorError > 0.0f ? pow(colorError, 1.0f - featureError) : 0.0f));
}
