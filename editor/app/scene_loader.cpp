#include "editor/app/scene_loader.h"

#include <exception>
#include <tuple>
#include <utility>

#include "base/text.h"
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
                        const scene::PointsAndLines& pointsAndLines, const ChangeView& changeView,
                        const std::filesystem::path& root) {
    if (IsLoading()) return false;
    m_isDone = false;
    m_progress = {};
    m_thread = std::thread([this, file, variant, pointsAndLines, changeView, root] {
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
            std::string viewMessage;
            std::optional<SceneView> view = ReadView(file, viewMessage);
            try {
                if (view) std::ignore = scene::ChooseView(data, view->camera, 1.0f);
            } catch (const Error& error) {
                viewMessage = Text("{}: {}; ignored", ViewFileOf(file), error.what());
                view.reset();
            }
            SceneView seen = view.value_or(SceneView());
            if (changeView) changeView(seen);
            std::ignore = scene::ChooseView(data, seen.camera, 1.0f);  // throws if there is no such camera
            std::string hash = session::HashOf(data);
            scene::DeformInstances(data);
            Document document(file, data, stamp, std::move(hash), root);
            m_result =
                LoadedScene{.document = std::move(document),
                            .scene = PreparedScene(std::move(data), {.buildsWideBvhs = m_buildsWideBvhs}),
                            .view = view,
                            .changeView = changeView,
                            .viewMessage = std::move(viewMessage)};
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

}  // namespace raygraph::editor
