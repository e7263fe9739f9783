// RasterShade without shadows, without films and stretched highlights.
#version 460
#extension GL_GOOGLE_include_directive : require
#define PLAIN_SURFACES
#include "raster/shade_main.glsl"
