#include "renderer/gpu_scene/lights/light_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/gpu_scene/lights/light_bvh.h"
#include "renderer/gpu_scene/lights/light_table.h"
#include "renderer/scene/geometry/transforms.h"
#include "shaders/shared/ray_clearance.h"

namespace raygraph {

namespace {

// Weights are relative to the greatest, and at least this: every triangle that shines can be chosen.
constexpr double kMinWeight = 1e-30;
constexpr double kCosineRounding = 1e-6;

}  // namespace

LightMesh::LightMesh(std::span<const Emitter> emitters, std::span<const glm::vec3> emission,
                     std::span<const uint32_t> groups) {
    std::vector<double> weights;
    if (!emitters.empty()) m_first = emitters.front();
    for (const Emitter& emitter : emitters) {
        gpu::LightRecord light{.p0 = emitter.p0,
                               .kind = gpu::kLightTriangle,
                               .e1 = emitter.p1 - emitter.p0,
                               .e2 = emitter.p2 - emitter.p0,
                               .primitive = emitter.primitive};
        if (emitter.isDoubleSided) light.flags |= gpu::kLightDoubleSided;
        if (emitter.material < groups.size())
            light.flags |= groups[emitter.material] << gpu::kLightGroupShift;
        m_lights.push_back(light);
        const Facet facet{.area = 0.5 * glm::cross(glm::dvec3(light.e1), glm::dvec3(light.e2)),
                          .exitance = (emitter.isDoubleSided ? 2.0 : 1.0) * std::numbers::pi *
                                      Luminance(emission[emitter.material] * emitter.meanTexture)};
        weights.push_back(facet.exitance * glm::length(facet.area));
        if (!(weights.back() > 0.0 && std::isfinite(weights.back()))) {
            weights.back() = 0.0;
            continue;
        }
        m_facets.push_back(facet);
        m_isTwoSided |= emitter.isDoubleSided;
    }
    const double greatest = weights.empty() ? 0.0 : *std::ranges::max_element(weights);
    for (double& weight : weights)
        if (weight > 0.0) weight = std::max(weight / greatest, kMinWeight);

    const std::vector<float> power(weights.begin(), weights.end());
    const LightTree tree = BuildLightTree(m_lights, power);
    m_nodes = tree.Nodes();
    if (!m_nodes.empty()) {
        m_axis = glm::dvec3(m_nodes[0].axis);
        m_min = m_nodes[0].boundsMin;
        m_max = m_nodes[0].boundsMax;
    }
    m_alias.resize(weights.size());
    BuildAliasTable(weights, m_alias);
    for (uint32_t i = 0; i < weights.size(); ++i)
        if (weights[i] > 0.0) m_alias.push_back({.keep = 1.0f, .alias = i, .probability = 0.0f});
}

void LightMesh::PlaceBox(const glm::mat4x3& objectToWorld, LightBounds& bounds) const {
    bounds.min = LightBounds().min;
    bounds.max = LightBounds().max;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p((corner & 1) != 0 ? m_max.x : m_min.x, (corner & 2) != 0 ? m_max.y : m_min.y,
                           (corner & 4) != 0 ? m_max.z : m_min.z);
        const glm::vec3 placed = glm::dmat4x3(objectToWorld) * glm::dvec4(p, 1.0);
        bounds.min = glm::min(bounds.min, placed);
        bounds.max = glm::max(bounds.max, placed);
    }
}

LightBounds LightMesh::Placed(const glm::mat4x3& objectToWorld) const {
    LightBounds bounds;
    PlaceBox(objectToWorld, bounds);
    const glm::dvec3 x(objectToWorld[0]), y(objectToWorld[1]), z(objectToWorld[2]);
    // Area vectors transform by the cofactors; a front face stays a front face under mirroring
    glm::dmat3 cofactors(glm::cross(y, z), glm::cross(z, x), glm::cross(x, y));
    if (glm::dot(x, cofactors[0]) < 0.0) cofactors = -cofactors;
    const glm::dvec3 axis = cofactors * m_axis;
    const double length = glm::length(axis);
    if (length > 0.0) bounds.axis = axis / length;
    double leastCosine = length > 0.0 ? 1.0 : -1.0;
    for (const Facet& facet : m_facets) {
        const glm::dvec3 area = cofactors * facet.area;
        const double size = glm::length(area);
        if (!(size > 0.0)) continue;
        bounds.power += facet.exitance * size;
        leastCosine = std::min(leastCosine, glm::dot(area, bounds.axis) / size);
    }
    bounds.thetaO = std::acos(std::clamp(leastCosine - kCosineRounding, -1.0, 1.0));
    bounds.thetaE = 0.5 * std::numbers::pi;
    bounds.isTwoSided = m_isTwoSided;
    return bounds;
}

// --- Triangles as lights ---

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
