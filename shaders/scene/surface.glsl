// Finds the surface at a hit: fetches vertices, interpolates, evaluates the material's inputs.
#ifndef RAYGRAPH_SCENE_SURFACE_GLSL
#define RAYGRAPH_SCENE_SURFACE_GLSL

#include "core/capsule.glsl"
#include "core/ray_offset.glsl"
#include "core/frame.glsl"
#include "scene/material_textures.glsl"
#include "scene/ray.glsl"

SHADING_BEGIN

// Carries an object-space normal to world space by the cofactors of the transform, which are its inverse
// transpose times the determinant: a mirroring transform must not flip the side.
INLINE vec3 NormalToWorld(mat4x3 objectToWorld, vec3 normal) {
    vec3 x = objectToWorld[0];
    vec3 y = objectToWorld[1];
    vec3 z = objectToWorld[2];
    vec3 yz = cross(y, z);
    vec3 result = normal.x * yz + normal.y * cross(z, x) + normal.z * cross(x, y);
    return dot(x, yz) < 0.0f ? -result : result;
}

// Returns the unit normal of a triangle with those edges, on its front. A degenerate triangle, which has no
// normal of its own, faces the viewer.
INLINE vec3 GeometricNormalAt(InstanceRecord instance, vec3 e1, vec3 e2, vec3 wo) {
    return UnitOr(NormalToWorld(instance.objectToWorld, cross(e1, e2)), wo);
}

// Returns whether the transform keeps the directions of the coordinate axes: it only translates, or scales by
// positive factors.
INLINE bool PreservesAxes(mat3x2 transform) {
    return transform[0].y == 0.0f && transform[1].x == 0.0f && transform[0].x > 0.0f && transform[1].y > 0.0f;
}

// Returns a vertex's tangent along the texture coordinate set that the stored ones are not made along.
INLINE vec3 OtherTangentOf(GeometryRecord geometry, uint vertex) {
    vec3 tangent = vec3(Vec4Stream(geometry.tangents).at[vertex]);
    vec2 turn = Vec2Stream(geometry.frameTurns).at[vertex];
    return turn.x * tangent + turn.y * cross(Vec3Stream(geometry.normals).at[vertex], tangent);
}

// Returns the frame (core/frame.glsl), in object space, of a directional map (TEXTURE_OF) at a point
// of a geometry with tangents; n is the interpolated normal, of any length. The stored tangents are the frame
// if they were given for all maps, or made along the texture coordinate set by which the map is read. The
// frame of the other set comes from frameTurns or else from the triangle. A texture transform turns it within
// the surface. e1 and e2 are the triangle's edges after deformation.
INLINE vec4 TangentOf(uint map, mat3x2 transform, GeometryRecord geometry, Triangle triangle, vec3 e1,
                      vec3 e2, vec3 n) {
    vec4 tangent = InterpolateVec4(Vec4Stream(geometry.tangents), triangle);
    if (!HasTraceFeature(kTraceTextureTransforms) || map == kNoTexture) return tangent;
    if (geometry.tangentSet == kTangentsOfAllMaps) return tangent;
    bool isSecond = (map & kSecondTexCoord) != 0u;
    bool isSameSet = geometry.tangentSet == (isSecond ? kTangentsOfSecondSet : kTangentsOfFirstSet);
    bool isTurned = !PreservesAxes(transform);
    Address stream = isSecond ? geometry.uv1 : geometry.uv0;
    if ((isSameSet && !isTurned) || !IsPresent(stream)) return tangent;
    Vec2Stream values = Vec2Stream(stream);
    vec2 first = values.at[triangle.vertices.x];
    vec2 a = values.at[triangle.vertices.y] - first;
    vec2 b = values.at[triangle.vertices.z] - first;
    n = UnitOr(n, vec3(0.0f));
    vec4 ofTriangle = TriangleTangent(e1, e2, a, b, n);
    bool hasFrame = ofTriangle.w != 0.0f;
    if (!isSameSet && IsPresent(geometry.frameTurns)) {
        // Interpolated as MikkTSpace's are: turn and tangent, each interpolated, have another product
        vec3 other = triangle.weights.x * OtherTangentOf(geometry, triangle.vertices.x) +
                     triangle.weights.y * OtherTangentOf(geometry, triangle.vertices.y) +
                     triangle.weights.z * OtherTangentOf(geometry, triangle.vertices.z);
        tangent = vec4(other, hasFrame ? ofTriangle.w : tangent.w);
    } else if (!isSameSet && hasFrame) {
        tangent = ofTriangle;
    }
    if (!isTurned || !hasFrame) return tangent;
    vec4 turned = TriangleTangent(e1, e2, transform * vec3(a, 0.0f), transform * vec3(b, 0.0f), n);
    return turned.w != 0.0f ? TurnTangent(tangent, ofTriangle, turned, n) : tangent;
}

