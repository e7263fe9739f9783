#include "editor/cli/scene_input.h"

#include <algorithm>

#include "base/stopwatch.h"
#include "editor/cli/content_hash.h"
#include "editor/cli/exit_code.h"
#include "renderer/scene/load_gltf.h"

namespace raygraph::cli {

SceneInput LoadInput(const std::filesystem::path& path, const std::string& choice,
                     const std::filesystem::path& environment, LoadProgress progress) {
    SceneInput input;
    const Stopwatch watch;
    if (!environment.empty()) {
        image::Environment map = AsInput([&] { return image::ReadEnvironment(environment); });
        input.environment = std::move(map.image);
        input.warnings = std::move(map.warnings);
        input.environmentFile = environment.filename().string();
    }
    scene::LoadOptions options;
    options.scene = choice;
    options.progress = std::move(progress);
    input.data = AsInput([&] { return scene::LoadGltf(path, options); });
    input.loadMs = watch.Milliseconds();

    input.file = path.filename().string();
    input.warnings.insert(input.warnings.end(), input.data.warnings.begin(), input.data.warnings.end());
    input.statistics = scene::Statistics(input.data);
    input.hash = HashOf(input.data);
    if (!input.environmentFile.empty()) input.environmentHash = HashOf(input.environment);
    return input;
}

}  // namespace raygraph::cli
