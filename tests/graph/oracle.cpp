#include <algorithm>
#include <set>
#include <stdexcept>
#include <tuple>

#include "base/text.h"
#include "tests/graph/access_table.h"
#include "tests/graph/oracle.h"

namespace raygraph::oracle {

namespace {

constexpr std::array<VkPipelineStageFlags2, 15> kStages{
    VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
    VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT,
    VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT,
    VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT,
    VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
    VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
    VK_PIPELINE_STAGE_2_COPY_BIT,
    VK_PIPELINE_STAGE_2_RESOLVE_BIT,
    VK_PIPELINE_STAGE_2_BLIT_BIT,
    VK_PIPELINE_STAGE_2_CLEAR_BIT,
    VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR,
    VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
    VK_PIPELINE_STAGE_2_HOST_BIT,
};
constexpr VkPipelineStageFlags2 kTransferStages =
    VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_RESOLVE_BIT | VK_PIPELINE_STAGE_2_BLIT_BIT |
    VK_PIPELINE_STAGE_2_CLEAR_BIT;
constexpr VkAccessFlags2 kShaderReads =
    VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_UNIFORM_READ_BIT;
constexpr VkAccessFlags2 kReads = kShaderReads | VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT |
                                  VK_ACCESS_2_INDEX_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT |
                                  VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
                                  VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_HOST_READ_BIT |
                                  VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR;
constexpr VkAccessFlags2 kWrites =
    VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT |
    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT |
    VK_ACCESS_2_HOST_WRITE_BIT | VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;

// Bits that no stage above has.
constexpr size_t kFirstComputeBit = 42;
constexpr std::array<size_t, kSemaphoreCount> kSemaphoreBits{4,  5,  6,  17, 18, 19, 20, 22,
                                                             23, 24, 26, 27, 28, 29, 30, 31};
constexpr size_t kAllStages = 2 * kStages.size() + kSemaphoreCount;

constexpr VkPipelineStageFlags2 StageAt(size_t s) {
    if (s < kStages.size()) return kStages[s];
    if (s < 2 * kStages.size()) return VkPipelineStageFlags2{1} << (kFirstComputeBit + s - kStages.size());
    return VkPipelineStageFlags2{1} << kSemaphoreBits[s - 2 * kStages.size()];
}

template <typename Run>
void ForEachStage(VkPipelineStageFlags2 stages, Run&& run) {
    for (size_t s = 0; s < kAllStages; ++s)
        if ((stages & StageAt(s)) != 0) run(s);
}

}  // namespace

VkPipelineStageFlags2 SemaphoreStage(size_t number) {
    return VkPipelineStageFlags2{1} << kSemaphoreBits.at(number);
}

Scope OnQueue(const Scope& scope, rhi::QueueKind queue) {
    if (queue != rhi::QueueKind::Compute) return scope;
    Scope mapped{0, scope.access};
    const VkPipelineStageFlags2 stages = Expand(scope.stages);
    for (size_t s = 0; s < kStages.size(); ++s)
        if ((stages & kStages[s]) != 0) mapped.stages |= StageAt(kStages.size() + s);
    return mapped;
}

VkPipelineStageFlags2 Expand(VkPipelineStageFlags2 stages) {
    VkPipelineStageFlags2 all = 0, commands = 0;
    for (size_t s = 0; s < kAllStages; ++s) all |= StageAt(s);
    for (const VkPipelineStageFlags2 stage : kStages) commands |= stage;
    if ((stages & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT) != 0)
        stages =
            (stages & ~VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT) | (commands & ~VK_PIPELINE_STAGE_2_HOST_BIT);
    if ((stages & VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT) != 0)
        stages = (stages & ~VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT) | kTransferStages;
    if ((stages & ~all) != 0) throw std::logic_error("the memory model does not know a stage");
    return stages;
}

VkAccessFlags2 ExpandAccess(VkAccessFlags2 access) {
    if ((access & VK_ACCESS_2_MEMORY_READ_BIT) != 0) access |= kReads;
    if ((access & VK_ACCESS_2_MEMORY_WRITE_BIT) != 0) access |= kWrites;
    if ((access & VK_ACCESS_2_SHADER_READ_BIT) != 0) access |= kShaderReads;
    if ((access & VK_ACCESS_2_SHADER_WRITE_BIT) != 0) access |= VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
    access &= ~(VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT | VK_ACCESS_2_SHADER_READ_BIT |
                VK_ACCESS_2_SHADER_WRITE_BIT);
    if ((access & ~(kReads | kWrites)) != 0)
        throw std::logic_error("the memory model does not know an access");
    return access;
}

VkAccessFlags2 WritesOf(VkAccessFlags2 access) {
    return ExpandAccess(access) & kWrites;
}

// The part itself is in the first scope, or what it happens before is: a chain.
bool Memory::IsOrdered(const Part& part, VkPipelineStageFlags2 src) {
    return ((part.stage | part.happensBefore) & src) != 0;
}

// Made available by this barrier, whose access scope has it, or by an earlier one that this one follows.
bool Memory::IsMadeAvailable(const Event& write, const Part& part, const Scope& src) {
    const bool isInScope = (part.stage & src.stages) != 0 && (write.writes & ~src.access) == 0;
    return isInScope || (part.isAvailable && (part.availableBefore & src.stages) != 0);
}

void Memory::MakeVisible(Part& part, const Scope& dst) {
    part.isAvailable = true;
    part.availableBefore |= dst.stages;
    ForEachStage(dst.stages, [&](size_t s) { part.visible[s] |= dst.access; });
}

Memory::Event Memory::EventOf(const Scope& scope, const std::string& who) {
    Event event{.who = who, .writes = scope.access & kWrites};
    ForEachStage(scope.stages, [&](size_t s) { event.parts.push_back({.stage = StageAt(s)}); });
    return event;
}

void Memory::Barrier(const Scope& srcMasks, const Scope& dstMasks) {
    const Scope src{Expand(srcMasks.stages), ExpandAccess(srcMasks.access)};
    const Scope dst{Expand(dstMasks.stages), ExpandAccess(dstMasks.access)};
    for (Event& write : m_writes)
        for (Part& part : write.parts) {
            if (IsMadeAvailable(write, part, src)) MakeVisible(part, dst);
            if (IsOrdered(part, src.stages)) part.happensBefore |= dst.stages;
        }
    for (Event& read : m_reads)
        for (Part& part : read.parts)
            if (IsOrdered(part, src.stages)) part.happensBefore |= dst.stages;
}

std::string Memory::Transition(const Scope& srcMasks, const Scope& dstMasks, const std::string& who) {
    const Scope src{Expand(srcMasks.stages), ExpandAccess(srcMasks.access)};
    const Scope dst{Expand(dstMasks.stages), ExpandAccess(dstMasks.access)};
    std::string wrong;
    for (const Event& write : m_writes)
        for (const Part& part : write.parts)
            if (!IsOrdered(part, src.stages) || !IsMadeAvailable(write, part, src))
                wrong = who + " does not wait for " + write.who;
    for (const Event& read : m_reads)
        for (const Part& part : read.parts)
            if (!IsOrdered(part, src.stages)) wrong = who + " does not wait for " + read.who;
    Part part{.happensBefore = dst.stages};
    MakeVisible(part, dst);
    m_writes.assign(1, {.who = who, .writes = 0, .parts = {part}});
    m_reads.clear();
    return wrong;
}

// Whether the accesses come after the last write and see it.
std::string Memory::Invisible(const Scope& scope, const std::string& who) const {
    std::string wrong;
    for (const Event& write : m_writes)
        for (const Part& part : write.parts)
            ForEachStage(scope.stages, [&](size_t s) {
                if ((part.happensBefore & StageAt(s)) == 0)
                    wrong = who + " is not ordered after " + write.who;
                else if ((scope.access & ~part.visible[s]) != 0)
                    wrong = who + " does not see " + write.who;
            });
    return wrong;
}

std::string Memory::Read(const Scope& masks, const std::string& who) {
    const Scope scope{Expand(masks.stages), ExpandAccess(masks.access)};
    const std::string wrong = Invisible(scope, who);
    m_reads.push_back(EventOf({scope.stages, 0}, who));
    return wrong;
}

std::string Memory::Write(const Scope& masks, const std::string& who) {
    const Scope scope{Expand(masks.stages), ExpandAccess(masks.access)};
    std::string wrong = Invisible(scope, who);
    for (const Event& read : m_reads)
        for (const Part& part : read.parts)
            if ((scope.stages & ~part.happensBefore) != 0) wrong = who + " is not ordered after " + read.who;
    m_writes.assign(1, EventOf(scope, who));
    m_reads.clear();
    return wrong;
}

void Memory::HandedOver(VkPipelineStageFlags2 waitStages, const std::string& who) {
    Part part{.happensBefore = Expand(waitStages)};
    MakeVisible(part, {Expand(waitStages), kReads | kWrites});
    m_writes.assign(1, {.who = who, .writes = 0, .parts = {part}});
    m_reads.clear();
}

}  // namespace raygraph::oracle

