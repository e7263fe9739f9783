// The mip level at which paths read textures: against closed forms of what a pixel sees, and what it does to
// noise and energy.
#include <algorithm>
#include <cmath>

#include "tests/passes/level_texture.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::texture_lod_test {

using passes::TraceSettings;

namespace {

class TextureLod : public VulkanTest {
  protected:
    double CenterLevel(const TraceSettings& settings) {
        const FloatImage image = render.TraceOnce(settings);
        return LevelOf(image.At(image.extent.width / 2, image.extent.height / 2).x);
    }
    SceneRender render{Device(), {.textureLevels = true}};
};

// Along -z, with the middle of the picture at the origin.
TraceSettings Facing(float distance, float yFov, uint32_t size = 9) {
    TraceSettings settings = LookAt({0, 0, distance}, {0, 0, 0}, yFov, size);
    settings.biases.textureLod = 0.0f;
    return settings;
}

double PixelWidth(float yFov, uint32_t size) {  // at distance 1
    return 2.0 * std::tan(0.5 * double(yFov)) / size;
}

glm::mat4x3 Turned(float angle, float scale = 1.0f) {  // about x
    glm::mat4x3 matrix(scale);
    matrix[1] = scale * glm::vec3(0, std::cos(angle), std::sin(angle));
    matrix[2] = scale * glm::vec3(0, -std::sin(angle), std::cos(angle));
    return matrix;
}

}  // namespace

// The texels of a pixel: (distance times pixel)^2 times their density, over the cosine of the tilt.
TEST_F(TextureLod, PlaneIsReadAtTheLevelOfThePixelsTexels) {
    constexpr float kFov = 0.1f, kRepeats = 4000.0f;
    const double density = LevelDensity(1.0f, kRepeats);
    double least = 9.0, greatest = 0.0;
    for (const float distance : {2.0f, 6.0f, 17.0f})
        for (const float tilt : {0.0f, 0.9f, 1.3f})
            for (const float scale : {1.0f, 2.0f}) {
                SCOPED_TRACE("distance " + std::to_string(distance) + ", tilt " + std::to_string(tilt));
                render.scene.SetScene(
                    LevelScene({LevelQuad(1.0f, kRepeats)}, {LevelMaterial()}, {Turned(tilt, scale)}));
                const double width = double(distance) * PixelWidth(kFov, 9);
                const double texels =
                    width * width * density / (std::cos(double(tilt)) * double(scale) * double(scale));
                const double expected = 0.5 * std::log2(texels);
                least = std::min(least, expected);
                greatest = std::max(greatest, expected);
                TraceSettings settings = Facing(distance, kFov);
                EXPECT_NEAR(CenterLevel(settings), std::clamp(expected, 0.0, kFinestLevel), 0.1);
                settings.biases.textureLod = -1.5f;
                EXPECT_NEAR(CenterLevel(settings), std::clamp(expected - 1.5, 0.0, kFinestLevel), 0.1);
            }
    EXPECT_LT(least, 1.5);
    EXPECT_GT(greatest, 4.0);
}

// Not the middle of the picture: a pixel of a wide picture's corner sees less, from farther away.
TEST_F(TextureLod, CornersOfAWidePictureSeeSmallerPixelsFromFartherAway) {
    constexpr float kFov = 2.2f, kRepeats = 400000.0f, kHalf = 30.0f;
    render.scene.SetScene(LevelScene({LevelQuad(kHalf, kRepeats)}, {LevelMaterial()}));
    const FloatImage image = render.TraceOnce(Facing(4.0f, kFov, 65));
    // On a plane along the film all pixels have the same area
    const double width = 4.0 * PixelWidth(kFov, 65);
    const double expected = 0.5 * std::log2(width * width * LevelDensity(kHalf, kRepeats));
    ASSERT_GT(expected, 1.0);
    ASSERT_LT(expected, 5.0);
    for (const uint32_t y : {1u, 32u, 63u})
        for (const uint32_t x : {1u, 32u, 63u}) EXPECT_NEAR(LevelOf(image.At(x, y).x), expected, 0.15);
}

