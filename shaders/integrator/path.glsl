// The path integrator without resource bindings: what happens where a ray has arrived (ShadeVertex). Rays are
// traced by its includers: one after the other in integrator/extend_path.glsl, those of many paths at once in
// pathtrace/wave_*.glsl. It accesses the scene through a small bridge, which the including file declares
// beforehand: scene/*.glsl on the device, a few analytic shapes in the tests. Only what traces rays needs the
// first two.
//
//     Hit Intersect(Ray ray, uint alphaSeed)                    the nearest surface
//     vec3 ShadowTransmittance(Ray ray, float distance, float ior, uint alphaSeed)
//         share of light that comes along the ray from there: 0 if anything opaque is nearer, less than 1 if
//         smooth thin walls are. `ior` is of the medium that the ray starts in. A distance of 0 is legal. Not
//         asked for where kTraceMatchedMedia is set
//     SurfaceInteraction SurfaceAt(Hit hit, Ray ray)            what is there
//     Medium MediumAt(uint material)                            what the surfaces of a material enclose
//     void AddToGroup(vec3 value, uint light, uint triangle)    what a light (kNoLight: a surface that is
//         none), or the triangle of a mesh that is one, brought to the camera; asked for if LIGHT_GROUPS is
//         defined
//     and those of lights/lights.glsl and bxdf/energy.glsl
//
// Each vertex adds the light it emits and, by sampling the lights, the light it scatters; multiple importance
// sampling weights both ways to find a light (Veach 1997, chapter 9). Unbiased, except for maxDepth,
// clampIndirect and regularize, which are off by default.
//
// Light that passes straight through a smooth thin wall, or into or out of a medium of the same index, has
// not been scattered: to both ways of finding a light the surface is a hole for a share of the light, and the
// remaining paths sample its other lobes.
//
// Sample dimensions: 0 to 3 are the camera's; each bounce has kBounceDimensions of its own, so that the same
// decision uses the same dimension on every path. Straight crossings, flights through media and the choice
// among candidates for a light have dimensions by the ray's number, and the path's wavelength has one.
#ifndef RAYGRAPH_INTEGRATOR_PATH_GLSL
#define RAYGRAPH_INTEGRATOR_PATH_GLSL

#include "bxdf/bsdf.glsl"
#include "core/frame.glsl"
#include "core/ray_offset.glsl"
#include "core/record.glsl"
#include "core/rng.glsl"
#include "core/trace_options.glsl"
#include "integrator/direct_light.glsl"
#include "integrator/media.glsl"
#include "integrator/path_state.glsl"
#include "integrator/scattering.glsl"
#include "integrator/shadow_catcher.glsl"
#include "lights/lights.glsl"
#include "lights/shadow_ray.glsl"
#include "scene/ray.glsl"
#include "shared/scene_records.h"

SHADING_BEGIN

// Dimension 0 chooses a light; 1 and 2 a point on it; 3 a lobe; 4 and 5 a direction; 6 is for roulette.
CONST uint kBounceDimensions = 7u;
CONST uint kPassThroughDimensions = 0x40000000u;
CONST uint kWavelengthDimension = 0x3fffffffu;
CONST uint kFlightDimensions = 0x20000000u;  // 2 for each ray
CONST uint kCandidateDimensions = 0x30000000u;

// Describes a surface as the path meets it.
struct Vertex {
    SurfaceInteraction surface;
    MediumStack beyond;  // the media on its other side
    SurfaceBSDF bsdf;
    Frame frame;
};

#ifdef RECORDS_PATHS
INLINE void RecordShadowRay(DirectLight direct) {
    RECORD(shadowOrigin, direct.ray.origin);
    RECORD(shadowDirection, direct.ray.direction);
    RECORD(shadowDistance, direct.distance);
    RECORD(unoccluded, direct.radiance);
}