namespace raygraph::oracle {

namespace {

constexpr VkAccessFlags2 kAnything = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;

// Whether a write leaves some of what was there in place, by the graph's contract (renderer/graph/README.md).
bool IsPartial(ResourceKind kind, Access access) {
    return access == Access::AddressWrite || (kind == ResourceKind::Buffer && access == Access::CopyWrite) ||
           (kind == ResourceKind::BlasSet && access == Access::BuildWrite);
}

// From one executed pass to another one, both included; the end of the frame is one more.
struct Span {
    uint32_t first = ~0u;
    uint32_t last = 0;
    bool IsUsed() const { return first != ~0u; }
};

}  // namespace

struct Oracle::Frame {
    const FrameGraph& graph;
    const Plan& plan;
    std::vector<std::string> wrong;
    std::vector<Span> spans;                      // by resource
    rhi::QueueKind queue = rhi::QueueKind::Main;  // of the batch that is judged
    // By resource and place: the family to which it was released, for an acquisition that must follow.
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> released;
    // By resource, place of the subresource and version.
    std::map<std::tuple<uint32_t, uint32_t, uint32_t>, uint64_t> contentsOf;
    // Objects of transients; those that share memory use the images alone.
    std::map<uint32_t, Object> passing;
    // By resource and place: its contents from before the frame are used.
    std::set<std::pair<uint32_t, uint32_t>> needsLastFrame;

