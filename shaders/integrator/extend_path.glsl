// The path integrator as a loop: traces one ray of a path after the other (integrator/path.glsl, which
// describes the bridge).
#ifndef RAYGRAPH_INTEGRATOR_EXTEND_PATH_GLSL
#define RAYGRAPH_INTEGRATOR_EXTEND_PATH_GLSL

#include "integrator/path.glsl"
#include "integrator/share_through_media.glsl"

SHADING_BEGIN

// Traces the path's next ray, and a shadow ray from where it ended. False: the path has ended, and
// path.radiance is an unbiased estimate of the radiance along its first ray (unless a named bias is on).
INLINE bool ExtendPath(INOUT(PathState) path, PathSettings settings) {
    DirectLight direct = NoDirectLight();
    uint depth = path.depth;
    ++path.rayCount;
    Hit hit = Intersect(path.ray, AlphaSeed(path.rng, path.rayCount));
    bool isGoingOn = ShadeVertex(path, hit, settings, direct);
    if (HasTraceFeature(kTraceLightSampling)) {
        // Devices run many paths in lockstep. Paths without a light sample trace a ray of no length along
        // with the others: a branch here would make them diverge from then on
        bool isLit = MaxComponent(direct.radiance) > 0.0f;
        if (isLit)
            ++path.rayCount;
        else
            direct = NoDirectLight();
        vec3 share = HasTraceFeature(kTraceMatchedMedia)
                         ? ShareThroughMedia(direct, path.wavelength, path.rng, path.rayCount)
                         : UnblockedShare(direct.ray, direct.distance, direct.ior,
                                          AlphaSeed(path.rng, path.rayCount));
        if (isLit && MaxComponent(share) > 0.0f)
            Collect(path, direct.radiance * share, depth + 1u, direct.lobe, direct.light, direct.triangle,
                    settings);
    }
    return isGoingOn && path.rayCount < kMaxRays;
}

SHADING_END

#endif
