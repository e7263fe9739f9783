#version 460
#extension GL_GOOGLE_include_directive : require
#define WITH_COUNTS
#include "post/resolve_main.glsl"