    const GraphResource& Resource(uint32_t r) const { return graph.resources[r]; }
    void Note(const std::string& line) {
        if (!line.empty()) wrong.push_back(line);
    }
    uint32_t PlaceCount(uint32_t r) const { return Resource(r).levels * Resource(r).layers; }
    bool Covers(const Subresources& part, uint32_t r, uint32_t place) const {
        const uint32_t level = place % Resource(r).levels, layer = place / Resource(r).levels;
        return part.level <= level && level < part.level + part.levelCount && part.layer <= layer &&
               layer < part.layer + part.layerCount;
    }
    // The version of the last declared write of a subresource among the first `version` ones; 0: there is none.
    uint32_t LastWrite(uint32_t r, uint32_t place, uint32_t version) const {
        uint32_t last = 0;
        for (const ResourceUse& use : graph.uses)
            if (use.resource == r && use.versionOut != use.versionIn && use.versionOut <= version &&
                Covers(use.part, r, place))
                last = std::max(last, use.versionOut);
        return last;
    }
    // IGNORED stands for the main queue's family.
    uint32_t Known(uint32_t family) const {
        return family == graph.queueFamily ? VK_QUEUE_FAMILY_IGNORED : family;
    }
    uint32_t OwnFamily() const {
        return queue == rhi::QueueKind::Compute ? Known(graph.computeFamily) : VK_QUEUE_FAMILY_IGNORED;
    }
    bool IsShared(uint32_t r) const {
        return Resource(r).origin == Origin::Transient && plan.lifetimes[r].block != kNone;
    }
};

Oracle::Object& Oracle::ObjectOf(Frame& frame, uint32_t r) {
    const bool isTransient = frame.Resource(r).origin == Origin::Transient;
    Object& object = isTransient ? frame.passing[r] : m_objects[std::string(frame.Resource(r).name)];
    // One that its owner has used as a whole, or a new one.
    if (object.images.size() != frame.PlaceCount(r)) {
        object.segments.resize(frame.PlaceCount(r), object.segments.front());
        object.images.resize(frame.PlaceCount(r), object.images.front());
    }
    return object;
}

std::vector<Oracle::Segment>& Oracle::AllSegments(Frame& frame, uint32_t r) {
    if (frame.IsShared(r)) return m_blocks[frame.plan.lifetimes[r].block];
    return ObjectOf(frame, r).segments;
}

// Returns the bytes of one subresource: the resource lies at the start of its block.
std::vector<Oracle::Segment*> Oracle::Segments(Frame& frame, uint32_t r, uint32_t place) {
    std::vector<Segment>& all = AllSegments(frame, r);
    if (!frame.IsShared(r)) return {&all[place]};
    const uint64_t size = frame.Resource(r).memory.size, count = frame.PlaceCount(r);
    std::vector<Segment*> own;
    for (Segment& segment : all)
        if (segment.end > place * size / count && segment.end <= (place + 1) * size / count)
            own.push_back(&segment);
    return own;
}

Oracle::Image& Oracle::ImageOf(Frame& frame, uint32_t r, uint32_t place) {
    return ObjectOf(frame, r).images[place];
}

void Oracle::FindSpans(Frame& frame) {
    frame.spans.resize(frame.graph.resources.size());
    std::array<uint32_t, 2> next{};  // by queue
    for (const PlannedBatch& batch : frame.plan.batches)
        for (uint32_t position = batch.firstPass; position < batch.firstPass + batch.passCount; ++position) {
            const uint32_t p = frame.plan.passes[position].pass;
            if (p < next.at(IndexOf(batch.queue)))
                frame.Note("passes are not executed in the order of their declaration");
            next.at(IndexOf(batch.queue)) = p + 1;
            const GraphPass& pass = frame.graph.passes[p];
            for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u) {
                Span& span = frame.spans[frame.graph.uses[u].resource];
                const bool isBeside = batch.queue == rhi::QueueKind::Compute;
                span.first = isBeside ? 0 : std::min(span.first, position);
                span.last = isBeside ? static_cast<uint32_t>(frame.plan.passes.size())
                                     : std::max(span.last, position);
            }
        }
    for (const Root& root : frame.graph.roots)
        if (frame.spans[root.resource].IsUsed())
            frame.spans[root.resource].last = static_cast<uint32_t>(frame.plan.passes.size());
}

