// ResolveMoving: temporal anti-aliasing. The light of each pixel's surface, times its albedo, is averaged
// with the pictures of earlier frames.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "core/color.glsl"
#include "real_time/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba16f) readonly uniform image2D filtered;
layout(set = 0, binding = 1, rgba16f) readonly uniform image2D albedo;
layout(set = 0, binding = 2, rg32ui) readonly uniform uimage2D surfaces;
layout(set = 0, binding = 3, rgba16f) readonly uniform image2D motion;
layout(set = 0, binding = 4, rgba16f) readonly uniform image2D mean;  // w: number of samples
layout(set = 0, binding = 5, rgba16f) readonly uniform image2D pictureBefore;  // w: number of frames
layout(set = 0, binding = 6, rg32ui) readonly uniform uimage2D surfacesBefore;
layout(set = 0, binding = 7, rgba16f) writeonly uniform image2D picture;

layout(push_constant, scalar) uniform Constants {
    float mostBefore;  // frames that count of those before
    float mostMoving;  // frames that count where something moves
    float mostStill;
    uint hasChanged;  // something else than the camera has
    uint isStill;     // neither the camera nor anything else has
    uint hasLimit;    // no more pictures count than samples of the mean
    uint frame;       // a number, for random rounding
} constants;

const float kDeviations = 1.0f;  // of its neighborhood that a color of earlier frames may be away

// Where the contrast of 3 x 3 pixels, the squared relative deviation of their luminance, is above
// kLowContrast, the number of pictures that count is divided by 1 + kBlur * (contrast - kLowContrast). Both
// are chosen by the measured error of edges of lamps.
const float kBlur = 8.0f;
const float kLowContrast = 0.7f;

vec3 ToYCoCg(vec3 c) {
    return vec3(0.25f * (c.x + c.z) + 0.5f * c.y, 0.5f * (c.x - c.z), 0.5f * c.y - 0.25f * (c.x + c.z));
}
vec3 FromYCoCg(vec3 c) { return vec3(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z); }

// Weights of Catmull-Rom's cubic at four texels.
vec4 CubicWeights(float t) {
    float t2 = t * t, t3 = t2 * t;
    return 0.5f * vec4(2.0f * t2 - t3 - t, 3.0f * t3 - 5.0f * t2 + 2.0f, 4.0f * t2 - 3.0f * t3 + t, t3 - t2);
}

vec4 PictureBefore(vec2 place) {
    ivec2 corner = ivec2(floor(place - 0.5f)), size = imageSize(pictureBefore);
    vec2 part = place - 0.5f - vec2(corner);
    if (part == vec2(0.0f)) return imageLoad(pictureBefore, corner);
    vec4 across = CubicWeights(part.x), down = CubicWeights(part.y);
    vec3 sum = vec3(0.0f);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
            ivec2 at = clamp(corner + ivec2(x, y) - 1, ivec2(0), size - 1);
            sum += across[x] * down[y] * imageLoad(pictureBefore, at).xyz;
        }
    ivec2 nearest = clamp(ivec2(floor(place)), ivec2(0), size - 1);
    return vec4(max(sum, vec3(0.0f)), imageLoad(pictureBefore, nearest).w);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(picture);
    if (!IsInside(pixel, size)) return;
    uint number = NumberOf(imageLoad(surfaces, pixel).xy);
    vec3 color, sum = vec3(0.0f), squares = vec3(0.0f);
    float count = 0.0f, nearest = 3.4e38f;
    ivec2 front = pixel;
    for (int i = 0; i < 9; ++i) {
        ivec2 at = pixel + ivec2(i % 3, i / 3) - 1;
        if (!IsInside(at, size)) continue;
        vec3 value = FiniteOr0(imageLoad(filtered, at).xyz * DivisorOf(imageLoad(albedo, at)));
        if (i == 4) color = value;
        value = ToYCoCg(value);
        sum += value;
        squares += value * value;
        count += 1.0f;
        uvec2 seen = imageLoad(surfaces, at).xy;
        if (NumberOf(seen) != kNothingHit && DepthOf(seen) < nearest) {
            nearest = DepthOf(seen);
            front = at;
        }
    }
    vec4 moved = imageLoad(motion, front);
    vec2 shift = ShiftOf(moved);
    bool isStill = shift == vec2(0.0f);
    vec2 place = vec2(pixel) + 0.5f + shift;
    bool isKnown = moved.w != 0.0f && all(greaterThanEqual(place, vec2(0.0f))) &&
                   all(lessThan(place, vec2(size))) && constants.mostBefore > 0.0f;
    vec4 result = vec4(color, 1.0f);
    if (isKnown) {
        vec4 before = PictureBefore(place);
        bool isFree = constants.isStill != 0u ||
                      (isStill && constants.hasChanged == 0u && imageLoad(mean, pixel).w > 1.0f &&
                       number == NumberOf(imageLoad(surfacesBefore, pixel).xy));
        if (!isFree) {  // what stands still needs no clamp, which would shift its mean
            vec3 middle = sum / count;
            vec3 reach = kDeviations * sqrt(max(squares / count - middle * middle, vec3(0.0f)));
            before.xyz = FromYCoCg(clamp(ToYCoCg(before.xyz), middle - reach, middle + reach));
            before.xyz = max(before.xyz, vec3(0.0f));
        }
        float most = constants.mostStill;
        if (!isStill || constants.hasChanged != 0u) {
            // A picture that is sampled between its texels is blurred. Where the edge of a bright surface is
            // near, that would be seen a pixel beside it, so that few pictures count there.
            float contrast = max(squares.x * count / (sum.x * sum.x + 1e-12f) - 1.0f, 0.0f);
            float blur = kBlur * max(contrast - kLowContrast, 0.0f);
            most = 1.0f + (constants.mostMoving - 1.0f) / (1.0f + blur);
        }
        if (constants.hasLimit != 0u) most = min(most, imageLoad(mean, pixel).w);
        float frames = min(min(before.w, constants.mostBefore) + 1.0f, most);
        // The n-th picture counts n times as much as the first: each has less noise than those before
        result = vec4(mix(before.xyz, color, min(2.0f / (frames + 1.0f), 1.0f)), frames);
    }
    imageStore(picture, pixel, ToHalf(result, RandomBits(pixel, constants.frame)));
}
