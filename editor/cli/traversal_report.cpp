#include "editor/cli/traversal_report.h"

#include <cstdio>
#include <nlohmann/json.hpp>

namespace raygraph::cli {

namespace {

using Json = nlohmann::ordered_json;

const char* NameOf(passes::RayQuestion question) {
    return question == passes::RayQuestion::Any ? "any" : "nearest";
}

double Mrays(const TraversalTimes& times, double ms) {
    return times.rayCount / (ms * 1e3);
}

}  // namespace

Json ToJson(const TraversalResult& result) {
    Json kinds = Json::array();
    for (const TraversalTimes& times : result.kinds) {
        Json orders;
        const double driver = times.driverMs[static_cast<size_t>(kUsedOrder)];
        for (const BuildOrder order : Values<BuildOrder>())
            orders[Name(order)] = times.driverMs[static_cast<size_t>(order)] / driver;
        const HitDifferences& differences = times.differences;
        kinds.push_back({{"rays", times.rays},
                         {"question", NameOf(times.question)},
                         {"count", times.rayCount},
                         {"hit_share", times.hitShare},
                         {"driver_ms", driver},
                         {"wide_ms", times.wideMs},
                         {"one_level_ms", times.oneLevelMs > 0.0 ? Json(times.oneLevelMs) : Json()},
                         {"ratio", times.Ratio()},
                         {"driver_mrays_per_s", Mrays(times, driver)},
                         {"nodes_per_ray", times.nodesPerRay},
                         {"triangles_per_ray", times.trianglesPerRay},
                         {"instances_per_ray", times.instancesPerRay},
                         {"driver_orders", orders},
                         {"differences",
                          {{"all", differences.all},
                           {"at_edges", differences.atEdges},
                           {"wide_is_wrong", differences.wideIsWrong},
                           {"driver_is_wrong", differences.driverIsWrong},
                           {"unchecked", differences.unchecked}}}});
    }
    Json orderSeconds;
    for (const BuildOrder order : Values<BuildOrder>())
        orderSeconds[Name(order)] = result.orderSeconds[static_cast<size_t>(order)];
    return {{"measure", result.measure},
            {"triangles_unique", result.uniqueTriangles},
            {"triangles_placed", result.placedTriangles},
            {"instances", result.instances},
            {"sah_instances", result.sahOfInstances},
            {"sah_meshes", result.sahOfMeshes},
            {"wide_build_s", result.wideBuildSeconds},
            {"order_s", orderSeconds},
            {"wide_bytes", result.wideBytes},
            {"driver_bytes", result.driverBytes},
            {"kinds", kinds}};
}

void PrintForPeople(const TraversalResult& result) {
    std::fprintf(
        stderr,
        "%llu triangles, %llu placed by %llu instances; SAH cost %.2f of instances, %.2f of meshes; times "
        "are %s\n",
        static_cast<unsigned long long>(result.uniqueTriangles),
        static_cast<unsigned long long>(result.placedTriangles),
        static_cast<unsigned long long>(result.instances), result.sahOfInstances, result.sahOfMeshes,
        result.measure.c_str());
    std::fprintf(
        stderr,
        "  rays            driver ms   Mrays/s  wide ms  1 level ms  ratio  nodes  triangles  instances  "
        "differ");
    for (const BuildOrder order : Values<BuildOrder>()) std::fprintf(stderr, "  %7s", Name(order));
    std::fprintf(stderr, "\n");
    for (const TraversalTimes& times : result.kinds) {
        const double driver = times.driverMs[static_cast<size_t>(kUsedOrder)];
        std::fprintf(stderr, "  %-7s %-7s %9.3f %9.1f %8.3f  %10.3f  %5.2f  %5.1f  %9.1f  %9.2f  %6u",
                     times.rays.c_str(), NameOf(times.question), driver, Mrays(times, driver), times.wideMs,
                     times.oneLevelMs, times.Ratio(), times.nodesPerRay, times.trianglesPerRay,
                     times.instancesPerRay, times.differences.all);
        for (const double ms : times.driverMs) std::fprintf(stderr, "  %7.3f", ms / driver);
        const uint32_t wrong = times.differences.wideIsWrong;
        std::fprintf(stderr, "%s\n", wrong > 0 ? "  the wide trees are WRONG" : "");
    }
}

}  // namespace raygraph::cli
