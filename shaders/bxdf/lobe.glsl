// A material is a sum of lobes (bxdf/gltf_lobes.glsl lists them), and this is what they share: the surface as
// seen from one direction, computed once for all of them, and their interface.
//
// Each lobe has a file of its own, with a struct of its parameters as seen from wo and these overloads.
// Conventions are those of bxdf/bxdf.glsl, but wo.z > 0 always: the integrator turns the frame.
//     InitLobe(lobe, material, setting, view, share)
//         makes the lobe. `share` comes in as the share of light that arrives at the lobe from above; a lobe
//         that covers those below multiplies it by what it lets pass towards wo
//     uint Flags(lobe, view)
//     bool IsDiffuse(lobe)  whether that has kBxDFDiffuse
//     vec3 Evaluate(lobe, view, pair, pdf)               f, and the density of pair.wi in SampleDirection
//     bool SamplesCosine(lobe, uc)  whether SampleDirection takes a direction by the cosine, or else a
//         facet's normal: one place draws them for all lobes (SampleCosineOrNormal), which a device would
//         otherwise do one by one
//     BSDFSample SampleDirection(lobe, view, drawn, uc, u)  Sample_f without f and pdf; no sample: kBxDFNone.
//         `drawn`, with u, is what SamplesCosine says
//     float Weight(lobe, view)         about its albedo: samples are distributed to lobes in proportion
//     LobeMean Reflected(lobe, view)   directional albedo and shape, for light that has been filtered
//     LobeMean Transmitted(lobe, view)
//     float NormalizedTransmittance(lobe, view, pair)
//         the factor on the diffuse lobes below for light from pair.wi; its
//         mean by the cosine is 1, so that a base under a layer has the albedo that InitLobe gave it. Lobes
//         that scatter into few directions have no such mean: `share` is all that they lose. A layer is on
//         both sides of a surface, and passes light of either side alike
//     bool IsWalked(lobe), MicrosurfaceWalk WalkOf(lobe, view)
//         whether a random walk between the facets takes the lobe's place where kMultiscatter asks for walks
//         (bxdf/gltf.glsl), and which
//     vec3 PassThroughWeight(lobe, view), float PassThroughProbability(lobe, view), WithoutPassThrough(lobe)
//         at a smooth thin wall: the share of light that goes straight on, f |wi.z| of that delta; the
//         probability that a sample of the lobe does; and the lobe without that. What such a lobe transmits
//         at all, it transmits so
// LOBE_IS_OPAQUE, LOBE_HAS_NO_PASS_THROUGH (part of the former), LOBE_IS_NOT_A_LAYER and LOBE_HAS_NO_WALK
// write the overloads that are the same for most lobes. LOBE_BXDF_INTERFACE(Lobe) adds f, PDF and Sample_f of
// the lobe alone, which the tests hold to their contracts.
#ifndef RAYGRAPH_BXDF_LOBE_GLSL
#define RAYGRAPH_BXDF_LOBE_GLSL

#include "bxdf/anisotropy.glsl"
#include "bxdf/bxdf.glsl"
#include "bxdf/energy.glsl"
#include "bxdf/facet_fresnel.glsl"
#include "bxdf/microfacet.glsl"
#include "bxdf/multiscatter_walk.glsl"
#include "core/trace_options.glsl"
#include "core/warp.glsl"
#include "scene/ray.glsl"

SHADING_BEGIN

// Holds the properties that shading needs in addition to a surface's material.
struct SurfaceSetting {
    float eta;    // n(other side) / n(side of wo)
    bool isThin;  // there is no medium behind it: a thin wall of that index
    bool isMatched;  // IsIndexMatched (bxdf/bsdf.glsl); read if kTraceMatchedMedia is set
    vec2 alpha;   // roughness of its facets along x and y
    uint seed;    // seed of the random walk and of bxdf/anisotropy.glsl; another one for each sample
    vec3 coatNormal;  // normal of the clear coat, in the frame of the surface; not read without a coat
    float coatAlpha;
    float outerIor;  // index of the medium that wo is in; read if kTraceIridescence is set
};

