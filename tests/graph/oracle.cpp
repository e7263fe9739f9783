#include "tests/graph/oracle.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "tests/graph/access_table.h"

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
    std::vector<Span> spans;                                       // by resource
    std::map<std::pair<uint32_t, uint32_t>, uint64_t> contentsOf;  // by resource and version
    std::map<uint32_t, Object> passing;                            // objects of this frame alone
    std::map<uint32_t, Image> images;                              // of transients
    std::vector<uint8_t> needsLastFrame;                           // by resource: its old contents are used

    const GraphResource& Resource(uint32_t r) const { return graph.resources[r]; }
    void Note(const std::string& line) {
        if (!line.empty()) wrong.push_back(line);
    }
    bool IsShared(uint32_t r) const {
        return Resource(r).origin == Origin::Transient && plan.lifetimes[r].block != kNone;
    }
};

std::vector<Oracle::Segment>& Oracle::AllSegments(Frame& frame, uint32_t r) {
    if (frame.IsShared(r)) return m_blocks[frame.plan.lifetimes[r].block];
    if (frame.Resource(r).origin == Origin::Transient) return frame.passing[r].segments;
    return m_objects[frame.Resource(r).name].segments;
}

// Those that the resource itself covers: it lies at the start of its block.
std::vector<Oracle::Segment*> Oracle::Segments(Frame& frame, uint32_t r) {
    std::vector<Segment*> own;
    for (Segment& segment : AllSegments(frame, r))
        if (!frame.IsShared(r) || segment.end <= frame.Resource(r).memory.size) own.push_back(&segment);
    return own;
}

Oracle::Image& Oracle::ImageOf(Frame& frame, uint32_t r) {
    if (frame.Resource(r).origin == Origin::Transient) return frame.images[r];
    return m_objects[frame.Resource(r).name].image;
}

std::vector<std::string> Oracle::Judge(const FrameGraph& graph, const Plan& plan) {
    Frame frame{.graph = graph, .plan = plan};
    frame.spans.resize(graph.resources.size());
    frame.needsLastFrame.resize(graph.resources.size());
    uint32_t position = 0, next = 0;
    for (const PlannedPass& planned : plan.passes) {
        if (planned.pass < next) frame.Note("passes are not executed in the order of their declaration");
        next = planned.pass + 1;
        const GraphPass& pass = graph.passes[planned.pass];
        for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u) {
            Span& span = frame.spans[graph.uses[u].resource];
            span.first = std::min(span.first, position);
            span.last = position;
        }
        ++position;
    }
    for (const Root& root : graph.roots)
        if (frame.spans[root.resource].IsUsed()) frame.spans[root.resource].last = position;
    JudgeSharing(frame);
    PlaceTransients(frame);
    for (uint32_t r = 0; r < graph.resources.size(); ++r)
        if (graph.resources[r].origin != Origin::Transient)
            frame.contentsOf[{r, 0}] = AllSegments(frame, r).front().contents;

    JudgeBarriers(frame, plan.acquire, "the first pass");
    for (const PlannedPass& planned : plan.passes) {
        JudgeBarriers(frame, planned.barriers, graph.passes[planned.pass].name);
        JudgePass(frame, planned);
    }
    JudgeBarriers(frame, plan.finish, "the end");
    JudgeEnd(frame);
    JudgeBarriers(frame, plan.release, "the release");
    for (const Root& root : graph.roots)
        if (root.kind == RootKind::Exported && root.queueFamily != graph.queueFamily &&
            ImageOf(frame, root.resource).queueFamily != root.queueFamily)
            frame.Note(graph.resources[root.resource].name + " is not released to its owner's queue family");
    return std::move(frame.wrong);
}

