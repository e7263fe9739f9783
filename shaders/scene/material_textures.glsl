// From a triangle to the values of its vertices and textures.
#ifndef RAYGRAPH_SCENE_MATERIAL_TEXTURES_GLSL
#define RAYGRAPH_SCENE_MATERIAL_TEXTURES_GLSL

#include "core/trace_options.glsl"
#include "scene/bindings.glsl"
#include "shared/alpha_modes.h"

struct Triangle {
    uvec3 vertices;
    vec3 weights;
};

// Index of the GeometryRecord that a triangle belongs to.
uint GeometryIndex(InstanceRecord instance, uint primitive) {
    uint geometry = instance.firstGeometry;
    if (IsPresent(instance.triangleGeometries))
        geometry += UintStream(instance.triangleGeometries).at[primitive];
    return geometry;
}

Triangle TriangleAt(InstanceRecord instance, uint primitive, vec2 barycentrics) {
    UintStream indices = UintStream(instance.indices);
    uint first = 3u * primitive;
    Triangle triangle;
    triangle.vertices = uvec3(indices.at[first], indices.at[first + 1u], indices.at[first + 2u]);
    triangle.weights = vec3(1.0f - barycentrics.x - barycentrics.y, barycentrics);
    return triangle;
}

vec2 InterpolateVec2(Vec2Stream values, Triangle triangle) {
    return triangle.weights.x * values.at[triangle.vertices.x] +
           triangle.weights.y * values.at[triangle.vertices.y] +
           triangle.weights.z * values.at[triangle.vertices.z];
}

vec3 InterpolateVec3(Vec3Stream values, Triangle triangle) {
    return triangle.weights.x * values.at[triangle.vertices.x] +
           triangle.weights.y * values.at[triangle.vertices.y] +
           triangle.weights.z * values.at[triangle.vertices.z];
}

vec4 InterpolateVec4(Vec4Stream values, Triangle triangle) {
    return triangle.weights.x * values.at[triangle.vertices.x] +
           triangle.weights.y * values.at[triangle.vertices.y] +
           triangle.weights.z * values.at[triangle.vertices.z];
}

// A material's texture of the name as SampleTexture takes it.
#define TEXTURE_OF(material, name) material.name##Texture, material.name##Transform

// One texture of a material; white where it has none.
vec4 SampleTexture(uint slot, mat3x2 transform, GeometryRecord geometry, Triangle triangle) {
    if (!HasTraceFeature(kTraceTextures) || slot == kNoTexture) return vec4(1.0f);
    uvec2 stream = (slot & kSecondTexCoord) != 0u ? geometry.uv1 : geometry.uv0;
    vec2 uv = IsPresent(stream) ? InterpolateVec2(Vec2Stream(stream), triangle) : vec2(0.0f);
    if (HasTraceFeature(kTraceTextureTransforms)) uv = transform * vec3(uv, 1.0f);
    return textureLod(textures[nonuniformEXT(slot & ~kSecondTexCoord)], uv, 0.0f);
}

vec4 BaseColor(GeometryRecord geometry, MaterialRecord material, Triangle triangle) {
    vec4 color = material.baseColor * SampleTexture(TEXTURE_OF(material, baseColor), geometry, triangle);
    if (IsPresent(geometry.colors)) color *= InterpolateVec4(Vec4Stream(geometry.colors), triangle);
    return color;
}

// Share of rays that a surface stops.
float Opacity(GeometryRecord geometry, MaterialRecord material, Triangle triangle) {
    if (material.alphaMode == kAlphaOpaque) return 1.0f;
    float alpha = BaseColor(geometry, material, triangle).w;
    return material.alphaMode == kAlphaMask ? float(alpha >= material.alphaCutoff) : alpha;
}

// Radiance that a surface emits.
vec3 EmissionAt(GeometryRecord geometry, MaterialRecord material, Triangle triangle) {
    vec3 emission = material.emission;
    if (material.emissiveTexture != kNoTexture)
        emission *= SampleTexture(TEXTURE_OF(material, emissive), geometry, triangle).xyz;
    return emission;
}

#endif
