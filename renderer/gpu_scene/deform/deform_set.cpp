#include "renderer/gpu_scene/deform/deform_set.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/check.h"
#include "base/text.h"
#include "renderer/gpu_scene/device_array.h"
#include "renderer/gpu_scene/instances/group_kinds.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "renderer/gpu_scene/scene_context.h"
#include "renderer/scene/model/check.h"

namespace raygraph {
namespace {

// Holds the push constants of shaders/scene/deform.comp.
struct DeformConstants {
    uint32_t taskCount;
    uint32_t groupCount;
};

uint32_t GroupsOf(const gpu::DeformRecord& record) {
    return (record.vertexCount + gpu::kDeformGroupSize - 1) / gpu::kDeformGroupSize;
}

}  // namespace

DeformSet::DeformSet(rhi::Device& device, SceneGeometry& geometry, InstanceSet& instances)
    : m_device(device), m_geometry(geometry), m_deform(*geometry.deform), m_instances(instances) {
    m_tasks.reserve(m_deform.records.size());  // frames must not allocate memory for it
}

bool DeformSet::SetJointMatrices(uint32_t skin, std::span<const glm::mat4x3> matrices) {
    for (const glm::mat4x3& matrix : matrices)
        if (!scene::IsFinite(matrix))
            throw MakeError(ErrorKind::Usage,
                            "GpuScene: SetJointMatrices: skin {} has numbers that are not "
                            "finite",
                            skin);
    return FollowJoints(skin, matrices);
}

bool DeformSet::FollowJoints(uint32_t skin, std::span<const glm::mat4x3> matrices) {
    SkinMatrices& range = m_deform.skins[skin];
    RG_CHECK_EQ(matrices.size(), range.count);
    bool isChanged = false;
    for (size_t i = 0; i < matrices.size(); ++i) {
        glm::mat4x3& old = m_deform.matrices[range.first + i];
        // The identity, not the joint's last matrix: the picture must not depend on what was shown before
        const glm::mat4x3 matrix = scene::IsFinite(matrices[i]) ? matrices[i] : glm::mat4x3(1.0f);
        if (matrix == old) continue;
        old = matrix;
        isChanged = true;
    }
    if (!isChanged) return false;
    range.isDirty = true;
    bool isSeen = false;
    for (DeformedMesh& mesh : m_deform.meshes) {
        if (mesh.skin != skin) continue;
        mesh.poseDirty = true;
        isSeen |= IsVisible(mesh);
    }
    return isSeen;
}

bool DeformSet::IsDeformed(uint32_t instance) const {
    // Instances that were added later are never deformed
    return instance < m_deform.meshOf.size() && m_deform.meshOf[instance] != scene::kNone;
}

uint32_t DeformSet::WeightCount(uint32_t instance) const {
    return IsDeformed(instance) ? m_deform.meshes[m_deform.meshOf[instance]].weightCount : 0;
}

bool DeformSet::SetMorphWeights(uint32_t instance, std::span<const float> weights) {
    RG_CHECK_EQ(weights.size(), WeightCount(instance));
    if (weights.empty()) return false;
    if (!std::ranges::all_of(weights, [](float weight) { return std::isfinite(weight); }))
        throw MakeError(ErrorKind::Usage,
                        "GpuScene: SetMorphWeights: instance {} has numbers that are not finite", instance);
    DeformedMesh& mesh = m_deform.meshes[m_deform.meshOf[instance]];
    const auto old = m_deform.weights.begin() + mesh.firstWeight;
    if (std::equal(weights.begin(), weights.end(), old)) return false;
    std::ranges::copy(weights, old);
    mesh.weightsDirty = mesh.poseDirty = true;
    return IsVisible(mesh);
}

bool DeformSet::IsVisible(const DeformedMesh& mesh) const {
    return std::ranges::any_of(mesh.instances, [&](uint32_t i) { return m_instances.IsVisible(i); });
}

bool DeformSet::IsPoseDirty(const DeformedMesh& mesh) const {
    return mesh.poseDirty && (IsVisible(mesh) || mesh.deformPending);
}

bool DeformSet::HasWork() const {
    return std::ranges::any_of(m_deform.meshes, [&](const DeformedMesh& mesh) {
        return IsPoseDirty(mesh) || mesh.deformPending ||
               std::ranges::any_of(mesh.groups, &DeformedGroup::refitPending);
    });
}

void DeformSet::Follow(DeformedMesh& mesh, LightSet& lights, DrawTable& draws) {
    m_deform.Follow(mesh, m_geometry);
    m_instances.MarkDeformed(mesh.mesh, mesh.instances);
    for (DeformedGroup& deformed : mesh.groups) {
        const GroupResources& group = m_geometry.groups[deformed.group];
        lights.SetPose(deformed.group, deformed.pose);
        draws.SetBounds(group);
    }
    mesh.poseDirty = false;  // This is last: if memory runs out before, the next frame repeats all of it
}

void DeformSet::DeclareDeformation(Renderer& renderer, SceneIds& ids, LightSet& lights, DrawTable& draws) {
    for (DeformedMesh& mesh : m_deform.meshes)
        if (IsPoseDirty(mesh)) Follow(mesh, lights, draws);
    ids.deformedStreams = renderer.Import("deformedStreams", m_deform.streams, m_streamsState);
    m_tasks.clear();
    m_groupCount = 0;
    for (const DeformedMesh& mesh : m_deform.meshes) {
        if (!mesh.deformPending) continue;
        for (uint32_t i = 0; i < mesh.recordCount; ++i) {
            m_tasks.push_back({.record = mesh.firstRecord + i, .firstGroup = m_groupCount});
            m_groupCount += GroupsOf(m_deform.records[mesh.firstRecord + i]);
        }
    }
    if (m_tasks.empty()) return;
    m_taskIds = renderer.Import("deformTasks", m_deform.taskBuffer, m_tasksState);
    m_matrices = renderer.Import("jointMatrices", m_deform.matrixBuffer, m_matricesState);
    m_weights = renderer.Import("morphWeights", m_deform.weightBuffer, m_weightsState);
    DeclareUpload(renderer);
    DeclareDeform(renderer, ids);
}

void DeformSet::DeclareUpload(Renderer& renderer) {
    renderer.AddPass(
        "UploadPoses", PassKind::Transfer,
        [&](PassBuilder& pass) {
            m_taskIds = pass.CopiesTo(m_taskIds);
            m_matrices = pass.CopiesTo(m_matrices);
            m_weights = pass.CopiesTo(m_weights);
        },
        [this](CommandList& commands) {
            RecordUpload(commands);
            commands.OnSubmitted([this] {
                for (SkinMatrices& skin : m_deform.skins) skin.isDirty = false;
                for (DeformedMesh& mesh : m_deform.meshes) mesh.weightsDirty = false;
            });
        });
}

void DeformSet::RecordUpload(CommandList& commands) {
    std::vector<TableCopy> copies{{std::as_bytes(std::span(std::as_const(m_tasks))), m_deform.taskBuffer, 0}};
    for (const SkinMatrices& skin : m_deform.skins)
        if (skin.isDirty)
            copies.push_back(
                {std::as_bytes(std::span(std::as_const(m_deform.matrices)).subspan(skin.first, skin.count)),
                 m_deform.matrixBuffer, skin.first * sizeof(glm::mat4x3)});
    for (const DeformedMesh& mesh : m_deform.meshes)
        if (mesh.weightsDirty && mesh.weightCount > 0)
            copies.push_back({std::as_bytes(m_deform.WeightsOf(mesh)), m_deform.weightBuffer,
                              mesh.firstWeight * sizeof(float)});
    RecordCopies(commands, m_device, "pose staging", copies);
}

void DeformSet::DeclareDeform(Renderer& renderer, SceneIds& ids) {
    renderer.AddPass(
        "Deform", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("scene/deform.comp");
            pass.Reads("deformRecords",
                       renderer.Import("deformRecords", m_deform.recordBuffer, m_recordsState));
            pass.Reads("deformTasks", m_taskIds);
            pass.Reads("jointMatrices", m_matrices);
            pass.Reads("morphWeights", m_weights);
            ids.deformedStreams = pass.WritesByAddress(ids.deformedStreams);
            pass.Constants(DeformConstants{static_cast<uint32_t>(m_tasks.size()), m_groupCount});
        },
        [this](CommandList& commands) {
            const uint32_t rows = (m_groupCount + gpu::kDeformRowGroups - 1) / gpu::kDeformRowGroups;
            commands.Dispatch(std::min(m_groupCount, gpu::kDeformRowGroups), rows);
            commands.OnSubmitted([this] {
                for (DeformedMesh& mesh : m_deform.meshes) mesh.deformPending = false;
                ++m_deformCount;
            });
        });
}

