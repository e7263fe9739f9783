// Shadows of punctual lights by the maps of shared/shadow_records.h. Occlusion between a point and a light is
// read from 4 x 4 texels, weighted so that the share grows evenly over three texels (percentage-closer
// filtering: Reeves, Salesin and Cook 1987, "Rendering Antialiased Shadows with Depth Maps").
//
// Bias: each texel is compared with the depth that the surface's own plane has there (Isidoro 2006, "Shadow
// Mapping: GPU-based Tips and Techniques"), at the point offset from the surface by half a texel along the
// geometric normal. A flat surface does not shadow itself; an occluder closer than half a texel casts no
// shadow.
#ifndef RAYGRAPH_RASTER_SHADOW_MAPS_GLSL
#define RAYGRAPH_RASTER_SHADOW_MAPS_GLSL

#include "core/frame.glsl"
#include "raster/projection.glsl"
#include "scene/bindings.glsl"
#include "shared/shadow_records.h"

layout(set = 0, binding = 18) uniform sampler2D shadowAtlas;
layout(set = 0, binding = 19, scalar) readonly buffer ShadowViews { ShadowView at[]; } shadowViews;
layout(set = 0, binding = 21, scalar) readonly buffer ShadowLights { ShadowLight at[]; } shadowLights;

const float kNormalOffset = 0.5f;  // texels

// Returns the face of a direction from a point light: +x, -x, +y, -y, +z, -z.
uint FaceOf(vec3 direction) {
    vec3 size = abs(direction);
    uint axis = size.x >= max(size.y, size.z) ? 0u : (size.y >= size.z ? 1u : 2u);
    return 2u * axis + (direction[axis] < 0.0f ? 1u : 0u);
}

// Lit share of the filter at a position in a tile: where the surface is nearer to the light than the map. Its
// depth grows by `slope` with the position.
float FilteredVisibility(uint view, vec2 place, float depth, vec2 slope) {
    int tilesPerSide = int(constants.shadowTiles);
    int tileSize = textureSize(shadowAtlas, 0).x / tilesPerSide;
    ivec2 corner = tileSize * ivec2(int(view) % tilesPerSide, int(view) / tilesPerSide);
    vec2 texel = place * float(tileSize) - 1.5f;
    ivec2 first = ivec2(floor(texel));
    vec2 part = texel - vec2(first);
    float share = 0.0f;
    for (int y = 0; y < 4; ++y) {
        float weightY = y == 0 ? 1.0f - part.y : (y == 3 ? part.y : 1.0f);
        for (int x = 0; x < 4; ++x) {
            float weightX = x == 0 ? 1.0f - part.x : (x == 3 ? part.x : 1.0f);
            ivec2 at = corner + clamp(first + ivec2(x, y), ivec2(0), ivec2(tileSize - 1));
            float seen = texelFetch(shadowAtlas, at, 0).x;  // reversed: greater is nearer
            vec2 way = (vec2(at - corner) + 0.5f) / float(tileSize) - place;
            share += depth + dot(slope, way) >= seen ? weightX * weightY : 0.0f;
        }
    }
    return share / 9.0f;
}

// Returns the position in a view's tile, in [0, 1], and the depth.
vec3 ProjectToTile(CameraRecord camera, vec3 position) {
    vec4 clip = ClipPosition(camera, position, vec2(0.0f));
    return vec3(0.5f * clip.xy / clip.w + 0.5f, clip.z / clip.w);
}

// Returns the gradient of depth along a plane; it is constant, in perspective too.
vec2 SlopeOf(CameraRecord camera, vec3 position, vec3 normal, float step, vec3 place) {
    Frame plane = FrameFromZ(normal);
    vec3 x = ProjectToTile(camera, position + step * plane.x) - place;
    vec3 y = ProjectToTile(camera, position + step * plane.y) - place;
    float area = x.x * y.y - x.y * y.x;
    if (abs(area) < 1e-3f * (dot(x.xy, x.xy) + dot(y.xy, y.xy))) return vec2(0.0f);  // seen from its edge
    return vec2(x.z * y.y - y.z * x.y, y.z * x.x - x.z * y.x) / area;
}

// `light` is an ordinal among the punctual lights; wi is the direction to it.
float ShadowMapVisibility(uint light, uint kind, vec3 position, vec3 normal, vec3 wi) {
    ShadowLight shadow = shadowLights.at[light];
    if (shadow.viewCount == 0u) return 1.0f;
    if (dot(normal, wi) < 0.0f) normal = -normal;
    uint first = shadow.firstView;
    uint last = shadow.firstView + shadow.viewCount;
    if (kind != kLightDirectional) {
        if (shadow.viewCount == kShadowFaces) first += FaceOf(position - shadowViews.at[first].camera.origin);
        last = first + 1u;
    }
    // The first cascade that contains the point: it has the smallest texels
    for (uint view = first; view < last; ++view) {
        CameraRecord camera = shadowViews.at[view].camera;
        float texel = shadowViews.at[view].texel;
        if (camera.orthographic == 0u) texel *= max(dot(position - camera.origin, camera.forward), 0.0f);
        vec3 off = position + kNormalOffset * texel * normal;
        if (camera.orthographic == 0u && !(dot(off - camera.origin, camera.forward) > 0.0f)) continue;
        vec3 place = ProjectToTile(camera, off);
        vec2 fromMiddle = abs(2.0f * place.xy - 1.0f);
        float margin = 4.0f * float(constants.shadowTiles) / float(textureSize(shadowAtlas, 0).x);
        bool isInside = max(fromMiddle.x, fromMiddle.y) < 1.0f - margin;
        if (isInside || view + 1u == last) {
            if (max(fromMiddle.x, fromMiddle.y) > 1.0f) return 1.0f;
            return FilteredVisibility(view, place.xy, place.z, SlopeOf(camera, off, normal, texel, place));
        }
    }
    return 1.0f;
}

#endif
