// Choices: a choice is one of several things under one name, stated once, as a list of lines. This file has
// the macros for such lists, and the choices that C++ and shaders share.
//   #define RAYGRAPH_FRUITS(X, Of) X(Of, Apple, 0, "apple", "") X(Of, PlumTree, 1, "plum-tree", "sour")
// A line has an enumerator, its number (counted from 0), what users call it (options, files, reports, the
// editor), and a note for the help. From the list follow
//   RAYGRAPH_CHOICE(Fruit, RAYGRAPH_FRUITS)
//       C++: enum class Fruit, Texts(Fruit{}), Notes(Fruit{}), Name(Fruit::Apple); Values<Fruit>()
//   RAYGRAPH_CHOICE_CONSTANTS(Fruit, RAYGRAPH_FRUITS)
//       GLSL, and C++ in namespace shading: kFruitApple, an unsigned number
// so that no code over a choice can lack one of its values. Threads: constants.
#ifndef RAYGRAPH_SHARED_CHOICE_H
#define RAYGRAPH_SHARED_CHOICE_H

#ifdef __cplusplus

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

namespace raygraph {

constexpr bool IsCountedFromZero(std::initializer_list<uint32_t> values) {
    uint32_t count = 0;
    for (const uint32_t value : values)
        if (value != count++) return false;
    return true;
}

// Returns all values of a choice, in their order.
template <typename Choice>
constexpr auto Values() {
    std::array<Choice, Texts(Choice{}).size()> values{};
    for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<Choice>(i);
    return values;
}

}  // namespace raygraph

// clang-format off
#define RAYGRAPH_CHOICE_ENUMERATOR_(Of, name, value, text, note) name = value,
#define RAYGRAPH_CHOICE_VALUE_(Of, name, value, text, note) value,
#define RAYGRAPH_CHOICE_TEXT_(Of, name, value, text, note) text,
#define RAYGRAPH_CHOICE_NOTE_(Of, name, value, text, note) note,
#define RAYGRAPH_CHOICE_CONSTANT_(Of, name, value, text, note) inline constexpr uint32_t k##Of##name = value;
// clang-format on

// Texts and Notes are by number; their argument only says of which choice.
#define RAYGRAPH_CHOICE(Enum, LIST)                                                     \
    enum class Enum : uint32_t { LIST(RAYGRAPH_CHOICE_ENUMERATOR_, Enum) };             \
    static_assert(::raygraph::IsCountedFromZero({LIST(RAYGRAPH_CHOICE_VALUE_, Enum)})); \
    constexpr auto Texts(Enum) {                                                        \
        return std::to_array<const char*>({LIST(RAYGRAPH_CHOICE_TEXT_, Enum)});         \
    }                                                                                   \
    constexpr auto Notes(Enum) {                                                        \
        return std::to_array<const char*>({LIST(RAYGRAPH_CHOICE_NOTE_, Enum)});         \
    }                                                                                   \
    constexpr const char* Name(Enum value) {                                            \
        return Texts(value)[static_cast<size_t>(value)];                                \
    }

#define RAYGRAPH_CHOICE_CONSTANTS(Of, LIST) \
    namespace shading {                     \
    LIST(RAYGRAPH_CHOICE_CONSTANT_, Of)     \
    }

#else

#define RAYGRAPH_CHOICE_CONSTANT_(Of, name, value, text, note) const uint k##Of##name = value;
#define RAYGRAPH_CHOICE_CONSTANTS(Of, LIST)                    LIST(RAYGRAPH_CHOICE_CONSTANT_, Of)

#endif

// --- The meanings of a material's alpha (glTF 2.0, 3.9.4) ---
//   Opaque: nothing
//   Mask:   where it is below the cutoff there is a hole
//   Blend:  the share of rays that the surface stops
// The notes are glTF's names.
#define RAYGRAPH_ALPHA_MODES(X, Of)      \
    X(Of, Opaque, 0, "opaque", "OPAQUE") \
    X(Of, Mask, 1, "mask", "MASK")       \
    X(Of, Blend, 2, "blend", "BLEND")

