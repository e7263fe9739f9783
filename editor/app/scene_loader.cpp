#include "editor/app/scene_loader.h"

#include <exception>
#include <tuple>
#include <utility>

#include "editor/session/file/content_hash.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/camera_view.h"
#include "renderer/scene/model/variants.h"

namespace raygraph::editor {

SceneLoader::~SceneLoader() {
    if (m_thread.joinable()) m_thread.join();
}

bool SceneLoader::Start(const std::filesystem::path& file, const std::string& variant,
                        const scene::PointsAndLines& pointsAndLines, const std::string& camera,
                        const std::filesystem::path& root) {
    if (IsLoading()) return false;
    m_isDone = false;
    m_progress = {};
    m_thread = std::thread([this, file, variant, pointsAndLines, camera, root] {
        try {
            scene::LoadOptions options;
            options.log = m_log;
            options.pointsAndLines = pointsAndLines;
            options.root = root;
            options.progress = [this](std::string_view stage, float fraction) {
                const std::scoped_lock lock(m_mutex);
                m_progress = {std::string(stage), fraction};
            };
            const std::optional<FileStamp> stamp = StampOf(file);
            scene::SceneData data = scene::LoadGltf(file, options);
            scene::SetVariant(data, scene::FindVariant(data, variant));
            std::ignore = scene::ChooseView(data, camera, 1.0f);  // throws if there is no such camera
            std::string hash = session::HashOf(data);
            scene::DeformInstances(data);
            Document document(file, data, stamp, std::move(hash), root);
            m_result =
                LoadedScene{std::move(document),
                            PreparedScene(std::move(data), {.buildsWideBvhs = m_buildsWideBvhs}), camera};
        } catch (const std::exception& failure) {
            m_result = LoadFailure{file, failure.what()};
        }
        m_isDone = true;
    });
    return true;
}

SceneLoader::Progress SceneLoader::Current() const {
    const std::scoped_lock lock(m_mutex);
    return m_progress;
}

std::optional<LoadResult> SceneLoader::Take() {
    if (!m_thread.joinable() || !m_isDone) return std::nullopt;
    m_thread.join();
    return std::exchange(m_result, std::nullopt);
}

Worker::~Worker() {
    {
        const std::scoped_lock lock(m_mutex);
        m_isEnding = true;
    }
    m_hasChanged.notify_one();
    if (m_thread.joinable()) m_thread.join();
}

void Worker::Add(Task task, Fail fail) {
    if (!m_thread.joinable()) m_thread = std::thread([this] { Run(); });
    {
        const std::scoped_lock lock(m_mutex);
        m_tasks.push_back({std::move(task), std::move(fail)});
    }
    ++m_unfinished;
    m_hasChanged.notify_one();
}

void Worker::FinishTasks() {
    std::vector<Finish> due;
    {
        const std::scoped_lock lock(m_mutex);
        due.swap(m_due);
    }
    for (const Finish& finish : due) {
        --m_unfinished;
        finish();
    }
}

void Worker::Run() {
    std::unique_lock lock(m_mutex);
    while (true) {
        m_hasChanged.wait(lock, [&] { return m_isEnding || !m_tasks.empty(); });
        if (m_tasks.empty()) return;
        Entry entry = std::move(m_tasks.front());
        m_tasks.pop_front();
        lock.unlock();
        Finish finish;
        try {
            finish = entry.task();
        } catch (
            const std::exception& error) {  // Error, or an exception of a library: neither ends the editor
            finish = [fail = std::move(entry.fail), why = std::string(error.what())] { fail(why); };
        }
        entry = {};  // the task may hold much memory
        lock.lock();
        m_due.push_back(std::move(finish));
    }
}

}  // namespace raygraph::editor
