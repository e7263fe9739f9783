// AccumulateMoving: adds a sample of each pixel to the mean of those that its surface had in earlier frames.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "core/color.glsl"
#include "real_time/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D radiance;  // rows below the picture are unused
layout(set = 0, binding = 1, rgba16f) readonly uniform image2D albedo;  // w: dullness
layout(set = 0, binding = 2, rg32ui) readonly uniform uimage2D surfaces;
layout(set = 0, binding = 3, rgba16f) readonly uniform image2D motion;
layout(set = 0, binding = 4, rg32ui) readonly uniform uimage2D surfacesBefore;
layout(set = 0, binding = 5, rgba16f) readonly uniform image2D meanBefore;  // w: number of samples
layout(set = 0, binding = 6, r16f) readonly uniform image2D deviationBefore;
layout(set = 0, binding = 7, rgba16f) writeonly uniform image2D mean;
layout(set = 0, binding = 8, r16f) writeonly uniform image2D deviation;
layout(set = 0, binding = 9, rgba32f) readonly uniform image2D changes;  // changes.comp

layout(push_constant, scalar) uniform Constants {
    Film filmBefore;
    float mostBefore;  // samples that count of those before
    float most;        // samples that count
    uint frame;        // a number, for random rounding
    uint hasChanges;   // `changes` are those of the frame
} constants;

// Earlier samples count for so many over the squared share by which light has changed: those that the filter
// averages of a pixel have a relative error of about the root of this.
const float kSamplesOfChange = 0.03f;
// A difference counts as far as it exceeds so many of its standard deviations.
const float kDeviations = 3.0f;

struct History {
    vec4 mean;
    float square;  // of the luminance
    float weight;
};

// Returns whether the pixel of the frame before saw the same surface: it has its number and its side, and
// lies in its plane. Both places are those of pixels' centers, each up to .7 pixels from that of the sample.
// What a mirror or glass shows is not where it seems to be, but has a similar depth.
bool IsSame(Surface now, vec3 offset, float depthThen, ivec2 pixel, uvec2 then) {
    if (NumberOf(then) != now.number) return false;
    if (now.number == kNothingHit) return true;
    float depth = DepthOf(then);
    vec3 normal = NormalOf(then);
    if (IsShown(now.number))
        return dot(now.normal, normal) > 0.7f && abs(depth - depthThen) < 0.1f * depthThen;
    float fromPlane = abs(dot(normal, offset - OffsetAt(constants.filmBefore, vec2(pixel) + 0.5f, depth)));
    return dot(now.normal, normal) > 0.7f &&
           fromPlane < 2.0f * FootprintAt(constants.filmBefore, depth) + 1e-3f * abs(depth);
}

void Take(inout History history, Surface now, vec3 offset, vec4 moved, ivec2 pixel, float weight) {
    if (!(weight > 0.0f) || !IsInside(pixel, imageSize(meanBefore))) return;
    if (!IsSame(now, offset, moved.z * now.depth, pixel, imageLoad(surfacesBefore, pixel).xy)) return;
    vec4 mean = imageLoad(meanBefore, pixel);
    float luminance = Luminance(mean.xyz), deviation = imageLoad(deviationBefore, pixel).x;
    history.mean += weight * mean;
    history.square += weight * (deviation * deviation + luminance * luminance);
    history.weight += weight;
}

History HistoryOf(ivec2 pixel, Surface now, vec4 moved) {
    History history;
    history.mean = vec4(0.0f);
    history.square = 0.0f;
    history.weight = 0.0f;
    if (moved.w == 0.0f || constants.mostBefore == 0.0f) return history;
    vec2 place = vec2(pixel) + 0.5f + ShiftOf(moved);
    if (!all(lessThan(abs(place), vec2(1e6f)))) return history;
    vec3 offset = OffsetAt(constants.filmBefore, place, moved.z * now.depth);
    ivec2 corner = ivec2(floor(place - 0.5f));
    vec2 part = place - 0.5f - vec2(corner);
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1);
        vec2 along = mix(1.0f - part, part, vec2(step));
        Take(history, now, offset, moved, corner + step, along.x * along.y);
    }
    if (history.weight > 0.01f) return history;
    // The surface covers a part of the pixel only, and was not what the sample before saw of it
    ivec2 nearest = ivec2(floor(place));
    for (int i = 0; i < 9; ++i)
        Take(history, now, offset, moved, nearest + ivec2(i % 3, i / 3) - 1, 1.0f);
    return history;
}

float ShareOf(vec3 sums) {
    return max(abs(sums.x) - kDeviations * sqrt(sums.y), 0.0f) / max(sums.z, 1e-6f);
}

// Returns how many earlier samples count by the change of the light around a pixel: in its block, or in all
// that are next to it, whichever tells more.
float MostBefore(ivec2 pixel) {
    if (constants.hasChanges == 0u) return constants.mostBefore;
    ivec2 block = pixel / int(kChangeBlock);
    vec3 sums = vec3(0.0f);
    for (int i = 0; i < 9; ++i) {
        ivec2 at = block + ivec2(i % 3, i / 3) - 1;
        if (IsInside(at, imageSize(changes))) sums += imageLoad(changes, at).xyz;
    }
    float share = max(ShareOf(imageLoad(changes, block).xyz), ShareOf(sums));
    return min(constants.mostBefore, kSamplesOfChange / (share * share + 1e-9f));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!IsInside(pixel, imageSize(mean))) return;
    vec4 color = imageLoad(albedo, pixel), moved = imageLoad(motion, pixel);
    vec3 value = LightOf(imageLoad(radiance, pixel), color);
    uvec2 texel = imageLoad(surfaces, pixel).xy;
    Surface now = Surface(NormalOf(texel), DepthOf(texel), NumberOf(texel));
    History history = HistoryOf(pixel, now, moved);
    vec4 newMean = vec4(value, 1.0f);
    float variance = 0.0f;
    if (history.weight > 0.0f) {
        history.mean /= history.weight;
        float average = Luminance(history.mean.xyz), away = Luminance(value) - average;
        variance = max(history.square / history.weight - average * average, 0.0f);
        // What surfaces that are not dull reflect does not move as they do
        float most = ShiftOf(moved) == vec2(0.0f) ? constants.most : max(constants.most * color.w, 2.0f);
        float count = min(min(history.mean.w, MostBefore(pixel)) + 1.0f, most);
        newMean = vec4(mix(history.mean.xyz, value, 1.0f / count), count);
        if (now.number == kNothingHit) newMean.xyz = value;  // the environment is sharp and has no noise
        variance = (1.0f - 1.0f / count) * (variance + away * away / count);
    }
    uint bits = RandomBits(pixel, constants.frame);
    imageStore(mean, pixel, ToHalf(newMean, bits));
    imageStore(deviation, pixel, ToHalf(vec4(sqrt(variance)), bits));
}
