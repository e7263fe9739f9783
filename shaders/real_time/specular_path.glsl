// The path of a camera ray along mirrors and through clear glass, to what they show: at each surface it takes
// the more likely one of reflection and refraction. Its differentials tell where its end was seen before.
#ifndef RAYGRAPH_REAL_TIME_SPECULAR_PATH_GLSL
#define RAYGRAPH_REAL_TIME_SPECULAR_PATH_GLSL

#include "real_time/surface.glsl"
#include "scene/alpha_test.glsl"
#include "scene/surface.glsl"
#include "scene/trace_rays.glsl"

#include "bxdf/fresnel.glsl"
#include "core/frame.glsl"
#include "integrator/media.glsl"

// Roughness up to which a surface shows a picture, and up to which colors in that are sharp.
const float kSharp = 0.2f;
const float kSharpest = 0.1f;
const uint kMostEvents = 4u;     // surfaces that a path meets on its way
const float kLeastShare = 0.5f;  // where less light goes one way, no picture stands out
const float kLeastShownDullness = 0.25f;

// How the origin and the direction of a ray change. Igehy 1999, "Tracing Ray Differentials".
struct RayDifferential {
    vec3 origin, direction;
};

struct SpecularPath {
    Ray ray;
    MediumStack media;
    vec3 tint;       // what the surfaces and media on it leave of the light
    float share;     // of all light that goes this way
    float roughest;  // roughness of its surfaces
    float covered;   // meters to the ray's origin
    uint events;     // surfaces met
    uint key;        // a hash of them
    // Rays that leave the camera in another direction, by a unit along x and y of the first ray's frame, and
    // rays that leave as far beside it.
    RayDifferential turned[2], beside[2];
};

// The camera is taken to be outside of all media: a surface that is left says what was inside.
SpecularPath StartSpecularPath(Ray ray) {
    Frame frame = FrameFromZ(ray.direction);
    const vec3 none = vec3(0.0f);
    SpecularPath path;
    path.ray = ray;
    path.media = NoMedia();
    path.tint = vec3(1.0f);
    path.share = 1.0f;
    path.roughest = 0.0f;
    path.covered = 0.0f;
    path.events = 0u;
    path.key = 0u;
    path.turned[0] = RayDifferential(none, frame.x);
    path.turned[1] = RayDifferential(none, frame.y);
    path.beside[0] = RayDifferential(frame.x, none);
    path.beside[1] = RayDifferential(frame.y, none);
    return path;
}

// The albedo of a layer that reflects 4 % over a base of that color.
vec3 AlbedoOf(vec3 baseColor) { return mix(baseColor, vec3(1.0f), 0.04f); }

// 1 for a surface whose light looks alike from all sides, down to 0 for a mirror and clear glass.
float DullnessOf(SurfaceMaterial material) {
    float polished = 1.0f - smoothstep(0.3f, 1.0f, material.roughness);
    return 1.0f - max(material.metallic, material.transmission) * polished;
}

bool IsMetalOrClear(SurfaceMaterial material) { return max(material.metallic, material.transmission) > 0.5f; }

// A number of an instance and a material: neighbors with the same are only likely to be of one. Paint on
// metal, in one material with it, reflects other light.
uint KeyOf(InstanceRecord instance, SurfaceMaterial material) {
    return instance.instance * 7919u + 2u * material.id + (IsMetalOrClear(material) ? 1u : 0u);
}

// Returns whether the surface shows others.
bool ShowsOthers(SurfaceMaterial material) {
    if (!HasTraceFeature(kTraceMetals | kTraceGlass)) return false;
    if ((material.flags & kMaterialUnlit) != 0u || material.roughness > kSharp) return false;
    if (material.metallic > 0.5f) return HasTraceFeature(kTraceMetals);
    if (!HasTraceFeature(kTraceGlass) || material.transmission <= 0.5f) return false;
    bool scatters = HasTraceFeature(kTraceScattering) && (material.flags & kMaterialVolume) != 0u &&
                    any(greaterThan(MediumAt(material.id).scattering, vec3(0.0f)));
    return !scatters;
}

// Returns whether the path has a next part from the surface that its ray has hit.
bool GoesOn(SpecularPath path, SurfaceMaterial material) {
    return path.events < kMostEvents && path.share > kLeastShare && ShowsOthers(material);
}