INLINE void RecordLightCandidate(uint candidate, LightSample light) {
    RECORD(candidateCount, candidate + 1u);
    RECORD_LIGHT(candidate, light, light.light);
    RECORD_LIGHT(candidate, triangle, light.triangle);
    RECORD_LIGHT(candidate, probability, RECORDED.lightProbability);
    RECORD_LIGHT(candidate, pdf, light.pdf);
    RECORD_LIGHT(candidate, direction, light.wi);
    RECORD_LIGHT(candidate, distance, light.distance);
    RECORD_LIGHT(candidate, radiance, light.radiance);
    RecordSource(candidate, light.light, light.triangle);
}

INLINE void RecordRay(PathState path, Hit hit) {
    StartVertexRecord();
    RECORD(ray, path.rayCount);
    RECORD(depth, path.depth);
    RECORD(origin, path.ray.origin);
    RECORD(direction, path.ray.direction);
    RECORD(distance, hit.t);
    RECORD(scatterPDF, path.scatterPDF);
    RECORD(medium, CurrentMedium(path.media));
    RECORD(wavelength, path.wavelength);
    RECORD(end, kPathEndEscaped);
    if (IsHit(hit)) RecordPlace(hit);
}

INLINE void RecordSurface(SurfaceInteraction surface) {
    RECORD(event, kPathEventSurface);
    RECORD(end, kPathEndNone);
    RECORD(position, surface.position);
    RECORD(geometricNormal, surface.geometricNormal);
    RECORD(shadingNormal, surface.shadingNormal);
    RECORD(isFront, surface.isFront ? 1u : 0u);
    RECORD(baseColor, surface.material.baseColor);
    RECORD(metallic, surface.material.metallic);
    RECORD(roughness, surface.material.roughness);
    RECORD(transmission, surface.material.transmission);
}

INLINE void RecordEmission(PathState path, vec3 radiance, uint light, uint triangle) {
    RECORD(arriving, path.throughput);
    RECORD(emission, radiance);
    RECORD(light, light);
    RECORD(lightTriangle, triangle);
}

INLINE void RecordScattering(vec3 direction, vec3 f, float pdf, float cosine, uint flags) {
    RECORD(scattered, direction);
    RECORD(bsdf, f);
    RECORD(pdf, pdf);
    RECORD(cosine, cosine);
    RECORD(scatterFlags, flags);
}
#endif

// Returns the contribution of a light that is `radiance` at the vertex.
INLINE DirectLight ScatterLight(PathState path, Vertex vertex, LightSample light, vec3 radiance) {
    DirectLight direct;
    float side = dot(light.wi, vertex.surface.geometricNormal);
    direct.ray = ShadowRayTo(vertex.surface, light, direct.distance);
    direct.lobe = path.lobe;
    direct.light = light.light;
    direct.triangle = light.triangle;
    direct.radiance = path.throughput * radiance;
    direct.ior = 1.0f;
    if (HasTraceFeature(kTraceMatchedMedia)) {
        direct.media = side > 0.0f ? path.media : vertex.beyond;
        direct.start = StartAtSurface(vertex.surface, direct.ray.origin);
    } else if (HasTraceFeature(kTraceVolumes)) {
        uint medium = CurrentMedium(side > 0.0f ? path.media : vertex.beyond);
        direct.radiance *= Transmittance(medium, light.distance);
        if (HasTraceFeature(kTraceThinWalls)) direct.ior = MediumIor(medium, path.wavelength);
    }
    RECORD_BY(RecordShadowRay(direct));
    return direct;
}

// Returns the cone of the next ray, from that of the path where it met the surface.
INLINE RayCone ScatteredCone(RayCone cone, float curvature, BSDFSample scattered) {
    cone = IsTransmissive(scattered.flags) ? RefractCone(cone, curvature, scattered.eta)
                                           : ReflectCone(cone, curvature);
    return IsSpecular(scattered.flags) ? cone : WidenCone(cone, scattered.pdf);
}

