// The --report of a render, schema 2: schema 1 counted pixels, image.nonfinite_pixels, where this one counts
// samples. Times are milliseconds, sizes bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "editor/cli/arguments.h"
#include "editor/session/bias.h"
#include "editor/session/image_statistics.h"
#include "editor/session/pass_times.h"
#include "editor/session/picture_settings.h"
#include "editor/session/render_file.h"
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
    } device;                          // the first; memory, passes and acceleration are of it alone
    std::vector<std::string> devices;  // the names of all, of this process
    session::SettingTexts settings;    // picture settings and what else was asked for
    uint64_t samples = 0;              // in the picture; of an adaptive one a pixel's, on average
    struct SamplesOfPixels {
        uint32_t least = 0, most = 0;
    };
    std::optional<SamplesOfPixels> samplesOfPixels;  // of an adaptive one
    bool wasStopped = false;
    struct {
        double load = 0.0, upload = 0.0, blasBuild = 0.0, compaction = 0.0, pipelines = 0.0;
        double firstSample = 0.0;  // until it was done, pipelines and uploads included
        double render = 0.0;       // all samples of this run
    } timingsMs;
    std::vector<session::PassTime> passes;
    struct {
        uint64_t blasCount = 0, bytesBuilt = 0, bytesCompacted = 0, tlasBytes = 0;
        std::string whyCompactionOff;  // "": it was on
    } acceleration;
    struct {
        uint64_t devicePeakBytes = 0, hostPeakBytes = 0;
        uint64_t deviceFallbackBytes = 0;  // what had to go into the host's memory
        bool isBudgetOfDriver = false;     // else estimated
        std::vector<rhi::MemoryHeap> heaps;
        uint64_t textureBytes = 0, textureBudgetBytes = 0;
        uint32_t reducedTextures = 0;  // smaller than their images, to fit that budget
    } memory;
    struct {
        std::optional<double> samplesPerSecond;  // over the samples after the first
        std::optional<double> raysPerSample;
    } throughput;
    session::ImageStatistics image;
    uint64_t nonFiniteSamples = 0;                           // that this run rendered, and counted as black
    std::map<session::Bias, session::RemovedLight> removed;  // of the biases that are on
};

// Pretty-printed, with a newline at the end. Numbers that are not known are null.
std::string ToJson(const Report& report);

// All of the text or nothing; Error{Io}.
void WriteTextFile(const std::filesystem::path& path, std::string_view text);

// The picture settings and the other options that say what was rendered.
session::SettingTexts SettingsForReport(const RenderArguments& arguments, const session::RenderFile& render,
                                        const std::optional<uint32_t>& samplesWanted);

}  // namespace raygraph::cli
