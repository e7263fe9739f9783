// Compares a run of `raygraph bench` with a stored one by ratios of costs, which are the same on a loaded
// machine as on an idle one. Needs no device.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace raygraph::cli {

// The reference of these ratios, passes::LimitKind::Path. Runs of different versions cannot be compared.
inline constexpr int kLimitPathVersion = 1;

// The cost of a path-traced frame relative to limit_path in the same round, over all rounds.
struct RelativeCost {
    std::string measure;         // "cpu seconds" of the process on a CPU device, else "gpu timestamps"
    double median = 0.0;         // of the rounds' ratios
    double standardError = 0.0;  // of that median, from the median absolute deviation; infinite of one round
};
RelativeCost RelativeCostOf(std::string measure, const std::vector<double>& ratios);
nlohmann::ordered_json ToJson(const RelativeCost& cost);

struct BenchChange {
    std::string what;        // "": of the frames of a render; "viewport ..."
    double now = 0.0;        // median
    double change = 0.0;     // of the median: 0.1 is ten percent slower
    double noise = 0.0;      // two standard errors of the change
    double tolerance = 0.0;  // as asked for
    // Slower by more than the tolerance and by more than the noise.
    bool IsWorse() const { return change > tolerance && change > noise; }
    // The noise exceeds the tolerance.
    bool IsUncertain() const { return !IsWorse() && noise > tolerance; }
};

// Finds the line of the same scene (by file name) among the lines of `stored`, and compares its costs: that
// of frames, and those of viewports where both runs have them. Throws Error{BadInput}, naming `file` and the
// scene, where there is none, where a line is no result of bench, and where version of limit_path, device,
// measure or settings differ.
std::vector<BenchChange> CompareBench(const std::filesystem::path& file, const std::string& stored,
                                      const nlohmann::ordered_json& now, double tolerance);
// "cornell.gltf    3.420 of limit_path: +0.6%, noise 1.0%: not worse"
std::string ToText(const BenchChange& change, const nlohmann::ordered_json& now);

}  // namespace raygraph::cli