void Oracle::OrderAll(Frame& frame, const Scope& src, const Scope& dst) {
    const auto order = [&](std::vector<Segment>& segments) {
        for (Segment& segment : segments) segment.memory.Barrier(src, dst);
    };
    for (auto& [name, object] : m_objects) order(object.segments);
    for (auto& [resource, object] : frame.passing) order(object.segments);
    for (std::vector<Segment>& block : m_blocks) order(block);
}

void Oracle::JudgeBatch(Frame& frame, uint32_t index) {
    const PlannedBatch& batch = frame.plan.batches[index];
    frame.queue = batch.queue;
    const Scope all = OnQueue({VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, kAnything}, batch.queue);
    if (batch.waitsFor != kNone) OrderAll(frame, {SemaphoreStage(batch.waitsFor), 0}, all);
    for (uint32_t position = batch.firstPass; position < batch.firstPass + batch.passCount; ++position) {
        const PlannedPass& planned = frame.plan.passes[position];
        JudgeBarriers(frame, planned.barriers, std::string(frame.graph.passes[planned.pass].name));
        JudgePass(frame, planned);
    }
    for (uint32_t b = 0; b < batch.release.count; ++b)
        JudgeRelease(frame, frame.plan.barriers[batch.release.first + b]);
    if (frame.plan.batches.size() > 1 && index + 1 < frame.plan.batches.size())
        OrderAll(frame, all, {SemaphoreStage(index), 0});
}