// --- The ways of choosing a light (lights/lights.glsl) ---
//   Uniform: every light with power above 0 alike
//   Power:   by power
//   Bvh:     by what each may contribute to the point that is lit, through a tree over position and
//            orientation
#define RAYGRAPH_LIGHT_SAMPLERS(X, Of) \
    X(Of, Uniform, 0, "uniform", "")   \
    X(Of, Power, 1, "power", "")       \
    X(Of, Bvh, 2, "bvh", "by its possible contribution")

// --- The models that make up a microfacet lobe (bxdf/microfacet.glsl, bxdf/fresnel.glsl) ---
#define RAYGRAPH_MICROFACET_DISTRIBUTIONS(X, Of) \
    X(Of, Ggx, 0, "ggx", "")                     \
    X(Of, Beckmann, 1, "beckmann", "")           \
    X(Of, Phong, 2, "phong", "")

// Masking and shadowing of microfacets.
//   Correlated: Smith's, by one height for both directions
//   Separable:  Smith's, each direction by itself
//   Shortcut:   Kelemen and Szirmay-Kalos, 1 / (L.H)^2 for all of G / (cos cos)
#define RAYGRAPH_MASKING_MODELS(X, Of)          \
    X(Of, Correlated, 0, "correlated", "Smith") \
    X(Of, Separable, 1, "separable", "")        \
    X(Of, Shortcut, 2, "shortcut", "")

#define RAYGRAPH_FRESNEL_MODELS(X, Of)     \
    X(Of, Schlick, 0, "schlick", "")       \
    X(Of, Dielectric, 1, "dielectric", "") \
    X(Of, Conductor, 2, "conductor", "")   \
    X(Of, Lazanyi, 3, "lazanyi", "")

// --- Treatment of multiple scattering between the facets of a rough surface ---
//   Off:  it is lost
//   Lut:  single scattering, scaled up by tables to what the walk returns
//   Walk: a random walk among the facets, the reference from which the tables are computed
#define RAYGRAPH_MULTISCATTER_KINDS(X, Of)        \
    X(Of, Off, 0, "off", "lost")                  \
    X(Of, Lut, 1, "lut", "compensated by tables") \
    X(Of, Walk, 2, "walk", "simulated")

// --- The samplers of core/rng.glsl ---
#define RAYGRAPH_SAMPLER_KINDS(X, Of)          \
    X(Of, Sobol, 0, "sobol", "Owen-scrambled") \
    X(Of, Pcg, 1, "pcg", "")                   \
    X(Of, Tea, 2, "tea", "")

// --- The operators of core/tonemap.glsl ---
#define RAYGRAPH_TONEMAP_OPERATORS(X, Of) \
    X(Of, Linear, 0, "linear", "")        \
    X(Of, Srgb, 1, "srgb", "")            \
    X(Of, Reinhard, 2, "reinhard", "")    \
    X(Of, Aces, 3, "aces", "")            \
    X(Of, AgX, 4, "agx", "")              \
    X(Of, Neutral, 5, "neutral", "")

// --- The views of a scene ---
// To add a view, add a line to the list: the command line, the passes of passes/views.h and their tests take
// it from here.
//   C++:  raygraph::passes::View::Normals, passes::Name(View::RayCost) == "ray-cost"
//   GLSL: kViewNormals

