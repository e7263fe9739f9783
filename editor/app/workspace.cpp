#include "editor/app/workspace.h"

#include <algorithm>
#include <utility>

#include "base/error.h"

namespace raygraph::editor {

void Workspace::Open(const std::filesystem::path& file) {
    if (!loader.Start(file)) Say("another scene is being loaded");
}

template <typename Change>
void Workspace::Try(Change&& change) {
    try {
        change();
    } catch (const Error& error) {
        Say(error.what());
    }
}

void Workspace::Apply(const Edit& edit) {
    Try([&] { document.Apply(edit, gpu); });
}

void Workspace::Undo() {
    Try([&] { document.Undo(gpu); });
}

void Workspace::Redo() {
    Try([&] { document.Redo(gpu); });
}

bool Workspace::FinishLoading() {
    std::optional<LoadResult> result = loader.Take();
    if (!result) return false;
    if (const LoadFailure* failure = std::get_if<LoadFailure>(&*result)) {
        Say(failure->message);
        return false;
    }
    LoadedScene& loaded = std::get<LoadedScene>(*result);
    Document opened(loaded.file, loaded.data);
    try {
        gpu.SetScene(std::move(loaded.data));
    } catch (const Error& error) {
        Say(loaded.file.string() + ": " + error.what());
        return false;
    }
    document = std::move(opened);
    selectedNode.reset();
    selectedMaterial.reset();
    bookmarks = {};
    const scene::SceneData& scene = document.Scene();
    // A scene without light of its own would be black
    const bool isLit = !scene.lights.empty() || scene::HasEmission(scene);
    gpu.SetEnvironment({.radiance = glm::vec3(isLit ? 0.0f : 1.0f)});
    UseCamera(scene.cameras.empty() ? std::nullopt : std::optional<uint32_t>(0));
    Say(scene.warnings.empty() ? "" : scene.warnings.front());
    return true;
}

void Workspace::UseCamera(std::optional<uint32_t> index) {
    const scene::SceneData& scene = document.Scene();
    const Extent2D size = view.Size();
    const float aspect =
        size.IsEmpty() ? 1.0f : static_cast<float>(size.width) / static_cast<float>(size.height);
    const scene::CameraView taken =
        index ? scene::ViewOf(scene.cameras.at(*index), aspect) : scene::ViewOfBounds(scene.bounds, aspect);
    const float distance =
        scene.bounds.IsEmpty() ? 1.0f : glm::dot(scene.bounds.Center() - taken.eye, taken.forward);
    camera.Set(taken, distance > 0.0f ? distance : std::max(scene.bounds.Radius(), 0.01f));
}

void Workspace::FrameSelection() {
    camera.Frame(selectedNode ? document.BoundsOf(*selectedNode) : document.Scene().bounds);
}

}  // namespace raygraph::editor
