// The picture of a scene of Lambert's surfaces under directional lights, worked out by a small program of its
// own in double precision: none of the shaders' text is in it. What it knows is what glTF 2.0 says of
// textures (3.8.4), alpha (3.9.4) and sides (3.9.5), and that a white surface that faces a light of E lx has
// the radiance E / pi. Light that was scattered twice is not in it, nor is light that surfaces emit onto
// others.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/scene/model/camera_view.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::test {

// One reading of a texture by its own sampler, as its magnification filter says: rgb linear.
glm::dvec4 ReadTexture(const scene::SceneData& scene, uint32_t texture, const glm::dvec2& uv);

// The linear value of an sRGB-encoded one in [0, 1] (IEC 61966-2-1).
double DecodeSrgb(double encoded);

class DirectLightReference {
  public:
    // Takes what it needs of the scene, which must outlive this object. Opaque, MASK and BLEND; base color
    // and emission with their factors, textures and vertex colors; every directional light. BLEND is the
    // mean over all choices of whether a surface is there.
    explicit DirectLightReference(const scene::SceneData& scene);

    // Radiance along a ray from `origin` (direction of unit length), and the share of it that surfaces stop.
    glm::dvec4 Along(const glm::dvec3& origin, const glm::dvec3& direction) const;

    // Returns for each pixel, rows from the top, the mean over raysAcross x raysAcross evenly spread
    // positions.
    std::vector<glm::dvec4> Picture(const scene::CameraView& camera, uint32_t width, uint32_t height,
                                    uint32_t raysAcross) const;

  private:
    struct Triangle {
        glm::dvec3 corners[3];
        glm::dvec3 normal;  // unit length, of the front
        glm::dvec2 uv[2][3]{};
        glm::dvec4 colors[3]{glm::dvec4(1.0), glm::dvec4(1.0), glm::dvec4(1.0)};
        const scene::Material* material = nullptr;
    };
    // Is a point where a ray meets a triangle, with the weights of its corners.
    struct Crossing {
        double distance;
        glm::dvec3 weights;
        const Triangle* triangle;
        double opacity;
    };
    struct Sun {
        glm::dvec3 toLight;
        glm::dvec3 illuminance;  // lx, of a surface that faces it
    };

    void AddPrimitive(const scene::Primitive& primitive, const glm::mat4x3& objectToWorld);
    // Returns all crossings that may block light, nearest first.
    std::vector<Crossing> Crossings(const glm::dvec3& origin, const glm::dvec3& direction) const;
    glm::dvec4 TextureAt(const scene::TextureRef& reference, const Crossing& crossing) const;
    glm::dvec4 BaseColorAt(const Crossing& crossing) const;
    double OpacityAt(const Crossing& crossing) const;
    glm::dvec3 RadianceOf(const Crossing& crossing, const glm::dvec3& place,
                          const glm::dvec3& direction) const;

    const scene::SceneData& m_scene;
    std::vector<Triangle> m_triangles;
    std::vector<Sun> m_suns;
};

}  // namespace raygraph::test
