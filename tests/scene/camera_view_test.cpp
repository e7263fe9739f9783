// CameraView: cameras of a scene, of a text, and those that frame its bounds.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <random>
#include <string>

#include "renderer/scene/model/camera_view.h"
#include "tests/support/error_of.h"

namespace raygraph::test::camera_view_test {
namespace {

using glm::vec3;
using scene::CameraView;

void ExpectNear(const vec3& actual, const vec3& expected, float tolerance = 1e-5f) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], tolerance) << "component " << i;
}

void ExpectFrame(const CameraView& view) {
    ExpectNear(glm::cross(view.right, view.up), -view.forward);
    EXPECT_NEAR(glm::length(view.right), 1.0f, 1e-5f);
    EXPECT_NEAR(glm::length(view.up), 1.0f, 1e-5f);
    EXPECT_NEAR(glm::length(view.forward), 1.0f, 1e-5f);
}

TEST(CameraView, UntransformedCameraLooksAlongMinusZ) {
    scene::Camera camera;
    camera.yFov = 0.5f;
    const CameraView view = scene::ViewOf(camera, 2.0f);
    ExpectFrame(view);
    ExpectNear(view.forward, {0, 0, -1});
    ExpectNear(view.up, {0, 1, 0});
    ExpectNear(view.right, {1, 0, 0});
    EXPECT_EQ(view.yFov, 0.5f);
    EXPECT_EQ(view.aspect, 2.0f);
}

TEST(CameraView, ScaleShearAndMirrorOfTheNodeAreIgnored) {
    scene::Camera camera;
    camera.cameraToWorld = glm::mat4x3(glm::translate(glm::mat4(1), vec3(1, 2, 3)) *
                                       glm::rotate(glm::mat4(1), 1.0f, vec3(0, 1, 0)) *
                                       glm::scale(glm::mat4(1), vec3(-3, 2, 5)));
    const CameraView view = scene::ViewOf(camera, 1.0f);
    ExpectFrame(view);
    ExpectNear(view.eye, {1, 2, 3});
    ExpectNear(view.forward, {-std::sin(1.0f), 0, -std::cos(1.0f)});
    ExpectNear(view.right, {std::cos(1.0f), 0, -std::sin(1.0f)});
}

TEST(CameraView, OrthographicHeightIsTwiceYMag) {
    scene::Camera camera;
    camera.projection = scene::Projection::Orthographic;
    camera.yMag = 1.5f;
    const CameraView view = scene::ViewOf(camera, 1.0f);
    EXPECT_EQ(view.projection, scene::Projection::Orthographic);
    EXPECT_EQ(view.height, 3.0f);
    EXPECT_GT(view.zNear, 0.0f);
}

TEST(CameraView, LookingStraightUpOrDownStillHasAFrame) {
    for (const float y : {-1.0f, 1.0f}) {
        const CameraView view = CameraView::LookAt({0, 0, 0}, {0, y, 0}, {0, 1, 0});
        ExpectFrame(view);
        ExpectNear(view.forward, {0, y, 0});
    }
    ExpectFrame(CameraView::LookAt({0, 0, 0}, {0, 0, 5}, {0, 0, 0}));
    ExpectFrame(CameraView::LookAt({1, 1, 1}, {1, 1, 1}, {0, 1, 0}));
}

TEST(CameraView, TextGivesEyeTargetUpAndFov) {
    const CameraView view = scene::ViewFromText("1,2,3 1,2,13  1,0,0 60", 1.5f);
    ExpectFrame(view);
    ExpectNear(view.eye, {1, 2, 3});
    ExpectNear(view.forward, {0, 0, 1});
    ExpectNear(view.up, {1, 0, 0});
    EXPECT_FLOAT_EQ(view.yFov, glm::radians(60.0f));
    EXPECT_EQ(view.aspect, 1.5f);
    EXPECT_FLOAT_EQ(scene::ViewFromText("0 0 5 0 0 0", 1).yFov, glm::radians(40.0f));
    EXPECT_FLOAT_EQ(scene::ViewFromText("0 0 5 0 0 0 25", 1).yFov, glm::radians(25.0f));
    ExpectNear(scene::ViewFromText("+1e1 0 5 0 0 0 0 0 1", 1).eye, {10, 0, 5});
    const CameraView flat = scene::ViewFromText("0 0 5 0 0 0 0 1 0 2.5m", 1);
    EXPECT_EQ(flat.projection, scene::Projection::Orthographic);
    EXPECT_FLOAT_EQ(flat.height, 2.5f);
    EXPECT_TRUE(scene::IsViewText("0 0 5 0 0 0 2m"));
    EXPECT_FALSE(scene::IsViewText("2m")) << "a camera may be called so";
}