std::vector<DeformedGroup*> DeformSet::UnbuiltGroups() {
    std::vector<DeformedGroup*> unbuilt;
    for (DeformedMesh& mesh : m_deform.meshes)
        for (DeformedGroup& group : mesh.groups)
            if (!m_geometry.groups[group.group].blas->IsBuilt()) unbuilt.push_back(&group);
    return unbuilt;
}

void DeformSet::MarkBuilt(std::span<DeformedGroup* const> groups) noexcept {
    for (DeformedGroup* group : groups) {
        group->refitPending = group->rebuildPending = false;
        group->quality.OnBuild();
    }
}

void DeformSet::DeclareRefits(Renderer& renderer, SceneIds& ids, rhi::BlasBuilder& builder) {
    std::vector<DeformedGroup*> due;
    for (DeformedMesh& mesh : m_deform.meshes)
        for (DeformedGroup& group : mesh.groups)
            if (group.refitPending && m_geometry.groups[group.group].blas->IsBuilt()) due.push_back(&group);
    if (due.empty()) return;
    m_instances.MarkRefitted();
    renderer.AddPass(
        "RefitBlas", PassKind::AccelerationStructure,
        [&](PassBuilder& pass) {
            pass.BuildsFrom(ids.deformedStreams);
            ids.blases = pass.Refits(ids.blases);
        },
        [this, due = std::move(due), &builder](CommandList& commands) {
            std::vector<rhi::BlasBuilder::RefitRequest> requests;
            for (const DeformedGroup* group : due)
                requests.push_back({.blas = m_geometry.groups[group->group].blas.get(),
                                    .desc = {},
                                    .rebuilds = group->rebuildPending});
            builder.RecordRefits(commands, requests);
            commands.OnSubmitted([due] {
                for (DeformedGroup* group : due) {
                    if (group->rebuildPending) group->quality.OnBuild();
                    group->refitPending = group->rebuildPending = false;
                }
            });
        });
}