TEST_F(TextureLod, OrthographicCameraSeesTheSameLevelAtAnyDistance) {
    constexpr float kRepeats = 40000.0f;
    render.scene.SetScene(LevelScene({LevelQuad(1.0f, kRepeats)}, {LevelMaterial()}));
    for (const float distance : {2.0f, 90.0f}) {
        scene::CameraView view = scene::CameraView::LookAt({0, 0, distance}, {0, 0, 0}, {0, 1, 0});
        view.projection = scene::Projection::Orthographic;
        view.height = 0.2f;
        TraceSettings settings = Facing(distance, 1.0f);
        settings.camera = ToRecord(view);
        const double width = 0.2 / 9;
        EXPECT_NEAR(CenterLevel(settings), 0.5 * std::log2(width * width * LevelDensity(1.0f, kRepeats)),
                    0.1);
    }
}

TEST_F(TextureLod, TransformsAndCoordinateSetsScaleTheTexels) {
    constexpr float kFov = 0.1f, kRepeats = 4000.0f;
    const auto level = [&](const scene::Material& material, bool isSecondSet) {
        scene::Mesh mesh = LevelQuad(1.0f, kRepeats);
        scene::Primitive& primitive = mesh.primitives[0];
        primitive.uv1 = primitive.uv0;
        // The other set counts a quarter as far along v
        for (glm::vec2& uv : isSecondSet ? primitive.uv0 : primitive.uv1) uv.y *= 0.25f;
        render.scene.SetScene(LevelScene({mesh}, {material}));
        return CenterLevel(Facing(6.0f, kFov));
    };
    const double plain = level(LevelMaterial(), false);
    EXPECT_NEAR(plain,
                0.5 * std::log2(36.0 * std::pow(PixelWidth(kFov, 9), 2.0) * LevelDensity(1.0f, kRepeats)),
                0.1);
    EXPECT_NEAR(level(LevelMaterial(), true), plain - 1.0, 0.1);
    EXPECT_NEAR(level(LevelMaterial(1), true), plain, 0.1);
    for (const float scale : {4.0f, 0.25f}) {
        scene::Material moved = LevelMaterial();
        moved.emissiveTexture.transform.scale = {1.0f, scale};
        EXPECT_NEAR(level(moved, false), plain + 0.5 * std::log2(double(scale)), 0.1) << scale;
    }
}

// A mirror does not change what it shows, and a ball of radius r widens the cone by 2 / r a meter of its
// width.
TEST_F(TextureLod, MirrorBallWidensWhatItShowsByItsCurvature) {
    constexpr float kFov = 0.05f, kRepeats = 60000.0f, kHalf = 3.0f, kBehind = 8.0f;
    scene::Material mirror;
    mirror.roughnessFactor = 0.0f;
    const auto levelIn = [&](scene::Mesh mesh, const glm::vec3& at) {
        mesh.primitives[0].material = 1;
        render.scene.SetScene(LevelScene({LevelQuad(kHalf, kRepeats), std::move(mesh)},
                                         {LevelMaterial(), mirror},
                                         {Translation({0, 0, kBehind}), Translation(at)}));
        TraceSettings settings = Facing(4.0f, kFov);
        settings.scattering.brdf = BrdfModel::Gltf;
        return CenterLevel(settings);
    };
    const double pixel = PixelWidth(kFov, 9), density = LevelDensity(kHalf, kRepeats);
    const double flat = pixel * (4.0 + double(kBehind));
    EXPECT_NEAR(levelIn(QuadMesh(1.0f), {}), 0.5 * std::log2(flat * flat * density), 0.1);
    for (const double radius : {1.0, 2.5}) {
        const double ball = pixel * (4.0 + double(kBehind) * (1.0 + 2.0 * 4.0 / radius));
        const double expected = 0.5 * std::log2(ball * ball * density);
        ASSERT_LT(expected, kFinestLevel);
        EXPECT_NEAR(levelIn(SphereMesh(float(radius), 96), {0, 0, -float(radius)}), expected, 0.12) << radius;
        EXPECT_NEAR(levelIn(RoundSphere(float(radius)), {0, 0, -float(radius)}), expected, 0.1) << radius;
    }
}

