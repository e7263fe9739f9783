// The transform gizmo: the positions of its handles in the picture, and the effect of dragging one. Pure: it
// draws nothing. Positions in the picture are points from its upper left corner.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "renderer/scene/camera_view.h"
#include "shaders/shared/choice.h"

namespace raygraph::editor {

#define RAYGRAPH_GIZMO_TOOLS(X, Of) \
    X(Of, Move, 0, "move", "") X(Of, Rotate, 1, "rotate", "") X(Of, Scale, 2, "scale", "")
RAYGRAPH_CHOICE(GizmoTool, RAYGRAPH_GIZMO_TOOLS)
#define RAYGRAPH_GIZMO_SPACES(X, Of) X(Of, World, 0, "world", "") X(Of, Local, 1, "local", "")
RAYGRAPH_CHOICE(GizmoSpace, RAYGRAPH_GIZMO_SPACES)
// The position of the handles, and the center of rotation and scaling: the middle of the node's instances, or
// its origin.
#define RAYGRAPH_GIZMO_PIVOTS(X, Of) X(Of, Middle, 0, "middle", "") X(Of, Origin, 1, "origin", "")
RAYGRAPH_CHOICE(GizmoPivot, RAYGRAPH_GIZMO_PIVOTS)

struct Ray {
    glm::vec3 origin{0.0f};
    glm::vec3 direction{0.0f, 0.0f, -1.0f};  // unit length
};

// From places in a picture to rays of its camera, and back.
class PictureMap {
  public:
    // The aspect ratio is that of the size, which is not empty.
    PictureMap(const scene::CameraView& view, glm::vec2 size);
    Ray RayAt(glm::vec2 place) const;
    // Nullopt behind the eye.
    std::optional<glm::vec2> PlaceOf(const glm::vec3& point) const;
    // Meters that cover this many points at the depth of `point`; 0 behind the eye.
    float MetersAt(const glm::vec3& point, float points) const;
    // From `point` to the eye, unit length.
    glm::vec3 ToEye(const glm::vec3& point) const;
    const scene::CameraView& View() const { return m_view; }

  private:
    scene::CameraView m_view;
    glm::vec2 m_size;
};

// Along the axis from `origin` (unit `axis`), the point nearest to the ray; nullopt if they are parallel.
std::optional<float> NearestAlong(const glm::vec3& origin, const glm::vec3& axis, const Ray& ray);
// The intersection of the ray with the plane; nullopt if it is parallel to it, or leads away.
std::optional<glm::vec3> MeetPlane(const glm::vec3& origin, const glm::vec3& normal, const Ray& ray);

// X, Y, Z: along, about or across an axis. PlaneX: the plane that x is normal to. Whole: in the picture's
// plane, about the line of sight, or all axes alike.
enum class GizmoHandle : uint8_t { X, Y, Z, PlaneX, PlaneY, PlaneZ, Whole };
inline constexpr size_t kGizmoHandleCount = 7;
// 0 to 2 of X to Z and PlaneX to PlaneZ; 3 of Whole.
constexpr int AxisOf(GizmoHandle handle) {
    return handle == GizmoHandle::Whole ? 3 : static_cast<int>(handle) % 3;
}

struct GizmoFrame {
    glm::vec3 origin{0.0f};
    glm::mat3 axes{1.0f};  // unit columns; of a node that shears they need not be perpendicular
    float size = 1.0f;     // meters: how long its arms are
};
// At `pivot`, else at the node's origin. Scaling is always along the node's own axes. Nothing if the node is
// behind the eye or has an axis of length 0.
std::optional<GizmoFrame> FrameOf(const glm::mat4x3& nodeToWorld, GizmoTool tool, GizmoSpace space,
                                  const PictureMap& map, const std::optional<glm::vec3>& pivot = {});

// The shape of a handle for drawing and hit tests: an open line, or an area with a closed outline.
struct GizmoShape {
    GizmoHandle handle = GizmoHandle::X;
    bool isArea = false;
    std::vector<glm::vec2> places;
};
// Those that can be dragged from where the camera is: an arm that points at the eye cannot. In the order in
// which they are drawn.
std::vector<GizmoShape> ShapesOf(const GizmoFrame& frame, GizmoTool tool, const PictureMap& map);
// The handle at a position, the uppermost within `reach` points.
std::optional<GizmoHandle> HandleAt(const std::vector<GizmoShape>& shapes, glm::vec2 place, float reach);

// A handle that is being dragged.
class GizmoDrag {
  public:
    // `ray` is that of the start of the drag.
    GizmoDrag(GizmoTool tool, GizmoHandle handle, const GizmoFrame& frame, const PictureMap& map,
              const Ray& ray);
    GizmoHandle Handle() const { return m_handle; }
    // The world-space transform from the start of the drag to now: to be multiplied from the left with the
    // node's transform at the start. In steps if it snaps: 15 degrees, tenths of the scale, or a tenth to a
    // whole of the arm, rounded to a power of ten. The identity while the ray has no valid intersection.
    glm::mat4 Change(const Ray& ray, bool isSnapping) const;

  private:
    glm::mat4 Moved(const Ray& ray, bool isSnapping) const;
    glm::mat4 Turned(const Ray& ray, bool isSnapping) const;
    glm::mat4 Scaled(const Ray& ray, bool isSnapping) const;
    glm::vec3 Axis() const;
    std::optional<glm::vec3> Grasped(const Ray& ray) const;

    GizmoTool m_tool;
    GizmoHandle m_handle;
    GizmoFrame m_frame;
    glm::vec3 m_toEye, m_right, m_up;
    std::optional<glm::vec3> m_start;    // the point where the drag started, in world space
    std::optional<glm::vec3> m_tangent;  // of a ring that is seen edge-on, where the drag started
};

// The local transform that puts a node where `change` moves it: `parentToWorld` is of its parent (the
// identity for a root). Nothing if the parent has no inverse.
std::optional<glm::mat4x3> LocalAfter(const glm::mat4& change, const glm::mat4x3& parentToWorld,
                                      const glm::mat4x3& local);
// `after` with what the tool leaves alone as it was `before`, without the rounding of LocalAfter: the axes
// where it moves, and the place where it rotates or scales about the node's origin.
glm::mat4x3 WithoutRounding(GizmoTool tool, bool isAboutOrigin, const glm::mat4x3& before,
                            const glm::mat4x3& after);

}  // namespace raygraph::editor
