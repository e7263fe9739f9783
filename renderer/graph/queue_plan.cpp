#include "renderer/graph/queue_plan.h"

#include <algorithm>
#include <array>
#include <span>

namespace raygraph {

namespace {

using rhi::QueueKind;

// Positions are those among the executed passes, in order of declaration. -1: before the frame.
using Position = int64_t;
constexpr Position kBeforeFrame = -1;

// The uses of one subresource so far.
struct History {
    Position lastChange = kBeforeFrame;  // a write, a transition or a transfer of ownership
    size_t changedOn = 0;                // its queue
    std::array<Position, 2> lastRead{kBeforeFrame, kBeforeFrame};  // by queue, since the last change
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
};

class QueuePlanner {
  public:
    QueuePlanner(const FrameGraph& graph, Plan& plan)
        : m_graph(graph), m_plan(plan), m_histories(graph.SubresourceCount()) {}

    void Run();

  private:
    QueueKind QueueOf(Position position) const {
        const GraphPass& pass = PassAt(position);
        return CanRunOnComputeQueue(pass.kind) ? pass.queue : QueueKind::Main;
    }
    const GraphPass& PassAt(Position position) const {
        return m_graph.passes[m_plan.passes[static_cast<size_t>(position)].pass];
    }
    void StartHistories();
    Position DependencyOf(Position position);
    void FormBatches(std::span<const Position> dependencies);

