// Random graphs over several frames, checked by an oracle that knows Vulkan and not the planner; and faults
// planted into plans, to see that it finds them.
#include <gtest/gtest.h>

#include <algorithm>

#include "renderer/graph/compile.h"
#include "renderer/graph/memory_plan.h"
#include "renderer/graph/plan_text.h"
#include "tests/graph/oracle.h"
#include "tests/graph/random_frames.h"

namespace raygraph::random_graph_test {
namespace {

using oracle::Oracle;

constexpr uint64_t kSeeds = 400;
constexpr int kFrames = 4;

std::string Lines(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + '\n';
    return text;
}

// Calls `look` with each frame's oracle, before it judges, graph and plan.
template <typename Look>
void ForEachFrame(uint64_t seed, Look&& look, bool hasComputeQueue = false) {
    Oracle oracle;
    RandomFrames frames(seed, oracle, hasComputeQueue);
    for (int f = 0; f < kFrames; ++f) {
        const FrameGraph& graph = frames.Declare();
        const Plan plan = Compile(graph);
        look(oracle, graph, plan);
        ASSERT_EQ(Lines(oracle.Judge(graph, plan)), "") << "seed " << seed << ", frame " << f << '\n'
                                                        << DescribePlan(graph, plan);
        frames.Commit(plan, oracle);
    }
}

TEST(RandomGraph, EveryHazardIsOrderedVisibleAndInTheRightLayout) {
    size_t passes = 0, barriers = 0, shared = 0, transfers = 0, parts = 0;
    for (uint64_t seed = 0; seed < kSeeds && !::testing::Test::HasFailure(); ++seed)
        ForEachFrame(seed, [&](const Oracle&, const FrameGraph& graph, const Plan& plan) {
            passes += plan.passes.size();
            barriers += plan.barriers.size();
            transfers += plan.acquire.count;
            for (const PlannedBarrier& barrier : plan.barriers) {
                shared += barrier.predecessor != kNone ? 1 : 0;
                parts += barrier.part != graph.resources[barrier.resource].Whole() ? 1 : 0;
            }
        });
    // Enough has been checked.
    EXPECT_GT(passes, kSeeds * kFrames * 2);
    EXPECT_GT(barriers, kSeeds * kFrames * 4);
    EXPECT_GT(shared, kSeeds);
    EXPECT_GT(parts, kSeeds * kFrames);
    EXPECT_GT(transfers, kSeeds / 10);
}

TEST(RandomGraph, OnTwoQueuesEveryHazardIsOrderedVisibleAndOwned) {
    size_t batches = 0, waits = 0, transfers = 0;
    for (uint64_t seed = 0; seed < kSeeds && !::testing::Test::HasFailure(); ++seed)
        ForEachFrame(
            seed,
            [&](const Oracle&, const FrameGraph&, const Plan& plan) {
                batches += plan.batches.size();
                for (const PlannedBatch& batch : plan.batches) {
                    waits += batch.waitsFor != kNone ? 1 : 0;
                    transfers += batch.release.count;
                }
            },
            true);
    EXPECT_GT(batches, kSeeds * kFrames * 3);
    EXPECT_GT(waits, kSeeds * kFrames);
    EXPECT_GT(transfers, kSeeds);
}

// How many of the planted faults are found, of how many.
struct Found {
    size_t planted = 0;
    size_t found = 0;
    std::string missed;  // the first one