TEST(CameraView, BadTextIsRefusedWithTheReason) {
    const auto error = [](const char* text) {
        return testing::ErrorTextOf([&] { scene::ViewFromText(text, 1); });
    };
    EXPECT_NE(error("0 0 5 0 0 0 0 1 0 0m").find("above 0"), std::string::npos);
    EXPECT_NE(error("0 0 5 0 0 0m").find("place of the fov"), std::string::npos);
    EXPECT_EQ(error("1 2 3"),
              "camera \"1 2 3\": must have 10 numbers (eye target up fov), or 9, 7 or 6 without fov or up");
    EXPECT_EQ(error("1 2 3 4 5 x"), "camera \"1 2 3 4 5 x\": must be numbers: eye target up fov");
    EXPECT_EQ(error("1 2 3 4 5 nan"), "camera \"1 2 3 4 5 nan\": must be numbers: eye target up fov");
    EXPECT_EQ(error("1 2 3 1 2 3"), "camera \"1 2 3 1 2 3\": eye and target must differ");
    EXPECT_EQ(error("1 2 3 0 0 0 180"), "camera \"1 2 3 0 0 0 180\": fov must be between 0 and 180 degrees");
}

// Returns the distance along the view to the nearest corner.
double NearestDepth(const scene::Bounds& bounds, const CameraView& view) {
    double nearest = 1e30;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 point(corner & 1 ? bounds.max.x : bounds.min.x,
                               corner & 2 ? bounds.max.y : bounds.min.y,
                               corner & 4 ? bounds.max.z : bounds.min.z);
        nearest = std::min(nearest, glm::dot(point - view.eye, glm::dvec3(view.forward)));
    }
    return nearest;
}

// Measures by projection of the corners, without the closed form: the share of the picture's half that is
// seen of the box, at the left, right, bottom and top.
std::array<double, 4> ProjectedBorders(const scene::Bounds& bounds, const CameraView& view) {
    std::array<double, 4> borders;
    borders.fill(-1e30);
    const double slopeY = std::tan(0.5 * view.yFov), slopeX = slopeY * view.aspect;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 point(corner & 1 ? bounds.max.x : bounds.min.x,
                               corner & 2 ? bounds.max.y : bounds.min.y,
                               corner & 4 ? bounds.max.z : bounds.min.z);
        const glm::dvec3 d = point - view.eye;
        const double depth = glm::dot(d, glm::dvec3(view.forward));
        EXPECT_GT(depth, view.zNear);
        const double x = glm::dot(d, glm::dvec3(view.right)) / (depth * slopeX),
                     y = glm::dot(d, glm::dvec3(view.up)) / (depth * slopeY);
        borders = {std::max(borders[0], -x), std::max(borders[1], x), std::max(borders[2], -y),
                   std::max(borders[3], y)};
    }
    return borders;
}

TEST(CameraView, FramedBoundsTouchTheMarginAndAreCentered) {
    std::mt19937 random(7);
    const auto between = [&](float a, float b) { return std::uniform_real_distribution(a, b)(random); };
    int touched = 0;
    for (int i = 0; i < 400; ++i) {
        scene::Bounds bounds;
        const vec3 corner(between(-100, 100), between(-100, 100), between(-100, 100));
        bounds.Extend(corner);
        bounds.Extend(corner +
                      vec3(std::exp(between(-4, 4)), std::exp(between(-4, 4)), std::exp(between(-4, 4))));
        const float aspect = std::exp(between(-1.5f, 1.5f));
        const CameraView view = i % 4 == 0
                                    ? scene::ViewOfBounds(bounds, aspect)
                                    : scene::ViewOfBounds(bounds, {between(-180, 180), between(-90, 90)},
                                                          aspect, between(0.1f, 2));
        ExpectFrame(view);
        const auto [left, right, bottom, top] = ProjectedBorders(bounds, view);
        // The tighter pair of borders is at the margin on both sides; of the other, no side is beyond it
        // A wide view may see all of a box from a corner of it, and then goes no nearer
        if (NearestDepth(bounds, view) > 1e-5 * glm::length(bounds.max - bounds.min)) {
            EXPECT_NEAR(std::max(std::min(left, right), std::min(bottom, top)), scene::kFramedShare, 1e-3)
                << i;
            ++touched;
        }
        EXPECT_LT(std::max({left, right, bottom, top}), scene::kFramedShare + 1e-3) << i;
    }
    EXPECT_GT(touched, 390);
}

TEST(CameraView, TurntableKeepsItsDistanceAndSeesAllOfTheScene) {
    scene::Bounds bounds;
    bounds.Extend(vec3(-3, 1, 2));
    bounds.Extend(vec3(5, 2, 40));
    const CameraView first = scene::ViewOfBounds(bounds, {0.0f, 20.0f, true}, 1.6f);
    for (float azimuth = 0.0f; azimuth < 360.0f; azimuth += 15.0f) {
        const CameraView view = scene::ViewOfBounds(bounds, {azimuth, 20.0f, true}, 1.6f);
        const vec3 center = bounds.Center();
        EXPECT_NEAR(glm::dot(center - vec3(view.eye), view.forward),
                    glm::dot(center - vec3(first.eye), first.forward), 1e-3f);
        EXPECT_NEAR(view.eye.y, first.eye.y, 1e-4);
        EXPECT_NEAR(glm::dot(center - vec3(view.eye), view.right), 0.0f, 1e-3f);
        for (const double border : ProjectedBorders(bounds, view))
            EXPECT_LT(border, scene::kFramedShare + 1e-3);
    }
}

