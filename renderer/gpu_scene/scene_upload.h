// SceneUpload: a scene that is copied to the device over frames, beside the one that is shown. Threads: that
// of the GpuScene, which outlives it.
#pragma once

#include <memory>

#include "base/api.h"

namespace raygraph {

// What GpuScene::Upload begins. Without its owner, copying stops, and what has been copied is freed.
class RAYGRAPH_API SceneUpload {
  public:
    struct Content;  // renderer/gpu_scene/scene_upload.cpp
    explicit SceneUpload(std::unique_ptr<Content> content);
    ~SceneUpload();
    SceneUpload(const SceneUpload&) = delete;
    SceneUpload& operator=(const SceneUpload&) = delete;

    // Everything has been copied, or cannot be: GpuScene::SetScene has nothing to wait for, or throws.
    bool IsReady() const;
    float Fraction() const;  // from 0 to 1: of the bytes

  private:
    friend class GpuScene;
    std::unique_ptr<Content> m_content;
};

}  // namespace raygraph
