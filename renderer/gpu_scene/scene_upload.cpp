#include "renderer/gpu_scene/scene_upload.h"

#include <algorithm>
#include <utility>

#include "renderer/gpu_scene/scene_upload_content.h"

namespace raygraph {

SceneUpload::SceneUpload(std::unique_ptr<Content> content) : m_content(std::move(content)) {}
SceneUpload::~SceneUpload() = default;

bool SceneUpload::IsReady() const {
    return !m_content || m_content->isDone;
}

float SceneUpload::Fraction() const {
    if (IsReady()) return 1.0f;
    const auto all = static_cast<double>(std::max<uint64_t>(1, m_content->resources->Bytes()));
    return static_cast<float>(static_cast<double>(m_content->resources->CopiedBytes()) / all);
}

}  // namespace raygraph
