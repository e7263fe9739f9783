// Tests the positions of the gizmo's handles, and the effect of dragging them.
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "editor/app/actions.h"
#include "editor/app/camera_controller.h"
#include "editor/app/gizmo.h"
#include "editor/app/input.h"

namespace raygraph::editor::gizmo_test {

namespace {

constexpr glm::vec2 kSize{800.0f, 600.0f};

PictureMap FrontMap(scene::Projection projection = scene::Projection::Perspective) {
    scene::CameraView view = scene::CameraView::LookAt({1, 2, 8}, {0, 0, 0}, {0, 1, 0});
    view.projection = projection;
    view.height = 5.0f;
    return {view, kSize};
}

void ExpectNear(const glm::vec3& a, const glm::vec3& b, float tolerance = 1e-4f) {
    EXPECT_LT(glm::length(a - b), tolerance)
        << a.x << " " << a.y << " " << a.z << " against " << b.x << " " << b.y << " " << b.z;
}

glm::vec3 Applied(const glm::mat4& change, const glm::vec3& point) {
    return glm::vec3(change * glm::vec4(point, 1.0f));
}

Ray RayTo(const PictureMap& map, const glm::vec3& point) {
    return map.RayAt(*map.PlaceOf(point));
}

// Returns the change by a drag from one point in space to another.
glm::mat4 Dragged(GizmoTool tool, GizmoHandle handle, const glm::vec3& from, const glm::vec3& to,
                  const glm::mat4x3& node = glm::mat4x3(1.0f), GizmoSpace space = GizmoSpace::World,
                  bool isSnapping = false) {
    const PictureMap map = FrontMap();
    const GizmoFrame frame = *FrameOf(node, tool, space, map);
    return GizmoDrag(tool, handle, frame, map, RayTo(map, from)).Change(RayTo(map, to), isSnapping);
}

}  // namespace

TEST(GizmoMaths, PlacesAndRaysAreInverse) {
    for (const auto projection : {scene::Projection::Perspective, scene::Projection::Orthographic}) {
        const PictureMap map = FrontMap(projection);
        const glm::vec3 point(0.4f, -0.7f, 0.9f);
        const Ray ray = RayTo(map, point);
        const glm::vec3 way = point - ray.origin;
        EXPECT_NEAR(glm::length(ray.direction), 1.0f, 1e-6f);
        ExpectNear(way - glm::dot(way, ray.direction) * ray.direction, glm::vec3(0.0f));
        const glm::vec3 beside = point + map.View().up * map.MetersAt(point, 10.0f);
        EXPECT_NEAR(map.PlaceOf(point)->y - map.PlaceOf(beside)->y, 10.0f, 1e-2f);
    }
    EXPECT_FALSE(FrontMap().PlaceOf({1, 2, 9})) << "behind the eye";
}

TEST(GizmoMaths, NearestAlongIsTheFootOfTheCommonPerpendicular) {
    // A line along x, and a ray down that passes it at x = 3
    EXPECT_NEAR(*ClosestPointOnAxis({1, 0, 0}, {1, 0, 0}, {{3, 5, 2}, {0, -1, 0}}), 2.0f, 1e-6f);
    const glm::vec3 slanted = glm::normalize(glm::vec3(1, -1, 0));
    EXPECT_NEAR(*ClosestPointOnAxis({0, 0, 0}, {1, 0, 0}, {{0, 2, 7}, slanted}), 2.0f, 1e-5f);
    EXPECT_FALSE(ClosestPointOnAxis({0, 0, 0}, {1, 0, 0}, {{0, 1, 0}, {1, 0, 0}}));
}

TEST(GizmoMaths, PlaneIsMetInFrontAlone) {
    ExpectNear(*IntersectPlane({0, 1, 0}, {0, 1, 0}, {{2, 5, 3}, {0, -1, 0}}), {2, 1, 3});
    EXPECT_FALSE(IntersectPlane({0, 1, 0}, {0, 1, 0}, {{2, 5, 3}, {0, 1, 0}}));
    EXPECT_FALSE(IntersectPlane({0, 1, 0}, {0, 1, 0}, {{2, 5, 3}, {1, 0, 0}}));
}

TEST(Gizmo, MoveAlongAnAxisStaysOnIt) {
    // The mouse also moves up: only x counts
    const glm::mat4 change = Dragged(GizmoTool::Move, GizmoHandle::X, {0.5f, 0, 0}, {1.25f, 0, 0});
    ExpectNear(Applied(change, {7, 7, 7}), {7.75f, 7, 7});
    const glm::vec3 aside =
        Applied(Dragged(GizmoTool::Move, GizmoHandle::Y, {0, 0.5f, 0}, {0.3f, 0.9f, 0.2f}), glm::vec3(0.0f));
    EXPECT_EQ(aside.x, 0.0f);
    EXPECT_EQ(aside.z, 0.0f);
    EXPECT_GT(aside.y, 0.2f);
}

TEST(Gizmo, MoveInAPlaneFollowsTheMouse) {
    const glm::mat4 change = Dragged(GizmoTool::Move, GizmoHandle::PlaneY, {0.2f, 0, 0.2f}, {0.7f, 0, -0.4f});
    ExpectNear(Applied(change, glm::vec3(0.0f)), {0.5f, 0, -0.6f});
    const PictureMap map = FrontMap();
    const glm::vec3 step = 0.4f * map.View().right - 0.3f * map.View().up;
    ExpectNear(Applied(Dragged(GizmoTool::Move, GizmoHandle::Whole, {0, 0, 0}, step), glm::vec3(0.0f)), step);
}

TEST(Gizmo, LocalAxesAreTheNodes) {
    const glm::mat4x3 turned(
        glm::rotate(glm::mat4(1.0f), glm::half_pi<float>(), glm::vec3(0, 0, 1)));  // its x is up
    const glm::mat4 change =
        Dragged(GizmoTool::Move, GizmoHandle::X, {0, 0.2f, 0}, {0, 0.8f, 0}, turned, GizmoSpace::Local);
    ExpectNear(Applied(change, glm::vec3(0.0f)), {0, 0.6f, 0});
}

TEST(Gizmo, RotationTurnsAboutTheOriginByTheAngleOfTheMouse) {
    glm::mat4x3 node(1.0f);
    node[3] = {0.5f, 0.5f, 0.0f};
    const glm::vec3 o = node[3];
    const float angle = glm::radians(50.0f);
    const glm::vec3 from = o + glm::vec3(0.6f, 0, 0),
                    to = o + 0.6f * glm::vec3(std::cos(angle), std::sin(angle), 0);
    const glm::mat4 change = Dragged(GizmoTool::Rotate, GizmoHandle::Z, from, to, node);
    ExpectNear(Applied(change, o), o);
    ExpectNear(Applied(change, o + glm::vec3(1, 0, 0)), o + glm::vec3(std::cos(angle), std::sin(angle), 0));
    const glm::mat4 snapped =
        Dragged(GizmoTool::Rotate, GizmoHandle::Z, from, to, node, GizmoSpace::World, true);
    const float step = glm::radians(45.0f);
    ExpectNear(Applied(snapped, o + glm::vec3(1, 0, 0)), o + glm::vec3(std::cos(step), std::sin(step), 0));
}

TEST(Gizmo, RingSeenFromItsEdgeTurnsAlongIt) {
    // The eye is at a height of 2 and a distance of 8, so that y's ring is nearly a line. Its front follows
    // the mouse to the right: +y turns +z to +x.
    const PictureMap map = FrontMap();
    const GizmoFrame frame = *FrameOf(glm::mat4x3(1.0f), GizmoTool::Rotate, GizmoSpace::World, map);
    const glm::vec3 front = frame.size * glm::normalize(glm::vec3(1, 0, 8));
    const GizmoDrag drag(GizmoTool::Rotate, GizmoHandle::Y, frame, map, RayTo(map, front));
    ExpectNear(Applied(drag.Change(RayTo(map, front), false), {1, 0, 0}), {1, 0, 0}, 1e-3f);
    const glm::vec3 along = glm::normalize(glm::cross(glm::vec3(0, 1, 0), front));
    const glm::mat4 change = drag.Change(RayTo(map, front + 0.3f * frame.size * along), false);
    const glm::vec3 turned = Applied(change, {0, 0, 1});
    EXPECT_NEAR(std::atan2(turned.x, turned.z), 0.3f, 0.03f);
    EXPECT_NEAR(turned.y, 0.0f, 1e-5f);
}

TEST(Gizmo, ScaleKeepsTheOriginAndStretchesItsAxis) {
    glm::mat4x3 node(1.0f);
    node[3] = {0.5f, 0, 0};
    const glm::mat4 change = Dragged(GizmoTool::Scale, GizmoHandle::X, {0.9f, 0, 0}, {1.3f, 0, 0}, node);
    ExpectNear(Applied(change, {0.5f, 0, 0}), {0.5f, 0, 0});
    ExpectNear(Applied(change, {1.5f, 1, 1}), {2.5f, 1, 1}, 1e-3f);
    const glm::mat4 plane =
        Dragged(GizmoTool::Scale, GizmoHandle::PlaneY, {0.9f, 0, 0.4f}, {1.3f, 0, 0.8f}, node);
    ExpectNear(Applied(plane, {1.5f, 1, 1}), {2.5f, 1, 2}, 1e-3f);
    const glm::mat4 flat = Dragged(GizmoTool::Scale, GizmoHandle::X, {0.9f, 0, 0}, {-3.0f, 0, 0}, node);
    EXPECT_GT(Applied(flat, {1.5f, 0, 0}).x, 0.5f) << "never to nothing, nor through itself";
    const PictureMap map = FrontMap();
    const glm::mat4 whole =
        Dragged(GizmoTool::Scale, GizmoHandle::Whole, node[3], node[3] + 0.2f * map.View().right, node);
    const glm::vec3 grown = Applied(whole, {1.5f, 1, 1}) - node[3];
    EXPECT_GT(grown.x, 1.05f);
    EXPECT_NEAR(grown.x, grown.y, 1e-4f);
}

TEST(Gizmo, HandlesAreWhereTheyAreDrawn) {
    const PictureMap map = FrontMap();
    for (const GizmoTool tool : {GizmoTool::Move, GizmoTool::Rotate, GizmoTool::Scale}) {
        const GizmoFrame frame = *FrameOf(glm::mat4x3(1.0f), tool, GizmoSpace::World, map);
        const std::vector<GizmoShape> shapes = ShapesOf(frame, tool, map);
        EXPECT_GE(shapes.size(), 4u);
        if (tool == GizmoTool::Rotate) continue;
        const glm::vec2 tip = *map.PlaceOf(0.95f * frame.size * frame.axes[1]);
        EXPECT_EQ(HandleAt(shapes, tip, 6.0f), GizmoHandle::Y);
        EXPECT_EQ(HandleAt(shapes, *map.PlaceOf({0, 0, 0}), 6.0f), GizmoHandle::Whole);
        EXPECT_FALSE(HandleAt(shapes, tip + glm::vec2(30, -30), 6.0f));
        EXPECT_NEAR(glm::length(*map.PlaceOf({0, frame.size, 0}) - *map.PlaceOf({0, 0, 0})), 90.0f, 10.0f)
            << "as large however far away it is";
    }
}

TEST(Gizmo, ArmThatPointsAtTheEyeCannotBeTaken) {
    const PictureMap map({scene::CameraView::LookAt({0, 0, 8}, {0, 0, 0}, {0, 1, 0})}, kSize);
    const GizmoFrame frame = *FrameOf(glm::mat4x3(1.0f), GizmoTool::Move, GizmoSpace::World, map);
    const std::vector<GizmoShape> shapes = ShapesOf(frame, GizmoTool::Move, map);
    const auto has = [&](GizmoHandle handle) {
        return std::ranges::any_of(shapes, [&](const GizmoShape& s) { return s.handle == handle; });
    };
    EXPECT_FALSE(has(GizmoHandle::Z));
    EXPECT_TRUE(has(GizmoHandle::PlaneZ));
    EXPECT_FALSE(has(GizmoHandle::PlaneX));
    EXPECT_FALSE(FrameOf(glm::mat4x3(glm::translate(glm::mat4(1.0f), glm::vec3(0, 0, 9))), GizmoTool::Move,
                         GizmoSpace::World, map))
        << "behind the eye";
}

TEST(Gizmo, AFlatNodeHasTheNormalOfItsPlaneForItsThirdAxis) {
    const PictureMap map = FrontMap();
    glm::mat4x3 node(glm::rotate(glm::mat4(1.0f), 0.7f, glm::vec3(0, 1, 0)));
    const glm::vec3 normal = node[2];
    node[2] = glm::vec3(0.0f);
    for (const GizmoTool tool : {GizmoTool::Move, GizmoTool::Rotate, GizmoTool::Scale}) {
        const std::optional<GizmoFrame> frame = FrameOf(node, tool, GizmoSpace::Local, map);
        ASSERT_TRUE(frame);
        ExpectNear(frame->axes[2], normal);
        ExpectNear(frame->axes[0], node[0]);
    }
    node[1] = glm::vec3(0.0f);
    EXPECT_FALSE(FrameOf(node, GizmoTool::Move, GizmoSpace::Local, map)) << "a line has none";
}

TEST(Gizmo, LocalTransformFollowsBelowATurnedParent) {
    const glm::mat4x3 parent(glm::translate(glm::mat4(1.0f), glm::vec3(3, 2, 1)) *
                             glm::rotate(glm::mat4(1.0f), 0.7f, glm::vec3(0, 1, 0)) *
                             glm::scale(glm::mat4(1.0f), glm::vec3(2.0f)));
    const glm::mat4x3 local(glm::translate(glm::mat4(1.0f), glm::vec3(0.5f, 0, 0)));
    const glm::mat4 change = glm::translate(glm::mat4(1.0f), glm::vec3(0, 1, 0));
    const glm::mat4 after = glm::mat4(parent) * glm::mat4(*ApplyToLocal(change, parent, local));
    ExpectNear(glm::vec3(after[3]), Applied(glm::mat4(parent), {0.5f, 0, 0}) + glm::vec3(0, 1, 0));
    glm::mat4x3 flat = parent;
    flat[0] = glm::vec3(0.0f);
    EXPECT_FALSE(ApplyToLocal(change, flat, local));
}

// Otherwise a rotated joint would move by rounding, which an animation may not allow.
TEST(Gizmo, WhatTheToolLeavesAloneStaysToTheBit) {
    glm::mat4x3 before(1.0f), after(2.0f);
    before[3] = {1, 2, 3};
    after[3] = {4, 5, 6};
    glm::mat4x3 moved = before, turned = after;
    moved[3] = after[3];
    turned[3] = before[3];
    for (const bool isAboutOrigin : {true, false})
        EXPECT_EQ(WithoutRounding(GizmoTool::Move, isAboutOrigin, before, after), moved);
    for (const GizmoTool tool : {GizmoTool::Rotate, GizmoTool::Scale}) {
        EXPECT_EQ(WithoutRounding(tool, true, before, after), turned);
        EXPECT_EQ(WithoutRounding(tool, false, before, after), after);
    }
}

}  // namespace raygraph::editor::gizmo_test

