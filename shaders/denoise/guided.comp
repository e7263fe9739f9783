// Estimates with three bandwidths: fits around each pixel with weights by the distance of the first estimate
// and of the surfaces. w of each is the share that the pixel's own value has in it.
//
// A pixel that is much noisier than the fitted one counts for less: without that, a bright sample that few
// paths find would spread over its neighbors.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/regression.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D mean;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D guide;  // the target and its variance
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D pilot;
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D albedoFeature;
layout(set = 0, binding = 4, rgba32f) readonly uniform image2D normalFeature;
layout(set = 0, binding = 5, rgba32f) writeonly uniform image2D detailed;
layout(set = 0, binding = 6, rgba32f) writeonly uniform image2D medium;
layout(set = 0, binding = 7, rgba32f) writeonly uniform image2D smoothed;

layout(push_constant) uniform Constants {
    float trusted;  // of the fitted pixel's variance: weights of noisier pixels fall with theirs
} constants;

// In standard deviations of the first estimate.
const float kDetailed = 0.7f, kMedium = 1.4f, kSmoothed = 2.8f;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(mean);
    if (!IsInside(pixel, size)) return;
    vec4 albedo = imageLoad(albedoFeature, pixel), normal = imageLoad(normalFeature, pixel);
    vec4 own = imageLoad(pilot, pixel), ownGuide = imageLoad(guide, pixel);
    Sums ofDetailed = NoSums(), ofMedium = NoSums(), ofSmoothed = NoSums();
    ivec2 begin = WindowBegin(pixel, kRadius), end = WindowEnd(pixel, kRadius, size);
    for (int y = begin.y; y <= end.y; ++y)
        for (int x = begin.x; x <= end.x; ++x) {
            ivec2 other = ivec2(x, y);
            vec4 otherAlbedo = imageLoad(albedoFeature, other), otherNormal = imageLoad(normalFeature, other);
            float distance = kFeatureScale * FeatureDistance(albedo, otherAlbedo, normal, otherNormal);
            vec4 otherPilot = imageLoad(pilot, other), otherGuide = imageLoad(guide, other);
            float trust = min(constants.trusted * ownGuide.w / otherGuide.w, 1.0f);
            vec2 position = vec2(other - pixel) / float(kRadius);
            vec4 u = vec4(otherAlbedo.xyz - albedo.xyz, position.x);
            vec4 v = vec4(otherNormal.xyz - normal.xyz, position.y);
#define ADD_TO(sums, bandwidth)                                                                       \
    {                                                                                                 \
        float total = distance + max(GuideDistance(own, otherPilot, bandwidth * bandwidth), 0.0f);     \
        if (total < kFarthest) Add(sums, trust * exp(-total), u, v, otherGuide.xyz);                   \
    }
            ADD_TO(ofSmoothed, kSmoothed)
            ADD_TO(ofMedium, kMedium)
            ADD_TO(ofDetailed, kDetailed)
        }
    vec4 rest = vec4(FiniteOr0(imageLoad(mean, pixel).xyz) - ownGuide.xyz, 0.0f);
    imageStore(detailed, pixel, Fit(ofDetailed) + rest);
    imageStore(medium, pixel, Fit(ofMedium) + rest);
    imageStore(smoothed, pixel, Fit(ofSmoothed) + rest);
}
