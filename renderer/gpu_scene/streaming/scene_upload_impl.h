// SceneUpload::Impl copies a scene to the device, at once or in pieces. For renderer/gpu_scene alone.
// Threads: that of the Renderer.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "renderer/gpu_scene/geometry/mesh_packing.h"
#include "renderer/gpu_scene/instances/scene_objects.h"
#include "renderer/gpu_scene/materials/texture_set.h"
#include "renderer/gpu_scene/scene_context.h"
#include "renderer/gpu_scene/streaming/scene_content.h"
#include "renderer/gpu_scene/streaming/scene_upload.h"

namespace raygraph {

class SceneUpload::Impl {
  public:
    // Plans the textures. Keeps references to all arguments.
    Impl(SceneContext& context, rhi::Uploader& uploader, PreparedContent& content);

    // Continues, and subtracts from the budget, as TextureUpload and MeshUpload do. Returns true when
    // textures and meshes are complete.
    bool Continue(uint64_t& budget, bool mayWait = true);
    bool IsDone() const { return m_hasMaterials && m_mesh == m_content.meshes.size(); }
    // Copies everything that Continue has left, and flushes.
    void Complete();
    // Copies the rest and creates the scene's objects, without flushing: the caller flushes context.uploader.
    // If this upload uses another uploader, IsDone() must be true.
    std::unique_ptr<SceneObjects> Finish();

    // Bytes of streams and texels.
    uint64_t Bytes() const { return m_textures.Bytes() + m_meshes.Bytes(); }
    uint64_t CopiedBytes() const { return m_textures.CopiedBytes() + m_meshes.CopiedBytes(); }
    uint64_t TextureBudget() const { return m_textureBudget; }
    // Returns the message that textures are smaller than their images; empty if none are.
    const std::string& Warning() const { return m_textures.Reduction(); }
    // Moves the textures to the caller, after Finish or an Error: their destructor waits while the device
    // works on them.
    TextureUpload TakeTextures() { return std::move(m_textures); }

  private:
    void AddMaterials();

    SceneContext& m_context;
    rhi::Uploader& m_uploader;
    PreparedContent& m_content;
    uint64_t m_textureBudget;
    TextureUpload m_textures;
    MeshUpload m_meshes;
    std::unique_ptr<SceneMaterials> m_materials;
    std::unique_ptr<SceneGeometry> m_geometry;
    bool m_hasMaterials = false;
    uint32_t m_texture = 0, m_mesh = 0;  // the next ones to continue
};

}  // namespace raygraph
