// Morph targets and joints: how they move a vertex. On the CPU renderer/scene/animation/deform.h states the
// same; the tests compare the two.
//
//   ShapedVertex vertex = base;
//   AddMorphTarget(vertex, weight, ...);            // for each target of the mesh
//   vertex = NormalizeMorphed(vertex, base);
//   mat4x3 joints = weight * matrix + ...;     // of the vertex
//   vertex = ApplySkinning(joints, vertex);
//   vertex.tangent = TangentInPlane(vertex.tangent, vertex.normal);  // if its normal came from elsewhere
#ifndef RAYGRAPH_CORE_DEFORM_GLSL
#define RAYGRAPH_CORE_DEFORM_GLSL

#include "core/math.glsl"

SHADING_BEGIN

struct ShapedVertex {
    vec3 position;
    vec3 normal;   // unit length; 0 without
    vec4 tangent;  // xyz unit length; 0 without
};

// Displacements by a target, as many times as its weight says.
INLINE void AddMorphTarget(INOUT(ShapedVertex) vertex, float weight, vec3 position, vec3 normal,
                           vec3 tangent) {
    vertex.position += weight * position;
    vertex.normal += weight * normal;
    vertex.tangent += vec4(weight * tangent, 0.0f);
}

// Must be called after all targets: a vector without length stays as it was.
INLINE ShapedVertex NormalizeMorphed(ShapedVertex vertex, ShapedVertex base) {
    vertex.normal = UnitOr(vertex.normal, base.normal);
    vec3 was = vec3(base.tangent.x, base.tangent.y, base.tangent.z);
    vertex.tangent = vec4(UnitOr(vec3(vertex.tangent.x, vertex.tangent.y, vertex.tangent.z), was),
                          base.tangent.w);
    return vertex;
}

// `joints` is the weighted sum of the matrices. Normals go by its cofactors: they need no inverse, and keep
// the side that the winding of the moved triangle says.
INLINE ShapedVertex ApplySkinning(mat4x3 joints, ShapedVertex vertex) {
    vec3 x = joints[0];
    vec3 y = joints[1];
    vec3 z = joints[2];
    vec3 n = vertex.normal;
    vec3 t = vec3(vertex.tangent.x, vertex.tangent.y, vertex.tangent.z);
    ShapedVertex moved;
    moved.position = joints * vec4(vertex.position, 1.0f);
    moved.normal = UnitOr(cross(y, z) * n.x + cross(z, x) * n.y + cross(x, y) * n.z, n);
    moved.tangent = vec4(UnitOr(x * t.x + y * t.y + z * t.z, t), vertex.tangent.w);
    return moved;
}

// Perpendicular to the unit normal (Gram-Schmidt), w as it was; one along the normal stays as it is.
INLINE vec4 TangentInPlane(vec4 tangent, vec3 normal) {
    vec3 t = vec3(tangent.x, tangent.y, tangent.z);
    vec3 inPlane = t - dot(t, normal) * normal;
    float size = length(inPlane);
    return size > 1e-3f ? vec4(inPlane / size, tangent.w) : tangent;
}

// Returns the unit normal of a triangle; +z where it has no area.
INLINE vec3 FlatNormal(vec3 p0, vec3 p1, vec3 p2) {
    return UnitOr(cross(p1 - p0, p2 - p0), vec3(0.0f, 0.0f, 1.0f));
}

SHADING_END

#endif
