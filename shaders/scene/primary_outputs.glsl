// The outputs of PrimaryHits and RasterHits for the hit of a camera ray.
#ifndef RAYGRAPH_SCENE_PRIMARY_OUTPUTS_GLSL
#define RAYGRAPH_SCENE_PRIMARY_OUTPUTS_GLSL

#include "scene/surface.glsl"

layout(set = 0, binding = 16, rgba32f) writeonly uniform image2D albedo;
layout(set = 0, binding = 17, rgba32f) writeonly uniform image2D normal;
layout(set = 0, binding = 18, rgba32f) writeonly uniform image2D position;
layout(set = 0, binding = 19, rgba32ui) writeonly uniform uimage2D ids;

void StorePrimaryHit(ivec2 pixel, Hit hit, Ray ray) {
    vec4 outAlbedo = vec4(0.0f);
    vec4 outNormal = vec4(0.0f);
    float infinity = uintBitsToFloat(0x7f800000u);
    vec4 outPosition = vec4(infinity);
    uvec4 outIds = uvec4(0xFFFFFFFFu);
    if (IsHit(hit)) {
        SurfaceInteraction surface = SurfaceAt(hit, ray);
        InstanceRecord instance = InstanceAt(hit.instance);
        uint geometryIndex = GeometryIndex(instance, hit.primitive);
        GeometryRecord geometry = geometries.at[geometryIndex];
        float depth = dot(surface.position - parameters.value.camera.origin, parameters.value.camera.forward);
        uint primitive = hit.primitive;
        if (IsPresent(geometry.primitives)) primitive = UintStream(geometry.primitives).at[primitive];
        outAlbedo = vec4(surface.material.baseColor, 1.0f);
        outNormal = vec4(surface.shadingNormal, 0.0f);
        outPosition = vec4(surface.position + parameters.value.sceneOrigin, depth);
        outIds = uvec4(instance.instance, geometry.material, primitive, geometryIndex);
    }
    imageStore(albedo, pixel, outAlbedo);
    imageStore(normal, pixel, outNormal);
    imageStore(position, pixel, outPosition);
    imageStore(ids, pixel, outIds);
}

#endif
