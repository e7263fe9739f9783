// The scene as a list of draws: one for each group of triangles, whatever the number of its placements. Round
// primitives are not drawn: raster views find them by rays. The draws of a kind are contiguous, so that one
// call draws a kind; as long as there is room, adding or removing groups does not move the draws of others.
// Threads: that of the Renderer.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/gpu_scene/device_array.h"
#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "renderer/gpu_scene/record_table.h"
#include "renderer/gpu_scene/scene_ids.h"
#include "shaders/shared/draw_records.h"

namespace raygraph {

DrawKind KindOf(const GroupKind& group);

class DrawTable {
  public:
    // Creates the draws of all groups, and writes their numbers into the groups' records.
    DrawTable(rhi::Device& device, SceneGeometry& geometry, const InstanceSet& instances);
    void Upload(rhi::Uploader& uploader);

    // Must be called when a group has been added or is about to be removed. Its record gets its number, if
    // there is room.
    void Add(GroupResources& group);
    void Remove(const GroupResources& group);
    // Must be called when placements have been added or removed.
    void MarkCountsDirty() noexcept { m_countsDirty = true; }
    // Must be called when the kinds of groups have changed.
    void MarkNumbersDirty() noexcept { m_numbersDirty = true; }
    void SetBounds(const GroupResources& group);

    // Updates the records. If room is lacking or kinds have changed, it renumbers all draws with room for
    // more, which makes the records of all placements dirty. If memory runs out, the next call repeats it.
    void Refresh(SceneGeometry& geometry, InstanceSet& instances);
    // Sets `draws`, `drawsOfKind` and `chunkCount`, and uploads the changes.
    void Declare(Renderer& renderer, SceneIds& ids);

  private:
    struct Kind {
        uint32_t first = 0;  // number of its first draw
        uint32_t room = 0;
        SlotRanges taken;  // counted from `first`
    };
    void Number(SceneGeometry& geometry, uint32_t roomFactor);
    void Count(const SceneGeometry& geometry, const InstanceSet& instances);

    std::array<Kind, kDrawKindCount> m_kinds;
    bool m_numbersDirty = false, m_countsDirty = false;
    uint64_t m_chunkCount = 0;
    DeviceArray<gpu::DrawRecord> m_draws;
};

}  // namespace raygraph