// `minAlpha`: no facets are less rough. For those that have no coat normal, which is the surface's, and are
// not seen from within the material.
INLINE SurfaceSetting SettingOf(SurfaceMaterial material, float eta, float minAlpha, uint seed) {
    SurfaceSetting setting;
    setting.eta = eta;
    setting.isThin = (material.flags & kMaterialVolume) == 0u;
    setting.isMatched = false;
    setting.alpha = max(AlphaOf(material), vec2(minAlpha));
    setting.seed = seed;
    setting.coatNormal = vec3(0.0f, 0.0f, 1.0f);
    setting.coatAlpha = max(Sqr(material.clearcoatRoughness), minAlpha);
    if (HasTraceFeature(kTraceIridescence)) setting.outerIor = material.ior / eta;
    return setting;
}

// Holds the facets of a surface as seen from one direction.
struct FacetView {
    vec3 wo;
    MicrofacetDistribution facets;
    bool isSmooth;  // the lobes of these facets are deltas
    bool isThin;
    float roughness;     // the material's roughness: setting.alpha may be raised
    TableSpan row;       // row of the energy tables, for IsotropicAlpha
    FacetEnergy energy;  // towards wo
    float higherOrderCurve;    // mean curve of its later bounces, HigherOrderCurve
    float retroreflectedShare;  // share of the reflection that goes back (bxdf/retroreflection.glsl). Read if
                         // kTraceRetroreflection is set
};

INLINE FacetView ViewOfFacets(vec2 alpha, bool isThin, float roughness, vec3 wo, uint seed) {
    FacetView view;
    view.wo = wo;
    view.facets = MakeMicrofacetDistribution(alpha);
    view.isSmooth = IsEffectivelySmooth(view.facets);
    view.isThin = isThin;
    view.roughness = roughness;
    view.row = EnergyRow(IsotropicAlpha(view.facets.alpha));
    view.energy = ViewEnergy(view.facets.alpha, view.row, wo, seed);
    view.higherOrderCurve = ViewHigherOrderCurve(view.facets.alpha, view.row, view.energy);
    view.retroreflectedShare = 0.0f;
    return view;
}

INLINE FacetView ViewOf(SurfaceMaterial material, SurfaceSetting setting, vec3 wo) {
    float roughness = material.roughness;
    if (HasTraceFeature(kTraceAnisotropy)) roughness = sqrt(IsotropicAlpha(AlphaOf(material)));
    FacetView view = ViewOfFacets(setting.alpha, setting.isThin, roughness, wo, setting.seed);
    if (HasTraceFeature(kTraceRetroreflection))
        view.retroreflectedShare = clamp(material.retroreflection, 0.0f, 1.0f);
    return view;
}

INLINE float Average(vec3 v) { return (v.x + v.y + v.z) * (1.0f / 3.0f); }

// Returns the flag of what these facets reflect or transmit.
INLINE uint FacetFlags(FacetView view) { return view.isSmooth ? kBxDFSpecular : kBxDFGlossy; }

// Returns a facet's normal by the density of what wo sees; the surface's where it is smooth.
INLINE vec3 SampleNormal(FacetView view, vec2 u) {
    return view.isSmooth ? vec3(0.0f, 0.0f, 1.0f) : Sample_wm(view.facets, view.wo, u);
}

// Returns the `drawn` argument of a lobe's SampleDirection.
INLINE vec3 SampleCosineOrNormal(FacetView view, bool isCosine, vec2 u) {
    return isCosine ? SampleCosineHemisphere(u) : SampleNormal(view, u);
}

// wo and one wi, with what all lobes of the facets need to know of them.
struct FacetPair {
    vec3 wi;
    bool isDelta;         // wi was sampled from a delta, and only deltas scatter there
    float cosI;  // cosine of wo to the normal that reflects it to wi, or to wi mirrored by a thin wall
    float reflection;     // f of facets that reflect everything; of a delta, its factor
    float reflectionPDF;  // 0, like the two above: no facet does
};