// --- Resources of skinned and morphed meshes ---

namespace {

// Packs two joints into a word, the first in its lower half, whatever the byte order of the host.
std::vector<uint32_t> PackJoints(const std::vector<uint16_t>& joints) {
    std::vector<uint32_t> words((joints.size() + 1) / 2);
    for (size_t i = 0; i < joints.size(); ++i) words[i / 2] |= uint32_t{joints[i]} << (16 * (i % 2));
    return words;
}

// Turns an offset into an address.
void Place(uint64_t& offset, VkDeviceAddress start) {
    offset = StreamPacker::Address(offset, start);
}

// Copies a group, which is then drawn by itself; both share their streams.
GroupResources CopyOf(const GroupResources& group, DeviceArray<gpu::GeometryRecord>& records) {
    GroupResources copy;
    copy.kind = group.kind;
    copy.parts = group.parts;
    copy.blas = group.blas;  // that of a group that does not deform
    copy.record = group.record;
    copy.record.firstGeometry = static_cast<uint32_t>(records.Size());
    records.Grow(records.Size() + group.parts.size());
    for (uint32_t i = 0; i < group.parts.size(); ++i)
        records.Edit(copy.record.firstGeometry + i) = records[group.record.firstGeometry + i];
    copy.emitters = group.emitters;
    copy.emitterVariants = group.emitterVariants;
    copy.triangleCount = group.triangleCount;
    copy.capsuleCount = group.capsuleCount;
    copy.bounds = group.bounds;
    copy.base = group.base;
    return copy;
}

// Returns the plan's copies with the poses that the scene has.
std::unique_ptr<DeformResources> PosesOf(const scene::SceneData& scene, const DeformPlan& plan) {
    auto result = std::make_unique<DeformResources>();
    result->meshOf = plan.copyOf;
    result->skins.resize(scene.skins.size());
    const std::vector<scene::PlacedTransform> nodeToWorld = scene::WorldTransforms(scene);
    for (const DeformedCopy& copy : plan.copies) {
        DeformedMesh& mesh = result->meshes.emplace_back();
        const scene::Instance& instance = scene.instances[copy.instances.front()];
        mesh.mesh = copy.mesh;
        mesh.instances = copy.instances;
        mesh.skin = copy.skin;
        mesh.firstWeight = static_cast<uint32_t>(result->weights.size());
        if (copy.hasTargets) {
            const std::span<const float> weights = scene::MorphWeights(scene, instance);
            mesh.weightCount = static_cast<uint32_t>(weights.size());
            result->weights.insert(result->weights.end(), weights.begin(), weights.end());
        }
        if (copy.skin == scene::kNone || result->skins[copy.skin].count > 0) continue;
        const scene::Skin& skin = scene.skins[copy.skin];
        SkinMatrices& range = result->skins[copy.skin];
        range = {.first = static_cast<uint32_t>(result->matrices.size()),
                 .count = static_cast<uint32_t>(skin.joints.size()),
                 .isDirty = true};
        result->matrices.resize(range.first + range.count);
        scene::JointMatrices(nodeToWorld, skin, {instance.objectToWorld, instance.translationResidual},
                             std::span(result->matrices).subspan(range.first));
    }
    return result;
}

// Gives each copy its groups: those of its mesh if nothing else draws them, or else new ones.
void AddGroups(DeformResources& deform, const DeformPlan& plan, SceneGeometry& geometry) {
    for (size_t i = 0; i < plan.copies.size(); ++i) {
        DeformedMesh& copy = deform.meshes[i];
        const bool isFirst = i == 0 || plan.copies[i - 1].mesh != copy.mesh;
        geometry.meshes[copy.mesh].isDeformed = true;
        const MeshResources base = geometry.meshes[copy.mesh];
        if (!isFirst || plan.isBaseShapeDrawn[copy.mesh]) {
            copy.mesh = static_cast<uint32_t>(geometry.meshes.size());
            MeshResources& added = geometry.meshes.emplace_back(base);
            added.isCopy = true;
            added.firstGroup = static_cast<uint32_t>(geometry.groups.size());
            for (uint32_t group = 0; group < base.groupCount; ++group)
                geometry.groups.push_back(CopyOf(geometry.groups[base.firstGroup + group], geometry.records));
        }
        for (const uint32_t instance : copy.instances) geometry.meshOf[instance] = copy.mesh;
        const uint32_t firstGroup = geometry.meshes[copy.mesh].firstGroup;
        for (uint32_t group = 0; group < base.groupCount; ++group)
            if (geometry.groups[firstGroup + group].base)
                copy.groups.push_back({.group = firstGroup + group});
    }
}

// Gives the groups of a copy their ranges of the streams. With a `next` of 0 this finds the size alone.
void AssignStreams(DeformResources& deform, DeformedMesh& mesh, SceneGeometry& geometry,
                   VkDeviceAddress& next) {
    const auto take = [&](uint64_t bytes) {
        const VkDeviceAddress address = next;
        next += AlignStream(bytes);
        return address;
    };
    mesh.firstRecord = static_cast<uint32_t>(deform.records.size());
    for (const DeformedGroup& deformed : mesh.groups) {
        GroupResources& group = geometry.groups[deformed.group];
        group.record.positions = take(group.base->vertexCount * sizeof(glm::vec3));
        for (size_t i = 0; i < group.base->parts.size(); ++i) {
            const BaseShape::Part& part = group.base->parts[i];
            gpu::GeometryRecord& shown = geometry.records.Edit(group.record.firstGeometry + i);
            gpu::DeformRecord record = part.record;
            const size_t end = i + 1 < group.base->parts.size() ? group.base->parts[i + 1].firstVertex
                                                                : group.base->vertexCount;
            record.vertexCount = static_cast<uint32_t>(end - part.firstVertex);
            record.deformedPositions = group.record.positions + part.firstVertex * sizeof(glm::vec3);
            if (record.normals != 0) {
                record.deformedNormals = take(record.vertexCount * sizeof(glm::vec3));
                shown.normals = record.deformedNormals - part.firstVertex * sizeof(glm::vec3);
            }
            if (record.tangents != 0) {
                record.deformedTangents = take(record.vertexCount * sizeof(glm::vec4));
                shown.tangents = record.deformedTangents - part.firstVertex * sizeof(glm::vec4);
            }
            if (mesh.skin == scene::kNone)
                record.perVertex = 0;
            else
                record.firstMatrix = deform.skins[mesh.skin].first;
            if (mesh.weightCount == 0) record.targetCount = 0;
            record.firstWeight = mesh.firstWeight;
            deform.records.push_back(record);
        }
    }
    mesh.recordCount = static_cast<uint32_t>(deform.records.size()) - mesh.firstRecord;
}

}  // namespace

