// ShadowMaps: what the punctual lights see, for raster views. Threads: that of the Renderer.
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
// of triangles by one indirect draw, of the placements that are in each view. The atlas is shared out evenly:
// up to gpu::kMaxShadowViews tiles, and the fewer lights there are, the larger their tiles. Lights get theirs
// in the scene's order; which get none is decided on the device, and those cast no shadow. Cascades cover
// what `settings.camera` sees of the scene; their size stays and they move in whole texels when the camera
// moves or turns a little. Faces are culled as shadow rays cull them; MASK and BLEND are there by
// settings.seed and sampleIndex. What is nearer to a point light or spot than 1e-4 of the scene's size casts
// no shadow. Error{Usage} on a device without drawIndirectFirstInstance, and for an atlas of no texels.
[[nodiscard]] RAYGRAPH_API ShadowMapIds DrawShadowMaps(Renderer& renderer, const SceneIds& scene,
                                                       const TraceSettings& settings,
                                                       const ShadowMapSettings& shadows = {});

}  // namespace raygraph::passes
