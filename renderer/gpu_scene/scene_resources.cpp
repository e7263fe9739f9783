#include "renderer/gpu_scene/scene_resources.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "renderer/gpu_scene/alpha_bounds.h"
#include "renderer/gpu_scene/capsules.h"
#include "renderer/gpu_scene/deform_resources.h"
#include "renderer/gpu_scene/emitters.h"
#include "renderer/gpu_scene/group_kinds.h"
#include "renderer/gpu_scene/material_records.h"
#include "renderer/gpu_scene/spatial_order.h"
#include "renderer/gpu_scene/stream_packer.h"
#include "renderer/gpu_scene/texture_upload.h"

namespace raygraph {
namespace {

// One list over the vertices of all primitives, in spatial order. Takes positions and indices.
GroupTriangles MergeTriangles(std::span<scene::Primitive* const> primitives) {
    GroupTriangles merged;
    if (primitives.size() == 1) {
        merged.positions = std::move(primitives[0]->positions);
        merged.indices = std::move(primitives[0]->indices);
        merged.firstVertices = {0};
        merged.originals = SortTriangles(merged.positions, merged.indices);
        return merged;
    }
    std::vector<uint32_t> geometries, originals;
    for (uint32_t p = 0; p < primitives.size(); ++p) {
        scene::Primitive& primitive = *primitives[p];
        const auto firstVertex = static_cast<uint32_t>(merged.positions.size());
        merged.firstVertices.push_back(firstVertex);
        merged.positions.insert(merged.positions.end(), primitive.positions.begin(),
                                primitive.positions.end());
        for (const uint32_t index : primitive.indices) merged.indices.push_back(firstVertex + index);
        for (uint32_t triangle = 0; triangle < primitive.TriangleCount(); ++triangle) {
            geometries.push_back(p);
            originals.push_back(triangle);
        }
        primitive.positions = {};
        primitive.indices = {};
    }
    const std::vector<uint32_t> order = SortTriangles(merged.positions, merged.indices);
    if (order.empty()) {
        merged.geometries = std::move(geometries);
        merged.originals = std::move(originals);
        return merged;
    }
    for (const uint32_t source : order) {
        merged.geometries.push_back(geometries[source]);
        merged.originals.push_back(originals[source]);
    }
    return merged;
}

// Kinds of groups, of which a mesh has one each at most, and as many of round primitives. Walls have both
// sides, and alpha needs any-hit anyway.
constexpr GroupKind kGroupKinds[] = {
    {.isOpaque = true, .isBackCulled = true},
    {.isOpaque = true, .isBackCulled = false},
    {.isOpaque = false, .isBackCulled = true},
    {.isOpaque = false, .isBackCulled = false},
    {.isOpaque = true, .isBackCulled = false, .isThinWall = true},
    {.isOpaque = false, .isBackCulled = false, .isThinWall = true},
};

std::vector<GroupKind> AllGroupKinds() {
    std::vector<GroupKind> kinds(std::begin(kGroupKinds), std::end(kGroupKinds));
    kinds.insert(kinds.end(), std::begin(kGroupKinds), std::end(kGroupKinds));
    for (size_t i = std::size(kGroupKinds); i < kinds.size(); ++i) kinds[i].isRound = true;
    return kinds;
}

// Uploads one group and appends its geometry records. Empties the primitives.
GroupResources UploadGroup(rhi::Device& device, rhi::Uploader& uploader, rhi::BlasBuilder& builder,
                           const std::string& name, std::span<scene::Primitive* const> primitives,
                           std::vector<GroupPart> parts, const GroupKind& kind, const MeshUse& use,
                           EmitterFinder& finder, std::vector<gpu::GeometryRecord>& records) {
    GroupResources result;
    result.kind = kind;
    result.parts = std::move(parts);
    for (const scene::Primitive* primitive : primitives) result.bounds.Extend(primitive->bounds);
    const GroupCapsules capsules = kind.isRound ? MergeCapsules(primitives) : GroupCapsules{};
    const GroupTriangles triangles = kind.isRound ? GroupTriangles{} : MergeTriangles(primitives);
    const std::vector<uint32_t>& firstVertices =
        kind.isRound ? capsules.firstVertices : triangles.firstVertices;
    result.triangleCount = triangles.indices.size() / 3;
    FoundEmitters found = finder.Find(triangles, primitives, !kind.isBackCulled);
    result.emitters = std::move(found.emitters);
    result.emitterVariants = std::move(found.variants);

    // Offsets now, addresses once the buffer exists
    StreamPacker packer;
    const uint64_t positions =
        kind.isRound ? packer.Append(capsules.records) : packer.Append(triangles.positions);
    const uint64_t indices = packer.Append(triangles.indices);  // absent of capsules
    const uint64_t boxes = packer.Append(capsules.boxes);
    const uint64_t geometries = packer.Append(kind.isRound ? capsules.geometries : triangles.geometries);
    const uint64_t originals = packer.Append(kind.isRound ? capsules.originals : triangles.originals);
    const uint64_t lights = packer.Append(TriangleLights(result.emitters, result.triangleCount));
    std::shared_ptr<BaseShape> base;
    if (use.isDeformed && MayDeform(primitives)) {
        base = std::make_shared<BaseShape>(
            BaseShape{.vertexCount = static_cast<uint32_t>(triangles.positions.size()),
                      .outline = DeformOutline(triangles, primitives, result.emitters)});
        for (const scene::Primitive* primitive : primitives) PackMovers(*primitive, packer, *base);
    }
    const size_t firstRecord = records.size();
    for (scene::Primitive* primitive : primitives) {
        records.push_back({
            .normals = packer.Append(primitive->normals),
            .tangents = packer.Append(primitive->tangents),
            .uv0 = packer.Append(primitive->uv0),
            .uv1 = packer.Append(primitive->uv1),
            .colors = packer.Append(primitive->colors),
            .primitives = originals,
            .material = primitive->material,
            .padding = 0,
        });
        *primitive = {};
    }

    result.streams = device.CreateBuffer({.name = name + " streams",
                                          .size = packer.Bytes().size(),
                                          .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::BuildInput |
                                                   rhi::BufferUsage::CopyDestination});
    const VkDeviceAddress start = result.streams.Address();
    for (size_t i = 0; i < primitives.size(); ++i) {
        gpu::GeometryRecord& record = records[firstRecord + i];
        const uint64_t first = firstVertices[i];
        if (base) PlaceBase(base->parts[i], record, positions, first, start, packer);
        record.normals = StreamPacker::Address(record.normals, start, first, sizeof(glm::vec3));
        record.tangents = StreamPacker::Address(record.tangents, start, first, sizeof(glm::vec4));
        record.uv0 = StreamPacker::Address(record.uv0, start, first, sizeof(glm::vec2));
        record.uv1 = StreamPacker::Address(record.uv1, start, first, sizeof(glm::vec2));
        record.colors = StreamPacker::Address(record.colors, start, first, sizeof(glm::vec4));
        record.primitives = StreamPacker::Address(record.primitives, start);
    }
    uploader.UploadBuffer(result.streams, 0, packer.Bytes());
    result.record.positions = StreamPacker::Address(positions, start);
    result.record.indices = StreamPacker::Address(indices, start);
    result.record.triangleGeometries = StreamPacker::Address(geometries, start);
    result.record.triangleLights = StreamPacker::Address(lights, start);
    result.record.firstGeometry = static_cast<uint32_t>(firstRecord);
    result.base = std::move(base);
    if (result.base && !use.isBaseDrawn) return result;

    rhi::BlasDesc blas;
    blas.name = name;
    if (kind.isRound)
        blas.aabbs.push_back({.boxes = StreamPacker::Address(boxes, start),
                              .boxCount = static_cast<uint32_t>(capsules.boxes.size())});
    else
        blas.triangles.push_back({.vertices = result.record.positions,
                                  .vertexCount = static_cast<uint32_t>(triangles.positions.size()),
                                  .indices = result.record.indices,
                                  .triangleCount = static_cast<uint32_t>(result.triangleCount)});
    SetFlags(blas, kind);
    result.blas = builder.Add(blas);
    return result;
}

// Uploads the groups of one mesh.
MeshResources UploadMesh(rhi::Device& device, rhi::Uploader& uploader, rhi::BlasBuilder& builder,
                         scene::Mesh& mesh, std::span<const float> textureAlphas, const MeshUse& use,
                         EmitterFinder& finder, SceneResources& resources,
                         std::vector<gpu::GeometryRecord>& records) {
    std::vector<GroupPart> parts;
    for (const scene::Primitive& primitive : mesh.primitives) {
        const float ofColors = LowestAlpha(primitive.colors);
        GroupPart& part =
            parts.emplace_back(GroupPart{.material = primitive.material,
                                         .lowestAlpha = ofColors * textureAlphas[primitive.material],
                                         .isRound = primitive.IsRound()});
        for (const auto& [variant, material] : primitive.variants)
            part.variants.push_back({variant, material, ofColors * textureAlphas[material]});
    }
    MeshResources result;
    result.firstGroup = static_cast<uint32_t>(resources.groups.size());
    for (const GroupKind& kind : AllGroupKinds()) {
        std::vector<scene::Primitive*> primitives;
        std::vector<GroupPart> ofKind;
        for (size_t i = 0; i < parts.size(); ++i) {
            if (mesh.primitives[i].indices.empty()) continue;
            if (KindOf({&parts[i], 1}, resources.materialRecords) != kind) continue;
            primitives.push_back(&mesh.primitives[i]);
            ofKind.push_back(parts[i]);
        }
        if (primitives.empty()) continue;
        const std::string name = mesh.name.empty() ? "mesh" : mesh.name;
        resources.groups.push_back(UploadGroup(device, uploader, builder, name, primitives, std::move(ofKind),
                                               kind, use, finder, records));
        resources.geometryBytes += resources.groups.back().streams.Size();
        result.triangleCount += resources.groups.back().triangleCount;
    }
    result.groupCount = static_cast<uint32_t>(resources.groups.size()) - result.firstGroup;
    return result;
}

// A table on the device; one zero record where there is none, since an empty buffer cannot be bound.
template <typename T>
rhi::Buffer UploadTable(rhi::Device& device, rhi::Uploader& uploader, const char* name,
                        std::span<const T> records) {
    const T none{};
    const std::span<const T> content = records.empty() ? std::span<const T>(&none, 1) : records;
    rhi::Buffer buffer =
        device.CreateBuffer({.name = name,
                             .size = content.size_bytes(),
                             .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::CopyDestination |
                                      rhi::BufferUsage::CopySource});
    uploader.UploadBuffer(buffer, 0, std::as_bytes(content));
    return buffer;
}

}  // namespace

scene::Bounds BoundsOf(const SceneResources& resources, const MeshResources& mesh) {
    scene::Bounds bounds;
    for (uint32_t group = mesh.firstGroup; group < mesh.firstGroup + mesh.groupCount; ++group)
        bounds.Extend(resources.groups[group].bounds);
    return bounds;
}

uint64_t TriangleCount(const SceneResources& resources) {
    uint64_t count = 0;
    for (const MeshResources& mesh : resources.meshes) count += mesh.isCopy ? 0 : mesh.triangleCount;
    return count;
}
uint64_t TriangleCount(const SceneResources& resources, std::span<const scene::Instance> instances) {
    uint64_t count = 0;
    for (const scene::Instance& instance : instances) count += resources.meshes[instance.mesh].triangleCount;
    return count;
}

SceneResources::SceneResources() = default;
SceneResources::~SceneResources() = default;

std::unique_ptr<SceneResources> UploadScene(rhi::Device& device, rhi::Uploader& uploader,
                                            rhi::BlasBuilder& builder, scene::SceneData& scene,
                                            const TextureUploadSettings& textures) {
    auto resources = std::make_unique<SceneResources>();
    std::vector<gpu::GeometryRecord> records;
    EmitterFinder finder(scene);
    resources->materialRecords = MaterialRecords(scene.materials, {});
    const std::vector<float> textureAlphas = LowestTextureAlphas(scene);
    for (const scene::Instance& instance : scene.instances) resources->meshOf.push_back(instance.mesh);
    const bool isDeformed = std::ranges::any_of(scene.instances, &scene::Instance::isDeformed);
    std::optional<DeformUpload> deform;
    if (isDeformed) deform.emplace(scene);
    for (uint32_t i = 0; i < scene.meshes.size(); ++i) {
        const MeshUse use = deform ? deform->UseOf(i) : MeshUse{};
        resources->meshes.push_back(UploadMesh(device, uploader, builder, scene.meshes[i], textureAlphas, use,
                                               finder, *resources, records));
        if (use.isDeformed) deform->AddCopies(i, *resources, records);
    }
    if (deform) deform->Finish(device, uploader, builder, *resources, records);
    resources->usedMaterials = UsedMaterials(*resources);
    UploadTextures(device, uploader, scene, textures, *resources);
    resources->materialRecords = MaterialRecords(scene.materials, resources->textures);
    resources->geometryCount = static_cast<uint32_t>(records.size());
    resources->geometries = UploadTable<gpu::GeometryRecord>(device, uploader, "geometries", records);
    resources->variantCount = static_cast<uint32_t>(scene.variants.size());
    resources->variant = scene.variant;
    if (resources->variantCount > 0) resources->geometryRecords = std::move(records);
    resources->materials =
        UploadTable<gpu::MaterialRecord>(device, uploader, "materials", resources->materialRecords);
    return resources;
}

}  // namespace raygraph
