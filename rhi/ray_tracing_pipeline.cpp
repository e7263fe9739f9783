#include "rhi/ray_tracing_pipeline.h"

#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "rhi/device.h"
#include "rhi/stage_set.h"

namespace raygraph::rhi {
namespace {

std::vector<ShaderStage> StagesOf(const RayTracingPipelineDesc& desc) {
    std::vector<ShaderStage> stages{desc.rayGen.stage};
    for (const GeneralShader& miss : desc.miss) stages.push_back(miss.stage);
    for (const HitGroupSet& set : desc.hitSets)
        for (const HitGroup& group : set)
            stages.insert(stages.end(), {group.closestHit, group.anyHit, group.intersection});
    for (const GeneralShader& callable : desc.callables) stages.push_back(callable.stage);
    return stages;
}

// The shader groups in the order of their numbers: ray generation, misses, hit sets, callables.
class GroupList {
  public:
    GroupList(StageSet& stages, const DeviceInfo& info)
        : m_stages(stages), m_needsOwnIntersections(info.isLavapipe) {}

    void AddGeneral(const ShaderStage& shader, StageKind kind) {
        if (shader.IsEmpty()) return;
        VkRayTracingShaderGroupCreateInfoKHR group = Unused(VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR);
        group.generalShader = m_stages.Add(shader, kind);
        m_groups.push_back(group);
    }

    // A group without any shader is legal: VK_SHADER_UNUSED_KHR throughout.
    void AddHit(const HitGroup& hit) {
        VkRayTracingShaderGroupCreateInfoKHR group =
            Unused(hit.intersection.IsEmpty() ? VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR
                                              : VK_RAY_TRACING_SHADER_GROUP_TYPE_PROCEDURAL_HIT_GROUP_KHR);
        group.closestHitShader = m_stages.AddIfPresent(hit.closestHit, StageKind::ClosestHit);
        group.anyHitShader = m_stages.AddIfPresent(hit.anyHit, StageKind::AnyHit);
        // Mesa's CPU driver (25.0) compiles an intersection stage once, with the any-hit shader of the first
        // group that has it, and runs that one for all groups: each any-hit shader gets a stage of its own.
        const uint32_t partner = m_needsOwnIntersections ? group.anyHitShader : VK_SHADER_UNUSED_KHR;
        group.intersectionShader = m_stages.AddIfPresent(hit.intersection, StageKind::Intersection, partner);
        m_groups.push_back(group);
    }

    const std::vector<VkRayTracingShaderGroupCreateInfoKHR>& Groups() const { return m_groups; }

  private:
    static VkRayTracingShaderGroupCreateInfoKHR Unused(VkRayTracingShaderGroupTypeKHR type) {
        VkRayTracingShaderGroupCreateInfoKHR group{};
        group.sType = VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR;
        group.type = type;
        group.generalShader = VK_SHADER_UNUSED_KHR;
        group.closestHitShader = VK_SHADER_UNUSED_KHR;
        group.anyHitShader = VK_SHADER_UNUSED_KHR;
        group.intersectionShader = VK_SHADER_UNUSED_KHR;
        return group;
    }

    StageSet& m_stages;
    bool m_needsOwnIntersections;
    std::vector<VkRayTracingShaderGroupCreateInfoKHR> m_groups;
};

uint32_t DataBytes(const std::vector<std::byte>& data) {
    return static_cast<uint32_t>(data.size());
}

// Writes records one after another, taking the handles in the order of the groups.
class TableWriter {
  public:
    TableWriter(std::byte* table, std::span<const std::byte> handles, size_t handleSize)
        : m_table(table), m_handles(handles), m_handleSize(handleSize) {}

    // Without a group the handle stays zero, which means "no shader" to the device.
    void Write(const TableRegion& region, uint32_t record, bool hasGroup,
               const std::vector<std::byte>& data) {
        std::byte* target = m_table + region.RecordOffset(record);
        std::memset(target, 0, region.stride);
        if (hasGroup) {
            RG_CHECK_GE(m_handles.size(), m_handleSize);
            std::memcpy(target, m_handles.data(), m_handleSize);
            m_handles = m_handles.subspan(m_handleSize);
        }
        if (!data.empty()) std::memcpy(target + m_handleSize, data.data(), data.size());
    }

