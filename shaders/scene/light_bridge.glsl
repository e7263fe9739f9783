// The scene's side of the bridges of light sampling and the energy tables.
#ifndef RAYGRAPH_SCENE_LIGHT_BRIDGE_GLSL
#define RAYGRAPH_SCENE_LIGHT_BRIDGE_GLSL

#include "scene/environment.glsl"
#include "scene/material_textures.glsl"

LightSetRecord LightSet() { return parameters.value.lights; }
LightRecord LightAt(uint index) { return lights.at[index]; }
LightNode LightNodeAt(uint index) { return lightNodes.at[index]; }
AliasEntry LightAliasAt(uint index) { return lightAlias.at[index]; }
AliasEntry EnvironmentAliasAt(uint index) { return environmentAlias.at[index]; }
uvec4 EnergyEntryAt(uint index) { return energyTables.at[index]; }

// Mean radiance of rays to a point of a light triangle: partly transparent ones let some rays pass. The same
// in all directions.
vec3 TriangleEmission(LightRecord light, vec2 barycentrics, vec3 toViewer) {
    InstanceRecord instance = instances.at[light.instance];
    GeometryRecord geometry = geometries.at[GeometryIndex(instance, light.primitive)];
    MaterialRecord material = materials.at[geometry.material];
    Triangle triangle = TriangleAt(instance, light.primitive, barycentrics);
    vec3 emission = EmissionAt(geometry, material, triangle);
    if (material.alphaMode != kAlphaOpaque) emission *= Opacity(geometry, material, triangle);
    return emission;
}

#endif
