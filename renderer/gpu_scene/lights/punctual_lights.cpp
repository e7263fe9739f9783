#include "renderer/gpu_scene/lights/punctual_lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/gtc/quaternion.hpp>
#include "renderer/gpu_scene/lights/triangle_lights.h"
#include "renderer/scene/geometry/linear_map.h"

namespace raygraph {

namespace {

// Returns the direction of the node's -z, whatever its scale; a node scaled to zero has no direction of its
// own.
glm::vec3 DirectionOf(const scene::Light& light) {
    const glm::dvec3 direction(-light.lightToWorld[2]);
    const double length = glm::length(direction);
    return length > 0.0 ? glm::vec3(direction / length) : glm::vec3(0.0f, 0.0f, -1.0f);
}

uint32_t KindOf(scene::LightType type) {
    switch (type) {
        case scene::LightType::Directional:
            return gpu::kLightDirectional;
        case scene::LightType::Point:
            return gpu::kLightPoint;
        case scene::LightType::Spot:
            return gpu::kLightSpot;
    }
    return gpu::kLightPoint;
}

// Computes the falloff of KHR_lights_punctual from the inner and outer cone angles.
gpu::LightRecord RecordOf(const scene::Light& light) {
    const float cosOuter = std::cos(light.outerConeAngle);
    const float scale = 1.0f / std::max(0.001f, std::cos(light.innerConeAngle) - cosOuter);
    const bool isSpot = light.type == scene::LightType::Spot;
    return {.p0 = light.lightToWorld[3],
            .kind = KindOf(light.type),
            .e1 = DirectionOf(light),
            .flags = 0,
            .e2 = light.color * light.intensity,
            .instance = 0,
            .primitive = 0,
            .bitTrail = 0,
            .spotScale = isSpot ? scale : 0.0f,
            .spotOffsetOrClearance = isSpot ? -cosOuter * scale : 0.0f};
}

// Turns a point light's record into that of a light with a profile.
void PutProfile(gpu::LightRecord& record, const scene::Light& light, const ProfileTable& profiles) {
    // The axes are those of the node, z first, without scale and shear; a degenerate transform gets
    // substitutes
    glm::dvec3 z(light.lightToWorld[2]), x(light.lightToWorld[0]);
    z = glm::length(z) > 0.0 ? glm::normalize(z) : glm::dvec3(0.0, 0.0, 1.0);
    if (glm::length(x) > 0.0) x = glm::normalize(x);
    x -= glm::dot(x, z) * z;
    if (!(glm::length(x) > 1e-9))
        x = glm::cross(glm::abs(z.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0), z);
    x = glm::normalize(x);
    const glm::dmat3 axes(x, glm::cross(z, x), z);
    const glm::dquat toProfile = glm::normalize(glm::conjugate(glm::quat_cast(axes)));
    record.flags |= gpu::kLightProfile;
    if (scene::IsMirrored(light.lightToWorld)) record.flags |= gpu::kLightMirrored;
    record.e1 = glm::dvec3(toProfile.x, toProfile.y, toProfile.z);
    record.spotScale = static_cast<float>(toProfile.w);
    record.primitive = profiles.firstWords[light.profile];
}

double PunctualPower(const gpu::LightRecord& light, double sceneRadius) {
    const double intensity = Luminance(light.e2);
    if (light.kind == gpu::kLightDirectional) return std::numbers::pi * sceneRadius * sceneRadius * intensity;
    if (light.kind == gpu::kLightPoint) return 4.0 * std::numbers::pi * intensity;
    // The integral of clamp(c scale + offset, 0, 1)^2 over c up to 1: a parabola, then a constant
    const double end =
        double{light.spotScale} + double{light.spotOffsetOrClearance};  // before the clamp, at c = 1
    const double ramp = std::min(end, 1.0);
    const double integral = (ramp * ramp * ramp / 3.0 + (end - ramp)) / double{light.spotScale};
    return 2.0 * std::numbers::pi * intensity * integral;
}

}  // namespace

ProfileTable MakeProfileTable(std::span<const scene::LightProfile> profiles) {
    ProfileTable table;
    std::vector<float>& words = table.words;
    const auto append = [&](const std::vector<float>& values) {
        words.insert(words.end(), values.begin(), values.end());
    };
    for (const scene::LightProfile& profile : profiles) {
        table.firstWords.push_back(static_cast<uint32_t>(words.size()));
        table.means.push_back(profile.MeanIntensity());
        words.push_back(static_cast<float>(profile.type));
        words.push_back(static_cast<float>(profile.vertical.size()));
        words.push_back(static_cast<float>(profile.horizontal.size()));
        append(profile.vertical);
        append(profile.horizontal);
        append(profile.candela);
    }
    return table;
}

PoweredLight PunctualLight(const scene::Light& light, bool isHidden, const ProfileTable& profiles,
                           double sceneRadius) {
    PoweredLight result{.record = RecordOf(light)};
    if (isHidden) result.record.e2 = glm::vec3(0.0f);
    result.power = PunctualPower(result.record, sceneRadius);
    if (light.profile != scene::kNone) {
        PutProfile(result.record, light, profiles);
        result.power *= profiles.means[light.profile];
    }
    return result;
}

}  // namespace raygraph
