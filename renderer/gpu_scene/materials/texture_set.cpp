#include "renderer/gpu_scene/materials/texture_set.h"

#include <algorithm>
#include <utility>

#include "base/text.h"

namespace raygraph {
namespace {

rhi::Filter ToRhi(scene::FilterMode mode) {
    return mode == scene::FilterMode::Nearest ? rhi::Filter::Nearest : rhi::Filter::Linear;
}

rhi::AddressMode ToRhi(scene::WrapMode mode) {
    switch (mode) {
        case scene::WrapMode::Repeat:
            return rhi::AddressMode::Repeat;
        case scene::WrapMode::MirroredRepeat:
            return rhi::AddressMode::MirroredRepeat;
        case scene::WrapMode::ClampToEdge:
            return rhi::AddressMode::ClampToEdge;
    }
    return rhi::AddressMode::Repeat;
}

}  // namespace

TextureSet::TextureSet(rhi::Device& device, const rhi::Texture& defaultTexture,
                       const rhi::Sampler& defaultSampler, float maxAnisotropy)
    : m_device(device),
      m_maxAnisotropy(maxAnisotropy),
      m_table(std::make_unique<rhi::TextureTable>(device, 1, defaultTexture, defaultSampler)) {}

const rhi::Sampler& TextureSet::SamplerFor(const scene::Sampler& wanted) {
    const auto found = std::ranges::find(m_samplerDescs, wanted);
    if (found != m_samplerDescs.end()) return m_samplers[static_cast<size_t>(found - m_samplerDescs.begin())];
    const bool isSmooth = wanted.usesMips && wanted.minFilter == scene::FilterMode::Linear;
    m_samplers.reserve(m_samplers.size() + 1);
    m_samplerDescs.reserve(m_samplers.size() + 1);
    m_samplers.push_back(m_device.CreateSampler({.name = "material sampler",
                                                 .magFilter = ToRhi(wanted.magFilter),
                                                 .minFilter = ToRhi(wanted.minFilter),
                                                 .mipFilter = ToRhi(wanted.mipFilter),
                                                 .addressU = ToRhi(wanted.wrapU),
                                                 .addressV = ToRhi(wanted.wrapV),
                                                 .maxAnisotropy = isSmooth ? m_maxAnisotropy : 1.0f}));
    m_samplerDescs.push_back(wanted);
    return m_samplers.back();
}

// Slots that were just removed are still in use by frames in flight, so that the table grows past them.
void TextureSet::Reserve(uint32_t slots) {
    if (m_table->FreeCount() >= slots) return;
    const uint32_t needed = m_table->Capacity() - m_table->FreeCount() + slots;
    const uint32_t doubled = std::min(2 * m_table->Capacity(), rhi::kMaxTextureTableSlots);
    if (needed > rhi::kMaxTextureTableSlots)
        throw MakeError(ErrorKind::Usage, "GpuScene: {} textures, a shader can read {}", needed,
                        rhi::kMaxTextureTableSlots);
    m_table =
        std::make_unique<rhi::TextureTable>(m_device, std::max(needed, m_count > 0 ? doubled : 1), *m_table);
}

std::vector<uint32_t> TextureSet::Add(std::span<const SceneTexture> textures) {
    std::vector<uint32_t> indices;
    for (uint32_t i = 0; i < m_entries.size() && indices.size() < textures.size(); ++i)
        if (!m_entries[i].image) indices.push_back(i);
    const auto size = static_cast<uint32_t>(m_entries.size() + textures.size() - indices.size());
    for (auto i = static_cast<uint32_t>(m_entries.size()); i < size; ++i) indices.push_back(i);
    std::vector<const rhi::Sampler*> samplers;
    for (const SceneTexture& texture : textures) SamplerFor(texture.sampler);
    for (const SceneTexture& texture : textures) samplers.push_back(&SamplerFor(texture.sampler));
    Reserve(static_cast<uint32_t>(textures.size()));
    m_entries.resize(size);
    for (size_t i = 0; i < textures.size(); ++i)
        m_entries[indices[i]] = {textures[i].image, m_table->Add(textures[i].image->Shown(), *samplers[i])};
    m_count += static_cast<uint32_t>(textures.size());
    return indices;
}

void TextureSet::Remove(uint32_t index) {
    m_table->Remove(std::exchange(m_entries[index], {}).slot);
    --m_count;
}

std::vector<const SceneImage*> TextureSet::Images() const {
    std::vector<const SceneImage*> images;
    for (const Entry& entry : m_entries)
        if (entry.image) images.push_back(entry.image.get());
    std::ranges::sort(images);
    images.erase(std::unique(images.begin(), images.end()), images.end());
    return images;
}

uint64_t TextureSet::Bytes() const {
    uint64_t bytes = 0;
    for (const SceneImage* image : Images()) bytes += image->bytes;
    return bytes;
}

uint32_t TextureSet::ReducedImages() const {
    return static_cast<uint32_t>(std::ranges::count_if(Images(), &SceneImage::isReduced));
}

}  // namespace raygraph