// Gives the path its next ray. `diffuse` is the diffuse part of scattered.f. False: there is none.
INLINE bool Scatter(INOUT(PathState) path, Vertex vertex, BSDFSample scattered, vec3 diffuse,
                    PathSettings settings) {
    RECORD(end, kPathEndAbsorbed);
    if (!(scattered.pdf > 0.0f)) return false;
    if (kKeepsParts && path.depth == 0u)
        path.lobe = FirstLobeOf(scattered.f, diffuse, IsTransmissive(scattered.flags));
    vec3 direction = FromLocal(vertex.frame, scattered.wi);
    RECORD_BY(RecordScattering(direction, scattered.f, scattered.pdf, abs(scattered.wi.z), scattered.flags));
    float side = dot(direction, vertex.surface.geometricNormal);
    RECORD(end, kPathEndLeak);
    if (side * scattered.wi.z <= 0.0f) return false;  // light leak of the shading normal
    RECORD(end, kPathEndAbsorbed);
    path.throughput *= scattered.f * (abs(scattered.wi.z) / scattered.pdf);
    if (!(MaxComponent(path.throughput) > 0.0f)) return false;
    path.scatterPDF = IsSpecular(scattered.flags) ? 0.0f : scattered.pdf;
    path.ray.direction = direction;
    path.ray.origin = OffsetOriginToSide(vertex.surface, side);
    if (HasTraceFeature(kTraceTextureLod))
        path.ray.cone = ScatteredCone(path.ray.cone, vertex.surface.curvature, scattered);
    if (HasTraceFeature(kTraceVolumes)) path.start = StartAtSurface(vertex.surface, path.ray.origin);
    if (HasTraceFeature(kTraceTransmission) && IsTransmissive(scattered.flags)) {
        path.etaScale *= scattered.eta * scattered.eta;
        if (HasTraceFeature(kTraceVolumes)) path.media = vertex.beyond;
    }
    RECORD(end, kPathEndRoulette);
    if (!SurviveRoulette(path, settings)) return false;
    RECORD(end, kPathEndNone);
    ++path.depth;
    return true;
}

INLINE uint LightCandidates(Vertex vertex) {
    return HasTraceFeature(kTraceEnvironmentLight) && (vertex.bsdf.flags & kBxDFGlossy) != 0u
               ? kLightCandidates
               : 1u;
}

// Returns u, moved by `shift` and wrapped around the end. It is exact: values that were equally likely stay
// so, which the table of the environment relies on.
INLINE float ToroidalShift(float u, float shift) {
    return u < 1.0f - shift ? u + shift : u - (1.0f - shift);
}

// The numbers of each candidate are uniform; those of all are spread over each of their ranges.
INLINE vec3 CandidateSample(vec3 u, uint candidate) {
    float shift = float(candidate) / float(kLightCandidates);
    float backward = candidate > 0u ? 1.0f - shift : 0.0f;
    return vec3(ToroidalShift(u.x, shift), ToroidalShift(u.y, shift), ToroidalShift(u.z, backward));
}

// Returns the number that chooses one of the candidates, for each ray; the next dimension stays.
INLINE float CandidateChoiceSample(PathState path) {
    path.rng.dimension = kCandidateDimensions + path.rayCount;
    return Get1D(path.rng);
}

// Returns the numbers for the direction of a bounce, and in z for its lobe. The light after two bounces
// depends on both directions, so that each second bounce has its numbers of the sequence of the one before.
INLINE vec3 BounceDirectionSample(INOUT(PathState) path) {
    uint dimension = kCameraDimensions + path.depth * kBounceDimensions + 3u;
    path.rng.dimension = dimension;
    return Get3DOfPair(path.rng, dimension - (path.depth & 1u) * kBounceDimensions);
}