// The first half of a transfer of ownership: the other one carries out the transition.
void Oracle::JudgeRelease(Frame& frame, const PlannedBarrier& barrier) {
    const uint32_t r = barrier.resource;
    const Scope src = OnQueue({barrier.dependency.srcStages, barrier.dependency.srcAccess}, frame.queue);
    const Scope rest = OnQueue({VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, kAnything}, frame.queue);
    const std::string who = "the release of " + std::string(frame.Resource(r).name);
    for (uint32_t place = 0; place < frame.PlaceCount(r); ++place) {
        if (!frame.Covers(barrier.part, r, place)) continue;
        if (ImageOf(frame, r, place).queueFamily != frame.Known(barrier.srcQueueFamily) ||
            frame.OwnFamily() != frame.Known(barrier.srcQueueFamily))
            frame.Note(who + " is by a queue family that does not have it");
        for (Segment* segment : Segments(frame, r, place))
            frame.Note(segment->memory.Transition(src, rest, who));
        frame.released[{r, place}] = frame.Known(barrier.dstQueueFamily);
    }
}

std::vector<std::string> Oracle::Judge(const FrameGraph& graph, const Plan& plan) {
    Frame frame{.graph = graph, .plan = plan};
    FindSpans(frame);
    JudgeSharing(frame);
    PlaceTransients(frame);
    for (uint32_t r = 0; r < graph.resources.size(); ++r)
        for (uint32_t place = 0; place < frame.PlaceCount(r); ++place)
            if (graph.resources[r].origin != Origin::Transient)
                frame.contentsOf[{r, place, 0}] = Segments(frame, r, place).front()->contents;

    JudgeBarriers(frame, plan.acquire, "the first pass");
    for (uint32_t batch = 0; batch < plan.batches.size(); ++batch) JudgeBatch(frame, batch);
    if (frame.queue != rhi::QueueKind::Main) frame.Note("the frame does not end on the main queue");
    JudgeBarriers(frame, plan.regain, "the end");
    JudgeBarriers(frame, plan.finish, "the end");
    JudgeEnd(frame);
    JudgeBarriers(frame, plan.release, "the release");
    for (const Root& root : graph.roots)
        if (root.kind == RootKind::Exported && root.queueFamily != graph.queueFamily &&
            !graph.resources[root.resource].isShared &&
            ImageOf(frame, root.resource, 0).queueFamily != root.queueFamily)
            frame.Note(
                Text("{} is not released to its owner's queue family", graph.resources[root.resource].name));
    return std::move(frame.wrong);
}

void Oracle::JudgeSharing(Frame& frame) {
    for (uint32_t a = 0; a < frame.spans.size(); ++a) {
        if (!frame.IsShared(a) || !frame.spans[a].IsUsed()) continue;
        const rhi::MemoryRequirements& needs = frame.Resource(a).memory;
        const rhi::MemoryRequirements& block = frame.plan.blocks[frame.plan.lifetimes[a].block];
        if (needs.size > block.size || needs.alignment > block.alignment || block.memoryTypeBits == 0 ||
            (block.memoryTypeBits & ~needs.memoryTypeBits) != 0)
            frame.Note(std::string(frame.Resource(a).name) + " does not fit its block");
        for (uint32_t b = 0; b < a; ++b)
            if (frame.IsShared(b) && frame.spans[b].IsUsed() &&
                frame.plan.lifetimes[a].block == frame.plan.lifetimes[b].block &&
                frame.spans[a].first <= frame.spans[b].last && frame.spans[b].first <= frame.spans[a].last)
                frame.Note(std::string(frame.Resource(a).name) + " and " +
                           std::string(frame.Resource(b).name) + " share memory and live at one time");
    }
}

// Cuts the blocks where a subresource of this frame ends.
void Oracle::PlaceTransients(Frame& frame) {
    if (m_blocks.size() < frame.plan.blocks.size()) m_blocks.resize(frame.plan.blocks.size());
    for (uint32_t r = 0; r < frame.spans.size(); ++r) {
        if (!frame.IsShared(r)) continue;
        std::vector<Segment>& segments = m_blocks[frame.plan.lifetimes[r].block];
        for (uint64_t place = 1; place <= frame.PlaceCount(r); ++place) {
            const uint64_t end = place * frame.Resource(r).memory.size / frame.PlaceCount(r);
            const auto at = std::find_if(segments.begin(), segments.end(),
                                         [&](const Segment& segment) { return segment.end >= end; });
            if (at == segments.end()) {
                segments.push_back({.end = end});
            } else if (at->end > end) {
                Segment head = *at;
                head.end = end;
                segments.insert(at, head);
            }
        }
    }
}

