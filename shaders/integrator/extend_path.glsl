// The path integrator as a loop: traces one ray of a path after the other (integrator/path.glsl, which
// describes the bridge). An includer that defines SINGLE_TRACE_CALL has one function more:
//
//     Hit IntersectWithin(Ray ray, float distance, bool terminateOnFirstHit, uint alphaSeed)
//         as Intersect, up to a distance; terminateOnFirstHit: only whether there is a surface
#ifndef RAYGRAPH_INTEGRATOR_EXTEND_PATH_GLSL
#define RAYGRAPH_INTEGRATOR_EXTEND_PATH_GLSL

#include "integrator/path.glsl"
#include "integrator/share_through_media.glsl"

SHADING_BEGIN

#ifdef RECORDS_PATHS
INLINE void EndVertexRecord(PathState path, bool isAlive) {
    if (isAlive && path.rayCount >= kMaxRays) RECORD(end, kPathEndRayLimit);
    RECORD(throughput, path.throughput);
    RECORD(radiance, path.radiance);
    StoreVertexRecord();
}
#endif

#ifdef SINGLE_TRACE_CALL
// ExtendPath, with one place in its code that traces both rays.
INLINE bool ExtendPathBySingleTraceCall(INOUT(PathState) path, PathSettings settings) {
    DirectLight direct = NoDirectLight();
    uint depth = path.depth;
    Ray ray = path.ray;
    float distance = kInfinity;
    bool isAlive = false;
    bool isLit = false;
    ++path.rayCount;
    DONT_UNROLL
    for (uint turn = 0u; turn < 2u; ++turn) {
        Hit hit = IntersectWithin(ray, distance, turn != 0u, AlphaSeed(path.rng, path.rayCount));
        if (turn == 0u) {
            isAlive = ShadeVertex(path, hit, settings, direct);
            isLit = MaxComponent(direct.radiance) > 0.0f;
            if (isLit)
                ++path.rayCount;
            else
                direct = NoDirectLight();
            ray = direct.ray;
            distance = direct.distance;
        } else if (isLit && !IsHit(hit)) {
            Collect(path, direct.radiance, depth + 1u, direct.lobe, direct.light, direct.triangle, settings);
            RECORD(visibility, vec3(1.0f));
            RECORD(lit, RECORDED.collected);
        }
    }
    RECORD_BY(EndVertexRecord(path, isAlive));
    return isAlive && path.rayCount < kMaxRays;
}
#endif

// Traces the path's next ray, and a shadow ray from where it ended. False: the path has ended, and
// path.radiance is an unbiased estimate of the radiance along its first ray (unless a named bias is on).
INLINE bool ExtendPath(INOUT(PathState) path, PathSettings settings) {
#ifdef SINGLE_TRACE_CALL
    if (HasLoopOption(kLoopOneTrace)) return ExtendPathBySingleTraceCall(path, settings);
#endif
    DirectLight direct = NoDirectLight();
    uint depth = path.depth;
    ++path.rayCount;
    Hit hit = Intersect(path.ray, AlphaSeed(path.rng, path.rayCount));
    bool isAlive = ShadeVertex(path, hit, settings, direct);
    if (HasTraceFeature(kTraceLightSampling)) {
        // Devices run many paths in lockstep. Paths without a light sample trace a ray of no length along
        // with the others: a branch here would make them diverge from then on
        bool isLit = MaxComponent(direct.radiance) > 0.0f;
        if (isLit)
            ++path.rayCount;
        else
            direct = NoDirectLight();
        vec3 share = HasTraceFeature(kTraceMatchedMedia)
                         ? MediaTransmittance(direct, path.wavelength, path.rng, path.rayCount)
                         : ShadowTransmittance(direct.ray, direct.distance, direct.ior,
                                          AlphaSeed(path.rng, path.rayCount));
        RECORD(visibility, isLit ? share : vec3(0.0f));
        if (isLit && MaxComponent(share) > 0.0f) {
            Collect(path, direct.radiance * share, depth + 1u, direct.lobe, direct.light, direct.triangle,
                    settings);
            RECORD(lit, RECORDED.collected);
        }
    }
    RECORD_BY(EndVertexRecord(path, isAlive));
    return isAlive && path.rayCount < kMaxRays;
}

SHADING_END

#endif
