// RasterShade with shadow maps.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SHADOW_MAPS
#include "raster/shade_main.glsl"
