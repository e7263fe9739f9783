// A kernel of a wavefront: traces the next ray of all paths in the queue, and the shadow rays of the step
// before, whose light it adds. Both at once: a device waits for the longest ray of a launch. Where the way to
// a light may take more than one ray, which the number of the path's next ray depends on, shadow rays have a
// launch of their own.
#version 460
#extension GL_GOOGLE_include_directive : require
#define TRACES_SHADOW_RAYS
#define OUTPUTS_ARE_READ
#define WAVE_WRITES_PATHS
#define WAVE_WRITES_HITS
#include "pathtrace/launch.glsl"
#include "scene/extensions.glsl"

#include "scene/camera.glsl"
#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"
#include "scene/surface.glsl"
#include "scene/trace_rays.glsl"

#include "pathtrace/outputs.glsl"
#include "pathtrace/wave_state.glsl"

#include "integrator/share_through_media.glsl"

void TracePath(uint slot) {
    PathState path = LoadRay(slot);
    StoreHit(slot, Intersect(path.ray, AlphaSeed(RngOf(uvec2(TexelOf(slot))), path.rayCount + 1u)));
}

// Returns how many rays it took beyond the one that was planned.
uint TraceShadow(uint at, PathSettings settings) {
    WaveShadow shadow = LoadShadow(at);
    ivec2 texel = TexelOf(shadow.slot);
    Sampler rng = RngOf(uvec2(texel));
    vec3 share = vec3(0.0f);
    uint planned = shadow.rayCount;
    if (HasTraceFeature(kTraceMatchedMedia)) {
        share = MediaTransmittance(shadow.light, shadow.wavelength, rng, shadow.rayCount);
        StoreRayCount(shadow.slot, shadow.rayCount);
    } else {
        share = ShadowTransmittance(shadow.light.ray, shadow.light.distance, shadow.light.ior,
                               AlphaSeed(rng, shadow.rayCount));
    }
    if (!(MaxComponent(share) > 0.0f)) return shadow.rayCount - planned;
    PathState path;
    LoadOutputs(texel, path);
    Collect(path, shadow.light.radiance * share, shadow.depth, shadow.light.lobe, shadow.light.light,
            shadow.light.triangle, settings);
    StoreOutputs(texel, path);
    return shadow.rayCount - planned;
}

void main() {
    PathSettings settings = SettingsOf(parameters.value);
    uint paths = (wave.value.traces & kWaveTracesPaths) != 0u ? PathCount() : 0u;
    uint shadows = (wave.value.traces & kWaveTracesShadows) != 0u ? ShadowCount() : 0u;
    uint unplanned = 0u;
    for (uint i = LaunchIndex(); i < paths + shadows; i += LaunchSize()) {
        if (i < paths)
            TracePath(SlotAt(i));
        else
            unplanned += TraceShadow(i - paths, settings);
    }
    CountRays(unplanned);
}
