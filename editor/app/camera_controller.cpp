#include "editor/app/camera_controller.h"

#include <algorithm>
#include <cmath>

namespace raygraph::editor {

namespace {

constexpr float kSteepest = 1.553f;  // radians above or below the horizon: 89 degrees
constexpr float kNearest = 1e-3f;    // meters from the pivot

// Returns the view's direction turned by an angle about +y, and tilted up; in radians.
glm::vec3 Rotated(const scene::CameraView& view, glm::vec2 angles) {
    const glm::vec3& forward = view.forward;
    // A view from straight above or below heads where the picture's top is, or its bottom
    const glm::vec3 ahead =
        std::abs(forward.y) < 0.9999f ? forward : -std::copysign(1.0f, forward.y) * view.up;
    const float heading = std::atan2(ahead.x, -ahead.z) + angles.x;
    const float tilt =
        std::clamp(std::asin(std::clamp(forward.y, -1.0f, 1.0f)) + angles.y, -kSteepest, kSteepest);
    return {std::sin(heading) * std::cos(tilt), std::sin(tilt), -std::cos(heading) * std::cos(tilt)};
}

}  // namespace

void CameraController::Set(const scene::CameraView& view, float distance) {
    m_view = view;
    m_distance = std::max(distance, kNearest);
}

void CameraController::Face(glm::vec3 forward, glm::vec3 up) {
    const scene::CameraView turned =
        scene::CameraView::LookAt(m_view.eye, m_view.eye + glm::dvec3(forward), up);
    m_view.forward = turned.forward;
    m_view.up = turned.up;
    m_view.right = turned.right;
}

void CameraController::Orbit(glm::vec2 angles) {
    const glm::dvec3 pivot = Pivot();
    // The camera goes to the right about the pivot, so that the scene turns to the left
    const glm::vec3 forward = Rotated(m_view, {-angles.x, -angles.y});
    m_view.eye = pivot - glm::dvec3(m_distance * forward);
    Face(forward);
}

void CameraController::Turn(glm::vec2 angles) {
    Face(Rotated(m_view, angles));
}

void CameraController::Pan(glm::vec2 shares) {
    const float height = m_view.projection == scene::Projection::Orthographic
                             ? m_view.height
                             : 2.0f * m_distance * std::tan(0.5f * m_view.yFov);
    m_view.eye += height * (-shares.x * m_view.right - shares.y * m_view.up);
}

void CameraController::Dolly(float notches) {
    const float factor = std::pow(0.85f, notches);
    if (m_view.projection == scene::Projection::Orthographic) {
        m_view.height *= factor;
        return;
    }
    const glm::dvec3 pivot = Pivot();
    m_distance = std::max(m_distance * factor, kNearest);
    m_view.eye = pivot - glm::dvec3(m_distance * m_view.forward);
}

void CameraController::Fly(glm::vec3 meters) {
    m_view.eye += meters.x * m_view.right + meters.y * m_view.up + meters.z * m_view.forward;
}

void CameraController::LookAlong(glm::vec3 direction) {
    const glm::dvec3 pivot = Pivot();
    m_view.eye = pivot - glm::dvec3(m_distance * direction);
    Face(direction, direction.x == 0.0f && direction.z == 0.0f ? glm::vec3(0.0f, 0.0f, direction.y)
                                                               : glm::vec3(0.0f, 1.0f, 0.0f));
}

void CameraController::ToggleOrthographic() {
    const float slope = 2.0f * std::tan(0.5f * m_view.yFov);
    if (m_view.projection == scene::Projection::Perspective) {
        m_view.projection = scene::Projection::Orthographic;
        m_view.height = slope * m_distance;
        return;
    }
    const glm::dvec3 pivot = Pivot();
    m_view.projection = scene::Projection::Perspective;
    m_distance = std::max(m_view.height / slope, kNearest);
    m_view.eye = pivot - glm::dvec3(m_distance * m_view.forward);
}

void CameraController::Frame(const scene::Bounds& bounds) {
    m_view = scene::ViewOfBounds(bounds, m_view);
    const glm::dvec3 center = bounds.IsEmpty() ? glm::dvec3(0.0) : glm::dvec3(bounds.Center());
    m_distance =
        std::max(static_cast<float>(glm::dot(center - m_view.eye, glm::dvec3(m_view.forward))), kNearest);
}

}  // namespace raygraph::editor
