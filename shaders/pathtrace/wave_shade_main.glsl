// A kernel of a wavefront: shades what the rays of all paths in the queue found, and queues their next rays.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#define OUTPUTS_ARE_READ
#define WAVE_WRITES_PATHS
#define WAVE_WRITES_SHADOWS
#define WAVE_WRITES_QUEUES
#include "scene/extensions.glsl"

#include "scene/camera.glsl"
#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"
#include "scene/surface.glsl"

#include "pathtrace/outputs.glsl"
#include "pathtrace/wave_state.glsl"

layout(local_size_x = 64) in;

// Shades the path and stores what it has collected. False: it ends here. `light` becomes what a shadow ray
// must confirm, at `depth`.
bool Shade(uint slot, PathSettings settings, out PathState path, inout DirectLight light, out uint depth) {
    ivec2 texel = TexelOf(slot);
    if (wave.value.step == 0u) {
        path = PathOf(uvec2(texel));
        if (HasTraceFeature(kTraceProbeMedia)) path.media = LoadCameraMedia(slot);
        ClearGroups();
        if (IsPastListEnd(uvec2(texel))) {  // black, so that later kernels need not ask
            StoreOutputs(texel, path);
            return false;
        }
    } else {
        path = LoadPath(slot);
        LoadOutputs(texel, path);
    }
    depth = path.depth + 1u;
    ++path.rayCount;
    bool isAlive = ShadeVertex(path, LoadHit(slot), settings, light);
    StoreOutputs(texel, path);
    return isAlive;
}

void main() {
    PathSettings settings = SettingsOf(parameters.value);
    uint count = PathCount();
    uint total = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    // All invocations of a group take the same number of turns.
    for (uint first = gl_WorkGroupID.x * gl_WorkGroupSize.x; first < count; first += total) {
        uint i = first + gl_LocalInvocationIndex;
        uint slot = 0u, depth = 0u;
        PathState path;
        DirectLight light = NoDirectLight();
        bool isAlive = false;
        if (i < count) {
            slot = SlotAt(i);
            isAlive = Shade(slot, settings, path, light, depth);
        }
        bool isLit = HasTraceFeature(kTraceLightSampling) && MaxComponent(light.radiance) > 0.0f;
        if (isLit) ++path.rayCount;
        isAlive = isAlive && path.rayCount < kMaxRays;
        uvec2 place = ReserveQueueEntries(isAlive, isLit);
        if (isLit) {
            WaveShadow shadow;
            shadow.light = light;
            shadow.slot = slot;
            shadow.depth = depth;
            shadow.rayCount = path.rayCount;
            shadow.wavelength = path.wavelength;
            StoreShadow(place.y, shadow);
        }
        if (isAlive) {
            StorePath(slot, path);
            Enqueue(slot, place.x);
        }
    }
}