// Returns the normal on the front of the surface: interpolated, and bent by a normal map (TEXTURE_OF). Unit
// length. e1 and e2 are the triangle's edges, in object space.
INLINE vec3 NormalAt(InstanceRecord instance, GeometryRecord geometry, uint map, mat3x2 transform,
                     float scale, Triangle triangle, vec3 e1, vec3 e2, vec3 ng) {
    if (!IsPresent(geometry.normals)) return ng;
    vec3 n = InterpolateVec3(Vec3Stream(geometry.normals), triangle);
    if (HasTraceFeature(kTraceTextures) && map != kNoTexture && IsPresent(geometry.tangents)) {
        vec4 tangent = TangentOf(map, transform, geometry, triangle, e1, e2, n);
        vec3 bend = 2.0f * vec3(SampleTexture(map, transform, geometry, triangle)) - 1.0f;
        // Blocks of two channels have no blue: z of a unit vector that points up
        if (bend.z <= -1.0f) bend.z = sqrt(max(1.0f - dot(vec2(bend), vec2(bend)), 0.0f));
        bend.x *= scale;
        bend.y *= scale;
        // The bitangent is computed in object space, where the file's tangent frame is orthogonal. A normal
        // is transformed to world space by the inverse transpose, however it was computed
        vec3 bitangent = cross(n, vec3(tangent)) * tangent.w;
        vec3 bent = bend.x * vec3(tangent) + bend.y * bitangent + bend.z * n;
        if (dot(bent, n) > 0.0f) n = bent;
    }
    return UnitOr(NormalToWorld(instance.objectToWorld, n), ng);
}

INLINE vec3 ShadingNormalAt(InstanceRecord instance, GeometryRecord geometry, MaterialRecord material,
                            Triangle triangle, vec3 e1, vec3 e2, vec3 ng) {
    return NormalAt(instance, geometry, TEXTURE_OF(material, normal), material.normalScale, triangle, e1, e2,
                    ng);
}

// Returns the clear coat's normal, on the side of wo, as `ng` is.
INLINE vec3 CoatNormalAt(InstanceRecord instance, GeometryRecord geometry, MaterialRecord material,
                         Triangle triangle, vec3 e1, vec3 e2, vec3 ng, bool isFront, vec3 wo) {
    vec3 n = NormalAt(instance, geometry, TEXTURE_OF(material, clearcoatNormal),
                      material.clearcoatNormalScale, triangle, e1, e2, isFront ? ng : -ng);
    return AdaptShadingNormal(isFront ? n : -n, ng, wo);
}

// Returns the direction in which highlights are stretched (xy, in the frame of StretchToWorld) and its
// strength (z).
INLINE vec3 AnisotropyAt(GeometryRecord geometry, MaterialRecord material, Triangle triangle) {
    vec3 read = vec3(1.0f, 0.0f, 1.0f);
    if (HasTraceFeature(kTraceTextures) && material.anisotropyTexture != kNoTexture) {
        read = vec3(SampleTexture(TEXTURE_OF(material, anisotropy), geometry, triangle));
        read.x = 2.0f * read.x - 1.0f;
        read.y = 2.0f * read.y - 1.0f;
    }
    float c = cos(material.anisotropyRotation);
    float s = sin(material.anisotropyRotation);
    return vec3(c * read.x - s * read.y, s * read.x + c * read.y, material.anisotropy * read.z);
}