// Tests how the editor's camera moves.
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

TEST(CameraController, ViewsAlongAxesKeepThePivotAndAreLeftByOrbiting) {
    CameraController camera = FromFront();
    camera.Orbit({0.7f, 0.4f});
    for (const glm::vec3 direction :
         {glm::vec3(0, 0, -1), glm::vec3(-1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, -1, 0)}) {
        camera.LookAlong(direction);
        ExpectNear(camera.View().forward, direction);
        ExpectNear(camera.Pivot(), {0, 0, 0});
        EXPECT_NEAR(glm::length(camera.View().eye), 4.0f, 1e-5f);
    }
    ExpectNear(camera.View().up, {0, 0, -1}, 1e-5f);
    ExpectNear(camera.View().right, {1, 0, 0}, 1e-5f);
    camera.Orbit({0.0f, -0.5f});
    EXPECT_LT(camera.View().forward.z, -0.4f) << "it tilts to the front, and does not turn around";
    EXPECT_GT(camera.View().right.x, 0.999f);
}

TEST(CameraController, BothProjectionsShowTheSameHeightAtThePivot) {
    CameraController camera = FromFront();
    camera.ToggleOrthographic();
    EXPECT_EQ(camera.View().projection, scene::Projection::Orthographic);
    EXPECT_NEAR(camera.View().height, 2.0f * 4.0f * std::tan(0.5f * camera.View().yFov), 1e-5f);
    camera.Dolly(1.0f);
    camera.ToggleOrthographic();
    EXPECT_EQ(camera.View().projection, scene::Projection::Perspective);
    ExpectNear(camera.View().eye, {0, 0, 4.0f * 0.85f});
    ExpectNear(camera.Pivot(), {0, 0, 0});
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

// The greatest coordinate of a corner in the picture, whose borders are at 1.
float FarthestCorner(const scene::Bounds& bounds, const scene::CameraView& view) {
    float farthest = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 point(corner & 1 ? bounds.min.x : bounds.max.x,
                              corner & 2 ? bounds.min.y : bounds.max.y,
                              corner & 4 ? bounds.min.z : bounds.max.z);
        const glm::vec3 way = glm::dvec3(point) - view.eye;
        const float depth = glm::dot(way, view.forward);
        EXPECT_GT(depth, view.zNear);
        const float half = view.projection == scene::Projection::Orthographic
                               ? 0.5f * view.height
                               : std::tan(0.5f * view.yFov) * depth;
        farthest = std::max({farthest, std::abs(glm::dot(way, view.up)) / half,
                             std::abs(glm::dot(way, view.right)) / (half * view.aspect)});
    }
    return farthest;
}

