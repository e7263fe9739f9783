#include "renderer/gpu_scene/resource_upload.h"

#include <span>
#include <utility>
#include <vector>

#include "renderer/gpu_scene/deform_resources.h"

namespace raygraph {

ResourceUpload::ResourceUpload(SceneContext& context, rhi::Uploader& uploader, SceneContent& content)
    : m_context(context),
      m_uploader(uploader),
      m_content(content),
      m_textureBudget(context.desc.textureBudget > 0 ? context.desc.textureBudget
                                                     : DefaultTextureBudget(context.device)),
      m_textures(context.device, uploader, content.data, context.TextureSettings(m_textureBudget)),
      m_resources{
          std::make_unique<SceneMaterials>(context.device, context.defaultTexture, context.defaultSampler,
                                           context.desc.textureLevels ? context.desc.maxAnisotropy : 1.0f),
          std::make_unique<SceneGeometry>(context.device)} {
    m_bytes = m_textures.Bytes();
    for (const PackedMesh& mesh : content.meshes) m_bytes += mesh.Bytes();
}

bool ResourceUpload::Continue(uint64_t& budget, bool mayWait) {
    for (; m_texture < m_content.data.textures.size(); ++m_texture)
        if (!m_textures.Make(m_texture, budget, mayWait)) return false;
    if (!std::exchange(m_hasMaterials, true)) AddMaterials();
    for (; m_mesh < m_content.meshes.size(); ++m_mesh) {
        if (budget == 0 || (!mayWait && m_uploader.WouldWait())) return false;
        if (!m_meshUpload) m_meshUpload.emplace(std::move(m_content.meshes[m_mesh]));
        if (!m_meshUpload->Continue(m_context.device, m_uploader, m_context.builder, m_context.disposer,
                                    budget))
            return false;
        m_meshBytes += m_meshUpload->CopiedBytes();
        m_resources.geometry->AddMesh(m_meshUpload->Take(), *m_resources.materials);
        m_meshUpload.reset();
    }
    return true;
}

void ResourceUpload::AddMaterials() {
    std::vector<SceneTexture> textures;
    for (uint32_t i = 0; i < m_content.data.textures.size(); ++i) textures.push_back(m_textures.Get(i));
    m_resources.materials->Add(m_content.data.materials, m_resources.materials->AddTextures(textures));
}

uint64_t ResourceUpload::CopiedBytes() const {
    return m_meshBytes + (m_meshUpload ? m_meshUpload->CopiedBytes() : 0) + m_textures.CopiedBytes();
}

SceneResources ResourceUpload::Finish(rhi::Uploader& uploader) {
    const scene::SceneData& scene = m_content.data;
    SceneGeometry& geometry = *m_resources.geometry;
    for (const scene::Instance& instance : scene.instances) geometry.meshOf.push_back(instance.mesh);
    for (size_t i = 0; i < m_content.meshes.size(); ++i)
        geometry.meshes[i].isDeformed = m_content.meshes[i].use.isDeformed;
    if (m_content.deform) {
        m_content.deform->AddCopies(m_context.device, uploader, m_context.builder, geometry);
        geometry.TakeSlots();
    }
    for (const uint32_t mesh : geometry.meshOf) ++geometry.meshes[mesh].instanceCount;
    geometry.records.Upload(uploader);
    m_resources.materials->Upload(uploader);
    geometry.variantCount = static_cast<uint32_t>(scene.variants.size());
    geometry.variant = scene.variant;
    return std::move(m_resources);
}

}  // namespace raygraph
