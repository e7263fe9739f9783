// The path integrator as a loop: traces one ray of a path after the other (integrator/path.glsl, which
// describes the bridge).
#ifndef RAYGRAPH_INTEGRATOR_EXTEND_PATH_GLSL
#define RAYGRAPH_INTEGRATOR_EXTEND_PATH_GLSL

#include "integrator/path.glsl"

SHADING_BEGIN

// The share of it that arrives, where light passes from medium to medium. Which medium lies behind a boundary
// depends on those before it, so they must be met in order: an any-hit shader would not. Counts its rays.
INLINE vec3 ShareThroughMedia(DirectLight direct, float wavelength, Sampler rng, INOUT(uint) rayCount) {
    if (!HasTraceFeature(kTraceMatchedMedia)) return vec3(0.0f);
    vec3 share = vec3(1.0f);
    Ray ray = direct.ray;
    float rest = direct.distance;
    DONT_UNROLL
    while (rest > 0.0f && rayCount < kMaxRays) {
        Hit hit = Intersect(ray, AlphaSeed(rng, rayCount));
        uint medium = CurrentMedium(direct.media);
        if (!IsHit(hit) || hit.t >= rest) return share * Transmittance(medium, rest / kShadowShare);
        SurfaceInteraction surface = SurfaceAt(hit, ray);
        share *= Transmittance(medium, SegmentLength(direct.start, surface, ray, hit.t));
        bool isVolume = (surface.material.flags & kMaterialVolume) != 0u;
        Boundary boundary;
        boundary.beyond = direct.media;
        boundary.isReal = true;
        float eta = 1.0f;
        if (isVolume)
            boundary = CrossBoundary(direct.media, surface.material.id, surface.isFront);
        else
            eta = surface.material.ior / MediumIor(medium, wavelength);
        if (boundary.isReal) {
            bool isMatched = isVolume && IsMatchedBoundary(surface.material, boundary, wavelength);
            if (!isMatched && !IsSmoothThinWall(surface.material)) return vec3(0.0f);
            Frame frame = FrameOf(surface);
            SurfaceSetting setting = SettingOf(surface, frame, eta, 0.0f, 0u);
            setting.isMatched = isMatched;
            share *= StraightShare(surface.material, setting, ToLocal(frame, -ray.direction));
            if (!(MaxComponent(share) > 0.0f)) return vec3(0.0f);
        }
        direct.media = boundary.beyond;
        vec3 origin = OffsetRayOrigin(surface.position, -surface.geometricNormal, surface.clearance);
        rest -= dot(origin - ray.origin, ray.direction);
        ray.origin = origin;
        direct.start = StartAtSurface(surface, origin);
        ++rayCount;
    }
    return rayCount < kMaxRays ? share : vec3(0.0f);
}

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
