// Tests motion blur against closed forms: the fraction of the shutter's time in which a pixel sees a moving
// object.
#include <cmath>
#include <numbers>

#include "editor/session/session.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/cli/cli_test.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::session::motion_blur_test {
namespace {

using namespace scene;  // NOLINT

constexpr uint32_t kSide = 32;

// Emits 1 in all channels on both sides; the scenes have nothing else that it could light.
Material Lamp() {
    Material material;
    material.baseColorFactor = glm::vec4(0.0f, 0.0f, 0.0f, 1.0f);
    material.emissiveFactor = glm::vec3(1.0f);
    material.isDoubleSided = true;
    return material;
}

Primitive Triangles(std::vector<glm::vec3> corners, std::vector<uint32_t> indices) {
    Primitive primitive;
    primitive.positions = std::move(corners);
    primitive.indices = std::move(indices);
    primitive.material = 0;
    primitive.bounds = BoundsOf(primitive.positions);
    return primitive;
}

// Makes one node with a mesh of one primitive, before an orthographic camera that sees from -1 to 1.
SceneData OneMesh(Primitive primitive) {
    SceneData scene;
    scene.materials = {Lamp()};
    scene.meshes.emplace_back().primitives.push_back(std::move(primitive));
    scene.nodes.resize(2);
    scene.nodeOrder = {0, 1};
    scene.instances.emplace_back().node = 0;
    Camera& camera = scene.cameras.emplace_back();
    camera.projection = scene::Projection::Orthographic;
    camera.yMag = 1.0f;
    camera.node = 1;
    scene.nodes[1].translation = glm::vec3(0.0f, 0.0f, 5.0f);
    UpdateWorldTransforms(scene);
    return scene;
}

// Animates from 0 to 1 s at constant speed.
void Animate(SceneData& scene, const AnimationTarget& target, std::vector<float> values) {
    Animation& animation = scene.animations.emplace_back();
    animation.duration = 1.0f;
    animation.samplers.push_back({.width = static_cast<uint32_t>(values.size() / 2),
                                  .times = {0.0f, 1.0f},
                                  .values = std::move(values)});
    animation.channels.push_back({0, target});
}

class MotionBlurTest : public testing::VulkanTest {
  protected:
    static Session Animated(SceneData scene, double at, const std::optional<Shutter>& shutter = {},
                            const AovSet& aovs = {}) {
        SceneInput input = MakeInput(std::move(scene), "ours");
        input.isAnimated = true;
        SessionDesc desc;
        desc.settings.size = {kSide, kSide};
        desc.settings.at = at;
        desc.settings.shutter = shutter;
        desc.settings.light = DefaultLight::None;
        desc.aovs = aovs;
        return Session(Device(), std::move(input), desc);
    }
    static Texels Picture(SceneData scene, const std::optional<Shutter>& shutter, uint32_t samples,
                          double at = 0.0) {
        Session session = Animated(std::move(scene), at, shutter);
        session.Run({.samples = samples});
        return session.Result().render.radiance;
    }
    static float At(const Texels& picture, uint32_t x, uint32_t y) {
        return picture[4 * (size_t{y} * kSide + x)];
    }
    // Returns the position of a pixel's center in the picture, from -1 to 1.
    static double Place(uint32_t pixel) { return (2.0 * pixel + 1.0) / kSide - 1.0; }

