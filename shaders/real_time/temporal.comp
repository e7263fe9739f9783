// AccumulateMoving: adds a sample of each pixel to the mean of those that its surface had in earlier frames.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "core/color.glsl"
#include "real_time/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D radiance;  // rows below the picture are unused
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D albedo;  // w: dullness
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D surfaces;
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D motion;
layout(set = 0, binding = 4, rgba32f) readonly uniform image2D surfacesBefore;
layout(set = 0, binding = 5, rgba32f) readonly uniform image2D meanBefore;  // w: number of samples
layout(set = 0, binding = 6, r32f) readonly uniform image2D squareBefore;
layout(set = 0, binding = 7, rgba32f) writeonly uniform image2D mean;
layout(set = 0, binding = 8, r32f) writeonly uniform image2D square;

layout(push_constant, scalar) uniform Constants {
    Film filmBefore;
    float mostBefore;  // samples that count of those before
    float most;        // samples that count
} constants;

struct History {
    vec4 mean;
    float square;
    float weight;
};

// Returns whether the pixel of the frame before saw the same surface: it has its number and its side, and
// lies in its plane. Both places are those of pixels' centers, each up to .7 pixels from that of the sample.
bool IsSame(Surface now, vec3 offset, ivec2 pixel, Surface then) {
    if (then.number != now.number) return false;
    if (now.number == 0.0f) return true;
    vec3 thenOffset = OffsetAt(constants.filmBefore, vec2(pixel) + 0.5f, then.depth);
    float fromPlane = abs(dot(then.normal, offset - thenOffset));
    return dot(now.normal, then.normal) > 0.7f &&
           fromPlane < 2.0f * FootprintAt(constants.filmBefore, then.depth) + 1e-3f * abs(then.depth);
}

void Take(inout History history, Surface now, vec3 offset, ivec2 pixel, float weight) {
    if (!(weight > 0.0f) || !IsInside(pixel, imageSize(meanBefore))) return;
    if (!IsSame(now, offset, pixel, UnpackSurface(imageLoad(surfacesBefore, pixel)))) return;
    history.mean += weight * imageLoad(meanBefore, pixel);
    history.square += weight * imageLoad(squareBefore, pixel).x;
    history.weight += weight;
}

History HistoryOf(ivec2 pixel, Surface now, vec4 moved) {
    History history;
    history.mean = vec4(0.0f);
    history.square = 0.0f;
    history.weight = 0.0f;
    if (moved.w == 0.0f || constants.mostBefore == 0.0f) return history;
    vec2 shift = moved.xy;
    if (dot(shift, shift) < 1e-4f) shift = vec2(0.0f);  // rounding must not blur what stands still
    vec2 place = vec2(pixel) + 0.5f + shift;
    if (!all(lessThan(abs(place), vec2(1e6f)))) return history;
    vec3 offset = OffsetAt(constants.filmBefore, place, moved.z);
    ivec2 corner = ivec2(floor(place - 0.5f));
    vec2 part = place - 0.5f - vec2(corner);
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1);
        vec2 along = mix(1.0f - part, part, vec2(step));
        Take(history, now, offset, corner + step, along.x * along.y);
    }
    if (history.weight > 0.01f) return history;
    // The surface covers a part of the pixel only, and was not what the sample before saw of it
    ivec2 nearest = ivec2(floor(place));
    for (int i = 0; i < 9; ++i)
        Take(history, now, offset, nearest + ivec2(i % 3, i / 3) - 1, 1.0f);
    return history;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!IsInside(pixel, imageSize(mean))) return;
    vec4 color = imageLoad(albedo, pixel), moved = imageLoad(motion, pixel);
    vec3 value = FiniteOr0(imageLoad(radiance, pixel).xyz) / max(color.xyz, vec3(0.01f));
    float luminance = Luminance(value);
    Surface now = UnpackSurface(imageLoad(surfaces, pixel));
    History history = HistoryOf(pixel, now, moved);
    vec4 newMean = vec4(value, 1.0f);
    float newSquare = luminance * luminance;
    if (history.weight > 0.0f) {
        history.mean /= history.weight;
        // A mirror's picture does not move as its surface does
        float most = moved.xy == vec2(0.0f) ? constants.most : max(constants.most * color.w, 2.0f);
        float count = min(min(history.mean.w, constants.mostBefore) + 1.0f, most);
        newMean = vec4(mix(history.mean.xyz, value, 1.0f / count), count);
        if (now.number == 0.0f) newMean.xyz = value;  // the environment is sharp and has no noise
        newSquare = mix(history.square / history.weight, newSquare, 1.0f / count);
    }
    imageStore(mean, pixel, newMean);
    imageStore(square, pixel, vec4(newSquare));
}