// Draws a direction to a light and one from the BSDF, and follows both. False: the path ends here.
//
// The light is chosen of several candidates by what they would contribute (Talbot et al. 2005, "Importance
// Resampling for Global Illumination"): the mean is that of all of them, for one shadow ray. In the weights
// of multiple importance sampling they count as one sample: under an even sky, which the BSDF finds best,
// they are no better than one.
INLINE bool ScatterBoth(INOUT(PathState) path, Vertex vertex, PathSettings settings,
                        INOUT(DirectLight) direct) {
    vec3 toLightU = vec3(0.0f);
    uint candidates = 0u;
    if (HasTraceFeature(kTraceLightSampling)) {
        path.rng.dimension = kCameraDimensions + path.depth * kBounceDimensions;
        toLightU = Get3D(path.rng);
        if (IsNonSpecular(vertex.bsdf.flags)) candidates = LightCandidates(vertex);
    }
    vec3 u = BounceDirectionSample(path);
    bool isEvaluated = false;
    BSDFSample scattered = SampleDirection(vertex.bsdf, u.z, vec2(u), isEvaluated);
    vec3 diffuse = DiffuseOf(vertex.bsdf, scattered);  // diffuse part of scattered.f

    if (!HasTraceFeature(kTraceLightSampling)) {
        if (!isEvaluated)
            scattered.f = Evaluate(vertex.bsdf, scattered.wi, IsDelta(scattered), scattered.pdf, diffuse);
        return Scatter(path, vertex, scattered, diffuse, settings);
    }
    LightSample chosen = NoLightSample();
    vec3 chosenRadiance = vec3(0.0f);
    FirstLobe chosenLobe = path.lobe;
    float sum = 0.0f;
    float chosenWeight = 1.0f;
    // The number needs many bits, or unlikely candidates would never be chosen.
    float choice = candidates > 1u ? CandidateChoiceSample(path) : 0.0f;
    // Evaluate the BSDF for all at one call site: a device compiles it for each
    DONT_UNROLL
    for (uint turn = 0u; turn <= candidates; ++turn) {
        bool isLight = turn < candidates;
        LightSample light = NoLightSample();
        vec3 toLight = vec3(0.0f);
        if (isLight) {
            vec3 v = CandidateSample(toLightU, turn);
            light = SampleLight(path.scatter, v.z, vec2(v));
            toLight = ToLocal(vertex.frame, light.wi);
            // There is no light where the shading normal would leak.
            if (dot(light.wi, vertex.surface.geometricNormal) * toLight.z <= 0.0f) light.pdf = 0.0f;
            RECORD_BY(RecordLightCandidate(turn, light));
        }
        if (isLight ? !(light.pdf > 0.0f) : isEvaluated) continue;
        float pdf = 0.0f;
        vec3 part = vec3(0.0f);
        bool isDelta = !isLight && IsDelta(scattered);
        vec3 value = Evaluate(vertex.bsdf, isLight ? toLight : scattered.wi, isDelta, pdf, part);
        if (!isLight) {
            scattered.f = value;
            scattered.pdf = pdf;
            diffuse = part;
            continue;
        }
        float weight = LightWeight(light, pdf) / (light.pdf * float(candidates));
        vec3 radiance = value * light.radiance * (abs(toLight.z) * weight);
        RECORD_LIGHT(turn, bsdf, value);
        RECORD_LIGHT(turn, scatterPDF, pdf);
        RECORD_LIGHT(turn, weight, LightWeight(light, pdf));
        if (radiance == vec3(0.0f)) continue;
        float share = MaxComponent(path.throughput * radiance);
        // A share that is not finite is chosen, too, so that the check of samples finds it.
        if (!(share > 0.0f && share < kInfinity)) share = 1.0f;
        sum += share;
        RECORD_LIGHT(turn, share, share);
        if (candidates == 1u || SampleBernoulli(choice, share / sum)) {
            chosen = light;
            chosenRadiance = radiance;
            chosenWeight = share;
            RECORD(chosen, turn);
            if (kKeepsParts && path.depth == 0u)
                chosenLobe = FirstLobeOf(value, part, !SameHemisphere(vertex.bsdf.wo, toLight));
        }
    }
    if (sum != 0.0f) {
        direct = ScatterLight(path, vertex, chosen, chosenRadiance * (sum / chosenWeight));
        direct.lobe = chosenLobe;
    }
    return Scatter(path, vertex, scattered, diffuse, settings);
}

