// One mip level of a material texture: means over the texels of the finer level, as floats for the next level
// and encoded as the image is. Variants define WIDENED: green is a roughness, widened by the variance of
// a normal map. Of an image as large as `encoded` level 0 is made, to be widened alone: it has no means.
//
// Where the finer level has an odd number m = 2 n + 1 of texels, each of the n coarser ones covers m / n of
// them: three, of which the outer ones count by the parts that it covers. So nothing shifts, and the mean of
// every level is that of the image.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "core/color.glsl"
#include "shared/texture_levels.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D finer;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D means;
layout(set = 0, binding = 2, rgba8) writeonly uniform image2D encoded;
#ifdef WIDENED
// Means of unit normals, from level 1 of the normal map on.
layout(set = 0, binding = 3) uniform sampler2D normals;
#endif

layout(push_constant, scalar) uniform Constants { TextureLevelConstants level; };

// Transparent texels keep a little weight: theirs is the color where all are.
const float kLeastWeight = 1.0f / 4096.0f;

// Returns the linear values that are averaged.
vec4 Linear(vec4 stored) {
    if (level.texels == kTexelsColor) return vec4(SrgbDecode(stored.xyz), stored.w);
    if (level.texels == kTexelsTransparentColor)
        return vec4(SrgbDecode(stored.xyz) * (stored.w + kLeastWeight), stored.w);
    if (level.texels == kTexelsNormals) {
        vec3 normal = 2.0f * stored.xyz - 1.0f;
        float size = length(normal);
        return vec4(size > 0.0f ? normal / size : vec3(0.0f, 0.0f, 1.0f), stored.w);
    }
    return stored;
}

vec4 Encoded(vec4 mean) {
    if (level.texels == kTexelsColor) return vec4(SrgbEncode(mean.xyz), mean.w);
    if (level.texels == kTexelsTransparentColor)
        return vec4(SrgbEncode(min(mean.xyz / (mean.w + kLeastWeight), vec3(1.0f))), mean.w);
    if (level.texels == kTexelsNormals) {
        float size = length(mean.xyz);
        return vec4(0.5f + 0.5f * (size > 1e-4f ? mean.xyz / size : vec3(0.0f, 0.0f, 1.0f)), mean.w);
    }
    return mean;
}

// Holds the texels of the finer level that texel i of n covers: the first one, how many, and what share each
// has.
struct Cover {
    int first;
    int count;
    vec3 weights;
};

Cover CoverOf(int i, int n, int finerSize) {
    bool isSame = n == finerSize;  // level 0, or one texel
    Cover cover;
    cover.first = isSame ? i : 2 * i;
    cover.count = isSame ? 1 : 2 + (finerSize & 1);
    cover.weights = vec3(1.0f / float(cover.count));
    if (cover.count == 3) cover.weights = vec3(float(n - i), float(n), float(i + 1)) / float(finerSize);
    return cover;
}

#ifdef WIDENED
// Variance of the slopes about their mean, per axis, by the length of the mean normal: Toksvig 2005,
// "Mipmapping Normal Maps". Below level 1 of the normal map it is a part of what level 1 has.
float SlopeVariance(vec3 normal) {
    float size = clamp(length(normal), 1e-3f, 1.0f);
    return level.slopeScale * level.slopeScale * (1.0f - size) / size;
}

const int kPoints = 4;  // along a side

float SlopeVariance(vec2 place, vec2 texelSize) {
    if (level.normalsLod <= 0.0f) return 0.0f;
    if (level.hasOtherTexels == 0u)
        return min(level.normalsLod, 1.0f) *
               SlopeVariance(textureLod(normals, place, level.normalsLod - 1.0f).xyz);
    // Between texels of the normal map nothing is lost: each one's own variance counts, over a texel of this
    // level or of the normal map, whichever is larger
    int lod = int(level.normalsLod) - 1;
    ivec2 size = textureSize(normals, lod);
    vec2 area = max(texelSize, 1.0f / vec2(size));
    float sum = 0.0f;
    for (int y = 0; y < kPoints; ++y)
        for (int x = 0; x < kPoints; ++x) {
            vec2 point = place + area * ((vec2(x, y) + 0.5f) / float(kPoints) - 0.5f);
            ivec2 texel = min(ivec2(fract(point) * vec2(size)), size - 1);
            sum += SlopeVariance(texelFetch(normals, texel, lod).xyz);
        }
    return sum / float(kPoints * kPoints);
}

// Toksvig's sharpness s turns into 1 / (1 / s + variance); with alpha^2 = 2 / s, alpha^2 grows by twice the
// variance, as that of Beckmann's facets does whose slopes are added to those of the map.
float Widened(float roughness, vec2 place, vec2 texelSize) {
    float alpha = level.roughnessFactor * roughness;
    alpha *= alpha;
    float square = min(alpha * alpha + 2.0f * SlopeVariance(place, texelSize), 1.0f);
    return max(min(sqrt(sqrt(square)) / level.roughnessFactor, 1.0f), roughness);
}
#endif

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(encoded);
    if (any(greaterThanEqual(texel, size))) return;
    ivec2 finerSize = textureSize(finer, 0);
    Cover columns = CoverOf(texel.x, size.x, finerSize.x);
    Cover rows = CoverOf(texel.y, size.y, finerSize.y);
    vec4 mean = vec4(0.0f);
    for (int y = 0; y < rows.count; ++y)
        for (int x = 0; x < columns.count; ++x) {
            vec4 value = texelFetch(finer, ivec2(columns.first + x, rows.first + y), 0);
            if (level.isFirst != 0u) value = Linear(value);
            mean += columns.weights[x] * rows.weights[y] * value;
        }
    if (size != finerSize) imageStore(means, texel, mean);
    vec4 result = Encoded(mean);
#ifdef WIDENED
    result.y = Widened(result.y, (vec2(texel) + 0.5f) / vec2(size), 1.0f / vec2(size));
#endif
    // Whole numbers, since a device may round others either way. Means of few texels often end in a half, but
    // for the floats' rounding: they are made halves again, of which as many go up as down
    vec4 codes = clamp(result, 0.0f, 1.0f) * 255.0f;
    imageStore(encoded, texel, roundEven(floor(codes * 1024.0f + 0.5f) / 1024.0f) / 255.0f);
}
