// Converts the nearest triangle of each pixel to the texels of the visibility texture.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/chunks.glsl"
#include "raster/triangle.glsl"
#include "raster/visibility.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 19, scalar) readonly buffer Nearest { uint64_t at[]; } nearest;
layout(set = 0, binding = 20, rgba32ui) writeonly uniform uimage2D visibility;
layout(set = 0, binding = 21, r32f) writeonly uniform image2D rasterDepth;
layout(push_constant, scalar) uniform Constants { vec2 shift; uint drawCount; } constants;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(visibility);
    if (any(greaterThanEqual(pixel, size))) return;
    uvec2 key = unpackUint2x32(nearest.at[pixel.y * size.x + pixel.x]);
    uvec4 texel = uvec4(0u);
    DrawnTriangle source;
    if (key.y != 0u && FindTriangle(key.x, constants.drawCount, source)) {
        CameraRecord camera = parameters.value.camera;
        PictureTriangle triangle =
            ProjectTriangle(source.placement, source.primitive, camera.origin,
                            OffsetToPicture(camera, constants.shift, uvec2(size)));
        vec3 edges = EdgesAt(triangle, vec2(pixel) + 0.5f);
        texel = PackVisibility(source.placement, source.primitive, BarycentricsOf(edges));
    }
    imageStore(visibility, pixel, texel);
    imageStore(rasterDepth, pixel, vec4(uintBitsToFloat(key.y)));
}
