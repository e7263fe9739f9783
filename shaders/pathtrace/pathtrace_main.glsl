// Trace as a loop, in ray generation or, where SOFTWARE_TRAVERSAL is defined, in a compute shader: one sample
// of every pixel of a region of the picture. Variants define COUNT_RAYS, PATH_PARTS and LIGHT_GROUPS; one
// defines RECORDS_PATHS, and its region is a pixel.
// Images have the region's size; `texel` is a position in them, `pixel` one in the picture.
//
// An invocation follows one path after the other, and takes the next pixel as soon as a path ends: paths
// differ in length, and invocations that run in lockstep would wait for the longest. There are at most as
// many invocations as pixels. Which one takes which pixel does not affect the picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#define TRACES_SHADOW_RAYS
#define SINGLE_TRACE_CALL
#include "pathtrace/launch.glsl"
#include "scene/extensions.glsl"

#ifdef RECORDS_PATHS
#include "pathtrace/path_recorder.glsl"
#endif
#include "scene/camera.glsl"
#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"
#include "scene/surface.glsl"
#include "scene/trace_rays.glsl"

#include "pathtrace/outputs.glsl"

#include "integrator/camera_media.glsl"
#include "integrator/extend_path.glsl"
#include "pathtrace/start.glsl"

// Gives the next texel that no invocation has taken, in rows from the top. Returns false if there is none.
bool AcquireTexel(uvec2 size, out uvec2 texel) {
    uint index = atomicAdd(pixelQueue.acquiredCount, 1u);
    texel = uvec2(index % size.x, index / size.x);
    return texel.y < size.y;
}

void main() {
    uvec2 size = uvec2(imageSize(radiance));
    PathSettings settings = SettingsOf(parameters.value);
    uvec2 texel;
    PathState path;
    uint rays = 0u;
    bool isAlive = false;
    bool isProbed = false;
    vec3 probedOrigin = vec3(0.0f);
    MediumStack cameraMedia = NoMedia();
    while (true) {
        if (!isAlive) {
            if (!AcquireTexel(size, texel)) break;
            if (IsPastListEnd(texel)) continue;
            path = PathOf(texel);
            ClearGroups();
            if (HasTraceFeature(kTraceProbeMedia)) {
                // All rays of a pinhole camera start at one point.
                if (!isProbed || path.ray.origin != probedOrigin) cameraMedia = MediaAround(path.ray.origin);
                isProbed = true;
                probedOrigin = path.ray.origin;
                path.media = cameraMedia;
            }
        }
        isAlive = ExtendPath(path, settings);
        if (isAlive) continue;
        rays += path.rayCount;
        FinishSample(path);
        StoreOutputs(ivec2(texel), path);
    }
    CountRays(rays);
}
