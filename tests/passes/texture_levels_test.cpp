#include <gmock/gmock.h>
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <random>

#include "renderer/gpu_scene/materials/texture_plan.h"
#include "renderer/gpu_scene/materials/texture_set.h"
#include "renderer/graph/pass_harness.h"
#include "tests/passes/level_texture.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

// The mip level at which paths read textures: against closed forms of what a pixel sees, and what it does to
// noise and energy.
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

// The finest level decides what is cut out, whatever the distance: of a mean of holes and leaf, a
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

// MakeTextureLevels alone: every level against means worked out here in double, for sizes that halve evenly and
// for those that do not.
namespace raygraph::testing::texture_levels_test {

namespace {

// Four numbers a texel.
struct Grid {
    Extent2D extent;
    std::vector<glm::dvec4> texels;

    const glm::dvec4& At(uint32_t x, uint32_t y) const { return texels[size_t{y} * extent.width + x]; }
    glm::dvec4 Mean() const {
        glm::dvec4 sum(0.0);
        for (const glm::dvec4& texel : texels) sum += texel;
        return sum / double(texels.size());
    }
};

double Decoded(double v) {
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}
double Encoded(double v) {
    return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
}

// The area of [t, t + 1] that texel i of n covers, of m.
double Share(uint32_t t, uint32_t i, uint32_t n, uint32_t m) {
    const double scale = double(m) / n;
    const double begin = std::max<double>(t, i * scale), end = std::min<double>(t + 1.0, (i + 1) * scale);
    return std::max(end - begin, 0.0) / scale;
}

Grid Halved(const Grid& finer) {
    Grid coarser{rhi::MipExtent(finer.extent, 1), {}};
    for (uint32_t y = 0; y < coarser.extent.height; ++y)
        for (uint32_t x = 0; x < coarser.extent.width; ++x) {
            glm::dvec4 sum(0.0);
            for (uint32_t v = 0; v < finer.extent.height; ++v) {
                const double row = Share(v, y, coarser.extent.height, finer.extent.height);
                if (row == 0.0) continue;
                for (uint32_t u = 0; u < finer.extent.width; ++u)
                    sum += row * Share(u, x, coarser.extent.width, finer.extent.width) * finer.At(u, v);
            }
            coarser.texels.push_back(sum);
        }
    return coarser;
}

glm::dvec4 Linear(TexelContent content, const glm::dvec4& stored) {
    const glm::dvec3 rgb(stored);
    if (content == TexelContent::Normals) return {glm::normalize(2.0 * rgb - 1.0), stored.w};
    if (content != TexelContent::Color) return stored;
    return {Decoded(rgb.x), Decoded(rgb.y), Decoded(rgb.z), stored.w};
}
glm::dvec4 Stored(TexelContent content, const glm::dvec4& mean) {
    const glm::dvec3 rgb(mean);
    if (content == TexelContent::Normals) return {0.5 + 0.5 * glm::normalize(rgb), mean.w};
    if (content != TexelContent::Color) return mean;
    return {Encoded(rgb.x), Encoded(rgb.y), Encoded(rgb.z), mean.w};
}

// Codes of 8 bits, brighter and bluer to the right; as normals they point up.
std::vector<float> Noise(Extent2D extent) {
    std::mt19937 random(7 * extent.width + extent.height);
    std::vector<float> values;
    for (uint32_t i = 0; i < extent.width * extent.height; ++i) {
        const uint32_t ramp = 100 * (i % extent.width) / extent.width;
        for (const uint32_t least : {ramp, 40u, 140u + ramp / 10, 5u})
            values.push_back(float(least + random() % 100) / 255.0f);
    }
    return values;
}

Grid GridOf(TexelContent content, Extent2D extent, const std::vector<float>& values) {
    Grid grid{extent, {}};
    for (size_t i = 0; i < values.size(); i += 4)
        grid.texels.push_back(
            Linear(content, glm::dvec4(values[i], values[i + 1], values[i + 2], values[i + 3])));
    return grid;
}

glm::dvec4 TexelAt(const Texels& texels, uint32_t x, uint32_t y) {
    const auto at = texels.At(x, y);
    return {at[0], at[1], at[2], at[3]};
}

class TextureLevelPass : public VulkanTest {
  protected:
    static TextureId Image(PassHarness& h, Extent2D extent, const std::vector<float>& values) {
        return h.Texture("image", extent, Format::Rgba8Unorm, values);
    }
    static TextureId Target(PassHarness& h, Extent2D extent, uint32_t levels) {
        return h.Graph().CreateTexture("target",
                                       {.extent = extent, .format = Format::Rgba8Unorm, .levels = levels});
    }
    std::vector<Texels> Levels(TexelContent content, Extent2D extent, const std::vector<float>& values) {
        return harness.RunAll([&](PassHarness& h) {
            return MakeTextureLevels(h.Graph(), Image(h, extent, values),
                                     Target(h, extent, rhi::FullMipCount(extent)), {.content = content})
                .texture;
        });
    }