    const FrameGraph& m_graph;
    Plan& m_plan;
    std::vector<History> m_histories;  // by number of the subresource
};

void QueuePlanner::StartHistories() {
    for (uint32_t r = 0; r < m_graph.resources.size(); ++r) {
        const GraphResource& resource = m_graph.resources[r];
        if (resource.origin == Origin::Transient) continue;
        uint32_t other = 0;
        m_graph.ForEachSubresource(r, [&](uint32_t number, auto&&) {
            const bool isFirst = number == r || !resource.hasOtherStates;
            m_histories[number].layout =
                isFirst ? resource.state.layout : m_graph.otherStates[resource.firstOther + other].layout;
            if (number != r) ++other;
        });
    }
}

// Returns the last pass of the other queue after which this pass must run, and records its uses.
Position QueuePlanner::DependencyOf(Position position) {
    const GraphPass& pass = PassAt(position);
    const size_t queue = IndexOf(QueueOf(position)), other = 1 - queue;
    const bool areApart = m_graph.computeFamily != m_graph.queueFamily;
    Position dependency = kBeforeFrame;
    for (const ResourceUse& use : std::span(m_graph.uses).subspan(pass.firstUse, pass.useCount)) {
        const GraphResource& resource = m_graph.resources[use.resource];
        if (resource.kind == ResourceKind::TextureSet) continue;  // its owner orders it
        const VkImageLayout layout = resource.kind == ResourceKind::Texture
                                         ? MasksFor(pass.kind, use.access).layout
                                         : VK_IMAGE_LAYOUT_UNDEFINED;
        m_graph.ForEachSubresource(use.resource, use.part, [&](uint32_t number, auto&&) {
            History& history = m_histories[number];
            const bool changes = Writes(use.access) || layout != history.layout ||
                                 (!resource.isShared && areApart && history.changedOn != queue);
            if (history.changedOn == other) dependency = std::max(dependency, history.lastChange);
            if (!changes) {
                history.lastRead[queue] = position;
                return;
            }
            dependency = std::max(dependency, history.lastRead[other]);
            history = {.lastChange = position, .changedOn = queue, .layout = layout};
        });
    }
    return dependency;
}

// `dependencies` has, for each pass, the pass of the other queue for which it waits; kBeforeFrame for those
// that wait for none, or whose queue has waited for it already.
void QueuePlanner::FormBatches(std::span<const Position> dependencies) {
    std::vector<uint8_t> endsBatch(dependencies.size(), 0);
    for (const Position dependency : dependencies)
        if (dependency != kBeforeFrame) endsBatch[static_cast<size_t>(dependency)] = 1;

    std::vector<std::vector<PlannedPass>> passes(1);  // by batch
    std::vector<uint32_t> batchOf(dependencies.size());
    std::array<uint32_t, 2> open{kNone, kNone};  // by queue: the batch to which passes are added
    m_plan.batches.push_back({.queue = QueueKind::Main});
    for (Position position = 0; position < std::ssize(dependencies); ++position) {
        const auto index = static_cast<size_t>(position);
        const QueueKind queue = QueueOf(position);
        uint32_t& batch = open[IndexOf(queue)];
        const bool waits = dependencies[index] != kBeforeFrame;
        if (batch == kNone || waits) {
            const bool isFirstOfCompute =
                queue == QueueKind::Compute &&
                std::ranges::find(m_plan.batches, queue, &PlannedBatch::queue) == m_plan.batches.end();
            batch = static_cast<uint32_t>(m_plan.batches.size());
            m_plan.batches.push_back({.queue = queue,
                                      .waitsFor = waits ? batchOf[static_cast<size_t>(dependencies[index])]
                                                  : isFirstOfCompute ? 0
                                                                     : kNone});
            passes.emplace_back();
        }
        batchOf[index] = batch;
        passes[batch].push_back(m_plan.passes[index]);
        if (endsBatch[index]) batch = kNone;
    }
    m_plan.passes.clear();
    for (size_t b = 0; b < passes.size(); ++b) {
        m_plan.batches[b].firstPass = static_cast<uint32_t>(m_plan.passes.size());
        m_plan.batches[b].passCount = static_cast<uint32_t>(passes[b].size());
        m_plan.passes.insert(m_plan.passes.end(), passes[b].begin(), passes[b].end());
    }
}

void QueuePlanner::Run() {
    StartHistories();
    std::vector<Position> dependencies(m_plan.passes.size(), kBeforeFrame);
    std::array<Position, 2> waitedFor{kBeforeFrame, kBeforeFrame};  // by queue: passes of the other one
    Position lastOnCompute = kBeforeFrame;
    for (Position position = 0; position < std::ssize(dependencies); ++position) {
        const QueueKind queue = QueueOf(position);
        const Position dependency = DependencyOf(position);
        if (dependency > waitedFor[IndexOf(queue)])
            dependencies[static_cast<size_t>(position)] = waitedFor[IndexOf(queue)] = dependency;
        if (queue == QueueKind::Compute) lastOnCompute = position;
    }
    FormBatches(dependencies);
    // The frame ends on the main queue, after all of the other.
    const bool isJoined = lastOnCompute <= waitedFor[IndexOf(QueueKind::Main)];
    if (isJoined && m_plan.batches.back().queue == QueueKind::Main) return;
    uint32_t last = static_cast<uint32_t>(m_plan.batches.size());
    while (m_plan.batches[--last].queue != QueueKind::Compute) {
    }
    m_plan.batches.push_back({.queue = QueueKind::Main,
                              .firstPass = static_cast<uint32_t>(m_plan.passes.size()),
                              .waitsFor = isJoined ? kNone : last});
}

}  // namespace

bool CanRunOnComputeQueue(PassKind kind) {
    return kind != PassKind::Raster;
}

void PlanQueues(const FrameGraph& graph, Plan& plan) {
    plan.batches.clear();
    const auto asksForCompute = [&](const PlannedPass& planned) {
        const GraphPass& pass = graph.passes[planned.pass];
        return pass.queue == rhi::QueueKind::Compute && CanRunOnComputeQueue(pass.kind);
    };
    if (graph.computeFamily == VK_QUEUE_FAMILY_IGNORED || std::ranges::none_of(plan.passes, asksForCompute)) {
        plan.batches.push_back({.passCount = static_cast<uint32_t>(plan.passes.size())});
        return;
    }
    QueuePlanner(graph, plan).Run();
}

}  // namespace raygraph
