#include "renderer/graph/persistent_store.h"

namespace raygraph {

namespace {

// Whatever later frames may do with it: what a persistent resource holds could not follow it into a new one.
rhi::TextureUsage UsageFor(rhi::Format format) {
    using rhi::TextureUsage;
    const TextureUsage common =
        TextureUsage::Sampled | TextureUsage::CopySource | TextureUsage::CopyDestination;
    if (rhi::IsDepth(format)) return common | TextureUsage::DepthTarget;
    switch (format) {
        // Storage of these is not a format that every device has.
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

Persistent& PersistentStore::FindKind(std::string_view name, ResourceKind kind) {
    auto entry = m_entries.find(name);
    if (entry != m_entries.end() && entry->second.kind == kind) return entry->second;
    if (entry != m_entries.end()) m_entries.erase(entry);
    entry = m_entries.emplace(std::string(name), Persistent{}).first;
    entry->second.name = entry->first;
    entry->second.kind = kind;
    return entry->second;
}

Persistent& PersistentStore::Find(std::string_view name, const GraphTextureDesc& desc) {
    Persistent& found = FindKind(name, ResourceKind::Texture);
    if (found.textureDesc != desc) {
        found = Persistent{};
        found.name = name;
        found.kind = ResourceKind::Texture;
        found.textureDesc = desc;
    }
    return found;
}

Persistent& PersistentStore::Find(std::string_view name, const GraphBufferDesc& desc) {
    Persistent& found = FindKind(name, ResourceKind::Buffer);
    if (found.bufferDesc != desc) {
        found = Persistent{};
        found.name = name;
        found.kind = ResourceKind::Buffer;
        found.bufferDesc = desc;
    }
    return found;
}

Persistent* PersistentStore::Declared(std::string_view name, uint64_t frame) {
    const auto entry = m_entries.find(name);
    return entry != m_entries.end() && entry->second.lastFrame == frame ? &entry->second : nullptr;
}

void PersistentStore::Ensure(rhi::Device& device, Persistent& persistent) {
    if (persistent.IsMade()) return;
    if (persistent.kind == ResourceKind::Texture)
        persistent.texture = device.CreateTexture({.name = persistent.name,
                                                   .extent = persistent.textureDesc.extent,
                                                   .format = persistent.textureDesc.format,
                                                   .usage = UsageFor(persistent.textureDesc.format)});
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
