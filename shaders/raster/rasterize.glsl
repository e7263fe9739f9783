// Draws triangles into a buffer of 64-bit keys: depth in the high bits, the triangle's number in the low
// bits, so that the maximum is the nearest.
#ifndef RAYGRAPH_RASTER_RASTERIZE_GLSL
#define RAYGRAPH_RASTER_RASTERIZE_GLSL

#include "raster/chunks.glsl"
#include "raster/triangle.glsl"
#include "scene/alpha_test.glsl"

layout(constant_id = 32) const uint kDrawn = kDrawnAlpha | kDrawnGlass;

layout(set = 0, binding = 19, scalar) buffer Nearest { uint64_t at[]; } nearest;
layout(push_constant, scalar) uniform Constants {
    vec2 shift;
    uvec2 size;         // size of the picture, in pixels
    uint drawCount;
    uint firstOfKind[4];  // draws, by DrawKind
} constants;

// Describes a triangle to draw.
struct Drawing {
    uint number;
    DrawnTriangle source;
    PictureTriangle picture;
    bool isCulled;  // back faces are culled
    bool isTested;  // alpha-tested
};

// Returns false if no part of it can be visible.
bool PrepareDrawing(uint number, mat4 offsetToPicture, out Drawing drawing) {
    drawing.number = number;
    if (!FindTriangle(number, constants.drawCount, drawing.source)) return false;
    uint draw = drawing.source.draw;
    drawing.isTested = draw >= constants.firstOfKind[2];
    drawing.isCulled = draw < constants.firstOfKind[drawing.isTested ? 3 : 1];
    if ((kDrawn & kDrawnGlass) == 0u) {
        uint geometry = GeometryIndex(instances.at[drawing.source.placement], drawing.source.primitive);
        if ((materials.at[geometries.at[geometry].material].flags & kMaterialGlass) != 0u) return false;
    }
    drawing.picture = ProjectTriangle(drawing.source.placement, drawing.source.primitive,
                                      parameters.value.camera.origin, offsetToPicture);
    return true;
}

void DrawPixel(Drawing drawing, ivec2 pixel) {
    vec3 edges;
    float depth;
    if (!CoversPixelCenter(drawing.picture, vec2(pixel) + 0.5f, drawing.isCulled, edges, depth)) return;
    uint place = uint(pixel.y) * constants.size.x + uint(pixel.x);
    uint64_t key = packUint2x32(uvec2(drawing.number, floatBitsToUint(depth)));
    if ((kDrawn & kDrawnAlpha) != 0u && drawing.isTested) {
        if (nearest.at[place] >= key) return;
        TraceParameters settings = parameters.value;
        Sampler rng = StartPixelSample(uvec2(pixel), settings.sampleIndex, settings.seed);
        if (!StopsRay(AlphaSeed(rng, 1u), drawing.source.placement, drawing.source.primitive,
                     BarycentricsOf(edges), max(max(edges.x, edges.y), edges.z) > 0.0f))
            return;
    }
    atomicMax(nearest.at[place], key);
}

#endif
