// The volumes that contain the camera.
#ifndef RAYGRAPH_INTEGRATOR_CAMERA_MEDIA_GLSL
#define RAYGRAPH_INTEGRATOR_CAMERA_MEDIA_GLSL

#include "core/ray_offset.glsl"
#include "integrator/media.glsl"
#include "shared/scene_records.h"

SHADING_BEGIN

CONST uint kMaxProbes = 256u;  // surfaces that the probe ray passes

// Follows a ray out of the scene: a volume that it leaves without having entered it contains its origin.
// Bridge: Intersect and SurfaceAt, see integrator/path.glsl.
INLINE MediumStack MediaAround(vec3 origin) {
    MediumStack around = NoMedia();
    MediumStack entered = NoMedia();
    Ray ray;
    ray.origin = origin;
    ray.direction = normalize(vec3(0.0137f, 1.0f, 0.0091f));  // off the axes: edges lie there
    ray.cone = MakeCone(0.0f, 0.0f);
    for (uint probe = 0u; probe < kMaxProbes; ++probe) {
        Hit hit = Intersect(ray, probe);
        if (!IsHit(hit)) break;
        SurfaceInteraction surface = SurfaceAt(hit, ray);
        if ((surface.material.flags & kMaterialVolume) != 0u) {
            uint id = surface.material.id;
            if (surface.isFront)
                entered = EnterMedium(entered, id);
            else if (IsInMedium(entered, id))
                entered = LeaveMedium(entered, id);
            else
                around = AppendOuterMedium(around, id);
        }
        ray.origin = OffsetRayOrigin(surface.position, -surface.geometricNormal, surface.clearance);
    }
    return around;
}

SHADING_END

#endif
