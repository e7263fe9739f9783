#include "editor/cli/scene_input.h"

#include <algorithm>

#include "base/printable.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/cli/content_hash.h"
#include "editor/cli/exit_code.h"
#include "renderer/scene/load_gltf.h"

namespace raygraph::cli {

SceneInput LoadInput(const std::filesystem::path& path, const std::string& choice,
                     const std::filesystem::path& environment, const Log& log, LoadProgress progress) {
    SceneInput input;
    const Stopwatch watch;
    if (!environment.empty()) {
        image::Environment map = AsInput([&] { return image::ReadEnvironment(environment); });
        for (const std::string& warning : map.warnings)
            log.Send(LogLevel::Warning, log_category::kScene, warning);
        Say(log, LogLevel::Info, log_category::kScene, "{}: {} x {} pixels read in {}",
            Printable(environment.filename().string()), map.image.width, map.image.height,
            DurationText(watch.Seconds()));
        input.environment = std::move(map.image);
        input.environmentFile = environment.filename().string();
    }
    scene::LoadOptions options;
    options.scene = choice;
    options.log = log;
    options.progress = std::move(progress);
    input.data = AsInput([&] { return scene::LoadGltf(path, options); });
    input.loadMs = watch.Milliseconds();

    input.file = path.filename().string();
    input.statistics = scene::Statistics(input.data);
    input.hash = HashOf(input.data);
    if (!input.environmentFile.empty()) input.environmentHash = HashOf(input.environment);
    return input;
}

}  // namespace raygraph::cli
