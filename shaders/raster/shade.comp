// RasterShade without shadows.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "raster/shade_main.glsl"
