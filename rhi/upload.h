// Uploader: data from the CPU into Device memory, through a bounded ring of staging memory.
//
// What is passed in is copied before a call returns; the caller may free it. The copies are recorded into
// lists of the uploader's own, submitted whenever a chunk of staging memory is full and by Flush, so that the
// device copies one chunk while the CPU fills the next. A chunk is used again once the timeline has passed
// its submission; only when every chunk is still in flight does a call wait, for the oldest one. The device
// is never drained. Ordering: uploads come after all work submitted before them, and all work submitted after
// them sees their data, on the one queue: waiting for the returned value is only needed to know that the data
// is there, not to use it. Threads: one at a time. Flush before commands that need the data are submitted.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/api.h"
#include "rhi/command_list.h"
#include "rhi/resources.h"

namespace raygraph::rhi {

struct UploaderDesc {
    std::string name = "uploader";
    uint64_t stagingBytes = uint64_t{64} << 20;  // of all chunks together; taken as they are needed
    uint32_t chunkCount = 4;                     // at least 2, so that copying and filling overlap
};

class RAYGRAPH_API Uploader {
  public:
    // Throws Error{Usage} for fewer than 2 chunks or chunks below 64 KiB.
    explicit Uploader(Device& device, const UploaderDesc& desc = {});
    ~Uploader();  // what was not flushed is dropped
    Uploader(const Uploader&) = delete;
    Uploader& operator=(const Uploader&) = delete;

    // Into a buffer with BufferUsage::CopyDestination. Throws Error{Usage} naming the buffer when it does not
    // fit.
    void UploadBuffer(const Buffer& target, uint64_t offset, std::span<const std::byte> bytes);

    // All texels of a texture with TextureUsage::CopyDestination: `levels` holds one span a mip level,
    // tightly packed rows from the top. What the texture held before is lost; it ends in
    // SHADER_READ_ONLY_OPTIMAL. Fewer levels than the texture has: the others are made by halving (linear
    // filter; sRGB formats are filtered as linear light), which needs TextureUsage::CopySource and a format
    // that can be filtered. Throws Error{Usage} naming the texture and what does not fit.
    void UploadTexture(const Texture& target, std::span<const std::span<const std::byte>> levels);
    void UploadTexture(const Texture& target, std::span<const std::byte> level0) {
        UploadTexture(target, std::span(&level0, 1));
    }

    // Submits what is recorded. Returns the timeline value at which all uploads so far have arrived.
    uint64_t Flush();

    // Runs what uploads and flushes it. After an Error nothing stays recorded: the list would refer to what
    // is given up, and keep it from being freed. What has been submitted on the way stays.
    template <typename Run>
    void FlushAfter(Run&& run) {
        try {
            run();
            Flush();
        } catch (...) {
            Drop();
            throw;
        }
    }

    // Bytes of staging memory taken so far: at most UploaderDesc::stagingBytes.
    uint64_t StagingBytes() const;
    // Times that a call had to wait for a chunk.
    uint64_t WaitCount() const { return m_waitCount; }

  private:
    struct Chunk {
        Buffer buffer;
        uint64_t used = 0;
        uint64_t until = 0;  // in flight until the timeline reaches this
    };
    struct Staged {
        const Buffer* buffer;
        uint64_t offset;
        std::span<std::byte> bytes;
    };
    CommandList& List();
    void Drop();
    // Room for at least `least` and at most `wanted` bytes, a multiple of `least`; submits and moves on to
    // another chunk when the present one has less.
    Staged Stage(uint64_t wanted, uint64_t least);
    void NextChunk();
    void SeparateOverlap(VkBuffer buffer, uint64_t begin, uint64_t end);
    void CheckTexture(const Texture& target, std::span<const std::span<const std::byte>> levels) const;
    void GenerateMips(const Texture& target, uint32_t firstLevel);

    Device& m_device;
    UploaderDesc m_desc;
    uint64_t m_chunkBytes;
    std::vector<Chunk> m_chunks;
    size_t m_current = 0;
    CommandList m_list;
    bool m_isRecording = false;
    // Ranges written since the last barrier, by buffer and begin: two writes of one range must not race.
    std::map<std::pair<VkBuffer, uint64_t>, uint64_t> m_written;
    uint64_t m_lastValue = 0;
    uint64_t m_waitCount = 0;
};

}  // namespace raygraph::rhi