// Holds how the normal of a surface changes along it, by its vertex normals; capsules count as flat.
struct Bend {
    vec3 e1, e2;  // edges of the triangle, in world space
    vec3 n1, n2;  // change of the normal along them, over its length
};

Bend BendAt(Hit hit, SurfaceInteraction surface) {
    InstanceRecord instance = InstanceAt(hit.instance);
    GeometryRecord geometry = geometries.at[GeometryIndex(instance, hit.primitive)];
    Bend bend = Bend(vec3(0.0f), vec3(0.0f), vec3(0.0f), vec3(0.0f));
    if (IsRound(instance) || !IsPresent(geometry.normals)) return bend;
    Triangle triangle = TriangleAt(instance, hit.primitive, hit.barycentrics);
    Vec3Stream positions = Vec3Stream(instance.positions), normals = Vec3Stream(geometry.normals);
    vec3 p0 = positions.at[triangle.vertices.x];
    bend.e1 = mat3(instance.objectToWorld) * (positions.at[triangle.vertices.y] - p0);
    bend.e2 = mat3(instance.objectToWorld) * (positions.at[triangle.vertices.z] - p0);
    vec3 n0 = NormalToWorld(instance.objectToWorld, normals.at[triangle.vertices.x]);
    bend.n1 = NormalToWorld(instance.objectToWorld, normals.at[triangle.vertices.y]) - n0;
    bend.n2 = NormalToWorld(instance.objectToWorld, normals.at[triangle.vertices.z]) - n0;
    vec3 normal = n0 + hit.barycentrics.x * bend.n1 + hit.barycentrics.y * bend.n2;
    float scale = InverseLength(normal) * (dot(normal, surface.shadingNormal) < 0.0f ? -1.0f : 1.0f);
    bend.n1 *= scale;
    bend.n2 *= scale;
    return bend;
}

// Returns how the unit normal changes over a way along the surface.
vec3 NormalChange(Bend bend, vec3 normal, vec3 way) {
    float xx = dot(bend.e1, bend.e1), xy = dot(bend.e1, bend.e2), yy = dot(bend.e2, bend.e2);
    float x = dot(bend.e1, way), y = dot(bend.e2, way), determinant = xx * yy - xy * xy;
    if (!(determinant > 0.0f)) return vec3(0.0f);
    vec3 change = ((yy * x - xy * y) * bend.n1 + (xx * y - xy * x) * bend.n2) / determinant;
    return change - dot(change, normal) * normal;
}

// Returns the differential of the ray in `direction` from a surface that the incident ray has met after
// `distance`. eta: that of refract; 0: the ray is reflected.
RayDifferential Behind(RayDifferential ray, float distance, vec3 incident, vec3 direction,
                       SurfaceInteraction surface, Bend bend, float eta) {
    vec3 normal = surface.shadingNormal, facing = surface.geometricNormal;
    vec3 way = ray.origin + distance * ray.direction;
    way -= dot(way, facing) / dot(incident, facing) * incident;
    vec3 normalChange = NormalChange(bend, normal, way);
    float cosine = dot(incident, normal), scale = 1.0f;
    float cosineChange = dot(ray.direction, normal) + dot(incident, normalChange);
    float factor = 2.0f * cosine, factorChange = 2.0f * cosineChange;  // of the normal in the direction
    if (eta > 0.0f) {
        float behind = dot(direction, normal);
        scale = eta;
        factor = eta * cosine - behind;
        factorChange = (eta - eta * eta * cosine / behind) * cosineChange;
    }
    return RayDifferential(way, scale * ray.direction - factor * normalChange - factorChange * normal);
}

