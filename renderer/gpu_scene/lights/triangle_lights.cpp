#include "renderer/gpu_scene/lights/triangle_lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/scene/geometry/flat_transform.h"
#include "renderer/scene/geometry/linear_map.h"
#include "shaders/shared/ray_clearance.h"

namespace raygraph {

namespace {

// Within these bounds, twice a triangle's area and its reciprocal are finite and normal floats.
constexpr double kMinArea = 1e-36, kMaxArea = 1e36;

// Returns the clearance of rays that end anywhere on a triangle whose record has p0, e1 and e2 in world
// space. RayClearance is convex in the point; the record adds rounding errors of its own.
float TriangleClearance(const Emitter& emitter, const glm::mat4x3& objectToWorld, const glm::vec3& p0,
                        const glm::vec3& e1, const glm::vec3& e2) {
    float clearance = 0.0f;
    for (const glm::vec3& vertex : {emitter.p0, emitter.p1, emitter.p2})
        clearance =
            std::max(clearance, gpu::RayClearance(glm::mat3(objectToWorld), objectToWorld[3], emitter.p0,
                                                  emitter.p1 - emitter.p0, emitter.p2 - emitter.p0, vertex));
    if (emitter.error > 0.0f)
        for (int axis = 0; axis < 3; ++axis) clearance += emitter.error * glm::length(objectToWorld[axis]);
    const glm::vec3 across = glm::cross(e1, e2);
    const glm::vec3 sizes = glm::abs(p0) + glm::abs(e1) + glm::abs(e2);
    return clearance + 4.0f * gpu::kRoundoff * glm::dot(glm::abs(across), sizes) * gpu::InverseLength(across);
}

}  // namespace

double Luminance(const glm::vec3& color) {
    return 0.2126 * double{color.x} + 0.7152 * double{color.y} + 0.0722 * double{color.z};
}

bool IsBackInside(const Emitter& emitter, const glm::mat4x3& objectToWorld) {
    constexpr double kFlatness = 4.0 * scene::kObliqueThickness;
    return emitter.isOnClosedMesh &&
           (emitter.isThin || emitter.isFlattened || scene::Flatness(objectToWorld) <= kFlatness);
}

gpu::LightRecord TriangleLight(const Emitter& emitter, uint32_t record, const glm::mat4x3& objectToWorld) {
    const glm::dmat3 linear{glm::dvec3(objectToWorld[0]), glm::dvec3(objectToWorld[1]),
                            glm::dvec3(objectToWorld[2])};
    const glm::vec3 p0 = linear * glm::dvec3(emitter.p0) + glm::dvec3(objectToWorld[3]);
    const glm::vec3 e1 = linear * (glm::dvec3(emitter.p1) - glm::dvec3(emitter.p0));
    const glm::vec3 e2 = linear * (glm::dvec3(emitter.p2) - glm::dvec3(emitter.p0));
    const bool isMirrored = scene::IsMirrored(objectToWorld);
    const bool isDoubleSided = emitter.isDoubleSided && !IsBackInside(emitter, objectToWorld);
    return {.p0 = p0,
            .kind = gpu::kLightTriangle,
            .e1 = e1,
            .flags = (isDoubleSided ? gpu::kLightDoubleSided : 0u) | (isMirrored ? gpu::kLightMirrored : 0u),
            .e2 = e2,
            .instance = record,
            .primitive = emitter.primitive,
            .bitTrail = 0,
            .spotScale = 0.0f,
            .spotOffsetOrClearance = TriangleClearance(emitter, objectToWorld, p0, e1, e2)};
}

double TrianglePower(const gpu::LightRecord& light, const glm::vec3& meanRadiance) {
    const double area = glm::length(glm::dvec3(glm::cross(light.e1, light.e2)));  // twice the area
    if (!(area >= kMinArea && area <= kMaxArea)) return 0.0;
    const double sides = (light.flags & gpu::kLightDoubleSided) != 0 ? 2.0 : 1.0;
    return sides * std::numbers::pi * 0.5 * area * Luminance(meanRadiance);
}

}  // namespace raygraph
