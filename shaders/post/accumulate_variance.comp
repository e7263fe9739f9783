#version 460
#extension GL_GOOGLE_include_directive : require
#define WITH_VARIANCE
#include "post/accumulate_main.glsl"