    void Judge(Oracle oracle, const FrameGraph& graph, const Plan& plan, const std::string& what) {
        ++planted;
        if (!oracle.Judge(graph, plan).empty())
            ++found;
        else if (missed.empty())
            missed = what + '\n' + DescribePlan(graph, plan);
    }
};

bool HasParts(const FrameGraph& graph, uint32_t resource) {
    return graph.resources[resource].SubresourceCount() > 1;
}

// Whether some of its parts take their memory over after the first pass that uses it.
bool TakesMemoryByParts(const Plan& plan, uint32_t resource) {
    const Lifetime& lifetime = plan.lifetimes[resource];
    if (!lifetime.IsUsed() || lifetime.first >= plan.passes.size()) return false;
    const BarrierRange& first = plan.passes[lifetime.first].barriers;
    for (size_t b = first.first + first.count; b < plan.barriers.size(); ++b)
        if (plan.barriers[b].resource == resource &&
            (plan.barriers[b].predecessor != kNone || plan.barriers[b].followsLastFrame))
            return true;
    return false;
}

// Barriers that may be one too many: the graph does not know that semaphores have made all visible, hands
// back to its owner what no pass has touched, keeps one state for all parts of an import, hands over the
// memory of one part with a barrier that the others have too, and does not know which bytes a part has.
bool IsPrecaution(const FrameGraph& graph, const Plan& plan, const PlannedBarrier& barrier) {
    if (graph.resources[barrier.resource].origin != Origin::Imported) {
        const bool isAfterParts = barrier.predecessor != kNone && HasParts(graph, barrier.predecessor);
        return barrier.dependency.oldLayout == barrier.dependency.newLayout &&
               (isAfterParts || TakesMemoryByParts(plan, barrier.resource));
    }
    return graph.waitStages != 0 || !plan.lifetimes[barrier.resource].IsUsed() ||
           (HasParts(graph, barrier.resource) &&
            barrier.dependency.oldLayout == barrier.dependency.newLayout);
}

bool WritesIt(const FrameGraph& graph, const GraphPass& pass, uint32_t resource, const Subresources& part) {
    const auto begin = graph.uses.begin() + pass.firstUse;
    return std::any_of(begin, begin + pass.useCount, [&](const ResourceUse& use) {
        return use.resource == resource && use.versionOut != use.versionIn && rhi::Overlap(use.part, part);
    });
}

// Whether anything has ever been written that an access behind the barrier could miss.
bool HasSomethingToSee(const FrameGraph& graph, const Plan& plan, size_t position,
                       const PlannedBarrier& barrier) {
    const Dependency& dependency = barrier.dependency;
    if (dependency.oldLayout != dependency.newLayout) return true;
    // Subresources with one barrier have one state.
    const GraphResource& resource = graph.resources[barrier.resource];
    const uint32_t place = barrier.part.layer * resource.levels + barrier.part.level;
    const ResourceState& before = place == 0 || !resource.hasOtherStates
                                      ? resource.state
                                      : graph.otherStates[resource.firstOther + place - 1];
    if (before.writeStages != VK_PIPELINE_STAGE_2_NONE) return true;
    return std::any_of(plan.passes.begin(), plan.passes.begin() + static_cast<ptrdiff_t>(position),
                       [&](const PlannedPass& planned) {
                           return WritesIt(graph, graph.passes[planned.pass], barrier.resource, barrier.part);
                       });
}

// Whether the barrier is for an owner that uses the resource after the frame: the next frame shows what is wrong.
bool IsForTheOwner(const FrameGraph& graph, const Plan& plan, size_t position,
                   const PlannedBarrier& barrier) {
    return position == plan.passes.size() && HasParts(graph, barrier.resource) &&
           std::none_of(graph.roots.begin(), graph.roots.end(),
                        [&](const Root& root) { return root.resource == barrier.resource; });
}

// Whether a write of this frame is made available by this barrier, before the pass at `position`, and by no
// barrier before it.
bool IsFirstAfterAWrite(const FrameGraph& graph, const Plan& plan, size_t position,
                        const PlannedBarrier& barrier) {
    const bool isHandOver = barrier.predecessor != kNone;
    const uint32_t r = isHandOver ? barrier.predecessor : barrier.resource;
    // Which bytes of another resource a subresource has is not known here.
    if (isHandOver && (HasParts(graph, r) || HasParts(graph, barrier.resource))) return false;
    const Subresources part = isHandOver ? graph.resources[r].Whole() : barrier.part;
    while (position-- > 0) {
        const PlannedPass& planned = plan.passes[position];
        if (WritesIt(graph, graph.passes[planned.pass], r, part)) return true;
        for (uint32_t b = planned.barriers.first; b < planned.barriers.first + planned.barriers.count; ++b)
            if (plan.barriers[b].resource == r && rhi::Overlap(plan.barriers[b].part, part)) return false;
    }
    return false;
}

// The range that a barrier is in: a pass's position, or that of the end.
template <typename Look>
void ForEachBarrier(const Plan& plan, Look&& look) {
    const auto range = [&](size_t position, const BarrierRange& barriers) {
        for (uint32_t b = barriers.first; b < barriers.first + barriers.count; ++b) look(position, b);
    };
    for (size_t position = 0; position < plan.passes.size(); ++position)
        range(position, plan.passes[position].barriers);
    range(plan.passes.size(), plan.finish);
}

TEST(RandomGraph, DroppedBarrierIsFound) {
    Found drops;
    for (uint64_t seed = 0; seed < kSeeds / 8; ++seed)
        ForEachFrame(seed, [&](const Oracle& oracle, const FrameGraph& graph, const Plan& plan) {
            for (size_t b = 0; b < plan.barriers.size(); ++b) {
                if (IsPrecaution(graph, plan, plan.barriers[b])) continue;
                Plan fault = plan;
                // Its place in the batch stays, and does nothing.
                fault.barriers[b].dependency = {.oldLayout = plan.barriers[b].dependency.oldLayout,
                                                .newLayout = plan.barriers[b].dependency.oldLayout};
                fault.barriers[b].srcQueueFamily = fault.barriers[b].dstQueueFamily = VK_QUEUE_FAMILY_IGNORED;
                drops.Judge(oracle, graph, fault,
                            "seed " + std::to_string(seed) + ": " + BarrierText(graph, plan.barriers[b]));
            }
        });
    EXPECT_GT(drops.planted, 1000u);
    EXPECT_EQ(drops.found, drops.planted) << drops.missed;
}

TEST(RandomGraph, DroppedWaitOfAQueueIsFound) {
    Found waits, releases;
    for (uint64_t seed = 0; seed < kSeeds / 4; ++seed)
        ForEachFrame(
            seed,
            [&](const Oracle& oracle, const FrameGraph& graph, const Plan& plan) {
                for (size_t b = 0; b < plan.batches.size(); ++b) {
                    const PlannedBatch& batch = plan.batches[b];
                    const std::string what =
                        "seed " + std::to_string(seed) + ", batch " + std::to_string(b + 1);
                    // The first wait of the compute queue is a precaution where no frame was before, and the
                    // last of the main queue where nobody reads what it waits for.
                    if (batch.waitsFor != kNone && batch.waitsFor != 0 && batch.passCount > 0) {
                        Plan fault = plan;
                        fault.batches[b].waitsFor = kNone;
                        waits.Judge(oracle, graph, fault, what);
                    }
                    if (batch.release.count > 0) {
                        Plan fault = plan;
                        fault.batches[b].release.count = 0;
                        releases.Judge(oracle, graph, fault, what);
                    }
                }
            },
            true);
    EXPECT_GT(waits.planted, 200u);
    EXPECT_GT(releases.planted, 100u);
    EXPECT_EQ(waits.found, waits.planted) << waits.missed;
    EXPECT_EQ(releases.found, releases.planted) << releases.missed;
}

TEST(RandomGraph, WeakenedAccessMaskIsFound) {
    Found sources, targets;
    for (uint64_t seed = 0; seed < kSeeds / 8; ++seed)
        ForEachFrame(seed, [&](const Oracle& oracle, const FrameGraph& graph, const Plan& plan) {
            ForEachBarrier(plan, [&](size_t position, uint32_t b) {
                const PlannedBarrier& barrier = plan.barriers[b];
                if (IsPrecaution(graph, plan, barrier)) return;
                const std::string what = "seed " + std::to_string(seed) + ": " + BarrierText(graph, barrier);
                // Writes that were made available before stay so.
                if (oracle::WritesOf(barrier.dependency.srcAccess) != 0 &&
                    IsFirstAfterAWrite(graph, plan, position, barrier)) {
                    Plan fault = plan;
                    fault.barriers[b].dependency.srcAccess = VK_ACCESS_2_NONE;
                    sources.Judge(oracle, graph, fault, what);
                }
                if (!HasSomethingToSee(graph, plan, position, barrier)) return;
                if (IsForTheOwner(graph, plan, position, barrier)) return;
                Plan fault = plan;
                fault.barriers[b].dependency.dstAccess = VK_ACCESS_2_NONE;
                targets.Judge(oracle, graph, fault, what);
            });
        });
    EXPECT_GT(sources.planted, 500u);
    EXPECT_GT(targets.planted, 1000u);
    EXPECT_EQ(sources.found, sources.planted) << sources.missed;
    EXPECT_EQ(targets.found, targets.planted) << targets.missed;
}

// A lifetime that ends a pass too early lets the memory planner give its block to another resource.
TEST(RandomGraph, ShortenedLifetimeIsFound) {
    Found lifetimes;
    for (uint64_t seed = 0; seed < kSeeds; ++seed)
        ForEachFrame(seed, [&](const Oracle& oracle, const FrameGraph& graph, const Plan& plan) {
            for (uint32_t r = 0; r < graph.resources.size(); ++r) {
                const Lifetime& lifetime = plan.lifetimes[r];
                if (lifetime.block == kNone || lifetime.first == lifetime.last) continue;
                Plan fault = plan;
                fault.lifetimes[r].last = lifetime.first;
                fault.blocks.clear();
                BlockMemory memory;
                PlanMemory(graph, fault, memory);
                // Only where the planner took the opportunity
                bool isShared = false;
                for (uint32_t other = 0; other < graph.resources.size(); ++other)
                    isShared = isShared || (other != r && plan.lifetimes[other].IsUsed() &&
                                            fault.lifetimes[other].block == fault.lifetimes[r].block &&
                                            plan.lifetimes[other].first <= lifetime.last &&
                                            lifetime.first <= plan.lifetimes[other].last);
                if (isShared)
                    lifetimes.Judge(
                        oracle, graph, fault,
                        "seed " + std::to_string(seed) + ": " + std::string(graph.resources[r].name));
            }
        });
    EXPECT_GT(lifetimes.planted, 50u);
    EXPECT_EQ(lifetimes.found, lifetimes.planted) << lifetimes.missed;
}

}  // namespace
}  // namespace raygraph::random_graph_test
