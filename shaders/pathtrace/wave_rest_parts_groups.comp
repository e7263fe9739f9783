#version 460
#extension GL_GOOGLE_include_directive : require
#define OWN_TRAVERSAL
#define PATH_PARTS
#define LIGHT_GROUPS
#include "pathtrace/wave_rest_main.glsl"