// Mirrors a direction about the normal.
INLINE vec3 Mirrored(vec3 w) { return vec3(-w.x, -w.y, w.z); }

INLINE FacetPair PairOf(FacetView view, vec3 wi, bool isDelta) {
    FacetPair pair;
    pair.wi = wi;
    pair.isDelta = isDelta;
    pair.cosI = 0.0f;
    pair.reflection = 0.0f;
    pair.reflectionPDF = 0.0f;
    if (isDelta != view.isSmooth || (wi.z < 0.0f && !view.isThin)) return pair;
    if (isDelta) {
        // A coat has deltas of its own, in other directions, and so has light that goes back
        if (HasTraceFeature(kTraceClearcoat | kTraceRetroreflection) && wi.z > 0.0f &&
            distance(wi, Mirrored(view.wo)) > 1e-3f)
            return pair;
        pair.cosI = view.wo.z;
        pair.reflection = 1.0f / abs(wi.z);
        pair.reflectionPDF = 1.0f;
        return pair;
    }
    vec3 mirrored = vec3(wi.x, wi.y, abs(wi.z));
    vec3 wm = ReflectionNormal(view.wo, mirrored);
    float cosI = dot(view.wo, wm);
    if (!(cosI > 0.0f)) return pair;
    pair.cosI = cosI;
    pair.reflection = ReflectionLobe(view.facets, view.wo, mirrored, wm);
    pair.reflectionPDF = ReflectionPDF(view.facets, view.wo, wm);
    return pair;
}

// Returns whether diffuse lobes scatter light from there: of the other side, only if one transmits.
INLINE bool IsForDiffuse(FacetPair pair) {
    if (pair.isDelta) return false;
    return HasTraceFeature(kTraceDiffuseTransmission) ? pair.wi.z != 0.0f : pair.wi.z > 0.0f;
}

// Returns a direction without its f and pdf, which Evaluate gives.
INLINE BSDFSample SampledDirection(vec3 wi, float eta, uint flags) {
    BSDFSample result = NoSample();
    result.wi = wi;
    result.eta = eta;
    result.flags = flags;
    return result;
}

// Returns a direction drawn by the cosine; at the rim, which has no density, there is none.
INLINE BSDFSample CosineDirection(vec3 wi, uint flags) {
    return wi.z > 0.0f ? SampledDirection(wi, 1.0f, kBxDFReflection | flags) : NoSample();
}

// Returns wo reflected at a facet; into the surface it meets another facet, and that light is lost.
INLINE BSDFSample ReflectedDirection(FacetView view, vec3 wm) {
    vec3 wi = Reflect(view.wo, wm);
    if (!(wi.z > 0.0f)) return NoSample();
    return SampledDirection(wi, 1.0f, kBxDFReflection | FacetFlags(view));
}

// Describes a lobe as a whole, for those who look up light that has been filtered.
struct LobeMean {
    vec3 albedo;
    vec3 wi;          // about the middle of its directions
    float roughness;  // roughness of facets with which they spread so
    float slope;      // for transmitted light: standard deviation of the slope of its directions
    bool isDiffuse;   // they are all of that side, by the cosine; wi is the normal
    vec2 alpha;       // alpha of reflecting facets; where HasAnisotropicAlpha, AnisotropySampleOf tells more
};

INLINE LobeMean NoMean() {
    LobeMean mean;
    mean.albedo = vec3(0.0f);
    mean.wi = vec3(0.0f, 0.0f, 1.0f);
    mean.roughness = 0.0f;
    mean.slope = 0.0f;
    mean.isDiffuse = false;
    mean.alpha = vec2(0.0f);
    return mean;
}

