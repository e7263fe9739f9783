#include "renderer/graph/resource_pool.h"

#include <algorithm>
#include <tuple>

#include "base/text.h"

namespace raygraph {

// --- PersistentStore ---

namespace {

// Returns every usage that later frames may need, since recreating a persistent resource would lose its
// contents.
rhi::TextureUsage UsageFor(rhi::Format format) {
    using rhi::TextureUsage;
    const TextureUsage common =
        TextureUsage::Sampled | TextureUsage::CopySource | TextureUsage::CopyDestination;
    if (rhi::IsDepth(format)) return common | TextureUsage::DepthTarget;
    switch (format) {
        // Not every device supports these formats as storage images.
        case rhi::Format::Rgba8Srgb:
        case rhi::Format::Bgra8Srgb:
        case rhi::Format::Bgra8Unorm:
            return common | TextureUsage::ColorTarget;
        default:
            return common | TextureUsage::ColorTarget | TextureUsage::Storage;
    }
}

constexpr rhi::BufferUsage kBufferUsage = rhi::BufferUsage::Storage | rhi::BufferUsage::Uniform |
                                          rhi::BufferUsage::Index | rhi::BufferUsage::Indirect |
                                          rhi::BufferUsage::BuildInput | rhi::BufferUsage::CopySource |
                                          rhi::BufferUsage::CopyDestination;

}  // namespace

template <typename Desc>
Persistent& PersistentStore::Find(std::string_view name, ResourceKind kind, Desc Persistent::*member,
                                  const Desc& desc) {
    const auto known = m_entries.find(name);
    if (known != m_entries.end() && known->second.Is(desc)) return known->second;
    Persistent& made = (known == m_entries.end() ? m_entries : m_replacements)[std::string(name)];
    made = Persistent{};
    made.name = name;
    made.kind = kind;
    made.*member = desc;
    return made;
}

Persistent& PersistentStore::Find(std::string_view name, const GraphTextureDesc& desc) {
    Persistent& persistent = Find(name, ResourceKind::Texture, &Persistent::textureDesc, desc);
    persistent.states.resize(size_t{desc.levels} * desc.layers);
    persistent.isWritten.resize(persistent.states.size());
    return persistent;
}

Persistent& PersistentStore::Find(std::string_view name, const GraphBufferDesc& desc) {
    return Find(name, ResourceKind::Buffer, &Persistent::bufferDesc, desc);
}

Persistent* PersistentStore::Declared(std::string_view name, uint64_t frame) {
    for (Entries* entries : {&m_replacements, &m_entries})
        if (const auto entry = entries->find(name);
            entry != entries->end() && entry->second.lastFrame == frame)
            return &entry->second;
    return nullptr;
}

void PersistentStore::CommitReplacements() {
    while (!m_replacements.empty()) {
        Entries::node_type replacement = m_replacements.extract(m_replacements.begin());
        m_entries.erase(replacement.key());
        m_entries.insert(std::move(replacement));
    }
}

void PersistentStore::Ensure(rhi::Device& device, Persistent& persistent) {
    if (persistent.IsMade()) return;
    if (persistent.kind == ResourceKind::Texture)
        persistent.texture = device.CreateTexture({.name = persistent.name,
                                                   .extent = persistent.textureDesc.extent,
                                                   .format = persistent.textureDesc.format,
                                                   .usage = UsageFor(persistent.textureDesc.format),
                                                   .mipLevels = persistent.textureDesc.levels,
                                                   .layers = persistent.textureDesc.layers});
    else
        persistent.buffer = device.CreateBuffer({.name = persistent.name,
                                                 .size = persistent.bufferDesc.size,
                                                 .usage = kBufferUsage,
                                                 .memory = persistent.bufferDesc.memory});
}

void PersistentStore::Release(std::string_view name) {
    const auto entry = m_entries.find(name);
    if (entry != m_entries.end()) m_entries.erase(entry);
}

// --- TransientPool ---

namespace {

// Resizing by drag requests a new size in every frame: a limit discards the old ones.
constexpr size_t kMaxKnown = 128;

// Returns all fields except the name. A new field of a description breaks the build until it is listed here.
auto PartsOf(const rhi::TextureDesc& desc) {
    const auto& [name, extent, format, usage, mipLevels, layers, isShared] = desc;
    return std::tie(extent, format, usage, mipLevels, layers, isShared);
}
auto PartsOf(const rhi::BufferDesc& desc) {
    const auto& [name, size, usage, memory, hasOwnMemory, isShared] = desc;
    return std::tie(size, usage, memory, hasOwnMemory, isShared);
}

// Returns true if an object that was created for `a` also serves `b`, under the same name in debuggers.
template <typename Desc>
bool IsSame(const Desc& a, const Desc& b) {
    return PartsOf(a) == PartsOf(b) && a.name == b.name;
}

bool Fits(const rhi::MemoryRequirements& needed, const rhi::MemoryRequirements& given) {
    return needed.size <= given.size && needed.alignment <= given.alignment &&
           (needed.memoryTypeBits & given.memoryTypeBits) == given.memoryTypeBits;
}

template <typename Known, typename Desc, typename Ask>
rhi::MemoryRequirements FindRequirements(std::vector<Known>& known, const Desc& desc, Ask&& ask) {
    for (const Known& entry : known)
        if (PartsOf(entry.desc) == PartsOf(desc)) return entry.requirements;
    if (known.size() >= kMaxKnown) known.clear();
    return known.emplace_back(Known{desc, ask()}).requirements;
}

template <typename Entries, typename Desc, typename Make>
auto& FindPlaced(Entries& entries, const Desc& desc, uint64_t frame, Make&& make) {
    using Entry = typename Entries::value_type::element_type;
    for (auto& entry : entries) {
        if (entry->lastFrame == frame || !IsSame(entry->object.Desc(), desc)) continue;
        entry->lastFrame = frame;
        return *entry;
    }
    entries.push_back(std::make_unique<Entry>(Entry{make(), frame}));
    return *entries.back();
}

template <typename Entries>
void DropUnused(Entries& entries, uint64_t frame) {
    std::erase_if(entries,
                  [&](const auto& entry) { return entry->lastFrame + TransientPool::kKeepFrames < frame; });
}

}  // namespace

rhi::MemoryRequirements TransientPool::RequirementsOf(const rhi::TextureDesc& desc) {
    return FindRequirements(m_knownTextures, desc, [&] { return m_device.RequirementsOf(desc); });
}

rhi::MemoryRequirements TransientPool::RequirementsOf(const rhi::BufferDesc& desc) {
    return FindRequirements(m_knownBuffers, desc, [&] {
        rhi::MemoryRequirements requirements = m_device.RequirementsOf(desc);
        // The alignment is that of Device::CreateBuffer: the start of a buffer can serve as scratch memory of
        // a build.
        requirements.alignment = std::max<uint64_t>(requirements.alignment, m_device.Info().scratchAlignment);
        return requirements;
    });
}

bool TransientPool::Reserve(std::span<const rhi::MemoryRequirements> blocks, uint64_t frame) {
    bool areKept = true;
    if (m_blocks.size() < blocks.size()) m_blocks.resize(blocks.size());
    for (size_t b = 0; b < blocks.size(); ++b) {
        Block& block = m_blocks[b];
        const bool isOversized = block.memory && blocks[b].size < block.memory.Requirements().size / 4;
        if (!isOversized) block.lastFitting = frame;
        const bool isTooLarge = block.lastFitting + kKeepFrames < frame;
        if (!block.memory || isTooLarge || !Fits(blocks[b], block.memory.Requirements())) {
            areKept = false;
            block.textures.clear();
            block.buffers.clear();
            block.memory = {};
            block.memory = m_device.CreateMemoryBlock(Text("transient block {}", b), blocks[b]);
            block.lastFitting = frame;
        }
        block.lastFrame = frame;
    }
    return areKept;
}

TransientPool::Placed<rhi::Texture>& TransientPool::Place(const rhi::TextureDesc& desc, uint32_t block,
                                                          uint64_t frame) {
    return FindPlaced(m_blocks[block].textures, desc, frame,
                      [&] { return m_device.CreateTexture(desc, m_blocks[block].memory); });
}

TransientPool::Placed<rhi::Buffer>& TransientPool::Place(const rhi::BufferDesc& desc, uint32_t block,
                                                         uint64_t frame) {
    return FindPlaced(m_blocks[block].buffers, desc, frame,
                      [&] { return m_device.CreateBuffer(desc, m_blocks[block].memory); });
}

const rhi::Buffer& TransientPool::TakeUpload(const rhi::BufferDesc& desc, uint64_t frame) {
    const uint64_t framesInFlight = m_device.FramesInFlight();
    for (auto& entry : m_uploads) {
        const bool isFree = entry->lastFrame + framesInFlight <= frame;
        if (!isFree || !IsSame(entry->object.Desc(), desc)) continue;
        entry->lastFrame = frame;
        return entry->object;
    }
    m_uploads.push_back(
        std::make_unique<Placed<rhi::Buffer>>(Placed<rhi::Buffer>{m_device.CreateBuffer(desc), frame}));
    return m_uploads.back()->object;
}

void TransientPool::Trim(uint64_t frame) {
    for (Block& block : m_blocks) {
        DropUnused(block.textures, frame);
        DropUnused(block.buffers, frame);
        if (block.lastFrame + kKeepFrames >= frame) continue;
        block.textures.clear();
        block.buffers.clear();
        block.memory = {};
    }
    DropUnused(m_uploads, frame);
}

}  // namespace raygraph
