// The views of a scene, named once. To add a view, add a line to the list: the command line, the passes of
// passes/views.h and their tests take it from here.
//   C++:  raygraph::passes::View::Normals, passes::Name(View::RayCost) == "ray-cost"
//   GLSL: kViewNormals
#ifndef RAYGRAPH_SHARED_VIEWS_H
#define RAYGRAPH_SHARED_VIEWS_H

#include "choice.h"

// PathTraced, Raster: light, as radiance. The others are values that PaintView maps to colors:
//   Albedo:     base color
//   Normals:    shading normal, world space
//   Roughness:  perceptual
//   Metallic
//   Emissive:   radiance that the surface emits
//   Depth:      distance along the camera's forward, meters
//   Instance, Material: the scene's indices; exact below 2^24
//   Wireframe:  x: how much of the pixel an edge covers,
//               y: cosine between the normal and the way to the camera
//   Overdraw:   surfaces drawn in the pixel, hidden ones included
//   RayCost:    rays that the pixel's path took, shadow rays included
// clang-format off
#define RAYGRAPH_VIEWS(X, Of)                                  \
    X(Of, PathTraced, 0, "path-traced", "")                    \
    X(Of, Raster, 1, "raster", "drawn and lit directly")       \
    X(Of, Albedo, 2, "albedo", "")                             \
    X(Of, Normals, 3, "normals", "")                           \
    X(Of, Roughness, 4, "roughness", "")                       \
    X(Of, Metallic, 5, "metallic", "")                         \
    X(Of, Emissive, 6, "emissive", "")                         \
    X(Of, Depth, 7, "depth", "")                               \
    X(Of, Instance, 8, "instance", "")                         \
    X(Of, Material, 9, "material", "")                         \
    X(Of, Wireframe, 10, "wireframe", "")                      \
    X(Of, Overdraw, 11, "overdraw", "")                        \
    X(Of, RayCost, 12, "ray-cost", "")
// clang-format on

#ifdef __cplusplus
namespace raygraph::passes {
RAYGRAPH_CHOICE(View, RAYGRAPH_VIEWS)
}  // namespace raygraph::passes
#else
RAYGRAPH_CHOICE_CONSTANTS(View, RAYGRAPH_VIEWS)
#endif

#endif
