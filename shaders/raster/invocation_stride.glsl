// For compute shaders that take one record after the other: devices bound the groups of a dispatch, so that
// an invocation takes every InvocationStride()-th record. The groups are those of GroupsFor
// (passes/draw_list.h).
#ifndef RAYGRAPH_RASTER_INVOCATION_STRIDE_GLSL
#define RAYGRAPH_RASTER_INVOCATION_STRIDE_GLSL

layout(local_size_x = 64) in;  // before gl_WorkGroupSize, which else is 1

uint InvocationStride() { return gl_NumWorkGroups.x * gl_WorkGroupSize.x; }

#endif
