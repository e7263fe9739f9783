#include "renderer/gpu_scene/lights/light_table.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "base/check.h"
#include "renderer/gpu_scene/lights/light_mesh.h"
#include "renderer/scene/geometry/transforms.h"

namespace raygraph {

namespace {

// Within these bounds, powers in floats and their sums stay finite and normal.
constexpr double kMinPower = 1e-36, kMaxPower = 1e30;
constexpr uint32_t kNoMesh = 0xFFFFFFFFu;

double Representable(double power) {
    return power >= kMinPower ? std::min(power, kMaxPower) : 0.0;  // a NaN becomes 0
}

uint32_t GroupAt(const std::vector<uint32_t>& groups, size_t index) {
    return index < groups.size() ? groups[index] : gpu::kLightGroupRest;
}

bool IsDirectional(const scene::Light& light) {
    return light.type == scene::LightType::Directional;
}

double RadiusOf(const LightScene& scene) {
    return scene.radius > 0.0f ? double{scene.radius} : 1.0;
}

PoweredLight PunctualAt(const LightScene& scene, size_t index) {
    const bool isHidden = index < scene.isPunctualHidden.size() && scene.isPunctualHidden[index];
    PoweredLight light = PunctualLight(scene.punctual[index], isHidden, scene.profiles, RadiusOf(scene));
    light.record.flags |= GroupAt(scene.lightGroups.lights, index) << gpu::kLightGroupShift;
    return light;
}

void AppendAlias(std::vector<gpu::AliasEntry>& alias, std::span<const double> power) {
    const size_t first = alias.size();
    alias.resize(first + power.size());
    BuildAliasTable(power, std::span(alias).subspan(first));
}

// A leaf without power does not extend the boxes above it.
LightBounds DarkBounds() {
    return {.min = glm::vec3(0.0f), .max = glm::vec3(0.0f)};
}

}  // namespace

bool LightScene::Shares(size_t group, uint64_t placementCount) const {
    const size_t emitters = groups[group].size();
    return emitters >= kMinSharedEmitters && placementCount > 1 &&
           placementCount * emitters > maxExpandedLights && (isDeformed.empty() || !isDeformed[group]);
}

uint32_t LightScene::NumberEmitters(bool stay) {
    std::vector<uint64_t> counts(groups.size());
    for (const EmitterPlacement& placement : placements)
        if (!placement.isRemoved) ++counts[placement.group];
    isShared.resize(groups.size());
    for (size_t i = 0; i < groups.size(); ++i)
        isShared[i] = Shares(i, counts[i]) || (stay && isShared[i] && counts[i] > 1);
    uint32_t count = 0;
    for (EmitterPlacement& placement : placements) {
        if (!placement.isRemoved)
            placement.lightCount =
                isShared[placement.group] ? 1 : static_cast<uint32_t>(groups[placement.group].size());
        placement.firstLight = count;
        count += placement.lightCount;
    }
    return count;
}

gpu::LightRecord LightTable::LightAt(size_t index) const {
    return index < m_lights.size() ? m_lights[index] : m_meshLights[index - m_lights.size()];
}

gpu::LightNode LightTable::NodeAt(size_t index) const {
    const std::vector<gpu::LightNode>& nodes = m_tree.Nodes();
    if (index >= FirstMeshNode()) return m_meshNodes[index - FirstMeshNode()];
    return index < nodes.size() ? nodes[index] : gpu::LightNode{};
}

gpu::AliasEntry LightTable::AliasAt(size_t index) const {
    if (index >= FirstMeshAlias()) return m_meshAlias[index - FirstMeshAlias()];
    return index < m_alias.size() ? m_alias[index] : gpu::AliasEntry{};
}

// Numbers the lights of placements, then the bounded punctual ones, then the directional ones.
void LightTable::Number(const LightScene& scene) {
    uint32_t count = 0;
    for (const EmitterPlacement& placement : scene.placements) {
        RG_CHECK_EQ(placement.firstLight, count);
        count += placement.lightCount;
    }
    m_set.firstPunctual = count;
    m_punctualNumbers.resize(scene.punctual.size());
    for (const bool isDirectional : {false, true}) {
        for (size_t i = 0; i < scene.punctual.size(); ++i)
            if (isDirectional == IsDirectional(scene.punctual[i])) m_punctualNumbers[i] = count++;
        if (!isDirectional) m_set.boundedCount = count;
    }
    m_set.lightCount = count;
    m_lights.assign(count, {});
    m_power.assign(size_t{count} + 1, 0.0);
    m_shiningCounts.assign(scene.placements.size(), 0);
    m_emissiveTriangleCount = 0;
}

void LightTable::BuildMeshes(const LightScene& scene) {
    m_meshes.clear();
    m_meshRecords.clear();
    m_meshLights.clear();
    m_meshNodes.clear();
    m_meshAlias.clear();
    m_meshOf.assign(scene.groups.size(), kNoMesh);
    m_meshBounds.clear();
    for (size_t i = 0; i < scene.groups.size(); ++i) {
        if (!scene.isShared[i]) continue;
        m_meshOf[i] = static_cast<uint32_t>(m_meshes.size());
        m_meshes.emplace_back(scene.groups[i], scene.emission, scene.lightGroups.materials);
        const LightMesh& mesh = m_meshes.back();
        const auto firstNode = static_cast<uint32_t>(FirstMeshNode() + m_meshNodes.size());
        m_meshRecords.push_back({.firstLight = static_cast<uint32_t>(m_lights.size() + m_meshLights.size()),
                                 .triangleCount = static_cast<uint32_t>(mesh.Lights().size()),
                                 .activeCount = mesh.ActiveCount(),
                                 .firstNode = firstNode,
                                 .firstAlias = static_cast<uint32_t>(FirstMeshAlias() + m_meshAlias.size())});
        m_meshLights.insert(m_meshLights.end(), mesh.Lights().begin(), mesh.Lights().end());
        for (gpu::LightNode node : mesh.Nodes()) {
            if ((node.link & gpu::kLightNodeLeaf) == 0u) node.link += firstNode;
            m_meshNodes.push_back(node);
        }
        m_meshAlias.insert(m_meshAlias.end(), mesh.Alias().begin(), mesh.Alias().end());
    }
    if (!m_meshes.empty()) m_meshBounds.resize(scene.placements.size());
}

void LightTable::SetLight(uint32_t number, gpu::LightRecord record, double power, const LightBounds* bounds,
                          bool isRefit, LightTableChanges& changes) {
    gpu::LightRecord& light = m_lights[number];
    record.bitTrail = light.bitTrail;
    if (std::memcmp(&light, &record, sizeof(record)) != 0) {
        light = record;
        changes.lights.push_back(number);
    }
    double& oldPower = m_power[number];
    power = Representable(power);
    const bool isAlike = power > 0.0 && std::abs(power - oldPower) <= kPowerTolerance * oldPower;
    if (isRefit && isAlike) power = oldPower;
    changes.isAlias |= power != oldPower;
    oldPower = power;
    if (!isRefit || number >= m_set.boundedCount) return;
    if (!m_tree.Has(number)) {
        changes.isRebuilt |= power > 0.0;
        return;
    }
    LightBounds placed = power == 0.0 ? DarkBounds() : bounds ? *bounds : BoundsOf(record, 0.0f);
    placed.power = static_cast<float>(power);
    m_tree.Set(number, placed);
}

void LightTable::SetPlacement(const LightScene& scene, uint32_t index, bool isRefit,
                              LightTableChanges& changes) {
    const EmitterPlacement& placement = scene.placements[index];
    m_emissiveTriangleCount -= m_shiningCounts[index];
    m_shiningCounts[index] = 0;
    if (placement.isRemoved) {
        for (uint32_t i = 0; i < placement.lightCount; ++i)
            SetLight(placement.firstLight + i, {}, 0.0, nullptr, isRefit, changes);
        return;
    }
    const LightScene::Instance& instance = scene.instances[placement.instance];
    const uint32_t instanceGroup = GroupAt(scene.lightGroups.instances, placement.instance);
    uint32_t shining = 0;
    if (const uint32_t mesh = m_meshOf[placement.group]; mesh != kNoMesh) {
        LightBounds& bounds = m_meshBounds[index] = m_meshes[mesh].Placed(instance.objectToWorld);
        const bool isMirrored = scene::IsMirrored(instance.objectToWorld);
        const gpu::LightRecord record{
            .kind = gpu::kLightMesh,
            .flags = (isMirrored ? gpu::kLightMirrored : 0u) |
                     (m_meshes[mesh].IsOutward(instance.objectToWorld) ? gpu::kLightOutward : 0u) |
                     (instanceGroup << gpu::kLightGroupShift),
            .instance = placement.record,
            .primitive = mesh};
        SetLight(placement.firstLight, record, instance.isVisible ? bounds.power : 0.0, &bounds, isRefit,
                 changes);
        if (m_power[placement.firstLight] > 0.0) shining = m_meshes[mesh].ActiveCount();
    } else {
        uint32_t number = placement.firstLight;
        for (const Emitter& emitter : scene.groups[placement.group]) {
            gpu::LightRecord record = TriangleLight(emitter, placement.record, instance.objectToWorld);
            const double power =
                TrianglePower(record, scene.emission[emitter.material] * emitter.meanTexture);
            record.flags |=
                FirstLightGroup(instanceGroup, GroupAt(scene.lightGroups.materials, emitter.material))
                << gpu::kLightGroupShift;
            SetLight(number, record, instance.isVisible ? power : 0.0, nullptr, isRefit, changes);
            shining += m_power[number++] > 0.0 ? 1 : 0;
        }
    }
    m_shiningCounts[index] = shining;
    m_emissiveTriangleCount += shining;
}

void LightTable::SetPunctual(const LightScene& scene, uint32_t index, bool isRefit,
                             LightTableChanges& changes) {
    const PoweredLight light = PunctualAt(scene, index);
    SetLight(m_punctualNumbers[index], light.record, light.power, nullptr, isRefit, changes);
}

void LightTable::SetInfinitePowers(const LightScene& scene) {
    for (uint32_t i = 0; i < scene.punctual.size(); ++i)
        if (IsDirectional(scene.punctual[i]))
            m_power[m_punctualNumbers[i]] = Representable(PunctualAt(scene, i).power);
    const double radius = RadiusOf(scene);
    m_power.back() = Representable(4.0 * std::numbers::pi * std::numbers::pi * radius * radius *
                                   Luminance(scene.environmentRadiance));
}

void LightTable::BuildTree(const LightScene& scene, LightTableChanges& changes) {
    std::vector<LightLeaf> leaves;
    const auto add = [&](uint32_t number, const LightBounds* bounds) {
        m_lights[number].bitTrail = 0;
        const auto power = static_cast<float>(m_power[number]);
        if (!(power > 0.0f)) return;
        leaves.push_back({.bounds = bounds ? *bounds : BoundsOf(m_lights[number], power), .light = number});
        leaves.back().bounds.power = power;
    };
    for (size_t i = 0; i < scene.placements.size(); ++i) {
        const EmitterPlacement& placement = scene.placements[i];
        const bool isMesh = !placement.isRemoved && m_meshOf[placement.group] != kNoMesh;
        for (uint32_t k = 0; k < placement.lightCount; ++k)
            add(placement.firstLight + k, isMesh ? &m_meshBounds[i] : nullptr);
    }
    for (const uint32_t number : m_punctualNumbers)
        if (number < m_set.boundedCount) add(number, nullptr);
    m_tree.Build(std::move(leaves), m_lights);
    m_quality.OnBuild(m_tree.RelativeCost(), m_tree.Nodes().size() / 2);
    changes.isRebuilt = changes.allRecordsChanged = true;
    UpdateNodeCount();
}

// A tree without power has no nodes: otherwise its last node would be chosen.
void LightTable::UpdateNodeCount() {
    const std::vector<gpu::LightNode>& nodes = m_tree.Nodes();
    const bool isLit = !nodes.empty() && nodes[0].power > 0.0f;
    m_set.nodeCount = isLit ? static_cast<uint32_t>(nodes.size()) : 0u;
}

void LightTable::BuildAlias() {
    const uint32_t boundedCount = m_set.boundedCount;
    m_alias.clear();
    AppendAlias(m_alias, m_power);
    AppendAlias(m_alias, std::span(m_power).subspan(boundedCount));
    m_set.activeCount = 0;
    double bounded = 0.0, unbounded = 0.0;
    for (uint32_t i = 0; i < m_power.size(); ++i) {
        if (m_power[i] == 0.0) continue;
        m_alias.push_back({.keep = 1.0f, .alias = i, .probability = 0.0f});
        ++m_set.activeCount;
        (i < boundedCount ? bounded : unbounded) += m_power[i];
    }
    double share = unbounded > 0.0 ? unbounded / (bounded + unbounded) : 0.0;
    if (bounded > 0.0 && unbounded > 0.0) share = std::clamp(share, kMinLightShare, 1.0 - kMinLightShare);
    m_set.unboundedProbability = static_cast<float>(share);
    m_set.hasEnvironment = m_power.back() > 0.0 ? 1u : 0u;
}

void LightTable::Place(const LightScene& scene, LightTableChanges& changes) {
    const auto setLeaf = [&](uint32_t number, LightBounds bounds) {
        if (!m_tree.Has(number) || m_power[number] == 0.0) return;
        bounds.power = static_cast<float>(m_power[number]);
        m_tree.Set(number, bounds);
    };
    for (size_t i = 0; i < scene.placements.size(); ++i) {
        const EmitterPlacement& placement = scene.placements[i];
        if (placement.isRemoved) continue;
        const glm::mat4x3& objectToWorld = scene.instances[placement.instance].objectToWorld;
        if (const uint32_t mesh = m_meshOf[placement.group]; mesh != kNoMesh) {
            m_meshes[mesh].PlaceBox(objectToWorld, m_meshBounds[i]);
            setLeaf(placement.firstLight, m_meshBounds[i]);
            continue;
        }
        uint32_t number = placement.firstLight;
        for (const Emitter& emitter : scene.groups[placement.group]) {
            const gpu::LightRecord moved = TriangleLight(emitter, placement.record, objectToWorld);
            m_lights[number].p0 = moved.p0;
            m_lights[number].spotOffsetOrClearance = moved.spotOffsetOrClearance;
            setLeaf(number, BoundsOf(m_lights[number], 0.0f));
            ++number;
        }
    }
    for (size_t i = 0; i < scene.punctual.size(); ++i) {
        const uint32_t number = m_punctualNumbers[i];
        m_lights[number].p0 = scene.punctual[i].lightToWorld[3];
        if (number < m_set.boundedCount) setLeaf(number, BoundsOf(m_lights[number], 0.0f));
    }
    changes.allRecordsChanged = true;
}

LightTableChanges LightTable::Update(const LightScene& scene, const LightEdits& edits, bool mayRefit) {
    LightTableChanges changes{.isAll = edits.isAll};
    const bool isRefit = mayRefit && !edits.isAll;
    if (edits.isAll) {
        Number(scene);
        BuildMeshes(scene);
        for (uint32_t i = 0; i < scene.placements.size(); ++i) SetPlacement(scene, i, isRefit, changes);
        for (uint32_t i = 0; i < scene.punctual.size(); ++i) SetPunctual(scene, i, isRefit, changes);
    } else {
        if (edits.transformsDirty) Place(scene, changes);
        for (const uint32_t i : edits.placements) SetPlacement(scene, i, isRefit, changes);
        for (const uint32_t i : edits.punctual) SetPunctual(scene, i, isRefit, changes);
    }
    if (edits.isAll || edits.powersDirty) {
        SetInfinitePowers(scene);
        changes.isAlias = true;
    }
    const bool isTreeDirty = !edits.placements.empty() || !edits.punctual.empty() || edits.transformsDirty;
    if (edits.isAll || changes.isRebuilt || (isTreeDirty && !isRefit)) {
        BuildTree(scene, changes);
    } else {
        m_tree.Refit(changes.nodes);
        UpdateNodeCount();
    }
    if (changes.isAlias) BuildAlias();
    return changes;
}

gpu::LightSetRecord LightTable::SetIn(const LightScene& scene) const {
    gpu::LightSetRecord set = m_set;
    set.environmentRotation = scene.environmentRotation;
    set.environmentWidth = scene.environmentWidth;
    set.environmentHeight = scene.environmentHeight;
    set.skyIrradiance = scene.skyIrradiance;
    return set;
}

LightTable BuildLightTable(const LightScene& scene) {
    LightTable table;
    table.Update(scene, {}, false);
    return table;
}

// --- Punctual lights ---

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

// --- Alias tables ---

namespace {

// Returns a float that is 0 only for 0, because a probability of 0 tells that the outcome never occurs.
float Probability(double p) {
    return p > 0.0 ? std::max(static_cast<float>(p), std::numeric_limits<float>::min()) : 0.0f;
}

}  // namespace

double BuildAliasTable(std::span<const double> weights, std::span<gpu::AliasEntry> slots) {
    RG_CHECK_EQ(weights.size(), slots.size());
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    const auto count = static_cast<uint32_t>(weights.size());
    if (!(sum > 0.0)) {
        for (uint32_t i = 0; i < count; ++i) slots[i] = {.keep = 1.0f, .alias = i, .probability = 0.0f};
        return 0.0;
    }
    // The weight that each slot still has to distribute, in units of a slot
    std::vector<double> shares(count);
    std::vector<uint32_t> poor, rich;
    uint32_t heaviest = 0;
    for (uint32_t i = 0; i < count; ++i) {
        shares[i] = weights[i] / sum * count;
        slots[i] = {.keep = 1.0f, .alias = i, .probability = Probability(weights[i] / sum)};
        (shares[i] < 1.0 ? poor : rich).push_back(i);
        if (weights[i] > weights[heaviest]) heaviest = i;
    }
    while (!poor.empty() && !rich.empty()) {
        const uint32_t small = poor.back();
        const uint32_t large = rich.back();
        poor.pop_back();
        slots[small].keep = static_cast<float>(shares[small]);
        slots[small].alias = large;
        shares[large] -= 1.0 - shares[small];
        if (shares[large] < 1.0) {
            rich.pop_back();
            poor.push_back(large);
        }
    }
    // Rounding may leave slots that should be full, and an outcome without weight must not become one
    for (const uint32_t i : poor)
        if (weights[i] == 0.0) slots[i] = {.keep = 0.0f, .alias = heaviest, .probability = 0.0f};
    return sum;
}

}  // namespace raygraph
