// Version 1 of the second limit: the rays of limit_path by own traversal.
#version 460
#extension GL_GOOGLE_include_directive : require
#define OWN_TRAVERSAL
#define LIMIT_BOUNCES 4
#include "bench/limit_main.glsl"
