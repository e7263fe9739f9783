// Finds the triangles of a mesh that may emit, while its host copy exists. Threads: const calls may come from
// any thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <vector>

#include "renderer/gpu_scene/lights/light_table.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// Holds the triangles of a group in the order of its BLAS.
struct GroupTriangles {
    std::vector<glm::vec3> positions;
    std::vector<uint32_t> indices;
    // By triangle: its primitive within the group; empty if there is only one primitive.
    std::vector<uint32_t> geometries;
    // By triangle: its index in its primitive; empty if the order is unchanged.
    std::vector<uint32_t> originals;
    std::vector<uint32_t> firstVertices;  // indexed by primitive
};

// Holds the material of an emitter in a variant of the scene.
struct EmitterVariant {
    uint32_t emitter = 0;   // index in the group
    uint32_t geometry = 0;  // its primitive within the group
    uint32_t material = 0;
    glm::vec3 meanTexture{1.0f};
};

struct EmitterLists {
    std::vector<Emitter> emitters;
    // All materials that a primitive with variants may have, the shown one included; nothing for other
    // primitives.
    std::vector<EmitterVariant> variants;
};

// Measures the volume that triangles enclose together.
class Enclosure {
  public:
    // Measures the triangles of a mesh; round primitives are ignored.
    static Enclosure Of(const scene::Mesh& mesh);
    // `corners` has three per triangle.
    static Enclosure Of(std::span<const glm::vec3> corners);

    // Returns whether there is a volume, and the sum of the area vectors is at most a tenth of the area. The
    // area vectors of a closed mesh sum to zero, as do those of a plane figure that is wound both ways.
    bool IsClosed() const;
    // Returns the volume over area^1.5: 0.068 for a cube, and 0.35 times its height for a flat square box
    // whose sides are 1. Returns 0 for a value that may be a rounding error.
    double Fullness() const;
    // Returns true for flat boxes that are 350 times as wide as high, for example.
    bool IsThin() const { return Fullness() < 1e-3; }

  private:
    explicit Enclosure(const glm::dvec3& center) : m_center(center) {}
    void Add(const glm::vec3& p0, const glm::vec3& p1, const glm::vec3& p2);

    glm::dvec3 m_center;      // center of the measured triangles; the volume of an open mesh depends on it
    glm::dvec3 m_areas{0.0};  // area vectors
    double m_area = 0.0, m_volume = 0.0;
    double m_farthest = 0.0;  // largest absolute coordinate
};

class EmitterFinder {
  public:
    // Keeps a reference to `scene`, of which it reads materials, textures and images, but no mesh.
    explicit EmitterFinder(const scene::SceneData& scene);

    // Tells whether Find may find emitters among the primitive's triangles.
    bool MayEmit(const scene::Primitive& primitive) const;

    // Returns the triangles whose material, or that of a variant, emits, has an emissive texture, or may be
    // made to emit by an animation, except those whose part of the texture is black. Positions and indices
    // are read from `triangles`, the rest from `primitives`. Time is linear in the triangles and in the
    // texels that they cover, of which some are read several times.
    EmitterLists Find(const GroupTriangles& triangles, std::span<const scene::Primitive* const> primitives,
                      bool isDoubleSided);

  private:
    // Describes a material that a primitive may have.
    struct Candidate {
        uint32_t material = 0;
        bool mayEmit = false;
        glm::mat3x2 toTexture{1.0f};
    };
    // Returns the candidates, the shown material first.
    std::vector<Candidate> CandidatesOf(const scene::Primitive& primitive) const;
    // Returns the mean of the emissive texture over the triangle with these vertices; 1 without a texture.
    glm::vec3 MeanTexture(const Candidate& candidate, const scene::Primitive& primitive,
                          const uint32_t (&vertices)[3], uint32_t maxCuts);
    // Prefix sums over an image: (width + 1) * (height + 1) counts of the texels that are not black, in the
    // rectangle from the origin.
    struct LitTexels {
        std::vector<uint32_t> sums;
        uint32_t Count(uint32_t width, glm::uvec2 begin, glm::uvec2 end) const;
    };
    const LitTexels& LitTexelsOf(uint32_t image);
    // Returns the mean of the texture over a triangle of texture coordinates, estimated from up to maxCuts^2
    // points; 0 only if the texture is black on the whole triangle.
    glm::vec3 Mean(const scene::Texture& texture, const glm::vec2 (&uv)[3], uint32_t maxCuts);

    const scene::SceneData& m_scene;
    std::vector<bool> m_isAnimated;             // by material: an animation may make it emit
    std::map<uint32_t, LitTexels> m_litTexels;  // keyed by image
};

// Returns InstanceRecord::triangleLights: each triangle's index among the emitters, or gpu::kNoLight. Empty
// if there are no emitters.
std::vector<uint32_t> TriangleLights(std::span<const Emitter> emitters, size_t triangleCount);

}  // namespace raygraph