// Returns the dominant direction of a rough surface's reflection, between the mirror direction and the
// normal. S. Lagarde and C. de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", section
// 4.9.3.
INLINE vec3 DominantDirection(vec3 normal, vec3 mirrored, float roughness) {
    float smoothness = 1.0f - roughness;
    return normalize(mix(normal, mirrored, smoothness * (sqrt(smoothness) + roughness)));
}

INLINE vec3 DominantReflection(vec3 wo, float roughness) {
    return DominantDirection(vec3(0.0f, 0.0f, 1.0f), Mirrored(wo), roughness);
}

// Returns the mean of facets that reflect `albedo`.
INLINE LobeMean FacetMean(FacetView view, vec3 albedo) {
    LobeMean mean = NoMean();
    mean.albedo = albedo;
    mean.wi = DominantReflection(view.wo, view.roughness);
    mean.roughness = view.roughness;
    mean.alpha = view.facets.alpha;
    return mean;
}

// A stretched reflection is about that of round facets all along a line of normals, as if the surface were
// bent: one of `count` such, evenly chosen.
struct AnisotropySample {
    vec3 wi;
    float roughness;
    float weight;  // weights have no common sum
};

INLINE AnisotropySample AnisotropySampleOf(vec2 alpha, vec3 wo, uint i, uint count) {
    // Slopes along x have the marginal density of GGX, with what the round facets lack
    float q = (2.0f * float(i) + 1.0f) / float(count) - 1.0f;
    float along = sqrt(max(Sqr(alpha.x) - Sqr(alpha.y), 0.0f));
    vec3 normal = normalize(vec3(along * q, 0.0f, sqrt(1.0f - q * q)));
    float gap = along * normal.z * normal.z / (pow(1.0f - q * q, 1.5f) * float(count));
    float cosI = dot(wo, normal);
    vec3 mirrored = 2.0f * cosI * normal - wo;
    AnisotropySample part;
    part.roughness = sqrt(min(max(alpha.y, gap), 1.0f));
    part.wi = DominantDirection(normal, mirrored, part.roughness);
    part.weight =
        cosI > 0.0f && mirrored.z > 0.0f ? cosI / normal.z * ConditionalShadowing(alpha, wo, mirrored) : 0.0f;
    return part;
}

// -------------------------------------------------------------------------------------- energy of the facets

// The tables are those of GGX with correlated masking; other models are not scaled.
INLINE bool HasCompensation() {
    return ActiveMultiscatterKind() == kMultiscatterKindLut && ActiveDistribution() == kDistributionGgx &&
           ActiveMasking() == kMaskingCorrelated;
}

INLINE bool UsesMicrosurfaceWalk() {
    return ActiveMultiscatterKind() == kMultiscatterKindWalk && ActiveDistribution() == kDistributionGgx;
}

// Returns the factor by which single scattering of albedo `single` includes `multiple`. The tables count
// shares of f90 in 65535ths: they do not tell less than one from none.
INLINE vec3 MultipleScatteringScale(vec3 single, vec3 multiple, vec3 f90) {
    if (!HasCompensation()) return vec3(1.0f);
    return vec3(1.0f) + multiple / max(single, max(f90 * (1.0f / 65535.0f), vec3(1e-20f)));
}

// MultipleAlbedo, if there is any.
INLINE vec3 MultipleScatteringAlbedo(FacetView view, FacetEnergy energy, vec3 f0, vec3 f90) {
    if (!HasCompensation() && !UsesMicrosurfaceWalk()) return vec3(0.0f);
    return MultipleAlbedo(energy, f0, f90, view.higherOrderCurve);
}

// Returns the albedo of facets of this reflectance.
INLINE vec3 FacetAlbedo(FacetView view, FacetEnergy energy, vec3 f0, vec3 f90) {
    return SingleAlbedo(energy, f0, f90) + MultipleScatteringAlbedo(view, energy, f0, f90);
}

