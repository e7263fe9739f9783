// Times the driver's tracing against wide trees in a compute shader, on the same rays, and counts where
// their answers differ.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "editor/cli/bench_run.h"
#include "editor/session/scene_input.h"
#include "passes/traversal.h"

namespace raygraph::cli {

struct HitDifferences {
    uint32_t all = 0;
    // Of the first ones, by rays in double precision: they are within rounding of an edge or of another
    // hit; otherwise one side is wrong.
    uint32_t atEdges = 0, wideIsWrong = 0, driverIsWrong = 0, unchecked = 0;
};

// One kind of rays.
struct TraversalTimes {
    std::string rays;
    passes::RayQuestion question = passes::RayQuestion::Nearest;
    uint32_t rayCount = 0;
    double hitShare = 0.0;
    // Milliseconds of one pass over all of them
    std::array<double, Values<BuildOrder>().size()> driverMs{};  // by the order it was built in
    double wideMs = 0.0;                                         // by trees of two levels
    double oneLevelMs = 0.0;  // by a tree of one; 0: there is none, of so many triangles
    double nodesPerRay = 0.0, trianglesPerRay = 0.0, instancesPerRay = 0.0;  // of the wide trees
    HitDifferences differences;

    // Above 1: the trees that renders of still scenes have are faster than the driver, built in the order
    // that GpuScene has.
    double Ratio() const {
        return driverMs[static_cast<size_t>(kUsedOrder)] / (oneLevelMs > 0.0 ? oneLevelMs : wideMs);
    }
};

struct TraversalResult {
    std::string measure;  // as RelativeCost::measure
    uint64_t uniqueTriangles = 0, placedTriangles = 0, instances = 0;
    double sahOfInstances = 0.0, sahOfMeshes = 0.0;
    double wideBuildSeconds = 0.0;
    std::array<double, Values<BuildOrder>().size()> orderSeconds{};
    uint64_t wideBytes = 0, driverBytes = 0;
    std::vector<TraversalTimes> kinds;
};

// `plan` as for RunBench. Error{BadInput} for a scene without triangles.
TraversalResult BenchTraversal(rhi::Device& device, const scene::SceneData& data,
                               const session::PictureSettings& settings, const BenchPlan& plan,
                               Progress& progress);

}  // namespace raygraph::cli
