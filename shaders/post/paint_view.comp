// PaintView: display values of a view.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "core/ramp.glsl"
#include "shared/choice.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba32f) readonly uniform image2D values;
layout(set = 0, binding = 1, rgba8) writeonly uniform image2D display;
layout(set = 0, binding = 2, scalar) readonly buffer Range { uint notMinimum; uint maximum; } range;
layout(push_constant, scalar) uniform Constants { uint view; } constants;

const float kDarkestDepth = 0.15f;
const vec3 kEdgeColor = vec3(1.0f, 0.55f, 0.1f);

float DepthGray(float depth) {
    float minimum = uintBitsToFloat(~range.notMinimum);
    float maximum = uintBitsToFloat(range.maximum);
    float share = maximum > minimum ? (depth - minimum) / (maximum - minimum) : 0.0f;
    return 1.0f - (1.0f - kDarkestDepth) * share;
}

// Returns the position of a count on the ramp: each doubling of 1 + count is one of `steps`.
vec3 CountHeatColor(float count, float steps) { return SrgbEncode(HeatColor(log2(1.0f + count) / steps)); }

// Returns values in [0, 1], as shown. `value` is a mean over samples of which some may have hit nothing.
vec3 Paint(vec4 value) {
    float coverage = value.w;
    if (!(coverage > 0.0f)) return vec3(0.0f);
    switch (constants.view) {
        case kViewAlbedo:
        case kViewEmissive:
            return SrgbEncode(clamp(value.xyz, 0.0f, 1.0f));
        case kViewNormals:
            return 0.5f * (vec3(coverage) + value.xyz);
        case kViewRoughness:
        case kViewMetallic:
            return value.xyz;
        case kViewDepth:
            return vec3(DepthGray(value.x));
        case kViewInstance:
        case kViewMaterial:
            return IdColor(uint(value.x));
        case kViewWireframe:
            return mix(vec3(0.12f * coverage + 0.4f * value.y), kEdgeColor, value.x);
        case kViewOverdraw:
        case kViewPathLength:
            return CountHeatColor(value.x, 5.0f);
        case kViewRayCost:
            return CountHeatColor(value.x, 10.0f);
    }
    return vec3(0.0f);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(display)))) return;
    imageStore(display, pixel, vec4(clamp(Paint(imageLoad(values, pixel)), 0.0f, 1.0f), 1.0f));
}
