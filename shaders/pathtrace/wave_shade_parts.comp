#version 460
#extension GL_GOOGLE_include_directive : require
#define PATH_PARTS
#include "pathtrace/wave_shade_main.glsl"
