#include "renderer/gpu_scene/streaming/scene_upload.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "renderer/gpu_scene/deform/deform_set.h"
#include "renderer/gpu_scene/streaming/scene_upload_impl.h"

namespace raygraph {

SceneUpload::SceneUpload(std::unique_ptr<PreparedContent> content, std::unique_ptr<Impl> impl)
    : m_content(std::move(content)), m_impl(std::move(impl)) {}
SceneUpload::~SceneUpload() = default;

bool SceneUpload::IsReady() const {
    return !m_impl || m_impl->IsDone();
}

float SceneUpload::Fraction() const {
    if (IsReady()) return 1.0f;
    const auto all = static_cast<double>(std::max<uint64_t>(1, m_impl->Bytes()));
    return static_cast<float>(static_cast<double>(m_impl->CopiedBytes()) / all);
}

SceneUpload::Impl::Impl(SceneContext& context, rhi::Uploader& uploader, PreparedContent& content)
    : m_context(context),
      m_uploader(uploader),
      m_content(content),
      m_textureBudget(context.desc.textureBudget > 0 ? context.desc.textureBudget
                                                     : DefaultTextureBudget(context.device)),
      m_textures(context.device, uploader, content.data, context.TextureSettings(m_textureBudget)),
      m_meshes(context, uploader, content.meshes),
      m_materials(
          std::make_unique<SceneMaterials>(context.device, context.defaultTexture, context.defaultSampler,
                                           context.desc.textureLevels ? context.desc.maxAnisotropy : 1.0f)),
      m_geometry(std::make_unique<SceneGeometry>(context.device)) {}

bool SceneUpload::Impl::Continue(uint64_t& budget, bool mayWait) {
    for (; m_texture < m_content.data.textures.size(); ++m_texture)
        if (!m_textures.Continue(m_texture, budget, mayWait)) return false;
    if (!std::exchange(m_hasMaterials, true)) AddMaterials();
    for (; m_mesh < m_content.meshes.size(); ++m_mesh) {
        if (!m_meshes.Continue(m_mesh, budget, mayWait)) return false;
        m_geometry->AddMesh(m_meshes.Take(), *m_materials);
    }
    return true;
}

void SceneUpload::Impl::AddMaterials() {
    std::vector<SceneTexture> textures;
    for (uint32_t i = 0; i < m_content.data.textures.size(); ++i) textures.push_back(m_textures.Get(i));
    m_materials->Add(m_content.data.materials, m_materials->AddTextures(textures));
}

void SceneUpload::Impl::Complete() {
    m_uploader.FlushAfter([&] {
        uint64_t budget = UINT64_MAX;
        Continue(budget);
    });
}

std::unique_ptr<SceneObjects> SceneUpload::Impl::Finish() {
    uint64_t budget = UINT64_MAX;
    Continue(budget);
    const scene::SceneData& scene = m_content.data;
    SceneGeometry& geometry = *m_geometry;
    for (const scene::Instance& instance : scene.instances) geometry.meshOf.push_back(instance.mesh);
    if (std::ranges::any_of(scene.instances, &scene::Instance::isDeformed)) {
        AddDeformedCopies(m_context, scene, m_content.deform, geometry);
        geometry.AllocateSlots();
    }
    for (const uint32_t mesh : geometry.meshOf) ++geometry.meshes[mesh].instanceCount;
    geometry.records.Upload(m_context.uploader);
    m_materials->Upload(m_context.uploader);
    geometry.variantCount = static_cast<uint32_t>(scene.variants.size());
    geometry.variant = scene.variant;
    return std::make_unique<SceneObjects>(m_context, std::move(m_materials), std::move(m_geometry), scene);
}

}  // namespace raygraph