TEST(CameraController, FramesABoxAsRenderDoesFromWhereItLooks) {
    scene::Bounds bounds;
    bounds.Extend(glm::vec3(9, 9, 9));
    bounds.Extend(glm::vec3(11, 10, 19));
    const scene::CameraView rendered = scene::ViewOfBounds(bounds, {30.0f, 20.0f}, 1.5f, 0.8f);
    CameraController camera;
    scene::CameraView from = rendered;
    from.eye = {3, -70, 1};
    camera.Set(from, 2.0f);
    camera.Frame(bounds);
    ExpectNear(camera.View().eye, rendered.eye, 1e-4f);
    EXPECT_EQ(camera.View().forward, from.forward);
    EXPECT_NEAR(camera.Distance(), glm::dot(bounds.Center() - glm::vec3(rendered.eye), from.forward), 1e-4f);
    EXPECT_NEAR(FarthestCorner(bounds, camera.View()), scene::kFramedShare, 1e-4f);
    camera.ToggleOrthographic();
    camera.Frame(bounds);
    EXPECT_NEAR(FarthestCorner(bounds, camera.View()), scene::kFramedShare, 1e-4f);
    ExpectNear(camera.Pivot(), {10, 9.5f, 14}, 1e-4f);
}

TEST(CameraController, FlyGoesAlongItsOwnAxes) {
    CameraController camera = FromFront();
    camera.Fly({1, 2, 3});
    ExpectNear(camera.View().eye, {1, 2, 1});
    ExpectNear(camera.Pivot(), {1, 2, -3});
}

}  // namespace raygraph::editor::camera_controller_test

