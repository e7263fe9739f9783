// The kinds of ray, named once. Order is the order of groups in every shader binding table: ray type t uses
// miss group t and, within an instance's records, hit group t. To add a type, add a line to the list.
//   C++:  raygraph::RayType::Shadow, raygraph::kRayTypeCount
//   GLSL: kRayTypeShadow, kRayTypeCount
// Hit sets and instance masks are here, too. docs/write-a-pass.md tells how a host uses its part of them.
#ifndef RAYGRAPH_SHARED_RAY_TYPES_H
#define RAYGRAPH_SHARED_RAY_TYPES_H

// Radiance: finds the nearest surface; its closest-hit returns what was hit, its miss that nothing was.
// Shadow:   tests whether two points are mutually visible; ends at the first hit and skips closest-hit.
// Host0 to Host5: for passes of a host. Raygraph's own passes trace none of them.
#define RAYGRAPH_RAY_TYPES(X) \
    X(Radiance, 0)            \
    X(Shadow, 1)              \
    X(Host0, 2)               \
    X(Host1, 3)               \
    X(Host2, 4)               \
    X(Host3, 5)               \
    X(Host4, 6)               \
    X(Host5, 7)

#define RAYGRAPH_COUNT_RAY_TYPE(name, value) +1

// Bits of the mask of an instance. One that is visible has the bit of its kind, whatever its host bits are:
// rays with the mask 0xFF, as Raygraph's own, meet every visible instance. An invisible instance has no bit.
#define RAYGRAPH_MASK_TRIANGLES 0x01  // triangles
#define RAYGRAPH_MASK_ROUND     0x02  // round primitives
#define RAYGRAPH_MASK_HOST      0xFC  // the host's: GpuScene::SetHostMask

#ifdef __cplusplus

#include <cstdint>

namespace raygraph {

#define RAYGRAPH_DECLARE_RAY_TYPE(name, value) name = value,
enum class RayType : uint32_t { RAYGRAPH_RAY_TYPES(RAYGRAPH_DECLARE_RAY_TYPE) };
#undef RAYGRAPH_DECLARE_RAY_TYPE

inline constexpr uint32_t kRayTypeCount = RAYGRAPH_RAY_TYPES(RAYGRAPH_COUNT_RAY_TYPE);

// --- Hit sets: which groups of a pipeline the hits of an instance run ---
// A set is that of a host's number and a kind of primitives. Number 0 is Raygraph's own, which instances have
// by default; GpuScene::SetHitSet gives them another one. Where a pass has no group for the number of an
// instance, it takes the group of number 0: every table has records for all sets, and no hit misses one.
inline constexpr uint32_t kHitSetTriangles = 0, kHitSetCapsules = 1;  // those of number 0
inline constexpr uint32_t kHitSetKinds = 2;
inline constexpr uint32_t kHitSetNumbers = 16;
inline constexpr uint32_t kHitSetCount = kHitSetNumbers * kHitSetKinds;
// Returns the hit set of a number below kHitSetNumbers; `kind` is kHitSetTriangles or kHitSetCapsules.
constexpr uint32_t HitSetOf(uint32_t number, uint32_t kind = kHitSetTriangles) {
    return number * kHitSetKinds + kind;
}
// Returns the TlasInstance::hitRecord that selects a hit set.
constexpr uint32_t FirstHitRecord(uint32_t hitSet) {
    return hitSet * kRayTypeCount;
}

inline constexpr uint8_t kMaskTriangles = RAYGRAPH_MASK_TRIANGLES;
inline constexpr uint8_t kMaskRound = RAYGRAPH_MASK_ROUND;
inline constexpr uint8_t kMaskHost = RAYGRAPH_MASK_HOST;

}  // namespace raygraph

#else

#define RAYGRAPH_DECLARE_RAY_TYPE(name, value) const uint kRayType##name = value;
RAYGRAPH_RAY_TYPES(RAYGRAPH_DECLARE_RAY_TYPE)
#undef RAYGRAPH_DECLARE_RAY_TYPE

const uint kRayTypeCount = uint(RAYGRAPH_RAY_TYPES(RAYGRAPH_COUNT_RAY_TYPE));
const uint kMaskTriangles = RAYGRAPH_MASK_TRIANGLES;
const uint kMaskRound = RAYGRAPH_MASK_ROUND;
const uint kMaskHost = RAYGRAPH_MASK_HOST;

#endif

#undef RAYGRAPH_COUNT_RAY_TYPE
#undef RAYGRAPH_MASK_TRIANGLES
#undef RAYGRAPH_MASK_ROUND
#undef RAYGRAPH_MASK_HOST

#endif
