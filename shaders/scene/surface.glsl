// From a hit to a surface: fetches vertices, interpolates, evaluates the material's inputs.
#ifndef RAYGRAPH_SCENE_SURFACE_GLSL
#define RAYGRAPH_SCENE_SURFACE_GLSL

#include "scene/bindings.glsl"
#include "scene/ray.glsl"

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

Triangle TriangleAt(InstanceRecord instance, Hit hit) {
    UintStream indices = UintStream(instance.indices);
    uint first = 3u * hit.primitive;
    Triangle triangle;
    triangle.vertices = uvec3(indices.at[first], indices.at[first + 1u], indices.at[first + 2u]);
    triangle.weights = vec3(1.0f - hit.barycentrics.x - hit.barycentrics.y, hit.barycentrics);
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

// One texture of a material; white where it has none.
vec4 SampleTexture(uint slot, GeometryRecord geometry, Triangle triangle) {
    if (slot == kNoTexture) return vec4(1.0f);
    uvec2 stream = (slot & kSecondTexCoord) != 0u ? geometry.uv1 : geometry.uv0;
    vec2 uv = IsPresent(stream) ? InterpolateVec2(Vec2Stream(stream), triangle) : vec2(0.0f);
    return textureLod(textures[nonuniformEXT(slot & ~kSecondTexCoord)], uv, 0.0f);
}

// Carries an object-space normal to world space by the cofactors of the transform, which are its inverse
// transpose times the determinant: a mirroring transform must not turn the side.
vec3 NormalToWorld(mat4x3 objectToWorld, vec3 normal) {
    vec3 x = objectToWorld[0];
    vec3 y = objectToWorld[1];
    vec3 z = objectToWorld[2];
    vec3 yz = cross(y, z);
    vec3 result = normal.x * yz + normal.y * cross(z, x) + normal.z * cross(x, y);
    return dot(x, yz) < 0.0f ? -result : result;
}

vec4 BaseColor(GeometryRecord geometry, MaterialRecord material, Triangle triangle) {
    vec4 color = material.baseColor * SampleTexture(material.baseColorTexture, geometry, triangle);
    if (IsPresent(geometry.colors)) color *= InterpolateVec4(Vec4Stream(geometry.colors), triangle);
    return color;
}

// `ray` is the ray that found the hit.
SurfaceInteraction SurfaceAt(Hit hit, Ray ray) {
    InstanceRecord instance = instances.at[hit.instance];
    GeometryRecord geometry = geometries.at[GeometryIndex(instance, hit.primitive)];
    Triangle triangle = TriangleAt(instance, hit);

    // Position from the vertices: its error does not grow with the ray's length
    Vec3Stream positions = Vec3Stream(instance.positions);
    vec3 p0 = positions.at[triangle.vertices.x];
    vec3 e1 = positions.at[triangle.vertices.y] - p0;
    vec3 e2 = positions.at[triangle.vertices.z] - p0;
    vec3 p = p0 + triangle.weights.y * e1 + triangle.weights.z * e2;
    SurfaceInteraction surface;
    surface.position = instance.objectToWorld * vec4(p, 1.0f);

    // Normals, on the side the ray came from
    vec3 ng = NormalToWorld(instance.objectToWorld, cross(e1, e2));
    float ngSquare = dot(ng, ng);
    ng = ngSquare > 0.0f ? ng * inversesqrt(ngSquare) : -ray.direction;  // a sliver has no normal of its own
    vec3 ns = ng;
    if (IsPresent(geometry.normals)) {
        vec3 n =
            NormalToWorld(instance.objectToWorld, InterpolateVec3(Vec3Stream(geometry.normals), triangle));
        float square = dot(n, n);
        if (square > 0.0f) ns = n * inversesqrt(square);
    }
    if (dot(ng, ray.direction) > 0.0f) {
        ng = -ng;
        ns = -ns;
    }
    // A shading normal that faces away would put the viewer below the surface
    surface.geometricNormal = ng;
    surface.shadingNormal = dot(ns, ray.direction) < 0.0f ? ns : ng;

    MaterialRecord material = materials.at[geometry.material];
    surface.albedo = BaseColor(geometry, material, triangle).xyz;
    surface.emission = material.emission;
    if (material.emissiveTexture != kNoTexture)
        surface.emission *= SampleTexture(material.emissiveTexture, geometry, triangle).xyz;
    return surface;
}

#endif
