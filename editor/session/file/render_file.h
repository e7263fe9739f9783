// RenderFile is the content of a render's .exr, in memory and as a file: the linear picture, the variance and
// AOVs that were accumulated beside it, and everything needed to resume it or to merge it with another.
//
// Channels: R G B A; samples; variance.R/G/B; and as asked for albedo.R/G/B, N.X/Y/Z (world space, mean over
// the samples, so shorter than 1 at edges), the parts of the radiance as emission.R/G/B and so on,
// removed_max_depth.R/G/B and so on with removed_max_depth.variance.R/G/B (of one sample traced twice),
// with --light-group the radiance by group as light.NAME.R/G/B,
// denoising.albedo.R and so on (DenoisingPlanes), Z
// (along the camera's forward; infinite where nothing is hit), id.instance and id.material (uint; 0xFFFFFFFF
// where nothing is hit). Z and the ids are those of the ray through the pixel's center. Attributes: see
// kAttribute* in the source.
//
// A render is resumed with exact sums of the samples (shaders/shared/exact_sums.h), stored as what they are
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
#include "editor/session/file/image_statistics.h"
#include "editor/session/file/sample_ranges.h"
#include "editor/session/frames/adaptive_frames.h"
#include "editor/session/settings/aovs.h"
#include "editor/session/settings/picture_settings.h"
#include "passes/accumulate.h"

namespace raygraph::session {

// Holds RGBA, rows from the top, 4 * width * height floats; it is empty if it was not rendered.
using Texels = std::vector<float>;

// Holds the sums whose means are the pictures of a RenderFile.
struct RenderSums {
    passes::ExactSums radiance;  // with squares if there is a variance
    passes::ExactSums albedo, normal;
    std::array<passes::ExactSums, passes::kPathPartCount> parts;
    std::array<passes::ExactSums, kBiasCount> removed;  // with squares
    std::vector<passes::ExactSums> lightGroups;
};

// Holds what the denoiser takes beside radiance and variance (passes::DenoiseInputs), so that a render is
// denoised from its file. w is not stored. All are empty without Aov::Denoising.
struct DenoisingPlanes {
    Texels albedo, normal;
    Texels firstHalf;                     // mean of the first samples of the radiance; empty with few samples
    uint32_t firstSamples = 0;            // samples of firstHalf
    Texels seen, seenByAll, seenSquares;  // empty if the shutter is open for some time
};

struct RenderFile {
    Extent2D size;    // in pixels, of the rendered part (RenderedPart)
    Texels radiance;  // mean of the samples; alpha: coverage
    Texels variance;  // unbiased variance of one sample; w is undefined
    Texels denoised;  // denoised radiance; written, but not read
    DenoisingPlanes denoising;
    Texels albedo;                                     // w: coverage; not stored
    Texels normal;                                     // w is undefined
    std::array<Texels, passes::kPathPartCount> parts;  // parts of the radiance by PathPart; w is not stored
    // By Bias, these are mean and variance of second trace minus sample; w is not stored.
    std::array<Texels, kBiasCount> removed, removedVariance;
    uint32_t removedSamples = 0;      // samples that were traced twice
    std::vector<Texels> lightGroups;  // indexed by LightGroupNames of the settings; w is not stored
    RenderSums sums;                  // w is stored for the radiance only
    std::vector<float> depth;
    std::vector<uint32_t> instance;
    std::vector<uint32_t> material;
    std::vector<float> motion;  // x and y per pixel: motion in pixels while the shutter is open

    SampleRanges samples;                   // adaptive: as many as the average per pixel, rounded down
    std::optional<AdaptiveState> adaptive;  // set if PictureSettings::isAdaptive
    // Holds the last measurement of a run to a relative error, from which a resumed one continues. Merged
    // renders have none.
    std::optional<MeasuredError> measuredError;
    SettingTexts settings;
    std::string sceneFile;        // file name without folders
    std::string sceneHash;        // hash of the scene's content; "": it had unsaved edits
    std::string environmentFile;  // "": no map
    std::string environmentHash;
    std::string version;  // version of the library
    std::string device;
    std::string driver;
};

// Returns the picture of an AOV that is a mean over samples; nullptr for depth, ids and denoising.
RAYGRAPH_API Texels* MeanOf(RenderFile& render, Aov aov);
RAYGRAPH_API const Texels* MeanOf(const RenderFile& render, Aov aov);

// Returns the sums of an AOV; nullptr for depth, ids and denoising.
RAYGRAPH_API passes::ExactSums* SumsOf(RenderSums& sums, Aov aov);
RAYGRAPH_API const passes::ExactSums* SumsOf(const RenderSums& sums, Aov aov);

// Returns the first missing channel of the sums that all means but `others` need: "albedo.sum0.R"; empty if
// none is missing.
RAYGRAPH_API std::string FirstMissingChannel(const RenderFile& render, const AovSet& others = {});
// A message about such a channel ends with this if there are no sums at all.
inline constexpr const char* kHalfHint = ", as in any file of half floats";
// Returns whether no channel is missing.
RAYGRAPH_API bool HasSums(const RenderFile& render, const AovSet& others = {});

// Returns the AOVs of the render.
RAYGRAPH_API AovSet AovsOf(const RenderFile& render);

// Clears all other AOVs.
RAYGRAPH_API void KeepOnly(RenderFile& render, const AovSet& aovs);

// The numbers of means and variances in a file; depth and ids are kept in full.
//   Half: at most 65504: what is beyond becomes that, and `log` is warned. Without sums: the file can be
//         neither resumed nor merged
#define RAYGRAPH_EXR_TYPES(X, Of) \
    X(Of, Float, 0, "float", "")  \
    X(Of, Half, 1, "half", "no sums: it can be neither resumed nor merged")
RAYGRAPH_CHOICE(ExrType, RAYGRAPH_EXR_TYPES)

// Writes an .exr, which replaces an old file as a whole or not at all. Throws Error{Usage} for a render that
// could not be read back (no samples or no radiance, planes of another size, settings that no option takes),
// and Error{Io}. Messages to `log`, here and below, include the duration.
RAYGRAPH_API void WriteRenderFile(const std::filesystem::path& path, const RenderFile& render,
                                  const Log& log = {}, ExrType type = ExrType::Float);

// Throws Error{BadInput} that names the path for a file that cannot be read, is no EXR, or is no render of
// this program in this format: a channel or an attribute is missing or malformed, or its version is older or
// newer, as with an unknown setting.
RAYGRAPH_API RenderFile ReadRenderFile(const std::filesystem::path& path, const Log& log = {});

// Returns the first reason for which samples of `a` and `b` do not belong in one picture, except for which
// samples they are: "scene: cornell.gltf against box.gltf"; empty if they do.
RAYGRAPH_API std::string FirstMismatch(const RenderFile& a, const RenderFile& b);

}  // namespace raygraph::session
