// The stage of kernels that trace: ray generation or, where SOFTWARE_TRAVERSAL is defined, compute
// (scene/trace_rays.glsl). Included before all else.
#ifndef RAYGRAPH_PATHTRACE_LAUNCH_GLSL
#define RAYGRAPH_PATHTRACE_LAUNCH_GLSL

#ifdef SOFTWARE_TRAVERSAL
#define NO_TLAS
layout(local_size_x = 64) in;

uint LaunchIndex() { return gl_GlobalInvocationID.x; }
uint LaunchSize() { return gl_NumWorkGroups.x * gl_WorkGroupSize.x; }
#else
#extension GL_EXT_ray_tracing : require

uint LaunchIndex() { return gl_LaunchIDEXT.x; }
uint LaunchSize() { return gl_LaunchSizeEXT.x; }
#endif

#endif