bool MayDeform(std::span<scene::Primitive* const> primitives) {
    return std::ranges::any_of(primitives, [](const scene::Primitive* primitive) {
        return !primitive->influences.IsEmpty() || !primitive->targets.empty();
    });
}

void PackDeformInputs(const scene::Primitive& primitive, StreamPacker& packer, BaseShape& base) {
    BaseShape::Part& part = base.parts.emplace_back();
    part.record.joints = packer.Append(PackJoints(primitive.influences.joints));
    part.record.weights = packer.Append(primitive.influences.weights);
    part.record.perVertex = primitive.influences.perVertex;
    part.record.targetCount = static_cast<uint32_t>(primitive.targets.size());
    part.record.isFlat = primitive.hasFlatNormals ? 1u : 0u;
    std::vector<gpu::DeformTarget> targets;
    for (const scene::MorphTarget& target : primitive.targets)
        targets.push_back({.positions = packer.Append(target.positions),
                           .normals = packer.Append(target.normals),
                           .tangents = packer.Append(target.tangents)});
    part.targets = packer.Append(targets);
}

void ResolveBaseAddresses(BaseShape::Part& part, const gpu::GeometryRecord& geometry, uint64_t positions,
                          uint64_t firstVertex, VkDeviceAddress start, StreamPacker& packer) {
    gpu::DeformRecord& record = part.record;
    part.firstVertex = static_cast<uint32_t>(firstVertex);
    record.positions = start + positions + firstVertex * sizeof(glm::vec3);
    record.normals = StreamPacker::Address(geometry.normals, start);
    record.tangents = StreamPacker::Address(geometry.tangents, start);
    Place(record.joints, start);
    Place(record.weights, start);
    record.targets = StreamPacker::Address(part.targets, start);
    for (uint32_t i = 0; i < record.targetCount; ++i) {
        const std::span<std::byte> bytes =
            packer.At(part.targets + i * sizeof(gpu::DeformTarget)).first(sizeof(gpu::DeformTarget));
        gpu::DeformTarget target;
        std::memcpy(&target, bytes.data(), bytes.size());
        Place(target.positions, start);
        Place(target.normals, start);
        Place(target.tangents, start);
        std::memcpy(bytes.data(), &target, bytes.size());
    }
}

