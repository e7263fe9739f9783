// The material of glTF 2.0 (appendix B) with KHR_materials_ior, specular and transmission, at one point:
//     mix(dielectric, metal, metallic)
//     dielectric = a Fresnel layer over mix(diffuse, transmitted, transmission)
//
// Layer and metal are rough GGX reflection; light is transmitted by refraction, or by a thin wall, where it
// passes straight on, spread by the roughness. Both take their color from baseColor.
//
// The layer reduces the diffuse base by what it reflects: with E its albedo, the base is multiplied by (1 -
// E(wo)) (1 - E(wi)) / (1 - mean E), which is reciprocal and returns everything where the base is white
// (Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks").
//
// Multiple scattering between the facets, by kMultiscatter:
// - `off` loses them.
// - `lut` scales each lobe by a factor that depends on wo (bxdf/energy.glsl), so that f(wo, wi) and f(wi, wo)
//   differ by the ratio of two such factors: for white metals and thin walls less than 1.4 at alpha 0.2, 1.8
//   at 0.5 and 3.3 at 1, for dielectrics over diffuse less than 1.1.
// - `walk` simulates a random walk (bxdf/multiscatter_walk.glsl). f is then an unbiased estimate that depends
//   on `seed`, and PDF, made of single scattering and a diffuse share, only approximates the density of
//   Sample_f. It suffices for the weights of multiple importance sampling, which only need to sum to one; f
//   |wi.z| / pdf of the sample is an unbiased estimate, but is not f(wo, wi) |wi.z| / PDF(wo, wi).
//
// wo.z > 0 always: the integrator turns the frame to the viewer's side and gives eta for it. Transmission
// scales radiance by 1 / eta^2, and the sample returns eta.
//
// Prepare(bxdf, wo) computes once what f, PDF and Sample_f at wo share; prefer the overloads that take
// its result.
#ifndef RAYGRAPH_BXDF_GLTF_GLSL
#define RAYGRAPH_BXDF_GLTF_GLSL

#include "bxdf/gltf_prepare.glsl"
#include "bxdf/multiscatter_walk.glsl"
#include "core/warp.glsl"

SHADING_BEGIN

// The index as seen from the thinner side, where nothing is reflected totally.
INLINE float OutsideEta(PreparedGltf g) { return max(g.bxdf.eta, 1.0f / g.bxdf.eta); }

// The reflectance of the dielectric's facets, seen from wo.
INLINE vec3 GlassReflectance(PreparedGltf g, float cosI) {
    return FacetReflectance(g.dielectric, cosI, g.isThin ? OutsideEta(g) : g.eta);
}

// The reflectance of opaque facets. From inside a denser medium they act as from outside.
INLINE vec3 OpaqueReflectance(PreparedGltf g, float cosI) {
    if (ActiveFresnel() == kFresnelSchlick) return FresnelSchlick(cosI, g.reflect0, g.reflect90);
    return g.metalScale * FacetReflectance(MetalFresnel(g.bxdf), cosI, 1.0f) +
           g.layerScale * FacetReflectance(g.dielectric, cosI, OutsideEta(g));
}

INLINE bool HasDiffuseBase(PreparedGltf g) { return MaxComponent(g.diffuse) > 0.0f; }

// The probability that Sample_f reflects at a facet of glass.
INLINE float GlassReflectChance(PreparedGltf g, vec3 reflectance) {
    float reflected = Average(g.glassReflect * reflectance);
    float passed = Average(g.glassPass * PassedShare(reflectance));
    float sum = reflected + passed;
    return sum > 0.0f ? reflected / sum : 1.0f;
}

// Share of light at cosI to the normal that passes straight through a smooth thin wall: f |wi.z| of
// that delta.
INLINE vec3 StraightShare(GltfBxDF lobe, float cosI) {
    if (!(cosI > 0.0f)) return vec3(0.0f);
    vec3 reflectance = FacetReflectance(DielectricFresnel(lobe), cosI, max(lobe.eta, 1.0f / lobe.eta));
    return lobe.baseColor * ((1.0f - lobe.metallic) * lobe.transmission) * PassedShare(reflectance);
}

// The probability that Sample_f passes straight through a smooth thin wall.
INLINE float StraightChance(PreparedGltf g) {
    if (!HasGlass(g)) return 0.0f;
    return g.glassChance * (1.0f - GlassReflectChance(g, GlassReflectance(g, g.wo.z)));
}

