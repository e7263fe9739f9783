// TextureSet: the textures of a scene on the device, and the table by which shaders index them. Adding and
// removing does not change the indices and slots of others. Threads: as rhi::Device says.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "renderer/scene/model/scene_data.h"
#include "rhi/device.h"
#include "rhi/resources.h"
#include "rhi/texture_table.h"

namespace raygraph {

// An image on the device, in the layout SHADER_READ_ONLY_OPTIMAL.
struct SceneImage {
    rhi::Texture texture;
    std::shared_ptr<const rhi::Texture> hostTexture;  // the host's texture, if it is one
    uint64_t bytes = 0;                               // all levels; 0 for a texture of the host
    bool isReduced = false;                           // smaller than the original image, to fit the budget
    float lowestAlpha = 0.0f;                         // a lower bound of the alpha of all texels

    const rhi::Texture& Shown() const { return hostTexture ? *hostTexture : texture; }
};

struct SceneTexture {
    std::shared_ptr<const SceneImage> image;  // shared by textures that differ in their samplers alone
    scene::Sampler sampler;
};

class TextureSet {
  public:
    // The defaults fill slots without a texture, which a shader may read; they outlive the set.
    TextureSet(rhi::Device& device, const rhi::Texture& defaultTexture, const rhi::Sampler& defaultSampler,
               float maxAnisotropy);

    // Returns the index of each. On an Error nothing has changed: Error{Usage} for more textures than a table
    // can have.
    std::vector<uint32_t> Add(std::span<const SceneTexture> textures);
    // The index may be reused; frames in flight read the texture until they end.
    void Remove(uint32_t index);

    // Returns a number above all indices.
    uint32_t Size() const { return static_cast<uint32_t>(m_entries.size()); }
    bool Exists(uint32_t index) const { return index < m_entries.size() && m_entries[index].image; }
    uint32_t Count() const { return m_count; }
    uint32_t Slot(uint32_t index) const { return m_entries[index].slot; }
    const SceneImage& Image(uint32_t index) const { return *m_entries[index].image; }
    const rhi::TextureTable& Table() const { return *m_table; }
    uint64_t Bytes() const;  // sum over all images
    uint32_t ReducedImages() const;

  private:
    struct Entry {
        std::shared_ptr<const SceneImage> image;  // null: the index is free
        uint32_t slot = 0;
    };
    void Reserve(uint32_t slots);
    const rhi::Sampler& SamplerFor(const scene::Sampler& wanted);
    std::vector<const SceneImage*> Images() const;

    rhi::Device& m_device;
    float m_maxAnisotropy;
    std::vector<scene::Sampler> m_samplerDescs;
    std::vector<rhi::Sampler> m_samplers;  // equal samplers are shared, so that there are few
    std::vector<Entry> m_entries;
    uint32_t m_count = 0;
    std::unique_ptr<rhi::TextureTable> m_table;  // destroyed before what it refers to
};

}  // namespace raygraph
