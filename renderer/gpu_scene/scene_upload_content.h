// What a SceneUpload holds. For renderer/gpu_scene alone.
#pragma once

#include <exception>
#include <memory>
#include <optional>
#include <utility>

#include "renderer/gpu_scene/resource_upload.h"
#include "renderer/gpu_scene/scene_upload.h"

namespace raygraph {

struct SceneUpload::Content {
    template <typename... Arguments>
    explicit Content(std::unique_ptr<SceneContent> content, Arguments&&... arguments)
        : scene(std::move(content)), resources(std::in_place, std::forward<Arguments>(arguments)...) {}

    std::unique_ptr<SceneContent> scene;
    std::optional<ResourceUpload> resources;  // refers to it; nullopt: it has failed
    bool isDone = false;                      // or has failed
    std::exception_ptr error;
};

}  // namespace raygraph
