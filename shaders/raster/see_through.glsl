// The light behind glass, in screen space: the picture without glass, read where the refracted ray leaves it,
// blurred by the surface's roughness. Approximations: the ray goes straight from the front of a volume to the
// surface behind the glass in the pixel, whose depth is taken for its whole surroundings; there is no glass
// behind glass; a volume absorbs nothing; beyond the screen there is only the environment.
#ifndef RAYGRAPH_RASTER_SEE_THROUGH_GLSL
#define RAYGRAPH_RASTER_SEE_THROUGH_GLSL

#include "raster/environment_lobes.glsl"
#include "raster/projection.glsl"
#include "raster/raster_depth.glsl"
#include "shared/blur_levels.h"

layout(set = 0, binding = 23) uniform sampler2D behind;
layout(set = 0, binding = 24) uniform sampler2D behindBlurred;
layout(set = 0, binding = 25) uniform sampler2D behindDepth;

// Returns color times alpha, and alpha, of a level about a position in pixels.
vec4 SampleBackgroundLevel(vec2 place, uint level) {
    uvec2 size = uvec2(textureSize(behind, 0));
    if (level == 0u) {
        vec4 value = textureLod(behind, place / vec2(size), 0.0f);
        return vec4(value.xyz * value.w, value.w);
    }
    vec2 levelSize = vec2(BlurSize(size.x, level), BlurSize(size.y, level));
    vec2 texel = clamp(place / float(1u << level), vec2(0.5f), levelSize - 0.5f);
    texel.y += float(BlurRow(size.y, level));
    return textureLod(behindBlurred, texel / vec2(textureSize(behindBlurred, 0)), 0.0f);
}

// Returns the depth of the surface behind the glass in the pixel; where there is none, that of the nearest
// one around it.
float DepthBehind() {
    float depth = texelFetch(behindDepth, Pixel(), 0).x;
    ivec2 size = textureSize(behindDepth, 0);
    for (int i = 0; i < 16 && depth == 0.0f; ++i) {
        float angle = kTwoPi * float(i & 7) / 8.0f;
        vec2 offset = (i < 8 ? 0.04f : 0.12f) * float(size.y) * vec2(cos(angle), sin(angle));
        ivec2 place = clamp(Pixel() + ivec2(offset), ivec2(0), size - 1);
        depth = texelFetch(behindDepth, place, 0).x;
    }
    return depth;
}

// Radiance transmitted by a surface along wo, before the surface's own color. `through` is the direction
// behind it, and `spread` the standard deviation of its slope.
vec3 TransmittedRadiance(vec3 position, vec3 through, float spread, float roughness) {
    CameraRecord camera = parameters.value.camera;
    vec2 size = vec2(textureSize(behind, 0));
    vec3 environment = GlossyEnvironment(through, roughness);
    float depth = DepthBehind();
    float forward = dot(through, camera.forward);
    if (depth == 0.0f || forward <= 0.0f) return environment;
    float far = DistanceOf(camera, depth);
    float way = max(far - dot(position - camera.origin, camera.forward), 0.0f) / forward;
    vec4 clip = ClipPosition(camera, position + way * through, vec2(0.0f));
    vec2 film = 0.5f * clip.xy / clip.w + 0.5f;
    if (any(lessThan(film, vec2(0.0f))) || any(greaterThan(film, vec2(1.0f)))) return environment;
    vec2 place = film * size - constants.filmOffset + 0.5f;
    float pixelsPerMeter =
        0.5f * size.y / (length(camera.up) * (camera.orthographic != 0u ? 1.0f : far));
    float level = clamp(log2(max(2.0f * spread * way * pixelsPerMeter, 1.0f)), 0.0f, float(kBlurLevels));
    uint lower = min(uint(level), kBlurLevels - 1u);
    vec4 value = mix(SampleBackgroundLevel(place, lower), SampleBackgroundLevel(place, lower + 1u),
                     level - float(lower));
    return value.xyz + (1.0f - value.w) * environment;
}

#endif
