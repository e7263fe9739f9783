// PreparedScene: a scene that is ready to be copied to the device. Its constructor does everything that needs
// no device, on any thread, beside frames of the scene that is shown: it checks, sorts triangles in space,
// finds those that emit, and lays out streams. GpuScene::SetScene and Add only copy the result.
//
//     auto coming = std::async([file] { return PreparedScene(scene::LoadGltf(file)); });
//     ...frames, until it is ready...
//     gpuScene.SetScene(coming.get());
//
// Threads: constructed on any thread; used by one thread at a time.
#pragma once

#include <cstdint>
#include <memory>

#include "base/api.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph {

struct PreparedContent;  // renderer/gpu_scene/streaming/scene_content.h

struct PrepareSettings {
    uint32_t maxThreads = 0;  // worker threads, which end before it returns; 0: one per core
    // Meshes with more triangles than this, or with more data than every device can store in one piece,
    // become several structures side by side, split in space. Small pieces let a scene that streams build a
    // little in each frame; large ones are traced faster.
    uint32_t maxTriangles = 1u << 24;
    // For software traversal. True: a scene of more than kMaxLevelTriangles triangles gets a tree per
    // mesh here; GpuScene builds the one tree of a smaller scene when it needs it. False: this scene cannot
    // be traversed by Raygraph's own shaders, which is for a GpuScene that does not (GpuScene::UsesWideBvhs).
    bool buildsWideBvhs = true;
    // For DefaultLight::Auto. True: HasOwnLight measures whether the scene lights itself, which builds trees
    // over its triangles. False: anything that emits counts as light (MayHaveOwnLight).
    bool measuresLight = true;
};

class RAYGRAPH_API PreparedScene {
  public:
    // Consumes the data. Throws Error{Usage} if scene::Check refuses it, and leaves the data unchanged;
    // Error{OutOfMemory}, after which the data may have lost its meshes and must not be used.
    explicit PreparedScene(scene::SceneData&& data, const PrepareSettings& settings = {});
    ~PreparedScene();
    PreparedScene(PreparedScene&& other) noexcept;
    PreparedScene& operator=(PreparedScene&& other) noexcept;

    // Returns the scene without its vertices and, after a failed SetScene, possibly without images. Must not
    // be called once GpuScene has consumed this object.
    const scene::SceneData& Data() const;
    // Returns the bytes of all vertex and index streams.
    uint64_t GeometryBytes() const;

  private:
    friend class GpuScene;
    friend class SceneStreams;
    // `call` is the function of GpuScene that error messages name.
    PreparedScene(scene::SceneData&& data, const PrepareSettings& settings, const char* call);
    void Prepare(scene::SceneData&& data, const PrepareSettings& settings);
    std::unique_ptr<PreparedContent> m_content;
};

}  // namespace raygraph