// Continues the path at the surface that its ray has hit.
void Continue(inout SpecularPath path, Hit hit, SurfaceInteraction surface, uint key) {
    float distance = hit.t;
    path.covered += distance;
    bool isVolume = (surface.material.flags & kMaterialVolume) != 0u;
    float eta = surface.material.ior;  // that on the far side over that on this side
    bool isReal = true;
    MediumStack beyond = path.media;
    if (HasTraceFeature(kTraceVolumes)) {
        path.tint *= Transmittance(CurrentMedium(path.media), distance);
        if (isVolume) {
            Boundary boundary = CrossBoundary(path.media, surface.material.id, surface.isFront);
            beyond = boundary.beyond;
            isReal = boundary.isReal;
            eta = RelativeIor(boundary, kNoWavelength);
        }
    }
    vec3 normal = surface.shadingNormal, incident = path.ray.direction, direction = incident;
    bool isThrough = surface.material.metallic <= 0.5f;
    if (isThrough && isReal) {
        float reflected = FresnelDielectric(-dot(incident, normal), eta);
        isThrough = reflected < 0.5f;
        path.share *= isThrough ? 1.0f - reflected : reflected;
    }
    if (!isReal || !isVolume) eta = 1.0f;  // thin walls do not bend what passes them
    if (isThrough && eta != 1.0f) direction = refract(incident, normal, 1.0f / eta);
    if (!isThrough) direction = reflect(incident, normal);
    bool isTinted = isThrough || surface.material.metallic > 0.5f;
    if (isReal && isTinted) path.tint *= AlbedoOf(surface.material.baseColor);
    if (isReal) path.roughest = max(path.roughest, surface.material.roughness);
    if (isThrough) path.media = beyond;
    Bend bend = BendAt(hit, surface);
    float ratio = isThrough ? 1.0f / eta : 0.0f;
    for (uint i = 0u; i < 2u; ++i) {
        path.turned[i] = Behind(path.turned[i], distance, incident, direction, surface, bend, ratio);
        path.beside[i] = Behind(path.beside[i], distance, incident, direction, surface, bend, ratio);
    }
    if (HasTraceFeature(kTraceTextureLod)) {
        path.ray.cone = AdvanceCone(path.ray.cone, distance);
        path.ray.cone = isThrough ? RefractCone(path.ray.cone, surface.curvature, eta)
                                  : ReflectCone(path.ray.cone, surface.curvature);
    }
    float side = dot(direction, surface.geometricNormal) < 0.0f ? -1.0f : 1.0f;
    path.ray.origin = OffsetRayOrigin(surface.position, side * surface.geometricNormal, surface.clearance);
    path.ray.direction = direction;
    path.key = 31u * path.key + 2u * key + (isThrough ? 1u : 0u);
    ++path.events;
}

// Returns the number of the surface that the path ends at, of that key.
uint NumberOf(SpecularPath path, uint key) {
    return (path.events == 0u ? kFirstNumber : kFirstShownNumber) + (31u * path.key + key) % kNumbers;
}

// Returns the albedo of that surface, as the path shows it. Light that goes other ways counts as white.
vec3 ShownAlbedo(SpecularPath path, SurfaceMaterial material, float distance) {
    vec3 tint = path.tint;
    if (HasTraceFeature(kTraceVolumes)) tint *= Transmittance(CurrentMedium(path.media), distance);
    if (path.roughest <= kSharpest) tint *= AlbedoOf(material.baseColor);
    return mix(vec3(1.0f), tint, path.share);
}

// Returns the place `distance` along the ray or, if that is infinite, the direction, as far as it changes.
vec3 EndOf(RayDifferential ray, bool isNear, float distance, vec3 direction) {
    if (!isNear) return ray.direction;
    vec3 end = ray.origin + distance * ray.direction;
    return end - dot(end, direction) * direction;  // what is along the ray makes no difference
}

// Returns the direction in which the end of a path from `from` is seen, by the same surfaces, from a place
// that is `shift` beside the camera, if the end moves by `endShift`. The end is `distance` along the last ray
// or, unless it is near, a direction.
vec3 DirectionFrom(SpecularPath path, vec3 from, bool isNear, float distance, vec3 shift, vec3 endShift) {
    Frame frame = FrameFromZ(from);
    vec3 direction = path.ray.direction;
    vec3 x = EndOf(path.turned[0], isNear, distance, direction);
    vec3 y = EndOf(path.turned[1], isNear, distance, direction);
    vec3 rest = endShift - dot(shift, frame.x) * EndOf(path.beside[0], isNear, distance, direction) -
                dot(shift, frame.y) * EndOf(path.beside[1], isNear, distance, direction);
    // Least squares
    float xx = dot(x, x), xy = dot(x, y), yy = dot(y, y), toX = dot(x, rest), toY = dot(y, rest);
    vec2 turn = vec2(yy * toX - xy * toY, xx * toY - xy * toX) / (xx * yy - xy * xy);
    return from + turn.x * frame.x + turn.y * frame.y;
}

#endif
