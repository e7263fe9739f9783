#version 460
#extension GL_GOOGLE_include_directive : require
#include "post/accumulate_main.glsl"
