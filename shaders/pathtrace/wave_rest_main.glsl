// The last kernel of a wavefront that traces: the paths that are left, each to its end.
#version 460
#extension GL_GOOGLE_include_directive : require
#define TRACES_SHADOW_RAYS
#define SINGLE_TRACE_CALL
#define OUTPUTS_ARE_READ
#include "pathtrace/launch.glsl"
#include "scene/extensions.glsl"

#include "scene/camera.glsl"
#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"
#include "scene/surface.glsl"
#include "scene/trace_rays.glsl"

#include "pathtrace/outputs.glsl"
#include "pathtrace/wave_state.glsl"

#include "integrator/extend_path.glsl"

void main() {
    PathSettings settings = SettingsOf(parameters.value);
    uint count = PathCount();
    uint slot = 0u;
    PathState path;
    uint rays = 0u;  // does not include the rays of the other kernels
    bool isAlive = false;
    while (true) {
        if (!isAlive) {
            uint i = atomicAdd(pixelQueue.acquiredCount, 1u);
            if (i >= count) break;
            slot = SlotAt(i);
            path = LoadPath(slot);
            LoadOutputs(TexelOf(slot), path);
            rays -= path.rayCount;
        }
        isAlive = ExtendPath(path, settings);
        if (isAlive) continue;
        rays += path.rayCount;
        StoreOutputs(TexelOf(slot), path);
    }
    CountRays(rays);
}
