// How rays treat the groups of a scene's primitives, and what becomes of them when materials change. For
// renderer/gpu_scene alone. Threads: exclusive access to what is changed.
#pragma once

#include <cstdint>
#include <span>

#include "renderer/gpu_scene/geometry/scene_geometry.h"

namespace raygraph {

// Whether back faces are culled for rays.
bool IsBackCulled(const gpu::MaterialRecord& material);

// Where the back faces of only some parts are culled, an any-hit shader decides.
GroupKind KindOf(std::span<const GroupPart> parts, std::span<const gpu::MaterialRecord> materials);
// Of the geometry of a group's BLAS. True if they have changed.
bool SetFlags(rhi::BlasDesc& blas, const GroupKind& kind);

// Replaces the record of a material, and updates the groups that use it. A BLAS whose geometry flags change
// is added to the builder again, with the memory for its build. On an Error nothing has changed. Returns
// what has:
struct KindChanges {
    bool structuresChanged = false;  // BLASes wait to be built
    bool sidesChanged = false;       // culling or alpha has changed
};
KindChanges ChangeMaterial(SceneGeometry& geometry, SceneMaterials& materials, rhi::BlasBuilder& builder,
                           uint32_t material, const gpu::MaterialRecord& record);

// Gives all parts, and the geometry records on the host, their materials in a variant. Otherwise as
// ChangeMaterial.
KindChanges ChangeVariant(SceneGeometry& geometry, SceneMaterials& materials, rhi::BlasBuilder& builder,
                          uint32_t variant);

}  // namespace raygraph
