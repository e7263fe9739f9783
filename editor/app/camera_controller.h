// CameraController orbits around a pivot, pans, dollies towards the pivot, or flies. Pure.
#pragma once

#include <glm/glm.hpp>

#include "renderer/scene/model/camera_view.h"

namespace raygraph::editor {

class CameraController {
  public:
    // Starts from a camera; the pivot lies `distance` meters ahead of it.
    void Set(const scene::CameraView& view, float distance);
    const scene::CameraView& View() const { return m_view; }
    glm::dvec3 Pivot() const { return m_view.eye + glm::dvec3(m_distance * m_view.forward); }
    float Distance() const { return m_distance; }

    // Orbits about the pivot by radians to the right and up; +y stays up. It stops short of looking straight
    // along y.
    void Orbit(glm::vec2 angles);
    // Turns the view by radians to the right and up; the eye stays.
    void Turn(glm::vec2 angles);
    // Moves by fractions of the picture's height, so that the point under the cursor follows it.
    void Pan(glm::vec2 shares);
    // Each notch of the wheel takes 15 % off the distance to the pivot. An orthographic view narrows.
    void Dolly(float notches);
    // Moves the eye and the pivot by meters along right, up and forward.
    void Fly(glm::vec3 meters);
    // Looks at the pivot along a direction, from the same distance. +y is up; in a view from straight above,
    // -z is, and from below +z.
    void LookAlong(glm::vec3 direction);
    // Changes between an orthographic and a perspective view of the same height at the pivot.
    void ToggleOrthographic();
    // Frames `bounds` as scene::ViewOfBounds does, keeping the direction of the view. The pivot is as far
    // away as their middle.
    void Frame(const scene::Bounds& bounds);

  private:
    void Face(glm::vec3 forward, glm::vec3 up = {0.0f, 1.0f, 0.0f});
    scene::CameraView m_view;
    float m_distance = 1.0f;
};

}  // namespace raygraph::editor
