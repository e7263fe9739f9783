// Trace: one path-traced sample per pixel of the scene's radiance; its settings, and those of frames.
// Threads: passes: that of the Renderer; settings: plain values and pure functions, for any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "passes/pixel_list.h"
#include "passes/tiles.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/renderer.h"
#include "renderer/scene/model/camera_view.h"
#include "shaders/shared/choice.h"
#include "shaders/shared/trace_options.h"

namespace raygraph::gpu {
struct PathVertexRecord;  // shaders/shared/path_record.h
}

namespace raygraph::passes {

inline constexpr uint32_t kNoDepthLimit = 0xFFFFFFFFu;

// Holds options of the scattering at surfaces. The defaults are glTF's material with multiple-scattering
// compensation.
struct ScatteringSettings {
    BrdfModel brdf = BrdfModel::Gltf;
    MicrofacetModel distribution = MicrofacetModel::Ggx;
    MaskingModel masking = MaskingModel::Correlated;
    FresnelModel fresnel = FresnelModel::Schlick;
    MultiscatterKind multiscatter = MultiscatterKind::Lut;

    bool operator==(const ScatteringSettings&) const = default;
};

// Holds options of the sampling of lights. Every setting converges to the same picture, except that without
// light sampling punctual lights are missing.
struct LightSamplingSettings {
    bool isOn = true;  // off: BSDF sampling only, without punctual lights
    LightSampler sampler = LightSampler::Bvh;
    MisHeuristic mis = MisHeuristic::Power;

    bool operator==(const LightSamplingSettings&) const = default;
};

struct RouletteSettings {
    Roulette kind = Roulette::Throughput;
    // The first bounce at which Russian roulette may terminate a path. From 2 on, the first bounce is never
    // thinned, which matters on dark surfaces under a sky.
    uint32_t start = 2;
    float survival = 0.8f;  // probability for each bounce, for Constant and Frame; in (0, 1]

    bool operator==(const RouletteSettings&) const = default;
};

// Named biases: each changes the picture for less noise or time, and is off unless asked for.
struct RAYGRAPH_API BiasSettings {
    uint32_t maxDepth = kNoDepthLimit;  // bounces
    // The largest component of a sample's contribution from beyond the first bounce.
    float clampIndirect = std::numeric_limits<float>::infinity();
    float regularize = 0.0f;  // least GGX alpha of surfaces seen after the first bounce
    // Opaque surfaces are shaded as the curved surface of their vertex normals: no edges of triangles in the
    // self-shadow of a smooth body.
    bool shadowTerminator = false;
    // Textures are read at the mip level that fits the path's cone (shaders/core/ray_cone.glsl), plus this;
    // negative: sharper. -infinity: at level 0. Does nothing without kTraceTextureLod in SceneIds::features.
    float textureLod = -std::numeric_limits<float>::infinity();

    bool operator==(const BiasSettings&) const = default;
};

// The form in which the integrator runs on the device. The choice is one of speed: on a device that rounds
// alike in both, such as Mesa's CPU driver, the bits are the same.
//   Auto:      the faster one, by the kind of device alone (DefaultForm)
//   Loop:      an invocation traces and shades one path after the other, each to its end
//   Wavefront: kernels that trace or shade do the same step of all paths
#define RAYGRAPH_INTEGRATOR_FORMS(X, Of) \
    X(Of, Auto, 0, "auto", "")           \
    X(Of, Loop, 1, "loop", "")           \
    X(Of, Wavefront, 2, "wavefront", "")
RAYGRAPH_CHOICE(IntegratorForm, RAYGRAPH_INTEGRATOR_FORMS)

// Returns the form that is faster on a device (docs/performance.md): the loop on a CPU, the wavefront on a
// GPU. It depends neither on scene nor settings, so that all parts of a picture have the bits of the whole.
RAYGRAPH_API IntegratorForm DefaultForm(const rhi::Device& device);

// Holds the options of path tracing: everything that decides the samples of a picture except its camera and
// extent.
struct PathSettings {
    SamplerKind sampler = SamplerKind::Sobol;
    uint32_t seed = 0;
    ScatteringSettings scattering{};
    LightSamplingSettings lights{};
    RouletteSettings roulette{};
    BiasSettings biases{};
    // Where the camera sees no surface and no medium, the radiance is 0: the environment shines on the scene
    // and is seen through it and mirrored in it, but not behind it.
    bool isEnvironmentHidden = false;

