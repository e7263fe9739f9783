// Multiple scattering between the facets of a rough GGX surface: the random walk of Heitz, Hanika, d'Eon and
// Dachsbacher 2016, "Multiple-Scattering Microfacet BSDFs with the Smith Model", SIGGRAPH.
//
// Smith's surface acts as a slab of microflakes (Dupuy, Heitz and d'Eon 2016, "Additional Progress
// Towards the Unification of Microfacet and Microflake Theories"). With depth measured as t = -log2
// C1(h), C1 the share of the surface that lies below height h, a ray from direction v goes this deep
// before it meets a facet:
//     t' = t + v.z e / Sigma(v),  e = -log2(1 - u)
// upwards too, where t' <= 0 means that it left; it leaves with probability 2^(-t Lambda). No distribution of
// heights is needed but for its symmetry: a ray refracted below sees the surface from below, where the depth
// is -log2(1 - 2^-t). Directions below are kept inverted (w -> -w), so that the code sees one side only.
//
// The walk has its own stream of random numbers: a function of `seed` only. It makes at most kWalkBounceLimit
// bounces; light that is still inside then is lost. White and lossless at alpha = 1 and grazing that is less
// than 1e-4 for a reflector and 1e-3 for a dielectric (measured by the tests).
#ifndef RAYGRAPH_BXDF_MULTISCATTER_WALK_GLSL
#define RAYGRAPH_BXDF_MULTISCATTER_WALK_GLSL

#include "bxdf/facet_fresnel.glsl"
#include "core/math.glsl"
#include "core/rng.glsl"
#include "core/warp.glsl"

SHADING_BEGIN

CONST uint kWalkBounceLimit = 64u;

// The fate of light that a facet does not reflect.
CONST uint kWalkAbsorbs = 0u;
CONST uint kWalkRefracts = 1u;
// A thin sheet: all light goes on as if reflected. In the end a part leaves mirrored on the far side: the
// mean of the transmittance of the first facet and of the last.
CONST uint kWalkPassesThin = 2u;

// wo of the functions below has z > 0.
struct WalkSurface {
    vec2 alpha;  // GGX along x and y, at least 1e-4
    uint kind;   // kWalk*
    float eta;   // n(below) / n(above); where nothing is refracted, at least 1
    FacetFresnel fresnel;
};

struct WalkSample {
    vec3 wi;
    vec3 weight;  // f |cos| / pdf, without the 1 / eta^2 of radiance that changed medium; 0: nothing scatters
    uint bounceCount;
};

struct WalkRng {
    uint state;
};

INLINE WalkRng StartWalkRng(uint seed) {
    WalkRng rng;
    rng.state = MixBits(seed ^ 0x68bc21ebu);
    return rng;
}

INLINE float WalkGet1D(INOUT(WalkRng) rng) {
    rng.state += 0x9e3779b9u;
    return BitsToUnit(MixBits(rng.state));
}

INLINE vec2 WalkGet2D(INOUT(WalkRng) rng) {
    float x = WalkGet1D(rng);
    return vec2(x, WalkGet1D(rng));
}

// Returns the area of facets seen from v, per area of the surface: (1 + Lambda) cos above, Lambda |cos|
// below.
INLINE float ProjectedMicrofacetArea(vec2 alpha, vec3 v) {
    float spread = Sqr(alpha.x * v.x) + Sqr(alpha.y * v.y);
    float root = sqrt(v.z * v.z + spread);
    // The second form is the first without its cancellation
    float area = v.z > 0.0f ? 0.5f * (v.z + root) : 0.5f * spread / (root - v.z);
    return max(area, 1e-12f);
}

// Returns Walter's Lambda of an upward direction.
INLINE float WalkLambda(vec2 alpha, vec3 w) { return ProjectedMicrofacetArea(alpha, -w) / max(w.z, 1e-12f); }

// Returns GGX, for m.z > 0 of unit length. cos^2 + (sin / alpha)^2 has no cancellation.
INLINE float WalkDistribution(vec2 alpha, vec3 m) {
    float a = m.z * m.z + Sqr(m.x / alpha.x) + Sqr(m.y / alpha.y);
    return kInvPi / (alpha.x * alpha.y * a * a);
}

// Returns a facet seen from v, which may lie below the horizon: seen on the unit hemisphere, reflections of v
// fill the cap z > -v.z evenly. Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps",
// HPG.
INLINE vec3 SampleVisibleFacet(vec2 alpha, vec3 v, vec2 u) {
    vec3 stretched = normalize(vec3(alpha.x * v.x, alpha.y * v.y, v.z));
    float z = 1.0f - u.x * (1.0f + stretched.z);
    float r = SafeSqrt(1.0f - z * z);
    vec2 cs = CosSinTurn(u.y);
    vec3 h = vec3(r * cs.x, r * cs.y, z) + stretched;
    vec3 m = vec3(alpha.x * h.x, alpha.y * h.y, max(h.z, 0.0f));
    float square = dot(m, m);
    return square > 0.0f ? m / sqrt(square) : vec3(0.0f, 0.0f, 1.0f);
}

