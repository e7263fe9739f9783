#include "renderer/graph/text.h"

#include <array>

#include "renderer/graph/barrier_planner.h"

namespace raygraph {

std::string StagesText(VkPipelineStageFlags2 stages) {
    struct StageName {
        VkPipelineStageFlags2 stages;
        const char* name;
    };
    static constexpr std::array<StageName, 14> kNames{{
        {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, "AllCommands"},
        {VK_PIPELINE_STAGE_2_HOST_BIT, "Host"},
        {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, "DrawIndirect"},
        {VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, "IndexInput"},
        {VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, "RasterShaders"},
        {VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, "VertexShader"},
        {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, "FragmentShader"},
        {VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
         "DepthTests"},
        {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, "ColorOutput"},
        {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, "ComputeShader"},
        {VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR, "RayTracingShader"},
        {VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR, "StructureBuild"},
        {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, "Transfer"},
        {VK_PIPELINE_STAGE_2_ALL_GRAPHICS_BIT, "AllGraphics"},
    }};
    if (stages == VK_PIPELINE_STAGE_2_NONE) return "nothing";
    std::string text;
    const auto add = [&](const char* name) {
        if (!text.empty()) text += '|';
        text += name;
    };
    for (const StageName& entry : kNames) {
        if ((stages & entry.stages) != entry.stages) continue;
        add(entry.name);
        stages &= ~entry.stages;
    }
    if (stages != 0) add("other stages");
    return text;
}

const char* AccessText(VkAccessFlags2 access) {
    const bool isWrite = (access & kWriteAccesses) != 0;
    const bool isRead = (access & ~kWriteAccesses) != 0;
    if (isRead && isWrite) return "read+write";
    if (isWrite) return "write";
    return isRead ? "read" : "";
}

const char* LayoutText(VkImageLayout layout) {
    switch (layout) {
        case VK_IMAGE_LAYOUT_UNDEFINED:
            return "Undefined";
        case VK_IMAGE_LAYOUT_GENERAL:
            return "General";
        case VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL:
            return "ColorTarget";
        case VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL:
            return "DepthTarget";
        case VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL:
            return "ShaderReadOnly";
        case VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL:
            return "CopySource";
        case VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL:
            return "CopyTarget";
        case VK_IMAGE_LAYOUT_PREINITIALIZED:
            return "Preinitialized";
        case VK_IMAGE_LAYOUT_PRESENT_SRC_KHR:
            return "PresentSource";
        default:
            return "other layout";
    }
}

}  // namespace raygraph
