// The footprint of a pixel on its triangle, for passes over pixels: the derivatives of the weights of its
// vertices, and by them those of texture coordinates. Neighbors see other triangles: their differences would
// not do. Included before scene/surface.glsl.
#ifndef RAYGRAPH_RASTER_PIXEL_FOOTPRINT_GLSL
#define RAYGRAPH_RASTER_PIXEL_FOOTPRINT_GLSL

#define PIXEL_FOOTPRINT

#include "raster/pixel.glsl"
#include "scene/material_textures.glsl"

// Returns the change of the weights of the second and third vertex where the ray meets the triangle's plane,
// for a change of the ray's origin and direction: the derivative of the solution by Cramer's rule (Moeller
// and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection").
vec2 WeightChange(vec3 direction, vec3 originChange, vec3 directionChange, vec3 offset, vec3 e1, vec3 e2,
                  vec2 weights) {
    float determinant = dot(e1, cross(direction, e2));
    if (determinant == 0.0f) return vec2(0.0f);
    float determinantChange = dot(e1, cross(directionChange, e2));
    vec2 change;
    change.x = dot(originChange, cross(direction, e2)) + dot(offset, cross(directionChange, e2));
    change.y = dot(directionChange, cross(offset, e1)) + dot(direction, cross(originChange, e1));
    return (change - weights * determinantChange) / determinant;
}

// Used with kTraceTextureLod, like the footprint of a ray's cone in scene/surface.glsl.
void FindFootprint(inout Triangle triangle, InstanceRecord instance, GeometryRecord geometry, vec3 p0,
                   vec3 e1, vec3 e2, Ray ray, float t) {
    CameraRecord camera = parameters.value.camera;
    mat3 toWorld = mat3(instance.objectToWorld);
    e1 = toWorld * e1;
    e2 = toWorld * e2;
    vec3 offset = ray.origin - (toWorld * p0 + instance.objectToWorld[3]);
    vec2 pixel = 2.0f / vec2(imageSize(visibility));
    bool isParallel = camera.orthographic != 0u;
    // In perspective, the direction has length 1 along forward, and is linear in the position in the picture.
    vec3 direction = isParallel ? ray.direction : ray.direction / dot(ray.direction, camera.forward);
    vec3 steps[2] = {pixel.x * camera.right, -pixel.y * camera.up};
    vec2 changes[2];
    for (int i = 0; i < 2; ++i)
        changes[i] = WeightChange(direction, isParallel ? steps[i] : vec3(0.0f),
                                  isParallel ? vec3(0.0f) : steps[i], offset, e1, e2, triangle.weights.yz);
    triangle.weightsAcross = vec3(-changes[0].x - changes[0].y, changes[0]);
    triangle.weightsDown = vec3(-changes[1].x - changes[1].y, changes[1]);
}

#endif
