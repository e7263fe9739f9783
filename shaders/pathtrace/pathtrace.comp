#version 460
#extension GL_GOOGLE_include_directive : require
#define OWN_TRAVERSAL
#include "pathtrace/pathtrace_main.glsl"
