// The kinds of ray, named once. Order is the order of groups in every shader binding table: ray type t uses
// miss group t and, within an instance's records, hit group t. To add a type, add a line to the list.
//   C++:  raygraph::RayType::Shadow, raygraph::kRayTypeCount
//   GLSL: kRayTypeShadow, kRayTypeCount
#ifndef RAYGRAPH_SHARED_RAY_TYPES_H
#define RAYGRAPH_SHARED_RAY_TYPES_H

// Radiance: finds the nearest surface; its closest-hit returns what was hit, its miss that nothing was.
// Shadow:   tests whether two points are mutually visible; ends at the first hit and skips closest-hit.
#define RAYGRAPH_RAY_TYPES(X) \
    X(Radiance, 0)            \
    X(Shadow, 1)

#define RAYGRAPH_COUNT_RAY_TYPE(name, value) +1

// Hit sets: which groups of a pipeline the hits of an instance run.
#define RAYGRAPH_HIT_SET_TRIANGLES 0
#define RAYGRAPH_HIT_SET_CAPSULES  1
// A bit that the masks of round primitives lack: rays with it alone meet only triangles.
#define RAYGRAPH_MASK_TRIANGLES 1

#ifdef __cplusplus

#include <cstdint>

namespace raygraph {

#define RAYGRAPH_DECLARE_RAY_TYPE(name, value) name = value,
enum class RayType : uint32_t { RAYGRAPH_RAY_TYPES(RAYGRAPH_DECLARE_RAY_TYPE) };
#undef RAYGRAPH_DECLARE_RAY_TYPE

inline constexpr uint32_t kRayTypeCount = RAYGRAPH_RAY_TYPES(RAYGRAPH_COUNT_RAY_TYPE);
inline constexpr uint32_t kHitSetTriangles = RAYGRAPH_HIT_SET_TRIANGLES;
inline constexpr uint32_t kHitSetCapsules = RAYGRAPH_HIT_SET_CAPSULES;
// Returns the TlasInstance::hitRecord that selects a hit set.
constexpr uint32_t FirstHitRecord(uint32_t hitSet) {
    return hitSet * kRayTypeCount;
}
inline constexpr uint8_t kMaskTriangles = RAYGRAPH_MASK_TRIANGLES;

}  // namespace raygraph

#else

#define RAYGRAPH_DECLARE_RAY_TYPE(name, value) const uint kRayType##name = value;
RAYGRAPH_RAY_TYPES(RAYGRAPH_DECLARE_RAY_TYPE)
#undef RAYGRAPH_DECLARE_RAY_TYPE

const uint kRayTypeCount = uint(RAYGRAPH_RAY_TYPES(RAYGRAPH_COUNT_RAY_TYPE));
const uint kMaskTriangles = RAYGRAPH_MASK_TRIANGLES;

#endif

#undef RAYGRAPH_COUNT_RAY_TYPE
#undef RAYGRAPH_HIT_SET_TRIANGLES
#undef RAYGRAPH_HIT_SET_CAPSULES
#undef RAYGRAPH_MASK_TRIANGLES

#endif
