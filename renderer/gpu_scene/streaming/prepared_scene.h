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
#include "renderer/scene/model/scene_data.h"

namespace raygraph {

struct PreparedContent;  // renderer/gpu_scene/streaming/scene_content.h

struct PrepareSettings {
    uint32_t maxThreads = 0;  // worker threads, which end before it returns; 0: one per core
    // Meshes of more triangles than this, or of more than every device has memory for in one piece, become
    // several structures side by side, split in space. Small ones let a scene that streams build a little in
    // each frame; large ones are traced faster.
    uint32_t maxTriangles = 1u << 24;
    // For own traversal. True: a scene of more than kMaxLevelTriangles triangles gets a tree per mesh here;
    // GpuScene builds the one tree of a smaller scene when it needs it. False: this scene cannot use own
    // traversal, as for a GpuScene without trees (GpuScene::UsesWideBvhs).
    bool buildsWideBvhs = true;
    // For DefaultLight::Auto. True: HasOwnLight measures whether the scene lights itself, which builds trees
    // over its triangles. False: anything that emits counts as light (MayHaveOwnLight).
    bool measuresLight = true;
};

class RAYGRAPH_API PreparedScene {
  public:
    // Consumes the data. Error{Usage}, if scene::Check refuses it: the data is unchanged. Error{OutOfMemory}:
    // the data may have lost its meshes, and is not to be used again.
    explicit PreparedScene(scene::SceneData&& data, const PrepareSettings& settings = {});
    ~PreparedScene();
    PreparedScene(PreparedScene&& other) noexcept;
    PreparedScene& operator=(PreparedScene&& other) noexcept;

    // Returns the scene without its vertices and, once a SetScene has failed, possibly without images. Not to
    // be called once GpuScene has taken this object.
    const scene::SceneData& Data() const;
    // Returns the bytes of all vertex and index streams.
    uint64_t GeometryBytes() const;

  private:
    friend class GpuScene;
    friend class SceneStreams;
    // `call` is the function of GpuScene that messages of Errors name.
    PreparedScene(scene::SceneData&& data, const PrepareSettings& settings, const char* call);
    void Make(scene::SceneData&& data, const PrepareSettings& settings);
    std::unique_ptr<PreparedContent> m_content;
};

}  // namespace raygraph
