// Work on other threads: SceneLoader loads scenes, one at a time; Worker runs tasks one after another.
// Threads: main thread only.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "base/log.h"
#include "editor/app/document.h"
#include "renderer/gpu_scene/streaming/prepared_scene.h"
#include "renderer/gpu_scene/streaming/scene_upload.h"
#include "renderer/scene/geometry/round_primitives.h"

namespace raygraph::editor {

// Holds a loaded scene, for which all work is done that needs neither the main thread nor a device.
struct LoadedScene {
    Document document;
    PreparedScene scene;
    std::string camera{};                   // the first camera, see scene::ChooseView
    std::shared_ptr<SceneUpload> upload{};  // set once the copy to the device begins
};
struct LoadFailure {
    std::filesystem::path file;
    std::string message;  // one line
};
using LoadResult = std::variant<LoadedScene, LoadFailure>;

// SceneLoader loads one scene at a time on another thread.
class SceneLoader {
  public:
    // `buildsWideBvhs` is GpuScene::UsesWideBvhs of the GpuScene that will show the scene. `log` gets
    // messages about loads.
    explicit SceneLoader(bool buildsWideBvhs = true, Log log = {})
        : m_buildsWideBvhs(buildsWideBvhs), m_log(std::move(log)) {}
    ~SceneLoader();  // waits for the current load
    SceneLoader(const SceneLoader&) = delete;
    SceneLoader& operator=(const SceneLoader&) = delete;

    // Starts to load a scene with this variant (name or index, "": none), to be seen through this camera
    // (scene::ChooseView), with this root (scene::LoadOptions). It fails if the scene lacks one of these.
    // Returns false if another load is running, which continues.
    bool Start(const std::filesystem::path& file, const std::string& variant = {},
               const scene::PointsAndLines& pointsAndLines = {}, const std::string& camera = {},
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

// Worker runs tasks one after another on a thread of its own, and their completions on the main thread.
class Worker {
  public:
    // Completes a task on the main thread.
    using Finish = std::function<void()>;
    // Runs on the worker's thread. It may throw.
    using Task = std::function<Finish()>;
    // Is called on the main thread, in place of Finish, with one line of what was thrown.
    using Fail = std::function<void(const std::string& why)>;

    Worker() = default;
    ~Worker();  // waits for all tasks; calls no more Finish or Fail
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    void Add(Task task, Fail fail);
    // Calls the pending Finish and Fail functions. It never waits for a task.
    void FinishTasks();
    // Returns whether there are tasks whose completion has not run.
    bool IsBusy() const { return m_unfinished > 0; }

  private:
    struct Entry {
        Task task;
        Fail fail;
    };
    void Run();

    std::thread m_thread;     // started by the first task
    size_t m_unfinished = 0;  // read and written on the main thread
    mutable std::mutex m_mutex;
    std::condition_variable m_hasChanged;
    // guarded by m_mutex
    bool m_isEnding = false;
    std::deque<Entry> m_tasks;
    std::vector<Finish> m_due;
};

}  // namespace raygraph::editor
