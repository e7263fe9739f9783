#include "editor/cli/scene_text.h"

#include <algorithm>
#include <array>

#include "base/printable.h"
#include "base/text.h"
#include "editor/cli/device_list.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/picture_settings.h"
#include "renderer/scene/gltf/document.h"
#include "renderer/scene/model/camera_view.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::cli {

namespace {

constexpr size_t kMaxListed = 20;
constexpr size_t kMaxNameBytes = 1024;  // longest accepted name

std::string Line(const char* label, const std::string& text) {
    return Text("  {:<12}{}\n", label, text);
}

std::string VectorText(const glm::vec3& v) {
    return Text("{:.4g} {:.4g} {:.4g}", v.x, v.y, v.z);
}

double Degrees(float radians) {
    return static_cast<double>(glm::degrees(radians));
}

// Writes a heading with the number of things, then a line for each, with its index.
template <typename Thing, typename Describe>
std::string List(const char* label, const std::vector<Thing>& things, Describe&& describe) {
    std::string text = Line(label, things.empty() ? "none" : GroupDigits(things.size()));
    const size_t shown = std::min(things.size(), kMaxListed);
    for (size_t i = 0; i < shown; ++i)
        text += Text("    {}  {}  {}\n", i, Quoted(things[i].name, kMaxNameBytes), describe(things[i]));
    if (things.size() > shown) text += Text("    ... and {} more\n", GroupDigits(things.size() - shown));
    return text;
}

std::string Describe(const scene::Camera& camera) {
    const glm::vec3 eye = camera.cameraToWorld[3];
    if (camera.projection == scene::Projection::Orthographic)
        return Text("orthographic, {:.4g} m high, at {}", 2.0f * camera.yMag, VectorText(eye));
    return Text("perspective, vertical angle {:.4g} degrees, at {}", Degrees(camera.yFov), VectorText(eye));
}

// The target is as far away as the middle of the scene.
std::string Describe(const scene::CameraView& view, const scene::Bounds& bounds) {
    const glm::vec3 center = bounds.IsEmpty() ? glm::vec3(0.0f) : bounds.Center(), eye(view.eye);
    const glm::vec3 target = eye + glm::dot(center - eye, view.forward) * view.forward;
    return Text("--camera \"{} {} {} {:.4g}\"", VectorText(eye), VectorText(target), VectorText(view.up),
                Degrees(view.yFov));
}

std::string Describe(const scene::Light& light, const std::vector<scene::LightProfile>& profiles) {
    const double intensity = static_cast<double>(light.intensity);
    std::string text;
    if (light.profile != scene::kNone)
        return Text("profile, at most {:.4g} cd, color {}",
                    intensity * static_cast<double>(profiles.at(light.profile).MaxIntensity()),
                    VectorText(light.color));
    switch (light.type) {
        case scene::LightType::Directional:
            text = Text("directional, {:.4g} lx", intensity);
            break;
        case scene::LightType::Point:
            text = Text("point, {:.4g} cd", intensity);
            break;
        case scene::LightType::Spot:
            text =
                Text("spot, {:.4g} cd, cone {:.4g} degrees", intensity, 2.0 * Degrees(light.outerConeAngle));
            break;
    }
    return Text("{}, color {}", text, VectorText(light.color));
}

std::string Describe(const scene::Material& material) {
    std::string text = Text("base color {}", VectorText(material.baseColorFactor));
    if (material.baseColorTexture.IsPresent()) text += " x texture";
    if (material.EmittedRadiance() != glm::vec3(0.0f)) {
        text += Text(", emits {}", VectorText(material.EmittedRadiance()));
        if (material.emissiveTexture.IsPresent()) text += " x texture";
    }
    if (material.alphaMode != scene::AlphaMode::Opaque) text += Text(", alpha {}", Name(material.alphaMode));
    return text;
}

// Writes a line per variant, with its index; the active one is marked.
std::string ListVariants(const scene::SceneData& scene) {
    if (scene.variants.empty()) return "";
    std::string text = Line("variants", GroupDigits(scene.variants.size()));
    const size_t shown = std::min(scene.variants.size(), kMaxListed);
    for (size_t i = 0; i < shown; ++i)
        text += Text("    {}  {}{}\n", i, Quoted(scene.variants[i], kMaxNameBytes),
                     i == scene.variant ? "  shown" : "");
    if (scene.variants.size() > shown)
        text += Text("    ... and {} more\n", GroupDigits(scene.variants.size() - shown));
    return text;
}

std::string TriangleText(const scene::SceneStatistics& statistics) {
    return Text("{} placed, {} unique", GroupDigits(statistics.placedTriangles),
                GroupDigits(statistics.uniqueTriangles));
}

}  // namespace