    // Expects the blur of an edge at x(t) = -0.5 + t, whose object is left of it, with the shutter open from
    // 0.25 to 0.75 s: full coverage, a straight ramp from -0.25 to 0.25, then none.
    static void ExpectRamp(const Texels& picture, uint32_t samples) {
        double worst = 0.0;
        for (uint32_t x = 0; x < kSide; ++x) {
            const double place = Place(x), half = 1.0 / kSide;
            const double share = std::clamp((0.25 - place) / 0.5, 0.0, 1.0);
            const bool isAtBend = std::abs(std::abs(place) - 0.25) < half;
            for (const uint32_t y : {10u, 16u, 21u}) {
                const double error = std::abs(At(picture, x, y) - share);
                if (!isAtBend) worst = std::max(worst, error);
            }
        }
        // The position in the pixel is sampled independently of the time, so the error is not 1 / `samples`;
        // a staircase of a few times would be off by far more.
        EXPECT_LT(worst, 4.0 / samples + 0.03);
    }
};

Primitive LeftHalf(float end) {
    return Triangles({{-4.0f, -4.0f, 0.0f}, {end, -4.0f, 0.0f}, {end, 4.0f, 0.0f}, {-4.0f, 4.0f, 0.0f}},
                     {0, 1, 2, 0, 2, 3});
}

constexpr uint32_t kSamples = 128;

TEST_F(MotionBlurTest, EdgeOfAMovingNodeIsARamp) {
    SceneData scene = OneMesh(LeftHalf(-0.5f));
    Animate(scene, {.property = AnimatedProperty::Translation, .object = 0}, {0, 0, 0, 1, 0, 0});
    ExpectRamp(Picture(std::move(scene), Shutter{0.25, 0.75}, kSamples), kSamples);
}

TEST_F(MotionBlurTest, EdgeBeforeAMovingCameraIsARamp) {
    SceneData scene = OneMesh(LeftHalf(-0.5f));
    Animate(scene, {.property = AnimatedProperty::Translation, .object = 1}, {0, 0, 5, -1, 0, 5});
    ExpectRamp(Picture(std::move(scene), Shutter{0.25, 0.75}, kSamples), kSamples);
}

TEST_F(MotionBlurTest, EdgeOfMovingVerticesIsARamp) {
    Primitive half = LeftHalf(-0.5f);
    MorphTarget& target = half.targets.emplace_back();
    target.positions = {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 0, 0}};
    UpdateDeformationBounds(half);
    SceneData scene = OneMesh(std::move(half));
    scene.meshes[0].weights = {0.0f};
    Animate(scene, {.property = AnimatedProperty::MeshWeights, .object = 0}, {0, 1});
    ExpectRamp(Picture(std::move(scene), Shutter{0.25, 0.75}, kSamples), kSamples);
}

TEST_F(MotionBlurTest, ShutterIsAroundTheTimeOfThePicture) {
    SceneData scene = OneMesh(LeftHalf(-0.5f));
    Animate(scene, {.property = AnimatedProperty::Translation, .object = 0}, {0, 0, 0, 1, 0, 0});
    const Texels from0 = Picture(scene, Shutter{0.25, 0.75}, 8),
                 around = Picture(scene, Shutter{-0.25, 0.25}, 8, 0.5);
    EXPECT_EQ(from0, around);
}

// A quarter disc turns by a quarter while the shutter is open. Where it starts, it is seen until it has
// turned past; ahead of it, from its arrival on.
TEST_F(MotionBlurTest, RotatingDiscIsALinearRampInTheAngle) {
    const float half = std::sqrt(0.5f);
    SceneData scene = OneMesh(Triangles({{0, 0, 0}, {1.4f, 0, 0}, {0, 1.4f, 0}}, {0, 1, 2}));
    Animate(scene, {.property = AnimatedProperty::Rotation, .object = 0}, {0, 0, 0, 1, 0, 0, half, half});
    const Texels picture = Picture(std::move(scene), Shutter{0.0, 1.0}, 2 * kSamples);
    double worst = 0.0, sum = 0.0;
    int count = 0;
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            const double right = Place(x), up = -Place(y), radius = std::hypot(right, up);
            if (radius < 0.4 || radius > 0.9) continue;
            double angle = std::atan2(up, right) / (0.5 * std::numbers::pi);  // in quarters
            if (angle < 0.0) angle += 4.0;
            const double share = angle < 2.0 ? 1.0 - std::abs(angle - 1.0) : 0.0;
            const double error = At(picture, x, y) - share;
            worst = std::max(worst, std::abs(error));
            sum += error;
            ++count;
        }
    EXPECT_LT(worst, 0.09);
    EXPECT_LT(std::abs(sum / count), 0.003);
}