// Moves the path's ray to the other side of the surface it has found.
INLINE void PassThrough(INOUT(PathState) path, SurfaceInteraction surface) {
    path.ray.origin = OffsetRayOrigin(surface.position, -surface.geometricNormal, surface.clearance);
    if (HasTraceFeature(kTraceVolumes)) path.start = StartAtSurface(surface, path.ray.origin);
}

// Returns whether the path passes straight through the smooth thin wall or matched boundary it has found. If
// not, its transmission is removed.
INLINE bool SamplePassThrough(INOUT(PathState) path, INOUT(Vertex) vertex) {
    float chance = PassThroughProbability(vertex.bsdf);
    RECORD(passProbability, chance);
    path.rng.dimension = kPassThroughDimensions + path.rayCount;
    if (Get1D(path.rng) < chance) {
        path.throughput *= PassThroughWeight(vertex.bsdf) / chance;
        return true;
    }
    path.throughput /= 1.0f - chance;
    vertex.bsdf = WithoutPassThrough(vertex.bsdf, chance);
    return false;
}

// Chooses a wavelength at the boundary of a medium that refracts colors differently: a path of all colors
// goes on as one of a single wavelength.
INLINE void ChooseWavelength(INOUT(PathState) path, Boundary boundary) {
    if (path.wavelength != kNoWavelength) return;
    if (!IsDispersive(boundary.here) && !IsDispersive(boundary.there)) return;
    path.rng.dimension = kWavelengthDimension;
    path.wavelength = SampleWavelength(Get1D(path.rng));
    path.throughput *= WavelengthShare(path.wavelength);
}

INLINE FreeFlight SampleMediumFlight(INOUT(PathState) path, uint medium, float limit) {
    path.rng.dimension = kFlightDimensions + 2u * path.rayCount;
    float color = Get1D(path.rng);
    return SampleFreeFlight(MediumAt(medium), path.throughput, limit, color, Get1D(path.rng));
}

// Returns the point at `distance` of a segment's length `inside`. Where it is nearer to a surface than its
// own rounding, a point that is off that surface: the path would find itself on the other side.
INLINE vec3 PositionInMedium(SegmentStart start, Ray ray, SurfaceInteraction end, bool isHit, float inside,
                             float distance) {
    float rest = (inside - distance) * abs(dot(ray.direction, end.geometricNormal));
    if (isHit && rest < end.clearance) return OffsetOriginToSide(end, 1.0f);
    return ray.origin + max(distance - OriginOffset(start, ray), 0.0f) * ray.direction;
}

