// Tonemap: radiance to display values, in a region of the display. Radiance of another extent is scaled, each
// pixel from the texel that it lies in. Where it has a backdrop, display values are mixed in linear light.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "core/color.glsl"
#include "core/equirect.glsl"
#include "core/tonemap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform sampler2D radiance;
layout(set = 0, binding = 1, rgba8) uniform image2D display;

layout(push_constant, scalar) uniform Constants {
    uvec2 offset;  // position of the region
    uvec2 size;
    float exposureEv;
    uint tonemapOperator;
    uint flags;
    vec4 whiteBalance[3];  // columns
} constants;

layout(set = 0, binding = 2) uniform sampler2D backdropMap;
layout(set = 0, binding = 3, scalar) uniform Backdrop {
    vec3 right, up, forward;  // of the camera, as in CameraRecord
    uint isOrthographic;
    vec3 radiance;  // factor on the map
    float rotation;
    vec3 color;
    vec2 offset, scale;  // from the display, 0 to 1, to the camera's picture, 0 to 1
} backdrop;

// kBacked: there is a backdrop; kColored: it is `color`; kMapped: its radiance has a map
const uint kOpaque = 1u, kUnassociated = 2u, kBalanced = 4u, kBacked = 8u, kColored = 16u, kMapped = 32u;

bool Has(uint flag) { return (constants.flags & flag) != 0u; }

vec3 Balanced(vec3 color) {
    vec4 columns[3] = constants.whiteBalance;
    return mat3(columns[0].xyz, columns[1].xyz, columns[2].xyz) * color;
}

vec3 Shown(vec3 color) {
    return Tonemap(Has(kBalanced) ? Balanced(color) : color, constants.exposureEv, constants.tonemapOperator);
}

// Returns what is behind the pixel, in linear display values.
vec3 Behind(ivec2 pixel) {
    if (Has(kColored)) return backdrop.color;
    vec3 radiance = backdrop.radiance;
    if (Has(kMapped)) {
        vec2 film = backdrop.offset + backdrop.scale * (vec2(pixel) + 0.5f) / vec2(imageSize(display));
        vec3 direction = backdrop.forward;
        if (backdrop.isOrthographic == 0u)
            direction += (2.0f * film.x - 1.0f) * backdrop.right + (1.0f - 2.0f * film.y) * backdrop.up;
        radiance *= textureLod(backdropMap, EquirectFromDirection(direction, backdrop.rotation), 0.0f).xyz;
    }
    return SrgbDecode(Shown(radiance));
}

void main() {
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, constants.size))) return;
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy + constants.offset);
    vec4 value = texelFetch(radiance, pixel * textureSize(radiance, 0) / imageSize(display), 0);
    vec3 color = value.xyz;
    float alpha = Has(kOpaque) ? 1.0f : clamp(value.w, 0.0f, 1.0f);
    if (Has(kUnassociated)) {
        // Display values end at 1, so a color that is brighter than its alpha would lose light. Beside what
        // sends light to a shadow catcher, alpha may even be negative.
        vec3 light = SrgbDecode(Shown(color));
        float coverage = max(clamp(value.w, 0.0f, 1.0f), max(light.x, max(light.y, light.z)));
        if (!Has(kOpaque)) alpha = coverage;
        color = coverage > 0.0f ? color / coverage : vec3(0.0f);
    }
    vec3 shown = Shown(color);
    if (Has(kBacked)) {
        if (alpha < 1.0f) shown = SrgbEncode(mix(Behind(pixel), SrgbDecode(shown), alpha));
        alpha = 1.0f;
    }
    imageStore(display, pixel, vec4(shown, alpha));
}
