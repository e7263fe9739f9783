#include "tests/support/exact_trace.h"

#include <cmath>

namespace raygraph {
namespace {

// Relative to the coordinates, of what tracing in float may be off by.
constexpr double kTolerance = 2e-6;

struct Candidate {
    double t = 0.0;
    double doubt = 0.0;  // rounding error of t
    uint32_t instance = 0;
    uint32_t primitive = 0;
    bool isAtEdge = false;  // the ray may as well miss it
};

// The ray against a triangle in double precision; false if it misses it by more than the tolerance.
bool Meet(const glm::dvec3& origin, const glm::dvec3& d, const glm::dvec3 (&p)[3], double scale,
          Candidate& candidate) {
    const glm::dvec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double length = glm::length(d), area = glm::length(normal);
    const double det = glm::dot(normal, d);
    if (area == 0.0 || det == 0.0) return false;
    const double t = glm::dot(normal, p[0] - origin) / det;
    const double cosine = std::abs(det) / (area * length);
    const double tolerance = kTolerance * (scale + std::abs(t) * length);
    // The distance of the ray's line from each edge's, positive inside
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 a = p[i] - origin, edge = p[(i + 1) % 3] - p[i];
        const glm::dvec3 across = glm::cross(d, edge);
        const double size = glm::length(across);
        if (size == 0.0) continue;
        least = std::min(least, std::copysign(1.0, det) * glm::dot(across, -a) / size);
    }
    if (least < -tolerance) return false;
    candidate.t = t;
    candidate.doubt = tolerance / (length * std::max(cosine, 1e-6));
    candidate.isAtEdge = least < tolerance;
    return true;
}

bool IntersectsBox(const glm::dvec3& origin, const glm::dvec3& d, const Box& box, double margin) {
    double tNear = 0.0, tFar = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const double low = double{box.min[axis]} - margin, high = double{box.max[axis]} + margin;
        if (d[axis] == 0.0) {
            if (origin[axis] < low || origin[axis] > high) return false;
            continue;
        }
        const double a = (low - origin[axis]) / d[axis], b = (high - origin[axis]) / d[axis];
        tNear = std::max(tNear, std::min(a, b));
        tFar = std::min(tFar, std::max(a, b));
    }
    return tNear <= tFar;
}

std::vector<Box> InstanceBoxes(const BvhScene& scene) {
    std::vector<Box> ofMeshes(scene.meshes.size()), boxes(scene.instances.size());
    for (size_t i = 0; i < scene.meshes.size(); ++i)
        for (const glm::vec3& position : scene.meshes[i].positions) ofMeshes[i].Extend(position);
    for (size_t i = 0; i < boxes.size(); ++i)
        boxes[i] = PlacedBox(ofMeshes[scene.instances[i].mesh], scene.instances[i].objectToWorld);
    return boxes;
}

}  // namespace

ExactHit TraceExactly(const BvhScene& scene, const gpu::BenchRay& ray) {
    const glm::dvec3 origin(ray.origin), d(ray.direction);
    const std::vector<Box> boxes = InstanceBoxes(scene);
    std::vector<Candidate> candidates;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const BvhInstance& instance = scene.instances[i];
        const BvhMesh& mesh = scene.meshes[instance.mesh];
        const double scale = std::max(glm::length(origin), std::max(glm::length(glm::dvec3(boxes[i].min)),
                                                                    glm::length(glm::dvec3(boxes[i].max))));
        if (!IntersectsBox(origin, d, boxes[i], 10.0 * kTolerance * scale)) continue;
        const glm::dmat4x3 toWorld(instance.objectToWorld);
        for (uint32_t triangle = 0; triangle < mesh.TriangleCount(); ++triangle) {
            glm::dvec3 p[3];
            for (uint32_t corner = 0; corner < 3; ++corner)
                p[corner] = toWorld *
                            glm::dvec4(glm::dvec3(mesh.positions[mesh.indices[3 * triangle + corner]]), 1.0);
            Candidate candidate{.instance = i, .primitive = triangle};
            if (!Meet(origin, d, p, scale, candidate)) continue;
            if (candidate.t < -candidate.doubt || candidate.t > double{ray.tMax} + candidate.doubt) continue;
            candidates.push_back(candidate);
        }
    }
    // The nearest one that is in no doubt; those that might be nearer make it doubtful
    ExactHit hit;
    const Candidate* nearest = nullptr;
    const auto isUnambiguous = [&](const Candidate& c) {
        return !c.isAtEdge && c.t > c.doubt && c.t < double{ray.tMax} - c.doubt;
    };
    for (const Candidate& candidate : candidates)
        if (isUnambiguous(candidate) && (!nearest || candidate.t < nearest->t)) nearest = &candidate;
    if (nearest) hit = {nearest->t, nearest->instance, nearest->primitive, false};
    for (const Candidate& candidate : candidates)
        if (&candidate != nearest &&
            (!nearest || candidate.t - candidate.doubt <= nearest->t + nearest->doubt))
            hit.isAmbiguous = true;
    return hit;
}

}  // namespace raygraph
