// The state of a path, what it collects, and whether it survives: the part of integrator/path.glsl, which
// describes bridges and dimensions, that does not look at surfaces.
#ifndef RAYGRAPH_INTEGRATOR_PATH_STATE_GLSL
#define RAYGRAPH_INTEGRATOR_PATH_STATE_GLSL

#include "core/record.glsl"
#include "core/rng.glsl"
#include "core/trace_options.glsl"
#include "integrator/media.glsl"
#include "integrator/path_parts.glsl"
#include "integrator/segment.glsl"
#include "lights/lights.glsl"
#include "scene/ray.glsl"

SHADING_BEGIN

CONST float kMaxSurvival = 0.99f;  // even a path without losses must end
// Where the throughput is less than the inverse of this, paths are ended at random, and those left have just
// that. By measurement (docs/performance.md): at 1, early bounces were most of the noise of rooms.
CONST float kRouletteThroughputScale = 3.0f;

struct PathSettings {
    uint maxDepth;        // bounces
    uint rouletteStart;   // first bounce at which roulette may end the path
    float survival;       // survival probability of a bounce, for roulettes of constant probability
    uint frameDepth;      // bounces of this sample, for Roulette::Frame
    float clampIndirect;  // largest component of one contribution of light scattered twice or more often
    float regularize;     // minimum alpha of the BSDFs after the first bounce
};

// Holds the state of a path: created by StartPath, extended by one ray with ExtendPath until that returns
// false.
struct PathState {
    Ray ray;  // the next one
    Sampler rng;
    vec3 radiance;     // collected so far: the estimate, once the path has ended
    vec3 throughput;   // share of the light at the path's end that reaches the camera
    float wavelength;  // nm; kNoWavelength: all colors
    float etaScale;    // square of the index of refraction along the path, which roulette must not count
    float scatterPDF;  // PDF of the ray's direction; 0: light sampling cannot make this path
    LightContext scatter;  // where the ray left, for light sampling
    SegmentStart start;    // where the ray left, for media
    MediumStack media;
    uint depth;       // bounces so far
    uint rayCount;    // rays traced
    float alpha;      // 1: the camera ray hit a surface
    PathParts parts;  // parts of the radiance; these two if kKeepsParts
    FirstLobe lobe;   // lobe of the first bounce
};

INLINE PathState StartPath(Ray ray, Sampler rng) {
    PathState path;
    path.ray = ray;
    path.rng = rng;
    path.radiance = vec3(0.0f);
    path.throughput = vec3(1.0f);
    path.wavelength = kNoWavelength;
    path.etaScale = 1.0f;
    path.scatterPDF = 0.0f;
    path.scatter.position = ray.origin;
    path.scatter.normal = vec3(0.0f);
    path.start = StartAtCamera();
    path.media = NoMedia();
    path.depth = 0u;
    path.rayCount = 0u;
    path.alpha = 0.0f;
    if (kKeepsParts) path.parts = NoParts();
    path.lobe = NoLobe();
    return path;
}

// Returns the share of a sample of density `pdf` where `other` is the density of the other strategy for it.
INLINE float MISWeight(float pdf, float other) {
    if (ActiveMis() == kMisBalance) return pdf / (pdf + other);
    float ratio = other / pdf;  // their squares may leave the range of float
    return 1.0f / (1.0f + ratio * ratio);
}

// Weight of light that a BSDF sample of density scatterPDF found, and light sampling would with lightPDF.
INLINE float ScatterWeight(float scatterPDF, float lightPDF) {
    if (!HasTraceFeature(kTraceLightSampling) || scatterPDF == 0.0f || lightPDF == 0.0f) return 1.0f;
    return ActiveMis() == kMisOff ? 0.0f : MISWeight(scatterPDF, lightPDF);
}

INLINE float LightWeight(LightSample light, float scatterPDF) {
    if (light.isDelta != 0u || ActiveMis() == kMisOff) return 1.0f;
    return MISWeight(light.pdf, scatterPDF);
}

#ifndef LIGHT_GROUPS
INLINE void AddToGroup(vec3, uint, uint) {}
#endif

// Adds the contribution `value` of light at vertex `depth` of the path, through `lobe`. `light` is the number
// of the light that it comes from, or kNoLight; `triangle` that within it if it is a mesh.
INLINE void Collect(INOUT(PathState) path, vec3 value, uint depth, FirstLobe lobe, uint light, uint triangle,
                    PathSettings settings) {
    if (depth > 1u) {
        float largest = MaxComponent(value);
        if (largest > settings.clampIndirect) value *= settings.clampIndirect / largest;
    }
    path.radiance += value;
    RECORD(collected, value);
    if (kKeepsParts) AddPart(path.parts, value, depth, lobe);
    AddToGroup(value, light, triangle);
}

// Adds light that the path's ray found: `light` is its number, or kNoLight where light sampling cannot find
// it.
INLINE void AddHitEmission(INOUT(PathState) path, vec3 radiance, uint light, uint triangle, float distance,
                         PathSettings settings) {
    float lightPDF = 0.0f;
    // Light sampling sampled from this point: straight crossings may have moved the ray's origin
    if (HasTraceFeature(kTraceThinWalls | kTraceMatchedMedia))
        distance += dot(path.ray.origin - path.scatter.position, path.ray.direction);
    if (HasTraceFeature(kTraceLightSampling) && path.scatterPDF > 0.0f && light != kNoLight)
        lightPDF = LightPDF(path.scatter, light, triangle, path.ray.direction, distance);
    float weight = ScatterWeight(path.scatterPDF, lightPDF);
    Collect(path, path.throughput * radiance * weight, path.depth, path.lobe, light, triangle, settings);
    RECORD(lightPDF, lightPDF);
    RECORD(emissionWeight, weight);
    RECORD(emitted, RECORDED.collected);
}

#ifdef RECORDS_PATHS
INLINE void RecordRoulette(Sampler rng) { RECORD(rouletteNumber, Get1D(rng)); }
#endif

// Plays Russian roulette. Returns false if the path is terminated; the weight of survivors keeps the mean.
INLINE bool SurviveRoulette(INOUT(PathState) path, PathSettings settings) {
    float survival = 1.0f;
    if (path.depth + 1u < settings.rouletteStart) return true;
    if (ActiveRoulette() == kRouletteThroughput) {
        survival =
            min(kRouletteThroughputScale * MaxComponent(path.throughput) * path.etaScale, kMaxSurvival);
        RECORD(survival, survival);
        RECORD_BY(RecordRoulette(path.rng));
        if (!(Get1D(path.rng) < survival)) return false;  // ends a path of NaN too
    } else if (ActiveRoulette() == kRouletteConstant) {
        survival = settings.survival;
        RECORD(survival, survival);
        RECORD_BY(RecordRoulette(path.rng));
        if (!(Get1D(path.rng) < survival)) return false;
    } else if (ActiveRoulette() == kRouletteFrame) {
        survival = settings.survival;
        RECORD(survival, survival);
        if (path.depth + 1u > settings.frameDepth) return false;
    }
    path.throughput /= survival;
    return true;
}

SHADING_END

#endif