// Scatters the path in a medium, at that point of its ray. `direct` becomes the light that a shadow ray
// must confirm. False: the path ends here.
INLINE bool ScatterInMedium(INOUT(PathState) path, uint medium, vec3 position, PathSettings settings,
                            INOUT(DirectLight) direct) {
    Cover(path);
    RECORD(event, kPathEventMedium);
    RECORD(position, position);
    RECORD(end, kPathEndDepth);
    if (path.depth >= settings.maxDepth) return false;
    float g = MediumAt(medium).anisotropy;
    vec3 forward = path.ray.direction;
    path.ray.origin = position;
    path.scatter.position = path.ray.origin;
    path.scatter.normal = vec3(0.0f);
    path.start = StartAtCamera();
    if (kKeepsParts && path.depth == 0u) path.lobe = FirstLobeOf(vec3(1.0f), vec3(1.0f), false);
    path.rng.dimension = kCameraDimensions + path.depth * kBounceDimensions;
    if (HasTraceFeature(kTraceLightSampling)) {
        vec3 u = Get3D(path.rng);
        LightSample light = SampleLight(path.scatter, u.z, vec2(u));
        RECORD_BY(RecordLightCandidate(0u, light));
        if (light.pdf > 0.0f) {
            float phase = PhaseHG(g, dot(forward, light.wi));
            direct.ray = ShadowRayFrom(path.ray.origin, light, direct.distance);
            direct.lobe = path.lobe;
            direct.light = light.light;
            direct.triangle = light.triangle;
            direct.ior = MediumIor(medium, path.wavelength);
            direct.media = path.media;
            direct.start = StartAtCamera();
            direct.radiance =
                path.throughput * light.radiance * (phase * LightWeight(light, phase) / light.pdf);
            if (!HasTraceFeature(kTraceMatchedMedia))
                direct.radiance *= Transmittance(medium, light.distance);
            RECORD_LIGHT(0, bsdf, vec3(phase));
            RECORD_LIGHT(0, scatterPDF, phase);
            RECORD_LIGHT(0, weight, LightWeight(light, phase));
            RECORD_LIGHT(0, share, MaxComponent(direct.radiance));
            RECORD(chosen, 0u);
            RECORD_BY(RecordShadowRay(direct));
        }
    }
    path.rng.dimension = kCameraDimensions + path.depth * kBounceDimensions + 4u;
    path.ray.direction = FromLocal(FrameFromZ(forward), SamplePhaseHG(g, Get2D(path.rng)));
    path.scatterPDF = PhaseHG(g, dot(forward, path.ray.direction));
    RECORD_BY(RecordScattering(path.ray.direction, vec3(path.scatterPDF), path.scatterPDF, 1.0f,
                               kBxDFTransmission | kBxDFGlossy));
    if (HasTraceFeature(kTraceTextureLod)) path.ray.cone = WidenCone(path.ray.cone, path.scatterPDF);
    RECORD(end, kPathEndRoulette);
    if (!SurviveRoulette(path, settings)) return false;
    RECORD(end, kPathEndNone);
    ++path.depth;
    return true;
}

