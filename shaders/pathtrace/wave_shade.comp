// A kernel of a wavefront: shades what the rays of the queue found, and queues the next rays.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
#define NO_TLAS
#define WAVE_QUEUES
#include "pathtrace/wave_scene.glsl"

#include "integrator/path.glsl"
#include "pathtrace/start.glsl"
#include "pathtrace/wave_state.glsl"

layout(local_size_x = 64) in;

void main() {
    PathSettings settings = SettingsOf(parameters.value);
    uint count = LiveCount();
    uint total = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    for (uint i = gl_GlobalInvocationID.x; i < count; i += total) {
        uint slot = SlotAt(i);
        ivec2 texel = TexelOf(slot);
        bool isFirst = wave.step == 0u;
        PathState path;
        if (isFirst) {
            path = PathOf(uvec2(texel));
            if (HasTraceFeature(kTraceProbeMedia)) path.media = LoadMedia(CameraMediaOf(slot));
        } else {
            path = LoadPath(slot);
        }
        DirectLight direct = NoDirectLight();
        uint depth = path.depth;
        float alpha = path.alpha;
        ++path.rayCount;
        bool isGoingOn = ShadeVertex(path, LoadHit(slot), settings, direct);
        if (isFirst)
            imageStore(radiance, texel, vec4(path.radiance, path.alpha));
        else if (path.radiance != vec3(0.0f) || path.alpha != alpha)
            imageStore(radiance, texel, vec4(imageLoad(radiance, texel).xyz + path.radiance, path.alpha));
        if (HasTraceFeature(kTraceLightSampling)) {
            bool isLit = MaxComponent(direct.radiance) > 0.0f;
            uint at = TakePlace(2u * wave.step + 1u, isLit);
            if (isLit) {
                ++path.rayCount;
                StoreShadow(at, slot, direct, AlphaSeed(path.rng, path.rayCount), depth + 1u);
            }
        }
        isGoingOn = isGoingOn && path.rayCount < kMaxRays;
        if (isGoingOn) StorePath(slot, path);
        Enqueue(slot, isGoingOn);
    }
}