    bool operator==(const PathSettings&) const = default;
};

struct TraceSettings : PathSettings {
    Extent2D extent;  // pixels
    // The part of the picture that is rendered, by all passes that trace: their textures have its extent.
    // Empty: all of it. The pixels of a part have the bits that they have in the whole. Passes that draw
    // render whole pictures alone.
    Region region{};
    gpu::CameraRecord camera{};  // in the world, as ToRecord makes it
    uint32_t sampleIndex = 0;
    // Only for Trace: the number of samples of every pixel, those from sampleIndex on. At least 1.
    uint32_t sampleCount = 1;
    // Only for Trace: samples these pixels instead of all, each from its own index + sampleIndex on. The
    // outputs have the extent of the list.
    ListedPixels pixels{};
    // Only for Trace, for measurements: the picture is the same up to rounding. Traversal::Software is
    // ignored if the scene has no trees (GpuSceneDesc::traversal); Auto takes them if it has.
    Traversal traversal = Traversal::Auto;
    IntegratorForm form = IntegratorForm::Auto;

    bool operator==(const TraceSettings&) const = delete;  // would ignore the members of TraceSettings
};

// Parts of the radiance, by the path that the light took: how often it was scattered, and which lobe
// scattered it first on the way from the camera. Emission + Direct + Indirect is the radiance, and so is
// Emission + Diffuse + Specular + Transmission, to rounding.
//   Emission:     not scattered: seen directly
//   Direct:       scattered once
//   Indirect:     scattered more often
//   Diffuse:      reflected first by a diffuse lobe
//   Specular:     reflected first by facets, of any roughness
//   Transmission: let through first
#define RAYGRAPH_PATH_PARTS(X, Of)     \
    X(Of, Emission, 0, "emission", "") \
    X(Of, Direct, 1, "direct", "")     \
    X(Of, Indirect, 2, "indirect", "") \
    X(Of, Diffuse, 3, "diffuse", "")   \
    X(Of, Specular, 4, "specular", "") \
    X(Of, Transmission, 5, "transmission", "")
RAYGRAPH_CHOICE(PathPart, RAYGRAPH_PATH_PARTS)
inline constexpr size_t kPathPartCount = Texts(PathPart{}).size();
using PathPartIds = std::array<TextureId, kPathPartCount>;

// The radiance by group of lights (SceneIds::lightGroupCount of them) lies in one texture: a tile of the
// picture's extent for each, row by row. This many tiles across and down; the last ones may be unused
// and undefined.
RAYGRAPH_API Extent2D LightGroupTiles(uint32_t groupCount);

// Holds the outputs of Trace beside the radiance. Ray counts and the record exclude the others.
struct TraceOutputs {
    bool rayCounts = false;
    bool parts = false;
    bool lightGroups = false;
    // Records what happens at each vertex of the path, of which there must be one (PathCount). The path is
    // that of IntegratorForm::Loop: on a device that rounds alike in all programs, the radiance has the bits
    // that it has without the record.
    bool record = false;
};

// Holds the counters of Trace, as in the buffer TraceIds::counts.
struct TraceCounts {
    uint32_t takenPixels = 0;  // not meaningful afterwards: invocations overrun the number of pixels
    // The number of samples that were infinite or NaN. They are written as black, and count as samples.
    uint32_t nonFiniteSamples = 0;
    std::array<uint32_t, 2> rayWords{};  // the low one first
    // Returns the total over all paths, shadow rays included.
    uint64_t Rays() const { return rayWords[0] + (uint64_t{rayWords[1]} << 32); }
};

// With several samples, a texture stacks them: sample i begins at row i * height. In lightGroups each tile is
// stacked so.
struct TraceIds {
    // rgba32f, linear, finite; alpha 1 where the camera ray hit a surface, 0 where it escaped
    TextureId radiance;
    TextureId rayCounts;    // r32f, rays traced in the pixel, shadow rays included
    TextureId bounces;      // r32f, with rayCounts: bounces of the pixel's path
    PathPartIds parts{};    // rgba32f each, alpha as there
    TextureId lightGroups;  // rgba32f, alpha as there; the groups sum to the radiance, to rounding
    BufferId counts;        // TraceCounts
    BufferId record;        // of the path: PathOf reads it
};

// Returns the vertices of a recorded path, in their order. Waits for the readback of TraceIds::record.
RAYGRAPH_API std::vector<gpu::PathVertexRecord> PathOf(const Readback& record);
// Returns the value of a sample from the vertices of its path: the sum of their contributions, which is what
// the integrator computes, to the bit; 0 if it is not finite, as Trace writes it.
RAYGRAPH_API glm::vec3 ValueOf(std::span<const gpu::PathVertexRecord> path);

// Returns the samples of every pixel: the radiance, and the requested other outputs. A function of only
// (scene, settings): the same device gives the same bits, in one piece or in regions, one sample at a time or
// several. Several at once fill a large device better. Unbiased but for settings.biases. Ray counts of pixels
// are taken by IntegratorForm::Loop; the wavefront traces the same rays. Error{Usage}: ray counts or a
// record together with another output; a record of several paths; a sampleCount of 0; Roulette::Frame, which
// draws one length for all paths of a sample, with several samples or a list of pixels; roulette.survival
// outside (0, 1]; a region outside the picture.
[[nodiscard]] RAYGRAPH_API TraceIds Trace(Renderer& renderer, const SceneIds& scene,
                                          const TraceSettings& settings, TraceOutputs outputs = {});

// Returns how many paths Trace follows: the samples of the pixels.
RAYGRAPH_API uint64_t PathCount(const TraceSettings& settings);

// Returns how many samples of every pixel Trace renders best at once, a power of two up to 64. On a GPU so
// many paths that the wait for the longest of them hardly counts, as far as an eighth of its memory holds
// them; on a CPU one sample of few pixels is enough work. `tileRows`: of the light groups, if they are asked
// for (LightGroupTiles).
RAYGRAPH_API uint32_t PreferredBatchSize(const rhi::Device& device, const TraceSettings& settings,
                                         uint32_t tileRows = 1);

// Returns whether a pass of that name is one of Trace, in any form.
RAYGRAPH_API bool IsTracePass(std::string_view pass);

// Holds the camera's first hits, without light: for AOVs and the diagnostic views. All are from one ray per
// pixel.
struct PrimaryHitIds {
    TextureId albedo;  // rgba32f, base color; the environment's radiance is not in it: 0 on a miss
    TextureId normal;  // rgba32f, shading normal in world space, w = 0; 0 on a miss
    // rgba32f, hit position in world space, w = depth along the camera's forward; inf on a miss
    TextureId position;
    // rgba32ui: instance, material, primitive (in the file's order), geometry; 0xFFFFFFFF on a miss
    TextureId ids;
};

enum class FilmPosition : uint8_t {
    Center,  // through the pixel's center: ids and depth; the same in every sample except for BLEND surfaces
    Jittered,  // the ray of Trace for the same sample: for averages
};

[[nodiscard]] RAYGRAPH_API PrimaryHitIds PrimaryHits(Renderer& renderer, const SceneIds& scene,
                                                     const TraceSettings& settings, FilmPosition film);

// Guides of a denoiser describe what the camera sees by means over samples, rgba32f.
struct GuideIds {
    TextureId albedo, normal;  // as PrimaryHits returns them
    // Radiance that reaches the camera without being scattered: a part of the radiance of Trace, for the same
    // samples, and by further ones where it varies within the pixel; the mean square of the former. Elsewhere
    // they are of few samples. All are 0 from within media, and with more than kMostSeenSamples, which leave
    // little noise in it; then albedo and normal are of few samples everywhere.
    TextureId seen, seenByAll, seenSquares;
};
inline constexpr uint32_t kMostSeenSamples = 1024;

// `settings` have the samples of the picture, from sampleIndex on; `mean` and `variance` are its own, and say
// where a light may be that the first of the samples miss.
[[nodiscard]] RAYGRAPH_API GuideIds TraceGuides(Renderer& renderer, const SceneIds& scene,
                                                const TraceSettings& settings, TextureId mean,
                                                TextureId variance);

// Returns a picture of the scene's surfaces that needs a small program only, for a viewport that has nothing
// better yet: the base colors of what the camera sees, lit from the camera, times `gain`; dark gray where it
// sees no surface. rgba32f of the settings' region. It has no light, no shadow and no refraction; its
// programs depend only on whether the scene has alpha tests and round primitives, and on the sampler.
[[nodiscard]] RAYGRAPH_API TextureId Preview(Renderer& renderer, const SceneIds& scene,
                                             const TraceSettings& settings, float gain = 1.0f);

// --- The options from which a viewport and an offline render make the settings of their frames ---

// Describes a thin lens; radius 0 is a pinhole. Meters. The raster view has none.
struct LensSettings {
    float radius = 0.0f;
    float focusDistance = 1.0f;  // along the view direction to the plane in focus

    bool operator==(const LensSettings&) const = default;
};

// Returns the settings for sample 0 of a whole picture. The aspect ratio is that of the extent, which must
// not be empty, and the camera's own is ignored.
RAYGRAPH_API TraceSettings FrameSettings(Extent2D extent, const scene::CameraView& camera,
                                         const LensSettings& lens, const PathSettings& paths);

}  // namespace raygraph::passes
