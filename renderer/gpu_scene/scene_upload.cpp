#include "renderer/gpu_scene/scene_upload.h"

#include <algorithm>
#include <utility>

#include "renderer/gpu_scene/resource_upload.h"

namespace raygraph {

SceneUpload::SceneUpload(std::unique_ptr<SceneContent> content, std::unique_ptr<ResourceUpload> resources)
    : m_content(std::move(content)), m_resources(std::move(resources)) {}
SceneUpload::~SceneUpload() = default;

bool SceneUpload::IsReady() const {
    return !m_content || m_isDone;
}

float SceneUpload::Fraction() const {
    if (IsReady()) return 1.0f;
    const auto all = static_cast<double>(std::max<uint64_t>(1, m_resources->Bytes()));
    return static_cast<float>(static_cast<double>(m_resources->CopiedBytes()) / all);
}

}  // namespace raygraph
