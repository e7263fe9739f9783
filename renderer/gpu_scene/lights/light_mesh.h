// Emitting triangles: each as a light of its own, or those of a mesh that is placed often as a LightMesh.
// Threads: pure functions; LightMesh: as std::vector.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/gpu_scene/lights/light_bounds.h"
#include "shaders/shared/light_records.h"

namespace raygraph {

// Describes a triangle that emits if its material does, in object space.
struct Emitter {
    glm::vec3 p0{0.0f}, p1{0.0f}, p2{0.0f};
    uint32_t primitive = 0;  // its number in the BLAS
    uint32_t material = 0;
    bool isDoubleSided = false;   // its back face emits, too
    glm::vec3 meanTexture{1.0f};  // mean of the emissive texture over the triangle, linear
    float error = 0.0f;           // bound of the difference between a coordinate here and on the device
    bool isOnClosedMesh = false;  // its mesh is closed (Enclosure)
    bool isThin = false;          // its mesh is thin at rest
    bool isFlattened = false;     // the pose flattens its mesh, see OutlinePose
};

// Tells whether light sampling ignores the emitter's back side, because it faces the inside of a closed mesh
// that is thin, or that its pose or the transform flattens, so that the opposite side of the mesh occludes
// it. Shadow rays cannot detect that, as they stop short of the light by more than the thickness. Paths that
// hit the back anyway count its emission in full.
bool IsBackInside(const Emitter& emitter, const glm::mat4x3& objectToWorld);

// Returns the luminance of a color.
double Luminance(const glm::vec3& color);

// Returns the triangle as `objectToWorld` places it, for the instance with that record.
gpu::LightRecord TriangleLight(const Emitter& emitter, uint32_t record, const glm::mat4x3& objectToWorld);

// Returns the power in luminance, W; `meanRadiance` is before the texture. 0 for a triangle without area.
double TrianglePower(const gpu::LightRecord& light, const glm::vec3& meanRadiance);

// LightMesh: the emitting triangles of a mesh that is placed often, stored once for all placements. Each
// placement is one light.
class LightMesh {
  public:
    // Both spans are by material: `emission` is radiance before the texture, `groups` are light groups
    // (empty: all are kLightGroupRest).
    LightMesh(std::span<const Emitter> emitters, std::span<const glm::vec3> emission,
              std::span<const uint32_t> groups);

    // In object space, one per triangle.
    const std::vector<gpu::LightRecord>& Lights() const { return m_lights; }
    // Indices of children count from the first node, those of lights from the first triangle.
    const std::vector<gpu::LightNode>& Nodes() const { return m_nodes; }
    // Returns the two alias tables of a mesh, without offsets: see light_records.h.
    const std::vector<gpu::AliasEntry>& Alias() const { return m_alias; }
    uint32_t ActiveCount() const { return static_cast<uint32_t>(m_facets.size()); }
    // Tells whether a placement of the mesh by this transform has the flag gpu::kLightOutward.
    bool IsOutward(const glm::mat4x3& objectToWorld) const { return IsBackInside(m_first, objectToWorld); }

    // Returns the bounds of all triangles together, as placed. The power is exact up to rounding, and so is
    // the cone if the transform only rotates and scales; the box is around the transformed box of the mesh.
    // O(triangles that shine).
    LightBounds Placed(const glm::mat4x3& objectToWorld) const;
    // Sets the box of these bounds alone. O(1).
    void PlaceBox(const glm::mat4x3& objectToWorld, LightBounds& bounds) const;

  private:
    // Describes a triangle that shines.
    struct Facet {
        glm::dvec3 area{0.0};   // along the normal
        double exitance = 0.0;  // luminance, W/m^2, over both sides if both emit
    };

    std::vector<gpu::LightRecord> m_lights;
    std::vector<gpu::LightNode> m_nodes;
    std::vector<gpu::AliasEntry> m_alias;
    std::vector<Facet> m_facets;
    glm::dvec3 m_axis{0.0, 0.0, 1.0};  // middle of the normals
    glm::vec3 m_min{0.0f}, m_max{0.0f};
    bool m_isTwoSided = false;  // some facet emits on both sides
    Emitter m_first;
};

}  // namespace raygraph