std::string GroupDigits(uint64_t number) {
    std::string text = std::to_string(number);
    for (size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, 1, ',');
    return text;
}

std::string DescribeExtensions() {
    std::string text;
    for (const scene::GltfExtension& extension : scene::KnownExtensions())
        text +=
            Text("{:<36}{:<10}{}\n", extension.name, extension.isRead ? "read" : "not read", extension.note);
    return text;
}

scene::CameraView FramedView(const scene::SceneData& scene) {
    const Extent2D size = session::PictureSettings{}.size;
    return scene::ViewOfBounds(scene.bounds,
                               static_cast<float>(size.width) / static_cast<float>(size.height));
}

std::string DescribeScene(std::string_view file, const scene::SceneData& scene) {
    const scene::SceneStatistics statistics = scene::Statistics(scene);
    std::string text(file);
    text += '\n';
    text += Line("triangles", TriangleText(statistics));
    if (statistics.placedSpheres > 0)
        text += Line("points", Text("{} placed", GroupDigits(statistics.placedSpheres)));
    if (statistics.placedCapsules > 0)
        text += Line("segments", Text("{} placed", GroupDigits(statistics.placedCapsules)));
    text += Line("instances", Text("{} of {} meshes", GroupDigits(statistics.instanceCount),
                                   GroupDigits(statistics.meshCount)));
    text += Line("textures", GroupDigits(statistics.textureCount));
    text += Line("memory", Text("geometry {}, images {}", BytesText(statistics.geometryBytes),
                                BytesText(statistics.imageBytes)));
    text += Line("bounds", scene.bounds.IsEmpty() ? "empty"
                                                  : Text("{} to {} m", VectorText(scene.bounds.min),
                                                         VectorText(scene.bounds.max)));
    if (const scene::EnvironmentLight& light = scene.environment; light.IsPresent())
        text += Line("environment", Text("{}, a cube of {} x {}; --env or --background replace it",
                                         Quoted(light.name, kMaxNameBytes), light.faceSize, light.faceSize));
    const auto describe = [](const auto& thing) { return Describe(thing); };
    text += List("cameras", scene.cameras, describe);
    text += Line("framed by", Describe(FramedView(scene), scene.bounds));
    text += List("lights", scene.lights,
                 [&](const scene::Light& light) { return Describe(light, scene.profiles); });
    text += List("materials", scene.materials, describe);
    text += ListVariants(scene);
    return text;
}

std::string DescribeAnimations(std::span<const session::AnimationLength> animations) {
    if (animations.empty()) return "";
    std::string text = Line("animations", GroupDigits(animations.size()));
    const size_t shown = std::min(animations.size(), kMaxListed);
    for (size_t i = 0; i < shown; ++i)
        text += Text("    {}  {}  {}\n", i, Quoted(animations[i].name, kMaxNameBytes),
                     DurationText(animations[i].seconds));
    if (animations.size() > shown)
        text += Text("    ... and {} more\n", GroupDigits(animations.size() - shown));
    return text;
}

}  // namespace raygraph::cli
