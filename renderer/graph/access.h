// The ways in which a pass accesses a resource, and their masks and layouts in Vulkan. Needs no device and
// makes no vk* call. Threads: plain values and pure functions, for any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/api.h"
#include "renderer/graph/ids.h"
#include "rhi/resources.h"
#include "rhi/vulkan.h"

namespace raygraph {

// The kind of a pass determines the pipeline stages of all its accesses; no stage is given by hand.
enum class PassKind : uint8_t {
    RayTracing,             // ray-tracing pipeline; TraceRays
    Compute,                // compute pipeline; Dispatch
    Raster,                 // graphics pipeline with dynamic rendering; Draw*
    Transfer,               // copies, fills, clears; no pipeline
    AccelerationStructure,  // builds, refits, compaction copies; no pipeline
};
RAYGRAPH_API const char* Name(PassKind kind);

enum class Access : uint8_t {
    Sampled,         // texture through a sampler
    StorageRead,     // storage image or storage buffer, read only
    StorageWrite,    // as StorageRead, but written; the contents before the pass are not read
    StorageUpdate,   // as StorageRead, but read and written
    Uniform,         // uniform buffer
    TraceStructure,  // acceleration structure, traced against
    AddressRead,     // buffer reached by address
    AddressWrite,
    AddressUpdate,
    CopyRead,
    CopyWrite,
    BuildInput,   // vertices, indices or instances of a build
    BuildRead,    // structure read by a build (BLASes by a TLAS build) or by a compaction copy
    BuildWrite,   // structure built
    BuildUpdate,  // structure refitted in place
    ColorWrite,   // attachment, cleared or overwritten
    ColorUpdate,  // attachment, loaded and blended
    DepthWrite,
    DepthUpdate,
    IndexRead,
    IndirectRead,
    Count  // number of accesses
};
RAYGRAPH_API const char* Name(Access access);  // "sampled", "storage write", ...
RAYGRAPH_API bool Writes(Access access);
// Returns true if the contents before the pass are needed: for StorageUpdate, every read, and so on; false
// for pure writes.
RAYGRAPH_API bool NeedsContents(Access access);
// Returns whether a pass of this kind may access a resource that way: a compute pass has no attachments, and
// a transfer pass no shaders.
RAYGRAPH_API bool IsLegal(PassKind kind, Access access);

// Describes an access as the barrier planner sees it.
struct AccessMasks {
    VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_NONE;
    VkAccessFlags2 access = VK_ACCESS_2_NONE;
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;  // textures only
};
// Requires a legal pair.
RAYGRAPH_API AccessMasks MasksFor(PassKind kind, Access access);

// Returns the pipeline stages in which the shaders of a pass of this kind run.
RAYGRAPH_API VkPipelineStageFlags2 ShaderStages(PassKind kind);

// The last known state of a resource, from which the next barrier follows. It survives frames for persistent
// and imported resources. The default is a resource that was never used and has undefined contents.
struct ResourceState {
    VkPipelineStageFlags2 writeStages = VK_PIPELINE_STAGE_2_NONE;  // the last write, not yet overwritten
    VkAccessFlags2 writeAccess = VK_ACCESS_2_NONE;
    VkPipelineStageFlags2 readStages = VK_PIPELINE_STAGE_2_NONE;  // reads since then
    // Stages to which that write is visible already.
    VkPipelineStageFlags2 visibleStages = VK_PIPELINE_STAGE_2_NONE;
    VkAccessFlags2 visibleAccess = VK_ACCESS_2_NONE;
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
    uint32_t queueFamily = VK_QUEUE_FAMILY_IGNORED;  // set for imports that come from another family

