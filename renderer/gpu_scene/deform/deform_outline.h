// The host's data of deformed meshes: which deformed copies a scene needs (DeformPlan), and the part of
// a deformed group's geometry that the host keeps (DeformOutline). Threads: pure functions; objects as
// std::vector.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/gpu_scene/lights/emitters.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph {

struct OutlinePose {
    // In object space. It contains all vertices that a view can show, is finite, and is very large where some
    // vertices may be beyond the range of floats.
    scene::Bounds bounds;
    std::vector<glm::vec3> emitters;  // three a triangle that emits, in their order
    float emitterError = 0.0f;        // bound of the difference between a coordinate here and on the device
    std::vector<glm::vec3> samples;   // three a triangle
    // The group encloses next to nothing now, and much more at rest: joints or targets squeeze it into a
    // plane.
    bool isFlattened = false;
};

// DeformOutline has the vertices of the triangles that emit and of a sample of all triangles (blas_set.h),
// with their joints, weights and targets, and boxes that bound the positions of all other vertices.
class DeformOutline {
  public:
    DeformOutline() = default;
    // `triangles` belong to `primitives`, which still have joints, weights and targets.
    DeformOutline(const GroupTriangles& triangles, std::span<scene::Primitive* const> primitives,
                  std::span<const Emitter> emitters);

    // Uses the formula of renderer/scene/animation/deform.h. Without a skin `jointMatrices` is empty.
    void Deform(std::span<const float> weights, std::span<const glm::mat4x3> jointMatrices,
                OutlinePose& pose) const;

  private:
    std::vector<scene::Primitive> m_parts;
    std::vector<uint32_t> m_emitters, m_samples;  // vertices, counted over all parts
    double m_fullness = 0.0;                      // fullness of the samples at rest
};

// --- Which deformed copies of its meshes a scene needs ---

// Describes a mesh as it is deformed by a skin and by the weights of a node. Instances that agree in these
// share a copy. With targets and without a node, an instance has a copy of its own.
struct DeformedCopy {
    uint32_t mesh = 0;
    uint32_t skin = scene::kNone;  // kNone: no skin deforms it
    bool hasTargets = false;       // morph targets move it
    std::vector<uint32_t> instances;
};

struct DeformPlan {
    std::vector<DeformedCopy> copies;  // by mesh, ascending
    std::vector<uint32_t> copyOf;      // by instance; kNone: it is not deformed
    // By mesh: some instance of it is not deformed, or it has no instance.
    std::vector<bool> isBaseShapeDrawn;
};

// Must be called before the scene's meshes are consumed.
DeformPlan PlanDeformation(const scene::SceneData& scene);

}  // namespace raygraph
