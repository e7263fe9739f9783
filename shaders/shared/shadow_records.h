// Shadow maps of punctual lights: one source for C++ and GLSL, scalar layout.
//
// A shadow view is what a light sees in one direction, drawn into one tile of the atlas: a spot has one view,
// a point light six (+x, -x, +y, -y, +z, -z), a directional light kShadowCascades, from near the camera to
// far. Tiles stand in rows from the top left. There is a fixed number of tiles; lights beyond that, or dark
// ones, have no views and cast no shadow.
#ifndef RAYGRAPH_SHARED_SHADOW_RECORDS_H
#define RAYGRAPH_SHARED_SHADOW_RECORDS_H

#include "scene_records.h"

#ifdef __cplusplus
namespace raygraph::gpu {
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_CONSTANT const
#endif

RAYGRAPH_CONSTANT uint kMaxShadowViews = 64u;
RAYGRAPH_CONSTANT uint kShadowCascades = 4u;
RAYGRAPH_CONSTANT uint kShadowFaces = 6u;
RAYGRAPH_CONSTANT uint kShadowMargin = 3u;  // texels around a view, for filters

struct ShadowView {
    CameraRecord camera;  // film and depth as in raster/projection.glsl
    float texel;          // width of a texel in meters: at distance 1, or of an orthographic view
    uint light;           // ordinal among the punctual lights, or kNoLight: the tile is unused
};

// Holds the shadow views of a punctual light, by its ordinal.
struct ShadowLight {
    uint firstView;
    uint viewCount;  // 0: it casts no shadow
};

// Describes a placement and the view that it is drawn into: an element of the list of casters.
struct ShadowCaster {
    uint placement;
    uint view;
};

// Holds the box around all placements that are drawn, as maxima over unsigned numbers that are in the order
// of the floats: of the coordinates, and of their negatives. 0: there are none.
struct SceneBoundsRecord {
    uint negatedMin[3];
    uint max[3];
};

#undef RAYGRAPH_CONSTANT

#ifdef __cplusplus
static_assert(sizeof(ShadowView) == 22 * 4);
static_assert(sizeof(SceneBoundsRecord) == 6 * 4);
}  // namespace raygraph::gpu
#endif

#endif
