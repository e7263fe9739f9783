// Tests how the editor's camera moves.
#include "editor/app/camera_controller.h"

#include <gtest/gtest.h>

#include <cmath>

namespace raygraph::editor::camera_controller_test {

namespace {

CameraController FromFront(float distance = 4.0f) {
    CameraController camera;
    camera.Set(scene::CameraView::LookAt({0, 0, distance}, {0, 0, 0}, {0, 1, 0}), distance);
    return camera;
}

void ExpectNear(const glm::vec3& a, const glm::vec3& b, float tolerance = 1e-5f) {
    EXPECT_LT(glm::length(a - b), tolerance) << a.x << " " << a.y << " " << a.z;
}

}  // namespace

TEST(CameraController, OrbitKeepsPivotDistanceAndUp) {
    CameraController camera = FromFront();
    camera.Orbit({0.5f, 0.3f});
    ExpectNear(camera.Pivot(), {0, 0, 0});
    EXPECT_NEAR(glm::length(camera.View().eye), 4.0f, 1e-5f);
    EXPECT_GT(camera.View().eye.x, 0.0f) << "to the right";
    EXPECT_GT(camera.View().eye.y, 0.0f) << "and up";
    EXPECT_NEAR(camera.View().right.y, 0.0f, 1e-6f) << "the horizon stays level";
}

TEST(CameraController, OrbitThereAndBackIsWhereItWas) {
    CameraController camera = FromFront();
    camera.Orbit({0.7f, -0.4f});
    camera.Orbit({-0.7f, 0.4f});
    ExpectNear(camera.View().eye, {0, 0, 4});
}

TEST(CameraController, OrbitStopsShortOfThePoles) {
    CameraController camera = FromFront();
    camera.Orbit({0.0f, 10.0f});
    EXPECT_GT(camera.View().eye.y, 3.9f);
    EXPECT_LT(camera.View().forward.y, -0.99f);
    EXPECT_NEAR(glm::length(camera.View().right), 1.0f, 1e-5f);
    camera.Orbit({0.0f, -1.0f});
    EXPECT_LT(camera.View().eye.y, 3.0f) << "it comes back";
}

TEST(CameraController, TurnKeepsTheEye) {
    CameraController camera = FromFront();
    camera.Turn({0.4f, 0.2f});
    ExpectNear(camera.View().eye, {0, 0, 4});
    EXPECT_GT(camera.View().forward.x, 0.0f);
    EXPECT_GT(camera.View().forward.y, 0.0f);
}

TEST(CameraController, PanMovesWhatIsUnderTheCursorWithIt) {
    CameraController camera = FromFront();
    camera.Pan({0.5f, 0.0f});
    // Half a picture to the right is half of the picture's height at the pivot
    const float height = 2.0f * 4.0f * std::tan(0.5f * camera.View().yFov);
    ExpectNear(camera.View().eye, {-0.5f * height, 0, 4});
    ExpectNear(camera.View().forward, {0, 0, -1});
}

TEST(CameraController, DollyTakesSharesOfTheDistance) {
    CameraController camera = FromFront();
    camera.Dolly(1.0f);
    ExpectNear(camera.View().eye, {0, 0, 4.0f * 0.85f});
    ExpectNear(camera.Pivot(), {0, 0, 0});
    camera.Dolly(1000.0f);
    EXPECT_GT(camera.View().eye.z, 0.0f) << "it never passes the pivot";
}

TEST(CameraController, DollyNarrowsAnOrthographicView) {
    CameraController camera;
    scene::CameraView view = scene::CameraView::LookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = 2.0f;
    camera.Set(view, 4.0f);
    camera.Dolly(2.0f);
    EXPECT_NEAR(camera.View().height, 2.0f * 0.85f * 0.85f, 1e-5f);
    ExpectNear(camera.View().eye, {0, 0, 4});
}

TEST(CameraController, FrameShowsAllOfABoxFromWhereItLooks) {
    CameraController camera = FromFront();
    camera.Orbit({0.6f, 0.2f});
    const glm::vec3 forward = camera.View().forward;
    scene::Bounds bounds;
    bounds.Extend(glm::vec3(9, 9, 9));
    bounds.Extend(glm::vec3(11, 11, 11));
    camera.Frame(bounds);
    ExpectNear(camera.View().forward, forward);
    ExpectNear(camera.Pivot(), {10, 10, 10}, 1e-4f);
    const scene::CameraView& view = camera.View();
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 point(corner & 1 ? 9 : 11, corner & 2 ? 9 : 11, corner & 4 ? 9 : 11);
        const glm::vec3 way = glm::dvec3(point) - view.eye;
        const float depth = glm::dot(way, view.forward), half = std::tan(0.5f * view.yFov) * depth;
        EXPECT_LT(std::abs(glm::dot(way, view.up)), half);
        EXPECT_LT(std::abs(glm::dot(way, view.right)), half * view.aspect);
    }
}

TEST(CameraController, FlyGoesAlongItsOwnAxes) {
    CameraController camera = FromFront();
    camera.Fly({1, 2, 3});
    ExpectNear(camera.View().eye, {1, 2, 1});
    ExpectNear(camera.Pivot(), {1, 2, -3});
}

}  // namespace raygraph::editor::camera_controller_test
