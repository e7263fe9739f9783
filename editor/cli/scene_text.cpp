#include "editor/cli/scene_text.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "base/printable.h"

namespace raygraph::cli {

namespace {

constexpr size_t kMostListed = 20;
constexpr size_t kMostOfName = 1024;  // bytes

template <typename... Values>
std::string Printed(const char* format, Values... values) {
    std::array<char, 160> text{};
    std::snprintf(text.data(), text.size(), format, values...);
    return text.data();
}

std::string Joined(std::initializer_list<std::string_view> parts) {
    std::string text;
    for (const std::string_view part : parts) text += part;
    return text;
}

std::string Line(const char* label, const std::string& text) {
    return Joined({Printed("  %-12s", label), text, "\n"});
}

std::string Text(const glm::vec3& v) {
    return Printed("%.4g %.4g %.4g", static_cast<double>(v.x), static_cast<double>(v.y),
                   static_cast<double>(v.z));
}

double Degrees(float radians) {
    return static_cast<double>(glm::degrees(radians));
}

// A heading with the number of things, then each thing on a line, with its index.
template <typename Thing, typename Describe>
std::string List(const char* label, const std::vector<Thing>& things, Describe&& describe) {
    std::string text = Line(label, things.empty() ? "none" : GroupDigits(things.size()));
    const size_t shown = std::min(things.size(), kMostListed);
    for (size_t i = 0; i < shown; i++)
        text += Joined({"    ", std::to_string(i), "  ", Quoted(things[i].name, kMostOfName), "  ",
                        describe(things[i]), "\n"});
    if (things.size() > shown)
        text += Joined({"    ... and ", GroupDigits(things.size() - shown), " more\n"});
    return text;
}

std::string Describe(const scene::Camera& camera) {
    const glm::vec3 eye = camera.cameraToWorld[3];
    if (camera.projection == scene::Projection::Orthographic)
        return Printed("orthographic, %.4g m high, at ", 2.0 * static_cast<double>(camera.yMag)) + Text(eye);
    return Printed("perspective, vertical angle %.4g degrees, at ", Degrees(camera.yFov)) + Text(eye);
}

std::string Describe(const scene::Light& light) {
    const double intensity = static_cast<double>(light.intensity);
    std::string text;
    switch (light.type) {
        case scene::LightType::Directional:
            text = Printed("directional, %.4g lx", intensity);
            break;
        case scene::LightType::Point:
            text = Printed("point, %.4g cd", intensity);
            break;
        case scene::LightType::Spot:
            text =
                Printed("spot, %.4g cd, cone %.4g degrees", intensity, 2.0 * Degrees(light.outerConeAngle));
            break;
    }
    return Joined({text, ", colour ", Text(light.color)});
}

std::string Describe(const scene::Material& material) {
    std::string text = Joined({"base colour ", Text(material.baseColorFactor)});
    if (material.baseColorTexture.IsPresent()) text += " x texture";
    if (material.EmittedRadiance() != glm::vec3(0.0f)) {
        text += Joined({", emits ", Text(material.EmittedRadiance())});
        if (material.emissiveTexture.IsPresent()) text += " x texture";
    }
    if (material.alphaMode == scene::AlphaMode::Mask) text += ", alpha mask";
    if (material.alphaMode == scene::AlphaMode::Blend) text += ", alpha blend";
    return text;
}

std::string TriangleText(const scene::SceneStatistics& statistics) {
    return Joined({GroupDigits(statistics.placedTriangles), " placed, ",
                   GroupDigits(statistics.uniqueTriangles), " unique"});
}

}  // namespace

std::string GroupDigits(uint64_t number) {
    std::string text = std::to_string(number);
    for (size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, 1, ',');
    return text;
}

std::string FormatBytes(uint64_t bytes) {
    constexpr std::array kUnits = {"bytes", "KiB", "MiB", "GiB", "TiB"};
    double value = static_cast<double>(bytes);
    size_t unit = 0;
    for (; value >= 1024.0 && unit + 1 < kUnits.size(); unit++) value /= 1024.0;
    return Printed(unit == 0 ? "%.0f %s" : "%.1f %s", value, kUnits[unit]);
}

std::string DescribeScene(std::string_view file, const scene::SceneData& scene) {
    const scene::SceneStatistics statistics = scene::Statistics(scene);
    std::string text(file);
    text += '\n';
    text += Line("triangles", TriangleText(statistics));
    text += Line("instances", Joined({GroupDigits(statistics.instanceCount), " of ",
                                      GroupDigits(statistics.meshCount), " meshes"}));
    text += Line("textures", GroupDigits(statistics.textureCount));
    text += Line("memory", Joined({"geometry ", FormatBytes(statistics.geometryBytes), ", images ",
                                   FormatBytes(statistics.imageBytes)}));
    text += Line("bounds", scene.bounds.IsEmpty()
                               ? "empty"
                               : Joined({Text(scene.bounds.min), " to ", Text(scene.bounds.max), " m"}));
    const auto describe = [](const auto& thing) { return Describe(thing); };
    text += List("cameras", scene.cameras, describe);
    text += List("lights", scene.lights, describe);
    text += List("materials", scene.materials, describe);
    return text;
}

}  // namespace raygraph::cli
