// Pictures over pictures: Overlay puts the finished part of a picture over a coarser one of the same view;
// the outline passes draw a line around the visible part of some instances. Threads: that of the Renderer.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <span>

#include "base/api.h"
#include "passes/tiles.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// Takes the pixels that `done` has of `fine`, the others from `coarse`, of any extent, scaled bilinearly.
// All are rgba32f; the picture has the extent of `fine`.
[[nodiscard]] RAYGRAPH_API TextureId Overlay(Renderer& renderer, TextureId coarse, TextureId fine,
                                             const TileCursor& done);

// Scales `coarse`, rgba32f, bilinearly to another extent.
[[nodiscard]] RAYGRAPH_API TextureId Upscale(Renderer& renderer, TextureId coarse, Extent2D extent);

// --- Outlines around the visible part of some instances ---

// Writes to every texel of `line`, r32f of the picture's extent, its coverage by the line: 0 to 1, with
// smooth edges. The line is `width` pixels wide (more than 0, at most 8) and lies outside of the outlined
// part. `hits` is RasterVisibility::hits of the same view, of any extent: a coarser one gives a coarser line.
// `instances` are indices as in SceneData::instances, in any order. Returns the new version of `line`.
[[nodiscard]] RAYGRAPH_API TextureId OutlineInstances(Renderer& renderer, TextureId hits,
                                                      std::span<const uint32_t> instances, TextureId line,
                                                      float width, std::function<void()> onSubmitted = {});

// Draws the line over `picture`, rgba8, in a color of display values. Error{Usage} for other formats or
// extents that differ.
[[nodiscard]] RAYGRAPH_API TextureId DrawOutline(Renderer& renderer, TextureId picture, TextureId line,
                                                 const glm::vec3& color);

}  // namespace raygraph::passes
