// PreparedScene: a scene on its way to the device. Everything that needs no device is done when it is made,
// on any thread, beside frames of the scene that is shown: the checks, sorting triangles in space, finding
// those that emit, laying out streams. What is left to GpuScene::SetScene and Add is to copy.
//
//     auto coming = std::async([file] { return PreparedScene(scene::LoadGltf(file)); });
//     ...frames, until it is ready...
//     gpuScene.SetScene(coming.get());
//
// Threads: making one, any; one at a time.
#pragma once

#include <cstdint>
#include <memory>

#include "base/api.h"
#include "renderer/scene/scene_data.h"

namespace raygraph {

struct SceneContent;  // renderer/gpu_scene/scene_content.h

struct PrepareSettings {
    uint32_t maxThreads = 0;  // that end before it returns; 0: one a core
    // Meshes of more triangles than this, or of more than every device has memory for in one piece, become
    // several structures side by side, split in space. Small ones let a scene that streams build a little in
    // each frame; large ones are traced faster.
    uint32_t maxTriangles = 1u << 24;
    // For own traversal. True: the trees of meshes are built here where there are more triangles than one
    // tree takes (kMaxLevelTriangles); those of fewer GpuScene builds, if it comes to need them. False: the
    // scene can have none, as for a GpuScene that does not take trees (GpuScene::TakesTrees).
    bool makesTrees = true;
    // For DefaultLight::Auto. True: HasOwnLight measures whether the scene lights itself, which builds trees
    // over its triangles. False: anything that emits counts as light (MayHaveOwnLight).
    bool measuresLight = true;
};

class RAYGRAPH_API PreparedScene {
  public:
    // Consumes the data, but for an Error{Usage}, for what scene::Check refuses: that leaves it as it is.
    // Error{OutOfMemory} leaves data without meshes.
    explicit PreparedScene(scene::SceneData&& data, const PrepareSettings& settings = {});
    ~PreparedScene();
    PreparedScene(PreparedScene&& other) noexcept;
    PreparedScene& operator=(PreparedScene&& other) noexcept;

    // The data without what has been consumed: vertices, and after an upload images.
    const scene::SceneData& Data() const;
    // Of all streams.
    uint64_t GeometryBytes() const;

  private:
    friend class GpuScene;
    friend class SceneStreams;
    // For a call of GpuScene, which begins the lines of Errors.
    PreparedScene(scene::SceneData&& data, const PrepareSettings& settings, const char* call);
    void Make(scene::SceneData&& data, const PrepareSettings& settings);
    std::unique_ptr<SceneContent> m_content;
};

}  // namespace raygraph
