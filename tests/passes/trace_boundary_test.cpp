// Boundaries of media whose indices are equal, near each other, or infinite, as Trace renders them.
#include <cmath>

#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

using passes::TraceSettings;

namespace {

class TraceBoundary : public VulkanTest {
  protected:
    // A quad that fills the picture, in an environment of unit radiance.
    glm::dvec3 FacingQuad(const scene::Material& material, TraceSettings settings) {
        render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {material}));
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        return render.Render(settings, 16).mean.Mean();
    }
    static TraceSettings FaceOn() {
        TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 0.2f, 16);
        settings.scattering.brdf = BrdfModel::Gltf;
        return settings;
    }

    SceneRender render{Device()};
};

}  // namespace

TEST_F(TraceBoundary, Trace_IndexZeroReflectsAllByEveryFresnelAndWithAVolume) {
    scene::Material material;
    material.baseColorFactor = {0.1f, 0.2f, 0.3f, 1.0f};
    material.metallicFactor = 0.0f;
    material.roughnessFactor = 0.0f;
    material.ior = 0.0f;
    for (const FresnelModel model :
         {FresnelModel::Schlick, FresnelModel::Dielectric, FresnelModel::Conductor, FresnelModel::Lazanyi})
        for (const float transmission : {0.0f, 1.0f})
            for (const float thickness : {0.0f, 1.0f}) {
                material.transmissionFactor = transmission;
                material.thicknessFactor = thickness;
                TraceSettings settings = FaceOn();
                settings.scattering.fresnel = model;
                const glm::dvec3 seen = FacingQuad(material, settings);
                for (int c = 0; c < 3; c++)
                    EXPECT_NEAR(seen[c], 1.0, 1e-4)
                        << "model " << static_cast<int>(model) << " transmission " << transmission
                        << " thickness " << thickness << " channel " << c;
            }
}

// Over black, seen at 80 degrees: all light is the environment's, mirrored in the sheet.
TEST_F(TraceBoundary, Trace_SheetOfTheIndexOfAirMirrorsNothing) {
    scene::Material sheet;
    sheet.metallicFactor = 0.0f;
    sheet.roughnessFactor = 0.0f;
    sheet.transmissionFactor = 1.0f;
    const double angle = 80.0 * 3.14159265358979 / 180.0;
    TraceSettings settings = FaceOn();
    settings.camera =
        LookAt(100.0f * glm::vec3(std::sin(angle), 0.0f, std::cos(angle)), {0, 0, 0}, 1e-4f, 8).camera;
    const auto mirrored = [&](float ior) {
        sheet.ior = ior;
        render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), QuadMesh(50.0f, 1)},
                                      {sheet, Lambert(glm::vec3(0.0f))},
                                      {glm::mat4x3(1.0f), Translation({0, 0, -0.5f})}));
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        return render.Render(settings, 256).mean.Mean().y;
    };
    EXPECT_EQ(mirrored(1.0f), 0.0);
    const double schlick = 0.04 + 0.96 * std::pow(1.0 - std::cos(angle), 5.0);
    EXPECT_NEAR(mirrored(1.5f), schlick, 0.02);
}

}  // namespace raygraph::testing
