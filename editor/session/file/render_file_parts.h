// The names of channels and attributes that the reader and the writer of a render's file share, flaws of a
// render that was not read from a file, and sums. For editor/session/ alone. Threads: pure functions, for any
// thread.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/printable.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/session/file/render_file.h"
#include "editor/session/file/sum_residuals.h"
#include "editor/session/settings/parse.h"
#include "renderer/image/exr.h"

namespace raygraph::session {

// The version counts changes of channels and attributes. Version 1 had no such attribute, and means without
// sums. In 2, scenes had another hash. 3, which can be read, has the words of the sums themselves.
inline constexpr std::string_view kFormat = "4", kWordFormat = "3";

// Settings are stored as the texts of their options: "raygraph.setting.seed" = "1".
inline constexpr const char* kAttributeFormat = "raygraph.format";
inline constexpr const char* kAttributeVersion = "raygraph.version";
inline constexpr const char* kAttributeDevice = "raygraph.device";
inline constexpr const char* kAttributeDriver = "raygraph.driver";
inline constexpr const char* kAttributeScene = "raygraph.scene";
inline constexpr const char* kAttributeSceneHash = "raygraph.sceneHash";
inline constexpr const char* kAttributeEnvironment = "raygraph.environment";
inline constexpr const char* kAttributeEnvironmentHash = "raygraph.environmentHash";
inline constexpr const char* kAttributeSamples = "raygraph.samples";            // decimal: number of samples
inline constexpr const char* kAttributeSampleOffset = "raygraph.sampleOffset";  // decimal: index of the first
inline constexpr const char* kAttributeSampleRanges = "raygraph.sampleRanges";  // e.g. "0-63 128-191"
// The number of samples that were traced twice, decimal.
inline constexpr const char* kAttributeRemovedSamples = "raygraph.removedSamples";
// The number of samples of DenoisingPlanes::firstHalf, decimal.
inline constexpr const char* kAttributeFirstHalfSamples = "raygraph.firstHalfSamples";
// Samples and relative error, e.g. "64 0.021".
inline constexpr const char* kAttributeMeasuredError = "raygraph.measuredError";
inline constexpr const char* kAttributeSumsDigest = "raygraph.sumsDigest";  // hexadecimal: digest of all sums
inline constexpr const char* kAttributeStage = "raygraph.adaptiveStage";    // "128 256": by color
inline constexpr std::string_view kSettingPrefix = "raygraph.setting.";

inline constexpr const char* kRadianceNames[] = {"R", "G", "B", "A"};
inline constexpr const char* kVarianceNames[] = {"variance.R", "variance.G", "variance.B"};
inline constexpr const char* kDenoisedNames[] = {"denoised.R", "denoised.G", "denoised.B"};
inline constexpr const char* kMotionNames[] = {"motion.X", "motion.Y"};

// These are the channels of an AOV that is a mean.
using ChannelNames = std::array<std::string, 3>;
inline ChannelNames ColorChannels(const std::string& name) {
    return {name + ".R", name + ".G", name + ".B"};
}

inline ChannelNames MeanChannels(Aov aov) {
    if (aov == Aov::Normal) return {"N.X", "N.Y", "N.Z"};
    return ColorChannels(Name(aov));
}

// Returns the channels of each plane of the denoiser.
inline auto DenoisingChannels() {
    using Plane = std::pair<ChannelNames, Texels DenoisingPlanes::*>;
    return std::to_array<Plane>({
        {ColorChannels("denoising.albedo"), &DenoisingPlanes::albedo},
        {{"denoising.N.X", "denoising.N.Y", "denoising.N.Z"}, &DenoisingPlanes::normal},
        {ColorChannels("denoising.first_half"), &DenoisingPlanes::firstHalf},
        {ColorChannels("denoising.seen"), &DenoisingPlanes::seen},
        {ColorChannels("denoising.seen_by_all"), &DenoisingPlanes::seenByAll},
        {ColorChannels("denoising.seen_squares"), &DenoisingPlanes::seenSquares},
    });
}

// Returns the channels of the groups of lights in a render with these settings.
inline std::vector<ChannelNames> GroupChannels(const SettingTexts& settings) {
    std::vector<ChannelNames> channels;
    for (const std::string& name : LightGroupNames(SettingsFrom(settings).lightGroups))
        channels.push_back(ColorChannels("light." + name));
    return channels;
}

// Returns the channels of the variance of the light that a bias removed.
inline ChannelNames VarianceChannels(Bias bias) {
    return ColorChannels(std::string(Name(AovOf(bias))) + ".variance");
}

// An adaptive render has these channels (AdaptiveState).
inline constexpr const char* kCountsName = "samples";
inline constexpr const char* kWantedName = "samples.wanted";
inline constexpr std::string_view kVariancePrefix = "samples.variance", kMeanPrefix = "samples.mean";

// Makes "albedo.sum0.R" of "albedo.R", and "sum0.R" of "R".
inline std::string WordChannel(const std::string& channel, const char* what, size_t word) {
    std::string name = channel;
    return name.insert(name.rfind('.') + 1, Text("{}{}.", what, word));
}

template <typename Names>
std::string WordChannel(const Names& names, const SumWord& which) {
    return WordChannel(names[which.channel], which.isSquareSum ? "squares" : "sum", which.word);
}

// Sums of different channels have different digests, so that swapped ones are noticed.
inline uint64_t DigestSeed(std::string_view channel) {
    uint64_t seed = 0;
    for (const char letter : channel) seed = 31 * seed + static_cast<unsigned char>(letter);
    return seed << 32;
}

// Returns the sample counts of an AOV's mean, per pixel or one for all, if those of the radiance are
// `counts`. It does not apply to what biases removed.
inline std::vector<uint32_t> CountsOf(Aov aov, const std::vector<uint32_t>& counts) {
    if (aov != Aov::Albedo && aov != Aov::Normal) return counts;
    return {*std::ranges::min_element(counts)};
}

struct IdChannel {
    const char* name;
    std::vector<uint32_t> RenderFile::*ids;
};
inline constexpr IdChannel kIdChannels[] = {{"id.instance", &RenderFile::instance},
                                            {"id.material", &RenderFile::material}};

// Returns where the file says that its pixels are in the picture; the settings say the same.
inline image::ExrWindow WindowOf(const PictureSettings& settings) {
    const passes::Region part = RenderedPart(settings);
    return {static_cast<int32_t>(part.x), static_cast<int32_t>(part.y), settings.size.width,
            settings.size.height};
}

// `done` is "read" or "written".
inline void LogTransfer(const Log& log, const std::filesystem::path& path, const RenderFile& render,
                        const char* done, const Stopwatch& watch) {
    WriteLog(log, LogLevel::Info, log_category::kScene, "{}: {} of {} pixels {} in {}",
             Printable(path.filename().string()), Counted(SampleCount(render.samples), "sample"),
             ToText(render.size), done, DurationText(watch.Seconds()));
}

// --- Flaws of a render that was not checked by reading a file ---

// Throws SettingError of kind Usage for settings whose texts could not be read back: no option takes their
// values.
void RequireReadable(const PictureSettings& settings);

// Returns the first reason for which its file could not be read back, e.g. "it has no samples"; empty if
// there is none.
std::string FirstFlaw(const RenderFile& render);

// Checks whether the planes of the denoiser belong together.
std::string FlawOfDenoising(const RenderFile& render);

// Checks the sample counts of an adaptive render alone.
std::string FlawOfCounts(const RenderFile& render);

// --- Sums of samples from several devices or files ---

// Adds to `sums`, which may be empty.
void Add(RenderSums& sums, RenderSums&& others);

// Sets all means and variances from the sums; there must be samples.
void TakeMeans(RenderFile& render);

// Returns all sums in an order that depends on the settings alone; those that are not rendered are empty.
std::vector<passes::ExactSums*> AllOf(RenderSums& sums);

}  // namespace raygraph::session
