#version 460
#extension GL_GOOGLE_include_directive : require
#define LIGHT_GROUPS
#include "pathtrace/wave_shade_main.glsl"
