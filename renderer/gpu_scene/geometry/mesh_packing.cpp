#include "renderer/gpu_scene/geometry/mesh_packing.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "renderer/bvh/wide_scene.h"
#include "renderer/gpu_scene/instances/group_kinds.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "renderer/scene/geometry/round_primitives.h"

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

// Describes a primitive, or a part of a split one, in its group.
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
    const gpu::MaterialRecord& record = materials.records[primitive.material];
    GroupPart part{.material = primitive.material,
                   .lowestAlpha = LowestAlpha(primitive.colors),
                   .isRound = primitive.IsRound(),
                   .isShadowCatcher = (record.flags & gpu::kMaterialShadowCatcher) != 0u};
    for (const auto& [variant, material] : primitive.variants) part.variants.push_back({variant, material});
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
            if (primitive.indices.empty() ||
                KindOf({&parts[i], 1}, materials.records, materials.textureAlphas) != kind)
                continue;
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

float LowestAlpha(std::span<const glm::vec4> colors) {
    float lowest = 1.0f;
    for (const glm::vec4& color : colors) lowest = std::min(lowest, color.a);
    return lowest;
}

std::vector<float> LowestTextureAlphas(scene::SceneData& scene) {
    std::vector<float> byMaterial;
    for (const scene::Material& material : scene.materials) {
        byMaterial.push_back(1.0f);
        if (!material.baseColorTexture.IsPresent()) continue;
        const auto texture = static_cast<size_t>(material.baseColorTexture.texture);
        scene::ImageData& image = scene.images[scene.textures[texture].image];
        image.lowestAlpha = scene::LowestAlpha(image);
        byMaterial.back() = static_cast<float>(*image.lowestAlpha) / 255.0f;
    }
    return byMaterial;
}

static_assert(sizeof(scene::Bounds) == 6 * sizeof(float));

GroupCapsules MergeCapsules(std::span<scene::Primitive* const> primitives) {
    GroupCapsules listed, sorted;
    std::vector<glm::vec3> centers;
    uint32_t firstVertex = 0;
    for (uint32_t p = 0; p < primitives.size(); ++p) {
        scene::Primitive& primitive = *primitives[p];
        sorted.firstVertices.push_back(firstVertex);
        for (uint32_t i = 0; i < primitive.radii.size(); ++i) {
            const uint32_t first = primitive.indices[2 * i], second = primitive.indices[2 * i + 1];
            const glm::vec3 p0 = primitive.positions[first], p1 = primitive.positions[second];
            listed.records.push_back({.p0 = p0,
                                      .radius = primitive.radii[i],
                                      .p1 = p1,
                                      .first = firstVertex + first,
                                      .second = firstVertex + second});
            listed.geometries.push_back(p);
            listed.originals.push_back(i);
            centers.push_back(0.5f * p0 + 0.5f * p1);
        }
        firstVertex += static_cast<uint32_t>(primitive.positions.size());
        primitive.positions = {};
        primitive.indices = {};
        primitive.radii = {};
    }
    for (const uint32_t source : SpatialOrder(centers)) {
        const gpu::CapsuleRecord& record = listed.records[source];
        sorted.records.push_back(record);
        sorted.boxes.push_back(scene::RoundBox(record.p0, record.p1, record.radius));
        if (primitives.size() > 1) sorted.geometries.push_back(listed.geometries[source]);
        sorted.originals.push_back(listed.originals[source]);
    }
    return sorted;
}

// --- Orders for builds ---

namespace {

constexpr uint32_t kAxisBits = 21;
constexpr double kLastStep = (1u << kAxisBits) - 1;
constexpr uint32_t kDigitBits = 9;  // 7 radix-sort digits
constexpr size_t kBlock = 64;       // points whose positions are computed at once

struct Keyed {
    uint64_t key = 0;
    uint32_t index = 0;
};

// Inserts two zeros between any two of the lowest 21 bits.
uint64_t SpreadBits(uint64_t bits) {
    bits = (bits | bits << 32) & 0x1f00000000ffffull;
    bits = (bits | bits << 16) & 0x1f0000ff0000ffull;
    bits = (bits | bits << 8) & 0x100f00f00f00f00full;
    bits = (bits | bits << 4) & 0x10c30c30c30c30c3ull;
    return (bits | bits << 2) & 0x1249249249249249ull;
}

// The cube around all finite points, in 2^21 steps per axis.
class Grid {
  public:
    explicit Grid(std::span<const glm::vec3> points) {
        glm::dvec3 highest = -m_lowest;
        for (const glm::vec3& point : points) {
            if (!glm::all(glm::lessThan(glm::abs(point), glm::vec3(std::numeric_limits<float>::infinity()))))
                continue;
            m_lowest = glm::min(m_lowest, glm::dvec3(point));
            highest = glm::max(highest, glm::dvec3(point));
        }
        const glm::dvec3 size = highest - m_lowest;
        const double extent = std::max({size.x, size.y, size.z, 0.0});
        m_scale = extent > 0.0 ? kLastStep / extent : 0.0;
    }

