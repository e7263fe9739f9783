// The draw lists of raster passes: the scene's groups of triangles, each with the placements that may be in
// the picture. For passes/ alone. Threads: that of the Renderer.
#pragma once

#include <array>

#include "passes/trace.h"

namespace raygraph::passes {

struct DrawList {
    BufferId commands;           // gpu::DrawCommand[], as SceneIds::draws
    BufferId visiblePlacements;  // see shaders/shared/draw_records.h
};

// `shift` moves the picture, in clip units. RequireIndirectDraws comes first.
DrawList ListDraws(Renderer& renderer, const SceneIds& scene, const gpu::TraceParameters& parameters,
                   const glm::vec2& shift);

// Throws Error{Usage} naming `pass` on a device that cannot draw such lists.
void RequireIndirectDraws(const Renderer& renderer, const char* pass);
// Writes one command for each draw, with an empty list. There are this many slots for each placement.
void ResetDraws(Renderer& renderer, const SceneIds& scene, DrawList& list, uint32_t slotsPerPlacement);

// Describes a class of triangles that is drawn by one command.
struct DrawClass {
    const char* name;  // "Opaque"
    DrawRange range;
    bool isTested;  // alpha-tested
    bool isCulled;  // back faces are culled
};
using DrawClasses = std::array<DrawClass, kDrawKindCount>;
DrawClasses ClassesOf(const SceneIds& scene);

// A raster camera has no lens.
gpu::TraceParameters RasterParameters(const SceneIds& scene, const TraceSettings& settings);

uint32_t DrawCount(const SceneIds& scene);
// Returns the number of groups of a shader that takes record after record, 64 at once in a group
// (raster/invocation_stride.glsl).
uint32_t GroupsFor(uint32_t count);

// Returns the position in each pixel that a sample draws, from its upper left corner: the center is (0.5,
// 0.5).
glm::vec2 FilmOffset(FilmPosition film, uint32_t sampleIndex);
// Returns the shift in clip units that moves this position to the pixel's center, where it is drawn.
glm::vec2 ClipOffset(const glm::vec2& filmOffset, Extent2D extent);

}  // namespace raygraph::passes