std::span<const glm::mat4x3> DeformResources::MatricesOf(const DeformedMesh& mesh) const {
    if (mesh.skin == scene::kNone) return {};
    return std::span(matrices).subspan(skins[mesh.skin].first, skins[mesh.skin].count);
}

std::span<const float> DeformResources::WeightsOf(const DeformedMesh& mesh) const {
    return std::span(weights).subspan(mesh.firstWeight, mesh.weightCount);
}

void DeformResources::Follow(DeformedMesh& mesh, SceneGeometry& geometry) const {
    for (DeformedGroup& deformed : mesh.groups) {
        GroupResources& group = geometry.groups[deformed.group];
        group.base->outline.Deform(WeightsOf(mesh), MatricesOf(mesh), deformed.pose);
        group.bounds = deformed.pose.bounds;
        deformed.rebuildPending = deformed.quality.Follow(deformed.pose.samples) > RefitQuality::kMaxDecay;
        deformed.refitPending = true;
    }
    mesh.deformPending = mesh.recordCount > 0;
}

void PoseEmitters(const OutlinePose& pose, std::span<Emitter> emitters) {
    for (size_t i = 0; i < emitters.size(); ++i) {
        emitters[i].p0 = pose.emitters[3 * i];
        emitters[i].p1 = pose.emitters[3 * i + 1];
        emitters[i].p2 = pose.emitters[3 * i + 2];
        emitters[i].error = pose.emitterError;
        emitters[i].isFlattened = pose.isFlattened;
    }
}

