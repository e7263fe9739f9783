#include "editor/session/settings/light_settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <span>

#include "renderer/scene/model/check.h"
#include "renderer/scene/model/studio.h"
#include "shaders/core/color.glsl"

namespace raygraph::session {

namespace {

constexpr double kPi = std::numbers::pi;

// Returns the mean of all texels, by the texture's color space.
glm::dvec3 MeanOf(const scene::Texture& texture, const scene::ImageData& image) {
    std::array<double, 256> values{};
    for (size_t i = 0; i < values.size(); ++i) {
        const float code = static_cast<float>(i) / 255.0f;
        values[i] =
            double{texture.colorSpace == scene::ColorSpace::Linear ? code : shading::SrgbDecode(code)};
    }
    std::array<std::array<uint64_t, 256>, 3> counts{};
    for (size_t i = 0; i < image.rgba.size(); i += 4)
        for (size_t c = 0; c < 3; ++c) ++counts[c][image.rgba[i + c]];
    glm::dvec3 mean(0.0);
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < 256; ++i)
            mean[c] += values[i] * static_cast<double>(counts[static_cast<size_t>(c)][i]);
    return mean / std::max(1.0, static_cast<double>(image.rgba.size() / 4));
}

double AreaOf(const scene::Primitive& primitive, const glm::dmat3& toWorld) {
    double area = 0.0;
    const auto at = [&](size_t i) { return toWorld * glm::dvec3(primitive.positions[primitive.indices[i]]); };
    if (primitive.IsRound()) {
        // The areas scale by the root mean square over all directions of their normals; this also holds for a
        // sphere that is flattened to almost no volume
        const glm::dvec3 *axes = &toWorld[0], yz = glm::cross(axes[1], axes[2]),
                         zx = glm::cross(axes[2], axes[0]), xy = glm::cross(axes[0], axes[1]);
        const double scale =
            std::sqrt(std::sqrt((glm::dot(yz, yz) + glm::dot(zx, zx) + glm::dot(xy, xy)) / 3.0));
        for (size_t i = 0; i + 1 < primitive.indices.size(); i += 2) {
            const double radius = scale * double{primitive.radii[i / 2]};
            area += 2.0 * kPi * radius * (2.0 * radius + glm::length(at(i + 1) - at(i)));
        }
        return area;
    }
    for (size_t i = 0; i + 2 < primitive.indices.size(); i += 3)
        area += 0.5 * glm::length(glm::cross(at(i + 1) - at(i), at(i + 2) - at(i)));
    return area;
}

glm::dvec3 PowerOfSurfaces(const scene::SceneData& scene) {
    const std::vector<bool> visible = scene::VisibleNodes(scene);
    std::map<uint32_t, glm::dvec3> radiances;  // keyed by material
    const auto radianceOf = [&](uint32_t index) {
        const auto [found, isNew] = radiances.try_emplace(index, 0.0);
        if (!isNew) return found->second;
        const scene::Material& material = scene.materials[index];
        glm::dvec3 radiance(material.EmittedRadiance());
        if (const auto& texture = material.emissiveTexture;
            texture.IsPresent() && radiance != glm::dvec3(0.0)) {
            const scene::Texture& its = scene.textures[static_cast<size_t>(texture.texture)];
            radiance *= MeanOf(its, scene.images[its.image]);
        }
        return found->second = radiance;
    };
    glm::dvec3 power(0.0);
    for (const scene::Instance& instance : scene.instances) {
        if (!IsVisible(visible, instance)) continue;
        const glm::dmat3 toWorld{glm::mat3(instance.objectToWorld)};
        for (const scene::Primitive& primitive : scene.meshes[instance.mesh].primitives) {
            const glm::dvec3 radiance = radianceOf(primitive.material);
            if (radiance == glm::dvec3(0.0)) continue;
            const bool isOneSided = primitive.IsRound() || scene.materials[primitive.material].IsBackCulled();
            power += (isOneSided ? kPi : 2.0 * kPi) * AreaOf(primitive, toWorld) * radiance;
        }
    }
    return power;
}

double SolidAngleOf(const scene::Light& light) {
    if (light.type != scene::LightType::Spot) return 4.0 * kPi;
    // KHR_lights_punctual's falloff clamp(c scale + offset, 0, 1)^2 is a parabola in c, then a constant
    const double cosOuter = std::cos(double{light.outerConeAngle});
    const double scale = 1.0 / std::max(0.001, std::cos(double{light.innerConeAngle}) - cosOuter);
    const double end = (1.0 - cosOuter) * scale, ramp = std::min(end, 1.0);
    return 2.0 * kPi * (ramp * ramp * ramp / 3.0 + (end - ramp)) / scale;
}

glm::dvec3 PowerOfLights(const scene::SceneData& scene, double radius) {
    const std::vector<bool> visible = scene::VisibleNodes(scene);
    glm::dvec3 power(0.0);
    for (const scene::Light& light : scene.lights) {
        if (!scene::IsVisible(visible, light.node)) continue;
        double factor =
            light.type == scene::LightType::Directional ? kPi * radius * radius : SolidAngleOf(light);
        if (light.profile != scene::kNone) factor *= scene.profiles[light.profile].MeanIntensity();
        power += factor * double{light.intensity} * glm::dvec3(light.color);
    }
    return power;
}

// Returns the mean of an equirectangular map over all directions.
glm::dvec3 MeanOf(const image::ImageF& map) {
    glm::dvec3 sum(0.0);
    double weights = 0.0;
    for (size_t y = 0; y < map.height; ++y) {
        const double weight = std::sin(kPi * (static_cast<double>(y) + 0.5) / map.height);
        glm::dvec3 row(0.0);
        for (size_t x = 0; x < map.width; ++x)
            for (int c = 0; c < 3; ++c)
                row[c] += double{map.rgba[4 * (y * map.width + x) + static_cast<size_t>(c)]};
        sum += weight * row;
        weights += weight * map.width;
    }
    return sum / weights;
}

// Chooses the environment as DeviceScene does.
glm::dvec3 EnvironmentRadiance(const SceneInput& input, const PictureSettings& settings) {
    const auto vector = [](const std::array<float, 3>& rgb) { return glm::dvec3(rgb[0], rgb[1], rgb[2]); };
    if (!input.environment.rgba.empty()) return vector(settings.environmentTint) * MeanOf(input.environment);
    if (settings.background) return vector(*settings.background);
    if (ChooseLight(input, settings) == DefaultLight::Studio)
        return vector(settings.environmentTint) * MeanOf(scene::StudioMap());
    if (!input.data.environment.IsPresent()) return glm::dvec3(0.0);
    return vector(settings.environmentTint) * MeanOf(input.data.environment.map);
}

}  // namespace

