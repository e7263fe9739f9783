// The scene's side of the bridges of light sampling and the energy tables.
#ifndef RAYGRAPH_SCENE_LIGHT_BRIDGE_GLSL
#define RAYGRAPH_SCENE_LIGHT_BRIDGE_GLSL

#include "scene/environment.glsl"
#include "scene/material_textures.glsl"

SHADING_BEGIN

INLINE LightSetRecord LightSet() { return parameters.value.lights; }
#ifdef __cplusplus
INLINE LightRecord LightAt(uint index) { return lights.at[index]; }
INLINE LightNode LightNodeAt(uint index) { return lightNodes.at[index]; }
#else
INLINE LightRecord LightAt(uint index) {
    Words words = Words(lights);
    uint first = 4u * index;
    uvec4 a = HalvesOf(words.at[first]);
    uvec4 b = HalvesOf(words.at[first + 1u]);
    uvec4 c = HalvesOf(words.at[first + 2u]);
    uvec4 d = HalvesOf(words.at[first + 3u]);
    LightRecord record;
    record.p0 = uintBitsToFloat(a.xyz);
    record.kind = a.w;
    record.e1 = uintBitsToFloat(b.xyz);
    record.flags = b.w;
    record.e2 = uintBitsToFloat(c.xyz);
    record.instance = c.w;
    record.primitive = d.x;
    record.bitTrail = d.y;
    record.spotScale = uintBitsToFloat(d.z);
    record.spotOffsetOrClearance = uintBitsToFloat(d.w);
    return record;
}
INLINE LightNode LightNodeAt(uint index) {
    Words words = Words(lightNodes);
    uint first = 3u * index;
    uvec4 a = HalvesOf(words.at[first]);
    uvec4 b = HalvesOf(words.at[first + 1u]);
    uvec4 c = HalvesOf(words.at[first + 2u]);
    LightNode record;
    record.boundsMin = uintBitsToFloat(a.xyz);
    record.power = uintBitsToFloat(a.w);
    record.boundsMax = uintBitsToFloat(b.xyz);
    record.link = b.w;
    record.axis = uintBitsToFloat(c.xyz);
    record.cones = c.w;
    return record;
}
#endif
INLINE AliasEntry LightAliasAt(uint index) { return lightAlias.at[index]; }
INLINE LightMeshRecord LightMeshAt(uint index) { return lightMeshes.at[index]; }
INLINE mat4x3 LightPlacement(uint index) { return InstanceAt(index).objectToWorld; }
INLINE float LightProfileAt(uint index) { return lightProfiles.at[index]; }
INLINE EnvironmentEntry EnvironmentEntryAt(uint index) { return environmentTable.at[index]; }
INLINE uvec4 EnergyEntryAt(uint index) { return energyTables.at[index]; }

SHADING_END

#include "bxdf/clearcoat.glsl"
#include "scene/surface.glsl"

SHADING_BEGIN

// Returns the properties of a triangle that EmissionTransmittance needs, as SurfaceAt has them for a ray from
// the viewer.
INLINE SurfaceInteraction CoatAt(InstanceRecord instance, GeometryRecord geometry, MaterialRecord material,
                                 Triangle triangle, vec3 toViewer) {
    SurfaceInteraction surface;
    surface.material.clearcoat =
        material.clearcoat * SampleTexture(TEXTURE_OF(material, clearcoat), geometry, triangle).x;
    if (!(surface.material.clearcoat > 0.0f)) return surface;
    Vec3Stream positions = Vec3Stream(instance.positions);
    vec3 p0 = positions.at[triangle.vertices.x];
    vec3 e1 = positions.at[triangle.vertices.y] - p0;
    vec3 e2 = positions.at[triangle.vertices.z] - p0;
    vec3 ng = GeometricNormalAt(instance, e1, e2, toViewer);
    bool isFront = dot(ng, toViewer) >= 0.0f;
    surface.coatNormal =
        CoatNormalAt(instance, geometry, material, triangle, e1, e2, isFront ? ng : -ng, isFront, toViewer);
    vec4 roughness = SampleTexture(TEXTURE_OF(material, clearcoatRoughness), geometry, triangle);
    surface.material.clearcoatRoughness = material.clearcoatRoughness * roughness.y;
    return surface;
}

// Returns the mean radiance of rays to a point of a light triangle: partly transparent ones let some rays
// pass. It is the same in all directions, except under a clear coat.
INLINE vec3 TriangleEmission(LightRecord light, vec2 barycentrics, vec3 toViewer) {
    InstanceRecord instance = InstanceAt(light.instance);
    GeometryRecord geometry = geometries.at[GeometryIndex(instance, light.primitive)];
    MaterialRecord material = materials.at[geometry.material];
    if (!HasTraceFeature(kTraceTextures | kTraceClearcoat | kTraceAnyHit)) return material.emission;
    Triangle triangle = WithTexCoords(TriangleAt(instance, light.primitive, barycentrics), geometry);
    vec3 emission = EmissionAt(geometry, material, triangle);
    if (HasTraceFeature(kTraceClearcoat))
        emission *= EmissionTransmittance(CoatAt(instance, geometry, material, triangle, toViewer), toViewer);
    if (HasTraceFeature(kTraceAnyHit) && material.alphaMode != kAlphaOpaque)
        emission *= Opacity(geometry, material, triangle);
    return emission;
}

SHADING_END

#endif
