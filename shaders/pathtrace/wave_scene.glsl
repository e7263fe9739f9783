// The scene as the kernels of a wavefront include it. Compute kernels define NO_TLAS.
#include "scene/extensions.glsl"

#include "scene/camera.glsl"
#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"
#include "scene/surface.glsl"
