// The material of glTF 2.0 (appendix B) with KHR_materials_ior, specular, transmission, diffuse_transmission,
// sheen and clearcoat, as lobes:
//     a clear coat over sheen over mix(dielectric, metal, metallic)
//     dielectric = mix(a Fresnel layer over diffuse, glass, transmission)
//     diffuse = mix(reflection, transmission to the other side, diffuseTransmission)
// Metal, layer and glass are GGX facets of one roughness, with a thin film on all of them
// (KHR_materials_iridescence, bxdf/facet_fresnel.glsl). baseColor colors metal, diffuse reflection and the
// light that glass transmits.
#ifndef RAYGRAPH_BXDF_GLTF_LOBES_GLSL
#define RAYGRAPH_BXDF_GLTF_LOBES_GLSL

#include "bxdf/clearcoat.glsl"
#include "bxdf/conductor.glsl"
#include "bxdf/dielectric_layer.glsl"
#include "bxdf/diffuse.glsl"
#include "bxdf/diffuse_transmission.glsl"
#include "bxdf/glass.glsl"
#include "bxdf/retroreflection.glsl"
#include "bxdf/sheen.glsl"

SHADING_BEGIN

// From top to bottom: a lobe is covered by those before it. The struct, its name in GltfBSDF, and
// the trace feature without which no material of the scene has it and all of its code folds away.
#define GLTF_LOBES(X)                                               \
    X(ClearcoatBxDF, coat, kTraceClearcoat)                         \
    X(SheenBxDF, sheen, kTraceSheen)                                \
    X(GlassBxDF, glass, kTraceGlass)                                \
    X(ConductorBxDF, metal, kTraceMetals)                           \
    X(DielectricLayerBxDF, layer, kTraceOpaque)                     \
    X(DiffuseTransmissionBxDF, through, kTraceDiffuseTransmission)  \
    X(DiffuseBxDF, base, kTraceOpaque)

#define RAYGRAPH_DECLARE_LOBE_(Lobe, name, feature) \
    Lobe name;                                      \
    float name##Chance;

// Holds the lobes as seen from one direction, and the probabilities that Sample_f chooses them: they sum to
// 1, or all are 0. A lobe of probability 0 scatters nothing.
struct GltfBSDF {
    FacetView view;
    uint seed;   // seed of the walk
    uint flags;  // flags of all lobes
    GLTF_LOBES(RAYGRAPH_DECLARE_LOBE_)
};
#undef RAYGRAPH_DECLARE_LOBE_

INLINE GltfBSDF Prepare(SurfaceMaterial material, SurfaceSetting setting, vec3 wo) {
    GltfBSDF g;
    g.view = ViewOf(material, setting, wo);
    g.seed = setting.seed;
    g.flags = kBxDFNone;
    material.baseColor = clamp(material.baseColor, vec3(0.0f), vec3(1.0f));
    float share = 1.0f;
    float sum = 0.0f;
#define RAYGRAPH_PLACE_LOBE_(Lobe, name, feature)                \
    g.name##Chance = 0.0f;                                       \
    if (HasTraceFeature(feature)) {                              \
        InitLobe(g.name, material, setting, g.view, share);     \
        g.name##Chance = wo.z > 0.0f ? Weight(g.name, g.view) : 0.0f; \
        sum += g.name##Chance;                                   \
    }
    GLTF_LOBES(RAYGRAPH_PLACE_LOBE_)
#undef RAYGRAPH_PLACE_LOBE_

    float scale = sum > 0.0f ? 1.0f / sum : 0.0f;
#define RAYGRAPH_WEIGH_LOBE_(Lobe, name, feature)                          \
    if (HasTraceFeature(feature) && g.name##Chance > 0.0f) {               \
        g.name##Chance *= scale;                                           \
        g.flags |= Flags(g.name, g.view);                                  \
    }
    GLTF_LOBES(RAYGRAPH_WEIGH_LOBE_)
#undef RAYGRAPH_WEIGH_LOBE_
    return g;
}

SHADING_END

#endif
