// CommandList: records commands for one submission. Made by Device::BeginCommands, consumed
// by Device::Submit.
//
// The render graph binds the pipeline and the resources of a pass before the pass records, so that an execute
// function usually is one call: TraceRays, Dispatch or Draw*. Functions are named after the Vulkan commands.
// Threads: one at a time.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/api.h"
#include "rhi/pipeline.h"
#include "rhi/resources.h"
#include "rhi/submission.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

class TextureTable;
struct DeviceFunctions;

// The maximum of resources of one pass: maxPushDescriptors of the requirements.
inline constexpr uint32_t kMaxBoundResources = 32;

// Describes a resource for a binding of set 0. Exactly one member is set.
struct BoundResource {
    uint32_t binding = 0;
    uint32_t element = 0;  // of a binding that is an array
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_MAX_ENUM;
    const Buffer* buffer = nullptr;
    uint64_t offset = 0;
    uint64_t size = VK_WHOLE_SIZE;
    const Texture* texture = nullptr;
    VkImageView view = VK_NULL_HANDLE;  // a view of that texture; null: all of it
    const Sampler* sampler = nullptr;   // for a combined image sampler
    VkAccelerationStructureKHR accelerationStructure = VK_NULL_HANDLE;
};

constexpr uint32_t kMaxColorTargets = 8;  // of one pass, on every device (maxColorAttachments)

struct ColorTarget {
    const Texture* texture = nullptr;
    bool clear = true;
    float clearValue[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    Subresources part = Subresource(0, 0);  // one level
};

struct DepthTarget {
    const Texture* texture = nullptr;
    bool clear = true;
    float clearValue = 1.0f;
    Subresources part = Subresource(0, 0);  // one level
};

// Describes a part of the workgroups of a dispatch: those from `first` to before `end`, in `of`-ths.
struct Portion {
    uint32_t first = 0;
    uint32_t end = 1;
    uint32_t of = 1;

    bool IsWhole() const { return first == 0 && end == of; }
};

class RAYGRAPH_API CommandList {
  public:
    CommandList() = default;
    CommandList(CommandList&& other) noexcept { *this = std::move(other); }
    CommandList& operator=(CommandList&& other) noexcept;
    ~CommandList();  // an unsubmitted list is dropped

    VkCommandBuffer Handle() const { return m_commands; }
    Device& Owner() const { return *m_device; }
    QueueKind Queue() const { return m_queue; }

    // Records one vkCmdPipelineBarrier2 for the batch; nothing when all are empty.
    void Barriers(std::span<const VkMemoryBarrier2> memory, std::span<const VkImageMemoryBarrier2> images,
                  std::span<const VkBufferMemoryBarrier2> buffers = {});

    // Records a memory barrier for everything before and after it; for transfers and tests, not for frames.
    void FullBarrier();
    // Records an image barrier over all levels and layers that orders everything before and after it. From
    // UNDEFINED, the contents are lost.
    void Transition(const Texture& texture, VkImageLayout from, VkImageLayout to);

    // Binds the pipeline and its resources: set 0 by push descriptors (vkCmdPushDescriptorSetKHR), set 1 the
    // texture table.
    void Bind(const ComputePipeline& pipeline);
    void Bind(const RayTracingPipeline& pipeline);
    void Bind(const RasterPipeline& pipeline);
    void BindResources(std::span<const BoundResource> resources);
    void BindTextures(const TextureTable& table);
    // Takes at most DeviceInfo::maxPushConstantBytes, a multiple of 4.
    void PushConstants(std::span<const std::byte> bytes);

    void Dispatch(uint32_t groupsX, uint32_t groupsY = 1, uint32_t groupsZ = 1);
    // Dispatches over `extent` with the bound compute pipeline's own workgroup size.
    void DispatchOver(Extent2D extent);
    // Restricts later dispatches to a part of their workgroups, so that portions that follow each other
    // execute each workgroup once, with the ids that it has in the whole. TraceRays knows nothing of it.
    void SetPortion(const Portion& portion) { m_portion = portion; }
    // Returns which of `count` things, such as rows, are in the portion: from `first` to before `end`.
    Portion PortionOf(uint32_t count) const {
        const auto boundary = [&](uint32_t part) {
            return static_cast<uint32_t>(uint64_t{count} * part / m_portion.of);
        };
        return {.first = boundary(m_portion.first), .end = boundary(m_portion.end), .of = count};
    }
    // Launches one ray-generation invocation for each texel. An empty extent records nothing.
    void TraceRays(Extent2D extent);

