// The origin of a ray that leaves a surface, offset so that it does not hit the surface again.
#ifndef RAYGRAPH_CORE_RAY_OFFSET_GLSL
#define RAYGRAPH_CORE_RAY_OFFSET_GLSL

#include "core/glue.h"
#include "shared/ray_clearance.h"

#ifdef __cplusplus
namespace raygraph::shading {
using gpu::kRoundoff;
using gpu::RayClearance;
}
#endif

SHADING_BEGIN

// p: a point on the surface, from the vertices and barycentrics (not from origin + t * direction). n: the
// unit geometric normal on the side the new ray goes to. clearance: RayClearance of the point, which includes
// the rounding of this sum.
INLINE vec3 OffsetRayOrigin(vec3 p, vec3 n, float clearance) { return p + clearance * n; }

SHADING_END

#endif