    PassHarness harness{Device()};
};

constexpr Extent2D kSizes[] = {{1, 1}, {2, 2}, {7, 3}, {640, 1}, {1, 5}, {5, 5}, {97, 64}, {256, 256}};
constexpr double kHalfCode = 0.5 / 255.0 + 1e-5;

}  // namespace

TEST_F(TextureLevelPass, LevelsAreMeansOverTheAreaOfTheirTexels) {
    for (const Extent2D extent : kSizes)
        for (const TexelContent content : {TexelContent::Data, TexelContent::Color, TexelContent::Normals}) {
            const std::vector<float> values = Noise(extent);
            const std::vector<Texels> levels = Levels(content, extent, values);
            ASSERT_EQ(levels.size(), rhi::FullMipCount(extent));
            Grid expected = GridOf(content, extent, values);
            EXPECT_EQ(levels[0].values, values);
            for (size_t level = 1; level < levels.size(); ++level) {
                expected = Halved(expected);
                ASSERT_EQ(levels[level].extent, expected.extent);
                double worst = 0.0;
                for (uint32_t y = 0; y < expected.extent.height; ++y)
                    for (uint32_t x = 0; x < expected.extent.width; ++x) {
                        const glm::dvec4 difference =
                            glm::abs(TexelAt(levels[level], x, y) - Stored(content, expected.At(x, y)));
                        for (int c = 0; c < 4; ++c) worst = std::max(worst, difference[c]);
                    }
                EXPECT_LT(worst, kHalfCode) << extent.width << "x" << extent.height << " level " << level
                                            << " content " << int(content);
            }
        }
}

// No light is gained or lost, and nothing shifts: of the levels' own texels, rounded to 8 bits.
TEST_F(TextureLevelPass, EveryLevelHasTheMeanOfTheImage) {
    for (const Extent2D extent : {Extent2D{7, 3}, {640, 1}, {5, 5}, {97, 64}, {256, 256}})
        for (const TexelContent content : {TexelContent::Data, TexelContent::Color}) {
            const std::vector<float> values = Noise(extent);
            const glm::dvec4 mean = GridOf(content, extent, values).Mean();
            // These are floats, before they are rounded
            const std::vector<Texels> floats = harness.RunAll([&](PassHarness& h) {
                return MakeTextureLevels(h.Graph(), Image(h, extent, values),
                                         Target(h, extent, rhi::FullMipCount(extent)), {.content = content})
                    .means->levels;
            });
            for (const Texels& level : floats) {
                const Grid grid = GridOf(TexelContent::Data, level.extent, level.values);
                for (int c = 0; c < 4; ++c) EXPECT_NEAR(grid.Mean()[c], mean[c], 2e-6) << extent.width;
            }
            const std::vector<Texels> levels = Levels(content, extent, values);
            for (const Texels& level : levels) {
                const glm::dvec4 rounded = GridOf(content, level.extent, level.values).Mean();
                const double count = double(level.extent.width) * level.extent.height;
                // Independent roundings are at most half a code each, where the curve is steepest
                const double error = 2.3 * kHalfCode * std::min(1.0, 4.0 / std::sqrt(count));
                for (int c = 0; c < 4; ++c) EXPECT_NEAR(rounded[c], mean[c], error) << extent.width;
            }
        }
}

// A white texel among clear black ones, as of a leaf: its color does not darken.
TEST_F(TextureLevelPass, ColorsOfTransparentTexelsDoNotCount) {
    const std::vector<float> values{1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    const std::vector<Texels> levels = Levels(TexelContent::TransparentColor, {2, 2}, values);
    EXPECT_NEAR(levels[1].At(0, 0)[0], 1.0f, 1.5f / 255.0f);
    EXPECT_NEAR(levels[1].At(0, 0)[3], 0.25f, kHalfCode);
    const std::vector<Texels> opaque = Levels(TexelContent::Color, {2, 2}, values);
    EXPECT_NEAR(opaque[1].At(0, 0)[0], Encoded(0.25), kHalfCode);
    // Where all are clear, their colors do
    const std::vector<float> clear{1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    EXPECT_NEAR(Levels(TexelContent::TransparentColor, {2, 2}, clear)[1].At(0, 0)[0], Encoded(0.5),
                1.5f / 255.0f);
}

TEST_F(TextureLevelPass, SmallerTargetHasTheLowerLevels) {
    const Extent2D extent{13, 6};
    const std::vector<float> values = Noise(extent);
    const std::vector<Texels> all = Levels(TexelContent::Color, extent, values);
    for (const uint32_t levelCount : {1u, 2u}) {
        const std::vector<Texels> some = harness.RunAll([&](PassHarness& h) {
            return MakeTextureLevels(h.Graph(), Image(h, extent, values), Target(h, {3, 1}, levelCount),
                                     {.content = TexelContent::Color, .firstLevel = 2})
                .texture;
        });
        ASSERT_EQ(some.size(), levelCount);
        for (uint32_t level = 0; level < levelCount; ++level)
            EXPECT_EQ(some[level].values, all[level + 2].values);
    }
    const auto other = [&] {
        harness.Run([&](PassHarness& h) {
            return MakeTextureLevels(h.Graph(), Image(h, extent, values), Target(h, {3, 2}, 1),
                                     {.firstLevel = 2})
                .texture;
        });
    };
    EXPECT_STREQ(ErrorOf(other).what(),
                 "MakeTextureLevels: an image of 13x6 texels has no level 2 of 3x2 texels");
}

// Waves of slopes +-s in x: their mean normal is as long as the cosine, and slopes have the variance that
// widens alpha^2 twice.
TEST_F(TextureLevelPass, RoughnessGrowsByTheVarianceOfTheNormals) {
    const Extent2D extent{4, 4}, fine{8, 8};
    const double tilt = 0.2, scale = 0.5, factor = 0.8, rough = 102.0 / 255.0;
    std::vector<float> normals, roughness;
    for (uint32_t i = 0; i < 64; ++i) {
        const double x = (i % 2 == 0 ? 1.0 : -1.0) * std::sin(tilt);
        for (const double value : {0.5 + 0.5 * x, 0.5, 0.5 + 0.5 * std::cos(tilt), 1.0})
            normals.push_back(float(std::round(255.0 * value) / 255.0));
    }
    for (uint32_t i = 0; i < 16; ++i)
        for (const double value : {0.2, rough, 0.6, 0.8}) roughness.push_back(float(value));
    const auto run = [&](double normalScale, const std::vector<float>& map) {
        return harness.RunAll([&](PassHarness& h) {
            const TextureLevels bent = MakeTextureLevels(h.Graph(), Image(h, fine, map), Target(h, fine, 4),
                                                         {.content = TexelContent::Normals});
            const RoughnessWidening widening{
                .normals = *bent.means, .normalScale = float(normalScale), .roughnessFactor = float(factor)};
            return MakeTextureLevels(h.Graph(), Image(h, extent, roughness), Target(h, extent, 3),
                                     {.widening = widening})
                .texture;
        });
    };
    const Grid unit = GridOf(TexelContent::Normals, fine, normals);
    const double size = glm::length(glm::dvec3(unit.Mean()));
    const double variance = scale * scale * (1.0 - size) / size;
    const double alpha = factor * factor * rough * rough;
    const double wider = std::pow(alpha * alpha + 2.0 * variance, 0.25) / factor;
    ASSERT_GT(wider, 1.1 * rough);
    const std::vector<Texels> levels = run(scale, normals);
    EXPECT_EQ(levels[0].values,
              testing::DecodeTexels(testing::EncodeTexels(roughness, extent, Format::Rgba8Unorm), extent,
                                    Format::Rgba8Unorm)
                  .values);
    for (size_t level = 1; level < 3; ++level)
        for (uint32_t x = 0; x < levels[level].extent.width; ++x) {
            EXPECT_NEAR(levels[level].At(x, 0)[1], wider, kHalfCode + 1e-4) << level;
            EXPECT_NEAR(levels[level].At(x, 0)[0], 0.2, kHalfCode);
            EXPECT_NEAR(levels[level].At(x, 0)[2], 0.6, kHalfCode);
        }
    // Roughness 1 of what the factor allows is the most; a flat map changes nothing
    EXPECT_EQ(run(1e3, normals)[1].At(0, 0)[1], 1.0f);
    std::vector<float> flat;
    for (uint32_t i = 0; i < 64; ++i) flat.insert(flat.end(), {0.5f, 0.5f, 1.0f, 1.0f});
    EXPECT_NEAR(run(scale, flat)[2].At(0, 0)[1], rough, kHalfCode);
}

// Level 1 of the roughness averages nothing of a normal map of half the size.
TEST_F(TextureLevelPass, SmallNormalMapsWidenOnlyTheLevelsThatAverageThem) {
    std::vector<float> normals, roughness(64 * 4, 0.4f);
    for (uint32_t i = 0; i < 16; ++i)
        for (const float value : {i % 2 == 0 ? 0.7f : 0.3f, 0.5f, 0.95f, 1.0f}) normals.push_back(value);
    const std::vector<Texels> levels = harness.RunAll([&](PassHarness& h) {
        const TextureLevels bent = MakeTextureLevels(
            h.Graph(), Image(h, {4, 4}, normals), Target(h, {4, 4}, 3), {.content = TexelContent::Normals});
        return MakeTextureLevels(h.Graph(), Image(h, {8, 8}, roughness), Target(h, {8, 8}, 4),
                                 {.widening = RoughnessWidening{.normals = *bent.means}})
            .texture;
    });
    EXPECT_NEAR(levels[1].At(0, 0)[1], 0.4f, kHalfCode);
    EXPECT_GT(levels[2].At(0, 0)[1], 0.5f);
    EXPECT_GT(levels[3].At(0, 0)[1], 0.5f);
}

}  // namespace raygraph::testing::texture_levels_test

// Which levels of textures go to the device, and how theirs are made: plans, without a device.
namespace raygraph::testing::texture_plan_test {

namespace {

using scene::Material;
using ::testing::ElementsAre;

constexpr uint64_t kMiB = uint64_t{1} << 20;

std::vector<TextureSizes> Textures(std::initializer_list<rhi::Extent2D> extents, bool makesMipLevels) {
    std::vector<TextureSizes> sizes;
    for (const rhi::Extent2D extent : extents) sizes.push_back(PlainTextureSizes(extent, makesMipLevels));
    return sizes;
}

std::vector<uint64_t> Bytes(const TextureSizes& sizes) {
    std::vector<uint64_t> bytes;
    for (const TextureChoice& choice : sizes.choices) bytes.push_back(choice.bytes);
    return bytes;
}
std::vector<uint32_t> FirstLevels(const TexturePlan& plan) {
    std::vector<uint32_t> levels;
    for (const TextureChoice& choice : plan.choices) levels.push_back(choice.firstLevel);
    return levels;
}

scene::TextureRef Ref(int32_t texture) {
    return {.texture = texture};
}

std::vector<TextureUse> UsesOf(const std::vector<Material>& materials, size_t textureCount) {
    scene::SceneData scene;
    scene.materials = materials;
    scene.textures.resize(textureCount);
    return TextureUses(scene);
}

Material RoughAndBent() {
    Material material;
    material.metallicRoughnessTexture = Ref(0);
    material.normalTexture = Ref(1);
    material.normalScale = 0.5f;
    material.roughnessFactor = 0.75f;
    return material;
}

}  // namespace

TEST(TexturePlan, SizesAreThoseOfTheLevelsThatAreLeft) {
    EXPECT_THAT(Bytes(PlainTextureSizes({5, 2}, false)), ElementsAre(40, 8, 4));
    EXPECT_THAT(Bytes(PlainTextureSizes({5, 2}, true)), ElementsAre(52, 12, 4));
}

TEST(TexturePlan, WhatFitsStaysWhole) {
    const auto textures = Textures({{512, 512}, {1024, 1024}}, false);
    const TexturePlan plan = PlanTextures(textures, 5 * kMiB);
    EXPECT_THAT(FirstLevels(plan), ElementsAre(0, 0));
    EXPECT_EQ(plan.bytes, 5 * kMiB);
    EXPECT_EQ(ReductionText(textures, plan, 5 * kMiB), "");
}

// 4 + 4 + 1 + 4: the first of the large ones goes first, and none a second time before the others had to.
TEST(TexturePlan, TheLargestLoseLevelsFirst) {
    const auto textures = Textures({{1024, 1024}, {1024, 1024}, {512, 512}, {1024, 1024}}, false);
    EXPECT_THAT(FirstLevels(PlanTextures(textures, 13 * kMiB - 1)), ElementsAre(1, 0, 0, 0));
    EXPECT_THAT(FirstLevels(PlanTextures(textures, 9 * kMiB)), ElementsAre(1, 1, 0, 0));
    const TexturePlan plan = PlanTextures(textures, 7 * kMiB / 2);
    EXPECT_THAT(FirstLevels(plan), ElementsAre(2, 1, 0, 1));
    EXPECT_EQ(plan.bytes, 13 * kMiB / 4);
    EXPECT_EQ(ReductionText(textures, plan, 7 * kMiB / 2),
              "3 of 4 textures are smaller on the device, to fit 3.2 MiB into a budget of 3.5 MiB: "
              "2 of 1024x1024 texels are 512x512, 1 of 1024x1024 texels is 256x256");
}

TEST(TexturePlan, NothingIsSmallerThanATexel) {
    const auto textures = Textures({{4, 1}, {1, 1}}, true);
    const TexturePlan plan = PlanTextures(textures, 1);
    EXPECT_THAT(FirstLevels(plan), ElementsAre(2, 0));
    EXPECT_EQ(plan.bytes, 8u);
}

// BC7 of 16 bytes a block: 8x8, 4x4 and no more in the file. One of 2x2 texels of four bytes takes as much as
// a block, and the plain texel less.
TEST(TexturePlan, BlocksShrinkAsFarAsTheirFileHasLevels) {
    const uint64_t levelBytes[] = {64, 16};
    EXPECT_THAT(
        BlockTextureSizes({8, 8}, levelBytes, false).choices,
        ElementsAre(TextureChoice{0, 64, true}, TextureChoice{1, 16, true}, TextureChoice{3, 4, false}));
    EXPECT_THAT(
        BlockTextureSizes({8, 8}, levelBytes, true).choices,
        ElementsAre(TextureChoice{0, 80, true}, TextureChoice{1, 16, true}, TextureChoice{3, 4, false}));
    EXPECT_THAT(
        BlockTextureSizes({8, 8}, std::span(levelBytes).first(1), true).choices,
        ElementsAre(TextureChoice{0, 64, true}, TextureChoice{2, 20, false}, TextureChoice{3, 4, false}));
}

TEST(TextureUses, FollowTheMaterials) {
    Material leaf, plain, bent = RoughAndBent();
    leaf.alphaMode = scene::AlphaMode::Mask;
    leaf.baseColorTexture = Ref(2);
    plain.baseColorTexture = Ref(3);
    scene::SceneData scene;
    scene.materials = {bent, leaf, plain};
    scene.textures.resize(4);
    scene.textures[2].colorSpace = scene.textures[3].colorSpace = scene::ColorSpace::Srgb;
    std::vector<TextureUse> uses = TextureUses(scene);
    EXPECT_EQ(uses[0].content, TexelContent::Data);
    EXPECT_EQ(uses[1].content, TexelContent::Normals);
    EXPECT_EQ(uses[2].content, TexelContent::TransparentColor);
    EXPECT_EQ(uses[3].content, TexelContent::Color);
    ASSERT_TRUE(uses[0].normals);
    EXPECT_EQ(*uses[0].normals, (PairedNormals{1, 0.5f, 0.75f}));
    // Shown opaque elsewhere, or emitted: all texels count
    scene.materials[2].baseColorTexture = Ref(2);
    EXPECT_EQ(TextureUses(scene)[2].content, TexelContent::Color);
    scene.materials[2].baseColorTexture = {};
    scene.materials[2].emissiveTexture = Ref(2);
    EXPECT_EQ(TextureUses(scene)[2].content, TexelContent::Color);
}

TEST(TextureUses, RoughnessIsWidenedOnlyByNormalsThatAllItsMaterialsShare) {
    const Material bent = RoughAndBent();
    Material same = bent, other = bent, flat = bent, moved = bent, smooth = bent;
    same.metallicFactor = 0.0f;
    other.normalScale = 1.0f;
    flat.normalTexture = {};
    moved.normalTexture.transform.offset.x = 0.5f;
    smooth.roughnessFactor = 0.0f;
    EXPECT_TRUE(UsesOf({bent, same}, 2)[0].normals);
    EXPECT_FALSE(UsesOf({bent, other}, 2)[0].normals);
    EXPECT_FALSE(UsesOf({bent, flat}, 2)[0].normals);
    EXPECT_FALSE(UsesOf({flat, bent}, 2)[0].normals);
    EXPECT_FALSE(UsesOf({moved}, 2)[0].normals);
    EXPECT_FALSE(UsesOf({smooth}, 2)[0].normals);
    // Beside a roughness there is often an occlusion, which it does not disturb; a film's thickness is green
    Material occluded = bent, film = bent;
    occluded.occlusionTexture = Ref(0);
    film.iridescenceThicknessTexture = Ref(0);
    EXPECT_TRUE(UsesOf({occluded}, 2)[0].normals);
    EXPECT_FALSE(UsesOf({film}, 2)[0].normals);
}

TEST(TextureUses, NormalsThatAreReadAsSomethingElseTooAreData) {
    Material bent = RoughAndBent();
    bent.specularTexture = Ref(1);
    const std::vector<TextureUse> uses = UsesOf({bent}, 2);
    EXPECT_EQ(uses[1].content, TexelContent::Data);
    EXPECT_FALSE(uses[0].normals);
}

TEST(TextureUses, CoatsHaveNormalsOfTheirOwn) {
    Material coated;
    coated.clearcoatRoughnessTexture = Ref(0);
    coated.clearcoatNormalTexture = Ref(1);
    coated.clearcoatRoughnessFactor = 0.5f;
    coated.normalTexture = Ref(2);
    const std::vector<TextureUse> uses = UsesOf({coated}, 3);
    ASSERT_TRUE(uses[0].normals);
    EXPECT_EQ(*uses[0].normals, (PairedNormals{1, 1.0f, 0.5f}));
}

}  // namespace raygraph::testing::texture_plan_test