// A smooth thin wall without its transmission; `chance` is StraightChance, and below 1.
INLINE PreparedGltf WithoutStraight(PreparedGltf g, float chance) {
    float scale = 1.0f / (1.0f - chance);
    g.glassPass = vec3(0.0f);
    g.glassChance = max(g.glassChance - chance, 0.0f) * scale;
    g.opaqueChance *= scale;
    g.diffuseChance *= scale;
    return g;
}

// The diffuse base under the layer.
INLINE vec3 GltfBase(PreparedGltf g, vec3 wi) {
    if (!HasDiffuseBase(g)) return vec3(0.0f);
    FacetEnergy energy = FacetEnergyAt(g.row, wi.z);
    vec3 layer = SingleAlbedo(energy, g.dielectric.f0, g.dielectric.f90) +
                 LaterAlbedo(g, energy, g.dielectric.f0, g.dielectric.f90);
    return g.diffuse * max(PassedShare(layer), vec3(0.0f));
}

// All parts that are sampled by the cosine: the base, and multiple scattering of glass.
INLINE vec3 GltfDiffuse(PreparedGltf g, vec3 wi) { return GltfBase(g, wi) + g.glassDiffuse; }

// The refraction that the tables scale: masked like reflection, which is closer in shape to all bounces
// together than one bounce is.
INLINE float CompensatedRefractionLobe(PreparedGltf g, vec3 wi, vec3 wm) {
    float ci = abs(wi.z);
    float visible = 1.0f / (g.wo.z * ci + LambdaCos(g.facets, g.wo) * ci + LambdaCos(g.facets, wi) * g.wo.z);
    return D(g.facets, wm) * visible * dot(g.wo, wm) * RefractionJacobian(g.wo, wi, wm, g.eta) / Sqr(g.eta);
}

// f of single scattering by the facets, and its part of the density.
INLINE vec3 GltfFacets(PreparedGltf g, vec3 wi, OUT(float) pdf) {
    pdf = 0.0f;
    bool isThrough = HasTraceFeature(kTraceGlass) && wi.z < 0.0f;
    if (isThrough && !g.isThin) {
        vec3 wm = RefractionNormal(g.wo, wi, g.eta);
        if (!IsRefractedBy(g.wo, wi, wm)) return vec3(0.0f);
        vec3 reflectance = GlassReflectance(g, dot(g.wo, wm));
        pdf = g.glassChance * (1.0f - GlassReflectChance(g, reflectance)) *
              RefractionPDF(g.facets, g.wo, wi, wm, g.eta);
        float lobe = HasCompensation() ? CompensatedRefractionLobe(g, wi, wm)
                                       : RefractionLobe(g.facets, g.wo, wi, wm, g.eta);
        return g.glassPass * PassedShare(reflectance) * lobe;
    }
    vec3 mirrored = vec3(wi.x, wi.y, abs(wi.z));
    vec3 wm = ReflectionNormal(g.wo, mirrored);
    float cosI = dot(g.wo, wm);
    if (!(cosI > 0.0f)) return vec3(0.0f);
    vec3 value = vec3(0.0f);
    float chance = 0.0f;
    if (!isThrough) {
        value = OpaqueReflectance(g, cosI);
        chance = g.opaqueChance;
    }
    if (HasGlass(g)) {
        vec3 reflectance = GlassReflectance(g, cosI);
        float reflectChance = GlassReflectChance(g, reflectance);
        value += isThrough ? g.glassPass * PassedShare(reflectance) : g.glassReflect * reflectance;
        chance += g.glassChance * (isThrough ? 1.0f - reflectChance : reflectChance);
    }
    pdf = chance * ReflectionPDF(g.facets, g.wo, wm);
    return value * ReflectionLobe(g.facets, g.wo, mirrored, wm);
}

// One of the surfaces in which the walk may take place, chosen with a probability that `weight`
// compensates for.
INLINE WalkSurface ChooseWalk(PreparedGltf g, float uc, OUT(vec3) weight) {
    float chance = uc * (g.opaqueChance + g.glassChance);
    float metalChance = g.opaqueChance * g.metalShare;
    float layerChance = g.opaqueChance - metalChance;
    float layered = 1.0f - g.bxdf.metallic;
    WalkSurface surface;
    surface.alpha = g.facets.alpha;
    surface.kind = kWalkAbsorbs;
    surface.eta = OutsideEta(g);
    surface.fresnel = g.dielectric;
    if (HasGlass(g) && chance >= g.opaqueChance) {
        surface.kind = g.isThin ? kWalkPassesThin : kWalkRefracts;
        if (!g.isThin) surface.eta = g.eta;
        weight = vec3(layered * g.bxdf.transmission / g.glassChance);
    } else if (layerChance > 1e-6f && chance >= metalChance) {
        weight = vec3(layered * (1.0f - g.bxdf.transmission) / layerChance);
    } else {
        surface.fresnel = MetalFresnel(g.bxdf);
        weight = vec3(g.bxdf.metallic / max(metalChance, 1e-20f));
    }
    return surface;
}

