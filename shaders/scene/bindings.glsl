// The scene's bindings in set 0 and its textures in set 1, the same in every pass that traces it.
// C++ side: passes/scene_bindings.h. Shaders of other pipelines than ray-tracing ones define NO_TLAS.
// Compiled as C++, this is nothing: includers of text that needs it declare these names beforehand, as
// editor/session/cpu/bindings.h.
#ifndef RAYGRAPH_SCENE_BINDINGS_GLSL
#define RAYGRAPH_SCENE_BINDINGS_GLSL

#ifndef __cplusplus

#include "scene/words.glsl"
#include "shared/light_records.h"
#include "shared/scene_records.h"

#ifndef NO_TLAS
layout(set = 0, binding = 0) uniform accelerationStructureEXT sceneTlas;
#endif
layout(set = 0, binding = 4) uniform sampler2D environmentMap;
layout(set = 0, binding = 5, scalar) uniform Parameters { TraceParameters value; } parameters;
// Tables, read by their addresses: Mesa's driver for CPUs branches for each lane of a load from a bound
// buffer, which made most of the code that it compiles. TABLE declares the type of one.
#define TABLE(alignment, Name, Record)                                   \
    layout(buffer_reference, scalar, buffer_reference_align = alignment) \
        readonly buffer Name { Record at[]; };
TABLE(4, Instances, InstanceRecord)
TABLE(4, Geometries, GeometryRecord)
TABLE(4, Materials, MaterialRecord)
TABLE(16, EnergyTables, uvec4)
TABLE(4, Lights, LightRecord)
TABLE(4, LightNodes, LightNode)
TABLE(4, LightAlias, AliasEntry)
TABLE(4, EnvironmentTable, EnvironmentEntry)
TABLE(4, LightProfiles, float)
TABLE(4, LightMeshes, LightMeshRecord)
layout(set = 0, binding = 1, scalar) uniform SceneTables {
    Instances instances;
    Geometries geometries;
    Materials materials;
    EnergyTables energyTables;
    Lights lights;
    LightNodes lightNodes;
    LightAlias lightAlias;
    EnvironmentTable environmentTable;
    LightProfiles lightProfiles;
    LightMeshes lightMeshes;
};
// 6: scene/software_traversal.glsl; 2, 3 and 7 to 15 are free; 16 and up are the pass's own.

layout(set = 1, binding = 0) uniform sampler2D textures[];

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer UintStream { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer CapsuleStream {
    CapsuleRecord at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec2Stream { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec3Stream { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec4Stream { vec4 at[]; };

// A table whose records have a multiple of 16 bytes.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Words { u64vec2 at[]; };

InstanceRecord InstanceAt(uint index) {
    Words words = Words(instances);
    uint first = 6u * index;
    vec4 a = uintBitsToFloat(HalvesOf(words.at[first]));
    vec4 b = uintBitsToFloat(HalvesOf(words.at[first + 1u]));
    vec4 c = uintBitsToFloat(HalvesOf(words.at[first + 2u]));
    uvec4 d = HalvesOf(words.at[first + 3u]);
    uvec4 e = HalvesOf(words.at[first + 4u]);
    uvec4 f = HalvesOf(words.at[first + 5u]);
    InstanceRecord record;
    record.objectToWorld = mat4x3(a.xyz, vec3(a.w, b.xy), vec3(b.zw, c.x), c.yzw);
    record.positions = d.xy;
    record.indices = d.zw;
    record.triangleGeometries = e.xy;
    record.triangleLights = e.zw;
    record.firstGeometry = f.x;
    record.instance = f.y;
    record.firstLight = f.z;
    record.draw = f.w;
    return record;
}

bool IsPresent(uvec2 address) { return (address.x | address.y) != 0u; }

#endif  // __cplusplus

#endif