// A lobe of roughness twice as large is four times as wide, which is two levels.
TEST_F(TextureLod, RoughMetalWidensWhatItShows) {
    constexpr float kFov = 0.002f, kRepeats = 625000.0f, kHalf = 40.0f, kBehind = 8.0f;
    const auto level = [&](float roughness) {
        scene::Material metal;
        metal.roughnessFactor = roughness;
        render.scene.SetScene(LevelScene({LevelQuad(kHalf, kRepeats), QuadMesh(1.0f, 1)},
                                         {LevelMaterial(), metal},
                                         {Translation({0, 0, kBehind}), Translation({})}));
        TraceSettings settings = Facing(4.0f, kFov, 17);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.lights.isOn = false;  // which reads level 0
        settings.biases.maxDepth = 1;
        std::vector<double> levels;
        for (const glm::vec4& texel : render.TraceOnce(settings).values)
            if (texel.x > 0.0f) levels.push_back(LevelOf(texel.x));  // else the ray missed the wall
        EXPECT_GT(levels.size(), 200u);
        std::ranges::sort(levels);
        return levels.at(levels.size() / 2);
    };
    const double smooth = level(0.0f), fine = level(0.1f), rough = level(0.2f);
    EXPECT_GT(fine, smooth + 0.5);
    EXPECT_NEAR(rough - fine, 2.0, 0.3);
}

// What is cut out is decided by the finest level, whatever the distance: of a mean of holes and leaf, a
// threshold would make all leaf, or all holes.
TEST_F(TextureLod, AlphaTestsStayAtLevel0) {
    for (const scene::AlphaMode mode : {scene::AlphaMode::Mask, scene::AlphaMode::Blend}) {
        scene::Material material = Lambert(glm::vec3(0.0f), glm::vec3(1.0f));
        material.baseColorTexture = {.texture = 0};
        material.alphaMode = mode;
        material.alphaCutoff = 0.4f;
        scene::Mesh mesh = QuadMesh(1.0f);
        mesh.primitives[0].uv0 = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        scene::SceneData scene = SceneOf({mesh}, {material});
        scene.images = {CheckerImage(256)};
        scene.textures = {{.name = "holes", .image = 0}};
        render.scene.SetScene(std::move(scene));
        TraceSettings settings = Facing(4.0f, 0.5f, 16);
        const FloatImage levels = render.TraceOnce(settings);
        settings.biases.textureLod = -std::numeric_limits<float>::infinity();
        const FloatImage finest = render.TraceOnce(settings);
        EXPECT_EQ(levels.values, finest.values);
        // Interpolated, the squares are 0.5 + 0.5 x y with x and y in [-1, 1]
        EXPECT_NEAR(finest.Mean().x, mode == scene::AlphaMode::Mask ? 0.76 : 0.5, 0.1);
    }
}

namespace {

// A floor of black and white squares, each a hundredth of a pixel's width or less.
scene::SceneData CheckerFloor(const scene::Material& like) {
    scene::Material material = like;
    material.baseColorTexture = {.texture = 0};
    scene::Mesh mesh = QuadMesh(10.0f);
    mesh.primitives[0].uv0 = {{0, 0}, {8, 0}, {8, 8}, {0, 8}};
    scene::SceneData scene = SceneOf({mesh}, {material});
    scene.images = {CheckerImage(512, 60, 230)};
    scene.textures = {{.name = "squares", .image = 0, .colorSpace = scene::ColorSpace::Linear}};
    return scene;
}

}  // namespace

