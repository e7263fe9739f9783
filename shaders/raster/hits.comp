// RasterHits: the outputs of PrimaryHits, for the raster view.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/pixel.glsl"
#include "scene/primary_outputs.glsl"

void main() {
    if (IsInPicture()) StorePrimaryHit(Pixel(), PixelHit(), PixelRay());
}
