// A kernel of a wavefront: the camera rays of all texels.
#version 460
#extension GL_GOOGLE_include_directive : require
#define WAVE_WRITES_PATHS
#define WAVE_WRITES_HITS
#include "pathtrace/launch.glsl"
#include "scene/extensions.glsl"

#include "scene/camera.glsl"
#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"
#include "scene/surface.glsl"
#include "scene/trace_rays.glsl"

#include "integrator/camera_media.glsl"
#include "pathtrace/wave_state.glsl"

void main() {
    for (uint slot = LaunchIndex(); slot < PixelCount(); slot += LaunchSize()) {
        if (IsPastListEnd(uvec2(TexelOf(slot)))) continue;
        PathState path = PathOf(uvec2(TexelOf(slot)));
        // All rays of a pinhole camera start at one point.
        if (HasTraceFeature(kTraceProbeMedia) && (slot == 0u || wave.value.isProbedOnce == 0u))
            StoreCameraMedia(slot, MediaAround(path.ray.origin));
        StoreHit(slot, Intersect(path.ray, AlphaSeed(path.rng, 1u)));
    }
}