TEST_F(TextureLod, MinifiedCheckerHasLittleNoiseAndTheSameMean) {
    render.scene.SetScene(CheckerFloor(Lambert(glm::vec3(1.0f))));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings settings = LookAt({0, -9.0f, 4.0f}, {0, 0, 0}, 0.3f, 32);
    settings.lights.isOn = false;  // in an even environment, all noise is then that of the squares
    const RenderedImage finest = render.Render(settings, 1024);
    settings.biases.textureLod = 0.0f;
    const RenderedImage levels = render.Render(settings, 64);
    // Interpolated squares of 60 and 230 deviate by a third of what they do themselves
    EXPECT_NEAR(std::sqrt(finest.variance.Mean().y), 85.0 / 255.0 / 3.0, 0.01);
    EXPECT_LT(levels.variance.Mean().y, 0.01 * finest.variance.Mean().y);
    EXPECT_NEAR(levels.mean.Mean().y, finest.mean.Mean().y, 0.005 * finest.mean.Mean().y);
}

// White in a white furnace stays white, and a room of a checker keeps its light over all bounces.
TEST_F(TextureLod, FurnacesKeepTheirEnergy) {
    scene::Material white = Lambert(glm::vec3(1.0f));
    white.baseColorTexture = {.texture = 0};
    scene::Mesh ball = SphereMesh(1.0f, 24);
    for (const glm::vec3& normal : ball.primitives[0].normals)
        ball.primitives[0].uv0.push_back({4.0f * normal.x, 4.0f * normal.y});
    scene::SceneData scene = SceneOf({ball}, {white});
    scene.images = {CheckerImage(64, 255, 255)};
    scene.textures = {{.name = "white", .image = 0}};
    render.scene.SetScene(std::move(scene));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings furnace = Facing(4.0f, 0.3f, 16);
    furnace.lights.isOn = false;
    for (const glm::vec4& texel : render.TraceOnce(furnace).values) ASSERT_NEAR(texel.y, 1.0f, 1e-4f);

    scene::Material wall = Lambert(glm::vec3(1.0f), glm::vec3(1.0f));
    wall.baseColorTexture = {.texture = 0};
    scene::Mesh room = BoxMesh(1.0f);
    for (const glm::vec3& position : room.primitives[0].positions)
        room.primitives[0].uv0.push_back({position.x + position.z, position.y + position.z});
    scene = SceneOf({room}, {wall});
    scene.images = {CheckerImage(64, 50, 200)};
    scene.textures = {{.name = "squares", .image = 0, .colorSpace = scene::ColorSpace::Linear}};
    render.scene.SetScene(std::move(scene));
    render.scene.SetEnvironment({});
    TraceSettings settings = LookAt({0.2f, 0.1f, 0.3f}, {1, 0, 0}, 1.5f, 16);
    settings.lights.isOn = false;
    const RenderedImage finest = render.Render(settings, 512);
    settings.biases.textureLod = 0.0f;
    const RenderedImage levels = render.Render(settings, 512);
    EXPECT_LT(finest.StandardErrorOfMean().y, 0.002 * finest.mean.Mean().y);
    EXPECT_NEAR(levels.mean.Mean().y, finest.mean.Mean().y, 0.005 * finest.mean.Mean().y);
    // 1 / (1 - mean albedo), as the squares are small
    EXPECT_NEAR(levels.mean.Mean().y, 1.0 / (1.0 - 125.0 / 255.0), 0.02);
}

// Where nothing has levels, asking for them changes no bit.
TEST_F(TextureLod, SceneWithoutLevelsIsReadAtLevel0) {
    SceneRender plain(Device());
    plain.scene.SetScene(CheckerFloor(Lambert(glm::vec3(1.0f))));
    render.scene.SetScene(CheckerFloor(Lambert(glm::vec3(1.0f))));
    for (SceneRender* one : {&plain, &render}) one->scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings settings = LookAt({0, -9.0f, 3.0f}, {0, 0, 0}, 0.5f, 16);
    const FloatImage finest = plain.TraceOnce(settings);
    EXPECT_EQ(render.TraceOnce(settings).values, finest.values) << "nor do levels that are not asked for";
    settings.biases.textureLod = 0.0f;
    EXPECT_EQ(plain.TraceOnce(settings).values, finest.values);
    EXPECT_NE(render.TraceOnce(settings).values, finest.values);
}

}  // namespace raygraph::testing::texture_lod_test
