// The pixel of an invocation that reads the visibility texture: one invocation a pixel, of compute, or of ray
// generation where PIXEL_BY_RAY_GENERATION is defined.
#ifndef RAYGRAPH_RASTER_PIXEL_GLSL
#define RAYGRAPH_RASTER_PIXEL_GLSL

#include "raster/visibility.glsl"
#include "scene/bindings.glsl"
#include "scene/camera.glsl"

#ifndef PIXEL_BY_RAY_GENERATION
layout(local_size_x = 8, local_size_y = 8) in;
#endif
layout(set = 0, binding = 20, rgba32ui) readonly uniform uimage2D visibility;
layout(push_constant, scalar) uniform Constants {
    vec2 filmOffset;  // position in a pixel, from its upper left corner: (0.5, 0.5) is its center
    uint punctualLights;
    uint option;       // SurfaceView: of shared/choice.h; RasterShade: of shared/shade_options.h
    uint shadowTiles;  // tiles per side of the atlas
} constants;

#ifdef PIXEL_BY_RAY_GENERATION
ivec2 Pixel() { return ivec2(gl_LaunchIDEXT.xy); }
#else
ivec2 Pixel() { return ivec2(gl_GlobalInvocationID.xy); }
#endif

bool IsInPicture() { return all(lessThan(Pixel(), imageSize(visibility))); }

// Through the film position that was drawn, so many pixels away.
Ray RayThrough(vec2 offset) {
    vec2 pixel = vec2(Pixel() + ivec2(parameters.value.regionOffset));
    vec2 film = (pixel + constants.filmOffset + offset) / vec2(parameters.value.pictureSize);
    return CameraRay(parameters.value.camera, film, vec2(0.5f));
}
Ray PixelRay() { return RayThrough(vec2(0.0f)); }

Hit PixelHit() { return UnpackVisibility(imageLoad(visibility, Pixel())); }

#endif