// Describes a ray inside the surface. `view` points back along it, seen from the side it is on.
struct WalkRay {
    vec3 view;
    float depth;     // t above, 0 at the top
    float side;      // 1 above, -1 below: where `view` is inverted
    vec3 weight;
    float firstCos;  // at the first facet, and at the last so far
    float lastCos;
};

INLINE WalkRay StartWalkRay(vec3 wo) {
    WalkRay ray;
    ray.view = wo;
    ray.depth = 0.0f;
    ray.side = 1.0f;
    ray.weight = vec3(1.0f);
    ray.firstCos = 1.0f;
    ray.lastCos = 1.0f;
    return ray;
}

// Moves the ray to the next facet. Returns false if it has left, towards -view on its side.
INLINE bool AdvanceToNextFacet(INOUT(WalkRay) ray, vec2 alpha, float u) {
    float free = -log2(1.0f - u);
    ray.depth += ray.view.z * free / ProjectedMicrofacetArea(alpha, ray.view);
    return ray.depth > 0.0f;
}

INLINE float DepthFromOtherSide(float depth) { return -log2(max(1.0f - exp2(-depth), 6e-8f)); }

// Reflects or refracts the ray at a facet that it meets.
INLINE void ScatterAtFacet(INOUT(WalkRay) ray, WalkSurface surface, INOUT(WalkRng) rng, bool isFirst) {
    vec3 m = SampleVisibleFacet(surface.alpha, ray.view, WalkGet2D(rng));
    float cosI = dot(ray.view, m);
    if (isFirst) ray.firstCos = cosI;
    ray.lastCos = cosI;
    if (surface.kind == kWalkPassesThin) {
        ray.view = ray.view - 2.0f * cosI * m;
        return;
    }
    if (surface.kind == kWalkAbsorbs) {
        ray.weight *= FacetReflectance(surface.fresnel, cosI, surface.eta);
        ray.view = ray.view - 2.0f * cosI * m;
        return;
    }
    float eta = ray.side > 0.0f ? surface.eta : 1.0f / surface.eta;
    FresnelCoefficients shares = EvaluateFresnel(surface.fresnel, cosI, eta);
    vec3 reflected = shares.reflected;
    float chance = clamp((reflected.x + reflected.y + reflected.z) * (1.0f / 3.0f), 0.0f, 1.0f);
    if (WalkGet1D(rng) < chance) {
        ray.weight *= reflected / chance;
        ray.view = ray.view - 2.0f * cosI * m;
    } else {
        ray.weight *= shares.passed / (1.0f - chance);
        float cosT = SafeSqrt(1.0f - (1.0f - cosI * cosI) / (eta * eta));
        // The direction goes onwards and is seen from the other side: it is inverted twice
        ray.view = normalize((cosI * m - ray.view) / eta - cosT * m);
        ray.side = -ray.side;
        ray.depth = DepthFromOtherSide(ray.depth);
    }
}

// Returns the shares of light that a thin sheet reflects and passes.
INLINE FresnelCoefficients ThinSheetFresnel(WalkSurface surface, float firstCos, float lastCos) {
    FresnelCoefficients first = EvaluateFresnel(surface.fresnel, firstCos, surface.eta);
    FresnelCoefficients last = EvaluateFresnel(surface.fresnel, lastCos, surface.eta);
    FresnelCoefficients mean;
    mean.reflected = 0.5f * (first.reflected + last.reflected);
    mean.passed = 0.5f * (first.passed + last.passed);
    return mean;
}

INLINE WalkSample SampleWalk(WalkSurface surface, vec3 wo, uint seed) {
    WalkSample result;
    result.wi = vec3(0.0f, 0.0f, 1.0f);
    result.weight = vec3(0.0f);
    result.bounceCount = 0u;
    WalkRng rng = StartWalkRng(seed);
    WalkRay ray = StartWalkRay(wo);
    while (AdvanceToNextFacet(ray, surface.alpha, WalkGet1D(rng))) {
        if (result.bounceCount == kWalkBounceLimit) return result;
        ScatterAtFacet(ray, surface, rng, result.bounceCount == 0u);
        ++result.bounceCount;
    }
    if (result.bounceCount == 0u) return result;  // u was 0: no step at all
    result.wi = -ray.side * ray.view;
    result.weight = ray.weight;
    if (surface.kind == kWalkPassesThin) {
        FresnelCoefficients shares = ThinSheetFresnel(surface, ray.firstCos, ray.lastCos);
        vec3 reflected = shares.reflected;
        float chance = clamp((reflected.x + reflected.y + reflected.z) * (1.0f / 3.0f), 0.0f, 1.0f);
        bool isReflected = WalkGet1D(rng) < chance;
        result.weight = isReflected ? reflected / chance : shares.passed / (1.0f - chance);
        if (!isReflected) result.wi.z = -result.wi.z;
    }
    return result;
}

