// Next event estimation: light that is sampled at a vertex of a path. Its transmittance on the way through
// media is in share_through_media.glsl.
//
// Bridge: MediumAt, see integrator/path.glsl.
#ifndef RAYGRAPH_INTEGRATOR_DIRECT_LIGHT_GLSL
#define RAYGRAPH_INTEGRATOR_DIRECT_LIGHT_GLSL

#include "bxdf/bsdf.glsl"
#include "core/frame.glsl"
#include "core/ray_offset.glsl"
#include "integrator/media.glsl"
#include "integrator/path_parts.glsl"
#include "integrator/segment.glsl"
#include "lights/shadow_ray.glsl"
#include "scene/ray.glsl"

SHADING_BEGIN

// Light from one point of one light, scattered by a surface or a medium to the camera, if it is not occluded.
struct DirectLight {
    Ray ray;
    float distance;  // distance that must be unoccluded; 0: no light
    float ior;       // index of the medium on the way
    vec3 radiance;   // 0: no light
    FirstLobe lobe;  // lobe of the path, if kKeepsParts
    uint light;      // number of the light
    uint triangle;   // for a mesh: the triangle within it
    MediumStack media;   // where the ray starts; these two are set if kTraceMatchedMedia is
    SegmentStart start;
};

INLINE DirectLight NoDirectLight() {
    DirectLight direct;
    direct.ray.origin = vec3(0.0f);
    direct.ray.direction = vec3(0.0f, 0.0f, 1.0f);
    direct.distance = 0.0f;
    direct.ior = 1.0f;
    direct.radiance = vec3(0.0f);
    direct.lobe = NoLobe();
    direct.light = kNoLight;
    direct.triangle = 0u;
    direct.media = NoMedia();
    direct.start = StartAtCamera();
    return direct;
}

// Returns whether light goes straight on at that boundary, which is real.
INLINE bool IsIndexMatched(SurfaceMaterial material, Boundary boundary, float wavelength) {
    return HasTraceFeature(kTraceMatchedMedia) &&
           IsIndexMatched(material, AreAlike(boundary, wavelength));
}

SHADING_END

#endif