    uint32_t Step(const glm::vec3& point, int axis) const {
        const double step = (double(point[axis]) - m_lowest[axis]) * m_scale;
        return step >= 0.0 && step <= kLastStep ? static_cast<uint32_t>(step) : 0u;
    }

  private:
    glm::dvec3 m_lowest{std::numeric_limits<double>::infinity()};
    double m_scale = 0.0;
};

// Turns coordinates into bits of positions along a Hilbert curve, interleaved by SpreadBits with x first:
// Skilling 2004, "Programming the Hilbert curve". All points of a block are processed at once, without
// branches.
struct Block {
    std::array<std::array<uint32_t, kBlock>, 3> x{};  // indexed by axis

    void ToCurve() {
        for (uint32_t bit = kAxisBits - 1; bit > 0; --bit) {
            const uint32_t below = (1u << bit) - 1u;
            for (auto& its : x)
                for (size_t i = 0; i < kBlock; ++i) {
                    const uint32_t isSet = 0u - (its[i] >> bit & 1u);  // all ones, or zero
                    const uint32_t swapped = (x[0][i] ^ its[i]) & below & ~isSet;
                    x[0][i] ^= swapped | (below & isSet);
                    its[i] ^= swapped;
                }
        }
        for (size_t i = 0; i < kBlock; ++i) {
            x[1][i] ^= x[0][i];
            x[2][i] ^= x[1][i];
            // Each bit of the last coordinate flips all bits below it
            uint32_t flips = x[2][i] >> 1;
            for (uint32_t shift = 1; shift < kAxisBits; shift *= 2) flips ^= flips >> shift;
            for (auto& its : x) its[i] ^= flips;
        }
    }
    uint64_t Key(size_t i) const {
        return SpreadBits(x[0][i]) << 2 | SpreadBits(x[1][i]) << 1 | SpreadBits(x[2][i]);
    }
};

std::vector<Keyed> KeysOf(std::span<const glm::vec3> points) {
    const Grid grid(points);
    std::vector<Keyed> keyed(points.size());
    Block block;
    for (size_t first = 0; first < points.size(); first += kBlock) {
        const size_t count = std::min(kBlock, points.size() - first);
        for (int axis = 0; axis < 3; ++axis)
            for (size_t i = 0; i < count; ++i) block.x[axis][i] = grid.Step(points[first + i], axis);
        block.ToCurve();
        for (size_t i = 0; i < count; ++i)
            keyed[first + i] = {block.Key(i), static_cast<uint32_t>(first + i)};
    }
    return keyed;
}

}  // namespace

std::vector<uint32_t> SpatialOrder(std::span<const glm::vec3> points) {
    std::vector<Keyed> keyed = KeysOf(points), sorted(points.size());
    // A radix sort by the digits of the keys, the lowest digit first
    for (uint32_t shift = 0; shift < 3 * kAxisBits; shift += kDigitBits) {
        const auto digit = [shift](const Keyed& k) { return (k.key >> shift) % (uint64_t{1} << kDigitBits); };
        std::array<size_t, (1u << kDigitBits) + 1> begins{};
        for (const Keyed& k : keyed) ++begins[digit(k) + 1];
        std::partial_sum(begins.begin(), begins.end(), begins.begin());
        for (const Keyed& k : keyed) sorted[begins[digit(k)]++] = k;
        keyed.swap(sorted);
    }
    std::vector<uint32_t> order(points.size());
    std::ranges::transform(keyed, order.begin(), &Keyed::index);
    return order;
}

std::vector<uint32_t> SortTriangles(std::span<const glm::vec3> positions, std::vector<uint32_t>& indices) {
    const size_t triangleCount = indices.size() / 3;
    std::vector<uint32_t> order;
    {
        std::vector<glm::vec3> centroids(triangleCount);
        for (size_t i = 0; i < triangleCount; ++i)
            centroids[i] =
                (positions[indices[3 * i]] + positions[indices[3 * i + 1]] + positions[indices[3 * i + 2]]) /
                3.0f;
        order = SpatialOrder(centroids);
    }
    bool isMoved = false;
    std::vector<uint32_t> sorted(indices.size());
    for (size_t i = 0; i < triangleCount; ++i) {
        const size_t source = order[i];
        isMoved |= source != i;
        for (size_t corner = 0; corner < 3; ++corner) sorted[3 * i + corner] = indices[3 * source + corner];
    }
    if (!isMoved) return {};
    indices = std::move(sorted);
    return order;
}

// --- Copies to the device ---

