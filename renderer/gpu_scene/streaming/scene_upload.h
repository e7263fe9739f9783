// SceneUpload: a scene that is copied to the device over frames, beside the one that is shown. Threads: that
// of the GpuScene, which outlives it.
#pragma once

#include <exception>
#include <memory>

#include "base/api.h"

namespace raygraph {

struct PreparedContent;  // renderer/gpu_scene/streaming/scene_content.h

// GpuScene::Upload creates one. Destroying it stops the upload and frees what was copied.
class RAYGRAPH_API SceneUpload {
  public:
    ~SceneUpload();
    SceneUpload(const SceneUpload&) = delete;
    SceneUpload& operator=(const SceneUpload&) = delete;

    // Returns whether GpuScene::SetScene has little left to do, or will throw the error that ended the
    // upload.
    bool IsReady() const;
    float Fraction() const;  // copied bytes over all bytes, 0 to 1

  private:
    friend class GpuScene;
    friend class SceneStreams;
    class Impl;  // renderer/gpu_scene/streaming/scene_upload_impl.h
    SceneUpload(std::unique_ptr<PreparedContent> content, std::unique_ptr<Impl> impl);

    std::unique_ptr<PreparedContent> m_content;
    // Refers to the content; null: the scene has been set, or the upload has failed.
    std::unique_ptr<Impl> m_impl;
    std::exception_ptr m_error;  // SetScene throws it once
};

}  // namespace raygraph