    bool operator==(const ResourceState&) const = default;
};

// --- The table of accesses, one row each ---
// It is used by access.cpp, by the declaration of a frame (usage flags) and by the compiler (what a write
// preserves). For renderer/graph/ alone.

// Returns a set of pass kinds or of resource kinds, as one bit each.
template <typename Kind, typename... Kinds>
constexpr uint8_t SetOf(Kind first, Kinds... others) {
    return static_cast<uint8_t>((1u << static_cast<unsigned>(first)) |
                                (0u | ... | (1u << static_cast<unsigned>(others))));
}
template <typename Kind>
constexpr bool Has(uint8_t set, Kind kind) {
    return (set & SetOf(kind)) != 0;
}

enum class Effect : uint8_t {
    Reads,     // needs the old contents
    Replaces,  // writes; the old contents are not needed
    Updates,   // writes, and needs the old contents
};

struct AccessRow {
    Access kind;
    const char* text;
    Effect effect;
    uint8_t passes;  // the pass kinds that may use this access
    // The masks of the barrier. Stages NONE stands for those of the pass kind (ShaderStages).
    VkAccessFlags2 access;
    VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_NONE;
    VkAccessFlags2 accessInBuilds = VK_ACCESS_2_NONE;  // NONE: the same as `access`
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;  // UNDEFINED: textures have no such access
    // The usage flags that the access needs.
    rhi::TextureUsage texture = rhi::TextureUsage::None;
    rhi::BufferUsage buffer = rhi::BufferUsage::None;
    // The resource kinds of which this access replaces only a part, so that the rest must be preserved.
    uint8_t partOf = 0;
};

namespace access_rows {

using A = Access;
using enum Effect;
using Texture = rhi::TextureUsage;
using Buffer = rhi::BufferUsage;

inline constexpr uint8_t kRaster = SetOf(PassKind::Raster);
inline constexpr uint8_t kTransfer = SetOf(PassKind::Transfer);
inline constexpr uint8_t kBuild = SetOf(PassKind::AccelerationStructure);
inline constexpr uint8_t kShading = SetOf(PassKind::RayTracing, PassKind::Compute, PassKind::Raster);

inline constexpr VkAccessFlags2 kStorageRead = VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
inline constexpr VkAccessFlags2 kStorageWrite = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
inline constexpr VkAccessFlags2 kInputRead = VK_ACCESS_2_SHADER_READ_BIT;
inline constexpr VkAccessFlags2 kStructureRead = VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR;
inline constexpr VkAccessFlags2 kStructureWrite = VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
inline constexpr VkAccessFlags2 kColorRead = VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT;
inline constexpr VkAccessFlags2 kColorWrite = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
inline constexpr VkAccessFlags2 kDepthRead = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
inline constexpr VkAccessFlags2 kDepthWrite = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;

inline constexpr VkPipelineStageFlags2 kColorStage = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
inline constexpr VkPipelineStageFlags2 kDepthStages =
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;

inline constexpr VkImageLayout kGeneral = VK_IMAGE_LAYOUT_GENERAL;
inline constexpr VkImageLayout kColorLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
inline constexpr VkImageLayout kDepthLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;

// A write by address may leave any part unchanged, so that it preserves the rest for all kinds. A build reads
// geometry by address (SHADER_READ), and writes scratch memory (accesses of structures).
inline constexpr uint8_t kAny = SetOf(ResourceKind::Texture, ResourceKind::Buffer, ResourceKind::Tlas,
                                      ResourceKind::BlasSet, ResourceKind::TextureSet);

inline constexpr AccessRow kAll[] = {
    {.kind = A::Sampled,
     .text = "sampled",
     .effect = Reads,
     .passes = kShading,
     .access = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
     .layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
     .texture = Texture::Sampled},
    {.kind = A::StorageRead,
     .text = "storage read",
     .effect = Reads,
     .passes = kShading,
     .access = kStorageRead,
     .layout = kGeneral,
     .texture = Texture::Storage,
     .buffer = Buffer::Storage},
    {.kind = A::StorageWrite,
     .text = "storage write",
     .effect = Replaces,
     .passes = kShading,
     .access = kStorageWrite,
     .layout = kGeneral,
     .texture = Texture::Storage,
     .buffer = Buffer::Storage},
    {.kind = A::StorageUpdate,
     .text = "storage update",
     .effect = Updates,
     .passes = kShading,
     .access = kStorageRead | kStorageWrite,
     .layout = kGeneral,
     .texture = Texture::Storage,
     .buffer = Buffer::Storage},
    {.kind = A::Uniform,
     .text = "uniform",
     .effect = Reads,
     .passes = kShading,
     .access = VK_ACCESS_2_UNIFORM_READ_BIT,
     .buffer = Buffer::Uniform},
    {.kind = A::TraceStructure,
     .text = "traced",
     .effect = Reads,
     .passes = kShading,
     .access = kStructureRead},
    {.kind = A::AddressRead,
     .text = "read by address",
     .effect = Reads,
     .passes = kShading | kBuild,
     .access = kStorageRead,
     .accessInBuilds = kInputRead,
     .buffer = Buffer::Storage},
    {.kind = A::AddressWrite,
     .text = "written by address",
     .effect = Replaces,
     .passes = kShading | kBuild,
     .access = kStorageWrite,
     .accessInBuilds = kStructureRead | kStructureWrite,
     .buffer = Buffer::Storage,
     .partOf = kAny},
    {.kind = A::AddressUpdate,
     .text = "updated by address",
     .effect = Updates,
     .passes = kShading | kBuild,
     .access = kStorageRead | kStorageWrite,
     .accessInBuilds = kStructureRead | kStructureWrite,
     .buffer = Buffer::Storage},
    {.kind = A::CopyRead,
     .text = "copy source",
     .effect = Reads,
     .passes = kTransfer,
     .access = VK_ACCESS_2_TRANSFER_READ_BIT,
     .layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
     .texture = Texture::CopySource,
     .buffer = Buffer::CopySource},
    {.kind = A::CopyWrite,
     .text = "copy target",
     .effect = Replaces,
     .passes = kTransfer,
     .access = VK_ACCESS_2_TRANSFER_WRITE_BIT,
     .layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
     .texture = Texture::CopyDestination,
     .buffer = Buffer::CopyDestination,
     .partOf = SetOf(ResourceKind::Buffer)},
    {.kind = A::BuildInput,
     .text = "build input",
     .effect = Reads,
     .passes = kBuild,
     .access = kInputRead,
     .buffer = Buffer::BuildInput},
    {.kind = A::BuildRead,
     .text = "structure read",
     .effect = Reads,
     .passes = kBuild,
     .access = kStructureRead},
    {.kind = A::BuildWrite,
     .text = "build",
     .effect = Replaces,
     .passes = kBuild,
     .access = kStructureWrite,
     .partOf = SetOf(ResourceKind::BlasSet)},
    {.kind = A::BuildUpdate,
     .text = "refit",
     .effect = Updates,
     .passes = kBuild,
     .access = kStructureRead | kStructureWrite},
    {.kind = A::ColorWrite,
     .text = "color target",
     .effect = Replaces,
     .passes = kRaster,
     .access = kColorWrite,
     .stages = kColorStage,
     .layout = kColorLayout,
     .texture = Texture::ColorTarget},
    {.kind = A::ColorUpdate,
     .text = "color target, loaded",
     .effect = Updates,
     .passes = kRaster,
     .access = kColorRead | kColorWrite,
     .stages = kColorStage,
     .layout = kColorLayout,
     .texture = Texture::ColorTarget},
    // A depth test reads what the pass itself has written, so that both have the same masks.
    {.kind = A::DepthWrite,
     .text = "depth target",
     .effect = Replaces,
     .passes = kRaster,
     .access = kDepthRead | kDepthWrite,
     .stages = kDepthStages,
     .layout = kDepthLayout,
     .texture = Texture::DepthTarget},
    {.kind = A::DepthUpdate,
     .text = "depth target, loaded",
     .effect = Updates,
     .passes = kRaster,
     .access = kDepthRead | kDepthWrite,
     .stages = kDepthStages,
     .layout = kDepthLayout,
     .texture = Texture::DepthTarget},
    {.kind = A::IndexRead,
     .text = "indices",
     .effect = Reads,
     .passes = kRaster,
     .access = VK_ACCESS_2_INDEX_READ_BIT,
     .stages = VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT,
     .buffer = Buffer::Index},
    {.kind = A::IndirectRead,
     .text = "indirect arguments",
     .effect = Reads,
     .passes = kShading,
     .access = VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT,
     .stages = VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
     .buffer = Buffer::Indirect},
};

constexpr bool AreAccessRowsInOrder() {
    size_t place = 0;
    for (const AccessRow& row : kAll)
        if (row.kind != static_cast<Access>(place++)) return false;
    return place == static_cast<size_t>(Access::Count);
}
static_assert(AreAccessRowsInOrder(), "each access needs its row, in the order of the enumerators");

}  // namespace access_rows

constexpr const AccessRow& Row(Access access) {
    return access_rows::kAll[static_cast<size_t>(access)];
}

}  // namespace raygraph
