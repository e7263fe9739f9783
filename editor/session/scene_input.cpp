#include "editor/session/scene_input.h"

#include <utility>

#include "base/printable.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/session/as_input.h"
#include "editor/session/content_hash.h"
#include "renderer/scene/load_gltf.h"

namespace raygraph::session {

SceneInput MakeInput(scene::SceneData data, std::string name) {
    SceneInput input;
    input.statistics = scene::Statistics(data);
    input.hash = HashOf(data);
    input.data = std::move(data);
    input.file = std::move(name);
    return input;
}

SceneInput LoadInput(const std::filesystem::path& path, const InputOptions& options) {
    const Stopwatch watch;
    image::ImageF map;
    if (!options.environment.empty()) {
        image::Environment read = AsInput([&] { return image::ReadEnvironment(options.environment); });
        for (const std::string& warning : read.warnings)
            options.log.Send(LogLevel::Warning, log_category::kScene, warning);
        map = std::move(read.image);
        Say(options.log, LogLevel::Info, log_category::kScene, "{}: {} x {} pixels read in {}",
            Printable(options.environment.filename().string()), map.width, map.height,
            DurationText(watch.Seconds()));
    }
    scene::LoadOptions loading;
    loading.scene = options.scene;
    loading.log = options.log;
    loading.progress = options.progress;
    scene::SceneData data = AsInput([&] { return scene::LoadGltf(path, loading); });
    const double loadMs = watch.Milliseconds();

    SceneInput input = MakeInput(std::move(data), path.filename().string());
    input.loadMs = loadMs;
    if (options.environment.empty()) return input;
    input.environmentFile = options.environment.filename().string();
    input.environmentHash = HashOf(map);
    input.environment = std::move(map);
    return input;
}

}  // namespace raygraph::session
