// GpuScene::Impl holds the scene that is shown, and the context that outlives it. It is for gpu_scene*.cpp
// alone.
#pragma once

#include <memory>
#include <optional>

#include "base/stopwatch.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/scene_context.h"
#include "renderer/gpu_scene/streaming/scene_streams.h"
#include "renderer/gpu_scene/streaming/scene_upload_impl.h"

namespace raygraph {

struct GpuScene::Impl {
    Impl(Renderer& renderer, const GpuSceneDesc& desc);

    // These create the new scene first, so that an Error leaves the old one in place.
    void SetContent(PreparedContent& content);
    void Replace(PreparedContent& content, SceneUpload::Impl& upload, const Stopwatch& watch);
    PrepareSettings Preparing() const {
        return {.buildsWideBvhs = context.traversal == Traversal::Software,
                .measuresLight = context.desc.measuresLight};
    }
    // Throws Error{Usage} while a frame is open, since an edit would change or destroy the data from which it
    // was declared.
    void RequireNoFrame(const char* call);

    SceneContext context;
    SceneStreams streams{context};
    std::unique_ptr<SceneObjects> scene;
    struct Ground {
        AddedPart part;
        scene::Bounds bounds;  // below which it is
    };
    std::optional<Ground> ground;
    std::weak_ptr<const void> declaredIn;  // the open frame; expired if there is none
    rhi::Buffer energyTables;
    ResourceState energyTablesState;
};

}  // namespace raygraph
