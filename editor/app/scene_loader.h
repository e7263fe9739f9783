// SceneLoader loads one scene at a time on another thread. Threads: main thread only.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <variant>

#include "base/log.h"
#include "editor/app/document.h"
#include "editor/app/scene_view.h"
#include "renderer/gpu_scene/streaming/prepared_scene.h"
#include "renderer/gpu_scene/streaming/scene_upload.h"
#include "renderer/scene/geometry/round_primitives.h"

namespace raygraph::editor {

// Holds a loaded scene, for which all work is done that needs neither the main thread nor a device.
struct LoadedScene {
    Document document;
    PreparedScene scene;
    std::optional<SceneView> view{};        // the one that is stored beside the file
    ChangeView changeView{};                // see Start
    std::string viewMessage{};              // why a stored view is not there; "": nothing is wrong
    std::shared_ptr<SceneUpload> upload{};  // set once the copy to the device begins
};
struct LoadFailure {
    std::filesystem::path file;
    std::string message;  // one line
};
using LoadResult = std::variant<LoadedScene, LoadFailure>;

class SceneLoader {
  public:
    // `buildsWideBvhs` is GpuScene::UsesWideBvhs of the GpuScene that will show the scene. `log` gets
    // messages about loads.
    explicit SceneLoader(bool buildsWideBvhs = true, Log log = {})
        : m_buildsWideBvhs(buildsWideBvhs), m_log(std::move(log)) {}
    ~SceneLoader();  // waits for the current load
    SceneLoader(const SceneLoader&) = delete;
    SceneLoader& operator=(const SceneLoader&) = delete;

    // Starts to load a scene with this variant (name or index, "": none), with its view changed so (null:
    // not), and with this root (scene::LoadOptions). It fails if the scene lacks the variant, or the changed
    // view's camera. Returns false if another load is running, which continues.
    bool Start(const std::filesystem::path& file, const std::string& variant = {},
               const scene::PointsAndLines& pointsAndLines = {}, const ChangeView& changeView = {},
               const std::filesystem::path& root = {});
    bool IsLoading() const { return m_thread.joinable(); }
    struct Progress {
        std::string stage;
        float fraction = 0.0f;
    };
    Progress Current() const;
    // Returns the scene or the failure once, after the load has finished.
    std::optional<LoadResult> Take();

  private:
    bool m_buildsWideBvhs;
    Log m_log;
    std::thread m_thread;
    std::atomic<bool> m_isDone{false};
    mutable std::mutex m_mutex;
    Progress m_progress;                 // guarded by m_mutex
    std::optional<LoadResult> m_result;  // written by the thread before m_isDone is set
};

}  // namespace raygraph::editor
