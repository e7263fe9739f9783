// The kinds of groups, by which rays treat primitives, and their changes when materials change. Threads: that
// of the Renderer.
#pragma once

#include <cstdint>
#include <span>

#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/materials/scene_materials.h"
#include "rhi/blas_builder.h"

namespace raygraph {

// Tells whether rays ignore back faces of the material.
bool IsBackCulled(const gpu::MaterialRecord& material);

// Returns the kind of a group with these parts. If back faces of only some parts are culled, an any-hit
// shader decides. `textureAlphas` are lower bounds of the alpha of the base color's texture, by material.
GroupKind KindOf(std::span<const GroupPart> parts, std::span<const gpu::MaterialRecord> materials,
                 std::span<const float> textureAlphas);
// Sets the geometry flags of a group's BLAS. Returns true if they have changed.
bool SetFlags(rhi::BlasDesc& blas, const GroupKind& kind);

// Holds the effects of a change of materials.
struct KindChanges {
    bool structuresChanged = false;  // BLASes wait to be built
    bool sidesChanged = false;       // culling or alpha has changed
};
// Exchanges the records of materials with those of `changed`, and updates the groups that use them. A BLAS
// whose geometry flags change is added to the builder again, with the memory for its build. On an Error
// nothing has changed.
KindChanges ChangeMaterials(SceneGeometry& geometry, SceneMaterials& materials, rhi::BlasBuilder& builder,
                            std::span<SceneMaterials::ChangedRecord> changed);

// Gives all parts, and the geometry records on the host, their materials in a variant. Otherwise it does what
// ChangeMaterials does.
KindChanges ChangeVariant(SceneGeometry& geometry, SceneMaterials& materials, rhi::BlasBuilder& builder,
                          uint32_t variant);

}  // namespace raygraph
