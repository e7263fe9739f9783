// All that the editor has open: the scene, on the host and on the device, the view of it, and what is
// selected.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "editor/app/camera_controller.h"
#include "editor/app/document.h"
#include "editor/app/scene_loader.h"
#include "editor/viewport/viewport.h"
#include "renderer/graph/renderer.h"

namespace raygraph::editor {

// What is shown beside the picture.
struct Panels {
    bool hierarchy = true;
    bool inspector = true;
    bool statistics = false;
    bool graph = false;
    bool help = false;
};

struct Bookmark {
    scene::CameraView view;
    float distance = 1.0f;
};

class Workspace {
  public:
    // `shaders`: the folder of shader sources to reload from, or "".
    explicit Workspace(rhi::Device& of, const std::filesystem::path& shaders = {})
        : device(of),
          hasShaderSources(!shaders.empty()),
          renderer(of, {.shaderRoot = shaders}),
          gpu(renderer),
          view(renderer, gpu) {
        view.SetBudget({.frameMs = 30.0, .whileMoving = viewport::MotionView::PathTraced});
        camera.Set(scene::ViewOfBounds({}, 1.0f), 2.0f);
    }

    // Begins to load beside the frames that go on; says so if another load is under way.
    void Open(const std::filesystem::path& file);
    // Takes over a scene that has been loaded, or says why not: then all stays as it is.
    // True: there is a new scene.
    bool FinishLoading();
    // A camera of the scene, or one that frames it all.
    void UseCamera(std::optional<uint32_t> camera);
    // The view moves to show what is selected, or all.
    void FrameSelection();
    // An edit that the scene refuses changes nothing; the message says why.
    void Apply(const Edit& edit);
    void Undo();
    void Redo();
    void Say(std::string text) { message = std::move(text); }

    rhi::Device& device;
    bool hasShaderSources;
    Renderer renderer;
    GpuScene gpu;
    viewport::Viewport view;
    Document document;
    CameraController camera;
    SceneLoader loader;
    std::array<std::optional<Bookmark>, 9> bookmarks;  // keys 1 to 9
    std::optional<uint32_t> selectedNode;
    std::optional<uint32_t> selectedMaterial;  // of what was picked
    Panels panels;
    std::string message;  // the newest one line

  private:
    template <typename Change>
    void Try(Change&& change);
};

}  // namespace raygraph::editor
