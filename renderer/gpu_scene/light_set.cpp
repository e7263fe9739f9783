#include "renderer/gpu_scene/light_set.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.h"
#include "renderer/gpu_scene/deform_resources.h"
#include "renderer/gpu_scene/device_table.h"
#include "renderer/gpu_scene/group_kinds.h"
#include "renderer/scene/check.h"

namespace raygraph {

namespace {

// Sets the position of `light` to that of `placed`, which is in world space, relative to the origin.
void PlaceFromOrigin(scene::Light& light, const scene::Light& placed, const glm::dvec3& origin) {
    light.lightToWorld =
        scene::PlacedTransform{placed.lightToWorld, placed.translationRest}.RelativeTo(origin);
    light.translationRest = glm::vec3(0.0f);
}

// One of four in an octave: light sampling needs no more, and what only moves makes tables due when it
// crosses from one to the next, not in every frame of an animation.
float CoarseRadius(float radius) {
    return radius > 0.0f ? std::exp2(std::round(4.0f * std::log2(radius)) / 4.0f) : 0.0f;
}

}  // namespace

LightSet::LightSet(rhi::Device& device, rhi::Uploader& uploader, SceneResources& resources,
                   std::span<const InstanceSet::Placement> placements, const scene::SceneData& data)
    : m_device(device) {
    m_isEmitterInstance.resize(data.instances.size());
    m_isEmitterMaterial.resize(data.materials.size());
    for (GroupResources& group : resources.groups) {
        for (const Emitter& emitter : group.emitters) m_isEmitterMaterial[emitter.material] = true;
        for (const EmitterVariant& variant : group.emitterVariants)
            m_isEmitterMaterial[variant.material] = true;
        m_scene.groups.push_back(std::move(group.emitters));
    }
    for (uint32_t i = 0; i < placements.size(); ++i) {
        const InstanceSet::Placement& placement = placements[i];
        if (m_scene.groups[placement.group].empty()) continue;
        m_scene.placements.push_back({.record = i,
                                      .instance = placement.instance,
                                      .group = placement.group,
                                      .firstLight = placement.firstLight});
        m_isEmitterInstance[placement.instance] = true;
    }
    const std::vector<bool> isVisible = scene::VisibleNodes(data);
    for (const scene::Instance& instance : data.instances)
        m_scene.instances.push_back(
            {.objectToWorld = instance.objectToWorld, .isVisible = scene::IsVisible(isVisible, instance)});
    for (const scene::Material& material : data.materials)
        m_scene.emission.push_back(material.EmittedRadiance());
    m_scene.punctual = m_punctual = data.lights;
    for (const scene::Light& light : data.lights)
        m_scene.isPunctualHidden.push_back(!scene::IsVisible(isVisible, light.node));
    m_scene.profiles = MakeProfileTable(data.profiles);

    uint64_t lightCount = data.lights.size();
    for (const EmitterPlacement& placement : m_scene.placements)
        lightCount += m_scene.groups[placement.group].size();
    m_lights = CreateTable(device, "lights", lightCount, sizeof(gpu::LightRecord));
    m_nodes = CreateTable(device, "light nodes", 2 * lightCount, sizeof(gpu::LightNode));
    m_alias = CreateTable(device, "light alias", 3 * (lightCount + 1), sizeof(gpu::AliasEntry));
    const std::vector<float>& words = m_scene.profiles.words;
    m_profiles = CreateTable(device, "light profiles", words.size(), sizeof(float));
    if (!words.empty()) uploader.UploadBuffer(m_profiles, 0, std::as_bytes(std::span(words)));
}

void LightSet::SetTransform(uint32_t instance, const glm::mat4x3& objectToWorld) {
    glm::mat4x3& transform = m_scene.instances[instance].objectToWorld;
    if (transform == objectToWorld) return;
    transform = objectToWorld;
    m_isTableDue = true;
}

void LightSet::SetVisible(uint32_t instance, bool isVisible) {
    if (!m_isEmitterInstance[instance]) return;
    m_scene.instances[instance].isVisible = isVisible;
    m_isTableDue = true;
}

void LightSet::SetEmission(uint32_t material, const glm::vec3& radiance) {
    glm::vec3& old = m_scene.emission[material];
    if (old == radiance) return;
    old = radiance;
    m_isTableDue |= m_isEmitterMaterial[material];
}

void LightSet::SetPose(uint32_t group, const OutlinePose& pose) {
    if (m_scene.groups[group].empty()) return;
    PlaceEmitters(pose, m_scene.groups[group]);
    m_isTableDue = true;
}

void LightSet::SetSides(uint32_t material, bool isDoubleSided) {
    if (!m_isEmitterMaterial[material]) return;
    for (std::vector<Emitter>& group : m_scene.groups)
        for (Emitter& emitter : group) {
            if (emitter.material != material || emitter.isDoubleSided == isDoubleSided) continue;
            emitter.isDoubleSided = isDoubleSided;
            m_isTableDue = true;
        }
}

void LightSet::SetVariant(const SceneResources& resources) {
    for (size_t i = 0; i < resources.groups.size(); ++i) {
        const GroupResources& group = resources.groups[i];
        for (const EmitterVariant& variant : group.emitterVariants) {
            if (group.parts[variant.geometry].material != variant.material) continue;
            Emitter& emitter = m_scene.groups[i][variant.emitter];
            m_isTableDue |= emitter.material != variant.material;
            emitter.material = variant.material;
            emitter.meanTexture = variant.meanTexture;
            emitter.isDoubleSided = !IsBackCulled(resources.materialRecords[variant.material]);
        }
    }
}

void LightSet::SetPunctual(uint32_t light, const scene::Light& values, LightPlace place) {
    const std::string subject = Text("GpuScene: SetLight: light {}", light);
    scene::Check(values, subject);
    if (const size_t count = m_scene.profiles.firstWords.size();
        values.profile != scene::kNone && values.profile >= count)
        throw MakeError(ErrorKind::Usage, "{}: profile is {}, there are {}", subject, values.profile, count);
    // A file's transform may be degenerate; one that a host sets must have a direction
    if (place == LightPlace::OfHost)
        scene::CheckTransform({values.lightToWorld, values.translationRest}, subject);
    scene::Light inWorld = values, fromOrigin = values;
    PlaceFromOrigin(fromOrigin, inWorld, m_origin);
    m_punctual[light] = std::move(inWorld);
    m_scene.punctual[light] = std::move(fromOrigin);
    m_isTableDue = true;
}

void LightSet::SetPunctualVisible(uint32_t light, bool isVisible) {
    if (IsPunctualVisible(light) == isVisible) return;
    m_scene.isPunctualHidden[light] = !isVisible;
    m_isTableDue = true;
}

void LightSet::MoveOrigin(const glm::dvec3& origin, const InstanceSet& instances) noexcept {
    m_origin = origin;
    for (uint32_t i = 0; i < m_scene.instances.size(); ++i)
        m_scene.instances[i].objectToWorld = instances.DeviceTransform(i);
    for (size_t i = 0; i < m_punctual.size(); ++i)
        PlaceFromOrigin(m_scene.punctual[i], m_punctual[i], origin);
    m_arePlacesDue = true;
}

void LightSet::SetGroups(LightGroups groups) {
    m_scene.lightGroups = std::move(groups);
    m_isTableDue = true;
}

void LightSet::SetEnvironment(const glm::vec3& meanRadiance, float rotation, glm::uvec2 cells) {
    m_isTableDue |= m_scene.environmentRadiance != meanRadiance;
    m_scene.environmentRadiance = meanRadiance;
    m_scene.environmentRotation = m_table.set.environmentRotation = rotation;
    m_scene.environmentWidth = m_table.set.environmentWidth = cells.x;
    m_scene.environmentHeight = m_table.set.environmentHeight = cells.y;
}

bool LightSet::HasInfiniteLight() const {
    return m_scene.environmentRadiance != glm::vec3(0.0f) ||
           std::ranges::any_of(m_scene.punctual, [](const scene::Light& light) {
               return light.type == scene::LightType::Directional;
           });
}

void LightSet::Declare(Renderer& renderer, SceneIds& ids, InstanceSet& instances) {
    // Of what is now, so that pictures do not depend on what was shown before
    if (HasInfiniteLight()) {
        const float radius = CoarseRadius(instances.VisibleBounds().Radius());
        m_isTableDue |= radius != m_scene.radius;
        m_scene.radius = radius;
    }
    if (m_isTableDue) {
        m_table = BuildLightTable(m_scene);
        m_isUploadDue = m_isAliasUploadDue = true;
        ++m_rebuildCount;
    } else if (m_arePlacesDue) {
        PlaceLights(m_table, m_scene);
        m_isUploadDue = true;
    }
    m_isTableDue = m_arePlacesDue = false;
    ids.lightSet = m_table.set;
    ids.lightGroupCount = gpu::kLightGroupNamed + m_scene.lightGroups.namedCount;
    ids.punctualLights = static_cast<uint32_t>(m_scene.punctual.size());
    ids.triangleLights = m_table.set.lightCount - ids.punctualLights;
    ids.lights = renderer.Import("lights", m_lights, m_lightsState);
    ids.lightNodes = renderer.Import("lightNodes", m_nodes, m_nodesState);
    ids.lightAlias = renderer.Import("lightAlias", m_alias, m_aliasState);
    ids.lightProfiles = renderer.Import("lightProfiles", m_profiles, m_profilesState);
    ids.hasLightProfiles = !m_scene.profiles.words.empty();
    if (!m_isUploadDue) return;
    renderer.AddPass(
        "UploadLights", PassKind::Transfer,
        [&](PassBuilder& pass) {
            ids.lights = pass.CopiesTo(ids.lights);
            ids.lightNodes = pass.CopiesTo(ids.lightNodes);
            if (m_isAliasUploadDue) ids.lightAlias = pass.CopiesTo(ids.lightAlias);
        },
        [this](CommandList& commands) {
            RecordUpload(commands);
            commands.OnSubmitted([this] { m_isUploadDue = m_isAliasUploadDue = false; });
        });
}

void LightSet::RecordUpload(CommandList& commands) {
    const std::span<const gpu::AliasEntry> alias(m_table.alias);
    const TableCopy copies[] = {
        {std::as_bytes(std::span(std::as_const(m_table.lights))), m_lights},
        {std::as_bytes(std::span(std::as_const(m_table.nodes))), m_nodes},
        {std::as_bytes(m_isAliasUploadDue ? alias : alias.first(0)), m_alias},
    };
    RecordCopies(commands, m_device, "light staging", copies);
}

}  // namespace raygraph