// A lamp grows: the light on the floor is the mean over its poses, each of which is rendered separately.
TEST_F(MotionBlurTest, DeformingLampLightsAsItsPosesDo) {
    Primitive lamp =
        Triangles({{-0.2f, 0.6f, -0.2f}, {0.2f, 0.6f, -0.2f}, {0.2f, 0.6f, 0.2f}, {-0.2f, 0.6f, 0.2f}},
                  {0, 1, 2, 0, 2, 3});
    lamp.targets.emplace_back().positions = {{-1, 0, 0}, {1, 0.2f, 0}, {1, 0.2f, 0}, {-1, 0, 0}};
    UpdateDeformationBounds(lamp);
    SceneData scene = OneMesh(std::move(lamp));
    scene.meshes[0].weights = {0.0f};
    Material wall;
    wall.metallicFactor = 0.0f;
    wall.isDoubleSided = true;
    scene.materials.push_back(wall);
    scene.meshes.emplace_back().primitives.push_back(
        Triangles({{-4, -1, -4}, {4, -1, -4}, {4, 1, -1}, {-4, 1, -1}}, {0, 1, 2, 0, 2, 3}));
    scene.meshes[1].primitives[0].material = 1;
    scene.nodes.emplace_back();
    scene.nodeOrder.push_back(2);
    scene.instances.emplace_back().node = 2;
    scene.instances[1].mesh = 1;
    UpdateWorldTransforms(scene);
    Animate(scene, {.property = AnimatedProperty::MeshWeights, .object = 0}, {0, 1});
    const auto mean = [](const Texels& picture) {
        double sum = 0.0;
        for (uint32_t y = 18; y < 30; ++y)
            for (uint32_t x = 4; x < 28; ++x) sum += At(picture, x, y);
        return sum / (12 * 24);
    };
    const double blurred = mean(Picture(scene, Shutter{0.0, 1.0}, 64));
    Session session = Animated(std::move(scene), 0.0);
    double poses = 0.0, first = 0.0;
    constexpr int kPoses = 8;
    for (int i = 0; i < kPoses; ++i) {
        session.StartPicture({.at = (i + 0.5) / kPoses});
        session.Run({.samples = 4});
        const double pose = mean(session.Result().render.radiance);
        if (i == 0) first = pose;
        poses += pose / kPoses;
    }
    EXPECT_GT(first, 0.0);
    EXPECT_GT(poses, 2.0 * first) << "the lamp grows";
    EXPECT_NEAR(blurred, poses, 0.01 * poses);
}

class MotionVectorTest : public MotionBlurTest {
  protected:
    // Returns x and y per pixel: the motion from 0.25 to 0.75 s of the surface that is seen at 0 s.
    static std::vector<float> Vectors(SceneData scene) {
        Session session = Animated(std::move(scene), 0.0, Shutter{0.25, 0.75}, {Aov::Motion});
        session.Run({.samples = 1});
        return session.Result().render.motion;
    }
    static void ExpectVector(const std::vector<float>& vectors, uint32_t x, uint32_t y, double right,
                             double down) {
        ASSERT_EQ(vectors.size(), 2 * kSide * kSide);
        EXPECT_NEAR(vectors[2 * (kSide * y + x)], right, 1e-3) << x << " " << y;
        EXPECT_NEAR(vectors[2 * (kSide * y + x) + 1], down, 1e-3) << x << " " << y;
    }
    static constexpr double kPixels = 0.5 * kSide;  // pixels per unit in the picture
};

