// The textures of a scene on the device: TextureSet, with the table by which shaders index them;
// TextureUpload, which copies them; and the passes that make their mip levels. In TextureSet, adding and
// removing does not change the indices and slots of others. Threads: TextureSet: as rhi::Device says;
// TextureUpload: that of its uploader; passes: that of the Renderer.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/api.h"
#include "renderer/graph/renderer.h"
#include "renderer/scene/model/scene_data.h"
#include "rhi/device.h"
#include "rhi/resources.h"
#include "rhi/texture_table.h"
#include "rhi/transfer.h"

namespace raygraph {

// Describes an image on the device, in the layout SHADER_READ_ONLY_OPTIMAL.
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
    // Exchanges what two indices stand for; slots keep their textures.
    void Swap(uint32_t a, uint32_t b) noexcept { std::swap(m_entries[a], m_entries[b]); }

    // Returns a number above all indices.
    uint32_t Size() const { return static_cast<uint32_t>(m_entries.size()); }
    bool Exists(uint32_t index) const { return index < m_entries.size() && m_entries[index].image; }
    uint32_t Count() const { return m_count; }
    uint32_t Slot(uint32_t index) const { return m_entries[index].slot; }
    const SceneImage& Image(uint32_t index) const { return *m_entries[index].image; }
    const scene::Sampler& SamplerOf(uint32_t index) const { return m_entries[index].sampler; }
    const rhi::TextureTable& Table() const { return *m_table; }
    uint64_t Bytes() const;  // sum over all images
    uint32_t ReducedImages() const;

  private:
    struct Entry {
        std::shared_ptr<const SceneImage> image;  // null: the index is free
        uint32_t slot = 0;
        scene::Sampler sampler = {};
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

// --- Uploads ---
// They copy the textures of a scene with the levels that fit, and make those levels on the device: all at
// once, or each when it is needed, in pieces.

struct TextureUploadSettings {
    bool makesMipLevels = false;   // for textures whose samplers filter by levels
    uint64_t budget = UINT64_MAX;  // bytes of all textures
    float maxAnisotropy = 1.0f;    // for textures with levels that are filtered linearly
};

class TextureUpload {
  public:
    // Plans which levels fit. Keeps references to the device, the uploader, and the textures, images and
    // materials of the scene.
    TextureUpload(rhi::Device& device, rhi::Uploader& uploader, scene::SceneData& scene,
                  const TextureUploadSettings& settings);
    ~TextureUpload();
    TextureUpload(TextureUpload&& other) noexcept;

    // Continues with the texture, or with one on which it depends, and copies about `budget` bytes at most,
    // which it subtracts. Returns true once the texture is complete, with the making of its mip levels at
    // least submitted. At most two images are in work on the device: beyond that the call waits, or returns
    // false if mayWait is false. Frees each image after its last use.
    bool Continue(uint32_t texture, uint64_t& budget, bool mayWait = true);
    // Returns whether the device still makes mip levels; the destructor waits for that.
    bool IsBusy() const;
    // Requires that the texture is complete.
    SceneTexture Get(uint32_t texture) const;
    // Bytes that all textures together will have copied in the end, and bytes copied so far.
    uint64_t Bytes() const;
    uint64_t CopiedBytes() const;
    // Returns the bytes that incomplete textures will take on the device.
    uint64_t PendingBytes() const;
    // Returns the message that images were made smaller; empty if none were.
    const std::string& Reduction() const;

  private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

// Returns half of what the process may use of the largest heap of device memory, but no more than is left of
// it.
uint64_t DefaultTextureBudget(const rhi::Device& device);

// --- Passes that make the mip levels of a material texture ---

// The kind of texels of a texture, which says how they are averaged.
enum class TexelContent : uint8_t {
    Data,              // averaged as they are
    Color,             // sRGB with linear alpha, averaged in linear light
    TransparentColor,  // as Color, weighted by alpha
    Normals,           // unit vectors, encoded from [-1, 1]; those of each level are normalized again
};

// Holds the means of an image as floats (rgba32f), from its level 1 on: the values before encoding.
struct TextureMeans {
    TextureId levels;
    Extent2D extent;  // that of the image
};

// Describes a texture with roughness in its green channel, and the normal map that bends its surface.
struct RoughnessWidening {
    TextureMeans normals;  // means of its normal map, at the same texture coordinates
    // The levels of the normal map's image that materials read. The variance of levels before the first is
    // visible nowhere, and the detail of the last one at any distance.
    uint32_t firstNormals = 0, lastNormals = UINT32_MAX;
    float normalScale = 1.0f;
    float roughnessFactor = 1.0f;  // greater than 0
};

struct TextureLevelSettings {
    TexelContent content = TexelContent::Data;
    std::optional<RoughnessWidening> widening;
    std::optional<TextureId> means;  // rgba32f, for a normal map: its level 1 and all below
    uint32_t firstLevel = 0;         // level of the image that is the target's level 0
};

struct TextureLevels {
    TextureId texture;                  // the target
    std::optional<TextureMeans> means;  // empty for an image of one texel
};

// Fills all levels of the target. `image` is rgba8 with one level; the target has a format of four bytes per
// texel, the size of level `firstLevel` of the image, and any number of levels. Level 0 is the image itself
// if firstLevel is 0. Each level is the mean of the one above over the area of its texels, also if that has
// an odd number of them, computed in floats that are rounded once. A roughness grows by the variance of the
// normals that a texel covers: highlights keep their width in the picture as details of the normal map vanish
// (the formulas are in shaders/scene/texture_level_main.glsl). The target's level 0, which is also read from
// near, grows by the variance of the levels before firstNormals alone. Throws Error{Usage} for sizes that do
// not fit.
[[nodiscard]] RAYGRAPH_API TextureLevels MakeTextureLevels(Renderer& renderer, TextureId image,
                                                           TextureId target,
                                                           const TextureLevelSettings& settings);

}  // namespace raygraph