void Oracle::JudgeSharing(Frame& frame) {
    for (uint32_t a = 0; a < frame.spans.size(); ++a) {
        if (!frame.IsShared(a) || !frame.spans[a].IsUsed()) continue;
        const rhi::MemoryRequirements& needs = frame.Resource(a).memory;
        const rhi::MemoryRequirements& block = frame.plan.blocks[frame.plan.lifetimes[a].block];
        if (needs.size > block.size || needs.alignment > block.alignment || block.memoryTypeBits == 0 ||
            (block.memoryTypeBits & ~needs.memoryTypeBits) != 0)
            frame.Note(frame.Resource(a).name + " does not fit its block");
        for (uint32_t b = 0; b < a; ++b)
            if (frame.IsShared(b) && frame.spans[b].IsUsed() &&
                frame.plan.lifetimes[a].block == frame.plan.lifetimes[b].block &&
                frame.spans[a].first <= frame.spans[b].last && frame.spans[b].first <= frame.spans[a].last)
                frame.Note(frame.Resource(a).name + " and " + frame.Resource(b).name +
                           " share memory and live at one time");
    }
}

// Cuts the blocks where a resource of this frame ends.
void Oracle::PlaceTransients(Frame& frame) {
    if (m_blocks.size() < frame.plan.blocks.size()) m_blocks.resize(frame.plan.blocks.size());
    for (uint32_t r = 0; r < frame.spans.size(); ++r) {
        if (!frame.IsShared(r)) continue;
        std::vector<Segment>& segments = m_blocks[frame.plan.lifetimes[r].block];
        const uint64_t end = frame.Resource(r).memory.size;
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

void Oracle::JudgeBarriers(Frame& frame, const BarrierRange& range, const std::string& before) {
    for (uint32_t b = range.first; b < range.first + range.count; ++b)
        JudgeBarrier(frame, frame.plan.barriers[b], before);
}

void Oracle::JudgeBarrier(Frame& frame, const PlannedBarrier& barrier, const std::string& before) {
    const uint32_t r = barrier.resource;
    const Dependency& dependency = barrier.dependency;
    const Scope src{dependency.srcStages, dependency.srcAccess};
    const Scope dst{dependency.dstStages, dependency.dstAccess};
    const std::string who = "the transition of " + frame.Resource(r).name + " before " + before;
    const bool isTexture = frame.Resource(r).kind == ResourceKind::Texture;
    const bool changesOwner = barrier.srcQueueFamily != barrier.dstQueueFamily;
    Image& image = ImageOf(frame, r);
    const bool dropsContents = isTexture && dependency.oldLayout == VK_IMAGE_LAYOUT_UNDEFINED &&
                               dependency.newLayout != VK_IMAGE_LAYOUT_UNDEFINED;
    if (isTexture && dependency.oldLayout != VK_IMAGE_LAYOUT_UNDEFINED &&
        dependency.oldLayout != image.layout)
        frame.Note(who + " starts from another layout than the texture has");
    const bool isTransition = changesOwner || dropsContents || dependency.oldLayout != dependency.newLayout;
    // Any barrier orders the work in all of the block. What it makes available and visible is the resource
    // alone, unless it hands the block over, by a memory barrier if there is something to make available.
    const bool isHandOver = barrier.predecessor != kNone || barrier.followsLastFrame;
    std::vector<Segment*> own = Segments(frame, r);
    for (Segment& segment : AllSegments(frame, r)) {
        const bool isOwn = std::find(own.begin(), own.end(), &segment) != own.end();
        if (isOwn && isTransition) {
            frame.Note(segment.memory.Transition(src, dst, who));
            if (dropsContents && image.layout != VK_IMAGE_LAYOUT_UNDEFINED)
                segment.contents = ++m_lastContents;
        } else if (isOwn || (isHandOver && (!isTexture || src.access != VK_ACCESS_2_NONE))) {
            segment.memory.Barrier(src, dst);
        } else {
            segment.memory.Barrier({src.stages, VK_ACCESS_2_NONE}, {dst.stages, VK_ACCESS_2_NONE});
        }
    }
    if (isTexture) image.layout = dependency.newLayout;
    if (!changesOwner) return;
    const auto otherFamily = [&](uint32_t family) {
        return family == frame.graph.queueFamily ? VK_QUEUE_FAMILY_IGNORED : family;
    };
    if (image.queueFamily != otherFamily(barrier.srcQueueFamily))
        frame.Note(who + " takes it from a queue family that does not have it");
    image.queueFamily = otherFamily(barrier.dstQueueFamily);
}

void Oracle::JudgePass(Frame& frame, const PlannedPass& planned) {
    const GraphPass& pass = frame.graph.passes[planned.pass];
    std::set<uint32_t> seen;
    for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u)
        if (frame.Resource(frame.graph.uses[u].resource).kind != ResourceKind::TextureSet &&
            seen.insert(frame.graph.uses[u].resource).second)
            JudgeAccess(frame, pass, u);
}

// All that the pass does with the resource of its use `first`; within the pass, its body sees to the order.
void Oracle::JudgeAccess(Frame& frame, const GraphPass& pass, uint32_t first) {
    const uint32_t r = frame.graph.uses[first].resource;
    const GraphResource& resource = frame.Resource(r);
    const std::string who = pass.name + " (" + resource.name + ")";
    Scope scope;
    bool writes = false, needsContents = false;
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
    uint32_t version = 0;
    for (uint32_t u = first; u < pass.firstUse + pass.useCount; ++u) {
        const ResourceUse& use = frame.graph.uses[u];
        if (use.resource != r) continue;
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
    const uint32_t versionIn = frame.graph.uses[first].versionIn;
    Image& image = ImageOf(frame, r);
    if (resource.kind == ResourceKind::Texture && image.layout != layout)
        frame.Note(who + " finds another layout");
    if (image.queueFamily != VK_QUEUE_FAMILY_IGNORED) frame.Note(who + " finds it with another queue family");

    const bool isNew = versionIn == 0 && resource.origin == Origin::Transient;
    if (needsContents && !isNew) {
        const auto expected = frame.contentsOf.find({r, versionIn});
        if (expected == frame.contentsOf.end())
            frame.Note(who + " needs what no executed pass wrote");
        else
            for (const Segment* segment : Segments(frame, r))
                if (segment->contents != expected->second) frame.Note(who + " finds other contents");
    }
    if (needsContents && versionIn == 0) frame.needsLastFrame[r] = 1;
    const uint64_t contents = writes ? ++m_lastContents : 0;
    for (Segment* segment : Segments(frame, r)) {
        frame.Note(writes ? segment->memory.Write(scope, who) : segment->memory.Read(scope, who));
        if (writes) segment->contents = contents;
    }
    if (writes) frame.contentsOf[{r, version}] = contents;
}

void Oracle::JudgeEnd(Frame& frame) {
    const auto isNewest = [&](uint32_t r) {
        const auto newest = frame.contentsOf.find({r, frame.Resource(r).version});
        return newest != frame.contentsOf.end() && AllSegments(frame, r).front().contents == newest->second;
    };
    for (const Root& root : frame.graph.roots) {
        const GraphResource& resource = frame.Resource(root.resource);
        if (!isNewest(root.resource)) frame.Note("the end does not find the newest " + resource.name);
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
        const std::string who = "the end (" + resource.name + ")";
        if (resource.kind == ResourceKind::Texture && ImageOf(frame, root.resource).layout != layout)
            frame.Note(who + " finds another layout");
        for (Segment* segment : Segments(frame, root.resource)) {
            frame.Note(root.kind == RootKind::Exported ? segment->memory.Write(scope, who)
                                                       : segment->memory.Read(scope, who));
        }
    }
    // What a frame starts from has to be what the frame before left.
    for (uint32_t r = 0; r < frame.spans.size(); ++r) {
        const GraphResource& resource = frame.Resource(r);
        const bool isAlways = resource.persistence == Persistence::Always || frame.needsLastFrame[r] != 0;
        if (resource.origin == Origin::Persistent && isAlways && !isNewest(r))
            frame.Note("the next frame does not find the newest " + resource.name);
    }
}

void Oracle::OwnerUses(const std::string& name, const Scope& scope, VkImageLayout layout) {
    Object& object = m_objects[name];
    object.image.layout = layout;
    Segment& segment = object.segments.front();
    segment.memory = {};
    std::ignore = segment.memory.Write(scope, "its owner");
    segment.contents = ++m_lastContents;
}

void Oracle::OwnerSignals(const std::string& name, VkPipelineStageFlags2 waitStages, VkImageLayout layout,
                          uint32_t queueFamily) {
    Object& object = m_objects[name];
    object.image = {.layout = layout, .queueFamily = queueFamily};
    Segment& segment = object.segments.front();
    segment.memory.HandedOver(waitStages, "its owner");
    segment.contents = ++m_lastContents;
}

}  // namespace raygraph::oracle