TEST_F(MotionVectorTest, OfAMovingNode) {
    SceneData scene = OneMesh(LeftHalf(0.5f));
    Animate(scene, {.property = AnimatedProperty::Translation, .object = 0}, {0, 0, 0, 0.3f, 0.2f, 0});
    const std::vector<float> vectors = Vectors(std::move(scene));
    ExpectVector(vectors, 5, 9, 0.15 * kPixels, -0.1 * kPixels);
    ExpectVector(vectors, kSide - 2, 9, 0.0, 0.0);  // nothing is there
}

TEST_F(MotionVectorTest, OfMovingVertices) {
    Primitive half = LeftHalf(0.5f);
    half.targets.emplace_back().positions = {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 0, 0}};
    UpdateDeformationBounds(half);
    SceneData scene = OneMesh(std::move(half));
    scene.meshes[0].weights = {0.0f};
    Animate(scene, {.property = AnimatedProperty::MeshWeights, .object = 0}, {0, 1});
    const std::vector<float> vectors = Vectors(std::move(scene));
    for (const uint32_t x : {2u, 13u, 20u})
        ExpectVector(vectors, x, 17, 0.5 * (Place(x) + 4.0) / 4.5 * kPixels, 0.0);
}

// Before a camera that turns to the left, a surface and the infinitely distant sky both move to the right.
TEST_F(MotionVectorTest, OfATurningCamera) {
    SceneData scene = OneMesh(LeftHalf(0.0f));
    Camera& camera = scene.cameras[0];
    camera.projection = scene::Projection::Perspective;
    camera.yFov = 1.0f;
    const float half = 0.15f;
    Animate(scene, {.property = AnimatedProperty::Rotation, .object = 1},
            {0, 0, 0, 1, 0, std::sin(half), 0, std::cos(half)});
    const double scale = std::tan(0.5 * double{camera.yFov});
    const std::vector<float> vectors = Vectors(std::move(scene));
    for (const uint32_t x : {4u, 25u}) {
        const double angle = std::atan(Place(x) * scale);
        const auto at = [&](double seconds) { return std::tan(angle + 0.3 * seconds) / scale * kPixels; };
        const uint32_t middle = kSide / 2;  // half a pixel below the axis: the row bends a little
        EXPECT_NEAR(vectors[2 * (kSide * middle + x)], at(0.75) - at(0.25), 0.02) << x;
    }
}

TEST_F(MotionVectorTest, NeedAShutter) {
    PictureSettings settings;
    EXPECT_FALSE(CanHave(Aov::Motion, settings));
    settings.shutter = Shutter{0.0, 1.0};
    EXPECT_TRUE(CanHave(Aov::Motion, settings));
}

// Positions are relative to the camera at the time of the picture, and not to its rest pose.
TEST_F(MotionBlurTest, FarWayKeepsThePrecisionOfPlaces) {
    const auto at = [](double seconds) {
        SceneData scene = OneMesh(LeftHalf(-0.47f));
        scene.nodes.resize(3);
        scene.nodes[0].parent = scene.nodes[1].parent = 2;
        scene.nodeOrder = {2, 0, 1};
        UpdateWorldTransforms(scene);
        Animate(scene, {.property = AnimatedProperty::Translation, .object = 2}, {0, 0, 0, 1e7f, 0, 0});
        return Picture(std::move(scene), std::nullopt, 4, seconds);
    };
    const Texels near = at(0.0), far = at(1.0);
    double worst = 0.0;
    for (size_t i = 0; i < near.size(); ++i) worst = std::max(worst, std::abs(double{near[i]} - far[i]));
    EXPECT_LT(worst, 0.3) << "a sample at the edge";
    EXPECT_EQ(At(near, 2, 9), 1.0f);
    EXPECT_EQ(At(far, 20, 9), 0.0f);
}