TEST(CameraView, BoardsAreFramedFromWhereTheirFaceIsSeen) {
    const auto seenFrom = [](const vec3& size) {
        scene::Bounds bounds;
        bounds.Extend(vec3(7, 8, 9));
        bounds.Extend(vec3(7, 8, 9) + size);
        return -scene::ViewOfBounds(bounds, 1.5f).forward;
    };
    ExpectNear(seenFrom({2, 1, 0.05f}), {0, 0, 1});
    ExpectNear(seenFrom({0, 3, 2}), {1, 0, 0});
    ExpectNear(seenFrom({4, 0, 3}), {0, 1, 0});
    const vec3 usual = seenFrom({1, 1, 1});
    ExpectNear(seenFrom({4, 0.1f, 3}), usual);      // a floor with something on it
    ExpectNear(seenFrom({10, 0.1f, 0.1f}), usual);  // a rod
}

TEST(CameraView, OrbitIsSeenFromItsAngles) {
    scene::Bounds bounds;
    bounds.Extend(vec3(-1));
    bounds.Extend(vec3(1));
    const auto from = [&](const char* text) {
        return scene::ViewOfBounds(bounds, *scene::OrbitFromText(text), 1);
    };
    ExpectNear(from("orbit 0 0").forward, {0, 0, -1});
    ExpectNear(from("orbit 90 0").forward, {-1, 0, 0});
    ExpectNear(from("orbit 0 90").forward, {0, -1, 0});
    ExpectNear(from("orbit 0 90").up, {0, 0, -1});
    ExpectNear(from("turntable 90 90").up, {-1, 0, 0});
    ExpectNear(from("orbit -90 30").forward, {std::cos(0.5236f), -0.5f, 0});
    EXPECT_EQ(scene::OrbitFromText("orbit 1 91"), std::nullopt);
    EXPECT_EQ(scene::OrbitFromText("orbit 1"), std::nullopt);
    EXPECT_EQ(scene::OrbitFromText("1 2"), std::nullopt);
    const scene::Orbit orbit{12.5f, -3.25f, true};
    EXPECT_EQ(scene::OrbitFromText(scene::ToText(orbit)), orbit);
    ExpectNear(scene::ChooseView({}, "orbit 180 0", 1).forward, {0, 0, 1});
}

TEST(CameraView, EmptyAndPointLikeBoundsGiveAUsableView) {
    ExpectFrame(scene::ViewOfBounds({}, 1.0f));
    scene::Bounds point;
    point.Extend(vec3(100, 100, 100));
    const CameraView view = scene::ViewOfBounds(point, 1.0f);
    ExpectFrame(view);
    EXPECT_GT(glm::distance(view.eye, glm::dvec3(100)), 0.0f);
}

scene::SceneData WithCameras(std::string first = "front") {
    scene::SceneData scene;
    scene.cameras.resize(2);
    scene.cameras[0].name = std::move(first);
    scene.cameras[1].name = "side";
    scene.cameras[1].cameraToWorld[3] = vec3(9, 0, 0);
    return scene;
}

TEST(CameraView, IsChosenByNameThenIndexThenText) {
    scene::SceneData scene = WithCameras();
    ExpectNear(scene::ChooseView(scene, "", 1).eye, {0, 0, 0});
    ExpectNear(scene::ChooseView(scene, "side", 1).eye, {9, 0, 0});
    ExpectNear(scene::ChooseView(scene, "1", 1).eye, {9, 0, 0});
    ExpectNear(scene::ChooseView(scene, "0 4 5 0 0 0", 1).eye, {0, 4, 5});
    ExpectNear(scene::ChooseView(WithCameras("1"), "1", 1).eye, {0, 0, 0});
    scene.cameras.clear();
    EXPECT_GT(glm::length(scene::ChooseView(scene, "", 1).eye), 0.5f) << "frames the bounds";
}

TEST(CameraView, UnknownChoiceListsTheCameras) {
    const scene::SceneData scene = WithCameras();
    EXPECT_EQ(testing::ErrorTextOf([&] { scene::ChooseView(scene, "top", 1); }),
              "there is no camera \"top\"; the scene has 0 \"front\", 1 \"side\"");
    EXPECT_EQ(testing::ErrorTextOf([&] { scene::ChooseView(scene, "2", 1); }),
              "there is no camera \"2\"; the scene has 0 \"front\", 1 \"side\"");
    EXPECT_EQ(testing::ErrorTextOf([&] { scene::ChooseView({}, "top", 1); }),
              "there is no camera \"top\"; the scene has none");
}

}  // namespace
}  // namespace raygraph::test::camera_view_test
