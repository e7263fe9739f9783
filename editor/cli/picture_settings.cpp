#include "editor/cli/picture_settings.h"

#include <tuple>
#include <vector>

#include "base/error.h"
#include "renderer/scene/camera_view.h"

namespace raygraph::cli {

namespace {

constexpr std::array kViewNames = {"path-traced", "albedo", "normals", "depth", "instance", "material"};

const std::vector<std::string_view>& SamplerNames() {
    static const std::vector<std::string_view> kNames{"sobol", "pcg", "tea"};  // in the order of SamplerKind
    return kNames;
}

constexpr PictureSetting kTable[] = {
    {"size", "WxH", "Pixels of the picture (640x360)",
     [](PictureSettings& settings, std::string_view text) { settings.size = ParseSize(text); },
     [](const PictureSettings& settings) { return ToText(settings.size); }},
    {"view", "VIEW",
     "What the picture shows: path-traced (default), albedo, normals, depth, instance or material",
     [](PictureSettings& settings, std::string_view text) {
         settings.view = static_cast<View>(ParseChoice(text, {kViewNames.begin(), kViewNames.end()}));
     },
     [](const PictureSettings& settings) { return std::string(Name(settings.view)); }},
    {"camera", "CAMERA",
     "A camera of the scene by name or index, or \"eye target up fov\" as ten numbers, fov the vertical "
     "angle "
     "in degrees. Default: the scene's first camera, else one that frames the scene",
     [](PictureSettings& settings, std::string_view text) {
         if (scene::IsViewText(text)) std::ignore = scene::ViewFromText(text, 1.0f);  // malformed ones early
         settings.camera = text;
     },
     [](const PictureSettings& settings) { return settings.camera; }},
    {"scene", "SCENE", "Which scene of the glTF file, by name or index (the file's default)",
     [](PictureSettings& settings, std::string_view text) { settings.scene = text; },
     [](const PictureSettings& settings) { return settings.scene; }},
    {"seed", "N", "Seed of the random numbers (0)",
     [](PictureSettings& settings, std::string_view text) { settings.seed = ParseCount(text); },
     [](const PictureSettings& settings) { return std::to_string(settings.seed); }},
    {"sampler", "SAMPLER", "Random numbers: sobol (Owen-scrambled; default), pcg or tea",
     [](PictureSettings& settings, std::string_view text) {
         settings.sampler = static_cast<SamplerKind>(ParseChoice(text, SamplerNames()));
     },
     [](const PictureSettings& settings) {
         return std::string(SamplerNames()[static_cast<size_t>(settings.sampler)]);
     }},
    {"brdf", "BRDF", "How surfaces scatter: lambert (base colour as albedo, nothing else; default)",
     [](PictureSettings&, std::string_view text) { ParseChoice(text, {"lambert"}); },
     [](const PictureSettings&) { return std::string("lambert"); }},
    {"max-depth", "N", "End paths after N bounces; this darkens the picture. Default: none, no limit",
     [](PictureSettings& settings, std::string_view text) {
         settings.maxDepth = text == "none" ? std::nullopt : std::optional(ParseCount(text, 0, 0xFFFFFFFEu));
     },
     [](const PictureSettings& settings) {
         return settings.maxDepth ? std::to_string(*settings.maxDepth) : std::string("none");
     }},
    {"rr-start", "N", "First bounce at which Russian roulette may end a path (2)",
     [](PictureSettings& settings, std::string_view text) { settings.rouletteStart = ParseCount(text); },
     [](const PictureSettings& settings) { return std::to_string(settings.rouletteStart); }},
    {"env-rotation", "DEG", "Turns the environment map about +y (0)",
     [](PictureSettings& settings, std::string_view text) {
         settings.environmentRotation = static_cast<float>(ParseNumber(text, -36000.0, 36000.0));
     },
     [](const PictureSettings& settings) { return ToText(settings.environmentRotation); }},
    {"background", "R,G,B", "Constant radiance of the environment, instead of a map (0,0,0)",
     [](PictureSettings& settings, std::string_view text) { settings.background = ParseRadiance(text); },
     [](const PictureSettings& settings) { return ToText(settings.background); }},
};

}  // namespace

const char* Name(View view) {
    return kViewNames[static_cast<size_t>(view)];
}

std::span<const PictureSetting> PictureSettingTable() {
    return kTable;
}

SettingTexts Texts(const PictureSettings& settings) {
    SettingTexts texts;
    for (const PictureSetting& setting : kTable) texts[setting.name] = setting.text(settings);
    return texts;
}

PictureSettings SettingsFrom(const SettingTexts& texts) {
    PictureSettings settings;
    for (const PictureSetting& setting : kTable) {
        const auto text = texts.find(setting.name);
        if (text == texts.end()) continue;
        try {
            setting.set(settings, text->second);
        } catch (const Error& error) {
            throw Error(error.Kind(), std::string("--") + setting.name + ": " + error.what());
        }
    }
    return settings;
}

std::string FirstDifference(const SettingTexts& a, const SettingTexts& b) {
    const SettingTexts textsA = Texts(SettingsFrom(a)), textsB = Texts(SettingsFrom(b));
    for (const PictureSetting& setting : kTable) {
        const std::string &inA = textsA.at(setting.name), &inB = textsB.at(setting.name);
        if (inA == inB) continue;
        const auto quoted = [](const std::string& text) { return text.empty() ? "the default" : text; };
        return std::string(setting.name) + ": " + quoted(inA) + " against " + quoted(inB);
    }
    return {};
}

}  // namespace raygraph::cli
