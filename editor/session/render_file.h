// What the .exr of a render holds, in memory and as a file: the linear picture, the variance and AOVs that
// were accumulated beside it, and everything needed to go on with it or to merge it with another.
//
// Channels: R G B A; samples; variance.R/G/B; and as asked for albedo.R/G/B, N.X/Y/Z (world space, mean over
// the samples, so shorter than 1 at edges), the parts of the radiance as emission.R/G/B and so on,
// removed_max_depth.R/G/B and so on with removed_max_depth.variance.R/G/B (of one sample traced twice),
// with --light-group the radiance by group as light.NAME.R/G/B, Z
// (along the camera's forward; infinite where nothing is hit), id.instance and id.material (uint; 0xFFFFFFFF
// where nothing is hit). Z and the ids are those of the ray through the pixel's center. Attributes: see
// kAttribute* in the source.
//
// What is gone on with are exact sums of the samples (shaders/shared/exact_sums.h), stored as what they are
// beyond mean and variance (sum_residuals.h), one channel (uint) a word, lowest first: sum0.R, squares0.B,
// and with the others albedo.sum0.R, N.sum0.X, light.NAME.sum0.R, removed_max_depth.squares0.R and so on;
// words above the first that are 0 everywhere are left out. A digest of all sums shows that no other program
// has changed channels that they depend on. Older files hold the words of the sums. `samples` tells
// how many samples a pixel's sums are of: as many for all pixels, but of an adaptive render. That goes on
// with samples.wanted (uint), samples.variance32, samples.mean32, 64 and so on (AdaptiveState). Albedo,
// normals and what biases removed are of as many samples as all pixels have.
//
// Threads: plain values and functions of files, for any thread.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/api.h"
#include "base/log.h"
#include "editor/session/adaptive_state.h"
#include "editor/session/aovs.h"
#include "editor/session/image_statistics.h"
#include "editor/session/picture_settings.h"
#include "editor/session/sample_ranges.h"
#include "passes/exact_sums.h"

namespace raygraph::session {

// RGBA, rows from the top, 4 * width * height floats; empty when it was not rendered.
using Texels = std::vector<float>;

// Of what the pictures of a RenderFile are the means.
struct RenderSums {
    passes::ExactSums radiance;  // with squares where there is a variance
    passes::ExactSums albedo, normal;
    std::array<passes::ExactSums, passes::kPathPartCount> parts;
    std::array<passes::ExactSums, kBiasCount> removed;  // with squares
    std::vector<passes::ExactSums> lightGroups;
};

struct RenderFile {
    Extent2D size;    // pixels of the planes: those of the part that is rendered, RenderedPart
    Texels radiance;  // mean of the samples; alpha: part of the pixel that is covered
    Texels variance;  // unbiased variance of one sample, w without meaning
    Texels albedo;    // w: covered part of the pixel; not stored
    Texels normal;    // w without meaning
    std::array<Texels, passes::kPathPartCount> parts;  // of the radiance, by PathPart; w is not stored
    // By Bias: what second traces had more than their samples, mean and variance; w is not stored.
    std::array<Texels, kBiasCount> removed, removedVariance;
    uint32_t removedSamples = 0;      // that were traced twice
    std::vector<Texels> lightGroups;  // by LightGroupNames of its settings; w is not stored
    RenderSums sums;                  // w stored of the radiance alone
    std::vector<float> depth;
    std::vector<uint32_t> instance;
    std::vector<uint32_t> material;
    std::vector<float>
        motion;  // x and y of each pixel: from when the shutter opens to when it closes, pixels

    SampleRanges samples;  // of an adaptive render, as many as a pixel has on average, rounded down
    std::optional<AdaptiveState> adaptive;  // of a render of PictureSettings::isAdaptive
    // What a run to a relative error measured last: a resumed one goes on from it. None of merged renders.
    std::optional<MeasuredError> measuredError;
    SettingTexts settings;
    std::string sceneFile;        // file name without folders
    std::string sceneHash;        // of the scene's content; "": it had edits that were not saved
    std::string environmentFile;  // "": no map
    std::string environmentHash;
    std::string version;  // of the library
    std::string device;
    std::string driver;
};

// The picture of an AOV that is a mean over samples; nullptr for the others: depth and ids.
RAYGRAPH_API Texels* MeanOf(RenderFile& render, Aov aov);
RAYGRAPH_API const Texels* MeanOf(const RenderFile& render, Aov aov);

// Its sums; nullptr likewise.
RAYGRAPH_API passes::ExactSums* SumsOf(RenderSums& sums, Aov aov);
RAYGRAPH_API const passes::ExactSums* SumsOf(const RenderSums& sums, Aov aov);

// Of the sums that all means but `others` need, the first channel that is not there: "albedo.sum0.R"; empty:
// they are there.
RAYGRAPH_API std::string FirstMissingChannel(const RenderFile& render, const AovSet& others = {});
// Behind it, where there are none at all.
inline constexpr const char* kHalfHint = ", as in any file of half floats";
// Whether they are there.
RAYGRAPH_API bool HasSums(const RenderFile& render, const AovSet& others = {});

// The AOVs that it has.
RAYGRAPH_API AovSet AovsOf(const RenderFile& render);

// Empties the other AOVs.
RAYGRAPH_API void KeepOnly(RenderFile& render, const AovSet& aovs);

// The numbers of means and variances in a file; depth and ids are kept in full.
//   Half: at most 65504: what is beyond becomes that, and `log` is warned. Without sums: the file can be
//         neither resumed nor merged
#define RAYGRAPH_EXR_TYPES(X, Of) \
    X(Of, Float, 0, "float", "")  \
    X(Of, Half, 1, "half", "no sums: it can be neither resumed nor merged")
RAYGRAPH_CHOICE(ExrType, RAYGRAPH_EXR_TYPES)

// An .exr, replaced as a whole or not at all. Error{Usage} for a render that could not be read back: without
// samples or radiance, with planes of another size, with settings that no option takes. Error{Io}.
// `log` is told how long it took, here and below.
RAYGRAPH_API void WriteRenderFile(const std::filesystem::path& path, const RenderFile& render,
                                  const Log& log = {}, ExrType type = ExrType::Float);

// Error{BadInput} naming the path: for a file that cannot be read, is no EXR, or is no render of this program
// in this format (a channel or an attribute is missing or malformed, or it is of an older or newer version,
// as one with a setting that is not known here).
RAYGRAPH_API RenderFile ReadRenderFile(const std::filesystem::path& path, const Log& log = {});

// "scene: cornell.gltf against box.gltf": the first thing for which samples of `a` and `b` do not belong in
// one picture, apart from which samples they are; empty when they do belong together.
RAYGRAPH_API std::string FirstMismatch(const RenderFile& a, const RenderFile& b);

}  // namespace raygraph::session
