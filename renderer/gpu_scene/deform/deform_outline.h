// What the host keeps of a group that deforms: the vertices of the triangles that emit, and of a sample of
// all triangles (refit_quality.h), with what moves them; and the boxes that bound where the others may be.
// Threads: as std::vector.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/gpu_scene/lights/emitters.h"
#include "renderer/scene/animation/deform.h"

namespace raygraph {

struct OutlinePose {
    // Object space; contains all vertices that a view can show. Finite, and very large where some may be
    // beyond the numbers.
    scene::Bounds bounds;
    std::vector<glm::vec3> emitters;  // three a triangle that emits, in their order
    float emitterError = 0.0f;        // of each of their coordinates, against those on the device
    std::vector<glm::vec3> samples;   // three a triangle
    // The group encloses next to nothing, and much more at rest: joints or targets squeeze it into a plane.
    bool isFlattened = false;
};

class DeformOutline {
  public:
    DeformOutline() = default;
    // `triangles` are those of `primitives`, which still have joints, weights and targets.
    DeformOutline(const GroupTriangles& triangles, std::span<scene::Primitive* const> primitives,
                  std::span<const Emitter> emitters);

    // By the formula of renderer/scene/animation/deform.h. Without a skin `jointMatrices` is empty.
    void Deform(std::span<const float> weights, std::span<const glm::mat4x3> jointMatrices,
                OutlinePose& pose) const;

  private:
    std::vector<scene::Primitive> m_parts;
    std::vector<uint32_t> m_emitters, m_samples;  // vertices, counted over all parts
    double m_fullness = 0.0;                      // of the samples, at rest
};

}  // namespace raygraph
