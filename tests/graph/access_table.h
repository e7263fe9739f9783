// This table says what each access is to Vulkan, by hand from the specification, for tests to compare with
// and to judge plans by. Nothing here comes from renderer/graph/access.h.
//
// Sources, in the Vulkan 1.3 specification: "Pipeline Stages" and "Access Types" with its table of access
// types by stage (synchronization chapter); "Image Layouts" (resource creation); for builds "Acceleration
// Structure Building Commands", which names the stage and the accesses of inputs (SHADER_READ), of scratch
// memory (READ and WRITE of structures) and of structures. Without VK_KHR_ray_tracing_maintenance1 copies of
// structures are in the stage of builds.
#pragma once

#include <array>

#include "renderer/graph/access.h"

namespace raygraph::golden {

enum class Effect : uint8_t {
    Reads,     // needs what was there
    Replaces,  // what was there does not matter
    Updates,   // needs what was there, and changes it
};

struct AccessRow {
    PassKind kind;
    Access access;
    VkPipelineStageFlags2 stages;
    VkAccessFlags2 accesses;
    VkImageLayout layout;  // of a texture; UNDEFINED: no texture is used that way
    Effect effect;
};

namespace rows {

inline constexpr VkPipelineStageFlags2 kTracing = VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR;
inline constexpr VkPipelineStageFlags2 kCompute = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
inline constexpr VkPipelineStageFlags2 kDrawing =
    VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
inline constexpr VkPipelineStageFlags2 kTransfer = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
inline constexpr VkPipelineStageFlags2 kBuild = VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
inline constexpr VkPipelineStageFlags2 kColor = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
inline constexpr VkPipelineStageFlags2 kDepth =
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
inline constexpr VkPipelineStageFlags2 kIndirect = VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT;
inline constexpr VkPipelineStageFlags2 kIndex = VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT;

inline constexpr VkAccessFlags2 kSampledRead = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
inline constexpr VkAccessFlags2 kStorageRead = VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
inline constexpr VkAccessFlags2 kStorageWrite = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
inline constexpr VkAccessFlags2 kUniformRead = VK_ACCESS_2_UNIFORM_READ_BIT;
inline constexpr VkAccessFlags2 kStructureRead = VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR;
inline constexpr VkAccessFlags2 kStructureWrite = VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
inline constexpr VkAccessFlags2 kInputRead = VK_ACCESS_2_SHADER_READ_BIT;
inline constexpr VkAccessFlags2 kIndirectRead = VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT;
inline constexpr VkAccessFlags2 kIndexRead = VK_ACCESS_2_INDEX_READ_BIT;
inline constexpr VkAccessFlags2 kCopyRead = VK_ACCESS_2_TRANSFER_READ_BIT;
inline constexpr VkAccessFlags2 kCopyWrite = VK_ACCESS_2_TRANSFER_WRITE_BIT;
inline constexpr VkAccessFlags2 kColorRead = VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT;
inline constexpr VkAccessFlags2 kColorWrite = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
inline constexpr VkAccessFlags2 kDepthRead = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
inline constexpr VkAccessFlags2 kDepthWrite = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;

inline constexpr VkImageLayout kNoTexture = VK_IMAGE_LAYOUT_UNDEFINED;
inline constexpr VkImageLayout kGeneral = VK_IMAGE_LAYOUT_GENERAL;
inline constexpr VkImageLayout kReadOnly = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
inline constexpr VkImageLayout kSource = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
inline constexpr VkImageLayout kTarget = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
inline constexpr VkImageLayout kColorLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
inline constexpr VkImageLayout kDepthLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;

using enum PassKind;
using enum Effect;
using A = Access;

// clang-format off: a table
inline constexpr std::array kAll{
    AccessRow{RayTracing, A::Sampled, kTracing, kSampledRead, kReadOnly, Reads},
    AccessRow{RayTracing, A::StorageRead, kTracing, kStorageRead, kGeneral, Reads},
    AccessRow{RayTracing, A::StorageWrite, kTracing, kStorageWrite, kGeneral, Replaces},
    AccessRow{RayTracing, A::StorageUpdate, kTracing, kStorageRead | kStorageWrite, kGeneral, Updates},
    AccessRow{RayTracing, A::Uniform, kTracing, kUniformRead, kNoTexture, Reads},
    AccessRow{RayTracing, A::TraceStructure, kTracing, kStructureRead, kNoTexture, Reads},
    AccessRow{RayTracing, A::AddressRead, kTracing, kStorageRead, kNoTexture, Reads},
    AccessRow{RayTracing, A::AddressWrite, kTracing, kStorageWrite, kNoTexture, Replaces},
    AccessRow{RayTracing, A::AddressUpdate, kTracing, kStorageRead | kStorageWrite, kNoTexture, Updates},
    AccessRow{RayTracing, A::IndirectRead, kIndirect, kIndirectRead, kNoTexture, Reads},

    AccessRow{Compute, A::Sampled, kCompute, kSampledRead, kReadOnly, Reads},
    AccessRow{Compute, A::StorageRead, kCompute, kStorageRead, kGeneral, Reads},
    AccessRow{Compute, A::StorageWrite, kCompute, kStorageWrite, kGeneral, Replaces},
    AccessRow{Compute, A::StorageUpdate, kCompute, kStorageRead | kStorageWrite, kGeneral, Updates},
    AccessRow{Compute, A::Uniform, kCompute, kUniformRead, kNoTexture, Reads},
    AccessRow{Compute, A::TraceStructure, kCompute, kStructureRead, kNoTexture, Reads},
    AccessRow{Compute, A::AddressRead, kCompute, kStorageRead, kNoTexture, Reads},
    AccessRow{Compute, A::AddressWrite, kCompute, kStorageWrite, kNoTexture, Replaces},
    AccessRow{Compute, A::AddressUpdate, kCompute, kStorageRead | kStorageWrite, kNoTexture, Updates},
    AccessRow{Compute, A::IndirectRead, kIndirect, kIndirectRead, kNoTexture, Reads},

    AccessRow{Raster, A::Sampled, kDrawing, kSampledRead, kReadOnly, Reads},
    AccessRow{Raster, A::StorageRead, kDrawing, kStorageRead, kGeneral, Reads},
    AccessRow{Raster, A::StorageWrite, kDrawing, kStorageWrite, kGeneral, Replaces},
    AccessRow{Raster, A::StorageUpdate, kDrawing, kStorageRead | kStorageWrite, kGeneral, Updates},
    AccessRow{Raster, A::Uniform, kDrawing, kUniformRead, kNoTexture, Reads},
    AccessRow{Raster, A::TraceStructure, kDrawing, kStructureRead, kNoTexture, Reads},
    AccessRow{Raster, A::AddressRead, kDrawing, kStorageRead, kNoTexture, Reads},
    AccessRow{Raster, A::AddressWrite, kDrawing, kStorageWrite, kNoTexture, Replaces},
    AccessRow{Raster, A::AddressUpdate, kDrawing, kStorageRead | kStorageWrite, kNoTexture, Updates},
    AccessRow{Raster, A::IndirectRead, kIndirect, kIndirectRead, kNoTexture, Reads},
    AccessRow{Raster, A::IndexRead, kIndex, kIndexRead, kNoTexture, Reads},
    // Load operations of color read in the stage of the output; a clear writes.
    AccessRow{Raster, A::ColorWrite, kColor, kColorWrite, kColorLayout, Replaces},
    AccessRow{Raster, A::ColorUpdate, kColor, kColorRead | kColorWrite, kColorLayout, Updates},
    // Load operations of depth are in the early tests, store operations in the late ones; a test reads also
    // what a clear has written.
    AccessRow{Raster, A::DepthWrite, kDepth, kDepthRead | kDepthWrite, kDepthLayout, Replaces},
    AccessRow{Raster, A::DepthUpdate, kDepth, kDepthRead | kDepthWrite, kDepthLayout, Updates},

    AccessRow{Transfer, A::CopyRead, kTransfer, kCopyRead, kSource, Reads},
    AccessRow{Transfer, A::CopyWrite, kTransfer, kCopyWrite, kTarget, Replaces},

    AccessRow{AccelerationStructure, A::AddressRead, kBuild, kInputRead, kNoTexture, Reads},
    AccessRow{AccelerationStructure, A::AddressWrite, kBuild, kStructureRead | kStructureWrite, kNoTexture,
              Replaces},
    AccessRow{AccelerationStructure, A::AddressUpdate, kBuild, kStructureRead | kStructureWrite, kNoTexture,
              Updates},
    AccessRow{AccelerationStructure, A::BuildInput, kBuild, kInputRead, kNoTexture, Reads},
    AccessRow{AccelerationStructure, A::BuildRead, kBuild, kStructureRead, kNoTexture, Reads},
    AccessRow{AccelerationStructure, A::BuildWrite, kBuild, kStructureWrite, kNoTexture, Replaces},
    AccessRow{AccelerationStructure, A::BuildUpdate, kBuild, kStructureRead | kStructureWrite, kNoTexture,
              Updates},
};
// clang-format on

}  // namespace rows

inline constexpr auto& kAccessRows = rows::kAll;

// Null: a pass of that kind cannot do it.
constexpr const AccessRow* Find(PassKind kind, Access access) {
    for (const AccessRow& row : kAccessRows)
        if (row.kind == kind && row.access == access) return &row;
    return nullptr;
}

}  // namespace raygraph::golden
