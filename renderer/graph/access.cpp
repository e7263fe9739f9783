#include "renderer/graph/access.h"

#include "base/check.h"

namespace raygraph {

const char* Name(PassKind kind) {
    switch (kind) {
        case PassKind::RayTracing:
            return "ray tracing";
        case PassKind::Compute:
            return "compute";
        case PassKind::Raster:
            return "raster";
        case PassKind::Transfer:
            return "transfer";
        case PassKind::AccelerationStructure:
            return "acceleration structure";
    }
    return "?";
}

const char* Name(Access access) {
    return Row(access).text;
}

bool Writes(Access access) {
    return Row(access).effect != Effect::Reads;
}

bool NeedsContents(Access access) {
    return Row(access).effect != Effect::Replaces;
}

bool IsLegal(PassKind kind, Access access) {
    return Has(Row(access).passes, kind);
}

VkPipelineStageFlags2 ShaderStages(PassKind kind) {
    switch (kind) {
        case PassKind::RayTracing:
            return VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR;
        case PassKind::Compute:
            return VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
        case PassKind::Raster:
            return VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
        case PassKind::Transfer:
            return VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
        case PassKind::AccelerationStructure:
            return VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
    }
    return VK_PIPELINE_STAGE_2_NONE;
}

AccessMasks MasksFor(PassKind kind, Access access) {
    RG_CHECK(IsLegal(kind, access));
    const AccessRow& row = Row(access);
    const bool isOtherInBuilds =
        kind == PassKind::AccelerationStructure && row.accessInBuilds != VK_ACCESS_2_NONE;
    return {row.stages == VK_PIPELINE_STAGE_2_NONE ? ShaderStages(kind) : row.stages,
            isOtherInBuilds ? row.accessInBuilds : row.access, row.layout};
}

}  // namespace raygraph
