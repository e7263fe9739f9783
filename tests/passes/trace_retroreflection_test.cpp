// Light that a surface reflects back to its lamp, from the file to the picture.
#include <cmath>
#include <numbers>

#include "passes/raster.h"
#include "passes/views.h"
#include "tests/passes/gltf_square.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_retroreflection_test {

using passes::TraceSettings;

namespace {

constexpr double kCosine = 0.5, kDistance = 4.0, kIntensity = 20.0, kAlpha = 0.16;

class TraceRetroreflection : public VulkanTest {
  protected:
    // A square of white metal with a point light at the camera, at 60 degrees.
    static GltfDocument Lit(const Json& retroreflection) {
        GltfDocument document;
        Json material{{"pbrMetallicRoughness", {{"roughnessFactor", std::sqrt(kAlpha)}}}};
        if (!retroreflection.is_null())
            material["extensions"]["KHR_materials_retroreflection"] = retroreflection;
        const size_t index = document.AddMaterial(material);
        document.AddNode({{"mesh", document.AddMesh(Square(document, {}, index))}});
        document.json["extensions"]["KHR_lights_punctual"]["lights"] = {
            {{"type", "point"}, {"intensity", kIntensity}}};
        document.AddNode(
            {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}},
             {"translation", {kDistance * std::sqrt(1.0 - kCosine * kCosine), 0.0, kDistance * kCosine}}});
        return document;
    }
    static TraceSettings View() {
        TraceSettings settings =
            LookAt(float(kDistance) * glm::vec3(std::sqrt(1.0 - kCosine * kCosine), 0.0, kCosine), {0, 0, 0},
                   1e-3f, 8);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.scattering.multiscatter = MultiscatterKind::Off;
        return settings;
    }
    // Of the single reflection D F G / (4 cos cos) at the facets' normal.
    static double Radiance(double height) {
        const double sine2 = 1.0 - kCosine * kCosine;
        const double slope2 = (1.0 / (height * height) - 1.0) / (kAlpha * kAlpha);
        const double d = 1.0 / (std::numbers::pi * kAlpha * kAlpha * std::pow(height, 4.0) * (1.0 + slope2) *
                                (1.0 + slope2));
        const double lambdaCos = 0.5 * (std::sqrt(kCosine * kCosine + kAlpha * kAlpha * sine2) - kCosine);
        const double visible = 1.0 / (kCosine * kCosine + 2.0 * lambdaCos * kCosine);
        return 0.25 * d * visible * kCosine * kIntensity / (kDistance * kDistance);
    }

    FloatImage Raster() {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, View(), passes::FilmPosition::Center);
        const Readback drawn = render.renderer.ReadBack(
            passes::RasterShade(render.renderer, ids, View(), seen, environment, {}));
        render.renderer.Execute();
        return ToFloatImage(drawn);
    }

    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

}  // namespace

// Ahead, the facets that reflect to the camera are turned towards it; back, those that lie in the surface.
TEST_F(TraceRetroreflection, Trace_LampAtTheCameraIsSeenInTheSurface) {
    const double ahead = Radiance(kCosine), back = Radiance(1.0);
    ASSERT_GT(back, 50.0 * ahead);
    for (const double share : {0.0, 0.3, 1.0}) {
        const Json extension = {{"retroreflectionFactor", share}};
        render.scene.SetScene(test::Load(Lit(share > 0.0 ? extension : Json())));
        const double expected = (1.0 - share) * ahead + share * back;
        EXPECT_NEAR(render.Render(View(), 1).mean.Mean().y, expected, 2e-3 * expected) << share;
        EXPECT_NEAR(Raster().Mean().y, expected, 2e-3 * expected) << "raster, " << share;
    }
}

}  // namespace raygraph::testing::trace_retroreflection_test
