// What is done to a mesh before it goes to a device (mesh_upload.h): its triangles sorted into groups and in
// space, those that emit found, its streams laid out in memory. Threads: objects that are not shared may be
// used on any threads at once.
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

// A group of a mesh. Places are offsets in `streams`, or StreamPacker::kAbsent.
struct PackedGroup {
    GroupKind kind;
    std::vector<GroupPart> parts;
    StreamPacker streams;
    uint64_t positions = StreamPacker::kAbsent;  // of round primitives their CapsuleRecords
    uint64_t indices = StreamPacker::kAbsent;
    uint64_t boxes = StreamPacker::kAbsent;  // of round primitives
    uint64_t geometries = StreamPacker::kAbsent;
    uint64_t lights = StreamPacker::kAbsent;
    std::vector<gpu::GeometryRecord> records;  // one a part, with offsets
    std::vector<uint32_t> firstVertices;       // by part
    EmitterLists emitters;
    uint32_t vertexCount = 0;
    uint64_t triangleCount = 0;  // 0 of round primitives
    uint32_t boxCount = 0;
    scene::Bounds bounds;
    std::shared_ptr<BaseShape> base;  // null: nothing deforms it; with offsets
    std::shared_ptr<WideMesh> tree;   // null: it has none
};

struct PackedMesh {
    std::string name;
    std::vector<PackedGroup> groups;
    MeshUse use;

    uint64_t Bytes() const;
    size_t GeometryCount() const;
};

// What every device has: 1 GiB in one allocation, of which positions and indices take a second part in the
// order of the BLAS; and memory to build one.
inline constexpr scene::PieceLimits kPortableLimits{.maxTriangles = 1u << 24, .maxBytes = 512u << 20};

// What materials say about the meshes that have them: by their index.
struct PackingMaterials {
    std::vector<gpu::MaterialRecord> records;  // slots of textures do not matter
    std::vector<float> textureAlphas;          // LowestTextureAlphas
};

// Takes all primitives of the mesh. Materials keep their numbers. No group is beyond the limits: what does
// not fit becomes several of a kind.
PackedMesh PackMesh(scene::Mesh& mesh, const PackingMaterials& materials, const MeshUse& use,
                    EmitterFinder& finder, const scene::PieceLimits& limits = kPortableLimits);

// Keeps what it is in the variant that is shown.
void DropVariants(PackedMesh& mesh);

}  // namespace raygraph
