// SurfaceView: one property of the visible surface of each pixel (shared/choice.h). Alpha is 1 where there is
// a surface; all channels are 0 where there is none.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/pixel.glsl"
#include "scene/surface.glsl"

#include "shared/choice.h"

layout(set = 0, binding = 16, rgba32f) writeonly uniform image2D values;

const float kEdgeWidth = 1.2f;  // pixels

// Weights of the triangle's second and third vertex where a ray meets its plane.
vec2 WeightsOf(Ray ray, vec3 p0, vec3 e1, vec3 e2) {
    vec3 across = cross(ray.direction, e2);
    float determinant = dot(e1, across);
    float scale = determinant != 0.0f ? 1.0f / determinant : 0.0f;
    vec3 offset = ray.origin - p0;
    return scale * vec2(dot(offset, across), dot(ray.direction, cross(offset, e1)));
}

// Coverage of the pixel by the edges of its triangle: each weight falls to 0 at one edge, and how fast it
// does from pixel to pixel tells how far that edge is. Round primitives have none.
float EdgeCoverage(Hit hit) {
    InstanceRecord instance = instances.at[hit.instance];
    if (IsRound(instance)) return 0.0f;
    Triangle triangle = TriangleAt(instance, hit.primitive, hit.barycentrics);
    Vec3Stream positions = Vec3Stream(instance.positions);
    vec3 p0 = instance.objectToWorld * vec4(positions.at[triangle.vertices.x], 1.0f);
    vec3 e1 = instance.objectToWorld * vec4(positions.at[triangle.vertices.y], 1.0f) - p0;
    vec3 e2 = instance.objectToWorld * vec4(positions.at[triangle.vertices.z], 1.0f) - p0;
    vec2 here = WeightsOf(RayThrough(vec2(0.0f)), p0, e1, e2);
    vec2 alongX = WeightsOf(RayThrough(vec2(1.0f, 0.0f)), p0, e1, e2) - here;
    vec2 alongY = WeightsOf(RayThrough(vec2(0.0f, 1.0f)), p0, e1, e2) - here;
    vec3 weights = vec3(1.0f - here.x - here.y, here);
    vec3 slopeX = vec3(-alongX.x - alongX.y, alongX);
    vec3 slopeY = vec3(-alongY.x - alongY.y, alongY);
    vec3 distances = abs(weights) * inversesqrt(max(slopeX * slopeX + slopeY * slopeY, vec3(1e-20f)));
    float nearest = min(distances.x, min(distances.y, distances.z));
    return clamp(0.5f * kEdgeWidth + 0.5f - nearest, 0.0f, 1.0f);
}

vec3 ValueOf(Hit hit, Ray ray) {
    SurfaceInteraction surface = SurfaceAt(hit, ray);
    switch (constants.option) {
        case kViewAlbedo:
            return surface.material.baseColor;
        case kViewNormals:
            return surface.shadingNormal;
        case kViewRoughness:
            return vec3(surface.material.roughness);
        case kViewMetallic:
            return vec3(surface.material.metallic);
        case kViewEmissive:
            return surface.emission;
        case kViewDepth: {
            CameraRecord camera = parameters.value.camera;
            return vec3(dot(surface.position - camera.origin, camera.forward));
        }
        case kViewInstance:
            return vec3(float(instances.at[hit.instance].instance));
        case kViewMaterial:
            return vec3(float(surface.material.id));
        case kViewWireframe:
            return vec3(EdgeCoverage(hit), abs(dot(surface.geometricNormal, ray.direction)), 0.0f);
    }
    return vec3(0.0f);
}

void main() {
    if (!IsInPicture()) return;
    Hit hit = PixelHit();
    vec4 value = vec4(0.0f);
    if (IsHit(hit)) value = vec4(ValueOf(hit, PixelRay()), 1.0f);
    imageStore(values, Pixel(), value);
}
