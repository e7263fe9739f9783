// The ways in which a pass accesses a resource, and their masks and layouts in Vulkan. Needs no device and
// makes no vk* call. Threads: plain values and pure functions, for any thread.
#pragma once

#include <cstdint>

#include "base/api.h"
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

// An access as the barrier planner sees it.
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

}  // namespace raygraph
