#version 460
#extension GL_GOOGLE_include_directive : require
#define OWN_TRAVERSAL
#define LIMIT_BOUNCES 4
#define COUNT_RAYS
#include "bench/limit_main.glsl"
