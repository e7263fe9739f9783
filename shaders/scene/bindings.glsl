// The scene's bindings in set 0 and its textures in set 1, the same in every pass that traces it.
// C++ side: passes/scene_bindings.h.
#ifndef RAYGRAPH_SCENE_BINDINGS_GLSL
#define RAYGRAPH_SCENE_BINDINGS_GLSL

#include "shared/scene_records.h"

layout(set = 0, binding = 0) uniform accelerationStructureEXT sceneTlas;
layout(set = 0, binding = 1, scalar) readonly buffer Instances { InstanceRecord at[]; } instances;
layout(set = 0, binding = 2, scalar) readonly buffer Geometries { GeometryRecord at[]; } geometries;
layout(set = 0, binding = 3, scalar) readonly buffer Materials { MaterialRecord at[]; } materials;
layout(set = 0, binding = 4) uniform sampler2D environmentMap;
layout(set = 0, binding = 5, scalar) uniform Parameters { TraceParameters value; } parameters;
// 6 to 15 are the scene's, too; 16 and up are the pass's own.

layout(set = 1, binding = 0) uniform sampler2D textures[];

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer UintStream { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec2Stream { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec3Stream { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec4Stream { vec4 at[]; };

bool IsPresent(uvec2 address) { return (address.x | address.y) != 0u; }

#endif
