// FacetScene traces rays on the host against triangles of placed meshes. Threads: the constructor starts
// threads of its own; const calls may come from any thread, if the test of facets may.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "renderer/bvh/binary_bvh.h"
#include "renderer/bvh/wide_scene.h"

namespace raygraph {

struct Facet {
    glm::vec3 p0{0.0f}, p1{0.0f}, p2{0.0f};
    bool isBackCulled = false;  // rays pass through from behind
    bool isTested = false;      // the scene's FacetTest decides which rays pass through
};

// Returns whether a ray is stopped by a facet that isTested, at these barycentric coordinates of p1 and p2.
using FacetTest = std::function<bool(uint32_t instance, uint32_t facet, const glm::vec2& barycentrics)>;

struct FacetHit {
    float t = 0.0f;  // distance, in lengths of the ray's direction
    uint32_t instance = 0, facet = 0;
    glm::vec2 barycentrics{0.0f};  // weights of p1 and p2
    glm::vec3 normal{0.0f};        // unit length, in world space, on the side that the ray comes from
};

class FacetScene {
  public:
    // `meshes` has the finite facets of each mesh, in object space. Instances whose transforms have no
    // inverse are never hit. Without a test, facets that are tested stop all rays.
    FacetScene(std::vector<std::vector<Facet>> meshes, std::vector<BvhInstance> instances,
               uint32_t maxThreads = 0, FacetTest test = {});

    // Returns the nearest hit with a positive t.
    std::optional<FacetHit> Trace(const glm::vec3& origin, const glm::vec3& direction) const;
    // Returns whether any facet is hit with t in (0, tMax).
    bool IsOccluded(const glm::vec3& origin, const glm::vec3& direction, float tMax) const;
    const std::vector<Facet>& FacetsOf(uint32_t mesh) const { return m_meshes[mesh].facets; }
    const std::vector<BvhInstance>& Instances() const { return m_instances; }
    const Box& Bounds() const { return m_bounds; }  // around all instances that can be hit

  private:
    struct Mesh {
        std::vector<Facet> facets;
        BinaryBvh tree;
    };
    template <bool isAny>
    std::optional<FacetHit> Find(const glm::vec3& origin, const glm::vec3& direction, float tMax) const;

    std::vector<Mesh> m_meshes;
    std::vector<BvhInstance> m_instances;
    std::vector<uint32_t> m_hittable;     // by primitive of m_tree: the index of the instance
    std::vector<glm::mat4x3> m_toObject;  // by primitive of m_tree: from world to object space
    BinaryBvh m_tree;
    Box m_bounds;
    FacetTest m_test;
};

}  // namespace raygraph
