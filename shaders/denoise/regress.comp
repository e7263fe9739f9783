// Fits the target around each pixel by a function that is linear in albedo, normal and position (Bitterli et
// al. 2016), and writes its value at the pixel. Weights are those of non-local means on a guide (Rousselle et
// al. 2012), by the distance of patches, and fall with the distance of the surfaces. w of the result is the
// weight of the pixel's own value in its estimate.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D mean;   // the target
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D guide;  // w, of an estimate: as above
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D bound;  // noise of the mean
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D albedoFeature;
layout(set = 0, binding = 4, rgba32f) readonly uniform image2D normalFeature;
layout(set = 0, binding = 5, rgba32f) writeonly uniform image2D estimate;

layout(push_constant) uniform Constants {
    int patchRadius;   // at most 2
    float noiseScale;  // larger ones smooth more
    uint isEstimate;   // the guide is an estimate, whose noise is its w times that of the mean
} constants;

const int kRadius = 8;
const float kFeatureScale = 0.1f;
const float kFarthest = 12.0f;  // weights below exp(-12) are 0
const float kRidge = 0.1f, kLeastSpread = 0.01f;
const int kTerms = 9;

vec3 GuideVariance(vec4 value, ivec2 pixel) {
    float share = constants.isEstimate != 0u ? max(value.w, 0.02f) : 1.0f;
    return imageLoad(bound, pixel).xyz * (constants.noiseScale * share) +
           1e-5f * value.xyz * value.xyz + 1e-7f;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(mean);
    if (!IsInside(pixel, size)) return;
    int patchSide = 2 * constants.patchRadius + 1;
    vec3 ownGuide[25], ownVariance[25];
    for (int i = 0; i < patchSide * patchSide; ++i) {
        ivec2 offset = ivec2(i % patchSide, i / patchSide) - constants.patchRadius;
        ivec2 at = clamp(pixel + offset, ivec2(0), size - 1);
        vec4 value = imageLoad(guide, at);
        ownGuide[i] = FiniteOr0(value.xyz);
        ownVariance[i] = GuideVariance(vec4(ownGuide[i], value.w), at);
    }
    vec4 albedo = imageLoad(albedoFeature, pixel), normal = imageLoad(normalFeature, pixel);
    float moments[kTerms * (kTerms + 1) / 2];  // the lower triangle of the normal equations, row by row
    vec3 products[kTerms];
    for (int i = 0; i < kTerms * (kTerms + 1) / 2; ++i) moments[i] = 0.0f;
    for (int i = 0; i < kTerms; ++i) products[i] = vec3(0.0f);
    ivec2 begin = WindowBegin(pixel, kRadius), end = WindowEnd(pixel, kRadius, size);
    for (int y = begin.y; y <= end.y; ++y)
        for (int x = begin.x; x <= end.x; ++x) {
            ivec2 other = ivec2(x, y);
            vec4 otherAlbedo = imageLoad(albedoFeature, other), otherNormal = imageLoad(normalFeature, other);
            float distance = kFeatureScale * FeatureDistance(albedo, otherAlbedo, normal, otherNormal);
            if (!(distance < kFarthest)) continue;
            float sum = 0.0f, count = 0.0f;
            for (int i = 0; i < patchSide * patchSide; ++i) {
                ivec2 offset = ivec2(i % patchSide, i / patchSide) - constants.patchRadius;
                if (!IsInside(pixel + offset, size) || !IsInside(other + offset, size)) continue;
                vec4 value = imageLoad(guide, other + offset);
                value.xyz = FiniteOr0(value.xyz);
                vec3 variance = GuideVariance(value, other + offset);
                vec3 difference = value.xyz - ownGuide[i];
                vec3 both = ownVariance[i] + variance;
                sum += Sum((difference * difference - ownVariance[i] - min(ownVariance[i], variance)) / both);
                count += 3.0f;
            }
            distance += max(sum / count, 0.0f);
            if (!(distance < kFarthest)) continue;
            float weight = exp(-distance);
            vec3 albedoOffset = otherAlbedo.xyz - albedo.xyz, normalOffset = otherNormal.xyz - normal.xyz;
            vec2 position = vec2(other - pixel) / float(kRadius);
            float terms[kTerms] =
                float[](1.0f, albedoOffset.x, albedoOffset.y, albedoOffset.z, normalOffset.x, normalOffset.y,
                        normalOffset.z, position.x, position.y);
            vec3 target = FiniteOr0(imageLoad(mean, other).xyz);
            for (int i = 0, k = 0; i < kTerms; ++i) {
                float weighted = weight * terms[i];
                products[i] += weighted * target;
                for (int j = 0; j <= i; ++j, ++k) moments[k] += weighted * terms[j];
            }
        }
    // A ridge keeps slopes from following the noise, and the equations regular. Cholesky's factors replace
    // the moments.
    float least = kRidge * kLeastSpread * moments[0] + 1e-6f;
    for (int i = 0, row = 0; i < kTerms; row += ++i) {
        if (i > 0) moments[row + i] += kRidge * moments[row + i] + least;
        for (int j = 0, column = 0; j <= i; column += ++j) {
            float value = moments[row + j];
            for (int k = 0; k < j; ++k) value -= moments[row + k] * moments[column + k];
            moments[row + j] = i == j ? sqrt(max(value, 1e-12f)) : value / moments[column + j];
        }
    }
    // The first row of the inverse: what each product counts for in the constant term.
    float solution[kTerms];
    for (int i = 0, row = 0; i < kTerms; row += ++i) {
        float value = i == 0 ? 1.0f : 0.0f;
        for (int k = 0; k < i; ++k) value -= moments[row + k] * solution[k];
        solution[i] = value / moments[row + i];
    }
    for (int i = kTerms - 1; i >= 0; --i) {
        float value = solution[i];
        for (int k = i + 1; k < kTerms; ++k) value -= moments[k * (k + 1) / 2 + i] * solution[k];
        solution[i] = value / moments[i * (i + 1) / 2 + i];
    }
    vec3 result = vec3(0.0f);
    for (int i = 0; i < kTerms; ++i) result += solution[i] * products[i];
    imageStore(estimate, pixel, vec4(max(FiniteOr0(result), vec3(0.0f)), clamp(solution[0], 0.0f, 1.0f)));
}
