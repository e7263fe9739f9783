#include "editor/session/settings/scene_input.h"

#include <tuple>
#include <utility>

#include "base/printable.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/session/file/content_hash.h"
#include "editor/session/settings/as_input.h"
#include "editor/session/settings/picture_settings.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/gltf/still_scene.h"
#include "renderer/scene/model/variants.h"

namespace raygraph::session {

SceneInput MakeInput(scene::SceneData data, std::string name) {
    SceneInput input;
    input.statistics = scene::Statistics(data);
    input.hash = HashOf(data);
    input.variant = scene::VariantText(data, data.variant);
    input.data = std::move(data);
    input.file = std::move(name);
    return input;
}

void SetEnvironment(SceneInput& input, image::ImageF map, std::string name) {
    const uint64_t values = uint64_t{4} * map.width * map.height;
    if (name.empty()) throw Error(ErrorKind::Usage, "SetEnvironment: the map has no name");
    if (values == 0 || map.rgba.size() != values)
        throw MakeError(ErrorKind::Usage,
                        "SetEnvironment: {}: {} x {} pixels need {} values, and there are {}", Quoted(name),
                        map.width, map.height, values, map.rgba.size());
    input.environmentHash = HashOf(map);
    input.environment = std::move(map);
    input.environmentFile = std::move(name);
}

void LoadEnvironment(SceneInput& input, const std::filesystem::path& path, const Log& log) {
    const Stopwatch watch;
    image::Environment read = AsInput([&] { return image::ReadEnvironment(path); });
    for (const std::string& warning : read.warnings)
        log.Send(LogLevel::Warning, log_category::kScene, warning);
    if (!read.note.empty()) log.Send(LogLevel::Info, log_category::kScene, read.note);
    WriteLog(log, LogLevel::Info, log_category::kScene, "{}: {} x {} pixels read in {}",
             Printable(path.filename().string()), read.image.width, read.image.height,
             DurationText(watch.Seconds()));
    input.loadMs += watch.Milliseconds();
    SetEnvironment(input, std::move(read.image), path.filename().string());
}

namespace {

void ChooseVariant(scene::SceneData& data, const std::string& choice) {
    try {
        scene::SetVariant(data, scene::FindVariant(data, choice));
    } catch (const Error& error) {
        throw SettingError(error.Kind(), Text("variant: {}", error.what()));
    }
}

void CheckClips(const scene::SceneData& data, const InputOptions& options) {
    if (!options.isAnimated && !options.clips.empty())
        throw SettingError(ErrorKind::Usage, "clips: animations play at a time, and none is given");
    std::vector<scene::ClipState> clips;
    try {
        if (options.isAnimated) clips = scene::FindClips(data, options.clips, 0.0);
    } catch (const Error& error) {
        throw SettingError(error.Kind(), Text("clips: {}", error.what()));
    }
    scene::RequirePlayable(data, clips);
}

}  // namespace

void RequireRoot(const std::filesystem::path& root) {
    if (root.empty()) return;
    std::error_code error;
    const bool isFolder = std::filesystem::is_directory(root, error);
    if (!isFolder)
        throw SettingError(ErrorKind::BadInput, Text("root: {}: {}", Quoted(root.string()),
                                                     error ? error.message() : "it is not a folder"));
}

InputOptions InputOptionsFor(const PictureSettings& settings) {
    return {.scene = settings.scene,
            .variant = settings.variant,
            .isAnimated = settings.at.has_value(),
            .clips = settings.clips,
            .pointsAndLines = settings.pointsAndLines};
}

SceneInput LoadInput(const std::filesystem::path& path, const InputOptions& options) {
    SceneInput environment;  // before the scene, which takes longer: an error comes early
    if (!options.environment.empty()) LoadEnvironment(environment, options.environment, options.log);
    const Stopwatch watch;
    RequireRoot(options.root);
    scene::LoadOptions loading;
    loading.scene = options.scene;
    loading.pointsAndLines = options.pointsAndLines;
    loading.root = options.root;
    // An error is one line, so warnings are sent once it is known that there is none.
    loading.log = Log(
        [&options](const LogMessage& message) {
            if (message.level != LogLevel::Warning)
                options.log.Send(message.level, message.category, message.text);
        },
        LogLevel::Debug);
    loading.progress = options.progress;
    scene::SceneData data = AsInput([&] { return scene::LoadGltf(path, loading); });
    ChooseVariant(data, options.variant);
    CheckClips(data, options);
    for (const std::string& warning : data.warnings)
        options.log.Send(LogLevel::Warning, log_category::kScene, warning);
    const double loadMs = environment.loadMs + watch.Milliseconds();

    SceneInput input = MakeInput(std::move(data), path.filename().string());
    for (const scene::Animation& animation : input.data.animations)
        input.animations.push_back({animation.name, animation.duration});
    if (!options.isAnimated) AsInput([&] { scene::FreezePose(input.data, {}); });
    input.scene = options.scene;
    input.variant = options.variant;
    input.isAnimated = options.isAnimated;
    input.pointsAndLines = options.pointsAndLines;
    input.loadMs = loadMs;
    input.environment = std::move(environment.environment);
    input.environmentFile = std::move(environment.environmentFile);
    input.environmentHash = std::move(environment.environmentHash);
    return input;
}

}  // namespace raygraph::session
