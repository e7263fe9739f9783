// SceneMaterials: the materials and textures of a scene on the device. Adding and removing does not change
// the numbers of others. The trace features of the materials are computed when something has changed, not in
// every frame. Threads: that of the Renderer.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "renderer/gpu_scene/device_array.h"
#include "renderer/gpu_scene/materials/texture_set.h"
#include "renderer/gpu_scene/record_table.h"
#include "renderer/scene/model/scene_data.h"
#include "shaders/shared/scene_records.h"
#include "shaders/shared/trace_options.h"

namespace raygraph {

struct GroupResources;
struct SceneGeometry;
struct SceneIds;

class SceneMaterials {
  public:
    // Both defaults fill slots without a texture, and outlive this object.
    SceneMaterials(rhi::Device& device, const rhi::Texture& defaultTexture,
                   const rhi::Sampler& defaultSampler, float maxAnisotropy);

    // These calls return numbers, and change nothing on an Error. `textureNumbers` are the numbers of the
    // textures that the materials count from 0.
    std::vector<uint32_t> Add(std::span<const scene::Material> added,
                              std::span<const uint32_t> textureNumbers);
    std::vector<uint32_t> AddTextures(std::span<const SceneTexture> added);
    // These calls remove what nothing uses.
    void Remove(uint32_t material) noexcept;
    void RemoveTexture(uint32_t texture);
    struct ChangedRecord {
        uint32_t material = 0;
        gpu::MaterialRecord record;
        float textureAlpha = 1.0f;
    };
    // Returns what materials are to be exchanged with when SwapTextures exchanges the images of two textures,
    // and of the next two, and so on, because slots change.
    std::vector<ChangedRecord> ChangedBySwap(std::span<const uint32_t> a, std::span<const uint32_t> b) const;
    void SwapTextures(std::span<const uint32_t> a, std::span<const uint32_t> b) noexcept;
    // Gives a material the record and texture alpha, and returns those that it had in their place.
    void Exchange(ChangedRecord& changed) noexcept;
    // Must be called when groups have been added (1) or are about to be removed (-1): each of their parts
    // uses its material, in every variant.
    void CountUsers(std::span<const GroupResources> groups, int change) noexcept;
    // Parts of groups have materials of another variant: the next Declare computes the features again.
    void MarkFeaturesDirty() noexcept { m_featuresDirty = true; }

    // Returns a number above all numbers of materials; some numbers below it may be free (Exists).
    uint32_t Size() const { return static_cast<uint32_t>(m_records.Size()); }
    bool Exists(uint32_t material) const { return material < m_uses.size() && m_uses[material].exists; }
    std::span<const gpu::MaterialRecord> Records() const { return m_records.Records(); }
    // Returns lower bounds of the alpha of the base color's texture, by material; 1 without a texture.
    std::span<const float> TextureAlphas() const { return m_textureAlphas; }
    uint32_t PartCount(uint32_t material) const { return m_uses[material].partCount; }
    const TextureSet& Textures() const { return *m_textures; }
    // Number of materials that read it.
    uint32_t MaterialCount(uint32_t texture) const { return m_textureUses[texture]; }

    void Upload(rhi::Uploader& uploader) { m_records.Upload(uploader); }
    // Uploads the changes, and sets `materials`, `textures` and `features`.
    void Declare(Renderer& renderer, SceneIds& ids, const SceneGeometry& geometry);
    // Returns how often the features have been computed.
    uint64_t FeatureUpdates() const { return m_featureUpdates; }

  private:
    // Holds the properties of a material that the host keeps beside its record.
    struct Use {
        std::vector<uint32_t> textures;  // textures that it reads, each once
        uint32_t partCount = 0;          // parts that have it in some variant
        bool exists = true;
    };

    DeviceArray<gpu::MaterialRecord> m_records;
    std::vector<Use> m_uses;
    std::vector<float> m_textureAlphas;
    SlotRanges m_slots;
    std::unique_ptr<TextureSet> m_textures;
    std::vector<uint32_t> m_textureUses;  // by texture: number of materials that read it
    TraceFeatures m_features;
    bool m_featuresDirty = true;
    uint64_t m_featureUpdates = 0;
};

// --- The trace features that the materials of a scene need: all others are compiled out of pipelines ---

struct SceneGeometry;  // renderer/gpu_scene/geometry/scene_geometry.h

// Tells whether microfacets with that roughness, which a texture (or gpu::kNoTexture) scales down, may
// reflect in a single direction somewhere (bxdf/microfacet.glsl, IsEffectivelySmooth).
bool MayBeSmooth(float roughness, uint32_t texture);

// Returns the features of kinds Textures, Lobes, Media and Hits (except MeshLights) that the meshes need
// somewhere, and those of all materials that their parts have in the variant that is shown. O(n log n).
TraceFeatures MaterialFeatures(std::span<const gpu::MaterialRecord> materials, uint32_t textureCount,
                               const SceneGeometry& geometry);

// --- Materials as the device reads them ---

// Returns `values` as a record with the texture fields of `textures`.
gpu::MaterialRecord ToRecord(const scene::Material& values, const gpu::MaterialRecord& textures);

// Returns the textures that the material reads, each once, ascending.
std::vector<uint32_t> TexturesOf(const scene::Material& material);

// Returns the records of these materials. `slots` are those of the textures that they name; it is empty if
// these have not been uploaded.
std::vector<gpu::MaterialRecord> MaterialRecords(std::span<const scene::Material> materials,
                                                 std::span<const uint32_t> slots);

}  // namespace raygraph