void Oracle::JudgeBarriers(Frame& frame, const BarrierRange& range, const std::string& before) {
    // Barriers of one batch happen at once: none sees the transition of another.
    for (uint32_t b = range.first; b < range.first + range.count; ++b)
        OrderTheRest(frame, frame.plan.barriers[b]);
    for (uint32_t b = range.first; b < range.first + range.count; ++b)
        JudgeBarrier(frame, frame.plan.barriers[b], before);
}

void Oracle::JudgeBarrier(Frame& frame, const PlannedBarrier& barrier, const std::string& before) {
    const uint32_t r = barrier.resource;
    const Dependency& dependency = barrier.dependency;
    const Scope src = OnQueue({dependency.srcStages, dependency.srcAccess}, frame.queue);
    const Scope dst = OnQueue({dependency.dstStages, dependency.dstAccess}, frame.queue);
    const std::string who = "the transition of " + std::string(frame.Resource(r).name) + " before " + before;
    const bool isTexture = frame.Resource(r).kind == ResourceKind::Texture;
    if (isTexture && (barrier.part.level + barrier.part.levelCount > frame.Resource(r).levels ||
                      barrier.part.layer + barrier.part.layerCount > frame.Resource(r).layers))
        frame.Note(who + " goes beyond the texture");
    const bool changesOwner = barrier.srcQueueFamily != barrier.dstQueueFamily;
    const bool dropsContents = isTexture && dependency.oldLayout == VK_IMAGE_LAYOUT_UNDEFINED &&
                               dependency.newLayout != VK_IMAGE_LAYOUT_UNDEFINED;
    const bool isTransition = changesOwner || dropsContents || dependency.oldLayout != dependency.newLayout;
    for (uint32_t place = 0; place < frame.PlaceCount(r); ++place) {
        if (!frame.Covers(barrier.part, r, place)) continue;
        Image& image = ImageOf(frame, r, place);
        if (isTexture && dependency.oldLayout != VK_IMAGE_LAYOUT_UNDEFINED &&
            dependency.oldLayout != image.layout)
            frame.Note(who + " starts from another layout than the texture has");
        for (Segment* segment : Segments(frame, r, place)) {
            if (!isTransition) {
                segment->memory.Barrier(src, dst);
                continue;
            }
            frame.Note(segment->memory.Transition(src, dst, who));
            if (dropsContents && image.layout != VK_IMAGE_LAYOUT_UNDEFINED)
                segment->contents = ++m_lastContents;
        }
        if (isTexture) image.layout = dependency.newLayout;
        if (dropsContents && image.queueFamily == frame.Known(frame.graph.computeFamily))
            image.queueFamily = VK_QUEUE_FAMILY_IGNORED;
        if (dropsContents && !frame.Resource(r).isShared) image.queueFamily = frame.OwnFamily();
        if (!changesOwner) continue;
        if (image.queueFamily != frame.Known(barrier.srcQueueFamily))
            frame.Note(who + " takes it from a queue family that does not have it");
        image.queueFamily = frame.Known(barrier.dstQueueFamily);
        const bool isFromUs = barrier.srcQueueFamily == frame.graph.queueFamily ||
                              barrier.srcQueueFamily == frame.graph.computeFamily;
        const bool isToUs = barrier.dstQueueFamily == frame.graph.queueFamily ||
                            barrier.dstQueueFamily == frame.graph.computeFamily;
        if (!isFromUs || !isToUs) continue;
        const auto released = frame.released.find({r, place});
        if (released == frame.released.end() || released->second != image.queueFamily ||
            image.queueFamily != frame.OwnFamily())
            frame.Note(who + " takes what was not released to it");
        else
            frame.released.erase(released);
    }
}

