// TextureSet: the textures of a scene on the device, and the table in which shaders find them. Textures come
// and go; the others keep their indices and their slots. Threads: as rhi::Device says.
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

// An image on the device, in SHADER_READ_ONLY_OPTIMAL.
struct SceneImage {
    rhi::Texture texture;
    std::shared_ptr<const rhi::Texture> hostTexture;  // in its place: one of a host
    uint64_t bytes = 0;                               // of all levels; 0 of a host's own
    bool isReduced = false;    // smaller than the image it was made of, to fit the budget
    float lowestAlpha = 0.0f;  // no texel has less

    const rhi::Texture& Shown() const { return hostTexture ? *hostTexture : texture; }
};

struct SceneTexture {
    std::shared_ptr<const SceneImage> image;  // textures that differ in their samplers alone share one
    scene::Sampler sampler;
};

class TextureSet {
  public:
    // The defaults are in slots without a texture, which a shader may look at; they outlive the set.
    TextureSet(rhi::Device& device, const rhi::Texture& defaultTexture, const rhi::Sampler& defaultSampler,
               float maxAnisotropy);

    // The index of each. On an Error nothing has changed: Error{Usage} for more than a table can have.
    std::vector<uint32_t> Add(std::span<const SceneTexture> textures);
    // The index may be used again; frames in flight read the texture to their end.
    void Remove(uint32_t index);

    // Indices are below that.
    uint32_t Size() const { return static_cast<uint32_t>(m_entries.size()); }
    bool Exists(uint32_t index) const { return index < m_entries.size() && m_entries[index].image; }
    uint32_t Count() const { return m_count; }
    uint32_t Slot(uint32_t index) const { return m_entries[index].slot; }
    const SceneImage& Image(uint32_t index) const { return *m_entries[index].image; }
    const rhi::TextureTable& Table() const { return *m_table; }
    uint64_t Bytes() const;  // of all images
    uint32_t ReducedImages() const;

  private:
    struct Entry {
        std::shared_ptr<const SceneImage> image;  // null: free
        uint32_t slot = 0;
    };
    void Reserve(uint32_t slots);
    const rhi::Sampler& SamplerFor(const scene::Sampler& wanted);
    std::vector<const SceneImage*> Images() const;

    rhi::Device& m_device;
    float m_maxAnisotropy;
    std::vector<scene::Sampler> m_samplerDescs;
    std::vector<rhi::Sampler> m_samplers;  // few: equal ones are shared
    std::vector<Entry> m_entries;
    uint32_t m_count = 0;
    std::unique_ptr<rhi::TextureTable> m_table;  // declared after what is in it
};

}  // namespace raygraph
