// Finds the triangles of a mesh that may emit, while its host copy exists.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <vector>

#include "renderer/gpu_scene/lights/light_table.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// The triangles of a group, as its BLAS has them.
struct GroupTriangles {
    std::vector<glm::vec3> positions;
    std::vector<uint32_t> indices;
    std::vector<uint32_t> geometries;  // a triangle's primitive within the group; empty if there is one only
    std::vector<uint32_t> originals;   // a triangle's index in its primitive; empty if nothing moved
    std::vector<uint32_t> firstVertices;  // by primitive
};

// What an emitter becomes where its primitive has another material in a variant of the scene.
struct EmitterVariant {
    uint32_t emitter = 0;   // of the group
    uint32_t geometry = 0;  // its primitive within the group
    uint32_t material = 0;
    glm::vec3 meanTexture{1.0f};
};

struct EmitterLists {
    std::vector<Emitter> emitters;
    // Each material that a primitive of variants may have, the shown one included; of others nothing.
    std::vector<EmitterVariant> variants;
};

// What triangles enclose together.
class Enclosure {
  public:
    // Of a mesh's triangles; round primitives do not count.
    static Enclosure Of(const scene::Mesh& mesh);
    // Three corners a triangle.
    static Enclosure Of(std::span<const glm::vec3> corners);

    // True if there is a volume, and the area vectors add up to no more than a tenth of the area. Those of a
    // closed mesh add up to zero, as do those of a plane figure that is wound both ways.
    bool IsClosed() const;
    // The volume over area^1.5: 0.068 for a cube, and 0.35 times its height for a flat square box whose sides
    // are 1. 0 where it may be a rounding.
    double Fullness() const;
    // As flat boxes are that are 350 times as wide as high.
    bool IsThin() const { return Fullness() < 1e-3; }

  private:
    explicit Enclosure(const glm::dvec3& center) : m_center(center) {}
    void Add(const glm::vec3& p0, const glm::vec3& p1, const glm::vec3& p2);

    glm::dvec3 m_center;      // of what is measured: if it is open, the volume depends on that
    glm::dvec3 m_areas{0.0};  // area vectors
    double m_area = 0.0, m_volume = 0.0;
    double m_farthest = 0.0;  // coordinate
};

class EmitterFinder {
  public:
    // Refers to the materials, textures and images of `scene`, and to no mesh.
    explicit EmitterFinder(const scene::SceneData& scene);

    // Whether Find may find emitters among the primitive's triangles.
    bool MayEmit(const scene::Primitive& primitive) const;

    // The triangles whose material, or that of a variant, emits, has an emissive texture, or may be made to
    // emit by an animation, except those
    // whose part of the texture is black. Positions and indices are taken from `triangles`, the rest from
    // `primitives`. Linear in triangles and, a few times over, in the texels they cover.
    EmitterLists Find(const GroupTriangles& triangles, std::span<const scene::Primitive* const> primitives,
                      bool isDoubleSided);

  private:
    // A material that a primitive may have.
    struct Candidate {
        uint32_t material = 0;
        bool mayEmit = false;
        glm::mat3x2 toTexture{1.0f};
    };
    // The shown one first.
    std::vector<Candidate> CandidatesOf(const scene::Primitive& primitive) const;
    // Of its emissive texture, over the triangle of these vertices; 1 without.
    glm::vec3 MeanTexture(const Candidate& candidate, const scene::Primitive& primitive,
                          const uint32_t (&vertices)[3], uint32_t maxCuts);
    // The number of texels of a rectangle from the origin that are not black: (width + 1) * (height +
    // 1) sums.
    struct LitTexels {
        std::vector<uint32_t> sums;
        uint32_t Count(uint32_t width, glm::uvec2 begin, glm::uvec2 end) const;
    };
    const LitTexels& LitTexelsOf(uint32_t image);
    // Mean of the texture over a triangle of texture coordinates; 0 only if it is black all over. An estimate
    // from up to maxCuts^2 points.
    glm::vec3 Mean(const scene::Texture& texture, const glm::vec2 (&uv)[3], uint32_t maxCuts);

    const scene::SceneData& m_scene;
    std::vector<bool> m_isAnimated;             // by material: an animation may make it emit
    std::map<uint32_t, LitTexels> m_litTexels;  // by image
};

// For InstanceRecord::triangleLights: each triangle's index among the emitters, or gpu::kNoLight. Empty if
// there are no emitters.
std::vector<uint32_t> TriangleLights(std::span<const Emitter> emitters, size_t triangleCount);

}  // namespace raygraph
