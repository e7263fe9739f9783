// The scene's bindings in set 0 and its textures in set 1, the same in every pass that traces it.
// C++ side: passes/scene_bindings.h. Shaders of other pipelines than ray-tracing ones define NO_TLAS.
#ifndef RAYGRAPH_SCENE_BINDINGS_GLSL
#define RAYGRAPH_SCENE_BINDINGS_GLSL

#include "shared/light_records.h"
#include "shared/scene_records.h"

#ifndef NO_TLAS
layout(set = 0, binding = 0) uniform accelerationStructureEXT sceneTlas;
#endif
layout(set = 0, binding = 1, scalar) readonly buffer Instances { InstanceRecord at[]; } instances;
layout(set = 0, binding = 2, scalar) readonly buffer Geometries { GeometryRecord at[]; } geometries;
layout(set = 0, binding = 3, scalar) readonly buffer Materials { MaterialRecord at[]; } materials;
layout(set = 0, binding = 4) uniform sampler2D environmentMap;
layout(set = 0, binding = 5, scalar) uniform Parameters { TraceParameters value; } parameters;
layout(set = 0, binding = 6, std430) readonly buffer EnergyTables { uvec4 at[]; } energyTables;
layout(set = 0, binding = 7, scalar) readonly buffer Lights { LightRecord at[]; } lights;
layout(set = 0, binding = 8, scalar) readonly buffer LightNodes { LightNode at[]; } lightNodes;
layout(set = 0, binding = 9, scalar) readonly buffer LightAlias { AliasEntry at[]; } lightAlias;
layout(set = 0, binding = 10, scalar) readonly buffer EnvironmentAlias { AliasEntry at[]; } environmentAlias;
layout(set = 0, binding = 11, scalar) readonly buffer LightProfiles { float at[]; } lightProfiles;
layout(set = 0, binding = 12, scalar) readonly buffer LightMeshes { LightMeshRecord at[]; } lightMeshes;
// 13 to 15: scene/own_traversal.glsl; 16 and up are the pass's own.

layout(set = 1, binding = 0) uniform sampler2D textures[];

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer UintStream { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer CapsuleStream {
    CapsuleRecord at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec2Stream { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec3Stream { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec4Stream { vec4 at[]; };

bool IsPresent(uvec2 address) { return (address.x | address.y) != 0u; }

#endif
