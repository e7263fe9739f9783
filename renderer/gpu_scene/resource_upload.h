// Brings what a scene has but for its instances and lights to the device, at once or in pieces. For
// renderer/gpu_scene. Threads: that of the uploader.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "renderer/gpu_scene/mesh_upload.h"
#include "renderer/gpu_scene/scene_content.h"
#include "renderer/gpu_scene/scene_context.h"
#include "renderer/gpu_scene/scene_geometry.h"
#include "renderer/gpu_scene/scene_materials.h"
#include "renderer/gpu_scene/texture_upload.h"

namespace raygraph {

struct SceneResources {
    std::unique_ptr<SceneMaterials> materials;
    std::unique_ptr<SceneGeometry> geometry;
};

class ResourceUpload {
  public:
    // Refers to all of them. Plans textures.
    ResourceUpload(SceneContext& context, rhi::Uploader& uploader, SceneContent& content);

    // Goes on, and counts down the budget, as TextureUpload and MeshUpload do. True: textures and meshes are
    // there. Adds the BLASes to the builder. Frees each image of the content after its upload, and disposes
    // of each mesh.
    bool Continue(uint64_t& budget, bool mayWait = true);
    // All that is left, with that uploader, after Continue has come to its end.
    SceneResources Finish(rhi::Uploader& uploader);

    // Bytes of streams and texels.
    uint64_t Bytes() const { return m_bytes; }
    uint64_t CopiedBytes() const;
    uint64_t TextureBudget() const { return m_textureBudget; }
    // Says that textures are smaller than their images, if any are.
    const std::string& Warning() const { return m_textures.Reduction(); }
    // For the caller to keep, after Finish or an Error: the destructor waits while the device works on them.
    TextureUpload TakeTextures() { return std::move(m_textures); }

  private:
    void AddMaterials();

    SceneContext& m_context;
    rhi::Uploader& m_uploader;
    SceneContent& m_content;
    uint64_t m_textureBudget;
    TextureUpload m_textures;
    SceneResources m_resources;
    bool m_hasMaterials = false;
    uint32_t m_texture = 0, m_mesh = 0;  // the next ones
    std::optional<MeshUpload> m_meshUpload;
    uint64_t m_bytes = 0, m_meshBytes = 0;  // of all; of the meshes that are there
};

}  // namespace raygraph
