// RasterShade with shadow maps, without films and stretched highlights.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SHADOW_MAPS
#define PLAIN_SURFACES
#include "raster/shade_main.glsl"
