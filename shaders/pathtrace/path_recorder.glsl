// The recorder of core/record.glsl on the device: the records of one path, in a buffer with room for the
// longest. Included before all that records.
#ifndef RAYGRAPH_PATHTRACE_PATH_RECORDER_GLSL
#define RAYGRAPH_PATHTRACE_PATH_RECORDER_GLSL

#include "core/glue.h"
#include "shared/path_record.h"

#ifndef __cplusplus
layout(set = 0, binding = 26, scalar) buffer PathRecords {  // starts with 0
    uint count;
    PathVertexRecord at[];
} pathRecords;
#endif

SHADING_BEGIN

// Values are kept here until the vertex is complete: a store at each place that records one would be most of
// the program for Mesa's driver for CPUs.
PRIVATE PathVertexRecord recorded;
PRIVATE uint recordedVertex = 0u;

SHADING_END

#define RECORDED          recorded
#define RECORDED_LIGHT(i) pathRecords.at[recordedVertex].candidates[i]

#include "core/record.glsl"
#include "scene/light_bridge.glsl"

SHADING_BEGIN

// The values that a vertex starts with, by type.
CONST uint kNo_uint = 0u;
CONST uint kNo_PathIndex = kNoRecord;
CONST float kNo_float = 0.0f;
CONST vec2 kNo_vec2 = vec2(0.0f);
CONST vec3 kNo_vec3 = vec3(0.0f);

INLINE void StartVertexRecord() {
    recordedVertex = min(pathRecords.count, uint(pathRecords.at.length()) - 1u);
#define RAYGRAPH_PATH_VALUE(type, name) recorded.name = kNo_##type;
#include "shared/path_vertex_list.h"
}

INLINE void StoreVertexRecord() {
#define RAYGRAPH_PATH_VALUE(type, name) pathRecords.at[recordedVertex].name = recorded.name;
#include "shared/path_vertex_list.h"
    pathRecords.count = recordedVertex + 1u;
}

INLINE void RecordPlace(Hit hit) {
    InstanceRecord instance = InstanceAt(hit.instance);
    GeometryRecord geometry = geometries.at[GeometryIndex(instance, hit.primitive)];
    Triangle triangle = WithTexCoords(TriangleAt(instance, hit.primitive, hit.barycentrics), geometry);
    RECORD(instance, instance.instance);
    RECORD(material, geometry.material);
    RECORD(primitive, IsPresent(geometry.primitives) ? UintStream(geometry.primitives).at[hit.primitive]
                                                     : hit.primitive);
    RECORD(uv0, triangle.uv0);
    RECORD(uv1, triangle.uv1);
}

INLINE void RecordSource(uint candidate, uint light, uint triangle) {
    uint kind = kPathLightNone, instance = kNoRecord, material = kNoRecord;
    if (light == LightSet().lightCount) {
        kind = kPathLightEnvironment;
    } else if (light != kNoLight) {
        LightRecord record = LightAt(light);
        uint primitive = record.primitive;
        kind = kPathLightPunctual;
        if (record.kind == kLightMesh)
            primitive = LightAt(LightMeshAt(record.primitive).firstLight + triangle).primitive;
        if (record.kind == kLightMesh || record.kind == kLightTriangle) {
            InstanceRecord placed = InstanceAt(record.instance);
            kind = kPathLightSurface;
            instance = placed.instance;
            material = geometries.at[GeometryIndex(placed, primitive)].material;
        }
    }
    RECORD_LIGHT(candidate, kind, kind);
    RECORD_LIGHT(candidate, instance, instance);
    RECORD_LIGHT(candidate, material, material);
}

SHADING_END

#endif
