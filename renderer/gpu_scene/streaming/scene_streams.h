// SceneStreams copies parts and scenes to the device, at once or over several frames. For renderer/gpu_scene
// alone. Threads: that of the Renderer.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <vector>

#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/streaming/scene_upload_impl.h"

namespace raygraph {

class SceneStreams {
  public:
    explicit SceneStreams(SceneContext& context) : m_context(context) {}

    // These calls do what GpuScene's calls of the same names say, with the scene that is shown.
    AddedPart Add(PreparedScene&& part, SceneObjects& scene);
    std::shared_ptr<const AddedPart> Stream(PreparedScene&& part, SceneObjects& scene);
    std::shared_ptr<SceneUpload> Upload(PreparedScene&& scene);
    StreamProgress Streaming() const;

    // Ends the stream of the part with that owner number, if there is one; what has been added stays.
    void Stop(uint32_t owner);
    // Ends the streams of all parts, because their scene is replaced.
    void StopAll();
    // Ends an upload that is finished, or has failed. Keeps its textures until the device has finished with
    // them.
    void End(SceneUpload::Impl& upload) { m_ended.push_back(upload.TakeTextures()); }
    // Throws Error{Usage} if the owner of that object is a part that still streams, and so may need it.
    void RequireComplete(const char* what, uint32_t index, const Owners& owners) const;

    // Copies up to a frame's budget: uploads first, then parts, each in the order in which they began. If a
    // part fails, it removes the part and rethrows.
    void Continue(SceneObjects& scene);
    bool IsDone() const { return m_parts.empty() && !NextUpload(); }

  private:
    // Describes a part that is being copied: its prepared content, and its progress.
    struct Part {
        std::unique_ptr<PreparedContent> content;
        std::shared_ptr<AddedPart> added;
        TextureUpload textures;  // these refer to members above
        MeshUpload meshes;
        std::vector<bool> isVisible;  // indexed by node
        bool isStreamed = false;      // never waits for the device
        // The next object of each kind, by its index in the part.
        uint32_t light = 0, instance = 0, mesh = 0, material = 0, texture = 0;

        // Both count bytes of streams and texels.
        uint64_t Bytes() const { return textures.Bytes() + meshes.Bytes(); }
        uint64_t CopiedBytes() const { return textures.CopiedBytes() + meshes.CopiedBytes(); }
    };
    using Parts = std::list<Part>;

    rhi::Uploader& FrameUploader();
    Part Begin(const char* call, PreparedScene&& part, rhi::Uploader& with, const SceneObjects& scene);
    // Adds more of the part and lowers the budget by the cost. Returns true if the part is complete.
    bool Continue(Part& part, SceneObjects& scene, uint64_t& budget);
    bool ContinueTexture(Part& part, SceneObjects& scene, uint32_t texture, uint64_t& budget);
    bool ContinueMaterial(Part& part, SceneObjects& scene, uint32_t material, uint64_t& budget);
    bool ContinueMesh(Part& part, SceneObjects& scene, uint32_t mesh, uint64_t& budget);
    bool ContinueStream(Part& part, SceneObjects& scene, uint64_t& budget);
    void ContinueUpload(SceneUpload& upload, SceneObjects& scene, uint64_t& budget);
    std::shared_ptr<SceneUpload> NextUpload() const;
    void End(Parts::iterator part);

    SceneContext& m_context;
    Parts m_parts;                                            // oldest first; the first is being copied
    mutable std::list<std::weak_ptr<SceneUpload>> m_uploads;  // oldest first; they precede parts
    std::optional<rhi::Uploader> m_uploader;
    std::list<TextureUpload> m_ended;  // textures of ended streams on which the device still works
    uint32_t m_lastOwner = kOwnedByScene;
    uint64_t m_endedBytes = 0;  // bytes of parts completed since m_parts was last empty
};

}  // namespace raygraph
