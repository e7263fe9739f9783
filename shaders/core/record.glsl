// The macros by which the integrator notes what it does, to explain a path (shared/path_record.h). They are
// nothing, and change no bit of a shader, unless RECORDS_PATHS is defined. Recording takes part in no value
// of the path. Includers that define it declare beforehand:
//
//     RECORDED                 the PathVertexRecord of the current vertex, without its candidates: an lvalue
//     RECORDED_LIGHT(i)        the LightCandidateRecord of its candidate i: an lvalue
//     void StartVertexRecord()       begins a vertex: all values are as without an event, but for candidates
//     void StoreVertexRecord()       ends it
//     void RecordPlace(Hit hit)      records instance, material, primitive and texture coordinates
//     void RecordSource(uint candidate, uint light, uint triangle)
//         records kind, instance and material of a light, or of none (kNoLight)
//
// pathtrace/path_recorder.glsl is that of the device.
#ifndef RAYGRAPH_CORE_RECORD_GLSL
#define RAYGRAPH_CORE_RECORD_GLSL

#ifdef RECORDS_PATHS
// RECORD sets a value of the vertex, RECORD_LIGHT one of a candidate; RECORD_BY calls what records.
#define RECORD(name, value)                  RECORDED.name = (value)
#define RECORD_LIGHT(candidate, name, value) RECORDED_LIGHT(candidate).name = (value)
#define RECORD_BY(call)                      call
#else
#define RECORD(name, value)
#define RECORD_LIGHT(candidate, name, value)
#define RECORD_BY(call)
#endif

#endif
