// Occlusion: the unoccluded share of the directions above a surface, weighted by the cosine, in screen space.
// Horizons are searched along lines through the pixel, and between them the share is integrated in closed
// form: Jimenez, Wu, Pesce and Jarabo 2016, "Practical Real-Time Strategies for Accurate Indirect Occlusion"
// (GTAO), SIGGRAPH course. Lines and steps are turned and shifted from sample to sample.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "core/rng.glsl"
#include "raster/pixel.glsl"
#include "raster/raster_depth.glsl"
#include "scene/surface.glsl"

layout(set = 0, binding = 16, r32f) writeonly uniform image2D ambientVisibility;
layout(set = 0, binding = 17) uniform sampler2D depths;

const uint kLines = 3u;
const uint kSteps = 8u;                // on each side
const float kReach = 0.4f;             // fraction of the picture's height
const float kFade = 0.25f;             // last part of the reach
const uint kOcclusionDimension = 64u;  // first dimension of the pixel's random numbers

// Gives the surface in a pixel, as the depth buffer has it. Returns false if there is none.
bool PositionAt(ivec2 pixel, out vec3 position) {
    float depth = texelFetch(depths, pixel, 0).x;
    if (depth == 0.0f) return false;
    position = PositionAtRasterDepth(parameters.value.camera, RayThrough(vec2(pixel - Pixel())), depth);
    return true;
}

// Returns the cosine between wo and the horizon along a line of the screen (unit vector, so many pixels
// long), at least `lowest`, that of the surface's own plane. Occluders fade out up to the reach.
float HorizonCosine(vec3 position, vec3 wo, vec2 line, float pixels, float shift, float reach, float lowest) {
    float highest = lowest;
    for (uint i = 0u; i < kSteps; ++i) {
        float way = (float(i) + shift) / float(kSteps);
        ivec2 pixel = Pixel() + ivec2(round(line * mix(1.0f, pixels, way * way)));
        if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, imageSize(visibility)))) break;
        vec3 other;
        if (!PositionAt(pixel, other)) continue;
        vec3 offset = other - position;
        float distance = length(offset);
        float weight = clamp((1.0f - distance / reach) / kFade, 0.0f, 1.0f);
        highest = max(highest, mix(lowest, dot(offset, wo) / max(distance, 1e-20f), weight));
    }
    return highest;
}

// Returns one side's part of the integral, up to the horizon at angle h; n is the angle of the normal.
float Arc(float h, float n) { return 0.25f * (cos(n) + 2.0f * h * sin(n) - cos(2.0f * h - n)); }

float AmbientVisibility(vec3 position, vec3 normal, vec3 wo) {
    CameraRecord camera = parameters.value.camera;
    float depth = camera.orthographic != 0u ? 1.0f : dot(position - camera.origin, camera.forward);
    float reach = 2.0f * kReach * length(camera.up) * depth;
    float pixels = max(kReach * float(imageSize(visibility).y), 1.0f);
    Sampler rng = StartPixelSample(uvec2(Pixel()), parameters.value.sampleIndex, parameters.value.seed);
    rng.dimension = kOcclusionDimension;
    vec2 random = Get2D(rng);
    float sum = 0.0f;
    for (uint i = 0u; i < kLines; ++i) {
        float angle = kPi * (float(i) + random.x) / float(kLines);
        vec2 line = vec2(cos(angle), sin(angle));
        vec3 along = line.x * normalize(camera.right) - line.y * normalize(camera.up);
        vec3 across = along - dot(along, wo) * wo;
        vec3 axis = normalize(cross(across, wo));
        vec3 inPlane = normal - dot(normal, axis) * axis;
        float size = max(length(inPlane), 1e-6f);
        float cosine = clamp(dot(inPlane, wo) / size, -1.0f, 1.0f);
        float n = dot(across, inPlane) < 0.0f ? -acos(cosine) : acos(cosine);
        float right = HorizonCosine(position, wo, line, pixels, random.y, reach, cos(n + kPiOver2));
        float left = HorizonCosine(position, wo, -line, pixels, random.y, reach, cos(n - kPiOver2));
        float up = n + min(acos(clamp(right, -1.0f, 1.0f)) - n, kPiOver2);
        float down = n + max(-acos(clamp(left, -1.0f, 1.0f)) - n, -kPiOver2);
        sum += size * (Arc(up, n) + Arc(down, n));
    }
    return clamp(sum / float(kLines), 0.0f, 1.0f);
}

void main() {
    if (!IsInPicture()) return;
    float share = 1.0f;
    Hit hit = PixelHit();
    if (IsHit(hit)) {
        Ray ray = PixelRay();
        SurfaceInteraction surface = SurfaceAt(hit, ray);
        share = AmbientVisibility(surface.position, surface.shadingNormal, -ray.direction);
    }
    imageStore(ambientVisibility, Pixel(), vec4(share));
}
