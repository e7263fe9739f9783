// Records for drawing the scene: one source for C++ and GLSL, scalar layout.
//
// A draw is one group of triangles, for all of its visible placements at once: instance i of it is the
// placement, as the index of its InstanceRecord, that stands in slot firstInstance + i of the list of visible
// placements. Draws are ordered by how their triangles are drawn (DrawKind of gpu_scene.h).
#ifndef RAYGRAPH_SHARED_DRAW_RECORDS_H
#define RAYGRAPH_SHARED_DRAW_RECORDS_H

#ifdef __cplusplus

#include <cstdint>
#include <glm/glm.hpp>

namespace raygraph::gpu {
using glm::vec3;
using uint = uint32_t;
#endif

// A group as it would be drawn if all of its placements were visible.
struct DrawRecord {
    vec3 boundsMin;  // object space
    uint vertexCount;
    vec3 boundsMax;
    uint firstSlot;  // it has as many as the group has placements
};

// VkDrawIndirectCommand.
struct DrawCommand {
    uint vertexCount;
    uint instanceCount;
    uint firstVertex;
    uint firstInstance;
};

#ifdef __cplusplus
static_assert(sizeof(DrawRecord) == 8 * 4);
static_assert(sizeof(DrawCommand) == 4 * 4);
}  // namespace raygraph::gpu
#endif

#endif
