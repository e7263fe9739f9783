// The first estimate: a fit around each pixel with weights of non-local means (Rousselle et al. 2012) by the
// distance of patches of 3 x 3 pixels, which fall with the distance of the surfaces. w of the result is its
// variance, as weights use it.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/regression.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D guide;  // the target and its variance
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D albedoFeature;
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D normalFeature;
layout(set = 0, binding = 3, rgba32f) writeonly uniform image2D pilot;

// Patches that reach over the border have its pixels repeated.
vec4 GuideAt(ivec2 pixel, int x, int y, ivec2 size) {
    return imageLoad(guide, clamp(pixel + ivec2(x, y), ivec2(0), size - 1));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(guide);
    if (!IsInside(pixel, size)) return;
    vec4 albedo = imageLoad(albedoFeature, pixel), normal = imageLoad(normalFeature, pixel);
#define OF_PATCH(Apply)                                                                           \
    Apply(0, -1, -1) Apply(1, 0, -1) Apply(2, 1, -1) Apply(3, -1, 0) Apply(4, 0, 0) Apply(5, 1, 0) \
    Apply(6, -1, 1) Apply(7, 0, 1) Apply(8, 1, 1)
#define LOAD_OWN(i, x, y) vec4 own##i = GuideAt(pixel, x, y, size);
    OF_PATCH(LOAD_OWN)
    Sums sums = NoSums();
    ivec2 begin = WindowBegin(pixel, kRadius), end = WindowEnd(pixel, kRadius, size);
    for (int y = begin.y; y <= end.y; ++y)
        for (int x = begin.x; x <= end.x; ++x) {
            ivec2 other = ivec2(x, y);
            vec4 otherAlbedo = imageLoad(albedoFeature, other), otherNormal = imageLoad(normalFeature, other);
            float distance = kFeatureScale * FeatureDistance(albedo, otherAlbedo, normal, otherNormal);
            if (!(distance < kFarthest)) continue;
            float sum = 0.0f;
#define ADD_DISTANCE(i, dx, dy) sum += GuideDistance(own##i, GuideAt(other, dx, dy, size), 1.0f);
            OF_PATCH(ADD_DISTANCE)
            distance += max(sum / 9.0f, 0.0f);
            if (!(distance < kFarthest)) continue;
            vec2 position = vec2(other - pixel) / float(kRadius);
            Add(sums, exp(-distance), vec4(otherAlbedo.xyz - albedo.xyz, position.x),
                vec4(otherNormal.xyz - normal.xyz, position.y), imageLoad(guide, other).xyz);
        }
    const float kLeastShare = 0.02f;
    vec4 fit = Fit(sums);
    imageStore(pilot, pixel, vec4(fit.xyz, max(fit.w, kLeastShare) * own4.w + LeastVariance(fit.xyz)));
}
