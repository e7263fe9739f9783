// A kernel of a wavefront: shades what the rays of the queue found, and queues the next rays.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
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
            if (HasTraceFeature(kTraceProbeMedia)) path.media = LoadMedia(slot);
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
        if (HasTraceFeature(kTraceLightSampling) && MaxComponent(direct.radiance) > 0.0f) {
            ++path.rayCount;
            StoreShadow(slot, direct, AlphaSeed(path.rng, path.rayCount), depth + 1u);
        }
        if (isGoingOn && path.rayCount < kMaxRays) {
            StorePath(slot, path);
            Enqueue(slot);
        }
    }
}
