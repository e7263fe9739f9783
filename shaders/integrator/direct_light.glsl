// Light that is sampled at a vertex of a path, and its way to there through media.
//
// Bridge: Intersect, SurfaceAt and MediumAt, see integrator/path.glsl.
#ifndef RAYGRAPH_INTEGRATOR_DIRECT_LIGHT_GLSL
#define RAYGRAPH_INTEGRATOR_DIRECT_LIGHT_GLSL

#include "bxdf/bsdf.glsl"
#include "core/frame.glsl"
#include "core/ray_offset.glsl"
#include "integrator/media.glsl"
#include "integrator/path_parts.glsl"
#include "integrator/segment.glsl"
#include "lights/shadow_ray.glsl"
#include "scene/ray.glsl"

SHADING_BEGIN

CONST uint kMaxRays = 4096u;  // of one path: a guard against rooms that cannot be left

// Light from one point of one light, scattered by a surface or a medium to the camera, if it is not occluded.
struct DirectLight {
    Ray ray;
    float distance;  // that must be unoccluded; 0: no light
    float ior;       // of the medium on the way
    vec3 radiance;   // 0: no light
    FirstLobe lobe;  // of the path, if kKeepsParts
    uint light;      // its number
    uint triangle;   // of a mesh: within it
    MediumStack media;   // where the ray starts; these two are set if kTraceMatchedMedia is
    SegmentStart start;
};

INLINE DirectLight NoDirectLight() {
    DirectLight direct;
    direct.ray.origin = vec3(0.0f);
    direct.ray.direction = vec3(0.0f, 0.0f, 1.0f);
    direct.distance = 0.0f;
    direct.ior = 1.0f;
    direct.radiance = vec3(0.0f);
    direct.lobe = NoLobe();
    direct.light = kNoLight;
    direct.triangle = 0u;
    direct.media = NoMedia();
    direct.start = StartAtCamera();
    return direct;
}

// Whether light goes straight on at that boundary, which is real.
INLINE bool IsMatchedBoundary(SurfaceMaterial material, Boundary boundary, float wavelength) {
    return HasTraceFeature(kTraceMatchedMedia) &&
           IsMatchedBoundary(material, AreAlike(boundary, wavelength));
}

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

SHADING_END

#endif
