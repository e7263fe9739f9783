// The width of a path, from which the level of textures follows: a cone about each of its rays.
// Akenine-Moeller, Nilsson, Andersson, Barre-Brisebois, Toth and Karras 2019, "Texture Level of Detail
// Strategies for Real-Time Ray Tracing", Ray Tracing Gems, chapter 20; Akenine-Moeller, Crassin, Boksansky,
// Belcour, Panteleev and Wright 2021, "Improved Shader and Texture Level of Detail Using Ray Cones", JCGT
// 10(1).
//
// Widths are square roots of areas: cross-sections, footprints on a surface and pixels are compared by their
// area, whatever their shape. So a tilted surface counts 1 / sqrt(cosine), between the long and the short
// axis of the footprint: the samples of a pixel, which are spread over it, take care of the long one.
#ifndef RAYGRAPH_CORE_RAY_CONE_GLSL
#define RAYGRAPH_CORE_RAY_CONE_GLSL

#include "core/math.glsl"

SHADING_BEGIN

struct RayCone {
    float width;   // meters, where the ray starts
    float spread;  // meters a meter; negative: it narrows
};

INLINE RayCone MakeCone(float width, float spread) {
    RayCone cone;
    cone.width = width;
    cone.spread = spread;
    return cone;
}

// Returns the cone of a pixel of that width (meters) at distance 1 along the camera's axis, in a direction at
// that cosine to it: its solid angle falls by the cube of the cosine.
INLINE RayCone PerspectiveCone(float pixelWidth, float cosine) {
    return MakeCone(0.0f, pixelWidth * cosine * sqrt(cosine));
}

// Returns the cone farther along the ray. A cone that narrows to a point goes on as one that widens.
INLINE RayCone AdvanceCone(RayCone cone, float distance) {
    float width = cone.width + cone.spread * distance;
    return width < 0.0f ? MakeCone(-width, -cone.spread) : MakeCone(width, cone.spread);
}

// Returns the cone after a reflection at a mean curvature (1/m; positive: convex on the side of the ray). At
// an angle it counts 1 / cosine in one plane and cosine in the other, so that the area sees neither.
INLINE RayCone ReflectCone(RayCone cone, float curvature) {
    return MakeCone(cone.width, cone.spread + 2.0f * curvature * cone.width);
}

// Returns the cone after the refraction at a surface of relative index of refraction eta, near its normal:
// angles to the normal shrink by eta.
INLINE RayCone RefractCone(RayCone cone, float curvature, float eta) {
    float turn = curvature * cone.width;  // turn of the normal over the cone
    return MakeCone(cone.width, (cone.spread + turn) / eta - turn);
}

// A lobe is seen by many paths of a pixel. Each stands for the part of it that this many paths would share,
// by its density: the lobe's own blur becomes wider by an eighth, as variances add. Colbert and Krivanek
// 2007, "GPU-Based Importance Sampling", GPU Gems 3, chapter 20.
CONST float kPathsOfLobe = 4.0f;
CONST float kWidestLobe = 6.283185307179586f;  // sr: a path stands for no more than a part of a hemisphere

// Returns the cone after it was scattered by a lobe in a direction of that density (1/sr).
INLINE RayCone WidenCone(RayCone cone, float pdf) {
    float solidAngle = min(1.0f / (kPathsOfLobe * pdf), kWidestLobe / kPathsOfLobe);
    return MakeCone(cone.width, cone.spread + sqrt(solidAngle));
}

// Returns the mean curvature of a triangle with edges e1 and e2 from its first vertex, by its vertex normals:
// half their divergence. Of unit normals; of any other vectors, in proportion to their length. 0 for a
// sliver.
INLINE float MeanCurvature(vec3 e1, vec3 e2, vec3 n0, vec3 n1, vec3 n2) {
    vec3 normal = cross(e1, e2);
    float inverse = InverseLength(normal);
    normal *= inverse;
    return 0.5f * (dot(n1 - n0, cross(e2, normal)) + dot(n2 - n0, cross(normal, e1))) * inverse;
}

// The area of a cone's footprint on a surface at that cosine to the ray. A grazing one is not infinite.
CONST float kLeastCosine = 1e-4f;
INLINE float FootprintArea(float width, float cosine) {
    return width * width / max(abs(cosine), kLeastCosine);
}

// Returns the level at which a footprint of so many texels of level 0 has one, plus `bias`; no finer than
// level 0. A level has a quarter of the texels of the one before, or half, once the texture is one texel wide
// or high: `side` is its shorter side in texels of level 0.
INLINE float TextureLevel(float texels, float side, float bias) {
    float logTexels = log2(max(texels, 1e-30f));
    return max(max(0.5f * logTexels, logTexels - log2(side)) + bias, 0.0f);
}

SHADING_END

#endif
