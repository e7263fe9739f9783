#version 460
#extension GL_GOOGLE_include_directive : require
#define WITH_COUNTS
#define WITH_VARIANCE
#include "post/resolve_main.glsl"