// Returns the density per solid angle of the directions w into which the facets seen from v reflect, without
// Fresnel.
INLINE float ReflectionPhase(vec2 alpha, vec3 v, vec3 w) {
    vec3 h = v + w;
    float square = dot(h, h);
    if (!(h.z > 0.0f) || !(square > 0.0f)) return 0.0f;
    return WalkDistribution(alpha, h / sqrt(square)) / (4.0f * ProjectedMicrofacetArea(alpha, v));
}

// Returns the light that single facets send from w to a ray at v, and that leaves without meeting another
// one; then the same for refraction.
INLINE vec3 ConnectReflected(WalkRay ray, WalkSurface surface, vec3 w, bool isThrough) {
    float phase = ReflectionPhase(surface.alpha, ray.view, w);
    if (!(phase > 0.0f)) return vec3(0.0f);
    float leaves = exp2(-ray.depth * WalkLambda(surface.alpha, w));
    float cosI = dot(ray.view, normalize(ray.view + w));
    vec3 reflected = vec3(0.0f);
    if (surface.kind == kWalkPassesThin) {
        FresnelCoefficients shares = ThinSheetFresnel(surface, ray.firstCos, cosI);
        reflected = isThrough ? shares.passed : shares.reflected;
    } else {
        reflected =
            FacetReflectance(surface.fresnel, cosI, ray.side > 0.0f ? surface.eta : 1.0f / surface.eta);
    }
    return reflected * (phase * leaves);
}

INLINE vec3 ConnectRefracted(WalkRay ray, WalkSurface surface, vec3 w) {
    float eta = ray.side > 0.0f ? surface.eta : 1.0f / surface.eta;
    vec3 h = ray.view + eta * w;
    float square = dot(h, h);
    if (!(square > 0.0f)) return vec3(0.0f);
    vec3 m = h / (h.z > 0.0f ? sqrt(square) : -sqrt(square));
    float cosI = dot(ray.view, m);
    float cosT = -dot(w, m);
    if (!(cosI > 0.0f) || !(cosT > 0.0f)) return vec3(0.0f);
    // This is |dm / dw| of Walter et al. 2007, equation 17
    float jacobian = eta * eta * cosT / Sqr(cosI - eta * cosT);
    float phase = WalkDistribution(surface.alpha, m) * cosI * jacobian /
                  ProjectedMicrofacetArea(surface.alpha, ray.view);
    float leaves = exp2(-DepthFromOtherSide(ray.depth) * WalkLambda(surface.alpha, -w));
    return EvaluateFresnel(surface.fresnel, cosI, eta).passed * (phase * leaves);
}

// f |wi.z| by one bounce of reflection (all of it above, but for Fresnel), exactly: the mean of a connection
// over the depths of first facets is 1 / (1 + Lambda(wo) + Lambda(wi)), height-correlated Smith.
INLINE float SingleReflection(vec2 alpha, vec3 wo, vec3 wi) {
    float lambda = WalkLambda(alpha, wi);
    return ReflectionPhase(alpha, wo, wi) * ProjectedMicrofacetArea(alpha, wo) /
           (ProjectedMicrofacetArea(alpha, wo) + lambda * wo.z);
}

// Returns an unbiased estimate of f |wi.z| with the factors that SampleWalk's weight has: a walk from wo,
// connected to wi at each facet that it meets.
INLINE vec3 EstimateWalk(WalkSurface surface, vec3 wo, vec3 wi, uint seed) {
    bool isThin = surface.kind == kWalkPassesThin;
    bool isThrough = wi.z < 0.0f;
    if (wi.z == 0.0f || (isThrough && surface.kind == kWalkAbsorbs)) return vec3(0.0f);
    vec3 target = isThin && isThrough ? vec3(wi.x, wi.y, -wi.z) : wi;

    // The first reflection is connected exactly.
    vec3 sum = vec3(0.0f);
    if (target.z > 0.0f) {
        float single = SingleReflection(surface.alpha, wo, target);
        if (single > 0.0f) {
            float cosI = dot(wo, normalize(wo + target));
            FresnelCoefficients shares = EvaluateFresnel(surface.fresnel, cosI, surface.eta);
            sum = (isThin && isThrough ? shares.passed : shares.reflected) * single;
        }
    }

    // All later bounces are those of the walk.
    WalkRng rng = StartWalkRng(seed);
    WalkRay ray = StartWalkRay(wo);
    vec3 multiple = vec3(0.0f);
    for (uint i = 0u; i < kWalkBounceLimit && AdvanceToNextFacet(ray, surface.alpha, WalkGet1D(rng)); ++i) {
        vec3 here = ray.side * target;
        if (here.z < 0.0f)
            multiple += ray.weight * ConnectRefracted(ray, surface, here);
        else if (i > 0u)
            multiple += ray.weight * ConnectReflected(ray, surface, here, isThrough);
        ScatterAtFacet(ray, surface, rng, i == 0u);
    }
    return sum + multiple;
}

SHADING_END

#endif
