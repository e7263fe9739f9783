#include "rhi/pipeline.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>
#include <vector>

#include "base/check.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "rhi/device.h"
#include "rhi/stage_set.h"

namespace raygraph::rhi {
namespace {

ShaderInterface InterfaceOf(const std::string& pipeline, std::span<const ShaderStage> stages) {
    std::vector<NamedReflection> reflections;
    for (const ShaderStage& stage : stages)
        if (!stage.IsEmpty()) reflections.push_back({stage.name, ReflectionOf(stage)});
    try {
        return MergeInterface(reflections);
    } catch (const Error& error) {
        throw MakeError(error.Kind(), "{}: {}", pipeline, error.what());
    }
}

VkDescriptorSetLayout CreatePassSetLayout(Device& device, const std::string& pipeline,
                                          const ShaderInterface& interface) {
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    uint32_t descriptorCount = 0;
    for (const BindingInfo& info : interface.bindings) {
        // The reflection lists each address of a table and each element of an array; either is one binding.
        if (!bindings.empty() && bindings.back().binding == info.binding) {
            bindings.back().stageFlags |= info.stages;
            continue;
        }
        VkDescriptorSetLayoutBinding binding{};
        binding.binding = info.binding;
        binding.descriptorType = ToVk(info.kind);
        binding.descriptorCount = info.count;
        binding.stageFlags = info.stages;
        bindings.push_back(binding);
        descriptorCount += info.count;
    }
    if (descriptorCount > device.Info().maxPushDescriptors)
        throw MakeError(ErrorKind::Usage, "{}: binds {} descriptors in set 0, maxPushDescriptors is {}",
                        pipeline, descriptorCount, device.Info().maxPushDescriptors);
    VkDescriptorSetLayoutCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    create.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR;
    create.bindingCount = static_cast<uint32_t>(bindings.size());
    create.pBindings = bindings.data();
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    device.Check(device.Vk().vkCreateDescriptorSetLayout(device.Handle(), &create,
                                                         device.AllocationCallbacks(), &layout),
                 pipeline + ": vkCreateDescriptorSetLayout");
    return layout;
}

}  // namespace

Pipeline::Pipeline(Device& device, std::string name, std::span<const ShaderStage> stages)
    : m_device(&device), m_name(std::move(name)), m_interface(InterfaceOf(m_name, stages)) {
    const uint32_t pushBytes = m_interface.pushConstants.bytes;
    if (pushBytes > device.Info().maxPushConstantBytes)
        throw MakeError(ErrorKind::Usage, "{}: {} has {} bytes of push constants, maxPushConstantsSize is {}",
                        m_name, m_interface.pushConstantShader, pushBytes,
                        device.Info().maxPushConstantBytes);
    m_setLayout = CreatePassSetLayout(device, m_name, m_interface);

    std::vector<VkDescriptorSetLayout> sets{m_setLayout};
    const VkPushConstantRange range{m_interface.stages, 0, pushBytes};
    VkPipelineLayoutCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    try {
        if (m_interface.usesTextureTable) sets.push_back(device.TextureTableLayout());
        create.setLayoutCount = static_cast<uint32_t>(sets.size());
        create.pSetLayouts = sets.data();
        create.pushConstantRangeCount = pushBytes > 0 ? 1 : 0;
        create.pPushConstantRanges = &range;
        VkPipelineLayout layout = VK_NULL_HANDLE;
        device.Check(device.Vk().vkCreatePipelineLayout(device.Handle(), &create,
                                                        device.AllocationCallbacks(), &layout),
                     m_name + ": vkCreatePipelineLayout");
        m_layout = layout;
    } catch (...) {
        Release();
        throw;
    }
    device.SetName(VK_OBJECT_TYPE_PIPELINE_LAYOUT, reinterpret_cast<uint64_t>(m_layout), m_name);
}

Pipeline& Pipeline::operator=(Pipeline&& other) noexcept {
    if (this == &other) return *this;
    Release();
    m_device = std::exchange(other.m_device, nullptr);
    m_name = std::move(other.m_name);
    m_interface = std::move(other.m_interface);
    m_pipeline = std::exchange(other.m_pipeline, VK_NULL_HANDLE);
    m_layout = std::exchange(other.m_layout, VK_NULL_HANDLE);
    m_setLayout = std::exchange(other.m_setLayout, VK_NULL_HANDLE);
    m_creationMs = other.m_creationMs;
    return *this;
}

Pipeline::~Pipeline() {
    Release();
}

void Pipeline::Release() noexcept {
    if (!m_device) return;
    m_device->Retire([device = m_device, pipeline = m_pipeline, layout = m_layout, setLayout = m_setLayout] {
        const DeviceFunctions& vk = device->Vk();
        vk.vkDestroyPipeline(device->Handle(), pipeline, device->AllocationCallbacks());
        vk.vkDestroyPipelineLayout(device->Handle(), layout, device->AllocationCallbacks());
        vk.vkDestroyDescriptorSetLayout(device->Handle(), setLayout, device->AllocationCallbacks());
    });
    m_device = nullptr;
}

ComputePipeline::ComputePipeline(Device& device, const ComputePipelineDesc& desc)
    : Pipeline(device, desc.name, std::span(&desc.shader, 1)) {
    StageSet stages(device, m_name, m_interface, desc.specialization);
    stages.Add(desc.shader, StageKind::Compute);

    const ShaderReflection reflection = ReflectionOf(desc.shader);
    m_workgroupSize = reflection.workgroupSize;
    for (const SpecializationValue& value : desc.specialization)
        for (size_t axis = 0; axis < m_workgroupSize.size(); ++axis)
            if (reflection.workgroupSizeIds[axis] == value.id) m_workgroupSize[axis] = value.value;

    VkComputePipelineCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
    create.stage = stages.Infos()[0];
    create.layout = m_layout;
    // For CommandList::SetPortion. Pipelines that are never divided have the flag, too: NVIDIA's driver 580
    // takes one without it from its cache for one with it, whose dispatches then ignore their base.
    create.flags = device.PipelineFlags() | VK_PIPELINE_CREATE_DISPATCH_BASE_BIT;
    const Stopwatch stopwatch;
    device.Check(device.Vk().vkCreateComputePipelines(device.Handle(), device.PipelineCache(), 1, &create,
                                                      device.AllocationCallbacks(), &m_pipeline),
                 m_name + ": vkCreateComputePipelines");
    m_creationMs = stopwatch.Milliseconds();
    device.SetName(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<uint64_t>(m_pipeline), m_name);
}

ComputePipeline CreateComputePipeline(Device& device, const ComputePipelineDesc& desc) {
    if (desc.shader.IsEmpty()) throw MakeError(ErrorKind::Usage, "{}: has no compute shader", desc.name);
    return {device, desc};
}

// --- Raster pipelines ---

namespace {

VkPrimitiveTopology ToVk(Topology topology) {
    switch (topology) {
        case Topology::TriangleList:
            return VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
        case Topology::TriangleStrip:
            return VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
        case Topology::LineList:
            return VK_PRIMITIVE_TOPOLOGY_LINE_LIST;
        case Topology::PointList:
            return VK_PRIMITIVE_TOPOLOGY_POINT_LIST;
    }
    return VK_PRIMITIVE_TOPOLOGY_MAX_ENUM;
}

VkCullModeFlags ToVk(CullMode cull) {
    switch (cull) {
        case CullMode::None:
            return VK_CULL_MODE_NONE;
        case CullMode::Front:
            return VK_CULL_MODE_FRONT_BIT;
        case CullMode::Back:
            return VK_CULL_MODE_BACK_BIT;
    }
    return VK_CULL_MODE_NONE;
}

VkCompareOp ToVk(DepthCompare compare) {
    switch (compare) {
        case DepthCompare::Always:
            return VK_COMPARE_OP_ALWAYS;
        case DepthCompare::Less:
            return VK_COMPARE_OP_LESS;
        case DepthCompare::LessOrEqual:
            return VK_COMPARE_OP_LESS_OR_EQUAL;
        case DepthCompare::Equal:
            return VK_COMPARE_OP_EQUAL;
        case DepthCompare::Greater:
            return VK_COMPARE_OP_GREATER;
        case DepthCompare::GreaterOrEqual:
            return VK_COMPARE_OP_GREATER_OR_EQUAL;
    }
    return VK_COMPARE_OP_ALWAYS;
}

VkPipelineColorBlendAttachmentState ToVk(BlendMode blend) {
    VkPipelineColorBlendAttachmentState state{};
    state.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT |
                           VK_COLOR_COMPONENT_A_BIT;
    state.blendEnable = blend != BlendMode::Off;
    const bool isAdditive = blend == BlendMode::Additive;
    state.srcColorBlendFactor = blend == BlendMode::Alpha ? VK_BLEND_FACTOR_SRC_ALPHA : VK_BLEND_FACTOR_ONE;
    state.dstColorBlendFactor = isAdditive ? VK_BLEND_FACTOR_ONE : VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
    state.colorBlendOp = VK_BLEND_OP_ADD;
    state.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
    state.dstAlphaBlendFactor = state.dstColorBlendFactor;
    state.alphaBlendOp = VK_BLEND_OP_ADD;
    return state;
}

void CheckDesc(const Device& device, const RasterPipelineDesc& desc) {
    auto fail = [&](const std::string& what) {
        throw MakeError(ErrorKind::Usage, "{}: {}", desc.name, what);
    };
    if (desc.vertex.IsEmpty()) fail("has no vertex shader");
    if (desc.colorFormats.empty() && desc.depthFormat == Format::Undefined)
        fail("has neither color nor depth target");
    for (Format format : desc.colorFormats)
        if (format == Format::Undefined || IsDepth(format))
            fail(std::string("has a color target of ") + Name(format));
    if (desc.depthFormat != Format::Undefined && !IsDepth(desc.depthFormat))
        fail(std::string("has a depth target of ") + Name(desc.depthFormat));
    if (desc.isWireframe && !device.Info().optional.wireframe)
        fail("is wireframe, the device lacks fillModeNonSolid");
}

}  // namespace

RasterPipeline::RasterPipeline(Device& device, const RasterPipelineDesc& desc)
    : Pipeline(device, desc.name, std::array{desc.vertex, desc.fragment}) {
    StageSet stages(device, m_name, m_interface, desc.specialization);
    stages.Add(desc.vertex, StageKind::Vertex);
    stages.AddIfPresent(desc.fragment, StageKind::Fragment);

    VkPipelineVertexInputStateCreateInfo vertexInput{};
    vertexInput.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO;

    VkPipelineInputAssemblyStateCreateInfo assembly{};
    assembly.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO;
    assembly.topology = ToVk(desc.topology);

    VkPipelineViewportStateCreateInfo viewport{};
    viewport.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO;
    viewport.viewportCount = 1;
    viewport.scissorCount = 1;

    VkPipelineRasterizationStateCreateInfo raster{};
    raster.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO;
    raster.polygonMode = desc.isWireframe ? VK_POLYGON_MODE_LINE : VK_POLYGON_MODE_FILL;
    raster.cullMode = ToVk(desc.cull);
    raster.frontFace = desc.isFrontClockwise ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE;
    raster.lineWidth = 1.0f;

    VkPipelineMultisampleStateCreateInfo multisample{};
    multisample.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO;
    multisample.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;

    VkPipelineDepthStencilStateCreateInfo depth{};
    depth.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO;
    depth.depthTestEnable = desc.depthFormat != Format::Undefined;
    depth.depthWriteEnable = desc.depthFormat != Format::Undefined && desc.writesDepth;
    depth.depthCompareOp = ToVk(desc.depthCompare);
    depth.maxDepthBounds = 1.0f;

    const std::vector<VkPipelineColorBlendAttachmentState> targets(desc.colorFormats.size(),
                                                                   ToVk(desc.blend));
    VkPipelineColorBlendStateCreateInfo blend{};
    blend.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO;
    blend.attachmentCount = static_cast<uint32_t>(targets.size());
    blend.pAttachments = targets.data();

    constexpr std::array kDynamicStates{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic{};
    dynamic.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO;
    dynamic.dynamicStateCount = static_cast<uint32_t>(kDynamicStates.size());
    dynamic.pDynamicStates = kDynamicStates.data();

    std::vector<VkFormat> colorFormats;
    for (Format format : desc.colorFormats) colorFormats.push_back(rhi::ToVk(format));
    VkPipelineRenderingCreateInfo rendering{};
    rendering.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO;
    rendering.colorAttachmentCount = static_cast<uint32_t>(colorFormats.size());
    rendering.pColorAttachmentFormats = colorFormats.data();
    rendering.depthAttachmentFormat = rhi::ToVk(desc.depthFormat);

    VkGraphicsPipelineCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO;
    create.pNext = &rendering;
    create.stageCount = static_cast<uint32_t>(stages.Infos().size());
    create.pStages = stages.Infos().data();
    create.pVertexInputState = &vertexInput;
    create.pInputAssemblyState = &assembly;
    create.pViewportState = &viewport;
    create.pRasterizationState = &raster;
    create.pMultisampleState = &multisample;
    create.pDepthStencilState = &depth;
    create.pColorBlendState = &blend;
    create.pDynamicState = &dynamic;
    create.layout = m_layout;
    create.flags = device.PipelineFlags();
    const Stopwatch stopwatch;
    device.Check(device.Vk().vkCreateGraphicsPipelines(device.Handle(), device.PipelineCache(), 1, &create,
                                                       device.AllocationCallbacks(), &m_pipeline),
                 m_name + ": vkCreateGraphicsPipelines");
    m_creationMs = stopwatch.Milliseconds();
    device.SetName(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<uint64_t>(m_pipeline), m_name);
}

RasterPipeline CreateRasterPipeline(Device& device, const RasterPipelineDesc& desc) {
    CheckDesc(device, desc);
    return {device, desc};
}

// --- Ray-tracing pipelines ---

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

bool IsEmpty(const HitGroup& group) {
    return group.closestHit.IsEmpty() && group.anyHit.IsEmpty() && group.intersection.IsEmpty();
}

// The shader groups in the order of their numbers: ray generation, misses, hit sets, callables. Where there
// is no shader, there is no group.
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

    void AddHit(const HitGroup& hit) {
        if (IsEmpty(hit)) return;
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

// Writes records, and gives out the handles in the order of the groups.
class TableWriter {
  public:
    TableWriter(std::byte* table, std::span<const std::byte> handles, size_t handleSize)
        : m_table(table), m_handles(handles), m_handleSize(handleSize) {}

    // Returns the handle of the next group, or an empty one for a record that has none.
    std::span<const std::byte> NextHandle(bool hasGroup) {
        if (!hasGroup) return {};
        RG_CHECK_GE(m_handles.size(), m_handleSize);
        const auto handle = m_handles.first(m_handleSize);
        m_handles = m_handles.subspan(m_handleSize);
        return handle;
    }

    // An empty handle stays zero, which means "no shader" to the device.
    void Write(const TableRegion& region, uint32_t record, std::span<const std::byte> handle,
               const std::vector<std::byte>& data) {
        std::byte* target = m_table + region.RecordOffset(record);
        std::memset(target, 0, region.stride);
        std::ranges::copy(handle, target);
        std::ranges::copy(data, target + m_handleSize);
    }

  private:
    std::byte* m_table;
    std::span<const std::byte> m_handles;  // handles that are not given out yet
    size_t m_handleSize;
};

TableLayout LayOut(const Device& device, const RayTracingPipelineDesc& desc) {
    std::vector<uint32_t> miss, hit, callable;
    for (const GeneralShader& shader : desc.miss) miss.push_back(DataBytes(shader.recordData));
    for (const uint32_t set : desc.tableSets)
        for (const HitGroup& group : desc.hitSets[set]) hit.push_back(DataBytes(group.recordData));
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
    const size_t setCount = std::max<size_t>(1, desc.hitSets.size());
    for (const uint32_t set : desc.tableSets)
        if (set >= setCount)
            throw MakeError(ErrorKind::Usage, "{}: its table has hit set {} of {}", desc.name, set, setCount);
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
    writer.Write(m_tableLayout.rayGen, 0, writer.NextHandle(true), desc.rayGen.recordData);
    for (uint32_t i = 0; i < desc.miss.size(); ++i)
        writer.Write(m_tableLayout.miss, i, writer.NextHandle(!desc.miss[i].stage.IsEmpty()),
                     desc.miss[i].recordData);
    std::vector<std::vector<std::span<const std::byte>>> handlesOf(desc.hitSets.size());
    for (size_t set = 0; set < handlesOf.size(); ++set)
        for (const HitGroup& group : desc.hitSets[set])
            handlesOf[set].push_back(writer.NextHandle(!IsEmpty(group)));
    uint32_t record = 0;
    for (const uint32_t set : desc.tableSets)
        for (size_t type = 0; type < handlesOf[set].size(); ++type)
            writer.Write(m_tableLayout.hit, record++, handlesOf[set][type],
                         desc.hitSets[set][type].recordData);
    for (uint32_t i = 0; i < desc.callables.size(); ++i)
        writer.Write(m_tableLayout.callable, i, writer.NextHandle(true), desc.callables[i].recordData);

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
    if (whole.tableSets.empty())
        for (uint32_t set = 0; set < whole.hitSets.size(); ++set) whole.tableSets.push_back(set);
    return {device, whole};
}

// --- Statistics ---

namespace {

double ValueOf(const VkPipelineExecutableStatisticKHR& statistic) {
    switch (statistic.format) {
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR:
            return statistic.value.b32 ? 1.0 : 0.0;
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR:
            return static_cast<double>(statistic.value.i64);
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR:
            return static_cast<double>(statistic.value.u64);
        default:
            return statistic.value.f64;
    }
}

// Calls an enumerating function of Vulkan twice: for the number, then for as many structures of `type`.
template <typename T, typename Ask>
std::vector<T> ListOf(const Device& device, const char* what, VkStructureType type, Ask&& ask) {
    uint32_t count = 0;
    device.Check(ask(&count, nullptr), what);
    T empty{};
    empty.sType = type;
    std::vector<T> list(count, empty);
    device.Check(ask(&count, list.data()), what);
    list.resize(count);
    return list;
}

}  // namespace

std::vector<ProgramStatistics> StatisticsOf(const Device& device, const Pipeline& pipeline) {
    if ((device.PipelineFlags() & VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR) == 0 || !pipeline) return {};
    const DeviceFunctions& vk = device.Vk();
    VkPipelineInfoKHR info{VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR, nullptr, pipeline.Handle()};
    const auto programs = ListOf<VkPipelineExecutablePropertiesKHR>(
        device, "vkGetPipelineExecutablePropertiesKHR", VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_PROPERTIES_KHR,
        [&](uint32_t* count, VkPipelineExecutablePropertiesKHR* list) {
            return vk.vkGetPipelineExecutablePropertiesKHR(device.Handle(), &info, count, list);
        });
    std::vector<ProgramStatistics> all;
    for (uint32_t i = 0; i < programs.size(); ++i) {
        VkPipelineExecutableInfoKHR program{VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR, nullptr,
                                            pipeline.Handle(), i};
        ProgramStatistics& told = all.emplace_back();
        told.name = programs[i].name;
        told.subgroupSize = programs[i].subgroupSize;
        for (const VkPipelineExecutableStatisticKHR& statistic : ListOf<VkPipelineExecutableStatisticKHR>(
                 device, "vkGetPipelineExecutableStatisticsKHR",
                 VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR,
                 [&](uint32_t*count, VkPipelineExecutableStatisticKHR*list) {
                     return vk.vkGetPipelineExecutableStatisticsKHR(device.Handle(), &program, count, list);
                 }))
            told.statistics.push_back({statistic.name, statistic.description, ValueOf(statistic)});
    }
    return all;
}

}  // namespace raygraph::rhi