    // Records vkCmdBeginRendering; viewport and scissor are set to the whole extent. All targets have as many
    // layers; with several, the vertex shader chooses by gl_Layer. No MSAA.
    void BeginRendering(Extent2D extent, std::span<const ColorTarget> colors,
                        const DepthTarget* depth = nullptr);
    void EndRendering();
    // Restricts later draws to this rectangle of the target, until EndRendering.
    void SetScissor(int32_t x, int32_t y, Extent2D extent);
    void Draw(uint32_t vertexCount, uint32_t instanceCount = 1, uint32_t firstVertex = 0,
              uint32_t firstInstance = 0);
    void DrawIndexed(const Buffer& indices, uint32_t indexCount, uint32_t instanceCount = 1,
                     uint32_t firstIndex = 0, int32_t vertexOffset = 0, uint32_t firstInstance = 0);
    // Records `drawCount` VkDrawIndirectCommands from command `firstDraw` of the buffer on; one call where
    // the device has multiDrawIndirect. Error{Usage} beyond the buffer's end. A firstInstance other than 0 in
    // a command needs drawIndirectFirstInstance.
    void DrawIndirect(const Buffer& commands, uint32_t firstDraw, uint32_t drawCount);

    // Transfers. Textures are expected in the TRANSFER_SRC/DST_OPTIMAL layout. Each throws Error{Usage}
    // naming both sides, before anything is recorded, for arguments that do not fit: ranges, rows, mip
    // levels, layers, offsets that are no multiple of the texel's size (and of 4), formats with texels of
    // another size.
    void CopyBuffer(const Buffer& source, uint64_t sourceOffset, const Buffer& target, uint64_t targetOffset,
                    uint64_t size);
    void CopyToTexture(const Buffer& source, uint64_t offset, const Texture& target, uint32_t mipLevel = 0,
                       uint32_t layer = 0);
    // Copies rows [firstRow, firstRow + rowCount) of a mip level, tightly packed at `offset`: whole blocks.
    void CopyRowsToTexture(const Buffer& source, uint64_t offset, const Texture& target, uint32_t mipLevel,
                           uint32_t firstRow, uint32_t rowCount, uint32_t layer = 0);
    void CopyToBuffer(const Texture& source, const Buffer& target, uint64_t offset = 0, uint32_t mipLevel = 0,
                      uint32_t layer = 0);
    // Describes one level of one layer, the first ones by default; both sides of the same size.
    struct Place {
        uint32_t level = 0;
        uint32_t layer = 0;
    };
    void CopyTexture(const Texture& source, const Texture& target) {
        CopyTexture(source, Place{}, target, Place{});
    }
    void CopyTexture(const Texture& source, const Place& from, const Texture& target, const Place& to);
    // Records vkCmdBlitImage with a linear filter from mip `level - 1` to `level` (SRC and DST layouts
    // respectively), of the first layer.
    void BlitMip(const Texture& texture, uint32_t level);
    void Fill(const Buffer& target, uint32_t value, uint64_t offset = 0, uint64_t size = VK_WHOLE_SIZE);
    // Records vkCmdClearColorImage for that part of the texture, which is in TRANSFER_DST_OPTIMAL.
    void Clear(const Texture& texture, const float (&rgba)[4], const Subresources& part = {});

    // Host state that changes with the recorded work. When the list has been submitted, the functions of
    // OnSubmitted run in order and those of OnDropped are discarded. When it will not be, because it is
    // dropped or its submission failed, those of OnDropped run, the last one first, and those of OnSubmitted
    // are discarded. Their captures live until then; they must not throw.
    void OnSubmitted(std::function<void()> run) { m_onSubmitted.push_back(std::move(run)); }
    void OnDropped(std::function<void()> undo) { m_onDropped.push_back(std::move(undo)); }

    void BeginLabel(const std::string& name);
    void EndLabel();
    void WriteTimestamp(VkQueryPool pool, uint32_t query, VkPipelineStageFlags2 stage);

  private:
    friend class Device;
    const DeviceFunctions& Vk() const;
    void Bind(const Pipeline& pipeline, VkPipelineBindPoint bindPoint);
    void RequirePipeline(const char* call) const;
    Device* m_device = nullptr;
    VkCommandBuffer m_commands = VK_NULL_HANDLE;
    VkCommandPool m_pool = VK_NULL_HANDLE;
    QueueKind m_queue = QueueKind::Main;
    uint64_t m_serial = 0;  // among the lists begun
    std::vector<std::function<void()>> m_onSubmitted;
    std::vector<std::function<void()>> m_onDropped;
    const Pipeline* m_pipeline = nullptr;
    const RayTracingPipeline* m_tracing = nullptr;
    const ComputePipeline* m_compute = nullptr;
    Portion m_portion;
    VkPipelineBindPoint m_bindPoint = VK_PIPELINE_BIND_POINT_COMPUTE;
};

// Returns a barrier for all levels and layers, without a transfer of queue family ownership. The caller sets
// stages and accesses. For rhi/ and renderer/graph/ alone.
inline VkImageMemoryBarrier2 ImageBarrier(const Texture& texture, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier2 barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2;
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = texture.Image();
    barrier.subresourceRange = texture.WholeRange();
    return barrier;
}

}  // namespace raygraph::rhi
