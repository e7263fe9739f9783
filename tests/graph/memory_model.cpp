#include "tests/graph/memory_model.h"

#include <stdexcept>

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

template <typename Run>
void ForEachStage(VkPipelineStageFlags2 stages, Run&& run) {
    for (size_t s = 0; s < kStages.size(); ++s)
        if ((stages & kStages[s]) != 0) run(s);
}

}  // namespace

VkPipelineStageFlags2 Expand(VkPipelineStageFlags2 stages) {
    VkPipelineStageFlags2 all = 0;
    for (const VkPipelineStageFlags2 stage : kStages) all |= stage;
    if ((stages & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT) != 0)
        stages = (stages & ~VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT) | (all & ~VK_PIPELINE_STAGE_2_HOST_BIT);
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
    ForEachStage(scope.stages, [&](size_t s) { event.parts.push_back({.stage = kStages[s]}); });
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
                if ((part.happensBefore & kStages[s]) == 0)
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
