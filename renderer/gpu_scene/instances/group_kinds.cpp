#include "renderer/gpu_scene/instances/group_kinds.h"

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "renderer/scene/model/variants.h"

namespace raygraph {

namespace {

// Tells whether no ray needs an alpha test: the material has no alpha, or is opaque everywhere.
bool IsOpaque(const gpu::MaterialRecord& material, float lowestAlpha) {
    const auto mode = static_cast<scene::AlphaMode>(material.alphaMode);
    if (mode == scene::AlphaMode::Opaque) return true;
    // The product rounds, and may be opaque here where the shader's is not
    const float alpha = material.baseColor.a * lowestAlpha;
    if (mode == scene::AlphaMode::Blend || lowestAlpha == 1.0f)
        return alpha >= (mode == scene::AlphaMode::Mask ? material.alphaCutoff : 1.0f);
    constexpr float kRounding = 1.0f / 512.0f;
    return alpha >= material.alphaCutoff + kRounding;
}

// Tells whether light may pass straight through the surface somewhere (bxdf/bsdf.glsl, IsSmoothThinWall).
bool IsThinWall(const gpu::MaterialRecord& material) {
    constexpr uint32_t kKinds = gpu::kMaterialGlass | gpu::kMaterialVolume | gpu::kMaterialUnlit;
    return (material.flags & kKinds) == gpu::kMaterialGlass &&
           MayBeSmooth(material.roughness, material.metallicRoughnessTexture);
}

// Tells whether rays run an any-hit shader on the group.
bool IsAnyHit(const GroupKind& kind) {
    return !kind.isOpaque || kind.isThinWall;
}

}  // namespace

bool IsBackCulled(const gpu::MaterialRecord& material) {
    return (material.flags & gpu::kMaterialTwoSided) == 0u;
}

GroupKind KindOf(std::span<const GroupPart> parts, std::span<const gpu::MaterialRecord> materials,
                 std::span<const float> textureAlphas) {
    GroupKind kind;
    bool hasBackCulled = false;
    for (const GroupPart& part : parts) {
        const gpu::MaterialRecord& material = materials[part.material];
        kind.isOpaque &= IsOpaque(material, part.lowestAlpha * textureAlphas[part.material]);
        kind.isThinWall |= IsThinWall(material);
        kind.isBackCulled &= IsBackCulled(material);
        hasBackCulled |= IsBackCulled(material);
        kind.isRound = part.isRound;
    }
    kind.isOpaque &= kind.isBackCulled || !hasBackCulled;
    return kind;
}

bool SetFlags(rhi::BlasDesc& blas, const GroupKind& kind) {
    bool isChanged = false;
    const bool isOpaque = !IsAnyHit(kind);
    for (rhi::TriangleGeometry& triangles : blas.triangles) {
        isChanged |= std::exchange(triangles.isOpaque, isOpaque) != isOpaque;
        isChanged |= std::exchange(triangles.noDuplicateAnyHit, kind.isThinWall) != kind.isThinWall;
    }
    // A round primitive reports two hits, one where a ray enters and one where it leaves, and any-hit runs
    // for each.
    for (rhi::AabbGeometry& boxes : blas.aabbs)
        isChanged |= std::exchange(boxes.isOpaque, isOpaque) != isOpaque;
    return isChanged;
}

namespace {

// Gives groups for which `isAffected` holds the kind that their parts now have. On an Error they keep their
// kind.
KindChanges UpdateKinds(SceneGeometry& geometry, const SceneMaterials& materials, rhi::BlasBuilder& builder,
                        const std::function<bool(const GroupPart&)>& isAffected) {
    struct Changed {
        GroupResources& group;
        GroupKind kind;
        std::shared_ptr<rhi::Blas> blas;
    };
    std::vector<Changed> changed;
    std::map<const rhi::Blas*, std::shared_ptr<rhi::Blas>> replaced;  // copies of a group share its BLAS
    KindChanges changes;
    for (GroupResources& group : geometry.groups) {
        if (std::none_of(group.parts.begin(), group.parts.end(), isAffected)) continue;
        const GroupKind kind = KindOf(group.parts, materials.Records(), materials.TextureAlphas());
        if (kind == group.kind) continue;
        if (group.hostBlas != 0 && IsAnyHit(kind) != IsAnyHit(group.kind))
            throw Error(
                ErrorKind::Usage,
                "GpuScene: SetMaterial: a host's own BLAS cannot become one that rays test for alpha, or "
                "the other way round");
        std::shared_ptr<rhi::Blas>& blas = replaced[group.blas.get()];
        if (!blas && group.blas) {
            rhi::BlasDesc desc = group.blas->Desc();
            const bool isOther = SetFlags(desc, kind);
            blas = isOther ? builder.Add(desc) : group.blas;
            changes.structuresChanged |= isOther;
        }
        changed.push_back({group, kind, blas});
        changes.sidesChanged |=
            kind.isOpaque != group.kind.isOpaque || kind.isBackCulled != group.kind.isBackCulled;
    }
    if (changes.structuresChanged) builder.Reserve();
    for (Changed& change : changed) {
        change.group.kind = change.kind;
        change.group.blas = std::move(change.blas);
    }
    return changes;
}

void TakeVariant(SceneGeometry& geometry, uint32_t variant) noexcept {
    geometry.variant = variant;
    for (GroupResources& group : geometry.groups)
        for (size_t i = 0; i < group.parts.size(); ++i) {
            GroupPart& part = group.parts[i];
            if (part.variants.empty()) continue;
            const std::span<const PartVariant> variants = part.variants;
            part.material = variants[scene::VariantEntry(variants, variant)].material;
            geometry.records.Edit(group.record.firstGeometry + i).material = part.material;
        }
}

}  // namespace

KindChanges ChangeMaterials(SceneGeometry& geometry, SceneMaterials& materials, rhi::BlasBuilder& builder,
                            std::span<SceneMaterials::ChangedRecord> changed) {
    const auto exchange = [&] {
        for (SceneMaterials::ChangedRecord& each : changed) materials.Exchange(each);
    };
    exchange();
    try {
        return UpdateKinds(geometry, materials, builder, [&](const GroupPart& part) {
            return std::ranges::find(changed, part.material, &SceneMaterials::ChangedRecord::material) !=
                   changed.end();
        });
    } catch (...) {
        exchange();
        throw;
    }
}

KindChanges ChangeVariant(SceneGeometry& geometry, SceneMaterials& materials, rhi::BlasBuilder& builder,
                          uint32_t variant) {
    const uint32_t old = geometry.variant;
    materials.MarkFeaturesDirty();
    try {
        TakeVariant(geometry, variant);
        return UpdateKinds(geometry, materials, builder,
                           [](const GroupPart& part) { return !part.variants.empty(); });
    } catch (...) {
        TakeVariant(geometry, old);
        throw;
    }
}

}  // namespace raygraph