// The factor on transmitted light: the base's color, and the scale of radiance.
INLINE vec3 PassedTint(PreparedGltf g) {
    return g.isThin ? g.bxdf.baseColor : g.bxdf.baseColor / Sqr(g.bxdf.eta);
}

// The walk's estimate of f, without diffuse; `pdf` comes in as the density of single scattering and becomes
// that of the walk.
INLINE vec3 GltfWalkEstimate(PreparedGltf g, vec3 wi) {
    WalkRng rng = StartWalkRng(g.bxdf.seed ^ 0x5bd1e995u);
    vec3 weight = vec3(0.0f);
    WalkSurface surface = ChooseWalk(g, WalkGet1D(rng), weight);
    weight *= g.opaqueChance + g.glassChance;
    vec3 value = EstimateWalk(surface, g.wo, wi, rng.state);
    if (wi.z < 0.0f) value *= PassedTint(g);
    return value * weight / abs(wi.z);
}

// The density that approximates the walk's: single scattering, and a cosine lobe for the rest.
INLINE float GltfWalkPDF(PreparedGltf g, vec3 wi, float singlePdf) {
    float glassHalf = 0.5f * g.glassChance;
    float chance = wi.z > 0.0f ? g.opaqueChance + glassHalf : glassHalf;
    return mix(singlePdf, chance * CosineHemispherePDF(abs(wi.z)), g.rescattered);
}

// f and PDF at once, and the part of f that is the diffuse base's; the rest is the facets'.
INLINE vec3 Evaluate(PreparedGltf g, vec3 wi, OUT(float) pdf, OUT(vec3) diffuse) {
    pdf = 0.0f;
    diffuse = vec3(0.0f);
    vec3 value = vec3(0.0f);
    if (!(g.wo.z > 0.0f) || wi.z == 0.0f) return value;
    if (!g.isSmooth && (g.opaqueChance > 0.0f || HasGlass(g)) && (wi.z > 0.0f || HasGlass(g))) {
        value = GltfFacets(g, wi, pdf);
        if (IsWalked()) {
            value = GltfWalkEstimate(g, wi);
            pdf = GltfWalkPDF(g, wi, pdf);
        }
    }
    if (wi.z > 0.0f && g.diffuseChance > 0.0f) {
        diffuse = GltfBase(g, wi);
        value += diffuse + g.glassDiffuse;
        pdf += g.diffuseChance * CosineHemispherePDF(wi.z);
    }
    return value;
}

INLINE vec3 Evaluate(PreparedGltf g, vec3 wi, OUT(float) pdf) {
    vec3 diffuse = vec3(0.0f);
    return Evaluate(g, wi, pdf, diffuse);
}

INLINE vec3 f(PreparedGltf g, vec3 wi) {
    float pdf = 0.0f;
    return Evaluate(g, wi, pdf);
}

INLINE float PDF(PreparedGltf g, vec3 wi) {
    float pdf = 0.0f;
    Evaluate(g, wi, pdf);
    return pdf;
}

// A sample's f such that f |wi.z| / pdf is `estimate`, pdf being PDF.
INLINE BSDFSample WalkedSample(PreparedGltf g, BSDFSample s, vec3 estimate) {
    float single = 0.0f;
    if (!g.isSmooth) GltfFacets(g, s.wi, single);
    s.pdf = GltfWalkPDF(g, s.wi, single);
    if (s.wi.z > 0.0f) s.pdf += g.diffuseChance * CosineHemispherePDF(s.wi.z);
    s.f = estimate * (s.pdf / abs(s.wi.z));
    return s;
}

