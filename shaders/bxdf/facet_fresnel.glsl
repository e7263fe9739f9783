// The reflectance of one facet of a material: the curves of bxdf/fresnel.glsl between the reflectances that
// materials give, and by how much a thin film on it changes them (bxdf/thin_film.glsl).
#ifndef RAYGRAPH_BXDF_FACET_FRESNEL_GLSL
#define RAYGRAPH_BXDF_FACET_FRESNEL_GLSL

#include "bxdf/fresnel.glsl"
#include "bxdf/thin_film.glsl"
#include "core/trace_options.glsl"

SHADING_BEGIN

struct FacetFresnel {
    vec3 f0;        // at normal incidence
    vec3 f90;       // where Schlick's curve ends; the energy tables use this one whatever the model
    vec3 exactF90;  // where the exact curve of a dielectric ends
    bool isMetal;
    ThinFilm film;  // film of a dielectric, as from its thinner side; read if kTraceIridescence is set
};

INLINE FacetFresnel BlackFresnel() {
    FacetFresnel fresnel;
    fresnel.f0 = vec3(0.0f);
    fresnel.f90 = vec3(0.0f);
    fresnel.exactF90 = vec3(0.0f);
    fresnel.isMetal = true;
    fresnel.film = NoFilm();
    return fresnel;
}

// Returns the reflectance of a dielectric facet for light at cosI > 0; `cosOutside` is the cosine on its
// thinner side. Exact models have the shape of the exact curve, moved to f0 and exactF90 at its ends; f0 is
// then that of eta times a tint.
INLINE vec3 DielectricCurve(FacetFresnel fresnel, float cosOutside, float cosI, float eta) {
    if (ActiveFresnel() == kFresnelSchlick) return FresnelSchlick(cosOutside, fresnel.f0, fresnel.f90);
    float f0 = DielectricF0(eta);
    float exact = FresnelDielectric(cosI, eta);
    return mix(fresnel.f0, fresnel.exactF90, clamp((exact - f0) / max(1.0f - f0, 1e-6f), 0.0f, 1.0f));
}

INLINE bool HasFilm(ThinFilm film) { return HasTraceFeature(kTraceIridescence) && film.weight > 0.0f; }

// Returns what a film adds to the reflectance of a metal. With --fresnel dielectric there is no absorption
// here, either.
INLINE vec3 MetalFilmGain(ThinFilm film, ConductorFresnel fresnel, float cosI) {
    vec3 k = ActiveFresnel() == kFresnelDielectric ? vec3(0.0f) : fresnel.k;
    return film.weight * FilmGain(film, cosI, fresnel.eta, k);
}

// Returns what a film adds to the reflectance of a dielectric: of exactF90, the share that there is of it,
// and the index that reflects f0.
INLINE vec3 DielectricFilmGain(FacetFresnel fresnel, float cosOutside) {
    vec3 root = min(sqrt(fresnel.f0 / max(fresnel.exactF90, vec3(1e-6f))), vec3(0.9999f));
    vec3 eta = (vec3(1.0f) + root) / (vec3(1.0f) - root);
    return fresnel.film.weight * fresnel.exactF90 * FilmGain(fresnel.film, cosOutside, eta, vec3(0.0f));
}

// Returns a metal's reflectance with its film.
INLINE vec3 ConductorReflectance(ConductorFresnel fresnel, ThinFilm film, float cosI) {
    vec3 bare = ConductorReflectance(fresnel, cosI);
    if (!HasFilm(film)) return bare;
    return clamp(bare + MetalFilmGain(film, fresnel, cosI), vec3(0.0f), vec3(1.0f));
}

// Returns FacetReflectance of a dielectric seen from its thinner side, eta >= 1, where there is no total
// reflection.
INLINE vec3 OutsideReflectance(FacetFresnel fresnel, float cosI, float eta) {
    vec3 bare = DielectricCurve(fresnel, cosI, cosI, eta);
    if (!HasFilm(fresnel.film)) return bare;
    return clamp(bare + DielectricFilmGain(fresnel, cosI), vec3(0.0f), vec3(1.0f));
}

// Returns the share of light that a layer of that reflectance passes to its base: for every channel that of
// the channel which is reflected most. Otherwise a colored layer would give the base the inverse color
// (KHR_materials_specular).
INLINE vec3 LayerTransmittance(vec3 reflectance) { return vec3(1.0f - MaxComponent(reflectance)); }

// Holds the shares of light that a facet reflects and passes.
struct FresnelCoefficients {
    vec3 reflected;
    vec3 passed;
};

INLINE FresnelCoefficients FresnelWithoutFilm(vec3 reflectance) {
    FresnelCoefficients shares;
    shares.reflected = reflectance;
    shares.passed = LayerTransmittance(reflectance);
    return shares;
}

// A film takes from what passes, channel by channel, what it adds to the reflection.
INLINE FresnelCoefficients FresnelWithFilm(vec3 bare, vec3 gain) {
    FresnelCoefficients shares = FresnelWithoutFilm(bare);
    shares.reflected = clamp(bare + gain, vec3(0.0f), vec3(1.0f));
    shares.passed = max(shares.passed + bare - shares.reflected, vec3(0.0f));
    return shares;
}

// Returns the shares of light at cosI > 0 with the facet. eta is n(far side) / n(this side) as seen from
// here, and is not read for metals. Total reflection is 1 whatever f90 and film are.
INLINE FresnelCoefficients EvaluateFresnel(FacetFresnel fresnel, float cosI, float eta) {
    if (fresnel.isMetal) {
        if (ActiveFresnel() == kFresnelSchlick && !HasFilm(fresnel.film))
            return FresnelWithoutFilm(FresnelSchlick(cosI, fresnel.f0, fresnel.f90));
        ConductorFresnel conductor = ConductorFromColor(fresnel.f0, fresnel.f90);
        return FresnelWithoutFilm(ConductorReflectance(conductor, fresnel.film, cosI));
    }
    float c = min(cosI, 1.0f);
    if (eta < 1.0f) {
        c = RefractedCosine(c, eta);
        if (c < 0.0f) return FresnelWithoutFilm(vec3(1.0f));
    }
    vec3 bare = DielectricCurve(fresnel, c, cosI, eta);
    if (!HasFilm(fresnel.film)) return FresnelWithoutFilm(bare);
    return FresnelWithFilm(bare, DielectricFilmGain(fresnel, c));
}

INLINE vec3 FacetReflectance(FacetFresnel fresnel, float cosI, float eta) {
    return EvaluateFresnel(fresnel, cosI, eta).reflected;
}

SHADING_END

#endif
