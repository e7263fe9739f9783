#include "renderer/gpu_scene/resource_upload.h"

#include <span>
#include <utility>
#include <vector>

#include "renderer/gpu_scene/deform_resources.h"
#include "renderer/gpu_scene/group_kinds.h"

namespace raygraph {

ResourceUpload::ResourceUpload(rhi::Device& device, rhi::Uploader& uploader, rhi::BlasBuilder& builder,
                               Disposer& disposer, SceneContent& content, const ResourceSettings& settings)
    : m_device(device),
      m_uploader(uploader),
      m_builder(builder),
      m_disposer(disposer),
      m_content(content),
      m_settings(settings),
      m_textures(device, uploader, content.data, settings.textures),
      m_resources(std::make_unique<SceneResources>()) {
    m_bytes = m_textures.Bytes();
    for (const PackedMesh& mesh : content.meshes) m_bytes += mesh.Bytes();
    m_resources->geometries = DeviceArray<gpu::GeometryRecord>(device, "geometries", "UploadGeometries");
    m_resources->materials = DeviceArray<gpu::MaterialRecord>(device, "materials", "UploadMaterials");
    m_resources->textures =
        std::make_unique<TextureSet>(device, *settings.defaultTexture, *settings.defaultSampler,
                                     settings.textures.hasLevels ? settings.textures.maxAnisotropy : 1.0f);
}

bool ResourceUpload::Continue(uint64_t& budget, bool mayWait) {
    for (; m_texture < m_content.data.textures.size(); ++m_texture)
        if (!m_textures.Make(m_texture, budget, mayWait)) return false;
    if (!std::exchange(m_hasMaterials, true)) AddMaterials();
    for (; m_mesh < m_content.meshes.size(); ++m_mesh) {
        if (budget == 0 || (!mayWait && m_uploader.WouldWait())) return false;
        if (!m_meshUpload) m_meshUpload.emplace(std::move(m_content.meshes[m_mesh]));
        if (!m_meshUpload->Continue(m_device, m_uploader, m_builder, m_disposer, budget)) return false;
        m_meshBytes += m_meshUpload->CopiedBytes();
        m_resources->AddMesh(m_meshUpload->Take());
        m_meshUpload.reset();
    }
    return true;
}

void ResourceUpload::AddMaterials() {
    std::vector<SceneTexture> textures;
    for (uint32_t i = 0; i < m_content.data.textures.size(); ++i) textures.push_back(m_textures.Get(i));
    m_resources->AddMaterials(m_content.data.materials, m_resources->AddTextures(textures));
}

uint64_t ResourceUpload::CopiedBytes() const {
    return m_meshBytes + (m_meshUpload ? m_meshUpload->CopiedBytes() : 0) + m_textures.CopiedBytes();
}

std::unique_ptr<SceneResources> ResourceUpload::Finish(rhi::Uploader& uploader) {
    const scene::SceneData& scene = m_content.data;
    SceneResources& resources = *m_resources;
    for (const scene::Instance& instance : scene.instances) resources.meshOf.push_back(instance.mesh);
    for (size_t i = 0; i < m_content.meshes.size(); ++i)
        resources.meshes[i].isDeformed = m_content.meshes[i].use.isDeformed;
    if (m_content.deform) {
        m_content.deform->AddCopies(m_device, uploader, m_builder, resources);
        resources.TakeSlots();
    }
    for (const uint32_t mesh : resources.meshOf) ++resources.meshes[mesh].instanceCount;
    resources.usedMaterials = UsedMaterials(resources);
    resources.geometries.Upload(uploader);
    resources.materials.Upload(uploader);
    resources.variantCount = static_cast<uint32_t>(scene.variants.size());
    resources.variant = scene.variant;
    return std::move(m_resources);
}

}  // namespace raygraph
