// The any-hit test: whether a ray hits a surface that is alpha-tested, or whose back faces are culled in a
// group where others' are not.
#ifndef RAYGRAPH_SCENE_ALPHA_TEST_GLSL
#define RAYGRAPH_SCENE_ALPHA_TEST_GLSL

#include "core/rng.glsl"
#include "scene/material_textures.glsl"

SHADING_BEGIN

// Materials whose back faces are culled, as IsBackCulled of renderer/scene.
INLINE bool IsBackCulled(MaterialRecord material) {
    return (material.flags & kMaterialTwoSided) == 0u;
}

// Hit kinds of triangles are 0xFE and 0xFF; those of capsules (capsule.rint) likewise tell sides by the
// last bit.
INLINE bool IsBackFaceHit(uint hitKind) { return (hitKind & 1u) != 0u; }

// The alpha seed of rays that BLEND surfaces stop where they are rather opaque, instead of by chance.
CONST uint kAlphaSeedOfMost = 0xFFFFFFFFu;

// BLEND is stochastic: of many rays, the share alpha is stopped. The same ray gets the same result however
// often the device runs any-hit. `isBack`: the ray hits the back face.
INLINE bool StopsRay(uint alphaSeed, uint instanceIndex, uint primitive, vec2 barycentrics, bool isBack) {
    InstanceRecord instance = InstanceAt(instanceIndex);
    GeometryRecord geometry = geometries.at[GeometryIndex(instance, primitive)];
    MaterialRecord material = materials.at[geometry.material];
    if (isBack && IsBackCulled(material)) return false;
    Triangle triangle = WithTexCoords(TriangleAt(instance, primitive, barycentrics), geometry);
    float opacity = Opacity(geometry, material, triangle);
    // The two sides of a capsule are one primitive, but stop light independently
    uint number = instanceIndex * 0x9e3779b9u + primitive;
    if (IsRound(instance) && isBack) number = ~number;
    float threshold = alphaSeed == kAlphaSeedOfMost ? 0.5f : AlphaTestSample(alphaSeed, number);
    return threshold < opacity;
}

SHADING_END

#endif
