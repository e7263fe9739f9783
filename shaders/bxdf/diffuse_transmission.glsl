// The lobe of diffuse transmission (KHR_materials_diffuse_transmission): Lambert's, on the side of the
// surface that wo is not on. It takes its share of the light that would reach the diffuse base.
//
// The layers above (dielectric, sheen, clear coat) are on both sides of a sheet, and light from either side
// passes them by the same factor: the sum is reciprocal, and a white sheet returns and passes all light.
//
// At the boundary of a medium radiance is not scaled by the index of refraction, and the sample's eta is 1:
// equal radiance all around remains equal radiance inside. The extension leaves the index to the layer.
#ifndef RAYGRAPH_BXDF_DIFFUSE_TRANSMISSION_GLSL
#define RAYGRAPH_BXDF_DIFFUSE_TRANSMISSION_GLSL

#include "bxdf/lobe.glsl"

SHADING_BEGIN

struct DiffuseTransmissionBxDF {
    vec3 albedo;  // the share of light that is transmitted, in [0, 1]
};

INLINE void PlaceLobe(OUT(DiffuseTransmissionBxDF) lobe, SurfaceMaterial material, SurfaceSetting, FacetView,
                      INOUT(float) share) {
    lobe.albedo = share * material.diffuseTransmission *
                  clamp(material.diffuseTransmissionColor, vec3(0.0f), vec3(1.0f));
    share *= 1.0f - material.diffuseTransmission;
}

INLINE bool IsDiffuse(DiffuseTransmissionBxDF) { return true; }

INLINE uint Flags(DiffuseTransmissionBxDF, FacetView) { return kBxDFTransmission | kBxDFDiffuse; }

INLINE vec3 Evaluate(DiffuseTransmissionBxDF lobe, FacetView, FacetPair pair, OUT(float) pdf) {
    pdf = 0.0f;
    if (pair.isDelta || !(pair.wi.z < 0.0f)) return vec3(0.0f);
    pdf = CosineHemispherePDF(-pair.wi.z);
    return lobe.albedo * kInvPi;
}

INLINE bool DrawsCosine(DiffuseTransmissionBxDF, float) { return true; }

INLINE BSDFSample SampleDirection(DiffuseTransmissionBxDF, FacetView, vec3 drawn, float, vec2) {
    if (!(drawn.z > 0.0f)) return NoSample();
    return SampledDirection(vec3(drawn.x, drawn.y, -drawn.z), 1.0f, kBxDFTransmission | kBxDFDiffuse);
}

INLINE LobeMean Reflected(DiffuseTransmissionBxDF, FacetView) { return NoMean(); }

INLINE LobeMean Transmitted(DiffuseTransmissionBxDF lobe, FacetView) {
    LobeMean mean = NoMean();
    mean.albedo = lobe.albedo;
    mean.wi = vec3(0.0f, 0.0f, -1.0f);
    mean.isDiffuse = true;
    return mean;
}

INLINE float Weight(DiffuseTransmissionBxDF lobe, FacetView) { return Average(lobe.albedo); }

LOBE_GOES_NOT_STRAIGHT(DiffuseTransmissionBxDF)
LOBE_COVERS_NOTHING(DiffuseTransmissionBxDF)
LOBE_IS_NOT_WALKED(DiffuseTransmissionBxDF)
LOBE_WORDS(DiffuseTransmissionBxDF)

SHADING_END

#endif
