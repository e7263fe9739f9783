// Finds the values of vertices and textures at a point of a triangle.
#ifndef RAYGRAPH_SCENE_MATERIAL_TEXTURES_GLSL
#define RAYGRAPH_SCENE_MATERIAL_TEXTURES_GLSL

#include "core/ray_cone.glsl"
#include "core/trace_options.glsl"
#include "scene/bindings.glsl"
#include "shared/choice.h"

SHADING_BEGIN

// With the part of it that is seen, if kTraceTextureLod is set: nothing, that is level 0 of all textures,
// until SurfaceAt says more. Alpha tests and sampled lights stay at level 0: a threshold of a mean is no mean
// of the outcomes, and of a chance the noise does not depend on the level.
struct Triangle {
    uvec3 vertices;
    vec3 weights;
    vec2 uv0, uv1;  // texture coordinates, if WithTexCoords has read them: once for all textures
#ifdef PIXEL_FOOTPRINT
    vec3 weightsAcross, weightsDown;  // from this pixel to the next
#else
    vec2 uvAreas;  // areas of the ray's footprint, in uv0 and uv1
#endif
};

// Index of the GeometryRecord that a triangle belongs to.
INLINE uint GeometryIndex(InstanceRecord instance, uint primitive) {
    uint geometry = instance.firstGeometry;
    if (IsPresent(instance.triangleGeometries))
        geometry += UintStream(instance.triangleGeometries).at[primitive];
    return geometry;
}

// Returns whether the primitives of an instance are capsules.
INLINE bool IsRound(InstanceRecord instance) {
    return HasTraceFeature(kTraceCapsules) && !IsPresent(instance.indices);
}

INLINE CapsuleRecord CapsuleAt(InstanceRecord instance, uint primitive) {
    return CapsuleStream(instance.positions).at[primitive];
}

// Returns the segment of a capsule, as a triangle without a third vertex; `place` takes the place of
// barycentrics. Its textures are read at level 0.
INLINE Triangle SegmentAt(CapsuleRecord capsule, vec2 place) {
    float along = clamp(place.y, 0.0f, 1.0f);
    Triangle segment;
    segment.vertices = uvec3(capsule.first, capsule.second, capsule.second);
    segment.weights = vec3(1.0f - along, along, 0.0f);
#ifdef PIXEL_FOOTPRINT
    segment.weightsAcross = vec3(0.0f);
    segment.weightsDown = vec3(0.0f);
#else
    segment.uvAreas = vec2(0.0f);
#endif
    return segment;
}

INLINE Triangle TriangleAt(InstanceRecord instance, uint primitive, vec2 barycentrics) {
    if (IsRound(instance)) return SegmentAt(CapsuleAt(instance, primitive), barycentrics);
    UintStream indices = UintStream(instance.indices);
    uint first = 3u * primitive;
    Triangle triangle;
    triangle.vertices = uvec3(indices.at[first], indices.at[first + 1u], indices.at[first + 2u]);
    triangle.weights = vec3(1.0f - barycentrics.x - barycentrics.y, barycentrics);
#ifdef PIXEL_FOOTPRINT
    triangle.weightsAcross = vec3(0.0f);
    triangle.weightsDown = vec3(0.0f);
#else
    triangle.uvAreas = vec2(0.0f);
#endif
    return triangle;
}

INLINE vec2 WeightedSumVec2(Vec2Stream values, uvec3 vertices, vec3 weights) {
    return weights.x * values.at[vertices.x] + weights.y * values.at[vertices.y] +
           weights.z * values.at[vertices.z];
}

INLINE vec2 InterpolateVec2(Vec2Stream values, Triangle triangle) {
    return WeightedSumVec2(values, triangle.vertices, triangle.weights);
}

INLINE vec3 InterpolateVec3(Vec3Stream values, Triangle triangle) {
    return triangle.weights.x * values.at[triangle.vertices.x] +
           triangle.weights.y * values.at[triangle.vertices.y] +
           triangle.weights.z * values.at[triangle.vertices.z];
}

INLINE vec4 InterpolateVec4(Vec4Stream values, Triangle triangle) {
    return triangle.weights.x * values.at[triangle.vertices.x] +
           triangle.weights.y * values.at[triangle.vertices.y] +
           triangle.weights.z * values.at[triangle.vertices.z];
}

