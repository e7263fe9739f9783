// Prepares meshes for the device on the host (mesh_upload.h copies them): sorts triangles into groups and in
// space, finds those that emit, and lays out the streams in memory. Threads: different objects may be used on
// different threads at once.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "renderer/gpu_scene/deform/deform_resources.h"
#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/geometry/stream_packer.h"
#include "renderer/gpu_scene/lights/emitters.h"
#include "renderer/scene/geometry/split_mesh.h"

namespace raygraph {

// A group of a mesh. Positions in `streams` are offsets, or StreamPacker::kAbsent.
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
    std::vector<uint32_t> firstVertices;       // by part
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

// The properties of materials that packing reads, by material index.
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

}  // namespace raygraph
