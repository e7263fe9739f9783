// Tests the mip level at which the raster view reads textures: derivatives in a pixel, and anisotropic
// filters.
#include <algorithm>
#include <cmath>

#include "passes/raster.h"
#include "passes/views.h"
#include "tests/passes/level_texture.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::raster_levels_test {

using passes::TraceSettings;

namespace {

class RasterLevels : public VulkanTest {
  protected:
    static FloatImage Draw(SceneRender& render, const TraceSettings& settings, bool hasTextureLevels = true) {
        passes::FilteredEnvironment environment{"environment"};
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::AnyVisibility(render.renderer, ids, settings, passes::FilmPosition::Center);
        const Readback readback =
            render.renderer.ReadBack(passes::RasterShade(render.renderer, ids, settings, seen, environment,
                                                         {.shadows = passes::RasterShadows::Off,
                                                          .hasOcclusion = false,
                                                          .hasTransmission = false,
                                                          .hasTextureLevels = hasTextureLevels}));
        render.renderer.Execute();
        return ToFloatImage(readback);
    }
    static double CenterLevel(const FloatImage& image) {
        return LevelOf(image.At(image.extent.width / 2, image.extent.height / 2).x);
    }
};

double PixelWidth(float yFov, uint32_t size) {
    return 2.0 * std::tan(0.5 * double(yFov)) / size;
}

glm::mat4x3 Turned(float angle, float scale) {  // about x
    glm::mat4x3 matrix(scale);
    matrix[1] = scale * glm::vec3(0, std::cos(angle), std::sin(angle));
    matrix[2] = scale * glm::vec3(0, -std::sin(angle), std::cos(angle));
    return matrix;
}

}  // namespace

// Texture coordinates hardly change along x, so the texels along y decide: those of a pixel's height, divided
// by the cosine of the tilt.
TEST_F(RasterLevels, PlaneIsReadAtTheLevelOfThePixelsTexels) {
    SceneRender render(Device(), {.textureLevels = true});
    constexpr float kFov = 0.1f, kRepeats = 4.0f;
    for (const float distance : {8.0f, 30.0f})
        for (const float tilt : {0.0f, 0.9f})
            for (const float scale : {1.0f, 2.0f}) {
                SCOPED_TRACE("distance " + std::to_string(distance) + ", tilt " + std::to_string(tilt));
                render.scene.SetScene(
                    LevelScene({LevelQuad(1.0f, kRepeats)}, {LevelMaterial()}, {Turned(tilt, scale)}));
                const double texels = double(distance) * PixelWidth(kFov, 9) * double(kRepeats) *
                                      kLevelTexels / (2.0 * double(scale) * std::cos(double(tilt)));
                ASSERT_GT(texels, 1.5);
                const TraceSettings settings = LookAt({0, 0, distance}, {0, 0, 0}, kFov, 9);
                EXPECT_NEAR(CenterLevel(Draw(render, settings)), std::min(std::log2(texels), kFinestLevel),
                            0.15);
                EXPECT_NEAR(CenterLevel(Draw(render, settings, false)), 0.0, 0.1);
            }
}

TEST_F(RasterLevels, OrthographicPlaneIsReadAtTheLevelOfThePixelsTexels) {
    SceneRender render(Device(), {.textureLevels = true});
    render.scene.SetScene(LevelScene({LevelQuad(1.0f, 4.0f)}, {LevelMaterial()}, {Turned(0.9f, 1.0f)}));
    scene::CameraView view = scene::CameraView::LookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = 0.4f;
    TraceSettings settings = LookAt({0, 0, 5}, {0, 0, 0}, 1.0f, 9);
    settings.camera = ToRecord(view);
    const double texels = 0.4 / 9 * 4.0 * kLevelTexels / (2.0 * std::cos(0.9));
    EXPECT_NEAR(CenterLevel(Draw(render, settings)), std::log2(texels), 0.15);
}

