// The last kernel of a wavefront: samples are finished (outputs.glsl), and rays are counted that no other
// kernel counts: those which the queues name.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#define OUTPUTS_ARE_READ
#include "scene/extensions.glsl"

#include "scene/camera.glsl"
#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"
#include "scene/surface.glsl"

#include "pathtrace/outputs.glsl"
#include "pathtrace/wave_state.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (texel == ivec2(0)) {
        // The paths of the last queue are those of the kernel before this one
        uint rays = wave.value.firstPaths;
        for (uint step = 0u; step < wave.value.step; ++step)
            rays += waveCounts.at[2u * step] + waveCounts.at[2u * step + 1u];
        CountRays(rays);
    }
    if (any(greaterThanEqual(texel, imageSize(radiance)))) return;
    PathState path;
    vec4 stored = imageLoad(radiance, texel);
    path.radiance = stored.xyz;
    path.alpha = stored.w;
    if (IsFinite(path.radiance) && !IsCaught(path)) return;
    LoadOutputs(texel, path);
    FinishSample(path);
    StoreOutputs(texel, path);
}