// Any barrier orders the work in all of the block. What it makes available and visible is its part of the
// resource alone, unless it hands the block over, by a memory barrier if there is something to make available.
void Oracle::OrderTheRest(Frame& frame, const PlannedBarrier& barrier) {
    const uint32_t r = barrier.resource;
    const Dependency& dependency = barrier.dependency;
    std::set<const Segment*> own;
    for (uint32_t place = 0; place < frame.PlaceCount(r); ++place)
        if (frame.Covers(barrier.part, r, place))
            for (const Segment* segment : Segments(frame, r, place)) own.insert(segment);
    const bool isHandOver = barrier.predecessor != kNone || barrier.followsLastFrame;
    const bool isTexture = frame.Resource(r).kind == ResourceKind::Texture;
    const bool isMemoryBarrier = isHandOver && (!isTexture || dependency.srcAccess != VK_ACCESS_2_NONE);
    for (Segment& segment : AllSegments(frame, r)) {
        if (own.contains(&segment)) continue;
        const Scope src{dependency.srcStages, isMemoryBarrier ? dependency.srcAccess : VK_ACCESS_2_NONE};
        const Scope dst{dependency.dstStages, isMemoryBarrier ? dependency.dstAccess : VK_ACCESS_2_NONE};
        segment.memory.Barrier(OnQueue(src, frame.queue), OnQueue(dst, frame.queue));
    }
}

void Oracle::JudgePass(Frame& frame, const PlannedPass& planned) {
    const GraphPass& pass = frame.graph.passes[planned.pass];
    std::set<uint32_t> seen;
    for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u)
        if (frame.Resource(frame.graph.uses[u].resource).kind != ResourceKind::TextureSet &&
            seen.insert(frame.graph.uses[u].resource).second)
            for (uint32_t place = 0; place < frame.PlaceCount(frame.graph.uses[u].resource); ++place)
                JudgeAccess(frame, pass, u, place);
}

// All that the pass does with a subresource of the resource of its use `first`; within the pass, its body sees
// to the order.
void Oracle::JudgeAccess(Frame& frame, const GraphPass& pass, uint32_t first, uint32_t place) {
    const uint32_t r = frame.graph.uses[first].resource;
    const GraphResource& resource = frame.Resource(r);
    const std::string who = Text("{} ({})", pass.name, resource.name);
    Scope scope;
    bool writes = false, needsContents = false;
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
    bool isUsed = false;
    uint32_t versionIn = 0, version = 0;
    for (uint32_t u = first; u < pass.firstUse + pass.useCount; ++u) {
        const ResourceUse& use = frame.graph.uses[u];
        if (use.resource != r || !frame.Covers(use.part, r, place)) continue;
        if (!isUsed) versionIn = frame.LastWrite(r, place, use.versionIn);
        isUsed = true;
        const golden::AccessRow* row = golden::Find(pass.kind, use.access);
        if (!row) return frame.Note(who + " is an access that such a pass does not have");
        scope.stages |= row->stages;
        scope.access |= row->accesses;
        writes = writes || row->effect != golden::Effect::Reads;
        needsContents =
            needsContents || row->effect != golden::Effect::Replaces || IsPartial(resource.kind, use.access);
        if (resource.kind == ResourceKind::Texture) layout = row->layout;
        version = use.versionOut;
    }
    if (!isUsed) return;
    Image& image = ImageOf(frame, r, place);
    if (resource.kind == ResourceKind::Texture && image.layout != layout)
        frame.Note(who + " finds another layout");
    const uint32_t owner = resource.isShared ? VK_QUEUE_FAMILY_IGNORED : frame.OwnFamily();
    if (!needsContents && resource.kind == ResourceKind::Buffer && !resource.isShared)
        image.queueFamily = owner;  // whoever needs no contents needs no transfer either
    if (image.queueFamily != owner) frame.Note(who + " finds it with another queue family");
    scope = OnQueue(scope, frame.queue);

    const bool isNew = versionIn == 0 && resource.origin == Origin::Transient;
    if (needsContents && !isNew) {
        const auto expected = frame.contentsOf.find({r, place, versionIn});
        if (expected == frame.contentsOf.end())
            frame.Note(who + " needs what no executed pass wrote");
        else
            for (const Segment* segment : Segments(frame, r, place))
                if (segment->contents != expected->second) frame.Note(who + " finds other contents");
    }
    if (needsContents && versionIn == 0) frame.needsLastFrame.insert({r, place});
    const uint64_t contents = writes ? ++m_lastContents : 0;
    for (Segment* segment : Segments(frame, r, place)) {
        frame.Note(writes ? segment->memory.Write(scope, who) : segment->memory.Read(scope, who));
        if (writes) segment->contents = contents;
    }
    if (writes) frame.contentsOf[{r, place, version}] = contents;
}