// Up to the horizon the derivatives leave no pixel without a color, and far away all is the mean of the
// squares.
TEST_F(RasterLevels, CheckerToTheHorizonIsItsMeanFarAway) {
    scene::Material material = LevelMaterial();
    scene::Mesh floor = QuadMesh(1000.0f);
    floor.primitives[0].uv0 = {{0, 0}, {500, 0}, {500, 500}, {0, 500}};
    for (const float anisotropy : {1.0f, 8.0f}) {
        SceneRender render(Device(), {.textureLevels = true, .maxAnisotropy = anisotropy});
        scene::SceneData scene = SceneOf({floor}, {material});
        scene.images = {CheckerImage(64, 60, 200)};
        scene.textures = {{.name = "squares", .image = 0, .colorSpace = scene::ColorSpace::Linear}};
        render.scene.SetScene(std::move(scene));
        const TraceSettings settings = LookAt({0, 0, 2}, {0, 30, 0}, 0.6f, 48);
        const FloatImage levels = Draw(render, settings), finest = Draw(render, settings, false);
        double worst = 0.0, worstFinest = 0.0;
        uint32_t count = 0;
        for (uint32_t y = 0; y < 24; ++y)
            for (uint32_t x = 0; x < 48; ++x) {
                if (levels.At(x, y).w == 0.0f) continue;
                ++count;
                worst = std::max(worst, std::abs(double{levels.At(x, y).x} - 130.0 / 255.0));
                worstFinest = std::max(worstFinest, std::abs(double{finest.At(x, y).x} - 130.0 / 255.0));
            }
        EXPECT_GT(count, 200u);
        EXPECT_LT(worst, 0.02) << anisotropy;
        EXPECT_GT(worstFinest, 0.2);
    }
}

// A footprint that is long in v and short in u is filtered along v by several samples of a finer level, so
// that lines along v, which an isotropic filter blurs, stay sharp.
TEST_F(RasterLevels, AnisotropicFilterKeepsLinesAlongAFootprint) {
    if (Device().Info().maxAnisotropy < 8.0f) GTEST_SKIP() << "the device has no anisotropic filter";
    if (Device().Info().isLavapipe) GTEST_SKIP() << "this driver filters round footprints";
    // Across 64 pixels there are 4 texels each, in lines of 8; along v there are 32 texels per pixel
    scene::Mesh quad = QuadMesh(1.0f);
    quad.primitives[0].uv0.clear();
    for (const glm::vec3& position : quad.primitives[0].positions)
        quad.primitives[0].uv0.push_back({0.5f + 0.5f * position.x, 4.0f * position.y});
    const auto contrast = [&](float anisotropy) {
        SceneRender render(Device(), {.textureLevels = true, .maxAnisotropy = anisotropy});
        scene::SceneData scene = SceneOf({quad}, {LevelMaterial()});
        scene.images = {{.name = "lines", .width = 256, .height = 256, .rgba = {}}};
        for (uint32_t i = 0; i < 256 * 256; ++i) {
            const uint8_t byte = i % 256 / 8 % 2 != 0 ? 200 : 60;
            scene.images[0].rgba.insert(scene.images[0].rgba.end(), {byte, byte, byte, 255});
        }
        scene.textures = {{.name = "lines", .image = 0, .colorSpace = scene::ColorSpace::Linear}};
        render.scene.SetScene(std::move(scene));
        scene::CameraView view = scene::CameraView::LookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
        view.projection = scene::Projection::Orthographic;
        view.height = 2.0f;
        TraceSettings settings = LookAt({0, 0, 5}, {0, 0, 0}, 1.0f, 64);
        settings.camera = ToRecord(view);
        const FloatImage image = Draw(render, settings);
        float least = 1.0f, greatest = 0.0f;
        for (const glm::vec4& texel : image.values) {
            least = std::min(least, texel.x);
            greatest = std::max(greatest, texel.x);
        }
        return greatest - least;
    };
    EXPECT_LT(contrast(1.0f), 0.2f);
    EXPECT_GT(contrast(8.0f), 0.4f);
}

}  // namespace raygraph::testing::raster_levels_test