// Returns the mean of facets of this reflectance that reflect once, times `scale`.
INLINE LobeMean FacetMean(FacetView view, vec3 scale, vec3 f0, vec3 f90) {
    return FacetMean(view, scale * SingleAlbedo(view.energy, f0, f90));
}

// Describes a walk between the facets, and the factors on what it reflects and transmits.
struct MicrosurfaceWalk {
    WalkSurface surface;
    vec3 reflect;
    vec3 pass;
    float eta;  // index of a sample that is transmitted
};

// Returns the walk of facets that reflect, and do nothing else.
INLINE MicrosurfaceWalk ReflectedWalk(FacetView view, FacetFresnel fresnel, float eta, vec3 scale) {
    MicrosurfaceWalk walk;
    walk.surface.alpha = view.facets.alpha;
    walk.surface.kind = kWalkAbsorbs;
    walk.surface.eta = eta;
    walk.surface.fresnel = fresnel;
    walk.reflect = scale;
    walk.pass = vec3(0.0f);
    walk.eta = 1.0f;
    return walk;
}

// Returns the material's film on facets that are seen from a medium of that index.
INLINE ThinFilm FilmOf(SurfaceMaterial material, float outerIor) {
    ThinFilm film = NoFilm();
    if (!HasTraceFeature(kTraceIridescence) || !(material.iridescenceThickness > 0.0f)) return film;
    film.weight = material.iridescence;
    film.eta = material.iridescenceIor / outerIor;
    film.path = 2.0f * material.iridescenceIor * material.iridescenceThickness;
    return film;
}

// The ends of the curve that the energy tables take for facets.
struct TableCurve {
    vec3 f0;
    vec3 f90;
};

CONST uint kFilmViewCount = 6u;

// Returns the facets' own curve; under a film the one that reflects as much as they do to wo, by the mean
// over a few of them. That is an estimate, for the chances of sampling, later bounces and what passes to a
// base: what is evaluated is the film's reflectance. `isMasked`: only light that leaves by reflection counts,
// not light that meets another facet.
INLINE TableCurve TableCurveOf(FacetFresnel fresnel, FacetView view, float eta, bool isMasked) {
    TableCurve curve;
    curve.f0 = fresnel.f0;
    curve.f90 = fresnel.f90;
    if (!HasFilm(fresnel.film)) return curve;
    FacetFresnel bare = fresnel;
    bare.film = NoFilm();
    vec3 gain = vec3(0.0f);
    float rise = 0.0f;  // weight of f90
    float sum = 1e-9f;
    uint count = view.isSmooth ? 1u : kFilmViewCount;
    DONT_UNROLL
    for (uint i = 0u; i < count; ++i) {
        vec2 u = vec2((float(i) + 0.5f) / float(kFilmViewCount), fract(0.618034f * float(i)));
        vec3 wm = SampleNormal(view, u);
        vec3 wi = Reflect(view.wo, wm);
        float c = max(dot(view.wo, wm), 0.0f);
        float weight = 1.0f;
        if (isMasked) weight = wi.z > 0.0f ? wi.z * GOverCosines(view.facets, view.wo, wi) : 0.0f;
        gain += weight * (FacetReflectance(fresnel, c, eta) - FacetReflectance(bare, c, eta));
        rise += weight * SchlickWeight(!fresnel.isMetal && eta < 1.0f ? RefractedCosine(c, eta) : c);
        sum += weight;
    }
    gain /= sum;
    rise = clamp(rise / sum, 0.0f, 0.95f);
    // f0 takes the gain as far as it can, but is never 0: a lobe of no weight is not sampled
    vec3 f0 = curve.f0 + gain / (1.0f - rise);
    curve.f0 = clamp(f0, 1e-3f * curve.f90, vec3(1.0f));
    vec3 f90 = curve.f90 + min(f0, vec3(0.0f)) * ((1.0f - rise) / max(rise, 1e-3f));
    curve.f90 = max(f90, 1e-3f * curve.f90);
    return curve;
}