// 0 in a set that the geometry has not.
INLINE Triangle WithTexCoords(Triangle triangle, GeometryRecord geometry) {
    triangle.uv0 = vec2(0.0f);
    triangle.uv1 = vec2(0.0f);
    if (!HasTraceFeature(kTraceTextures)) return triangle;
    if (IsPresent(geometry.uv0)) triangle.uv0 = InterpolateVec2(Vec2Stream(geometry.uv0), triangle);
    if (IsPresent(geometry.uv1)) triangle.uv1 = InterpolateVec2(Vec2Stream(geometry.uv1), triangle);
    return triangle;
}

// A material's texture of the name as SampleTexture takes it.
#define TEXTURE_OF(material, name) material.name##Texture, material.name##Transform

// Reads a texture, at the level of what the ray or the pixel sees of it.
INLINE vec4 ReadTexture(uint slot, mat3x2 transform, Address stream, vec2 uv, Triangle triangle) {
    uint index = slot & ~kSecondTexCoord;
    if (!HasTraceFeature(kTraceTextureLod)) return textureLod(textures[nonuniformEXT(index)], uv, 0.0f);
#ifdef PIXEL_FOOTPRINT
    vec2 across = vec2(0.0f), down = vec2(0.0f);
    if (IsPresent(stream)) {
        across = WeightedSumVec2(Vec2Stream(stream), triangle.vertices, triangle.weightsAcross);
        down = WeightedSumVec2(Vec2Stream(stream), triangle.vertices, triangle.weightsDown);
    }
    if (HasTraceFeature(kTraceTextureTransforms)) {
        across = transform * vec3(across, 0.0f);
        down = transform * vec3(down, 0.0f);
    }
    return textureGrad(textures[nonuniformEXT(index)], uv, across, down);
#else
    float area = (slot & kSecondTexCoord) != 0u ? triangle.uvAreas.y : triangle.uvAreas.x;
    if (HasTraceFeature(kTraceTextureTransforms))
        area *= abs(transform[0].x * transform[1].y - transform[0].y * transform[1].x);
    vec2 size = vec2(textureSize(textures[nonuniformEXT(index)], 0));
    float level = TextureLevel(area * size.x * size.y, min(size.x, size.y), parameters.value.textureLod);
    return textureLod(textures[nonuniformEXT(index)], uv, level);
#endif
}

// Samples a texture of a material at the triangle's texture coordinates; returns white where it has none.
INLINE vec4 SampleTexture(uint slot, mat3x2 transform, GeometryRecord geometry, Triangle triangle) {
    if (!HasTraceFeature(kTraceTextures) || slot == kNoTexture) return vec4(1.0f);
    bool isSecond = (slot & kSecondTexCoord) != 0u;
    Address stream = isSecond ? geometry.uv1 : geometry.uv0;
    vec2 uv = isSecond ? triangle.uv1 : triangle.uv0;
    if (HasTraceFeature(kTraceTextureTransforms)) uv = transform * vec3(uv, 1.0f);
    return ReadTexture(slot, transform, stream, uv, triangle);
}

INLINE vec4 BaseColor(GeometryRecord geometry, MaterialRecord material, Triangle triangle) {
    vec4 color = material.baseColor * SampleTexture(TEXTURE_OF(material, baseColor), geometry, triangle);
    if (HasTraceFeature(kTraceVertexColors) && IsPresent(geometry.colors))
        color *= InterpolateVec4(Vec4Stream(geometry.colors), triangle);
    return color;
}

// Returns the share of rays that a surface stops.
INLINE float Opacity(GeometryRecord geometry, MaterialRecord material, Triangle triangle) {
    if (material.alphaMode == kAlphaOpaque) return 1.0f;
    float alpha = BaseColor(geometry, material, triangle).w;
    return material.alphaMode == kAlphaMask ? float(alpha >= material.alphaCutoff) : alpha;
}

// Radiance that a surface emits.
INLINE vec3 EmissionAt(GeometryRecord geometry, MaterialRecord material, Triangle triangle) {
    vec3 emission = material.emission;
    if (material.emissiveTexture != kNoTexture)
        emission *= vec3(SampleTexture(TEXTURE_OF(material, emissive), geometry, triangle));
    return emission;
}

SHADING_END

#endif
