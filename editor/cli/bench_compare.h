// Compares a run of `raygraph bench` with a stored one by ratios of costs, which are the same on a loaded
// machine as on an idle one. It needs no device.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace raygraph::cli {

// The ratios refer to this version of passes::LimitKind::Path. Runs of different versions cannot be compared.
inline constexpr int kLimitPathVersion = 1;

// Holds the cost of a path-traced frame relative to limit_path in the same round, over all rounds.
struct RelativeCost {
    std::string measure;  // "cpu seconds" of the process on a CPU device, else "gpu timestamps"
    double median = 0.0;  // median of the rounds' ratios
    // The error of the median, by the median absolute deviation; infinite for one round.
    double standardError = 0.0;
};
RelativeCost RelativeCostOf(std::string measure, const std::vector<double>& ratios);
nlohmann::ordered_json ToJson(const RelativeCost& cost);

struct BenchChange {
    std::string what;        // "": frames of a render; "viewport ..."
    double now = 0.0;        // median
    double change = 0.0;     // relative change of the median: 0.1 is ten percent slower
    double noise = 0.0;      // two standard errors of the change
    double tolerance = 0.0;  // the requested tolerance
    // Returns whether it is slower by more than the tolerance and by more than the noise.
    bool IsWorse() const { return change > tolerance && change > noise; }
    // Returns whether the noise exceeds the tolerance.
    bool IsUncertain() const { return !IsWorse() && noise > tolerance; }
};

// Finds the line of the same scene (by file name) among the lines of `stored`, and compares its costs: of
// frames, and of viewports if both runs have them. Throws Error{BadInput} that names `file` and the scene if
// there is none, if a line is no result of bench, or if version of limit_path, device, measure or settings
// differ.
std::vector<BenchChange> CompareBench(const std::filesystem::path& file, const std::string& stored,
                                      const nlohmann::ordered_json& now, double tolerance);
// Returns e.g. "cornell.gltf    3.420 of limit_path: +0.6%, noise 1.0%: not worse".
std::string ToText(const BenchChange& change, const nlohmann::ordered_json& now);

}  // namespace raygraph::cli