// Tests which actions keys are bound to, and that each has help.
namespace raygraph::editor::actions_test {

TEST(KeyBindings, ShiftTellsApartWhereItCounts) {
    const KeyBindings keys;
    EXPECT_EQ(keys.ActionOf({Key::S, true, false}), Action::SaveScene);
    EXPECT_EQ(keys.ActionOf({Key::S, true, true}), Action::SaveSceneAs);
    EXPECT_EQ(keys.ActionOf({Key::Z, true, true}), Action::Redo);
    EXPECT_EQ(keys.ActionOf({Key::Z, true, false}), Action::Undo);
    EXPECT_EQ(keys.ActionOf({Key::Y, true, true}), Action::Redo) << "Shift is of no account here";
    EXPECT_EQ(keys.ActionOf({Key::R, false, true}), Action::Scale);
    EXPECT_EQ(keys.ActionOf({Key::E, false, false}), Action::Rotate) << "without Ctrl";
    EXPECT_EQ(keys.ActionOf({Key::R, true, false}), std::nullopt);
    EXPECT_EQ(keys.ActionOf({Key::B, false, false}), std::nullopt);
}

TEST(KeyBindings, AKeyAsksForOneActionInEachPreset) {
    for (const KeyPreset preset : Values<KeyPreset>()) {
        const KeyBindings keys(preset);
        EXPECT_TRUE(keys.Changed().empty());
        for (const ActionRow& row : Actions())
            for (const std::optional<KeyPress>& key : keys.Of(row.action)) {
                if (!key) continue;
                EXPECT_EQ(keys.ActionOf(*key), row.action) << Name(preset) << ": " << KeyText(*key);
            }
    }
    KeyBindings keys;
    keys.Bind(Action::Hide, {KeyPress{Key::Y, true}});
    EXPECT_EQ(keys.TextOf(Action::Redo), "Ctrl+Shift+Z") << "the other alternative stays";
    EXPECT_EQ(keys.TextOf(Action::Hide), "Ctrl+Y");
}

TEST(KeyBindings, TextsReadBackAsTheirKeys) {
    for (size_t key = 0; key < kKeyCount; ++key)
        for (const bool isControl : {false, true}) {
            const KeyPress press{static_cast<Key>(key), isControl, key % 2 == 0};
            EXPECT_EQ(KeyFromText(KeyText(press)), press) << KeyText(press);
        }
    EXPECT_EQ(KeyText({Key::Digit7, true}), "Ctrl+7");
}

TEST(Actions, EachIsInAMenuOrHasAKeyAndHelp) {
    for (const ActionRow& row : Actions()) {
        EXPECT_TRUE(row.menu != Menu::None || row.keys[0]) << row.name;
        EXPECT_NE(*row.help, 0) << row.name;
        EXPECT_NE(*row.name, 0);
        EXPECT_TRUE(row.menu == Menu::None || *row.label != 0) << row.name;
    }
}

}  // namespace raygraph::editor::actions_test
