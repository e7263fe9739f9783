// SurfaceGlow computes what surfaces show without being lit: their emission, and the base color of unlit
// ones. It also tells which rays pass through them. It does so at single points, on the host, for the
// measurement of own_light.h. Threads: const calls may come from any thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/bvh/facet_scene.h"
#include "renderer/gpu_scene/lights/brightest_pose.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph {

class EmitterFinder;

class SurfaceGlow {
  public:
    // Keeps a reference to the scene, whose vertices and texels must stay.
    explicit SurfaceGlow(const scene::SceneData& scene);

    // Returns whether anything shines in the brightest pose (brightest_pose.h), where textures are taken as
    // white: a punctual light, or a placed surface that is visible in that pose.
    bool IsAny() const;
    const BrightestPose& Pose() const { return m_pose; }
    bool MayGlow(const scene::Mesh& mesh) const;

    // Returns the triangles of the mesh, and 12 facets for each round primitive, which is taken as a square
    // bar. Transmissive surfaces that do not glow are left out. Facets with alpha have isTested set.
    std::vector<Facet> AddMesh(uint32_t mesh);

    // Returns the luminance that a point of an added mesh shows in the brightest pose.
    float LuminanceAt(uint32_t mesh, uint32_t facet, const glm::vec2& barycentrics) const;
    // Returns the fraction of rays that the point stops, in the pose that the scene has.
    float OpacityAt(uint32_t mesh, uint32_t facet, const glm::vec2& barycentrics) const;
    bool IsUnlit(uint32_t mesh, uint32_t facet) const;
    // Returns, for each facet of an added mesh, the mean of the luminance that it emits; unlit facets emit
    // none.
    std::vector<float> EmittedMeans(uint32_t mesh, size_t facetCount, EmitterFinder& finder) const;

  private:
    struct Place {
        const scene::Primitive* primitive = nullptr;
        uint32_t vertices[3]{};
        glm::vec3 weights{0.0f};
    };
    Place At(uint32_t mesh, uint32_t facet, const glm::vec2& barycentrics) const;
    const scene::Primitive& PrimitiveOf(uint32_t mesh, uint32_t facet, uint32_t& first) const;
    glm::vec4 Read(const scene::TextureRef& reference, const Place& place) const;
    glm::vec4 BaseTexture(const scene::Material& material, const Place& place) const;
    bool MayGlow(const scene::Primitive& primitive) const;

    const scene::SceneData& m_scene;
    BrightestPose m_pose;
    std::vector<std::vector<uint32_t>> m_firstFacets;  // by mesh and primitive; one more at the end
};

}  // namespace raygraph