// PathTraced, Raster: light, as radiance. The others are values that PaintView maps to colors:
//   Albedo:     base color
//   Normals:    shading normal, world space
//   Roughness:  perceptual
//   Metallic
//   Emissive:   radiance that the surface emits
//   Depth:      distance along the camera's forward, meters
//   Instance, Material: the scene's indices; exact below 2^24
//   Wireframe:  x: how much of the pixel an edge covers,
//               y: cosine between the normal and the way to the camera
//   Overdraw:   surfaces drawn in the pixel, hidden ones included
//   RayCost:    rays that the pixel's path took, shadow rays included
//   PathLength: bounces of that path
// clang-format off
#define RAYGRAPH_VIEWS(X, Of)                                  \
    X(Of, PathTraced, 0, "path-traced", "")                    \
    X(Of, Raster, 1, "raster", "drawn and lit directly")       \
    X(Of, Albedo, 2, "albedo", "")                             \
    X(Of, Normals, 3, "normals", "")                           \
    X(Of, Roughness, 4, "roughness", "")                       \
    X(Of, Metallic, 5, "metallic", "")                         \
    X(Of, Emissive, 6, "emissive", "")                         \
    X(Of, Depth, 7, "depth", "")                               \
    X(Of, Instance, 8, "instance", "")                         \
    X(Of, Material, 9, "material", "")                         \
    X(Of, Wireframe, 10, "wireframe", "")                      \
    X(Of, Overdraw, 11, "overdraw", "")                        \
    X(Of, RayCost, 12, "ray-cost", "")                         \
    X(Of, PathLength, 13, "path-length", "")
// clang-format on

// --- The choices in C++ and in GLSL ---

#ifdef __cplusplus
namespace raygraph::scene {
RAYGRAPH_CHOICE(AlphaMode, RAYGRAPH_ALPHA_MODES)
}  // namespace raygraph::scene
namespace raygraph::passes {
RAYGRAPH_CHOICE(View, RAYGRAPH_VIEWS)
}  // namespace raygraph::passes

namespace raygraph {
RAYGRAPH_CHOICE(LightSampler, RAYGRAPH_LIGHT_SAMPLERS)
RAYGRAPH_CHOICE(MicrofacetModel, RAYGRAPH_MICROFACET_DISTRIBUTIONS)
RAYGRAPH_CHOICE(MaskingModel, RAYGRAPH_MASKING_MODELS)
RAYGRAPH_CHOICE(FresnelModel, RAYGRAPH_FRESNEL_MODELS)
RAYGRAPH_CHOICE(MultiscatterKind, RAYGRAPH_MULTISCATTER_KINDS)
RAYGRAPH_CHOICE(SamplerKind, RAYGRAPH_SAMPLER_KINDS)
RAYGRAPH_CHOICE(TonemapOperator, RAYGRAPH_TONEMAP_OPERATORS)

// Below this alpha (roughness^2) a surface counts as smooth, and its lobe is a delta.
inline constexpr float kSmoothAlpha = 1e-3f;
#else
const float kSmoothAlpha = 1e-3f;

RAYGRAPH_CHOICE_CONSTANTS(View, RAYGRAPH_VIEWS)
#endif

RAYGRAPH_CHOICE_CONSTANTS(Alpha, RAYGRAPH_ALPHA_MODES)
RAYGRAPH_CHOICE_CONSTANTS(LightSampler, RAYGRAPH_LIGHT_SAMPLERS)
RAYGRAPH_CHOICE_CONSTANTS(Distribution, RAYGRAPH_MICROFACET_DISTRIBUTIONS)
RAYGRAPH_CHOICE_CONSTANTS(Masking, RAYGRAPH_MASKING_MODELS)
RAYGRAPH_CHOICE_CONSTANTS(Fresnel, RAYGRAPH_FRESNEL_MODELS)
RAYGRAPH_CHOICE_CONSTANTS(MultiscatterKind, RAYGRAPH_MULTISCATTER_KINDS)
RAYGRAPH_CHOICE_CONSTANTS(SamplerKind, RAYGRAPH_SAMPLER_KINDS)
RAYGRAPH_CHOICE_CONSTANTS(Tonemap, RAYGRAPH_TONEMAP_OPERATORS)

#ifdef __cplusplus
}  // namespace raygraph
#endif

#endif
