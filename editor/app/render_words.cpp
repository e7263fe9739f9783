#include "editor/app/render_words.h"

#include <algorithm>
#include <system_error>

#include "base/text.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/picture_settings.h"
#include "passes/views.h"

namespace raygraph::editor {

namespace {

namespace fs = std::filesystem;

// Returns the path in full: a command may be run from any folder.
std::string FullPath(const fs::path& file) {
    std::error_code error;
    const fs::path whole = fs::absolute(file, error);
    return (error ? file : whole).string();
}

// Leaves out the settings that `render` refuses for its view, which have no effect on it.
session::PictureSettings WithoutUnused(session::PictureSettings settings) {
    const session::PictureSettings defaults;
    if (settings.view != passes::View::Raster) settings.raster.shadows = defaults.raster.shadows;
    if (settings.view == passes::View::PathTraced) return settings;
    settings.paths.isEnvironmentHidden = false;
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

// Quotes a word where a shell would take it apart or change it.
std::string ShellWord(const std::string& word) {
    constexpr std::string_view kPlain = "-_./,:=+%@";
    const auto isPlain = [&](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               kPlain.find(c) != std::string_view::npos;
    };
    if (!word.empty() && std::ranges::all_of(word, isPlain)) return word;
    const bool isInert = word.find_first_of("\"\\$`!") == std::string::npos;
    if (isInert) return '"' + word + '"';
    std::string quoted = "'";
    for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

}  // namespace

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
    const viewport::CaptureResult shown{.extent = work.view.Size(),
                                        .isRaster = show.view == viewport::View::Raster,
                                        .lens = work.Lens(),
                                        .paths = work.view.Paths(),
                                        .raster = work.view.Raster(),
                                        .environment = work.gpu.ShownEnvironment()};
    session::PictureSettings settings = SettingsOf(shown, work.Shown());
    if (show.view == viewport::View::Surface) settings.view = show.surface;
    return WithoutUnused(settings);
}

std::vector<std::string> RenderWords(const Workspace& work, const session::PictureSettings& settings) {
    std::vector<std::string> words;
    const auto add = [&](const std::string& name, const std::string& value) {
        // A value like -45 is not to be taken for an option
        if (value.starts_with('-')) {
            words.push_back("--" + name + "=" + value);
        } else {
            words.push_back("--" + name);
            words.push_back(value);
        }
    };
    const session::SettingTexts defaults = session::Texts(session::PictureSettings{});
    session::SettingTexts texts = session::Texts(settings);
    for (const char* first : {"camera", "size"}) add(first, texts.extract(first).mapped());
    for (const auto& [name, text] : texts)
        if (text != defaults.at(name)) add(name, text);
    const bool showsLight = passes::ShowsLight(settings.view);
    if (!work.EnvironmentFile().empty() && (showsLight || passes::CountsPaths(settings.view)))
        add("env", FullPath(work.EnvironmentFile()));
    if (!work.root.empty()) add("root", FullPath(work.root));
    if (!showsLight) return words;
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
    for (const std::string& word : words) line.append(line.empty() ? "" : " ").append(ShellWord(word));
    return line;
}

std::string CameraOption(const Workspace& work) {
    return "--camera \"" + session::CameraText(work.camera.View()) + "\"";
}

std::string RenderCommand(const Workspace& work) {
    std::vector<std::string> words{"raygraph", "render", FullPath(work.document.File())};
    for (std::string& word : RenderWords(work, ShownSettings(work))) words.push_back(std::move(word));
    return ShellLine(words);
}

}  // namespace raygraph::editor
