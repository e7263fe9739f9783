// Meshes on their way to the device: on the host, triangles are sorted into groups and in space, those that
// emit are found, and the streams are laid out in memory; MeshUpload then copies them. For
// renderer/gpu_scene alone. Threads: different objects may be used on different threads at once; MeshUpload:
// that of its uploader.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "renderer/gpu_scene/deform/deform_set.h"
#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/geometry/stream_packer.h"
#include "renderer/gpu_scene/lights/emitters.h"
#include "renderer/gpu_scene/scene_context.h"
#include "renderer/scene/geometry/split_mesh.h"
#include "renderer/scene/model/scene_data.h"
#include "rhi/transfer.h"
#include "shaders/shared/scene_records.h"

namespace raygraph {

// Describes a group of a mesh. Positions in `streams` are offsets, or StreamPacker::kAbsent.
struct PackedGroup {
    GroupKind kind;
    std::vector<GroupPart> parts;
    StreamPacker streams;
    uint64_t positions = StreamPacker::kAbsent;  // for round primitives, their CapsuleRecords
    uint64_t indices = StreamPacker::kAbsent;
    uint64_t boxes = StreamPacker::kAbsent;  // for round primitives alone
    uint64_t geometries = StreamPacker::kAbsent;
    uint64_t lights = StreamPacker::kAbsent;
    std::vector<gpu::GeometryRecord> records;  // one per part, with offsets
    std::vector<uint32_t> firstVertices;       // indexed by part
    EmitterLists emitters;
    uint32_t vertexCount = 0;
    uint64_t triangleCount = 0;  // 0 for round primitives
    uint32_t boxCount = 0;
    scene::Bounds bounds;
    std::shared_ptr<BaseShape> base;  // null: nothing deforms the group; holds offsets
    std::shared_ptr<WideMesh> tree;   // null: the group has no tree
};

struct PackedMesh {
    std::string name;
    std::vector<PackedGroup> groups;
    MeshUse use;

    uint64_t Bytes() const;
    size_t GeometryCount() const;
};

// Limits that every device can meet: 1 GiB in one allocation, half of it for positions and indices in the
// order of the BLAS, and memory to build that BLAS.
inline constexpr scene::PieceLimits kPortableLimits{.maxTriangles = 1u << 24, .maxBytes = 512u << 20};

// Holds the properties of materials that packing reads, by material index.
struct PackingMaterials {
    std::vector<gpu::MaterialRecord> records;  // their texture slots are not read
    std::vector<float> textureAlphas;          // see LowestTextureAlphas
};

// Moves all primitives out of the mesh. Material numbers do not change. No group exceeds the limits:
// primitives of one kind that do not fit become several groups.
PackedMesh PackMesh(scene::Mesh& mesh, const PackingMaterials& materials, const MeshUse& use,
                    EmitterFinder& finder, const scene::PieceLimits& limits = kPortableLimits);

// Keeps the materials of the variant that is shown and drops all others.
void DropVariants(PackedMesh& mesh);

// --- Lower bounds of the values by which a material's alpha is multiplied ---
// Where the product is opaque, no ray needs an alpha test.

// Returns the lowest alpha of a primitive's vertex colors; 1 without colors.
float LowestAlpha(std::span<const glm::vec4> colors);

// Returns the lowest alpha of each material's base color texture; 1 without a texture. Each image must have
// its texels or a known LowestAlpha(), which this call also makes known.
std::vector<float> LowestTextureAlphas(scene::SceneData& scene);

// --- The round primitives of a group in the layout of its BLAS ---

struct GroupCapsules {
    std::vector<gpu::CapsuleRecord> records;
    std::vector<scene::Bounds> boxes;  // input of rhi::AabbGeometry
    // By capsule: its primitive within the group; empty if there is only one primitive.
    std::vector<uint32_t> geometries;
    std::vector<uint32_t> originals;      // by capsule: its index in its primitive
    std::vector<uint32_t> firstVertices;  // indexed by primitive
};

// Merges the capsules of all primitives into one list in spatial order. Moves positions, indices and radii
// out of the primitives.
GroupCapsules MergeCapsules(std::span<scene::Primitive* const> primitives);

// --- Orders for acceleration-structure builds ---
// Some builders keep the order of their input (lavapipe's does), so that neighbors in space have to be
// neighbors in the index buffer and in the instance buffer.

// Returns the order of the points along a Hilbert curve: order[k] is the index of the k-th point. The grid
// has 2^21 steps per axis, since some points may be very far from the others. Points of one cell keep their
// order, and coordinates that are not finite count as the lowest ones.
std::vector<uint32_t> SpatialOrder(std::span<const glm::vec3> points);

// Reorders the triangles of an index list by their centroids, in place. Returns for each triangle of the new
// order its index in the old one; empty when the order is unchanged.
std::vector<uint32_t> SortTriangles(std::span<const glm::vec3> positions, std::vector<uint32_t>& indices);

// --- Copies of packed meshes to the device when they are needed, whole or in pieces ---

// Cost of a triangle whose BLAS is built, in copied bytes of a frame's budget.
inline constexpr uint64_t kTriangleCost = 64;

class MeshUpload {
  public:
    // Keeps references to all arguments. `materials` maps a material index of the meshes to its index on the
    // device; if it is empty, indices do not change. The entries that a mesh uses must be set before the last
    // Make for it.
    MeshUpload(SceneContext& context, rhi::Uploader& uploader, std::span<PackedMesh> meshes,
               std::span<const uint32_t> materials = {});

    // Continues copying the mesh; one mesh is finished before the next is begun. Subtracts from `budget` the
    // copied bytes and kTriangleCost for each triangle. Returns true when the mesh is complete, false if the
    // budget is used up or, with mayWait false, if it would have to wait for the device. Adds the BLAS of
    // each group to the builder and frees its host memory.
    bool Continue(uint32_t mesh, uint64_t& budget, bool mayWait = true);
    // Returns the groups of the mesh that is complete.
    std::vector<GroupResources> Take() { return std::exchange(m_groups, {}); }
    // Bytes that all meshes together will have copied in the end, and bytes copied so far.
    uint64_t Bytes() const { return m_bytes; }
    uint64_t CopiedBytes() const { return m_copiedBytes; }

  private:
    GroupResources Finish(PackedGroup& group, const PackedMesh& mesh);

    SceneContext& m_context;
    rhi::Uploader& m_uploader;
    std::span<PackedMesh> m_meshes;
    std::span<const uint32_t> m_materials;
    uint64_t m_bytes = 0, m_copiedBytes = 0;
    std::vector<GroupResources> m_groups;  // the finished groups of the current mesh
    rhi::Buffer m_streams;                 // streams of the group that is being copied
    uint64_t m_offset = 0;                 // bytes of m_streams that have been copied
};

}  // namespace raygraph
