#include "editor/app/render_words.h"

#include <algorithm>
#include <system_error>

#include "base/os.h"
#include "base/text.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/picture_settings.h"
#include "passes/views.h"

namespace raygraph::editor {

namespace {

namespace fs = std::filesystem;

// Leaves out the settings that `render` refuses for its view, which have no effect on it.
session::PictureSettings WithoutUnused(session::PictureSettings settings) {
    const session::PictureSettings defaults;
    if (settings.view != passes::View::Raster) settings.raster.shadows = defaults.raster.shadows;
    if (settings.view == passes::View::PathTraced) return settings;
    settings.paths.isEnvironmentHidden = false;
    settings.hasGround = false;
    if (!passes::CountsPaths(settings.view)) {
        viewport::PathSettings paths{.sampler = settings.paths.sampler, .seed = settings.paths.seed};
        if (settings.view == passes::View::Raster) paths.scattering = settings.paths.scattering;
        settings.paths = paths;
        settings.aperture = defaults.aperture;
        settings.focusDistance = defaults.focusDistance;
    }
    if (!passes::ShowsLight(settings.view) && !passes::CountsPaths(settings.view)) {
        settings.environmentRotation = defaults.environmentRotation;
        settings.environmentTint = defaults.environmentTint;
        settings.background = defaults.background;
        settings.light = defaults.light;
    }
    return settings;
}

// Returns the cameras in the order of the file.
std::vector<uint32_t> OrderedCameras(const Workspace& work) {
    const scene::SceneData& scene = work.document.Scene();
    std::vector<uint32_t> cameras;
    for (const uint32_t node : scene.nodeOrder)
        for (uint32_t i = 0; i < scene.cameras.size(); ++i)
            if (scene.cameras[i].node == node) cameras.push_back(i);
    return cameras;
}

}  // namespace

void AddOption(std::vector<std::string>& words, std::string_view name, const std::string& value) {
    words.push_back("--" + std::string(name));
    // A value like -45 is not to be taken for an option
    if (value.starts_with('-'))
        words.back() += "=" + value;
    else
        words.push_back(value);
}

std::string FullPath(const fs::path& file) {
    std::error_code error;
    const fs::path whole = fs::absolute(file, error);
    return (error ? file : whole).string();
}

std::string CameraChoice(const Workspace& work, uint32_t camera) {
    const std::vector<scene::Camera>& all = work.document.Scene().cameras;
    const std::vector<uint32_t> cameras = OrderedCameras(work);
    const std::string& name = all[camera].name;
    const auto isNamed = [&](uint32_t i) { return all[i].name == name; };
    if (!name.empty() && std::ranges::count_if(cameras, isNamed) == 1) return name;
    return std::to_string(std::ranges::find(cameras, camera) - cameras.begin());
}

std::vector<std::string> CameraChoices(const Workspace& work) {
    std::vector<std::string> choices;
    for (const uint32_t camera : OrderedCameras(work)) choices.push_back(CameraChoice(work, camera));
    return choices;
}

scene::CameraView RenderedView(const Workspace& work) {
    const scene::CameraView& view = work.camera.View();
    try {
        scene::CameraView read = scene::ViewFromText(session::CameraText(view), view.aspect);
        read.zNear = view.zNear;
        read.zFar = view.zFar;
        return read;
    } catch (const Error&) {
        return view;  // it is so far away that its text has no direction
    }
}

session::PictureSettings ShownSettings(const Workspace& work) {
    const viewport::ShowSettings& show = work.view.Show();
    if (show.view == viewport::View::Surface) return ShownSettings(work, show.surface);
    return ShownSettings(
        work, show.view == viewport::View::Raster ? passes::View::Raster : passes::View::PathTraced);
}

session::PictureSettings ShownSettings(const Workspace& work, passes::View view) {
    const viewport::CaptureResult shown{.extent = work.view.Size(),
                                        .lens = work.Lens(),
                                        .paths = work.view.Paths(),
                                        .raster = work.view.Raster(),
                                        .environment = work.gpu.ShownEnvironment()};
    session::PictureSettings settings = SettingsOf(shown, work.Shown());
    settings.view = view;
    return WithoutUnused(settings);
}

std::vector<std::string> RenderWords(const Workspace& work, const session::PictureSettings& settings,
                                     bool isShown) {
    std::vector<std::string> words;
    const auto add = [&](std::string_view name, const std::string& value) { AddOption(words, name, value); };
    const session::SettingTexts defaults = session::Texts(session::PictureSettings{});
    session::SettingTexts texts = session::Texts(settings);
    for (const char* first : {"camera", "size"})
        if (const std::string text = texts.extract(first).mapped(); !text.empty()) add(first, text);
    if (const auto behind = work.ShownBackdrop(); settings.paths.isEnvironmentHidden && behind && isShown) {
        texts.erase("transparent");
        if (behind != passes::BackdropSettings{}) add("backdrop", session::BackdropText(behind));
    }
    for (const auto& [name, text] : texts)
        if (text != defaults.at(name)) add(name, text);
    const bool showsLight = passes::ShowsLight(settings.view);
    if (!work.EnvironmentFile().empty() && (showsLight || passes::CountsPaths(settings.view)))
        add("env", FullPath(work.EnvironmentFile()));
    if (!showsLight || !isShown) return words;
    const passes::TonemapSettings& tonemap = work.view.Show().tonemap;
    const passes::TonemapSettings plain;
    if (tonemap.exposureEv != plain.exposureEv) add("exposure", session::ToText(tonemap.exposureEv));
    if (work.WhitePoint() != Settings().whitePoint) add("white-point", std::to_string(work.WhitePoint()));
    if (tonemap.tonemapOperator != plain.tonemapOperator)
        add("tonemap",
            tonemap.tonemapOperator == TonemapOperator::Linear ? "raw" : Name(tonemap.tonemapOperator));
    return words;
}

std::string ShellLine(std::span<const std::string> words) {
    std::string line;
    for (const std::string& word : words) line.append(line.empty() ? "" : " ").append(os::ForShell(word));
    return line;
}

std::string CameraOption(const Workspace& work) {
    return "--camera \"" + session::CameraText(work.camera.View()) + "\"";
}

std::string RenderCommand(const Workspace& work) {
    std::vector<std::string> words{"raygraph", "render", FullPath(work.document.File())};
    if (!work.root.empty()) AddOption(words, "root", FullPath(work.root));
    for (std::string& word : RenderWords(work, ShownSettings(work))) words.push_back(std::move(word));
    return ShellLine(words);
}

}  // namespace raygraph::editor
