// A placed mesh as one light: the choice of one of its triangles, and the triangle in world space.
//
// The bridge: LightMeshRecord LightMeshAt(uint mesh), mat4x3 LightPlacement(uint instance), which is the
// objectToWorld of an InstanceRecord, and those of lights/light_bvh.glsl.
#ifndef RAYGRAPH_LIGHTS_MESH_LIGHT_GLSL
#define RAYGRAPH_LIGHTS_MESH_LIGHT_GLSL

#include "core/ray_offset.glsl"
#include "lights/light_bvh.glsl"

SHADING_BEGIN

// |determinant| of a transform whose largest entry is 1. Below this, the way back to object space loses too
// many digits to guide a choice.
CONST float kMinMeshDeterminant = 1.0e-4f;

// The context in the object space of a mesh, where its tree is: the half-space above the context's plane
// stays that, and so do the sides of triangles. So an importance of 0 means there what it means in the world.
// Distances and angles stay only under uniform scale: otherwise the tree chooses less well. False: there is
// no way back.
INLINE bool ContextInMesh(mat4x3 objectToWorld, LightContext context, OUT(LightContext) inMesh) {
    inMesh = context;
    vec3 x = objectToWorld[0];
    vec3 y = objectToWorld[1];
    vec3 z = objectToWorld[2];
    float scale = max(MaxComponent(abs(x)), max(MaxComponent(abs(y)), MaxComponent(abs(z))));
    x /= scale;
    y /= scale;
    z /= scale;
    vec3 yz = cross(y, z);
    float determinant = dot(x, yz);
    if (!(abs(determinant) >= kMinMeshDeterminant)) return false;
    vec3 way = (context.position - objectToWorld[3]) / scale;
    inMesh.position = vec3(dot(yz, way), dot(cross(z, x), way), dot(cross(x, y), way)) / determinant;
    inMesh.normal = vec3(dot(x, context.normal), dot(y, context.normal), dot(z, context.normal));
    inMesh.normal = UnitOr(inMesh.normal, vec3(0.0f));
    return true;
}

// Chooses a triangle of the mesh, by its tree where the sampler is Bvh. The remainders of u are uniform.
INLINE ChosenLight ChooseMeshTriangle(LightMeshRecord mesh, mat4x3 objectToWorld, LightContext context,
                                      INOUT(vec2) u) {
    if (mesh.activeCount == 0u) return NoChosenLight();
    if (ActiveLightSampler() == kLightSamplerUniform) {
        ChosenLight result;
        uint slot = ChooseUniformly(u.x, mesh.activeCount);
        result.light = LightAliasAt(mesh.firstAlias + mesh.triangleCount + slot).alias;
        result.probability = 1.0f / float(mesh.activeCount);
        return result;
    }
    LightContext inMesh;
    if (ActiveLightSampler() == kLightSamplerBvh && ContextInMesh(objectToWorld, context, inMesh))
        return SampleLightTree(mesh.firstNode, inMesh, u.x);
    return SampleLightAlias(mesh.firstAlias, mesh.triangleCount, u.x, u.y);
}

// Returns the probability with which ChooseMeshTriangle chooses a triangle; `bitTrail` is that of its record.
INLINE float MeshTriangleProbability(LightMeshRecord mesh, mat4x3 objectToWorld, LightContext context,
                                     uint triangle, uint bitTrail) {
    float byPower = LightAliasAt(mesh.firstAlias + triangle).probability;
    if (byPower == 0.0f) return 0.0f;  // dark
    if (ActiveLightSampler() == kLightSamplerUniform) return 1.0f / float(mesh.activeCount);
    LightContext inMesh;
    if (ActiveLightSampler() == kLightSamplerBvh && ContextInMesh(objectToWorld, context, inMesh))
        return LightTreeProbability(mesh.firstNode, inMesh, bitTrail);
    return byPower;
}

INLINE LightRecord TransformLightTriangle(LightRecord triangle, LightRecord mesh, mat4x3 objectToWorld) {
    mat3 linear = mat3(objectToWorld);
    LightRecord placed = triangle;
    placed.p0 = linear * triangle.p0 + objectToWorld[3];
    placed.e1 = linear * triangle.e1;
    placed.e2 = linear * triangle.e2;
    placed.flags |= mesh.flags & kLightMirrored;
    if ((mesh.flags & kLightOutward) != 0u) placed.flags &= ~kLightDoubleSided;
    placed.instance = mesh.instance;
    return placed;
}

// Returns the clearance of rays that end anywhere on the triangle. It is convex in the point, so that the
// vertices bound it. A placed triangle has rounding errors of its own.
INLINE float TransformedClearance(LightRecord triangle, LightRecord placed, mat4x3 objectToWorld) {
    mat3 linear = mat3(objectToWorld);
    float clearance = 0.0f;
    DONT_UNROLL
    for (uint vertex = 0u; vertex < 3u; ++vertex) {
        vec3 p = triangle.p0;
        if (vertex == 1u) p += triangle.e1;
        if (vertex == 2u) p += triangle.e2;
        clearance =
            max(clearance, RayClearance(linear, objectToWorld[3], triangle.p0, triangle.e1, triangle.e2, p));
    }
    vec3 inObject = abs(triangle.p0) + abs(triangle.e1) + abs(triangle.e2);
    vec3 sizes = abs(placed.p0) + abs(placed.e1) + abs(placed.e2) + abs(linear[0]) * inObject.x +
                 abs(linear[1]) * inObject.y + abs(linear[2]) * inObject.z;
    vec3 across = cross(placed.e1, placed.e2);
    return clearance + 4.0f * kRoundoff * dot(abs(across), sizes) * InverseLength(across);
}

// Turns the light, if it is a mesh, into one of its triangles as it is placed; `triangle` is its number in
// the mesh. Returns the probability of that triangle, of any other light 1.
INLINE float ResolveMeshLight(INOUT(LightRecord) light, LightContext context, INOUT(vec2) u,
                          OUT(uint) triangle) {
    triangle = 0u;
    if (!HasTraceFeature(kTraceMeshLights) || light.kind != kLightMesh) return 1.0f;
    LightMeshRecord mesh = LightMeshAt(light.primitive);
    mat4x3 objectToWorld = LightPlacement(light.instance);
    ChosenLight chosen = ChooseMeshTriangle(mesh, objectToWorld, context, u);
    if (!(chosen.probability > 0.0f)) return 0.0f;
    triangle = chosen.light;
    LightRecord record = LightAt(mesh.firstLight + triangle);
    LightRecord placed = TransformLightTriangle(record, light, objectToWorld);
    placed.spotOffsetOrClearance = TransformedClearance(record, placed, objectToWorld);
    light = placed;
    return chosen.probability;
}

// Returns the probability with which ResolveMeshLight chooses a triangle that a ray has hit.
INLINE float ResolveHitMeshLight(INOUT(LightRecord) light, LightContext context, uint triangle) {
    if (!HasTraceFeature(kTraceMeshLights) || light.kind != kLightMesh) return 1.0f;
    LightMeshRecord mesh = LightMeshAt(light.primitive);
    mat4x3 objectToWorld = LightPlacement(light.instance);
    LightRecord record = LightAt(mesh.firstLight + triangle);
    light = TransformLightTriangle(record, light, objectToWorld);
    return MeshTriangleProbability(mesh, objectToWorld, context, triangle, record.bitTrail);
}

SHADING_END

#endif
