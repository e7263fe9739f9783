// Fragments of Overdraw: one each, added up by blending.
#version 460
layout(location = 0) out float count;

void main() { count = 1.0f; }
