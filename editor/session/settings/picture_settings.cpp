#include "editor/session/settings/setting_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/printable.h"
#include "base/text.h"
#include "editor/session/settings/parse.h"

namespace raygraph::session {

namespace {

const std::string kOpenLight = Name(DefaultLight::Auto);

// Returns the texts with those of missing settings.
SettingTexts AllTexts(const SettingTexts& given) {
    return Texts(SettingsFrom(given));
}

// Makes a setting that is one of a choice. `field` returns the field of settings: [](auto& settings) -> auto&
// { ... }.
template <typename Field>
PictureSetting Choice(const char* name, const char* operand, const std::string& what, Field field) {
    using Value = std::remove_reference_t<decltype(field(std::declval<PictureSettings&>()))>;
    static constexpr auto kTexts = Texts(Value{});
    const PictureSettings defaults;
    return {.name = name,
            .operand = operand,
            .help = what + ": " + ListForHelp(field(defaults)),
            .set = [field](PictureSettings& settings,
                           std::string_view text) { field(settings) = ParseChoice<Value>(text); },
            .text = [field](const PictureSettings& settings) { return std::string(Name(field(settings))); },
            .choices = {kTexts.begin(), kTexts.end()}};
}

// Makes a setting that is on or off.
template <typename Field>
PictureSetting Switch(const char* name, const std::string& help, Field field) {
    return {.name = name,
            .operand = "on|off",
            .help = help,
            .set =
                [field](PictureSettings& settings, std::string_view text) {
                    field(settings) = ParseChoice(text, {"off", "on"}) == 1;
                },
            .text = [field](const PictureSettings& settings) { return field(settings) ? "on" : "off"; },
            .choices = {"on", "off"}};
}

// Makes a setting for the radius of points or lines.
template <typename Field>
PictureSetting Radius(const char* name, const std::string& what, Field field) {
    return {.name = name,
            .operand = "RADIUS",
            .help = what + kRadiusHelp,
            .set = [field](PictureSettings& settings,
                           std::string_view text) { field(settings) = scene::ParseRoundRadius(text); },
            .text = [field](const PictureSettings& settings) { return scene::ToText(field(settings)); }};
}

bool HasProbability(Roulette kind) {
    return kind == Roulette::Constant || kind == Roulette::Frame;
}

// Accepts "throughput", "off", "constant:P" and "frame:P".
void SetRoulette(passes::RouletteSettings& roulette, std::string_view text) {
    const size_t colon = text.find(':');
    const std::string name(text.substr(0, colon));
    roulette.kind = ParseChoice<Roulette>(name);
    const bool hasProbability = HasProbability(roulette.kind);
    if (hasProbability != (colon != std::string_view::npos))
        throw MakeError(ErrorKind::Usage, "\"{}\" {}{}{}", text,
                        (hasProbability ? "needs a probability, as in " : "takes none: "), name,
                        (hasProbability ? ":0.8" : ""));
    if (hasProbability)
        roulette.survival = static_cast<float>(ParseNumber(text.substr(colon + 1), 0.01, 1.0));
}

// Returns a float's digits if the number is a float.
std::string NumberText(double value) {
    if (static_cast<double>(static_cast<float>(value)) == value) return ToText(static_cast<float>(value));
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

constexpr const char* kNoShutter = "none";
constexpr const char* kNoCrop = "none";

// The lower right corner is checked when the size is known.
void SetCrop(std::optional<passes::Region>& crop, std::string_view text) {
    crop.reset();
    if (text == kNoCrop) return;
    try {
        const std::vector<std::string_view> parts = ParseList(text);
        if (parts.size() == 4) {
            const auto place = [&](size_t i) { return ParseCount(parts[i], 0, kMaxImageSide - 1); };
            const auto side = [&](size_t i) { return ParseCount(parts[i], 1, kMaxImageSide); };
            crop = passes::Region{place(0), place(1), side(2), side(3)};
            return;
        }
    } catch (const Error&) {
        // The message for the whole text says more than the one for its part
    }
    throw MakeError(ErrorKind::Usage, "{} is not X,Y,W,H: the upper left corner and the size, in pixels",
                    Quoted(text));
}

std::string CropText(const std::optional<passes::Region>& crop) {
    return crop ? Text("{},{},{},{}", crop->x, crop->y, crop->width, crop->height) : kNoCrop;
}

std::string RouletteText(const passes::RouletteSettings& roulette) {
    const std::string name = Name(roulette.kind);
    return HasProbability(roulette.kind) ? name + ":" + ToText(roulette.survival) : name;
}

void SetShutter(std::optional<Shutter>& shutter, std::string_view text) {
    shutter.reset();
    if (text == kNoShutter) return;
    const size_t colon = text.find(':');
    if (colon == text.npos) throw MakeError(ErrorKind::Usage, "\"{}\" is not OPEN:CLOSE", text);
    shutter = Shutter{ParseNumber(text.substr(0, colon), -1e6, 1e6),
                      ParseNumber(text.substr(colon + 1), -1e6, 1e6)};
    if (!(shutter->open < shutter->close))
        throw MakeError(ErrorKind::Usage, "\"{}\": a shutter closes after it opens", text);
}

std::string ShutterText(const std::optional<Shutter>& shutter) {
    return shutter ? NumberText(shutter->open) + ":" + NumberText(shutter->close) : kNoShutter;
}

std::string RouletteHelp() {
    std::vector<std::string> texts;
    for (const Roulette kind : Values<Roulette>())
        texts.push_back(std::string(Name(kind)) + (HasProbability(kind) ? ":P" : ""));
    constexpr auto kNotes = Notes(Roulette{});
    return ListForHelp({texts.begin(), texts.end()}, {kNotes.begin(), kNotes.end()},
                       static_cast<size_t>(passes::RouletteSettings{}.kind));
}

// The table is no plain constant, since its help is generated.
const std::vector<PictureSetting>& Table() {
    static const std::vector<PictureSetting> kTable = {
        {"size", "WxH", "Size of the picture in pixels ({})",
         [](PictureSettings& settings, std::string_view text) { settings.size = ParseSize(text); },
         [](const PictureSettings& settings) { return ToText(settings.size); }},
        {"crop", "X,Y,W,H",
         "Render only W times H pixels of the picture from X, Y on, counted from the upper left corner ({})",
         [](PictureSettings& settings, std::string_view text) { SetCrop(settings.crop, text); },
         [](const PictureSettings& settings) { return CropText(settings.crop); }},
        Choice(
            "view", "VIEW", "What the picture shows", [](auto& settings) -> auto& { return settings.view; }),
        {"camera", "CAMERA",
         "A camera of the scene by name or index, or \"eye target up fov\" as ten numbers: fov is the "
         "vertical "
         "angle in degrees, or with m the height of an orthographic view in meters. Default: the scene's "
         "first "
         "camera, else one that frames the scene",
         [](PictureSettings& settings, std::string_view text) {
             if (scene::IsViewText(text))
                 std::ignore = scene::ViewFromText(text, 1.0f);  // rejects malformed texts early
             settings.camera = text;
         },
         [](const PictureSettings& settings) { return settings.camera; }},
        {"scene", "SCENE", "Scene of the glTF file, by name or index (the file's default)",
         [](PictureSettings& settings, std::string_view text) { settings.scene = text; },
         [](const PictureSettings& settings) { return settings.scene; }},
        {"variant", "VARIANT", "Variant of the materials, by name or index (none)",
         [](PictureSettings& settings, std::string_view text) { settings.variant = text; },
         [](const PictureSettings& settings) { return settings.variant; }},
        {"at", "SECONDS", "Time of the animations. Default: none, the scene has its rest pose",
         [](PictureSettings& settings, std::string_view text) {
             settings.at.reset();
             if (!text.empty()) settings.at = ParseNumber(text, -1e6, 1e6);
         },
         [](const PictureSettings& settings) { return AtText(settings.at); }},
        {"clips", "LIST",
         "Animations to play, by name or index, with weights to blend them: \"walk:0.3,run:0.7\"; or all. "
         "Default: the first. Needs --at",
         [](PictureSettings& settings, std::string_view text) { settings.clips = text; },
         [](const PictureSettings& settings) { return settings.clips; }},
        {"shutter", "OPEN:CLOSE",
         "Motion blur: when the shutter opens and closes, in seconds after --at, as -0.01:0.01 ({}). Needs "
         "--at",
         [](PictureSettings& settings, std::string_view text) { SetShutter(settings.shutter, text); },
         [](const PictureSettings& settings) { return ShutterText(settings.shutter); }},
        Radius(
            "points", "Radius of points, shown as spheres",
            [](auto& settings) -> auto& { return settings.pointsAndLines.points; }),
        Radius(
            "lines", "Radius of lines, shown as capsules",
            [](auto& settings) -> auto& { return settings.pointsAndLines.lines; }),
        {"seed", "N", "Seed of the random numbers ({})",
         [](PictureSettings& settings, std::string_view text) { settings.paths.seed = ParseCount(text); },
         [](const PictureSettings& settings) { return std::to_string(settings.paths.seed); }},
        Switch(
            "adaptive", "Distribute the samples by the noise of each pixel ({}); --spp is the average",
            [](auto& settings) -> auto& { return settings.isAdaptive; }),
        Choice(
            "sampler", "SAMPLER", "Random numbers",
            [](auto& settings) -> auto& { return settings.paths.sampler; }),
        Choice(
            "brdf", "BRDF", "How surfaces scatter",
            [](auto& settings) -> auto& { return settings.paths.scattering.brdf; }),
        Choice(
            "distribution", "D", "Microfacets",
            [](auto& settings) -> auto& { return settings.paths.scattering.distribution; }),
        Choice(
            "masking", "G", "Shadowing of microfacets",
            [](auto& settings) -> auto& { return settings.paths.scattering.masking; }),
        Choice(
            "fresnel", "F", "Reflectance over angle",
            [](auto& settings) -> auto& { return settings.paths.scattering.fresnel; }),
        Choice(
            "multiscatter", "M", "Light between microfacets",
            [](auto& settings) -> auto& { return settings.paths.scattering.multiscatter; }),
        Switch(
            "nee", "Sample the lights ({}). Without it, rays find lights by chance, and punctual ones never",
            [](auto& settings) -> auto& { return settings.paths.lights.isOn; }),
        Choice(
            "light-sampler", "L", "How a light is chosen",
            [](auto& settings) -> auto& { return settings.paths.lights.sampler; }),
        Choice(
            "mis", "HEURISTIC", "Weights of light sampling and BSDF sampling",
            [](auto& settings) -> auto& { return settings.paths.lights.mis; }),
        {"rr", "ROULETTE", "How paths end: " + RouletteHelp(),
         [](PictureSettings& settings, std::string_view text) { SetRoulette(settings.paths.roulette, text); },
         [](const PictureSettings& settings) { return RouletteText(settings.paths.roulette); }},
        {"rr-start", "N", "First bounce at which Russian roulette may end a path ({})",
         [](PictureSettings& settings, std::string_view text) {
             settings.paths.roulette.start = ParseCount(text);
         },
         [](const PictureSettings& settings) { return std::to_string(settings.paths.roulette.start); }},
        {"max-depth", "N", "Bias: end paths after N bounces, which darkens the picture, or none. Default: {}",
         [](PictureSettings& settings, std::string_view text) {
             settings.paths.biases.maxDepth =
                 text == "none" ? passes::kNoDepthLimit : ParseCount(text, 0, passes::kNoDepthLimit - 1);
         },
         [](const PictureSettings& settings) {
             return settings.paths.biases.maxDepth == passes::kNoDepthLimit
                        ? std::string("none")
                        : std::to_string(settings.paths.biases.maxDepth);
         }},
        {"clamp-indirect", "RADIANCE",
         "Bias: clamp the radiance of light that was scattered twice or more. Default: {}",
         [](PictureSettings& settings, std::string_view text) {
             settings.paths.biases.clampIndirect = text == "none"
                                                       ? std::numeric_limits<float>::infinity()
                                                       : static_cast<float>(ParseNumber(text, 1e-6, 1e30));
         },
         [](const PictureSettings& settings) {
             return std::isinf(settings.paths.biases.clampIndirect)
                        ? std::string("none")
                        : ToText(settings.paths.biases.clampIndirect);
         }},
        {"regularize", "ALPHA", "Bias: give surfaces after the first bounce at least this GGX alpha ({})",
         [](PictureSettings& settings, std::string_view text) {
             settings.paths.biases.regularize = static_cast<float>(ParseNumber(text, 0.0, 1.0));
         },
         [](const PictureSettings& settings) { return ToText(settings.paths.biases.regularize); }},
        Switch(
            "shadow-terminator",
            "Bias: shade opaque surfaces as curved, as their vertex normals are, to smooth the shadows that "
            "they cast on themselves ({})",
            [](auto& settings) -> auto& { return settings.paths.biases.shadowTerminator; }),
        {"texture-lod", "BIAS",
         "Bias: read textures at the mip level that fits the width of the path, plus this (negative: "
         "sharper). "
         "Default: {}, at full resolution",
         [](PictureSettings& settings, std::string_view text) {
             settings.paths.biases.textureLod = text == "none"
                                                    ? -std::numeric_limits<float>::infinity()
                                                    : static_cast<float>(ParseNumber(text, -16.0, 16.0));
         },
         [](const PictureSettings& settings) {
             return std::isinf(settings.paths.biases.textureLod) ? std::string("none")
                                                                 : ToText(settings.paths.biases.textureLod);
         }},
        Choice(
            "shadows", "SHADOWS", "Shadows of the raster view",
            [](auto& settings) -> auto& { return settings.raster.shadows; }),
        {"aperture", "RADIUS", "Radius of the camera's lens in meters ({}: a pinhole)",
         [](PictureSettings& settings, std::string_view text) {
             settings.aperture = static_cast<float>(ParseNumber(text, 0.0, 1e6));
         },
         [](const PictureSettings& settings) { return ToText(settings.aperture); }},
        {"focus", "DISTANCE", "Distance in focus, in meters ({}: the middle of the scene's bounds)",
         [](PictureSettings& settings, std::string_view text) {
             settings.focusDistance = static_cast<float>(ParseNumber(text, 0.0, 1e9));
         },
         [](const PictureSettings& settings) { return ToText(settings.focusDistance); }},
        {"env-rotation", "DEG", "Rotation of the environment map, or of the studio, about +y ({})",
         [](PictureSettings& settings, std::string_view text) {
             settings.environmentRotation = static_cast<float>(ParseNumber(text, -36000.0, 36000.0));
         },
         [](const PictureSettings& settings) { return ToText(settings.environmentRotation); }},
        Choice(
            kLightSetting.data(), "LIGHT",
            "Built-in studio as the environment, where neither a map nor a background is given",
            [](auto& settings) -> auto& { return settings.light; }),
        {"env-tint", "R,G,B", "Factor on the radiance of the environment map, or of the studio ({})",
         [](PictureSettings& settings, std::string_view text) {
             settings.environmentTint = ParseRadiance(text);
         },
         [](const PictureSettings& settings) { return ToText(settings.environmentTint); }},
        {"background", "COLOR",
         "Constant radiance of the environment, instead of a map: a number, R,G,B, #rrggbb or a name as "
         "gray. "
         "Default: {}",
         [](PictureSettings& settings, std::string_view text) {
             settings.background.reset();
             if (text != "none") settings.background = ParseColor(text);
         },
         [](const PictureSettings& settings) {
             return settings.background ? ToText(*settings.background) : std::string("none");
         }},
        Switch(
            "transparent",
            "Leave out the environment where the camera sees it directly ({}); alpha is 0 there",
            [](auto& settings) -> auto& { return settings.paths.isEnvironmentHidden; }),
        Switch(
            "ground",
            "Put a gray ground under the scene ({}), of which only the shadow is seen: a .png is as with "
            "--backdrop map, and an .exr has the shadow in its alpha, as with --transparent on",
            [](auto& settings) -> auto& { return settings.hasGround; }),
        {"texture-budget", "SIZE",
         "Bias: device memory of textures, as 512M; where they take more, large ones lose detail. Default: "
         "{}, "
         "half of the device's",
         [](PictureSettings& settings, std::string_view text) { settings.textureBudget = ParseBudget(text); },
         [](const PictureSettings& settings) { return BudgetText(settings.textureBudget); }},
        {"light-group", "NAME=PATTERN,...",
         "Write the radiance of a group of lights to channels light.NAME.R, G and B of an .exr. A light is "
         "in "
         "the group if the name of its material, of itself or of its node matches a PATTERN of the shell. "
         "May "
         "be given eight times; all other light is in light.environment and light.rest",
         [](PictureSettings& settings, std::string_view text) {
             settings.lightGroups = ParseLightGroups(text);
         },
         [](const PictureSettings& settings) { return ToText(settings.lightGroups); }, true},
    };
    return kTable;
}

}  // namespace

std::string PictureSetting::HelpWith(const PictureSettings& defaults) const {
    std::string shown = help;
    if (const size_t place = shown.find("{}"); place != std::string::npos)
        shown.replace(place, 2, text(defaults));
    return shown;
}

std::span<const PictureSetting> PictureSettingTable() {
    return Table();
}

bool IsSetting(std::string_view name) {
    return std::ranges::any_of(Table(), [&](const PictureSetting& setting) { return setting.name == name; });
}

SettingTexts Texts(const PictureSettings& settings) {
    SettingTexts texts;
    for (const PictureSetting& setting : Table()) texts[setting.name] = setting.text(settings);
    return texts;
}

PictureSettings SettingsFrom(const SettingTexts& texts, const PictureSettings& defaults) {
    PictureSettings settings = defaults;
    for (const PictureSetting& setting : Table()) {
        const auto text = texts.find(setting.name);
        if (text == texts.end()) continue;
        try {
            setting.set(settings, text->second);
        } catch (const Error& error) {
            throw SettingError(error.Kind(), Text("{}: {}", setting.name, error.what()));
        }
    }
    try {
        if (settings.crop) passes::RequireWithin(settings.size, *settings.crop);
    } catch (const Error& error) {
        throw SettingError(error.Kind(), Text("crop: {}", error.what()));
    }
    return settings;
}

std::string FirstDifference(const SettingTexts& a, const SettingTexts& b) {
    const SettingTexts textsA = AllTexts(a), textsB = AllTexts(b);
    for (const PictureSetting& setting : Table()) {
        const std::string &inA = textsA.at(setting.name), &inB = textsB.at(setting.name);
        if (inA == inB) continue;
        if (IsOpen(setting.name, inA) || IsOpen(setting.name, inB)) continue;
        const auto quoted = [](const std::string& text) { return text.empty() ? "the default" : text; };
        return Text("{}: {} against {}", setting.name, quoted(inA), quoted(inB));
    }
    return {};
}

bool IsOpen(std::string_view setting, std::string_view text) {
    return setting == kLightSetting && text == kOpenLight;
}

std::string AtText(const std::optional<double>& at) {
    return at ? NumberText(*at) : std::string();
}

float DefaultFocus(const scene::CameraView& view, const scene::Bounds& bounds) {
    if (bounds.IsEmpty()) return 1.0f;
    const float distance = glm::dot(bounds.Center() - glm::vec3(view.eye), view.forward);
    return distance > 0.0f ? distance : 1.0f;
}

std::string CameraText(const scene::CameraView& view) {
    std::string text;
    for (const glm::dvec3& place : {view.eye, view.eye + glm::dvec3(view.forward), glm::dvec3(view.up)})
        for (int i = 0; i < 3; ++i) text.append(NumberText(place[i])).append(1, ' ');
    if (view.projection == scene::Projection::Orthographic)
        return text.append(ToText(view.height)).append("m");
    return text.append(ToText(glm::degrees(view.yFov)));
}

}  // namespace raygraph::session