INLINE BSDFSample SampleGltfWalk(PreparedGltf g, float uc, vec2 u) {
    BSDFSample result = NoSample();
    if (uc < g.diffuseChance) {
        result.wi = SampleCosineHemisphere(u);
        if (!(result.wi.z > 0.0f)) return NoSample();
        result.flags = kBxDFReflection | kBxDFDiffuse;
        return WalkedSample(g, result, GltfDiffuse(g, result.wi) * (kPi / g.diffuseChance));
    }
    float facetChance = g.opaqueChance + g.glassChance;
    vec3 weight = vec3(0.0f);
    WalkSurface surface = ChooseWalk(g, min((uc - g.diffuseChance) / facetChance, 1.0f), weight);
    WalkSample walked = SampleWalk(surface, g.wo, g.bxdf.seed ^ floatBitsToUint(u.x + 1.0f) * 31u);
    if (!(MaxComponent(walked.weight) > 0.0f) || walked.wi.z == 0.0f) return NoSample();
    result.wi = walked.wi;
    result.flags = kBxDFReflection | kBxDFGlossy;
    if (walked.wi.z < 0.0f) {
        result.flags = kBxDFTransmission | kBxDFGlossy;
        result.eta = g.isThin ? 1.0f : g.bxdf.eta;
        weight *= PassedTint(g);
    }
    return WalkedSample(g, result, walked.weight * weight);
}

// Sample_f without f and pdf, which come from Evaluate, unless isEvaluated is set.
INLINE BSDFSample SampleDirection(PreparedGltf g, float uc, vec2 u, OUT(bool) isEvaluated) {
    BSDFSample result = NoSample();
    isEvaluated = true;
    float facetChance = g.opaqueChance + g.glassChance;
    if (!(facetChance + g.diffuseChance > 0.0f)) return result;
    if (IsWalked() && !g.isSmooth) return SampleGltfWalk(g, uc, u);

    if (uc < g.diffuseChance || !(facetChance > 0.0f)) {
        result.wi = SampleCosineHemisphere(u);
        result.flags = kBxDFReflection | (HasDiffuseBase(g) ? kBxDFDiffuse : kBxDFGlossy);
    } else {
        // A facet, and then which way
        vec3 m = g.isSmooth ? vec3(0.0f, 0.0f, 1.0f) : Sample_wm(g.facets, g.wo, u);
        float cosI = dot(g.wo, m);
        vec3 reflectance = vec3(1.0f);
        float reflectChance = 1.0f;
        if (HasGlass(g)) {
            reflectance = GlassReflectance(g, cosI);
            reflectChance = GlassReflectChance(g, reflectance);
        }
        float reflected = g.opaqueChance + g.glassChance * reflectChance;
        uint kind = g.isSmooth ? kBxDFSpecular : kBxDFGlossy;
        if (uc - g.diffuseChance < reflected) {
            result.wi = 2.0f * cosI * m - g.wo;
            if (!(result.wi.z > 0.0f)) return NoSample();
            result.flags = kBxDFReflection | kind;
            result.pdf = reflected;
            result.f = OpaqueReflectance(g, cosI) + g.glassReflect * reflectance;
        } else {
            result.flags = kBxDFTransmission | kind;
            result.pdf = facetChance - reflected;
            result.f = g.glassPass * PassedShare(reflectance);
            if (g.isThin) {
                result.wi = 2.0f * cosI * m - g.wo;
                result.wi.z = -result.wi.z;
            } else {
                if (!Refract(g.wo, m, g.eta, result.wi)) return NoSample();
                result.eta = g.bxdf.eta;
                result.f /= Sqr(g.eta);
            }
            if (!(result.wi.z < 0.0f)) return NoSample();
        }
        if (g.isSmooth) {
            result.f /= abs(result.wi.z);
            return result;
        }
    }
    isEvaluated = false;
    return result;
}

INLINE BSDFSample Sample_f(PreparedGltf g, float uc, vec2 u) {
    bool isEvaluated = false;
    BSDFSample result = SampleDirection(g, uc, u, isEvaluated);
    if (!isEvaluated) result.f = Evaluate(g, result.wi, result.pdf);
    return result;
}

INLINE vec3 f(GltfBxDF lobe, vec3 wo, vec3 wi) { return f(Prepare(lobe, wo), wi); }

INLINE float PDF(GltfBxDF lobe, vec3 wo, vec3 wi) { return PDF(Prepare(lobe, wo), wi); }

INLINE BSDFSample Sample_f(GltfBxDF lobe, vec3 wo, float uc, vec2 u) {
    return Sample_f(Prepare(lobe, wo), uc, u);
}

SHADING_END

#endif
