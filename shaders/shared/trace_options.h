// The options to which a path tracing pipeline can be specialized, in one list (core/trace_options.glsl).
#ifndef RAYGRAPH_SHARED_TRACE_OPTIONS_H
#define RAYGRAPH_SHARED_TRACE_OPTIONS_H

#include "choice.h"

// The model of scattering at surfaces (bxdf/bsdf.glsl).
//   Gltf:      the material as the file says
//   Lambert:   base color as albedo, nothing else
//   Lafortune: modified Phong, base color and roughness mapped onto it
#define RAYGRAPH_BRDF_MODELS(X, Of)                                    \
    X(Of, Gltf, 0, "gltf", "")                                         \
    X(Of, Lambert, 1, "lambert", "base color as albedo, nothing else") \
    X(Of, Lafortune, 2, "lafortune", "modified Phong")

// The MIS weights of light sampling and BSDF sampling.
//   Off: light sampling alone, where it can find the light at all
#define RAYGRAPH_MIS_HEURISTICS(X, Of) \
    X(Of, Balance, 0, "balance", "")   \
    X(Of, Power, 1, "power", "")       \
    X(Of, Off, 2, "off", "")

// Russian roulette: how paths are terminated.
//   Throughput: survival falls with what the path carries
//   Constant:   every bounce survives with one probability
//   Frame:      one depth for all pixels of a sample, drawn by the host; distributed as Constant's
//   Off:        by absorption, escape or the depth limit alone
#define RAYGRAPH_ROULETTES(X, Of)                                 \
    X(Of, Throughput, 0, "throughput", "")                        \
    X(Of, Constant, 1, "constant", "each bounce survives with P") \
    X(Of, Frame, 2, "frame", "one depth a sample, drawn so")      \
    X(Of, Off, 3, "off", "")

// Variants of the integrator's loop for devices: bits of kLoopOptions.
//   OneTrace: one place of the code traces all rays, shadow rays by the shaders of the others, which do the
//             same where neither ThinWalls nor MatchedMedia is set. For devices that compile each place anew
#define RAYGRAPH_LOOP_OPTIONS(X) X(OneTrace, 1)

// Limits of the integrator, for any settings.
//   MaxRays:         of one path: a guard against rooms that cannot be left
//   LightCandidates: directions to lights of which one is chosen. Facets scatter into few directions, so that
//                    few of many directions to a sky are among them
#define RAYGRAPH_TRACE_LIMITS(X) X(MaxRays, 4096u) X(LightCandidates, 4u)

// Word x (0) or y (1) of a feature's two words: one of them has the feature's bit.
#define RAYGRAPH_TRACE_WORD(word, line) (((line) >> 5 & 1) == (word) ? 1u << ((line)&31) : 0u)

#ifdef __cplusplus

namespace raygraph {
RAYGRAPH_CHOICE(BrdfModel, RAYGRAPH_BRDF_MODELS)
RAYGRAPH_CHOICE(MisHeuristic, RAYGRAPH_MIS_HEURISTICS)
RAYGRAPH_CHOICE(Roulette, RAYGRAPH_ROULETTES)

// Describes a set of features (trace_feature_list.h). GLSL's uvec2 has the same operators.
struct TraceFeatures {
    uint32_t x = 0, y = 0;

    constexpr bool Has(TraceFeatures any) const { return ((x & any.x) | (y & any.y)) != 0u; }
    constexpr TraceFeatures operator|(TraceFeatures other) const { return {x | other.x, y | other.y}; }
    constexpr TraceFeatures operator&(TraceFeatures other) const { return {x & other.x, y & other.y}; }
    constexpr TraceFeatures operator~() const { return {~x, ~y}; }
    constexpr TraceFeatures& operator|=(TraceFeatures other) { return *this = *this | other; }
    constexpr bool operator==(const TraceFeatures&) const = default;
};

#define RAYGRAPH_DECLARE_LOOP(name, value)  inline constexpr uint32_t kLoop##name = value;
#define RAYGRAPH_DECLARE_LIMIT(name, value) inline constexpr uint32_t k##name = value;
#define RAYGRAPH_TRACE_FEATURE(name, kind)                                        \
    inline constexpr TraceFeatures kTrace##name{RAYGRAPH_TRACE_WORD(0, __LINE__), \
                                                RAYGRAPH_TRACE_WORD(1, __LINE__)};
#define RAYGRAPH_TRACE_FEATURES_OF(name) inline constexpr TraceFeatures kTrace##name =
#else
#define RAYGRAPH_DECLARE_LOOP(name, value)  const uint kLoop##name = value;
#define RAYGRAPH_DECLARE_LIMIT(name, value) const uint k##name = value;
#define RAYGRAPH_TRACE_FEATURE(name, kind) \
    const uvec2 kTrace##name = uvec2(RAYGRAPH_TRACE_WORD(0, __LINE__), RAYGRAPH_TRACE_WORD(1, __LINE__));
#define RAYGRAPH_TRACE_FEATURES_OF(name) const uvec2 kTrace##name =
#endif

RAYGRAPH_CHOICE_CONSTANTS(Brdf, RAYGRAPH_BRDF_MODELS)
RAYGRAPH_CHOICE_CONSTANTS(Mis, RAYGRAPH_MIS_HEURISTICS)
RAYGRAPH_CHOICE_CONSTANTS(Roulette, RAYGRAPH_ROULETTES)
RAYGRAPH_LOOP_OPTIONS(RAYGRAPH_DECLARE_LOOP)
#undef RAYGRAPH_DECLARE_LOOP
RAYGRAPH_TRACE_LIMITS(RAYGRAPH_DECLARE_LIMIT)
#undef RAYGRAPH_DECLARE_LIMIT
#include "trace_feature_list.h"
#undef RAYGRAPH_TRACE_FEATURE

// The lobes through which light passes to the other side of a surface.
RAYGRAPH_TRACE_FEATURES_OF(Transmission) kTraceGlass | kTraceDiffuseTransmission;
#undef RAYGRAPH_TRACE_FEATURES_OF

#ifdef __cplusplus

enum class TraceFeatureKind : uint32_t { Lights, Textures, Lobes, Media, Hits, Settings };

struct TraceFeatureRow {
    TraceFeatures feature;
    TraceFeatureKind kind;
};
inline constexpr TraceFeatureRow kTraceFeatureRows[] = {
#define RAYGRAPH_TRACE_FEATURE(name, kind) {kTrace##name, TraceFeatureKind::kind},
#include "trace_feature_list.h"
#undef RAYGRAPH_TRACE_FEATURE
};

constexpr TraceFeatures FeaturesOfKind(TraceFeatureKind kind) {
    TraceFeatures features;
    for (const TraceFeatureRow& row : kTraceFeatureRows)
        if (row.kind == kind) features |= row.feature;
    return features;
}

constexpr bool HasDistinctBits() {
    TraceFeatures taken;
    for (const TraceFeatureRow& row : kTraceFeatureRows) {
        if (taken.Has(row.feature)) return false;
        taken |= row.feature;
    }
    return true;
}
static_assert(HasDistinctBits(), "two rows of the list share a line, or there are more than 64");

}  // namespace raygraph
#endif

#endif
