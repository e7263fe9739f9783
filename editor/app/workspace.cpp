#include "editor/app/workspace.h"

#include <algorithm>
#include <utility>

#include "base/error.h"

namespace raygraph::editor {

void Workspace::Open(const std::filesystem::path& file) {
    if (!loader.Start(file)) Say("another scene is being loaded");
}

void Workspace::FinishLoading() {
    std::optional<LoadResult> result = loader.Take();
    if (!result) return;
    if (const LoadFailure* failure = std::get_if<LoadFailure>(&*result)) {
        Say(failure->message);
        return;
    }
    LoadedScene& loaded = std::get<LoadedScene>(*result);
    Document opened(loaded.file, loaded.data);
    try {
        gpu.SetScene(std::move(loaded.data));
    } catch (const Error& error) {
        Say(loaded.file.string() + ": " + error.what());
        return;
    }
    document = std::move(opened);
    selectedNode.reset();
    selectedMaterial.reset();
    bookmarks.clear();
    const scene::SceneData& scene = document.Scene();
    // A scene without light of its own would be black
    const bool isLit =
        !scene.lights.empty() || std::ranges::any_of(scene.materials, [](const auto& material) {
            return material.EmittedRadiance() != glm::vec3(0.0f);
        });
    gpu.SetEnvironment({.radiance = glm::vec3(isLit ? 0.0f : 1.0f)});
    UseCamera(scene.cameras.empty() ? std::nullopt : std::optional<uint32_t>(0));
    Say(scene.warnings.empty() ? "" : scene.warnings.front());
}

void Workspace::UseCamera(std::optional<uint32_t> index) {
    const scene::SceneData& scene = document.Scene();
    const scene::CameraView taken =
        index ? scene::ViewOf(scene.cameras.at(*index), 1.0f) : scene::ViewOfBounds(scene.bounds, 1.0f);
    const float distance =
        scene.bounds.IsEmpty() ? 1.0f : glm::dot(scene.bounds.Center() - taken.eye, taken.forward);
    camera.Set(taken, distance > 0.0f ? distance : std::max(scene.bounds.Radius(), 0.01f));
}

void Workspace::FrameSelection() {
    camera.Frame(selectedNode ? document.BoundsOf(*selectedNode) : document.Scene().bounds);
}

}  // namespace raygraph::editor