// A picture has the bits of one in a session of its own, although the origin of the device's coordinates would
// have stayed where the earlier time had it: the way is shorter than OriginHysteresis lets one viewpoint go.
TEST_F(MotionBlurTest, FarWay_LeavesNoTraceInLaterTimes) {
    const auto open = [](double at) {
        SceneData scene = OneMesh(LeftHalf(-0.47f));
        scene.nodes.resize(3);
        scene.nodes[0].parent = scene.nodes[1].parent = 2;
        scene.nodes[1].translation.z = 5.00002f;  // between the steps of a float at 700 m
        scene.nodeOrder = {2, 0, 1};
        UpdateWorldTransforms(scene);
        Animate(scene, {.property = AnimatedProperty::Translation, .object = 2},
                {0, 0, 0, 700.3f, 0, 700.7f});
        return Animated(std::move(scene), at, std::nullopt, {Aov::Depth});
    };
    Session own = open(1.0), later = open(0.0);
    own.Run({.samples = 2});
    later.Run({.samples = 1});
    later.StartPicture({.at = 1.0});
    later.Run({.samples = 2});
    EXPECT_EQ(later.Result().render.depth, own.Result().render.depth);
    EXPECT_NEAR(own.Result().render.depth[kSide * 16 + 2], 5.00002f, 1e-5f);
}

TEST_F(MotionBlurTest, WhatAnAnimationMakesShineIsASampledLight) {
    SceneData scene = OneMesh(LeftHalf(-0.5f));
    scene.materials[0].emissiveFactor = glm::vec3(0.0f);
    uint8_t field = 0, index = 0;
    ForEachMaterialField([&](const auto& each) {
        if (std::string_view(each.name) == "emissiveFactor") field = index;
        ++index;
    });
    Animate(scene, {.property = AnimatedProperty::MaterialField, .field = field, .object = 0},
            {0, 0, 0, 1, 1, 1});
    Session session = Animated(std::move(scene), 1.0);
    session.Run({.samples = 1});
    EXPECT_EQ(session.Statistics().scene.emissiveTriangleCount, 2u);
    EXPECT_EQ(At(session.Result().render.radiance, 2, 9), 1.0f);
    session.StartPicture({.at = 0.0});
    session.Run({.samples = 1});
    EXPECT_EQ(At(session.Result().render.radiance, 2, 9), 0.0f);
}

// The bits are equal whether samples come from one run or two, and in whichever order times were seen before.
TEST_F(MotionBlurTest, BitsDoNotDependOnTheRuns) {
    const auto open = [](double at) {
        SceneData scene = OneMesh(LeftHalf(-0.5f));
        Animate(scene, {.property = AnimatedProperty::Translation, .object = 0}, {0, 0, 0, 1, 0, 0});
        return Animated(std::move(scene), at, Shutter{-0.25, 0.25}, {Aov::Depth, Aov::Albedo});
    };
    Session once = open(0.5), twice = open(0.5);
    once.Run({.samples = 6});
    twice.Run({.samples = 3});
    twice.Run({.samples = 6});
    const RenderFile a = once.Result().render, b = twice.Result().render;
    EXPECT_EQ(a.radiance, b.radiance);
    EXPECT_EQ(a.albedo, b.albedo);
    EXPECT_EQ(a.depth, b.depth);
    // At 0.5 s the edge is in the middle: depth is not blurred
    EXPECT_TRUE(std::isfinite(a.depth[kSide * 16 + 15]));
    EXPECT_FALSE(std::isfinite(a.depth[kSide * 16 + 17]));
    // Another time in the same session equals that time in a session of its own
    twice.StartPicture({.at = 0.6});
    EXPECT_FALSE(twice.HasResult());
    twice.Run({.samples = 4});
    Session own = open(0.6);
    own.Run({.samples = 4});
    EXPECT_EQ(twice.Result().render.radiance, own.Result().render.radiance);
    EXPECT_EQ(twice.Result().render.settings, own.Result().render.settings);
    EXPECT_NE(own.Result().render.radiance, once.Result().render.radiance);
}

}  // namespace
}  // namespace raygraph::session::motion_blur_test
