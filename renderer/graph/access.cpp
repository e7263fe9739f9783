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
    switch (access) {
        case Access::Sampled:
            return "sampled";
        case Access::StorageRead:
            return "storage read";
        case Access::StorageWrite:
            return "storage write";
        case Access::StorageUpdate:
            return "storage update";
        case Access::Uniform:
            return "uniform";
        case Access::TraceStructure:
            return "traced";
        case Access::AddressRead:
            return "read by address";
        case Access::AddressWrite:
            return "written by address";
        case Access::AddressUpdate:
            return "updated by address";
        case Access::CopyRead:
            return "copy source";
        case Access::CopyWrite:
            return "copy target";
        case Access::BuildInput:
            return "build input";
        case Access::BuildRead:
            return "structure read";
        case Access::BuildWrite:
            return "build";
        case Access::BuildUpdate:
            return "refit";
        case Access::ColorWrite:
            return "color target";
        case Access::ColorUpdate:
            return "color target, loaded";
        case Access::DepthWrite:
            return "depth target";
        case Access::DepthUpdate:
            return "depth target, loaded";
        case Access::IndexRead:
            return "indices";
        case Access::IndirectRead:
            return "indirect arguments";
        case Access::HostRead:
            return "read by the host";
    }
    return "?";
}

bool Writes(Access access) {
    switch (access) {
        case Access::StorageWrite:
        case Access::StorageUpdate:
        case Access::AddressWrite:
        case Access::AddressUpdate:
        case Access::CopyWrite:
        case Access::BuildWrite:
        case Access::BuildUpdate:
        case Access::ColorWrite:
        case Access::ColorUpdate:
        case Access::DepthWrite:
        case Access::DepthUpdate:
            return true;
        default:
            return false;
    }
}

bool NeedsContents(Access access) {
    switch (access) {
        case Access::StorageWrite:
        case Access::AddressWrite:
        case Access::CopyWrite:
        case Access::BuildWrite:
        case Access::ColorWrite:
        case Access::DepthWrite:
            return false;
        default:
            return true;
    }
}

bool IsLegal(PassKind kind, Access access) {
    const bool hasShaders =
        kind == PassKind::RayTracing || kind == PassKind::Compute || kind == PassKind::Raster;
    switch (access) {
        case Access::Sampled:
        case Access::StorageRead:
        case Access::StorageWrite:
        case Access::StorageUpdate:
        case Access::Uniform:
        case Access::TraceStructure:
        case Access::IndirectRead:
            return hasShaders;
        case Access::AddressRead:
        case Access::AddressWrite:
        case Access::AddressUpdate:
            return hasShaders || kind == PassKind::AccelerationStructure;
        case Access::CopyRead:
        case Access::CopyWrite:
            return kind == PassKind::Transfer;
        case Access::BuildInput:
        case Access::BuildRead:
        case Access::BuildWrite:
        case Access::BuildUpdate:
            return kind == PassKind::AccelerationStructure;
        case Access::ColorWrite:
        case Access::ColorUpdate:
        case Access::DepthWrite:
        case Access::DepthUpdate:
        case Access::IndexRead:
            return kind == PassKind::Raster;
        case Access::HostRead:
            return false;
    }
    return false;
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
    constexpr VkAccessFlags2 kStructureRead = VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR;
    constexpr VkAccessFlags2 kStructureWrite = VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
    constexpr VkAccessFlags2 kStorageRead = VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
    constexpr VkAccessFlags2 kStorageWrite = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
    constexpr VkAccessFlags2 kColorRead = VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT;
    constexpr VkAccessFlags2 kColorWrite = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
    constexpr VkAccessFlags2 kDepthRead = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
    constexpr VkAccessFlags2 kDepthWrite = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    constexpr VkPipelineStageFlags2 kColorStage = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
    constexpr VkPipelineStageFlags2 kDepthStages =
        VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
    RG_CHECK(IsLegal(kind, access));

    const VkPipelineStageFlags2 stages = ShaderStages(kind);
    const bool isBuild = kind == PassKind::AccelerationStructure;
    switch (access) {
        case Access::Sampled:
            return {stages, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
        case Access::StorageRead:
            return {stages, kStorageRead, VK_IMAGE_LAYOUT_GENERAL};
        case Access::StorageWrite:
            return {stages, kStorageWrite, VK_IMAGE_LAYOUT_GENERAL};
        case Access::StorageUpdate:
            return {stages, kStorageRead | kStorageWrite, VK_IMAGE_LAYOUT_GENERAL};
        case Access::Uniform:
            return {stages, VK_ACCESS_2_UNIFORM_READ_BIT};
        case Access::TraceStructure:
            return {stages, kStructureRead};
        // What a build reads by address is geometry (SHADER_READ), what it writes is scratch (structure
        // accesses).
        case Access::AddressRead:
            return {stages, isBuild ? VK_ACCESS_2_SHADER_READ_BIT : kStorageRead};
        case Access::AddressWrite:
            return {stages, isBuild ? kStructureRead | kStructureWrite : kStorageWrite};
        case Access::AddressUpdate:
            return {stages, isBuild ? kStructureRead | kStructureWrite : kStorageRead | kStorageWrite};
        case Access::CopyRead:
            return {stages, VK_ACCESS_2_TRANSFER_READ_BIT, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};
        case Access::CopyWrite:
            return {stages, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
        case Access::BuildInput:
            return {stages, VK_ACCESS_2_SHADER_READ_BIT};
        case Access::BuildRead:
            return {stages, kStructureRead};
        case Access::BuildWrite:
            return {stages, kStructureWrite};
        case Access::BuildUpdate:
            return {stages, kStructureRead | kStructureWrite};
        case Access::ColorWrite:
            return {kColorStage, kColorWrite, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
        case Access::ColorUpdate:
            return {kColorStage, kColorRead | kColorWrite, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
        // A depth test reads what the pass itself wrote, so both pairs of masks are the same.
        case Access::DepthWrite:
        case Access::DepthUpdate:
            return {kDepthStages, kDepthRead | kDepthWrite, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
        case Access::IndexRead:
            return {VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, VK_ACCESS_2_INDEX_READ_BIT};
        case Access::IndirectRead:
            return {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT};
        case Access::HostRead:
            break;
    }
    return {};
}

}  // namespace raygraph
