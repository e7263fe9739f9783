#include "rhi/raster_pipeline.h"

#include <array>

#include "base/stopwatch.h"
#include "base/text.h"
#include "rhi/device.h"
#include "rhi/stage_set.h"

namespace raygraph::rhi {
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

}  // namespace raygraph::rhi
