#include "renderer/scene/model/camera_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

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

TEST(CameraView, FramedBoundsAreSeenWhole) {
    scene::Bounds bounds;
    bounds.Extend(vec3(-3, 1, 2));
    bounds.Extend(vec3(5, 2, 40));
    for (const float aspect : {0.4f, 1.0f, 3.0f}) {
        const CameraView view = scene::ViewOfBounds(bounds, aspect);
        ExpectFrame(view);
        for (int corner = 0; corner < 8; ++corner) {
            const vec3 point(corner & 1 ? 5 : -3, corner & 2 ? 2 : 1, corner & 4 ? 40 : 2);
            const vec3 d = glm::dvec3(point) - view.eye;
            const float depth = glm::dot(d, view.forward);
            EXPECT_GT(depth, view.zNear);
            EXPECT_LE(std::abs(glm::dot(d, view.up)) / depth, std::tan(view.yFov / 2) * 1.0001f);
            EXPECT_LE(std::abs(glm::dot(d, view.right)) / depth, std::tan(view.yFov / 2) * aspect * 1.0001f);
        }
    }
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