// Returns the direction of the stretch in world space, from the frame of the anisotropy texture or, without
// one, of the normal map. It is tangent to the surface, so no inverse transpose is needed. Meshes without
// tangents use a tangent around their y axis; if they have no normals either, cross(e1, e2) is their
// direction.
INLINE vec3 StretchToWorld(InstanceRecord instance, GeometryRecord geometry, MaterialRecord material,
                           Triangle triangle, vec3 e1, vec3 e2, vec2 direction) {
    vec3 n = cross(e1, e2);
    if (IsPresent(geometry.normals)) n = InterpolateVec3(Vec3Stream(geometry.normals), triangle);
    n = UnitOr(n, vec3(0.0f));
    vec4 tangent = vec4(n.z, 0.0f, -n.x, 1.0f);
    if (IsPresent(geometry.tangents) && material.anisotropyTexture != kNoTexture)
        tangent = TangentOf(TEXTURE_OF(material, anisotropy), geometry, triangle, e1, e2, n);
    else if (IsPresent(geometry.tangents))
        tangent = TangentOf(TEXTURE_OF(material, normal), geometry, triangle, e1, e2, n);
    else if (abs(n.y) > 0.9999f)
        tangent = vec4(1.0f, 0.0f, 0.0f, 1.0f);
    vec3 bitangent = tangent.w * cross(n, vec3(tangent));
    return mat3(instance.objectToWorld) * (direction.x * vec3(tangent) + direction.y * bitangent);
}

// KHR_materials_scatter of a surface that bounds no medium (of others scatterStrength is 0): that share of
// what it would transmit belongs to its opaque base instead, of which it is the part that passes diffusely.
INLINE void ApplyThinScattering(INOUT(SurfaceMaterial) material) {
    float scattered = material.transmission * material.scatterStrength;
    material.scatterStrength = scattered;
    if (!(scattered > 0.0f)) return;
    material.transmission -= scattered;
    material.diffuseTransmission = min(scattered / (1.0f - material.transmission), 1.0f);
    material.diffuseTransmissionColor = material.scatterColor;
}

