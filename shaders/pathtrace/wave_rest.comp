#version 460
#extension GL_GOOGLE_include_directive : require
#define OWN_TRAVERSAL
#include "pathtrace/wave_rest_main.glsl"