namespace {

// Turns the offsets of a group into addresses in its buffer at `start`.
void ResolveGroupAddresses(PackedGroup& group, VkDeviceAddress start) {
    for (size_t i = 0; i < group.records.size(); ++i) {
        gpu::GeometryRecord& record = group.records[i];
        const uint64_t first = group.firstVertices[i];
        if (group.base)
            ResolveBaseAddresses(group.base->parts[i], record, group.positions, first, start, group.streams);
        record.normals = StreamPacker::Address(record.normals, start, first, sizeof(glm::vec3));
        record.tangents = StreamPacker::Address(record.tangents, start, first, sizeof(glm::vec4));
        record.frameTurns = StreamPacker::Address(record.frameTurns, start, first, sizeof(glm::vec2));
        record.uv0 = StreamPacker::Address(record.uv0, start, first, sizeof(glm::vec2));
        record.uv1 = StreamPacker::Address(record.uv1, start, first, sizeof(glm::vec2));
        record.colors = StreamPacker::Address(record.colors, start, first, sizeof(glm::vec4));
        record.primitives = StreamPacker::Address(record.primitives, start);
    }
}

rhi::BlasDesc BlasOf(const PackedGroup& group, const std::string& name, VkDeviceAddress start) {
    rhi::BlasDesc blas;
    blas.name = name;
    if (group.kind.isRound)
        blas.aabbs.push_back(
            {.boxes = StreamPacker::Address(group.boxes, start), .boxCount = group.boxCount});
    else
        blas.triangles.push_back({.vertices = StreamPacker::Address(group.positions, start),
                                  .vertexCount = group.vertexCount,
                                  .indices = StreamPacker::Address(group.indices, start),
                                  .triangleCount = static_cast<uint32_t>(group.triangleCount)});
    SetFlags(blas, group.kind);
    return blas;
}

void RenumberMaterials(PackedGroup& group, std::span<const uint32_t> numbers) {
    if (numbers.empty()) return;
    const auto renumber = [&](auto& thing) { thing.material = numbers[thing.material]; };
    for (GroupPart& part : group.parts) {
        renumber(part);
        std::ranges::for_each(part.variants, renumber);
    }
    std::ranges::for_each(group.records, renumber);
    std::ranges::for_each(group.emitters.emitters, renumber);
    std::ranges::for_each(group.emitters.variants, renumber);
}

}  // namespace

MeshUpload::MeshUpload(SceneContext& context, rhi::Uploader& uploader, std::span<PackedMesh> meshes,
                       std::span<const uint32_t> materials)
    : m_context(context), m_uploader(uploader), m_meshes(meshes), m_materials(materials) {
    for (const PackedMesh& mesh : meshes) m_bytes += mesh.Bytes();
}

bool MeshUpload::Continue(uint32_t mesh, uint64_t& budget, bool mayWait) {
    PackedMesh& packed = m_meshes[mesh];
    while (m_groups.size() < packed.groups.size()) {
        if (budget == 0 || (!mayWait && m_uploader.WouldBlock())) return false;
        PackedGroup& group = packed.groups[m_groups.size()];
        if (!m_streams) {
            m_streams = m_context.device.CreateBuffer(
                {.name = packed.name + " streams",
                 .size = group.streams.Bytes().size(),
                 .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::BuildInput |
                          rhi::BufferUsage::CopySource | rhi::BufferUsage::CopyDestination});
            ResolveGroupAddresses(group, m_streams.Address());
            m_offset = 0;
        }
        const std::span<const std::byte> left = group.streams.Bytes().subspan(m_offset);
        const std::span<const std::byte> piece = left.first(std::min<uint64_t>(left.size(), budget));
        m_uploader.UploadBuffer(m_streams, m_offset, piece);
        m_offset += piece.size();
        m_copiedBytes += piece.size();
        budget -= piece.size();
        if (piece.size() < left.size()) return false;
        m_groups.push_back(Finish(group, packed));
        budget -= std::min(budget, group.triangleCount * kTriangleCost);
        m_context.disposer.Dispose(std::exchange(group, {}));  // the next group may need this memory
    }
    return true;
}

// Requires that the streams of the group have been copied.
GroupResources MeshUpload::Finish(PackedGroup& group, const PackedMesh& mesh) {
    RenumberMaterials(group, m_materials);
    GroupResources result;
    result.streams = std::exchange(m_streams, {});
    const VkDeviceAddress start = result.streams.Address();
    if (!group.base || mesh.use.isBaseDrawn)
        result.blas = m_context.builder.Add(BlasOf(group, mesh.name, start));
    result.kind = group.kind;
    result.parts = std::move(group.parts);
    result.record.positions = StreamPacker::Address(group.positions, start);
    result.record.indices = StreamPacker::Address(group.indices, start);
    result.record.triangleGeometries = StreamPacker::Address(group.geometries, start);
    result.record.triangleLights = StreamPacker::Address(group.lights, start);
    result.records = std::move(group.records);
    result.emitters = std::move(group.emitters.emitters);
    result.emitterVariants = std::move(group.emitters.variants);
    result.triangleCount = group.triangleCount;
    result.capsuleCount = group.boxCount;
    result.bounds = group.bounds;
    result.base = std::move(group.base);
    result.tree = std::move(group.tree);
    return result;
}

}  // namespace raygraph