  private:
    std::byte* m_table;
    std::span<const std::byte> m_handles;  // handles that are not written yet
    size_t m_handleSize;
};

TableLayout LayOut(const Device& device, const RayTracingPipelineDesc& desc) {
    std::vector<uint32_t> miss, hit, callable;
    for (const GeneralShader& shader : desc.miss) miss.push_back(DataBytes(shader.recordData));
    for (const HitGroupSet& set : desc.hitSets)
        for (const HitGroup& group : set) hit.push_back(DataBytes(group.recordData));
    for (const GeneralShader& shader : desc.callables) callable.push_back(DataBytes(shader.recordData));
    const DeviceInfo& info = device.Info();
    const TableProperties properties{info.shaderGroupHandleSize, info.shaderGroupHandleAlignment,
                                     info.shaderGroupBaseAlignment, info.maxShaderGroupStride};
    try {
        return LayOutTable(properties, {DataBytes(desc.rayGen.recordData), miss, hit, callable});
    } catch (const Error& error) {
        throw MakeError(error.Kind(), "{}: {}", desc.name, error.what());
    }
}

void CheckDesc(const Device& device, const RayTracingPipelineDesc& desc) {
    if (desc.rayGen.stage.IsEmpty())
        throw MakeError(ErrorKind::Usage, "{}: has no ray-generation shader", desc.name);
    for (const GeneralShader& callable : desc.callables)
        if (callable.stage.IsEmpty())
            throw MakeError(ErrorKind::Usage, "{}: has an empty callable shader", desc.name);
    const uint32_t most = device.Info().maxRayRecursionDepth;
    if (desc.maxRecursion > most)
        throw MakeError(ErrorKind::Usage, "{}: maxRecursion {} exceeds the device's {}", desc.name,
                        desc.maxRecursion, most);
}

}  // namespace

RayTracingPipeline::RayTracingPipeline(Device& device, const RayTracingPipelineDesc& desc)
    : Pipeline(device, desc.name, StagesOf(desc)), m_tableLayout(LayOut(device, desc)) {
    StageSet stages(device, m_name, m_interface, desc.specialization);
    GroupList groups(stages, device.Info());
    groups.AddGeneral(desc.rayGen.stage, StageKind::RayGen);
    for (const GeneralShader& miss : desc.miss) groups.AddGeneral(miss.stage, StageKind::Miss);
    for (const HitGroupSet& set : desc.hitSets)
        for (const HitGroup& group : set) groups.AddHit(group);
    for (const GeneralShader& callable : desc.callables)
        groups.AddGeneral(callable.stage, StageKind::Callable);

    VkRayTracingPipelineCreateInfoKHR create{};
    create.sType = VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR;
    create.stageCount = static_cast<uint32_t>(stages.Infos().size());
    create.pStages = stages.Infos().data();
    create.groupCount = static_cast<uint32_t>(groups.Groups().size());
    create.pGroups = groups.Groups().data();
    create.maxPipelineRayRecursionDepth = desc.maxRecursion;
    create.layout = m_layout;
    create.flags = device.PipelineFlags();
    const Stopwatch stopwatch;
    device.Check(
        device.Vk().vkCreateRayTracingPipelinesKHR(device.Handle(), VK_NULL_HANDLE, device.PipelineCache(), 1,
                                                   &create, device.AllocationCallbacks(), &m_pipeline),
        m_name + ": vkCreateRayTracingPipelinesKHR");
    m_creationMs = stopwatch.Milliseconds();
    device.SetName(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<uint64_t>(m_pipeline), m_name);
    CreateTable(desc, create.groupCount);
}

void RayTracingPipeline::CreateTable(const RayTracingPipelineDesc& desc, uint32_t groupCount) {
    const DeviceInfo& info = m_device->Info();
    const size_t handleSize = info.shaderGroupHandleSize;
    std::vector<std::byte> handles(groupCount * handleSize);
    m_device->Check(m_device->Vk().vkGetRayTracingShaderGroupHandlesKHR(
                        m_device->Handle(), m_pipeline, 0, groupCount, handles.size(), handles.data()),
                    m_name + ": vkGetRayTracingShaderGroupHandlesKHR");

    // The address of a buffer may be less aligned than the table must be: there is room to move the start.
    const uint64_t alignment = info.shaderGroupBaseAlignment;
    m_table = m_device->CreateBuffer({.name = m_name + " table",
                                      .size = m_tableLayout.size + alignment,
                                      .usage = BufferUsage::ShaderBindingTable,
                                      .memory = MemoryKind::Upload});
    const VkDeviceAddress start = AlignUp(m_table.Address(), alignment);
    TableWriter writer(m_table.Mapped().data() + (start - m_table.Address()), handles, handleSize);
    writer.Write(m_tableLayout.rayGen, 0, true, desc.rayGen.recordData);
    for (uint32_t i = 0; i < desc.miss.size(); ++i)
        writer.Write(m_tableLayout.miss, i, !desc.miss[i].stage.IsEmpty(), desc.miss[i].recordData);
    uint32_t record = 0;
    for (const HitGroupSet& set : desc.hitSets)
        for (const HitGroup& group : set) writer.Write(m_tableLayout.hit, record++, true, group.recordData);
    for (uint32_t i = 0; i < desc.callables.size(); ++i)
        writer.Write(m_tableLayout.callable, i, true, desc.callables[i].recordData);

    const std::array<const TableRegion*, 4> regions{&m_tableLayout.rayGen, &m_tableLayout.miss,
                                                    &m_tableLayout.hit, &m_tableLayout.callable};
    for (size_t i = 0; i < regions.size(); ++i)
        if (regions[i]->recordCount > 0)
            m_regions[i] = {start + regions[i]->offset, regions[i]->stride, regions[i]->size};
    RG_CHECK_EQ(RayGenRegion().size, RayGenRegion().stride);
}

RayTracingPipeline CreateRayTracingPipeline(Device& device, const RayTracingPipelineDesc& desc) {
    CheckDesc(device, desc);
    RayTracingPipelineDesc whole = desc;
    // An instance needs a record for its hits, even if that runs nothing.
    if (whole.hitSets.empty()) whole.hitSets.emplace_back();
    size_t rayTypeCount = std::max<size_t>(1, whole.miss.size());
    for (const HitGroupSet& set : whole.hitSets) rayTypeCount = std::max(rayTypeCount, set.size());
    whole.miss.resize(rayTypeCount);
    for (HitGroupSet& set : whole.hitSets) set.resize(rayTypeCount);
    return {device, whole};
}

}  // namespace raygraph::rhi
