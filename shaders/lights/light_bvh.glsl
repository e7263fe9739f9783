// Sampling of a bounded light by a tree over position and orientation. A. Conty Estevez and C. Kulla 2018,
// "Importance Sampling of Many Lights with Adaptive Tree Splitting", without the splitting, with the bounds
// on the cosines that pbrt-v4's BVHLightSampler uses.
//
// The bridge, declared by the includer: LightNode LightNodeAt(uint node).
#ifndef RAYGRAPH_LIGHTS_LIGHT_BVH_GLSL
#define RAYGRAPH_LIGHTS_LIGHT_BVH_GLSL

#include "lights/light_types.glsl"

SHADING_BEGIN

struct ChosenLight {
    uint light;
    float probability;  // 0: none
};

INLINE ChosenLight NoChosenLight() {
    ChosenLight result;
    result.light = kNoLight;
    result.probability = 0.0f;
    return result;
}

CONST float kUnitStep = 5.9604644775390625e-8f;  // between random numbers: 2^-24

// Returns a light by an alias table of `count` entries from `first`; u chooses the slot, `choice` whether it
// is kept. The remainders of both are uniform; that of `choice` has all its digits, since those that the
// decision takes are filled up from the remainder of u.
INLINE ChosenLight SampleLightAlias(uint first, uint count, INOUT(float) u, INOUT(float) choice) {
    uint slot = ChooseUniformly(u, count);
    AliasEntry entry = LightAliasAt(first + slot);
    float share = entry.keep;
    if (!SampleBernoulli(choice, entry.keep)) {
        share = 1.0f - entry.keep;
        slot = entry.alias;
        entry = LightAliasAt(first + slot);
    }
    if (share < 1.0f) choice = min(choice + u * min(kUnitStep / share, 1.0f - choice), kOneMinusEpsilon);
    ChosenLight result;
    result.light = slot;
    result.probability = entry.probability;
    return result;
}

// Returns cos and sin of max(0, a - b), from cos and sin of a and b in [0, pi].
INLINE vec2 SubtractAngleClamped(vec2 a, vec2 b) {
    if (a.x > b.x) return vec2(1.0f, 0.0f);
    return vec2(a.x * b.x + a.y * b.y, a.y * b.x - a.x * b.y);
}

// Returns the importance of a node: an upper bound, up to a factor, of what the lights below it may
// contribute to a context; 0 only if that is nothing.
INLINE float Importance(LightNode node, LightContext context) {
    vec3 center = 0.5f * (node.boundsMin + node.boundsMax);
    vec3 halfSize = 0.5f * (node.boundsMax - node.boundsMin);
    float radius2 = dot(halfSize, halfSize);
    vec3 toContext = context.position - center;
    float distance2 = dot(toContext, toContext);
    // No part of the box is above the plane.
    if (dot(halfSize, abs(context.normal)) < dot(toContext, context.normal)) return 0.0f;
    // Inside the bounding sphere lights may be in any direction
    if (distance2 <= radius2) return radius2 > 0.0f ? node.power / radius2 : 0.0f;

    vec3 w = toContext / sqrt(distance2);
    float sinBounds2 = radius2 / distance2;
    vec2 bounds = vec2(SafeSqrt(1.0f - sinBounds2), sqrt(sinBounds2));
    // This is the least angle between the emission of a light below and the way to the context
    float cosAxis = dot(node.axis, w);
    if ((node.link & kLightNodeTwoSided) != 0u) cosAxis = abs(cosAxis);
    vec2 cones = unpackSnorm2x16(node.cones);
    vec2 angle = vec2(cosAxis, SafeSqrt(1.0f - cosAxis * cosAxis));
    angle = SubtractAngleClamped(angle, vec2(cones.x, SafeSqrt(1.0f - cones.x * cones.x)));
    angle = SubtractAngleClamped(angle, bounds);
    if (angle.x <= cones.y) return 0.0f;
    float importance = node.power * angle.x / distance2;

    // This is the least angle of incidence
    if (dot(context.normal, context.normal) > 0.0f) {
        float cosNormal = -dot(context.normal, w);
        vec2 incidence = vec2(cosNormal, SafeSqrt(1.0f - cosNormal * cosNormal));
        importance *= SubtractAngleClamped(incidence, bounds).x;
    }
    return max(importance, 0.0f);
}

// Returns the probability of the first of two children, which are adjacent from `first`; negative: neither
// can contribute.
INLINE float FirstChildProbability(uint first, LightContext context) {
    float importance0 = 0.0f;
    float importance1 = 0.0f;
    DONT_UNROLL
    for (uint child = 0u; child < 2u; ++child) {
        float importance = Importance(LightNodeAt(first + child), context);
        if (child == 0u)
            importance0 = importance;
        else
            importance1 = importance;
    }
    float sum = importance0 + importance1;
    return sum > 0.0f ? importance0 / sum : -1.0f;
}

// Chooses a light of the tree from the node `root`. u decides at each node, and its remainder is uniform. A
// single light is chosen whether or not it can contribute.
INLINE ChosenLight SampleLightTree(uint root, LightContext context, INOUT(float) u) {
    LightNode node = LightNodeAt(root);
    ChosenLight result = NoChosenLight();
    float probability = 1.0f;
    while ((node.link & kLightNodeLeaf) == 0u) {
        uint first = node.link & kLightNodeIndex;
        float p = FirstChildProbability(first, context);
        if (p < 0.0f) return result;
        bool isFirst = SampleBernoulli(u, p);
        probability *= isFirst ? p : 1.0f - p;
        node = LightNodeAt(isFirst ? first : first + 1u);
    }
    result.light = node.link & kLightNodeIndex;
    result.probability = probability;
    return result;
}

// Returns the probability with which SampleLightTree chooses the light of a bit trail.
INLINE float LightTreeProbability(uint root, LightContext context, uint bitTrail) {
    LightNode node = LightNodeAt(root);
    float probability = 1.0f;
    while ((node.link & kLightNodeLeaf) == 0u) {
        uint first = node.link & kLightNodeIndex;
        float p = FirstChildProbability(first, context);
        bool isFirst = (bitTrail & 1u) == 0u;
        probability *= p < 0.0f ? 0.0f : (isFirst ? p : 1.0f - p);
        if (probability == 0.0f) return 0.0f;
        node = LightNodeAt(isFirst ? first : first + 1u);
        bitTrail >>= 1u;
    }
    return probability;
}

SHADING_END

#endif