INLINE MicrosurfaceWalk NoWalk(FacetView view) {
    return ReflectedWalk(view, BlackFresnel(), 1.0f, vec3(0.0f));
}

// Returns the Fresnel of a material's dielectric, whose index is eta times that of the medium before it.
INLINE FacetFresnel DielectricFresnel(SurfaceMaterial material, float eta) {
    FacetFresnel fresnel;
    fresnel.f0 = min(DielectricF0(eta) * material.specularColor, vec3(1.0f)) * material.specular;
    fresnel.f90 = vec3(material.specular * DielectricF90(eta));
    fresnel.exactF90 = vec3(material.specular);
    fresnel.isMetal = false;
    fresnel.film = NoFilm();
    return fresnel;
}

// Returns the Fresnel values with the film, which are relative to the thinner side.
INLINE FacetFresnel DielectricFresnel(SurfaceMaterial material, SurfaceSetting setting) {
    FacetFresnel fresnel = DielectricFresnel(material, setting.eta);
    if (HasTraceFeature(kTraceIridescence))
        fresnel.film = FilmOf(material, setting.outerIor * min(setting.eta, 1.0f));
    return fresnel;
}

// Returns the index as seen from the thinner side, where nothing is reflected totally.
INLINE float OutsideEta(float eta) { return max(eta, 1.0f / eta); }

// Returns the share of light that meets the dielectric, and of that the one which it transmits.
INLINE float DielectricShare(SurfaceMaterial material) { return 1.0f - material.metallic; }
INLINE float GlassShare(SurfaceMaterial material) {
    return HasTraceFeature(kTraceGlass) ? DielectricShare(material) * material.transmission : 0.0f;
}

SHADING_END

// For lobes through which nothing goes straight on.
#define LOBE_HAS_NO_PASS_THROUGH(Lobe)                                          \
    INLINE vec3 PassThroughWeight(Lobe, FacetView) { return vec3(0.0f); }         \
    INLINE float PassThroughProbability(Lobe, FacetView) { return 0.0f; }             \
    INLINE Lobe WithoutPassThrough(Lobe lobe) { return lobe; }

// It transmits nothing.
#define LOBE_IS_OPAQUE(Lobe)                                                  \
    INLINE LobeMean Transmitted(Lobe, FacetView) { return NoMean(); }         \
    LOBE_HAS_NO_PASS_THROUGH(Lobe)

#define LOBE_IS_NOT_A_LAYER(Lobe)                                             \
    INLINE float NormalizedTransmittance(Lobe, FacetView, FacetPair) { return 1.0f; }

#define LOBE_HAS_NO_WALK(Lobe)                                              \
    INLINE bool IsWalked(Lobe) { return false; }                              \
    INLINE MicrosurfaceWalk WalkOf(Lobe, FacetView view) { return NoWalk(view); }

#define LOBE_BXDF_INTERFACE(Lobe)                                                             \
    INLINE vec3 f(Lobe lobe, FacetView view, vec3 wi) {                              \
        float pdf = 0.0f;                                                            \
        return Evaluate(lobe, view, PairOf(view, wi, false), pdf);                   \
    }                                                                                \
    INLINE float PDF(Lobe lobe, FacetView view, vec3 wi) {                           \
        float pdf = 0.0f;                                                            \
        Evaluate(lobe, view, PairOf(view, wi, false), pdf);                          \
        return pdf;                                                                  \
    }                                                                                \
    INLINE BSDFSample Sample_f(Lobe lobe, FacetView view, float uc, vec2 u) {        \
        vec3 drawn = SampleCosineOrNormal(view, SamplesCosine(lobe, uc), u);                        \
        BSDFSample s = SampleDirection(lobe, view, drawn, uc, u);                    \
        if (s.flags == kBxDFNone) return NoSample();                                 \
        s.f = Evaluate(lobe, view, PairOf(view, s.wi, IsSpecular(s.flags)), s.pdf);  \
        return s;                                                                    \
    }

#endif