// Adds the emission that the path's ray found, and scatters the path there. `direct` becomes the light that a
// shadow ray must confirm. False: the path ends here.
INLINE bool ShadeVertex(INOUT(PathState) path, Hit hit, PathSettings settings, INOUT(DirectLight) direct) {
    RECORD_BY(RecordRay(path, hit));
    // The ray has hit a surface, or the environment
    bool isHit = IsHit(hit);
    SurfaceInteraction surface;
    if (isHit) {
        surface = SurfaceAt(hit, path.ray);
        surface.emission *= EmissionTransmittance(surface, -path.ray.direction);
        RECORD_BY(RecordSurface(surface));
    } else {
        bool isHidden = HasTraceFeature(kTraceHiddenEnvironment) && path.alpha == 0.0f;
        surface.emission = isHidden ? vec3(0.0f) : EnvironmentRadiance(path.ray.direction);
        surface.light = LightSet().lightCount;
        surface.lightTriangle = 0u;
        surface.material.flags = 0u;
    }
    bool isVolume = (surface.material.flags & kMaterialVolume) != 0u;
    Boundary boundary;
    boundary.beyond = path.media;
    boundary.isReal = true;
    float eta = surface.material.ior;
    float distance = isHit ? hit.t : kInfinity;
    if (HasTraceFeature(kTraceVolumes)) {
        float inside = isHit ? SegmentLength(path.start, surface, path.ray, distance) : kInfinity;
        uint medium = CurrentMedium(path.media);
        RECORD(mediumLength, inside);
        RECORD(mediumWeight, Transmittance(medium, inside));
        if (HasTraceFeature(kTraceScattering) && IsScattering(medium)) {
            FreeFlight flight = SampleMediumFlight(path, medium, inside);
            path.throughput *= flight.weight;
            RECORD(mediumLength, flight.distance);
            RECORD(mediumWeight, flight.weight);
            if (flight.isScattered) {
                vec3 position =
                    PositionInMedium(path.start, path.ray, surface, isHit, inside, flight.distance);
                if (HasTraceFeature(kTraceTextureLod))
                    path.ray.cone = AdvanceCone(path.ray.cone, flight.distance);
                return ScatterInMedium(path, medium, position, settings, direct);
            }
        } else {
            path.throughput *= Transmittance(medium, inside);
        }
        if (isVolume) {
            boundary = CrossBoundary(path.media, surface.material.id, surface.isFront);
            eta = RelativeIor(boundary, path.wavelength);
        } else {
            eta = surface.material.ior / MediumIor(CurrentMedium(path.media), path.wavelength);
        }
    }
    RECORD_BY(RecordEmission(path, surface.emission, surface.light, surface.lightTriangle));
    // Surfaces emit even if a medium of higher priority hides them, as for light sampling
    if (MaxComponent(surface.emission) > 0.0f)
        AddHitEmission(path, surface.emission, surface.light, surface.lightTriangle, distance, settings);
    if (!isHit) return false;
    if (HasTraceFeature(kTraceTextureLod)) path.ray.cone = AdvanceCone(path.ray.cone, distance);
    if (HasTraceFeature(kTraceVolumes) && !boundary.isReal) {
        path.media = boundary.beyond;
        PassThrough(path, surface);
        RECORD(event, kPathEventIgnored);
        // Light sampling cannot follow the path: to its rays, surfaces of volumes are opaque.
        if (!HasTraceFeature(kTraceMatchedMedia)) path.scatterPDF = 0.0f;
        return true;
    }
    bool isCatcher = IsCatcher(path, surface);
    if (!isCatcher)
        Cover(path);
    else if (!Catch(path, surface))
        return false;
    bool isMatched = isVolume && IsIndexMatched(surface.material, boundary, path.wavelength);
    bool isWall = isMatched || IsSmoothThinWall(surface.material);
    bool isLast = path.depth >= settings.maxDepth;
    RECORD(end, isLast ? kPathEndDepth : kPathEndUnlit);
    if ((isLast && !isWall) || (surface.material.flags & kMaterialUnlit) != 0u) return false;

    if (isMatched) {
        eta = 1.0f;
    } else if (HasTraceFeature(kTraceDispersion) && isVolume) {
        ChooseWavelength(path, boundary);
        eta = RelativeIor(boundary, path.wavelength);
        // The index at this wavelength is also that of the base below the surface's film.
        surface.material.ior = MediumIor(surface.material.id, path.wavelength);
    }

    // The path scatters at the surface
    RECORD(wavelength, path.wavelength);
    Vertex vertex;
    vertex.surface = surface;
    vertex.beyond = boundary.beyond;
    vertex.frame = FrameOf(surface);
    float minAlpha = path.depth > 0u && !isWall ? settings.regularize : 0.0f;
    SurfaceSetting setting =
        SettingOf(surface, vertex.frame, eta, minAlpha, FacetSeed(path.rng, path.rayCount));
    setting.isMatched = isMatched;
    vertex.bsdf = BSDFOf(surface.material, ToLocal(vertex.frame, -path.ray.direction), setting);
    if (isWall) {
        if (SamplePassThrough(path, vertex)) {
            if (HasTraceFeature(kTraceMatchedMedia)) path.media = boundary.beyond;
            PassThrough(path, surface);
            RECORD(event, kPathEventStraight);
            RECORD(end, kPathEndNone);
            return true;
        }
        if (isLast) return false;
    }
    path.scatter.position = surface.position;
    path.scatter.normal = IsTransmissive(vertex.bsdf.flags) ? vec3(0.0f) : surface.geometricNormal;
    bool isAlive = ScatterBoth(path, vertex, settings, direct);
    if (isCatcher) SubtractUnoccluded(path, direct, isAlive);
    return isAlive;
}

SHADING_END

#endif
