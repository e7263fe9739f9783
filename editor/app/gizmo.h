// The transform gizmo: the positions of its handles in the picture, and the effect of dragging one. Pure: it
// draws nothing. Positions in the picture are points from its upper left corner.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "renderer/scene/model/camera_view.h"
#include "shaders/shared/choice.h"

namespace raygraph::editor {

#define RAYGRAPH_GIZMO_TOOLS(X, Of) \
    X(Of, Move, 0, "move", "") X(Of, Rotate, 1, "rotate", "") X(Of, Scale, 2, "scale", "")
RAYGRAPH_CHOICE(GizmoTool, RAYGRAPH_GIZMO_TOOLS)
#define RAYGRAPH_GIZMO_SPACES(X, Of) X(Of, World, 0, "world", "") X(Of, Local, 1, "local", "")
RAYGRAPH_CHOICE(GizmoSpace, RAYGRAPH_GIZMO_SPACES)
// The pivot is the position of the handles, and the center of rotation and scaling: the middle of the node's
// instances, or its origin.
#define RAYGRAPH_GIZMO_PIVOTS(X, Of) X(Of, Middle, 0, "middle", "") X(Of, Origin, 1, "origin", "")
RAYGRAPH_CHOICE(GizmoPivot, RAYGRAPH_GIZMO_PIVOTS)

struct Ray {
    glm::vec3 origin{0.0f};
    glm::vec3 direction{0.0f, 0.0f, -1.0f};  // unit length
};

// Maps positions in a picture to rays of its camera, and back.
class PictureMap {
  public:
    // `size` gives the aspect ratio, and is not empty.
    PictureMap(const scene::CameraView& view, glm::vec2 size);
    Ray RayAt(glm::vec2 place) const;
    // Projects a point; nullopt if it is behind the eye.
    std::optional<glm::vec2> PlaceOf(const glm::vec3& point) const;
    // Returns the meters that cover this many points at the depth of `point`; 0 behind the eye.
    float MetersAt(const glm::vec3& point, float points) const;
    // Returns the direction from `point` to the eye, unit length.
    glm::vec3 ToEye(const glm::vec3& point) const;
    const scene::CameraView& View() const { return m_view; }

  private:
    scene::CameraView m_view;
    glm::vec2 m_size;
};

// Returns the distance from `origin` along the unit `axis` to its point nearest to the ray; nullopt if they
// are parallel.
std::optional<float> ClosestPointOnAxis(const glm::vec3& origin, const glm::vec3& axis, const Ray& ray);
// Returns the intersection of the ray with the plane; nullopt if they are parallel, or the ray leads away.
std::optional<glm::vec3> IntersectPlane(const glm::vec3& origin, const glm::vec3& normal, const Ray& ray);

// X, Y and Z act along, about or across an axis; PlaneX acts in the plane with normal x. Whole acts in the
// plane of the picture, about the line of sight, or on all axes alike.
enum class GizmoHandle : uint8_t { X, Y, Z, PlaneX, PlaneY, PlaneZ, Whole };
inline constexpr size_t kGizmoHandleCount = 7;
// Returns 0 to 2 for X to Z and for PlaneX to PlaneZ, and 3 for Whole.
constexpr int AxisOf(GizmoHandle handle) {
    return handle == GizmoHandle::Whole ? 3 : static_cast<int>(handle) % 3;
}

struct GizmoFrame {
    glm::vec3 origin{0.0f};
    glm::mat3 axes{1.0f};  // unit columns; not orthogonal if the node shears
    float size = 1.0f;     // length of the arms, in meters
};
// Returns the frame at `pivot`, else at the node's origin. Scaling is always along the node's own axes.
// Nothing if the node is behind the eye or has an axis of length 0.
std::optional<GizmoFrame> FrameOf(const glm::mat4x3& nodeToWorld, GizmoTool tool, GizmoSpace space,
                                  const PictureMap& map, const std::optional<glm::vec3>& pivot = {});

// Describes a handle for drawing and hit tests: an open line, or an area with a closed outline.
struct GizmoShape {
    GizmoHandle handle = GizmoHandle::X;
    bool isArea = false;
    std::vector<glm::vec2> places;
};
// Returns the handles that can be dragged from the camera's position (an arm that points at the eye cannot),
// in the order in which they are drawn.
std::vector<GizmoShape> ShapesOf(const GizmoFrame& frame, GizmoTool tool, const PictureMap& map);
// Returns the uppermost handle within `reach` points of a position.
std::optional<GizmoHandle> HandleAt(const std::vector<GizmoShape>& shapes, glm::vec2 place, float reach);

// Drags a handle.
class GizmoDrag {
  public:
    // `ray` is the ray under the cursor at the start of the drag.
    GizmoDrag(GizmoTool tool, GizmoHandle handle, const GizmoFrame& frame, const PictureMap& map,
              const Ray& ray);
    GizmoHandle Handle() const { return m_handle; }
    // Returns the world-space transform since the start of the drag, to be multiplied from the left with the
    // node's transform at the start. Snapping steps are 15 degrees, tenths of the scale, or a tenth to a
    // whole of the arm, rounded to a power of ten. It is the identity while the ray has no valid
    // intersection.
    glm::mat4 Change(const Ray& ray, bool isSnapping) const;

  private:
    glm::mat4 Moved(const Ray& ray, bool isSnapping) const;
    glm::mat4 Rotated(const Ray& ray, bool isSnapping) const;
    glm::mat4 Scaled(const Ray& ray, bool isSnapping) const;
    glm::vec3 Axis() const;
    std::optional<glm::vec3> GrabPoint(const Ray& ray) const;

    GizmoTool m_tool;
    GizmoHandle m_handle;
    GizmoFrame m_frame;
    glm::vec3 m_toEye, m_right, m_up;
    std::optional<glm::vec3> m_start;    // world-space point where the drag started
    std::optional<glm::vec3> m_tangent;  // tangent of an edge-on ring at m_start
};

// Returns the local transform of a node that `change` moves in the world. `parentToWorld` is the identity for
// a root. Nothing if the parent has no inverse.
std::optional<glm::mat4x3> ApplyToLocal(const glm::mat4& change, const glm::mat4x3& parentToWorld,
                                        const glm::mat4x3& local);
// Returns `after` without the rounding of ApplyToLocal in what the tool does not change, which is taken from
// `before`: the axes for Move, the translation for rotating or scaling about the node's origin.
glm::mat4x3 WithoutRounding(GizmoTool tool, bool isAboutOrigin, const glm::mat4x3& before,
                            const glm::mat4x3& after);

}  // namespace raygraph::editor