INLINE SurfaceMaterial MaterialInputs(GeometryRecord geometry, MaterialRecord material, Triangle triangle) {
    SurfaceMaterial result;
    result.baseColor = vec3(BaseColor(geometry, material, triangle));
    vec4 metallicRoughness = SampleTexture(TEXTURE_OF(material, metallicRoughness), geometry, triangle);
    result.metallic = material.metallic * metallicRoughness.z;
    result.roughness = material.roughness * metallicRoughness.y;
    result.specular = material.specular * SampleTexture(TEXTURE_OF(material, specular), geometry, triangle).w;
    vec4 specularColor = SampleTexture(TEXTURE_OF(material, specularColor), geometry, triangle);
    result.specularColor = material.specularColor * vec3(specularColor);
    if (HasTraceFeature(kTraceTextures) && (material.flags & kMaterialGlossiness) != 0u)
        result.roughness = 1.0f - (1.0f - material.roughness) * specularColor.w;
    result.ior = material.ior;
    result.transmission =
        material.transmission * SampleTexture(TEXTURE_OF(material, transmission), geometry, triangle).x;
    if (HasTraceFeature(kTraceIridescence))
        result.iridescenceThickness =
            mix(material.iridescenceThickness.x, material.iridescenceThickness.y,
                SampleTexture(TEXTURE_OF(material, iridescenceThickness), geometry, triangle).y);
#define RAYGRAPH_MATERIAL_FACTOR(type, name, object, key, channels, space, feature, quantity)        \
    if (HasTraceFeature(kTrace##feature))                                                            \
        result.name = material.name *                                                                \
                      CHANNELS_OF(SampleTexture(TEXTURE_OF(material, name), geometry, triangle), channels);
#define RAYGRAPH_MATERIAL_NUMBER(type, name, field, object, key, feature, quantity) \
    if (HasTraceFeature(kTrace##feature)) result.name = material.name;
#include "shared/material_list.h"
    result.flags = material.flags;
    result.id = geometry.material;
    if (HasTraceFeature(kTraceThinScatter)) ApplyThinScattering(result);
    return result;
}

// Returns twice the area of a triangle in a set of texture coordinates.
INLINE float UvArea(Address stream, Triangle triangle) {
    if (!IsPresent(stream)) return 0.0f;
    Vec2Stream values = Vec2Stream(stream);
    vec2 first = values.at[triangle.vertices.x];
    vec2 a = values.at[triangle.vertices.y] - first;
    vec2 b = values.at[triangle.vertices.z] - first;
    return abs(a.x * b.y - a.y * b.x);
}

#ifndef PIXEL_FOOTPRINT
// Finds the part of a triangle with those edges that the ray's cone covers, for kTraceTextureLod.
INLINE void FindFootprint(INOUT(Triangle) triangle, InstanceRecord instance, GeometryRecord geometry, vec3 p0,
                          vec3 e1, vec3 e2, Ray ray, float t) {
    vec3 normal = NormalToWorld(instance.objectToWorld, cross(e1, e2));
    float inverse = InverseLength(normal);  // 1 / twice the triangle's area
    if (inverse == 0.0f) return;
    float cosine = dot(normal, ray.direction) * inverse;
    float seen = FootprintArea(AdvanceCone(ray.cone, t).width, cosine) * inverse;
    triangle.uvAreas = seen * vec2(UvArea(geometry.uv0, triangle), UvArea(geometry.uv1, triangle));
}
#endif

// Returns the curvature of the surface that the vertex normals describe, on the front; in world space.
INLINE float CurvatureAt(Hit hit, InstanceRecord instance, GeometryRecord geometry, Triangle triangle,
                         vec3 e1, vec3 e2) {
    float curvature = 0.0f;
    if (IsRound(instance)) {
        curvature = CapsuleCurvature(CapsuleAt(instance, hit.primitive), hit.barycentrics);
    } else if (IsPresent(geometry.normals)) {
        Vec3Stream normals = Vec3Stream(geometry.normals);
        curvature = MeanCurvature(e1, e2, normals.at[triangle.vertices.x], normals.at[triangle.vertices.y],
                                  normals.at[triangle.vertices.z]);
    }
    vec3 normal = cross(e1, e2);
    vec3 inWorld = NormalToWorld(instance.objectToWorld, normal);
    float inverse = InverseLength(normal);
    float shrink = inverse > 0.0f ? InverseLength(inWorld) / inverse : 0.0f;  // factor on areas
    return sqrt(shrink) * curvature;
}

// `ordinal`: of a mesh that is one light, the triangle within it.
INLINE uint LightOf(InstanceRecord instance, uint primitive, OUT(uint) ordinal) {
    ordinal = 0u;
    if (!IsPresent(instance.triangleLights)) return kNoLight;
    ordinal = UintStream(instance.triangleLights).at[primitive];
    if (ordinal == kNoLight) return kNoLight;
    if (HasTraceFeature(kTraceMeshLights) && (instance.firstLight & kFirstLightIsMesh) != 0u)
        return instance.firstLight & ~kFirstLightIsMesh;
    return instance.firstLight + ordinal;
}

INLINE Medium MediumAt(uint material) {
    Medium medium;
    medium.extinction = materials.at[material].extinction;
    if (HasTraceFeature(kTraceScattering)) {
        medium.scattering = materials.at[material].scattering;
        medium.anisotropy = materials.at[material].scatterAnisotropy;
    }
    medium.ior = materials.at[material].ior;
    if (HasTraceFeature(kTraceDispersion)) medium.dispersion = materials.at[material].dispersion;
    medium.priority = materials.at[material].priority;
    return medium;
}

// For kTraceShadowTerminator: treats the surface as the curved one that its vertex normals describe, so that
// grazing light ends where the curve turns away and not at the edge of a triangle. Not for transmissive
// surfaces: a ray that starts above the triangle would enter twice.
INLINE void BendSurface(INOUT(SurfaceInteraction) surface, InstanceRecord instance, GeometryRecord geometry,
                        Triangle triangle, vec3 p, vec3 p0, vec3 p1, vec3 p2, vec3 wo) {
    if (!IsPresent(geometry.normals) || surface.material.transmission > 0.0f) return;
    if (HasTraceFeature(kTraceDiffuseTransmission) && surface.material.diffuseTransmission > 0.0f) return;
    if ((surface.material.flags & kMaterialVolume) != 0u) return;
    Vec3Stream normals = Vec3Stream(geometry.normals);
    float side = surface.isFront ? 1.0f : -1.0f;
    vec3 lift = ShadowTerminatorOffset(
        triangle.weights, p, p0, p1, p2, side * normals.at[triangle.vertices.x],
        side * normals.at[triangle.vertices.y], side * normals.at[triangle.vertices.z]);
    surface.fromInstance += mat3(instance.objectToWorld) * lift;
    surface.position = surface.fromInstance + surface.instanceOrigin;
    vec3 n = side * NormalToWorld(instance.objectToWorld, InterpolateVec3(normals, triangle));
    float inverse = InverseLength(n);
    if (inverse == 0.0f) return;
    n = AdaptShadingNormal(n * inverse, surface.geometricNormal, wo);
    surface.clearance /= max(dot(n, surface.geometricNormal), 0.1f);  // it was along the triangle's normal
    surface.geometricNormal = n;
    surface.shadingNormal = AdaptShadingNormal(surface.shadingNormal, surface.geometricNormal, wo);
    if (HasTraceFeature(kTraceClearcoat))
        surface.coatNormal = AdaptShadingNormal(surface.coatNormal, surface.geometricNormal, wo);
}

// A point of a capsule, with two directions from it along the surface. They are as long as the capsule: the
// distances that IntersectCapsule takes are rounded in proportion, which RayClearance of them then covers.
INLINE void TangentPlaneAt(CapsuleRecord capsule, vec2 place, OUT(vec3) p, OUT(vec3) e1, OUT(vec3) e2) {
    CapsulePoint point = CapsulePointAt(capsule, place);
    Frame frame = FrameFromZ(point.normal);
    float extent = length(capsule.p1 - capsule.p0) + capsule.radius;
    p = point.position;
    e1 = extent * frame.x;
    e2 = extent * frame.y;
}

// `ray` is the ray that found the hit.
INLINE SurfaceInteraction SurfaceAt(Hit hit, Ray ray) {
    InstanceRecord instance = InstanceAt(hit.instance);
    GeometryRecord geometry = geometries.at[GeometryIndex(instance, hit.primitive)];
    MaterialRecord material = materials.at[geometry.material];
    Triangle triangle = WithTexCoords(TriangleAt(instance, hit.primitive, hit.barycentrics), geometry);

    // Position from the vertices, so that its error does not grow with the ray's length
    vec3 p0, e1, e2, p;
    if (IsRound(instance)) {
        TangentPlaneAt(CapsuleAt(instance, hit.primitive), hit.barycentrics, p, e1, e2);
        p0 = p;
    } else {
        Vec3Stream positions = Vec3Stream(instance.positions);
        p0 = positions.at[triangle.vertices.x];
        e1 = positions.at[triangle.vertices.y] - p0;
        e2 = positions.at[triangle.vertices.z] - p0;
        p = p0 + triangle.weights.y * e1 + triangle.weights.z * e2;
    }
    SurfaceInteraction surface;
    surface.instanceOrigin = instance.objectToWorld[3];
    surface.fromInstance = mat3(instance.objectToWorld) * p;
    surface.position = surface.fromInstance + surface.instanceOrigin;
    surface.clearance =
        RayClearance(mat3(instance.objectToWorld), instance.objectToWorld[3], p0, e1, e2, p);

    if (HasTraceFeature(kTraceTextureLod) && !IsRound(instance))
        FindFootprint(triangle, instance, geometry, p0, e1, e2, ray, hit.t);

    // Normals, on the side the ray came from
    vec3 ng = GeometricNormalAt(instance, e1, e2, -ray.direction);
    vec3 ns = ShadingNormalAt(instance, geometry, material, triangle, e1, e2, ng);
    surface.isFront = dot(ng, ray.direction) <= 0.0f;
    if (!surface.isFront) {
        ng = -ng;
        ns = -ns;
    }
    surface.geometricNormal = ng;
    surface.shadingNormal = AdaptShadingNormal(ns, ng, -ray.direction);

    if (HasTraceFeature(kTraceTextureLod)) {
        float curvature = CurvatureAt(hit, instance, geometry, triangle, e1, e2);
        surface.curvature = surface.isFront ? curvature : -curvature;
    }

    surface.emission = EmissionAt(geometry, material, triangle);
    surface.light = LightOf(instance, hit.primitive, surface.lightTriangle);
    surface.material = MaterialInputs(geometry, material, triangle);
    if (HasTraceFeature(kTraceClearcoat))
        surface.coatNormal =
            CoatNormalAt(instance, geometry, material, triangle, e1, e2, ng, surface.isFront, -ray.direction);
    if (HasTraceFeature(kTraceAnisotropy)) {
        vec3 anisotropy = AnisotropyAt(geometry, material, triangle);
        surface.material.anisotropy = anisotropy.z;
        surface.stretch = vec3(0.0f);
        vec2 direction = vec2(anisotropy);
        if (anisotropy.z > 0.0f)
            surface.stretch = StretchToWorld(instance, geometry, material, triangle, e1, e2, direction);
    }
    if ((material.flags & kMaterialUnlit) != 0u) surface.emission += surface.material.baseColor;
    if (HasTraceFeature(kTraceShadowTerminator))
        BendSurface(surface, instance, geometry, triangle, p, p0, p0 + e1, p0 + e2, -ray.direction);
    return surface;
}

SHADING_END

#endif