std::optional<glm::dvec3> LightColor(const SceneInput& input, const PictureSettings& settings) {
    const double radius = input.data.bounds.IsEmpty() ? 1.0 : double{input.data.bounds.Radius()};
    glm::dvec3 power = PowerOfSurfaces(input.data) +
                       4.0 * kPi * kPi * radius * radius * EnvironmentRadiance(input, settings);
    if (settings.paths.lights.isOn || settings.view != View::PathTraced)
        power += PowerOfLights(input.data, radius);
    const double most = std::max(power.x, std::max(power.y, power.z));
    if (!(most > 0.0) || !std::isfinite(most)) return std::nullopt;
    return power;
}

// --- The choice of the default light ---

namespace {

DefaultLight DecideLight(const SceneInput& input, const PictureSettings& settings,
                         const ResumedRender* resumed) {
    if (resumed != nullptr) return SettingsFrom(resumed->render.settings).light;
    const bool hasMap = !input.environment.rgba.empty();
    if (settings.background || hasMap || input.data.environment.IsPresent() ||
        !passes::ShowsLight(settings.view))
        return DefaultLight::None;
    scene::Check(input.data, "Session");
    return HasOwnLight(input.data) ? DefaultLight::None : DefaultLight::Studio;
}

}  // namespace

DefaultLight ChooseLight(const SceneInput& input, const PictureSettings& settings,
                         const ResumedRender* resumed, ProcessGroup* group) {
    DefaultLight light = settings.light;
    if (light != DefaultLight::Auto) return light;
    if (group == nullptr || group->IsRoot()) light = DecideLight(input, settings, resumed);
    if (group != nullptr) group->Broadcast(std::as_writable_bytes(std::span(&light, 1)));
    return light;
}

EnvironmentSettings EnvironmentOf(const PictureSettings& settings, bool hasMap) {
    const std::array<float, 3> radiance =
        settings.background && !hasMap ? *settings.background : settings.environmentTint;
    return {.radiance = glm::vec3(radiance[0], radiance[1], radiance[2]),
            .rotation = glm::radians(settings.environmentRotation),
            .usesScene = !hasMap && !settings.background,
            .defaultLight = settings.light};
}

bool HideBehindGround(SettingTexts& given) {
    const auto ground = given.find("ground");
    if (ground == given.end() || ground->second != "on") return false;
    return given.try_emplace("transparent", "on").second;
}

}  // namespace raygraph::session
