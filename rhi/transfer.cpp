#include "rhi/transfer.h"

#include <algorithm>
#include <chrono>
#include <cstring>

#include "base/check.h"
#include "base/text.h"
#include "rhi/command_list.h"
#include "rhi/device.h"

namespace raygraph::rhi {
namespace {

constexpr uint64_t kMinChunkBytes = uint64_t{64} << 10;
// A multiple of every texel size, and of 4 as copies into textures require.
constexpr uint64_t kStagingAlignment = 16;

VkImageMemoryBarrier2 MipBarrier(const Texture& texture, uint32_t level, uint32_t levelCount,
                                 VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier2 barrier = ImageBarrier(texture, from, to);
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
    barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.subresourceRange.baseMipLevel = level;
    barrier.subresourceRange.levelCount = levelCount;
    return barrier;
}

[[noreturn]] void RejectCopy(const std::string& subject, const std::string& reason) {
    throw MakeError(ErrorKind::Usage, "upload to {}: {}", subject, reason);
}

uint64_t LevelBytes(const Texture& texture, uint32_t level) {
    const Extent2D extent = MipExtent(texture.Extent(), level);
    return ImageBytes(texture.Desc().format, extent);
}

// Returns the bytes of a row of texels, or of a row of blocks.
uint64_t RowBytes(const Texture& texture, uint32_t level) {
    const Format format = texture.Desc().format;
    return ImageBytes(format, {MipExtent(texture.Extent(), level).width, BlockSide(format)});
}

}  // namespace

Uploader::Uploader(Device& device, const UploaderDesc& desc)
    : m_device(device),
      m_desc(desc),
      m_chunkBytes(desc.chunkCount == 0
                       ? 0
                       : desc.stagingBytes / desc.chunkCount / kStagingAlignment * kStagingAlignment) {
    if (desc.chunkCount < 2 || m_chunkBytes < kMinChunkBytes)
        throw MakeError(ErrorKind::Usage,
                        "uploader '{}': {} bytes in {} chunks; needed are at least 2 of at least {} bytes",
                        desc.name, desc.stagingBytes, desc.chunkCount, kMinChunkBytes);
    if (!device.HasQueue(m_desc.queue)) m_desc.queue = QueueKind::Main;
    if (!desc.allocatesAhead) return;
    m_ahead = std::async(std::launch::async | std::launch::deferred, [this] {
        std::vector<Chunk> chunks;
        for (size_t i = 0; i < m_desc.chunkCount; ++i) {
            chunks.push_back(MakeChunk(i));
            // The first access to a page takes longest, and happens here
            std::ranges::fill(chunks.back().buffer.Mapped(), std::byte{0});
        }
        return chunks;
    });
}

Uploader::~Uploader() = default;

CommandList& Uploader::List() {
    if (!m_isRecording) {
        m_list = m_device.BeginCommands(m_desc.name, m_desc.queue);
        m_isRecording = true;
        m_list.FullBarrier();  // after all earlier uses of the targets
        m_written.clear();
    }
    return m_list;
}

Submission Uploader::Flush() {
    if (!m_isRecording) return m_last;
    m_list.FullBarrier();  // before all later uses
    m_isRecording = false;
    m_last = m_device.Submit(std::move(m_list));
    if (!m_chunks.empty()) m_chunks[m_current].until = m_last;
    if (!m_mipList) return m_last;
    CommandList mips = *std::exchange(m_mipList, std::nullopt);
    mips.FullBarrier();
    m_last = m_device.Submit(std::move(mips));  // waits for the copies
    return m_last;
}

void Uploader::Drop() {
    m_list = {};
    m_isRecording = false;
    m_mipList.reset();
}

bool Uploader::IsChunkFree(const Chunk& chunk) const {
    return m_device.HasCompleted(chunk.until);
}

bool Uploader::WouldBlock() const {
    if (m_isRecording) return false;
    if (m_ahead.valid()) return m_ahead.wait_for(std::chrono::seconds(0)) == std::future_status::timeout;
    if (m_chunks.size() < m_desc.chunkCount) return false;
    return !IsChunkFree(m_chunks[(m_current + 1) % m_chunks.size()]);
}

Uploader::Chunk Uploader::MakeChunk(size_t index) const {
    Chunk chunk;
    chunk.buffer = m_device.CreateBuffer({.name = Text("{} staging {}", m_desc.name, index),
                                          .size = m_chunkBytes,
                                          .usage = BufferUsage::CopySource,
                                          .memory = MemoryKind::Upload,
                                          .hasOwnMemory = true});
    return chunk;
}

// Advances to a free chunk: the oldest one in the ring if the device is done with it, otherwise a new one if
// the limit allows it, otherwise the oldest one after waiting for it.
void Uploader::NextChunk() {
    if (m_ahead.valid()) m_chunks = m_ahead.get();
    const size_t oldest = m_chunks.empty() ? 0 : (m_current + 1) % m_chunks.size();
    const bool isDone = !m_chunks.empty() && IsChunkFree(m_chunks[oldest]);
    if (!isDone && m_chunks.size() < m_desc.chunkCount) {
        Chunk chunk = MakeChunk(m_chunks.size());
        // The new chunk follows the current one, so that the ring stays in the order of use.
        m_current = m_chunks.empty() ? 0 : m_current + 1;
        m_chunks.insert(m_chunks.begin() + static_cast<std::ptrdiff_t>(m_current), std::move(chunk));
        return;
    }
    if (!isDone) {
        ++m_waitCount;
        m_device.WaitFor(m_chunks[oldest].until);
    }
    m_current = oldest;
    m_chunks[m_current].used = 0;
    m_chunks[m_current].until = {};
}

Uploader::Staged Uploader::Stage(uint64_t wanted, uint64_t least) {
    RG_CHECK_LE(least, m_chunkBytes);
    if (m_chunks.empty() || m_chunks[m_current].until) {
        NextChunk();
    } else if (m_chunkBytes - m_chunks[m_current].used < least) {
        Flush();
        NextChunk();
    }
    Chunk& chunk = m_chunks[m_current];
    const uint64_t offset = chunk.used;
    const uint64_t size = std::min(wanted, m_chunkBytes - offset) / least * least;
    chunk.used = std::min(m_chunkBytes,
                          (offset + size + kStagingAlignment - 1) / kStagingAlignment * kStagingAlignment);
    return {&chunk.buffer, offset, chunk.buffer.Mapped().subspan(offset, size)};
}

// Makes a second write of bytes that this list writes already wait for the first.
void Uploader::SeparateOverlap(VkBuffer buffer, uint64_t begin, uint64_t end) {
    const auto after = m_written.lower_bound({buffer, end});
    if (after != m_written.begin()) {
        const auto& [key, previousEnd] = *std::prev(after);
        if (key.first == buffer && previousEnd > begin) {
            List().FullBarrier();
            m_written.clear();
        }
    }
    m_written[{buffer, begin}] = end;
}

bool Uploader::NeedsSharing() const {
    return m_desc.queue != QueueKind::Main && m_device.QueueFamilies().size() > 1;
}

void Uploader::UploadBuffer(const Buffer& target, uint64_t offset, std::span<const std::byte> bytes) {
    const std::string subject = "buffer '" + target.Desc().name + "'";
    if (!Has(target.Desc().usage, BufferUsage::CopyDestination))
        RejectCopy(subject, "it has no usage CopyDestination");
    if (NeedsSharing() && !target.IsShared())
        RejectCopy(subject, "it belongs to the main queue, the upload is for the transfer queue");
    if (bytes.size() > target.Size() || offset > target.Size() - bytes.size())
        RejectCopy(subject, Text("{} bytes at {}, it has {}", bytes.size(), offset, target.Size()));
    while (!bytes.empty()) {
        const Staged staged = Stage(bytes.size(), 1);
        std::memcpy(staged.bytes.data(), bytes.data(), staged.bytes.size());
        CommandList& list = List();
        SeparateOverlap(target.Handle(), offset, offset + staged.bytes.size());
        list.CopyBuffer(*staged.buffer, staged.offset, target, offset, staged.bytes.size());
        offset += staged.bytes.size();
        bytes = bytes.subspan(staged.bytes.size());
    }
}

void Uploader::CheckTexture(const Texture& target, std::span<const std::span<const std::byte>> levels) const {
    const TextureDesc& desc = target.Desc();
    const std::string subject = "texture '" + desc.name + "' (" + Name(desc.format) + ")";
    if (!Has(desc.usage, TextureUsage::CopyDestination))
        RejectCopy(subject, "it has no usage CopyDestination");
    if (levels.empty() || levels.size() > desc.mipLevels)
        RejectCopy(subject, Text("{} mip levels given, it has {}", levels.size(), desc.mipLevels));
    for (uint32_t level = 0; level < levels.size(); ++level)
        if (levels[level].size() != LevelBytes(target, level))
            RejectCopy(subject, Text("mip level {} has {} bytes, given are {}", level,
                                     LevelBytes(target, level), levels[level].size()));
    if (RowBytes(target, 0) > m_chunkBytes)
        RejectCopy(subject, Text("a row is larger than a staging chunk ({} bytes)", m_chunkBytes));
    if (NeedsSharing() && !target.IsShared())
        RejectCopy(subject, "it belongs to the main queue, the upload is for the transfer queue");
    if (desc.layers != 1) RejectCopy(subject, Text("it has {} layers, an upload is for one", desc.layers));
    if (levels.size() == desc.mipLevels) return;
    if (!Has(desc.usage, TextureUsage::CopySource))
        RejectCopy(subject, "its other mip levels cannot be made, it has no usage CopySource");
    if (!m_device.CanGenerateMips(desc.format))
        RejectCopy(subject,
                   "its other mip levels cannot be made, the format cannot be filtered on this device");
}

void Uploader::UploadTexture(const Texture& target, std::span<const std::span<const std::byte>> levels) {
    TextureTransfer transfer{.target = &target, .levels = {levels.begin(), levels.end()}};
    Continue(transfer, UINT64_MAX);
}

uint64_t Uploader::Continue(TextureTransfer& transfer, uint64_t budget) {
    const Texture& target = *transfer.target;
    const TextureDesc& desc = target.Desc();
    if (!transfer.isBegun) {
        CheckTexture(target, transfer.levels);
        const VkImageMemoryBarrier2 toTransfer = MipBarrier(
            target, 0, desc.mipLevels, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        List().Barriers({}, {&toTransfer, 1});
        transfer.isBegun = true;
    }
    const uint64_t blockSide = BlockSide(desc.format);
    uint64_t copied = 0;
    while (!transfer.IsComplete() && copied < budget) {
        const Extent2D extent = MipExtent(target.Extent(), transfer.level);
        const uint64_t rowBytes = RowBytes(target, transfer.level);
        const std::span<const std::byte> bytes =
            transfer.levels[transfer.level].subspan(transfer.row / blockSide * rowBytes);
        const Staged staged = Stage(std::clamp<uint64_t>(budget - copied, rowBytes, bytes.size()), rowBytes);
        const auto rowCount = std::min(static_cast<uint32_t>(staged.bytes.size() / rowBytes * blockSide),
                                       extent.height - transfer.row);
        std::memcpy(staged.bytes.data(), bytes.data(), staged.bytes.size());
        List().CopyRowsToTexture(*staged.buffer, staged.offset, target, transfer.level, transfer.row,
                                 rowCount);
        copied += staged.bytes.size();
        transfer.row += rowCount;
        if (transfer.row < extent.height) continue;
        transfer.row = 0;
        ++transfer.level;
    }
    if (!transfer.IsComplete()) return copied;
    if (transfer.levels.size() < desc.mipLevels) {
        const auto firstLevel = static_cast<uint32_t>(transfer.levels.size());
        CommandList& copies = List();
        const bool isOnMain = m_desc.queue == QueueKind::Main;
        if (!isOnMain && !m_mipList) m_mipList = m_device.BeginCommands(m_desc.name + " mips");
        GenerateMips(isOnMain ? copies : *m_mipList, target, firstLevel);
        return copied;
    }
    const VkImageMemoryBarrier2 toShader =
        MipBarrier(target, 0, desc.mipLevels, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                   VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    List().Barriers({}, {&toShader, 1});
    return copied;
}

// Requires all levels in TRANSFER_DST_OPTIMAL, and texels in those below `firstLevel`.
void Uploader::GenerateMips(CommandList& list, const Texture& target, uint32_t firstLevel) {
    const uint32_t levelCount = target.Desc().mipLevels;
    for (uint32_t level = firstLevel; level < levelCount; ++level) {
        const VkImageMemoryBarrier2 toSource = MipBarrier(
            target, level - 1, 1, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        list.Barriers({}, {&toSource, 1});
        list.BlitMip(target, level);
    }
    std::vector<VkImageMemoryBarrier2> toShader;
    const auto add = [&](uint32_t first, uint32_t end, VkImageLayout from) {
        if (first < end)
            toShader.push_back(
                MipBarrier(target, first, end - first, from, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL));
    };
    add(0, firstLevel - 1, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    add(firstLevel - 1, levelCount - 1, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    add(levelCount - 1, levelCount, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    list.Barriers({}, toShader);
}

uint64_t Uploader::StagingBytes() const {
    return m_chunks.size() * m_chunkBytes;
}

// --- Readback ---

namespace {

[[noreturn]] void RejectCopy(const std::string& kind, const std::string& name, const std::string& reason) {
    throw MakeError(ErrorKind::Usage, "readback of {} '{}': {}", kind, name, reason);
}

Buffer StagingFor(Device& device, const std::string& name, uint64_t size) {
    return device.CreateBuffer({.name = "readback of " + name,
                                .size = size,
                                .usage = BufferUsage::CopyDestination,
                                .memory = MemoryKind::Readback});
}

// The host is a reader like any other: waiting for the timeline does not make writes visible to it.
void ReleaseToHost(CommandList& commands) {
    VkMemoryBarrier2 barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2;
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
    barrier.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
    commands.Barriers({&barrier, 1}, {});
}

std::vector<std::byte> SubmitAndWait(Device& device, CommandList&& commands, Readback& readback) {
    readback.SetSubmitted(device.Submit(std::move(commands)));
    const std::span<const std::byte> bytes = readback.Wait();
    return {bytes.begin(), bytes.end()};
}

}  // namespace

Readback Readback::Record(CommandList& commands, const Buffer& source, uint64_t offset, uint64_t size) {
    const std::string& name = source.Desc().name;
    if (!Has(source.Desc().usage, BufferUsage::CopySource))
        RejectCopy("buffer", name, "it has no usage CopySource");
    if (size == VK_WHOLE_SIZE && offset <= source.Size()) size = source.Size() - offset;
    if (size == 0 || size > source.Size() || offset > source.Size() - size)
        RejectCopy("buffer", name, Text("{} bytes at {}, it has {}", size, offset, source.Size()));
    Readback readback;
    readback.m_device = &commands.Owner();
    readback.m_staging = StagingFor(commands.Owner(), name, size);
    commands.FullBarrier();
    commands.CopyBuffer(source, offset, readback.m_staging, 0, size);
    ReleaseToHost(commands);
    return readback;
}

Readback Readback::Record(CommandList& commands, const Texture& source, VkImageLayout layout,
                          uint32_t mipLevel, uint32_t layer) {
    const TextureDesc& desc = source.Desc();
    if (!Has(desc.usage, TextureUsage::CopySource))
        RejectCopy("texture", desc.name, "it has no usage CopySource");
    if (mipLevel >= desc.mipLevels)
        RejectCopy("texture", desc.name, Text("mip level {}, it has {}", mipLevel, desc.mipLevels));
    if (layer >= desc.layers)
        RejectCopy("texture", desc.name, Text("layer {}, it has {}", layer, desc.layers));
    const Extent2D extent = MipExtent(desc.extent, mipLevel);
    Readback readback;
    readback.m_device = &commands.Owner();
    readback.m_staging = StagingFor(commands.Owner(), desc.name, ImageBytes(desc.format, extent));
    commands.Transition(source, layout, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    commands.CopyToBuffer(source, readback.m_staging, 0, mipLevel, layer);
    ReleaseToHost(commands);
    if (layout != VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL)
        commands.Transition(source, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, layout);
    return readback;
}

bool Readback::IsReady() const {
    return m_submission && m_device->HasCompleted(m_submission);
}

std::span<const std::byte> Readback::Bytes() const {
    if (!IsReady()) throw MakeError(ErrorKind::Usage, "'{}' is not ready", m_staging.Desc().name);
    return m_staging.Mapped();
}

std::span<const std::byte> Readback::Wait() {
    if (!m_submission) throw MakeError(ErrorKind::Usage, "'{}' was not submitted", m_staging.Desc().name);
    m_device->WaitFor(m_submission);
    return m_staging.Mapped();
}

std::vector<std::byte> ReadBuffer(Device& device, const Buffer& source, uint64_t offset, uint64_t size) {
    CommandList commands = device.BeginCommands("read back " + source.Desc().name);
    Readback readback = Readback::Record(commands, source, offset, size);
    return SubmitAndWait(device, std::move(commands), readback);
}

std::vector<std::byte> ReadTexture(Device& device, const Texture& source, VkImageLayout layout,
                                   uint32_t mipLevel, uint32_t layer) {
    CommandList commands = device.BeginCommands("read back " + source.Desc().name);
    Readback readback = Readback::Record(commands, source, layout, mipLevel, layer);
    return SubmitAndWait(device, std::move(commands), readback);
}

}  // namespace raygraph::rhi
