// A thin film on the device: the colors that it reflects, and the energy of what it lets pass.
#include <cmath>

#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_iridescence_test {

using passes::TraceSettings;

namespace {

class TraceIridescence : public VulkanTest {
  protected:
    // The mean of a quad of the material, seen at that cosine within white surroundings.
    RenderedImage Seen(const scene::Material& material, float cosTheta, uint32_t sampleCount = 1) {
        const glm::vec3 eye = 100.0f * glm::vec3(std::sqrt(1.0f - cosTheta * cosTheta), 0.0f, cosTheta);
        TraceSettings settings = LookAt(eye, {0, 0, 0}, 1e-4f, 8);
        settings.scattering.brdf = BrdfModel::Gltf;
        render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {material}));
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        return render.Render(settings, sampleCount);
    }

    SceneRender render{Device()};
};

scene::Material Filmed(float ior, float thickness) {
    scene::Material material;
    material.iridescenceFactor = 1.0f;
    material.iridescenceIor = ior;
    material.iridescenceThicknessMaximum = thickness;
    return material;
}

// A film over a metal that reflects nothing is a soap film. Values: Airy's formula, integrated over the spectrum
// as tests/shading/thin_film_test.cpp does.
TEST_F(TraceIridescence, Trace_ThinFilmReflectsByItsThickness) {
    const struct {
        float ior, thickness, cosTheta;
        glm::dvec3 reflected;
    } kCases[] = {{1.5f, 250.0f, 0.9f, {0.0156, 0.1158, 0.1399}},
                  {1.5f, 420.0f, 0.5f, {0.2863, 0.0406, 0.1830}},
                  {2.0f, 180.0f, 0.9f, {0.0358, 0.2698, 0.3566}}};
    for (const auto& test : kCases) {
        scene::Material film = Filmed(test.ior, test.thickness);
        film.baseColorFactor = {0.0f, 0.0f, 0.0f, 1.0f};
        film.roughnessFactor = 0.0f;
        const glm::dvec3 bare(std::pow(1.0 - test.cosTheta, 5.0));  // Schlick's curve of an F0 of 0
        const glm::dvec3 seen(Seen(film, test.cosTheta).mean.Mean());
        EXPECT_LT(glm::distance(seen, bare + test.reflected), 0.01)
            << test.thickness << " nm, cos " << test.cosTheta << ": " << seen.x << ' ' << seen.y << ' '
            << seen.z;
        film.iridescenceFactor = 0.25f;
        EXPECT_LT(
            glm::distance(glm::dvec3(Seen(film, test.cosTheta).mean.Mean()), bare + 0.25 * test.reflected),
            0.004)
            << "a film on a quarter of the facets";
    }
}

// What a film on glass adds to the reflection it takes from the transmission.
TEST_F(TraceIridescence, Trace_FilmOnAPaneLosesNothing) {
    scene::Material pane = Filmed(1.9f, 330.0f);
    pane.metallicFactor = 0.0f;
    pane.roughnessFactor = 0.0f;
    pane.transmissionFactor = 1.0f;
    for (const float cosTheta : {0.95f, 0.4f}) {
        const RenderedImage seen = Seen(pane, cosTheta, 256);
        const glm::dvec3 mean(seen.mean.Mean()), error(seen.StandardErrorOfMean());
        EXPECT_LT(glm::length(error), 0.004);
        EXPECT_LT(glm::distance(mean, glm::dvec3(1.0)), 4.0 * glm::length(error) + 1e-3) << cosTheta;
    }
}

}  // namespace
}  // namespace raygraph::testing::trace_iridescence_test
