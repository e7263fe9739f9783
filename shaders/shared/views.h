// What a picture of the scene can show, named once. To add a view, add a line to the list: the command line,
// the passes of passes/views.h and their tests take it from here.
//   C++:  raygraph::passes::View::Normals, passes::Name(View::RayCost) == "ray-cost"
//   GLSL: kViewNormals
#ifndef RAYGRAPH_SHARED_VIEWS_H
#define RAYGRAPH_SHARED_VIEWS_H

// PathTraced, Raster: light, as radiance. The others are values that PaintView makes visible:
//   Albedo:     base colour
//   Normals:    shading normal, world space
//   Roughness:  perceptual
//   Metallic
//   Emissive:   radiance that the surface emits
//   Depth:      distance along the camera's forward, metres
//   Instance, Material: the scene's indices; exact below 2^24
//   Wireframe:  x: how much of the pixel an edge covers,
//               y: cosine between the normal and the way to the camera
//   Overdraw:   surfaces drawn in the pixel, hidden ones included
//   RayCost:    rays that the pixel's path took, shadow rays included
// clang-format off
#define RAYGRAPH_VIEWS(X) \
    X(PathTraced, 0)      \
    X(Raster, 1)          \
    X(Albedo, 2)          \
    X(Normals, 3)         \
    X(Roughness, 4)       \
    X(Metallic, 5)        \
    X(Emissive, 6)        \
    X(Depth, 7)           \
    X(Instance, 8)        \
    X(Material, 9)        \
    X(Wireframe, 10)      \
    X(Overdraw, 11)       \
    X(RayCost, 12)
// clang-format on

#ifndef __cplusplus
#define RAYGRAPH_DECLARE_VIEW(name, value) const uint kView##name = value;
RAYGRAPH_VIEWS(RAYGRAPH_DECLARE_VIEW)
#undef RAYGRAPH_DECLARE_VIEW
#endif

#endif
