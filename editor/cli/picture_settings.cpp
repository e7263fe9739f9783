#include "editor/cli/picture_settings.h"

#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "base/error.h"
#include "renderer/scene/camera_view.h"

namespace raygraph::cli {

namespace {

// Names of an enum's values, in their order.
constexpr std::array kSamplerNames = {"sobol", "pcg", "tea"};
constexpr std::array kBrdfNames = {"gltf", "lambert", "lafortune"};
constexpr std::array kDistributionNames = {"ggx", "beckmann", "phong"};
constexpr std::array kMaskingNames = {"correlated", "separable", "shortcut"};
constexpr std::array kFresnelNames = {"schlick", "dielectric", "conductor", "lazanyi"};
constexpr std::array kMultiscatterNames = {"off", "lut", "walk"};
constexpr std::array kLightSamplerNames = {"uniform", "power", "bvh"};
constexpr std::array kMisNames = {"balance", "power", "off"};
constexpr std::array kShadowNames = {"off", "maps", "rays"};

template <typename T, size_t N>
void SetChoice(T& value, std::string_view text, const std::array<const char*, N>& names) {
    value = static_cast<T>(ParseChoice(text, {names.begin(), names.end()}));
}

template <typename T, size_t N>
std::string ChoiceText(T value, const std::array<const char*, N>& names) {
    return names[static_cast<size_t>(value)];
}

View ParseView(std::string_view text) {
    std::vector<std::string_view> names;
    for (size_t i = 0; i < passes::kViewCount; i++) names.emplace_back(Name(static_cast<View>(i)));
    return static_cast<View>(ParseChoice(text, names));
}

// "throughput", "off", "constant:P" or "frame:P".
void SetRoulette(passes::RouletteSettings& roulette, std::string_view text) {
    const size_t colon = text.find(':');
    const std::string_view name = text.substr(0, colon);
    const size_t kind = ParseChoice(name, {"throughput", "constant", "frame", "off"});
    roulette.kind = static_cast<Roulette>(kind);
    const bool hasProbability = roulette.kind == Roulette::Constant || roulette.kind == Roulette::Frame;
    if (hasProbability != (colon != std::string_view::npos))
        throw Error(ErrorKind::Usage, "\"" + std::string(text) + "\" " +
                                          (hasProbability ? "needs a probability, as in " : "takes none: ") +
                                          std::string(name) + (hasProbability ? ":0.8" : ""));
    if (hasProbability)
        roulette.survival = static_cast<float>(ParseNumber(text.substr(colon + 1), 0.01, 1.0));
}

std::string RouletteText(const passes::RouletteSettings& roulette) {
    switch (roulette.kind) {
        case Roulette::Throughput:
            return "throughput";
        case Roulette::Constant:
            return "constant:" + ToText(roulette.survival);
        case Roulette::Frame:
            return "frame:" + ToText(roulette.survival);
        case Roulette::Off:
            return "off";
    }
    return "throughput";
}

constexpr PictureSetting kTable[] = {
    {"size", "WxH", "Pixels of the picture (640x360)",
     [](PictureSettings& settings, std::string_view text) { settings.size = ParseSize(text); },
     [](const PictureSettings& settings) { return ToText(settings.size); }},
    {"view", "VIEW",
     "What the picture shows: path-traced (default), raster (drawn and lit directly), albedo, normals, "
     "roughness, metallic, emissive, depth, instance, material, wireframe, overdraw or ray-cost",
     [](PictureSettings& settings, std::string_view text) { settings.view = ParseView(text); },
     [](const PictureSettings& settings) { return std::string(Name(settings.view)); }},
    {"camera", "CAMERA",
     "A camera of the scene by name or index, or \"eye target up fov\" as ten numbers, fov the vertical "
     "angle in degrees, or with m the height that is seen, in metres, without perspective. Default: the "
     "scene's first camera, else one that frames the scene",
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
         SetChoice(settings.sampler, text, kSamplerNames);
     },
     [](const PictureSettings& settings) { return ChoiceText(settings.sampler, kSamplerNames); }},
    {"brdf", "BRDF",
     "How surfaces scatter: gltf (default), lambert (base colour as albedo, nothing else) or lafortune "
     "(modified Phong)",
     [](PictureSettings& settings, std::string_view text) {
         SetChoice(settings.scattering.brdf, text, kBrdfNames);
     },
     [](const PictureSettings& settings) { return ChoiceText(settings.scattering.brdf, kBrdfNames); }},
    {"distribution", "D", "Microfacets: ggx (default), beckmann or phong",
     [](PictureSettings& settings, std::string_view text) {
         SetChoice(settings.scattering.distribution, text, kDistributionNames);
     },
     [](const PictureSettings& settings) {
         return ChoiceText(settings.scattering.distribution, kDistributionNames);
     }},
    {"masking", "G", "Shadowing of microfacets: correlated (Smith; default), separable or shortcut",
     [](PictureSettings& settings, std::string_view text) {
         SetChoice(settings.scattering.masking, text, kMaskingNames);
     },
     [](const PictureSettings& settings) { return ChoiceText(settings.scattering.masking, kMaskingNames); }},
    {"fresnel", "F", "Reflectance over angle: schlick (default), dielectric, conductor or lazanyi",
     [](PictureSettings& settings, std::string_view text) {
         SetChoice(settings.scattering.fresnel, text, kFresnelNames);
     },
     [](const PictureSettings& settings) { return ChoiceText(settings.scattering.fresnel, kFresnelNames); }},
    {"multiscatter", "M",
     "Light between microfacets: lut (compensated by tables; default), walk (simulated) or off (lost)",
     [](PictureSettings& settings, std::string_view text) {
         SetChoice(settings.scattering.multiscatter, text, kMultiscatterNames);
     },
     [](const PictureSettings& settings) {
         return ChoiceText(settings.scattering.multiscatter, kMultiscatterNames);
     }},
    {"nee", "on|off", "Sample the lights (on); off finds light by chance alone, and no punctual light",
     [](PictureSettings& settings, std::string_view text) {
         settings.lights.isOn = ParseChoice(text, {"off", "on"}) == 1;
     },
     [](const PictureSettings& settings) { return std::string(settings.lights.isOn ? "on" : "off"); }},
    {"light-sampler", "L",
     "How a light is chosen: bvh (by its possible contribution; default), power or uniform",
     [](PictureSettings& settings, std::string_view text) {
         SetChoice(settings.lights.sampler, text, kLightSamplerNames);
     },
     [](const PictureSettings& settings) { return ChoiceText(settings.lights.sampler, kLightSamplerNames); }},
    {"mis", "HEURISTIC", "Weighing of sampled lights and sampled surfaces: power (default), balance or off",
     [](PictureSettings& settings, std::string_view text) {
         SetChoice(settings.lights.mis, text, kMisNames);
     },
     [](const PictureSettings& settings) { return ChoiceText(settings.lights.mis, kMisNames); }},
    {"rr", "ROULETTE",
     "How paths end: throughput (default), constant:P (each bounce survives with P), frame:P (one depth a "
     "sample, drawn so) or off",
     [](PictureSettings& settings, std::string_view text) { SetRoulette(settings.roulette, text); },
     [](const PictureSettings& settings) { return RouletteText(settings.roulette); }},
    {"rr-start", "N", "First bounce at which Russian roulette may end a path (2)",
     [](PictureSettings& settings, std::string_view text) { settings.roulette.start = ParseCount(text); },
     [](const PictureSettings& settings) { return std::to_string(settings.roulette.start); }},
    {"max-depth", "N", "Bias: end paths after N bounces; this darkens the picture. Default: none, no limit",
     [](PictureSettings& settings, std::string_view text) {
         settings.biases.maxDepth =
             text == "none" ? passes::kNoDepthLimit : ParseCount(text, 0, passes::kNoDepthLimit - 1);
     },
     [](const PictureSettings& settings) {
         return settings.biases.maxDepth == passes::kNoDepthLimit ? std::string("none")
                                                                  : std::to_string(settings.biases.maxDepth);
     }},
    {"clamp-indirect", "RADIANCE",
     "Bias: cut at this radiance what light that was scattered twice or more brings. Default: none",
     [](PictureSettings& settings, std::string_view text) {
         settings.biases.clampIndirect = text == "none" ? std::numeric_limits<float>::infinity()
                                                        : static_cast<float>(ParseNumber(text, 1e-6, 1e30));
     },
     [](const PictureSettings& settings) {
         return std::isinf(settings.biases.clampIndirect) ? std::string("none")
                                                          : ToText(settings.biases.clampIndirect);
     }},
    {"regularize", "ALPHA", "Bias: roughen surfaces behind the first bounce to at least this GGX alpha (0)",
     [](PictureSettings& settings, std::string_view text) {
         settings.biases.regularize = static_cast<float>(ParseNumber(text, 0.0, 1.0));
     },
     [](const PictureSettings& settings) { return ToText(settings.biases.regularize); }},
    {"shadow-terminator", "on|off",
     "Bias: shade opaque surfaces where their vertex normals bend them to, so that the shadow which a smooth "
     "body throws on itself shows no triangles (off)",
     [](PictureSettings& settings, std::string_view text) {
         settings.biases.shadowTerminator = ParseChoice(text, {"off", "on"}) == 1;
     },
     [](const PictureSettings& settings) {
         return std::string(settings.biases.shadowTerminator ? "on" : "off");
     }},
    {"shadows", "SHADOWS",
     "Shadows of the raster view: rays (default), maps (of point lights, spots and directional ones alone) "
     "or "
     "off",
     [](PictureSettings& settings, std::string_view text) {
         SetChoice(settings.raster.shadows, text, kShadowNames);
     },
     [](const PictureSettings& settings) { return ChoiceText(settings.raster.shadows, kShadowNames); }},
    {"aperture", "RADIUS", "Radius of the camera's lens in metres (0: a pinhole, all is sharp)",
     [](PictureSettings& settings, std::string_view text) {
         settings.aperture = static_cast<float>(ParseNumber(text, 0.0, 1e6));
     },
     [](const PictureSettings& settings) { return ToText(settings.aperture); }},
    {"focus", "DISTANCE", "Distance that is sharp, in metres (0: to the middle of the scene's bounds)",
     [](PictureSettings& settings, std::string_view text) {
         settings.focusDistance = static_cast<float>(ParseNumber(text, 0.0, 1e9));
     },
     [](const PictureSettings& settings) { return ToText(settings.focusDistance); }},
    {"env-rotation", "DEG", "Turns the environment map about +y (0)",
     [](PictureSettings& settings, std::string_view text) {
         settings.environmentRotation = static_cast<float>(ParseNumber(text, -36000.0, 36000.0));
     },
     [](const PictureSettings& settings) { return ToText(settings.environmentRotation); }},
    {"env-tint", "R,G,B", "Factor on the radiance of the environment map (1,1,1)",
     [](PictureSettings& settings, std::string_view text) { settings.environmentTint = ParseRadiance(text); },
     [](const PictureSettings& settings) { return ToText(settings.environmentTint); }},
    {"background", "R,G,B", "Constant radiance of the environment, instead of a map (0,0,0)",
     [](PictureSettings& settings, std::string_view text) { settings.background = ParseRadiance(text); },
     [](const PictureSettings& settings) { return ToText(settings.background); }},
    {"light-group", "NAME=PATTERN,...",
     "Keep the light of a group of lights apart, as light.NAME.R and so on in an .exr: those whose material, "
     "light or node has a name like a PATTERN (* and ? as in a shell). May be given eight times; "
     "light.environment and light.rest hold the others",
     [](PictureSettings& settings, std::string_view text) { settings.lightGroups = ParseLightGroups(text); },
     [](const PictureSettings& settings) { return ToText(settings.lightGroups); }, true},
};

}  // namespace

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
