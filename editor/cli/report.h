// The --report of a render, schema 2, and the texts about biases in it and in the summary. Schema 2 counts
// non-finite samples where schema 1 counted pixels (image.nonfinite_pixels). Times are in milliseconds,
// sizes in bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "editor/cli/arguments.h"
#include "editor/session/file/image_statistics.h"
#include "editor/session/file/render_file.h"
#include "editor/session/frames/pass_times.h"
#include "editor/session/settings/bias.h"
#include "editor/session/settings/picture_settings.h"
#include "rhi/device.h"

namespace raygraph::cli {

struct Report {
    struct {
        std::string file;
        uint64_t trianglesUnique = 0, trianglesPlaced = 0, pointsPlaced = 0, segmentsPlaced = 0,
                 instances = 0, materials = 0, textures = 0, lights = 0;
    } scene;
    struct {
        std::string name, driver, type;
    } device;                          // first device, which memory, passes and acceleration describe
    std::vector<std::string> devices;  // names of all devices of this process
    session::SettingTexts settings;    // picture settings and other options
    uint64_t samples = 0;              // samples of the picture; average per pixel if it is adaptive
    struct SamplesOfPixels {
        uint32_t least = 0, most = 0;
    };
    std::optional<SamplesOfPixels> samplesOfPixels;  // set for an adaptive picture
    bool wasStopped = false;
    struct {
        double load = 0.0, upload = 0.0, blasBuild = 0.0, compaction = 0.0, pipelines = 0.0;
        double firstSample = 0.0;  // until the first sample was done, with pipelines and uploads
        double render = 0.0;       // for all samples of this run
    } timingsMs;
    std::vector<session::PassTime> passes;
    struct {
        uint64_t blasCount = 0, bytesBuilt = 0, bytesCompacted = 0, tlasBytes = 0;
        std::string compactionDisabledReason;  // "": compaction was on
    } acceleration;
    struct {
        uint64_t devicePeakBytes = 0, hostPeakBytes = 0;
        uint64_t deviceFallbackBytes = 0;  // allocated in host memory for lack of device memory
        bool isBudgetOfDriver = false;     // false: the budget is an estimate
        std::vector<rhi::MemoryHeap> heaps;
        uint64_t textureBytes = 0, textureBudgetBytes = 0;
        uint32_t reducedTextures = 0;  // reduced in size to fit the budget
    } memory;
    struct {
        std::optional<double> samplesPerSecond;  // without the first sample
        std::optional<double> raysPerSample;
    } throughput;
    session::ImageStatistics image;
    uint64_t nonFiniteSamples = 0;                           // samples of this run; they count as black
    std::map<session::Bias, session::RemovedLight> removed;  // per enabled bias
};

// Returns pretty-printed JSON with a newline at the end. Unknown numbers are null.
std::string ToJson(const Report& report);

// Writes the whole text or nothing. Throws Error{Io}.
void WriteTextFile(const std::filesystem::path& path, std::string_view text);

// Returns the picture settings and the other options that determine the picture.
session::SettingTexts SettingsForReport(const RenderArguments& arguments, const session::RenderFile& render,
                                        const std::optional<uint32_t>& samplesWanted);

// --- Biases as the command line and its summary name them ---

std::string Option(session::Bias bias);  // e.g. "--max-depth"

// Returns e.g. "--max-depth removed 25 % +- 0.3 % of the light".
std::string Describe(session::Bias bias, const session::RemovedLight& removed);

}  // namespace raygraph::cli
