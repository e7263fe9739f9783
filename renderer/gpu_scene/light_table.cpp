#include "renderer/gpu_scene/light_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/gtc/quaternion.hpp>
#include "base/check.h"
#include "renderer/gpu_scene/alias_table.h"
#include "renderer/gpu_scene/light_bvh.h"
#include "shaders/shared/ray_clearance.h"

namespace raygraph {

namespace {

constexpr double kPi = std::numbers::pi;
// Powers in floats, and sums of them, stay finite and normal within these.
constexpr double kMinPower = 1e-36, kMaxPower = 1e30;
// Likewise squares of twice a triangle's area.
constexpr float kMinAreaSquare = 1e-36f, kMaxAreaSquare = 1e36f;

double Luminance(const glm::vec3& color) {
    return 0.2126 * double{color.x} + 0.7152 * double{color.y} + 0.0722 * double{color.z};
}

double Representable(double power) {
    return power >= kMinPower ? std::min(power, kMaxPower) : 0.0;  // a NaN becomes 0
}

// Of the rays that end anywhere on a triangle, whose record has the world's p0, e1 and e2. RayClearance is
// convex in the point; the record adds roundings of its own.
float TriangleClearance(const Emitter& emitter, const glm::mat4x3& objectToWorld, const glm::vec3& p0,
                        const glm::vec3& e1, const glm::vec3& e2) {
    float clearance = 0.0f;
    for (const glm::vec3& vertex : {emitter.p0, emitter.p1, emitter.p2})
        clearance =
            std::max(clearance, gpu::RayClearance(glm::mat3(objectToWorld), objectToWorld[3], emitter.p0,
                                                  emitter.p1 - emitter.p0, emitter.p2 - emitter.p0, vertex));
    if (emitter.error > 0.0f)
        for (int axis = 0; axis < 3; ++axis) clearance += emitter.error * glm::length(objectToWorld[axis]);
    const glm::vec3 across = glm::cross(e1, e2);
    const float length = glm::length(across);
    const glm::vec3 sizes = glm::abs(p0) + glm::abs(e1) + glm::abs(e2);
    return clearance +
           4.0f * gpu::kRoundoff * (length > 0.0f ? glm::dot(glm::abs(across), sizes) / length : 0.0f);
}

gpu::LightRecord TriangleLight(const Emitter& emitter, const EmitterPlacement& placement,
                               const glm::mat4x3& objectToWorld) {
    const glm::dmat3 linear{glm::dvec3(objectToWorld[0]), glm::dvec3(objectToWorld[1]),
                            glm::dvec3(objectToWorld[2])};
    const glm::vec3 p0 = linear * glm::dvec3(emitter.p0) + glm::dvec3(objectToWorld[3]);
    const glm::vec3 e1 = linear * (glm::dvec3(emitter.p1) - glm::dvec3(emitter.p0));
    const glm::vec3 e2 = linear * (glm::dvec3(emitter.p2) - glm::dvec3(emitter.p0));
    const bool isMirrored = glm::determinant(glm::mat3(objectToWorld)) < 0.0f;
    return {.p0 = p0,
            .kind = gpu::kLightTriangle,
            .e1 = e1,
            .flags = (emitter.isDoubleSided ? gpu::kLightDoubleSided : 0u) |
                     (isMirrored ? gpu::kLightMirrored : 0u),
            .e2 = e2,
            .instance = placement.record,
            .primitive = emitter.primitive,
            .bitTrail = 0,
            .spotScale = 0.0f,
            .spotOffsetOrClearance = TriangleClearance(emitter, objectToWorld, p0, e1, e2)};
}

uint32_t GroupAt(const std::vector<uint32_t>& groups, size_t index) {
    return groups.empty() ? gpu::kLightGroupRest : groups[index];
}

double TrianglePower(const gpu::LightRecord& light, const glm::vec3& meanRadiance) {
    const glm::vec3 normal = glm::cross(light.e1, light.e2);
    const float square = glm::dot(normal, normal);
    if (!(square >= kMinAreaSquare && square <= kMaxAreaSquare)) return 0.0;
    const double sides = (light.flags & gpu::kLightDoubleSided) != 0 ? 2.0 : 1.0;
    return sides * kPi * 0.5 * std::sqrt(double{square}) * Luminance(meanRadiance);
}

// Along the node's -z, whatever its scale; a node scaled to nothing has no direction of its own.
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

// Falloff by KHR_lights_punctual, inner and outer cone angle.
gpu::LightRecord PunctualLight(const scene::Light& light) {
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

// Turns a point light's record into that of one with a profile.
void PutProfile(gpu::LightRecord& record, const scene::Light& light, const ProfileTable& profiles) {
    // From the node's axes, z first, without scale and shear; what is flat has axes of its own
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
    if (glm::determinant(glm::mat3(light.lightToWorld)) < 0.0f) record.flags |= gpu::kLightMirrored;
    record.e1 = glm::dvec3(toProfile.x, toProfile.y, toProfile.z);
    record.spotScale = static_cast<float>(toProfile.w);
    record.primitive = profiles.firstWords[light.profile];
}

double PunctualPower(const gpu::LightRecord& light, double sceneRadius) {
    const double intensity = Luminance(light.e2);
    if (light.kind == gpu::kLightDirectional) return kPi * sceneRadius * sceneRadius * intensity;
    if (light.kind == gpu::kLightPoint) return 4.0 * kPi * intensity;
    // The integral of clamp(c scale + offset, 0, 1)^2 over c up to 1: a parabola, then a constant
    const double end =
        double{light.spotScale} + double{light.spotOffsetOrClearance};  // before the clamp, at c = 1
    const double ramp = std::min(end, 1.0);
    const double integral = (ramp * ramp * ramp / 3.0 + (end - ramp)) / double{light.spotScale};
    return 2.0 * kPi * intensity * integral;
}

void AppendAlias(std::vector<gpu::AliasEntry>& alias, std::span<const double> power) {
    const size_t first = alias.size();
    alias.resize(first + power.size());
    BuildAliasTable(power, std::span(alias).subspan(first));
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

uint32_t LightScene::NumberEmitters() {
    uint32_t count = 0;
    for (EmitterPlacement& placement : placements) {
        placement.firstLight = count;
        count += static_cast<uint32_t>(groups[placement.group].size());
    }
    return count;
}

LightTable BuildLightTable(const LightScene& scene) {
    LightTable table;
    std::vector<double> power;
    const auto add = [&](const gpu::LightRecord& light, uint32_t group, double lightPower) {
        table.lights.push_back(light);
        table.lights.back().flags |= group << gpu::kLightGroupShift;
        power.push_back(Representable(lightPower));
    };
    for (const EmitterPlacement& placement : scene.placements) {
        RG_CHECK_EQ(placement.firstLight, table.lights.size());
        const LightScene::Instance& instance = scene.instances[placement.instance];
        for (const Emitter& emitter : scene.groups[placement.group]) {
            const gpu::LightRecord light = TriangleLight(emitter, placement, instance.objectToWorld);
            const glm::vec3 radiance = scene.emission[emitter.material] * emitter.meanTexture;
            const uint32_t group = FirstLightGroup(GroupAt(scene.lightGroups.instances, placement.instance),
                                                   GroupAt(scene.lightGroups.materials, emitter.material));
            add(light, group, instance.isVisible ? TrianglePower(light, radiance) : 0.0);
        }
    }
    table.emissiveTriangleCount =
        static_cast<uint32_t>(std::count_if(power.begin(), power.end(), [](double p) { return p > 0.0; }));
    const double radius = scene.radius > 0.0f ? double{scene.radius} : 1.0;
    for (const bool isDirectional : {false, true}) {
        for (size_t i = 0; i < scene.punctual.size(); ++i) {
            const scene::Light& light = scene.punctual[i];
            if (isDirectional != (light.type == scene::LightType::Directional)) continue;
            gpu::LightRecord record = PunctualLight(light);
            if (i < scene.isPunctualHidden.size() && scene.isPunctualHidden[i]) record.e2 = glm::vec3(0.0f);
            double lightPower = PunctualPower(record, radius);
            if (light.profile != scene::kNone) {
                PutProfile(record, light, scene.profiles);
                lightPower *= scene.profiles.means[light.profile];
            }
            add(record, GroupAt(scene.lightGroups.lights, i), lightPower);
        }
        if (!isDirectional) table.set.boundedCount = static_cast<uint32_t>(table.lights.size());
    }
    const double environmentPower =
        Representable(4.0 * kPi * kPi * radius * radius * Luminance(scene.environmentRadiance));
    power.push_back(environmentPower);

    const uint32_t boundedCount = table.set.boundedCount;
    const std::vector<float> boundedPower(power.begin(), power.begin() + boundedCount);
    table.nodes = BuildLightTree(std::span(table.lights).first(boundedCount), boundedPower);
    AppendAlias(table.alias, power);
    AppendAlias(table.alias, std::span(power).subspan(boundedCount));
    double bounded = 0.0, unbounded = 0.0;
    for (uint32_t i = 0; i < power.size(); ++i) {
        if (power[i] == 0.0) continue;
        table.alias.push_back({.keep = 1.0f, .alias = i, .probability = 0.0f});
        ++table.set.activeCount;
        (i < boundedCount ? bounded : unbounded) += power[i];
    }
    double share = unbounded > 0.0 ? unbounded / (bounded + unbounded) : 0.0;
    if (bounded > 0.0 && unbounded > 0.0) share = std::clamp(share, kMinLightShare, 1.0 - kMinLightShare);

    table.set.lightCount = static_cast<uint32_t>(table.lights.size());
    table.set.nodeCount = static_cast<uint32_t>(table.nodes.size());
    table.set.unboundedShare = static_cast<float>(share);
    table.set.environmentRotation = scene.environmentRotation;
    table.set.hasEnvironment = environmentPower > 0.0 ? 1u : 0u;
    table.set.environmentWidth = scene.environmentWidth;
    table.set.environmentHeight = scene.environmentHeight;
    return table;
}

void PlaceLights(LightTable& table, const LightScene& scene) {
    auto light = table.lights.begin();
    for (const EmitterPlacement& placement : scene.placements)
        for (const Emitter& emitter : scene.groups[placement.group]) {
            const gpu::LightRecord moved =
                TriangleLight(emitter, placement, scene.instances[placement.instance].objectToWorld);
            light->p0 = moved.p0;
            light->spotOffsetOrClearance = moved.spotOffsetOrClearance;
            ++light;
        }
    for (const bool isDirectional : {false, true})
        for (const scene::Light& punctual : scene.punctual)
            if (isDirectional == (punctual.type == scene::LightType::Directional))
                (light++)->p0 = punctual.lightToWorld[3];
    RefitLightTree(table.nodes, table.lights);
}

}  // namespace raygraph
