#include "renderer/gpu_scene/geometry/mesh_packing.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <optional>
#include <utility>

#include "renderer/bvh/wide_scene.h"
#include "renderer/gpu_scene/geometry/alpha_bounds.h"
#include "renderer/gpu_scene/geometry/capsules.h"
#include "renderer/gpu_scene/geometry/spatial_order.h"
#include "renderer/gpu_scene/instances/group_kinds.h"

namespace raygraph {
namespace {

// Merges the triangles of all primitives into one list in spatial order. Moves positions and indices out of
// them.
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

// The kinds of groups. A mesh has at most one group of triangles and one of round primitives of each kind.
// Thin walls are two-sided, so that none is culled.
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

// A primitive, or a part of a split one, in its group.
struct Piece {
    scene::PrimitivePiece content;
    GroupPart part;
};

// `originals` holds indices within the pieces that `geometries` names; they become indices within the
// primitives of the file.
void RestoreOriginals(std::span<const Piece> pieces, std::span<const uint32_t> geometries, size_t count,
                      std::vector<uint32_t>& originals) {
    if (std::ranges::all_of(pieces, [](const Piece& piece) { return piece.content.originals.empty(); }))
        return;
    if (originals.empty()) {
        originals.resize(count);
        std::iota(originals.begin(), originals.end(), 0u);
    }
    for (size_t i = 0; i < count; ++i) {
        const Piece& piece = pieces[geometries.empty() ? 0 : geometries[i]];
        if (!piece.content.originals.empty()) originals[i] = piece.content.originals[originals[i]];
    }
}

uint32_t TangentSetOf(const scene::Primitive& primitive) {
    if (primitive.tangentTexCoord == scene::kNone) return gpu::kTangentsOfAllMaps;
    return primitive.tangentTexCoord == 1 ? gpu::kTangentsOfSecondSet : gpu::kTangentsOfFirstSet;
}

// Moves the contents of the pieces out.
PackedGroup PackGroup(std::span<Piece> pieces, const GroupKind& kind, const MeshUse& use,
                      EmitterFinder& finder) {
    PackedGroup result;
    result.kind = kind;
    std::vector<scene::Primitive*> primitives;
    for (Piece& piece : pieces) {
        primitives.push_back(&piece.content.primitive);
        result.parts.push_back(std::move(piece.part));
    }
    for (const scene::Primitive* primitive : primitives) result.bounds.Extend(primitive->bounds);
    GroupCapsules capsules = kind.isRound ? MergeCapsules(primitives) : GroupCapsules{};
    GroupTriangles triangles = kind.isRound ? GroupTriangles{} : MergeTriangles(primitives);
    result.triangleCount = triangles.indices.size() / 3;
    result.vertexCount = static_cast<uint32_t>(triangles.positions.size());
    result.boxCount = static_cast<uint32_t>(capsules.boxes.size());
    RestoreOriginals(pieces, kind.isRound ? capsules.geometries : triangles.geometries,
                     kind.isRound ? capsules.records.size() : result.triangleCount,
                     kind.isRound ? capsules.originals : triangles.originals);
    result.emitters = finder.Find(triangles, primitives, !kind.isBackCulled);
    if (use.tree != WideBvhUse::None && !kind.isRound && !(use.isDeformed && MayDeform(primitives))) {
        result.tree = std::make_shared<WideMesh>(CollectTriangles(triangles.positions, triangles.indices));
        if (use.tree == WideBvhUse::Tree) BuildTree(*result.tree, use.bvhThreads);
    }

    StreamPacker& packer = result.streams;
    result.positions = kind.isRound ? packer.Append(capsules.records) : packer.Append(triangles.positions);
    result.indices = packer.Append(triangles.indices);  // absent for capsules
    result.boxes = packer.Append(capsules.boxes);
    result.geometries = packer.Append(kind.isRound ? capsules.geometries : triangles.geometries);
    const uint64_t originals = packer.Append(kind.isRound ? capsules.originals : triangles.originals);
    result.lights = packer.Append(TriangleLights(result.emitters.emitters, result.triangleCount));
    if (use.isDeformed && MayDeform(primitives)) {
        result.base = std::make_shared<BaseShape>(
            BaseShape{.vertexCount = result.vertexCount,
                      .outline = DeformOutline(triangles, primitives, result.emitters.emitters)});
        for (const scene::Primitive* primitive : primitives)
            PackDeformInputs(*primitive, packer, *result.base);
    }
    for (scene::Primitive* primitive : primitives) {
        result.records.push_back({
            .normals = packer.Append(primitive->normals),
            .tangents = packer.Append(primitive->tangents),
            .frameTurns = packer.Append(primitive->frameTurns),
            .uv0 = packer.Append(primitive->uv0),
            .uv1 = packer.Append(primitive->uv1),
            .colors = packer.Append(primitive->colors),
            .primitives = originals,
            .material = primitive->material,
            .tangentSet = TangentSetOf(*primitive),
        });
        *primitive = {};
    }
    result.firstVertices = std::move(kind.isRound ? capsules.firstVertices : triangles.firstVertices);
    return result;
}

GroupPart PartOf(const scene::Primitive& primitive, const PackingMaterials& materials) {
    const float ofColors = LowestAlpha(primitive.colors);
    GroupPart part{.material = primitive.material,
                   .lowestAlpha = ofColors * materials.textureAlphas[primitive.material],
                   .isRound = primitive.IsRound()};
    for (const auto& [variant, material] : primitive.variants)
        part.variants.push_back({variant, material, ofColors * materials.textureAlphas[material]});
    return part;
}

// Returns how many of the first pieces fit into one group: at least one.
size_t CountWithin(std::span<const Piece> pieces, const scene::PieceLimits& limits) {
    uint64_t triangles = 0, vertices = 0, bytes = 0;
    size_t count = 0;
    for (const Piece& piece : pieces) {
        const scene::Primitive& primitive = piece.content.primitive;
        triangles += primitive.IsRound() ? primitive.radii.size() : primitive.TriangleCount();
        vertices += primitive.positions.size();
        bytes += scene::StreamBytes(primitive);
        if (triangles > limits.maxTriangles || vertices > limits.maxVertices || bytes > limits.maxBytes)
            break;
        ++count;
    }
    return std::max<size_t>(1, count);
}

}  // namespace

uint64_t PackedMesh::Bytes() const {
    uint64_t bytes = 0;
    for (const PackedGroup& group : groups) bytes += group.streams.Bytes().size();
    return bytes;
}

size_t PackedMesh::GeometryCount() const {
    size_t count = 0;
    for (const PackedGroup& group : groups) count += group.records.size();
    return count;
}

PackedMesh PackMesh(scene::Mesh& mesh, const PackingMaterials& materials, const MeshUse& use,
                    EmitterFinder& finder, const scene::PieceLimits& limits) {
    PackedMesh result;
    result.name = mesh.name.empty() ? "mesh" : mesh.name;
    result.use = use;
    std::vector<GroupPart> parts;
    bool mayEmit = false;
    for (const scene::Primitive& primitive : mesh.primitives) {
        parts.push_back(PartOf(primitive, materials));
        mayEmit |= finder.MayEmit(primitive);
    }
    const std::optional<Enclosure> shape = mayEmit ? std::optional(Enclosure::Of(mesh)) : std::nullopt;
    for (const GroupKind& kind : AllGroupKinds()) {
        std::vector<Piece> pieces;
        for (size_t i = 0; i < parts.size(); ++i) {
            scene::Primitive& primitive = mesh.primitives[i];
            if (primitive.indices.empty() || KindOf({&parts[i], 1}, materials.records) != kind) continue;
            for (scene::PrimitivePiece& piece : scene::SplitPrimitive(std::move(primitive), limits))
                pieces.push_back({std::move(piece), parts[i]});
            primitive = {};
        }
        for (size_t first = 0; first < pieces.size();) {
            const size_t count = CountWithin(std::span(pieces).subspan(first), limits);
            result.groups.push_back(PackGroup(std::span(pieces).subspan(first, count), kind, use, finder));
            first += count;
            if (!shape) continue;
            for (Emitter& emitter : result.groups.back().emitters.emitters) {
                emitter.isOnClosedMesh = shape->IsClosed();
                emitter.isThin = shape->IsThin();
            }
        }
    }
    return result;
}

void DropVariants(PackedMesh& mesh) {
    for (PackedGroup& group : mesh.groups) {
        for (GroupPart& part : group.parts) part.variants.clear();
        group.emitters.variants.clear();
    }
}

}  // namespace raygraph
