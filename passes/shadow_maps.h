// ShadowMaps: depth maps of the punctual lights, for raster views. Threads: that of the Renderer.
#pragma once

#include "base/api.h"
#include "passes/trace.h"

namespace raygraph::passes {

struct ShadowMapSettings {
    uint32_t atlasSize = 4096;  // texels a side, for all lights together; 4 bytes each
};

struct ShadowMapIds {
    TextureId atlas;  // d32f, reversed, in square tiles
    BufferId views;   // gpu::ShadowView[], one a tile
    BufferId lights;  // gpu::ShadowLight[], one a punctual light
    uint32_t tilesPerSide = 0;
};

// Draws the scene once for each view of each light, see shaders/shared/shadow_records.h: all views of a class
// of triangles by one indirect draw, of the placements that are in each view. The atlas is divided evenly: up
// to gpu::kMaxShadowViews tiles, and the fewer lights there are, the larger their tiles. Lights get theirs in
// the scene's order; the device decides which get none, and those cast no shadow. Cascades cover the part of
// the scene that `settings.camera` sees; their size stays and they move in whole texels when the camera moves
// or turns a little. Faces are culled as for shadow rays; MASK and BLEND decide by settings.seed and
// sampleIndex. Surfaces nearer to a point light or spot than 1e-4 of the scene's size cast no shadow.
// Error{Usage} on a device without drawIndirectFirstInstance, and for an atlas of no texels.
[[nodiscard]] RAYGRAPH_API ShadowMapIds DrawShadowMaps(Renderer& renderer, const SceneIds& scene,
                                                       const TraceSettings& settings,
                                                       const ShadowMapSettings& shadows = {});

}  // namespace raygraph::passes