void AddDeformedCopies(SceneContext& context, const scene::SceneData& scene, const DeformPlan& plan,
                       SceneGeometry& geometry) {
    std::unique_ptr<DeformResources> made = PosesOf(scene, plan);
    DeformResources& result = *made;
    AddGroups(result, plan, geometry);
    VkDeviceAddress bytes = 0;
    for (DeformedMesh& mesh : result.meshes) AssignStreams(result, mesh, geometry, bytes);
    result.records.clear();
    result.streams = context.device.CreateBuffer(
        {.name = "deformed streams",
         .size = std::max<uint64_t>(kStreamAlignment, bytes),
         .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::BuildInput | rhi::BufferUsage::CopySource});
    geometry.streamBytes += result.streams.Size();
    VkDeviceAddress next = result.streams.Address();
    for (DeformedMesh& mesh : result.meshes) {
        AssignStreams(result, mesh, geometry, next);
        result.Follow(mesh, geometry);
        for (DeformedGroup& deformed : mesh.groups) {
            GroupResources& group = geometry.groups[deformed.group];
            PoseEmitters(deformed.pose, group.emitters);
            rhi::BlasDesc blas;
            blas.name = "deformed mesh";
            blas.kind = rhi::BlasKind::Deforming;
            blas.triangles.push_back({.vertices = group.record.positions,
                                      .vertexCount = group.base->vertexCount,
                                      .indices = group.record.indices,
                                      .triangleCount = static_cast<uint32_t>(group.triangleCount)});
            SetFlags(blas, group.kind);
            group.blas = context.builder.Add(blas);
        }
    }
    result.recordBuffer =
        CreateTable(context.device, "deform records", result.records.size(), sizeof(gpu::DeformRecord));
    result.taskBuffer =
        CreateTable(context.device, "deform tasks", result.records.size(), sizeof(gpu::DeformTask));
    result.matrixBuffer =
        CreateTable(context.device, "joint matrices", result.matrices.size(), sizeof(glm::mat4x3));
    result.weightBuffer = CreateTable(context.device, "morph weights", result.weights.size(), sizeof(float));
    if (!result.records.empty())
        context.uploader.UploadBuffer(result.recordBuffer, 0, std::as_bytes(std::span(result.records)));
    geometry.deform = std::move(made);
}

}  // namespace raygraph
