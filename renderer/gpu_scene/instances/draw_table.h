// The scene as a list of draws: one for each group of triangles, whatever the number of its placements. Round
// primitives are not drawn: raster views find them by rays. Draws of a kind are neighbors, so that a view
// draws a kind by one call; groups keep their draws while others come and go, as long as there is room.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/gpu_scene/device_array.h"
#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "renderer/gpu_scene/scene_ids.h"
#include "renderer/gpu_scene/slot_ranges.h"
#include "shaders/shared/draw_records.h"

namespace raygraph {

DrawKind KindOf(const GroupKind& group);

class DrawTable {
  public:
    // Of all groups, whose records get the numbers of their draws.
    DrawTable(rhi::Device& device, SceneGeometry& geometry, const InstanceSet& instances);
    void Upload(rhi::Uploader& uploader);

    // A group has come, or is about to go. Its record gets its number, if there is room.
    void Add(GroupResources& group);
    void Remove(const GroupResources& group);
    // Placements have come or gone.
    void MarkCountsDirty() noexcept { m_countsDirty = true; }
    // Groups are of other kinds.
    void MarkNumbersDirty() noexcept { m_numbersDirty = true; }
    void SetBounds(const GroupResources& group);

    // Brings the records up to date; where there was no room, or kinds have changed, numbers all again, with
    // room for more, which makes records of all placements due. Where memory runs out, the next call does it.
    void Refresh(SceneGeometry& geometry, InstanceSet& instances);
    // Sets `draws`, `drawsOfKind` and `chunkCount`; uploads what has changed.
    void Declare(Renderer& renderer, SceneIds& ids);

  private:
    struct Kind {
        uint32_t first = 0;  // number of its first draw
        uint32_t room = 0;
        SlotRanges taken;  // from `first`
    };
    void Number(SceneGeometry& geometry, uint32_t roomFactor);
    void Count(const SceneGeometry& geometry, const InstanceSet& instances);

    std::array<Kind, kDrawKindCount> m_kinds;
    bool m_numbersDirty = false, m_countsDirty = false;
    uint64_t m_chunkCount = 0;
    DeviceArray<gpu::DrawRecord> m_draws;
};

}  // namespace raygraph
