// The way of light that is sampled, through media. The bridge is that of integrator/path.glsl.
#ifndef RAYGRAPH_INTEGRATOR_SHARE_THROUGH_MEDIA_GLSL
#define RAYGRAPH_INTEGRATOR_SHARE_THROUGH_MEDIA_GLSL

#include "integrator/direct_light.glsl"

SHADING_BEGIN

// Returns the share of the light that arrives, where light passes from medium to medium. Which medium lies
// behind a boundary depends on those before it, so they must be met in order: an any-hit shader would not.
// Counts its rays.
INLINE vec3 MediaTransmittance(DirectLight direct, float wavelength, Sampler rng, INOUT(uint) rayCount) {
    if (!HasTraceFeature(kTraceMatchedMedia)) return vec3(0.0f);
    vec3 share = vec3(1.0f);
    Ray ray = direct.ray;
    float rest = direct.distance;
    DONT_UNROLL
    while (rest > 0.0f && rayCount < kMaxRays) {
        Hit hit = Intersect(ray, AlphaSeed(rng, rayCount));
        uint medium = CurrentMedium(direct.media);
        if (!IsHit(hit) || hit.t >= rest) return share * Transmittance(medium, rest / kShadowRayFraction);
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
            bool isMatched = isVolume && IsIndexMatched(surface.material, boundary, wavelength);
            if (!isMatched && !IsSmoothThinWall(surface.material)) return vec3(0.0f);
            Frame frame = FrameOf(surface);
            SurfaceSetting setting = SettingOf(surface, frame, eta, 0.0f, 0u);
            setting.isMatched = isMatched;
            share *= PassThroughWeight(surface.material, setting, ToLocal(frame, -ray.direction));
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

SHADING_END

#endif
