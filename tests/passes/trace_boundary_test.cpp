// Boundaries of media whose indices are equal, near each other, or infinite, as Trace renders them.
#include <cmath>

#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_boundary_test {

using passes::TraceSettings;

namespace {

class TraceBoundary : public VulkanTest {
  protected:
    static TraceSettings FaceOn() {
        TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 0.2f, 16);
        settings.scattering.brdf = BrdfModel::Gltf;
        return settings;
    }

    SceneRender render{Device()};
};

}  // namespace

// Side by side: an opaque sheet, one that lets light through, and the face of a volume.
TEST_F(TraceBoundary, Trace_IndexZeroReflectsAllAndWithAVolumeToo) {
    std::vector<scene::Material> materials(3);
    for (size_t i = 0; i < materials.size(); ++i) {
        materials[i].baseColorFactor = {0.1f, 0.2f, 0.3f, 1.0f};
        materials[i].metallicFactor = 0.0f;
        materials[i].roughnessFactor = 0.0f;
        materials[i].ior = 0.0f;
        materials[i].transmissionFactor = i > 0 ? 1.0f : 0.0f;
        materials[i].thicknessFactor = i > 1 ? 1.0f : 0.0f;
    }
    render.scene.SetScene(SceneOf({QuadMesh(0.5f, 0), QuadMesh(0.5f, 1), QuadMesh(0.5f, 2)}, materials,
                                  {Translation({-1, 0, 0}), glm::mat4x3(1.0f), Translation({1, 0, 0})}));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    for (const FresnelModel model : {FresnelModel::Schlick, FresnelModel::Dielectric}) {
        TraceSettings settings = FaceOn();
        settings.camera = LookAt({0, 0, 4}, {0, 0, 0}, 0.7f, 16).camera;
        settings.scattering.fresnel = model;
        // Where no sheet is the environment is, and as bright
        for (const glm::vec4& texel : render.Render(settings, 4).mean.values)
            for (int c = 0; c < 3; ++c) ASSERT_NEAR(texel[c], 1.0f, 1e-4f) << static_cast<int>(model);
    }
}

// Over black, seen at 80 degrees: all light is the environment's, mirrored in the sheet.
TEST_F(TraceBoundary, Trace_SheetOfTheIndexOfAirMirrorsNothing) {
    scene::Material sheet;
    sheet.metallicFactor = 0.0f;
    sheet.roughnessFactor = 0.0f;
    sheet.transmissionFactor = 1.0f;
    scene::Material black;
    black.baseColorFactor = {0, 0, 0, 1};
    black.metallicFactor = 0.0f;
    black.specularFactor = 0.0f;
    const double angle = 80.0 * 3.14159265358979 / 180.0;
    TraceSettings settings = FaceOn();
    settings.camera =
        LookAt(100.0f * glm::vec3(std::sin(angle), 0.0f, std::cos(angle)), {0, 0, 0}, 1e-4f, 8).camera;
    settings.extent = {64, 64};
    const auto mirrored = [&](float ior) {
        sheet.ior = ior;
        render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), QuadMesh(50.0f, 1)}, {sheet, black},
                                      {glm::mat4x3(1.0f), Translation({0, 0, -0.5f})}));
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        return render.Render(settings, 1).mean.Mean().y;
    };
    EXPECT_EQ(mirrored(1.0f), 0.0);
    const double schlick = 0.04 + 0.96 * std::pow(1.0 - std::cos(angle), 5.0);
    EXPECT_NEAR(mirrored(1.5f), schlick, 0.04);
}

}  // namespace raygraph::testing::trace_boundary_test