bool Oracle::HasNewest(Frame& frame, uint32_t r, uint32_t place) {
    const uint32_t last = frame.LastWrite(r, place, frame.Resource(r).version);
    const auto newest = frame.contentsOf.find({r, place, last});
    return newest != frame.contentsOf.end() && Segments(frame, r, place).front()->contents == newest->second;
}

void Oracle::JudgeEnd(Frame& frame) {
    for (const Root& root : frame.graph.roots) {
        const GraphResource& resource = frame.Resource(root.resource);
        for (uint32_t place = 0; place < frame.PlaceCount(root.resource); ++place)
            if (!HasNewest(frame, root.resource, place))
                frame.Note(Text("the end does not find the newest {}", resource.name));
        const bool isExportedToo =
            std::any_of(frame.graph.roots.begin(), frame.graph.roots.end(), [&](const Root& other) {
                return other.kind == RootKind::Exported && other.resource == root.resource;
            });
        Scope scope;
        VkImageLayout layout = root.layout;
        switch (root.kind) {
            case RootKind::Presented:
                if (isExportedToo) continue;
                scope = {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT};
                break;
            case RootKind::Exported:
                scope = {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, kAnything};
                break;
            case RootKind::HostRead:
                scope = {VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT};
                break;
        }
        const std::string who = Text("the end ({})", resource.name);
        for (uint32_t place = 0; place < frame.PlaceCount(root.resource); ++place) {
            if (resource.kind == ResourceKind::Texture &&
                ImageOf(frame, root.resource, place).layout != layout)
                frame.Note(who + " finds another layout");
            for (Segment* segment : Segments(frame, root.resource, place))
                frame.Note(root.kind == RootKind::Exported ? segment->memory.Write(scope, who)
                                                           : segment->memory.Read(scope, who));
        }
    }
    // A frame has to start from what the frame before left, and an import is in the layout that its state
    // says.
    for (uint32_t r = 0; r < frame.spans.size(); ++r)
        for (uint32_t place = 0; place < frame.PlaceCount(r); ++place) {
            const GraphResource& resource = frame.Resource(r);
            const bool isAlways =
                resource.persistence == Persistence::Always || frame.needsLastFrame.contains({r, place});
            if (resource.origin == Origin::Persistent && isAlways && !HasNewest(frame, r, place))
                frame.Note(Text("the next frame does not find the newest {}", resource.name));
            if (resource.origin != Origin::Transient && frame.spans[r].IsUsed() &&
                ImageOf(frame, r, place).queueFamily != VK_QUEUE_FAMILY_IGNORED)
                frame.Note(Text("the next frame finds {} with another queue family", resource.name));
            if (resource.origin == Origin::Imported && resource.kind == ResourceKind::Texture &&
                ImageOf(frame, r, place).layout != frame.plan.states[r].layout)
                frame.Note(Text("the owner of {} finds another layout", resource.name));
        }
}

void Oracle::OwnerUses(const std::string& name, const Scope& scope, VkImageLayout layout) {
    Object& object = m_objects[name];
    for (Image& image : object.images) image.layout = layout;
    for (Segment& segment : object.segments) {
        segment.memory = {};
        std::ignore = segment.memory.Write(scope, "its owner");
        segment.contents = ++m_lastContents;
    }
}

void Oracle::OwnerSignals(const std::string& name, VkPipelineStageFlags2 waitStages, VkImageLayout layout,
                          uint32_t queueFamily) {
    Object& object = m_objects[name];
    for (Image& image : object.images) image = {.layout = layout, .queueFamily = queueFamily};
    for (Segment& segment : object.segments) {
        segment.memory.HandedOver(waitStages, "its owner");
        segment.contents = ++m_lastContents;
    }
}

}  // namespace raygraph::oracle
