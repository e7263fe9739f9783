#include "renderer/graph/persistent_store.h"

namespace raygraph {

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

void PersistentStore::Forget(std::string_view name) {
    const auto entry = m_entries.find(name);
    if (entry != m_entries.end()) m_entries.erase(entry);
}

}  // namespace raygraph
