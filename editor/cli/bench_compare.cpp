#include "editor/cli/bench_compare.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/median.h"
#include "base/text.h"
#include "editor/session/settings/picture_settings.h"

namespace raygraph::cli {

namespace {

using Json = nlohmann::ordered_json;

[[noreturn]] void Reject(const std::filesystem::path& file, const std::string& scene,
                         const std::string& why) {
    throw MakeError(ErrorKind::BadInput, "{}: {}{}", file, (scene.empty() ? "" : scene + ": "), why);
}

std::string SceneName(const Json& result) {
    return std::filesystem::path(result.at("scene").get<std::string>()).filename().string();
}

Json FindScene(const std::filesystem::path& file, const std::string& stored, const std::string& scene) {
    std::istringstream lines(stored);
    for (std::string line; std::getline(lines, line);) {
        if (line.empty()) continue;
        try {
            Json result = Json::parse(line);
            if (SceneName(result) == scene) return result;
        } catch (const Json::exception&) {
            Reject(file, "", "a line that is no result of raygraph bench");
        }
    }
    Reject(file, scene, "no stored run of this scene");
}

void RequireComparable(const std::filesystem::path& file, const std::string& scene, const std::string& what,
                       const Json& stored, const Json& now) {
    if (stored != now)
        Reject(file, scene, "stored with the " + what + " " + stored.dump() + ", this run has " + now.dump());
}

}  // namespace

RelativeCost RelativeCostOf(std::string measure, const std::vector<double>& ratios) {
    RelativeCost cost{.measure = std::move(measure), .median = Median(ratios), .standardError = 0.0};
    std::vector<double> deviations;
    for (const double ratio : ratios) deviations.push_back(std::abs(ratio - cost.median));
    // For normally distributed ratios, the deviation is 1.4826 times the median absolute one, and the error
    // of a median is sqrt(pi / 2) times that of a mean
    cost.standardError = ratios.size() > 1 ? 1.4826 * Median(std::move(deviations)) * 1.2533 /
                                                 std::sqrt(static_cast<double>(ratios.size()))
                                           : std::numeric_limits<double>::infinity();
    return cost;
}

Json ToJson(const RelativeCost& cost) {
    return {{"limit_path_version", kLimitPathVersion},
            {"measure", cost.measure},
            {"median", cost.median},
            {"standard_error", cost.standardError}};  // infinity becomes null
}

double StandardErrorOf(const Json& cost) {
    const Json& error = cost.at("standard_error");
    return error.is_null() ? std::numeric_limits<double>::infinity() : error.get<double>();
}

std::vector<BenchChange> CompareBench(const std::filesystem::path& file, const std::string& stored,
                                      const Json& now, double tolerance) {
    const std::string scene = SceneName(now);
    const Json before = FindScene(file, stored, scene);
    const auto change = [&](const char* what, const Json& costBefore, const Json& cost) {
        for (const char* key : {"limit_path_version", "measure"})
            RequireComparable(file, scene, key, costBefore.at(key), cost.at(key));
        const double was = costBefore.at("median"), is = cost.at("median");
        if (!(was > 0.0) || !(is > 0.0)) Reject(file, scene, "a cost that is not above 0");
        const double wasError = StandardErrorOf(costBefore), isError = StandardErrorOf(cost);
        return BenchChange{.what = what,
                           .now = is,
                           .change = is / was - 1.0,
                           .noise = 2.0 * is / was * std::hypot(wasError / was, isError / is),
                           .tolerance = tolerance};
    };
    try {
        RequireComparable(file, scene, "device", before.at("device"), now.at("device"));
        // Options that only one of the two programs knows are not compared
        for (const auto& [name, value] : before.at("settings").items())
            if (now.at("settings").contains(name))
                RequireComparable(file, scene, "setting " + name, value, now.at("settings").at(name));
        std::vector<BenchChange> changes{change("", before.at("cost"), now.at("cost"))};
        if (!before.contains("viewport") || !now.contains("viewport")) return changes;
        const Json &viewBefore = before.at("viewport"), &view = now.at("viewport");
        RequireComparable(file, scene, "budget", viewBefore.at("budget_ms"), view.at("budget_ms"));
        for (const auto& [what, key] :
             {std::pair("viewport", "one_a_frame"), std::pair("viewport within budget", "within_budget")})
            changes.push_back(change(what, viewBefore.at(key).at("cost"), view.at(key).at("cost")));
        return changes;
    } catch (const Json::exception&) {
        Reject(file, scene, "stored by a program without costs relative to limit_path");
    }
}

std::string ToText(const BenchChange& change, const Json& now) {
    const char* verdict = change.IsWorse() ? "worse" : change.IsUncertain() ? "uncertain" : "not worse";
    return Text("{:<24} {:8.3f} of limit_path: {:+.1f}%, noise {:.1f}%: {}",
                SceneName(now) + (change.what.empty() ? "" : ", " + change.what), change.now,
                100.0 * change.change, 100.0 * change.noise, verdict);
}

}  // namespace raygraph::cli
