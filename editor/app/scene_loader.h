// Loads scenes on another thread, one at a time.
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
#include "renderer/gpu_scene/prepared_scene.h"
#include "renderer/gpu_scene/scene_upload.h"
#include "renderer/scene/round_primitives.h"

namespace raygraph::editor {

// With everything done that needs neither the main thread nor a device.
struct LoadedScene {
    Document document;
    PreparedScene scene;
    std::string camera{};                   // to look through, as of scene::ChooseView
    std::shared_ptr<SceneUpload> upload{};  // of it, once it is on its way to the device
};
struct LoadFailure {
    std::filesystem::path file;
    std::string message;  // one line
};
using LoadResult = std::variant<LoadedScene, LoadFailure>;

// Threads: the main thread's.
class SceneLoader {
  public:
    // `makesTrees`: GpuScene::TakesTrees of the one which shows what is loaded. `log`: of what is loaded.
    explicit SceneLoader(bool makesTrees = true, Log log = {})
        : m_makesTrees(makesTrees), m_log(std::move(log)) {}
    ~SceneLoader();  // waits for the current load
    SceneLoader(const SceneLoader&) = delete;
    SceneLoader& operator=(const SceneLoader&) = delete;

    // In this variant, by name or index, "": none; to be looked at through this camera, as of
    // scene::ChooseView; with a root as of scene::LoadOptions. A scene that lacks them is a failure. False:
    // another load is still running, and continues.
    bool Start(const std::filesystem::path& file, const std::string& variant = {},
               const scene::PointsAndLines& pointsAndLines = {}, const std::string& camera = {},
               const std::filesystem::path& root = {});
    bool IsLoading() const { return m_thread.joinable(); }
    struct Progress {
        std::string stage;
        float fraction = 0.0f;
    };
    Progress Current() const;
    // The scene or the failure, once, when the load has finished.
    std::optional<LoadResult> Take();

  private:
    bool m_makesTrees;
    Log m_log;
    std::thread m_thread;
    std::atomic<bool> m_isDone{false};
    mutable std::mutex m_mutex;
    Progress m_progress;                 // guarded
    std::optional<LoadResult> m_result;  // written by the thread, before m_isDone
};

}  // namespace raygraph::editor
