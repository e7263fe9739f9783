// A kernel of a wavefront: shades what the rays of all paths in the queue found, and queues their next rays.
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

void Shade(uint slot, PathSettings settings) {
    ivec2 texel = TexelOf(slot);
    bool isFirst = wave.value.step == 0u;
    PathState path;
    if (isFirst) {
        path = PathOf(uvec2(texel));
        if (HasTraceFeature(kTraceProbeMedia)) path.media = LoadCameraMedia(slot);
        ClearGroups();
    } else {
        path = LoadPath(slot);
        LoadOutputs(texel, path);
    }
    DirectLight light = NoDirectLight();
    uint depth = path.depth;
    ++path.rayCount;
    bool isGoingOn = ShadeVertex(path, LoadHit(slot), settings, light);
    StoreOutputs(texel, path);
    if (HasTraceFeature(kTraceLightSampling)) {
        bool isLit = MaxComponent(light.radiance) > 0.0f;
        uint at = TakePlace(2u * wave.value.step + 1u, isLit);
        if (isLit) {
            ++path.rayCount;
            WaveShadow shadow;
            shadow.light = light;
            shadow.slot = slot;
            shadow.depth = depth + 1u;
            shadow.rayCount = path.rayCount;
            shadow.wavelength = path.wavelength;
            StoreShadow(at, shadow);
        }
    }
    isGoingOn = isGoingOn && path.rayCount < kMaxRays;
    if (isGoingOn) StorePath(slot, path);
    Enqueue(slot, isGoingOn);
}

void main() {
    PathSettings settings = SettingsOf(parameters.value);
    uint count = PathCount();
    uint total = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    for (uint i = gl_GlobalInvocationID.x; i < count; i += total) Shade(SlotAt(i), settings);
}
