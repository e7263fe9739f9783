#include "editor/app/gizmo.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace raygraph::editor {

namespace {

constexpr float kArm = 90.0f;         // points
constexpr float kMinSine = 0.12f;     // minimal sine between a handle and the line of sight
constexpr float kEdgeOn = 0.25f;      // below this cosine a ring is turned by its tangent
constexpr float kWholeShare = 0.16f;  // half of the middle square, as a fraction of the arm
constexpr float kMinScale = 0.01f;
constexpr int kRingParts = 64;

// Returns the two other axes.
glm::ivec2 OtherAxes(int axis) {
    return {(axis + 1) % 3, (axis + 2) % 3};
}

float SnapToStep(float value, float step) {
    return std::round(value / step) * step;
}

glm::vec3 Normal(const GizmoFrame& frame, int axis) {
    const glm::ivec2 others = OtherAxes(axis);
    return glm::normalize(glm::cross(frame.axes[others.x], frame.axes[others.y]));
}

float DistanceToSegment(glm::vec2 place, glm::vec2 a, glm::vec2 b) {
    const glm::vec2 along = b - a;
    const float length = glm::dot(along, along);
    const float t = length > 0.0f ? std::clamp(glm::dot(place - a, along) / length, 0.0f, 1.0f) : 0.0f;
    return glm::length(place - (a + t * along));
}

bool IsWithin(const std::vector<glm::vec2>& corners, glm::vec2 place) {
    bool isWithin = false;
    for (size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i, ++i) {
        const glm::vec2 a = corners[i], b = corners[j];
        if ((a.y > place.y) != (b.y > place.y) && place.x < (b.x - a.x) * (place.y - a.y) / (b.y - a.y) + a.x)
            isWithin = !isWithin;
    }
    return isWithin;
}

glm::mat4 About(const glm::vec3& origin, const glm::mat4& change) {
    return glm::translate(glm::mat4(1.0f), origin) * change * glm::translate(glm::mat4(1.0f), -origin);
}

}  // namespace

PictureMap::PictureMap(const scene::CameraView& view, glm::vec2 size) : m_view(view), m_size(size) {
    m_view.aspect = size.x / size.y;
}

Ray PictureMap::RayAt(glm::vec2 place) const {
    const glm::vec2 film(2.0f * place.x / m_size.x - 1.0f, 1.0f - 2.0f * place.y / m_size.y);
    if (m_view.projection == scene::Projection::Orthographic) {
        const float half = 0.5f * m_view.height;
        return {
            glm::vec3(m_view.eye) + film.x * half * m_view.aspect * m_view.right + film.y * half * m_view.up,
            m_view.forward};
    }
    const float half = std::tan(0.5f * m_view.yFov);
    return {m_view.eye, glm::normalize(m_view.forward + film.x * half * m_view.aspect * m_view.right +
                                       film.y * half * m_view.up)};
}

float PictureMap::MetersAt(const glm::vec3& point, float points) const {
    if (m_view.projection == scene::Projection::Orthographic) return m_view.height * points / m_size.y;
    const float depth = glm::dot(glm::vec3(glm::dvec3(point) - m_view.eye), m_view.forward);
    return std::max(2.0f * depth * std::tan(0.5f * m_view.yFov) * points / m_size.y, 0.0f);
}

std::optional<glm::vec2> PictureMap::PlaceOf(const glm::vec3& point) const {
    const glm::vec3 way = glm::dvec3(point) - m_view.eye;
    float half = 0.5f * m_view.height;
    if (m_view.projection == scene::Projection::Perspective) {
        const float depth = glm::dot(way, m_view.forward);
        if (!(depth > 1e-6f)) return std::nullopt;
        half = depth * std::tan(0.5f * m_view.yFov);
    }
    const float x = glm::dot(way, m_view.right) / (half * m_view.aspect), y = glm::dot(way, m_view.up) / half;
    return 0.5f * m_size * glm::vec2(1.0f + x, 1.0f - y);
}

glm::vec3 PictureMap::ToEye(const glm::vec3& point) const {
    if (m_view.projection == scene::Projection::Orthographic) return -m_view.forward;
    return glm::normalize(m_view.eye - glm::dvec3(point));
}

std::optional<float> ClosestPointOnAxis(const glm::vec3& origin, const glm::vec3& axis, const Ray& ray) {
    const glm::vec3 apart = origin - ray.origin;
    const float cosine = glm::dot(axis, ray.direction), denominator = 1.0f - cosine * cosine;
    if (denominator < 1e-5f) return std::nullopt;
    return (cosine * glm::dot(ray.direction, apart) - glm::dot(axis, apart)) / denominator;
}

std::optional<glm::vec3> IntersectPlane(const glm::vec3& origin, const glm::vec3& normal, const Ray& ray) {
    const float slope = glm::dot(normal, ray.direction);
    if (std::abs(slope) < 1e-4f) return std::nullopt;
    const float t = glm::dot(normal, origin - ray.origin) / slope;
    if (!(t > 0.0f)) return std::nullopt;
    return ray.origin + t * ray.direction;
}

std::optional<GizmoFrame> FrameOf(const glm::mat4x3& nodeToWorld, GizmoTool tool, GizmoSpace space,
                                  const PictureMap& map, const std::optional<glm::vec3>& pivot) {
    GizmoFrame frame{.origin = pivot.value_or(nodeToWorld[3])};
    frame.size = map.MetersAt(frame.origin, kArm);
    if (!(frame.size > 0.0f)) return std::nullopt;
    if (space == GizmoSpace::World && tool != GizmoTool::Scale) return frame;
    for (int i = 0; i < 3; ++i) {
        // A flat node gets as its third axis the normal of its plane
        const glm::vec3 axis = nodeToWorld[i] == glm::vec3(0.0f)
                                   ? glm::cross(nodeToWorld[(i + 1) % 3], nodeToWorld[(i + 2) % 3])
                                   : nodeToWorld[i];
        const float length = glm::length(axis);
        if (!(length > 0.0f)) return std::nullopt;
        frame.axes[i] = axis / length;
    }
    if (std::abs(glm::determinant(frame.axes)) < 1e-3f) return std::nullopt;
    return frame;
}

namespace {

// Projects the points; nothing if one is behind the eye.
std::optional<GizmoShape> Projected(GizmoHandle handle, bool isArea, const std::vector<glm::vec3>& points,
                                    const PictureMap& map) {
    GizmoShape shape{.handle = handle, .isArea = isArea, .places = {}};
    for (const glm::vec3& point : points) {
        const std::optional<glm::vec2> place = map.PlaceOf(point);
        if (!place) return std::nullopt;
        shape.places.push_back(*place);
    }
    return shape;
}

// Returns the half of a circle that faces the eye, or all of it if the circle is seen from its front.
std::vector<glm::vec3> RingPoints(const GizmoFrame& frame, const glm::vec3& normal, float radius,
                                  const glm::vec3& toEye) {
    // The half of the circle begins here
    glm::vec3 across = glm::cross(normal, toEye);
    const bool isWhole = glm::length(across) < 0.02f;
    if (isWhole) across = std::abs(normal.x) < 0.9f ? glm::cross(normal, {1, 0, 0}) : glm::vec3(0, 1, 0);
    across = glm::normalize(across - glm::dot(across, normal) * normal);
    const glm::vec3 front = glm::cross(across, normal);  // towards the eye
    const float sign = glm::dot(front, toEye) < 0.0f ? -1.0f : 1.0f;
    std::vector<glm::vec3> points;
    const float span = isWhole ? glm::two_pi<float>() : glm::pi<float>();
    for (int i = 0; i <= kRingParts; ++i) {
        const float angle = span * static_cast<float>(i) / kRingParts;
        points.push_back(frame.origin + radius * (std::cos(angle) * across + sign * std::sin(angle) * front));
    }
    return points;
}

}  // namespace

std::vector<GizmoShape> ShapesOf(const GizmoFrame& frame, GizmoTool tool, const PictureMap& map) {
    std::vector<GizmoShape> shapes;
    const auto add = [&](GizmoHandle handle, bool isArea, const std::vector<glm::vec3>& points) {
        if (std::optional<GizmoShape> shape = Projected(handle, isArea, points, map))
            shapes.push_back(std::move(*shape));
    };
    const glm::vec3 o = frame.origin, toEye = map.ToEye(o);
    const glm::vec3 right = map.View().right * frame.size, up = map.View().up * frame.size;
    if (tool == GizmoTool::Rotate) {
        add(GizmoHandle::Whole, false, RingPoints(frame, toEye, 1.15f * frame.size, toEye));
        for (int i = 0; i < 3; ++i)
            add(static_cast<GizmoHandle>(i), false, RingPoints(frame, frame.axes[i], frame.size, toEye));
        return shapes;
    }
    for (int i = 0; i < 3; ++i) {
        const glm::ivec2 others = OtherAxes(i);
        if (std::abs(glm::dot(Normal(frame, i), toEye)) < kMinSine) continue;
        const glm::vec3 a = frame.axes[others.x] * frame.size, b = frame.axes[others.y] * frame.size;
        add(static_cast<GizmoHandle>(3 + i), true,
            {o + 0.3f * a + 0.3f * b, o + 0.55f * a + 0.3f * b, o + 0.55f * a + 0.55f * b,
             o + 0.3f * a + 0.55f * b});
    }
    for (int i = 0; i < 3; ++i)
        if (glm::length(glm::cross(frame.axes[i], toEye)) >= kMinSine)
            add(static_cast<GizmoHandle>(i), false,
                {o + 0.22f * frame.size * frame.axes[i], o + frame.size * frame.axes[i]});
    const float w = kWholeShare;
    add(GizmoHandle::Whole, true,
        {o - w * right - w * up, o + w * right - w * up, o + w * right + w * up, o - w * right + w * up});
    return shapes;
}

std::optional<GizmoHandle> HandleAt(const std::vector<GizmoShape>& shapes, glm::vec2 place, float reach) {
    for (size_t i = shapes.size(); i-- > 0;) {
        const GizmoShape& shape = shapes[i];
        if (shape.isArea && IsWithin(shape.places, place)) return shape.handle;
        for (size_t k = 0; k + 1 < shape.places.size() && !shape.isArea; ++k)
            if (DistanceToSegment(place, shape.places[k], shape.places[k + 1]) <= reach) return shape.handle;
    }
    return std::nullopt;
}

GizmoDrag::GizmoDrag(GizmoTool tool, GizmoHandle handle, const GizmoFrame& frame, const PictureMap& map,
                     const Ray& ray)
    : m_tool(tool),
      m_handle(handle),
      m_frame(frame),
      m_toEye(map.ToEye(frame.origin)),
      m_right(map.View().right),
      m_up(map.View().up) {
    const bool isRing = tool == GizmoTool::Rotate;
    if (isRing && std::abs(glm::dot(Axis(), ray.direction)) < kEdgeOn) {
        // The point under the cursor lies on the half of the ring that faces the eye
        const glm::vec3 across = glm::normalize(glm::cross(Axis(), m_toEye));
        const glm::vec3 front = glm::normalize(glm::cross(across, Axis()));
        const float along = ClosestPointOnAxis(frame.origin, across, ray).value_or(0.0f) / frame.size;
        const float cosine = std::clamp(along, -1.0f, 1.0f);
        const glm::vec3 arm = cosine * across + std::sqrt(1.0f - cosine * cosine) * front;
        m_tangent = glm::cross(Axis(), arm);
        m_start = frame.origin + frame.size * arm;
        if (const std::optional<float> at = ClosestPointOnAxis(*m_start, *m_tangent, ray))
            m_start = *m_start + *at * *m_tangent;
        return;
    }
    m_start = GrabPoint(ray);
}

glm::vec3 GizmoDrag::Axis() const {
    const int axis = AxisOf(m_handle);
    if (axis == 3) return m_toEye;
    if (m_tool != GizmoTool::Rotate && m_handle >= GizmoHandle::PlaneX) return Normal(m_frame, axis);
    return m_frame.axes[axis];
}

// Returns the intersection of the ray with the handle's plane, or the point of the handle's line nearest to
// it.
std::optional<glm::vec3> GizmoDrag::GrabPoint(const Ray& ray) const {
    if (m_tool == GizmoTool::Rotate || m_handle >= GizmoHandle::PlaneX)
        return IntersectPlane(m_frame.origin, Axis(), ray);
    const std::optional<float> along = ClosestPointOnAxis(m_frame.origin, Axis(), ray);
    if (!along) return std::nullopt;
    return m_frame.origin + *along * Axis();
}

glm::mat4 GizmoDrag::Moved(const Ray& ray, bool isSnapping) const {
    const std::optional<glm::vec3> now = GrabPoint(ray);
    if (!now) return glm::mat4(1.0f);
    glm::vec3 way = *now - *m_start;
    if (isSnapping) {
        const float step = std::pow(10.0f, std::floor(std::log10(m_frame.size)));
        if (m_handle < GizmoHandle::PlaneX) {
            way = SnapToStep(glm::dot(way, Axis()), step) * Axis();
        } else {
            const bool isWhole = m_handle == GizmoHandle::Whole;
            const glm::ivec2 others = OtherAxes(AxisOf(m_handle) % 3);
            const glm::vec3 a = isWhole ? m_right : m_frame.axes[others.x];
            // This axis is perpendicular to `a` within the plane, even if the node shears
            const glm::vec3 b = isWhole ? m_up : glm::normalize(glm::cross(Axis(), a));
            way = SnapToStep(glm::dot(way, a), step) * a + SnapToStep(glm::dot(way, b), step) * b;
        }
    }
    return glm::translate(glm::mat4(1.0f), way);
}

glm::mat4 GizmoDrag::Rotated(const Ray& ray, bool isSnapping) const {
    const glm::vec3 axis = Axis();
    float angle = 0.0f;
    if (m_tangent) {
        const std::optional<float> along = ClosestPointOnAxis(*m_start, *m_tangent, ray);
        if (!along) return glm::mat4(1.0f);
        angle = *along / m_frame.size;
    } else {
        const std::optional<glm::vec3> now = GrabPoint(ray);
        if (!now) return glm::mat4(1.0f);
        const glm::vec3 from = *m_start - m_frame.origin, to = *now - m_frame.origin;
        angle = std::atan2(glm::dot(axis, glm::cross(from, to)), glm::dot(from, to));
    }
    if (isSnapping) angle = SnapToStep(angle, glm::radians(15.0f));
    return About(m_frame.origin, glm::rotate(glm::mat4(1.0f), angle, axis));
}

glm::mat4 GizmoDrag::Scaled(const Ray& ray, bool isSnapping) const {
    const std::optional<glm::vec3> now = GrabPoint(ray);
    if (!now) return glm::mat4(1.0f);
    const glm::vec3 from = *m_start - m_frame.origin, to = *now - m_frame.origin;
    const int axis = AxisOf(m_handle);
    float factor = 1.0f;
    if (m_handle == GizmoHandle::Whole) {
        // The center square has no size to compare with, so movement to the right and up scales exponentially
        factor = std::exp(glm::dot(to - from, m_right + m_up) / m_frame.size);
    } else {
        const float before = glm::dot(from, from);
        if (!(before > 0.0f)) return glm::mat4(1.0f);
        factor = glm::dot(to, from) / before;
    }
    if (isSnapping) factor = SnapToStep(factor, 0.1f);
    factor = std::max(factor, kMinScale);
    glm::vec3 factors(factor);
    if (m_handle < GizmoHandle::PlaneX) (factors = glm::vec3(1.0f))[axis] = factor;
    if (m_handle >= GizmoHandle::PlaneX && m_handle < GizmoHandle::Whole) factors[axis] = 1.0f;
    const glm::mat3 axes = m_frame.axes;
    glm::mat3 stretched = axes;
    for (int i = 0; i < 3; ++i) stretched[i] *= factors[i];
    return About(m_frame.origin, glm::mat4(stretched * glm::inverse(axes)));
}

glm::mat4 GizmoDrag::Change(const Ray& ray, bool isSnapping) const {
    if (!m_start) return glm::mat4(1.0f);
    switch (m_tool) {
        case GizmoTool::Move:
            return Moved(ray, isSnapping);
        case GizmoTool::Rotate:
            return Rotated(ray, isSnapping);
        case GizmoTool::Scale:
            return Scaled(ray, isSnapping);
    }
    return glm::mat4(1.0f);
}

std::optional<glm::mat4x3> ApplyToLocal(const glm::mat4& change, const glm::mat4x3& parentToWorld,
                                        const glm::mat4x3& local) {
    const glm::mat4 parent(parentToWorld);
    if (!std::isnormal(glm::determinant(glm::mat3(parentToWorld)))) return std::nullopt;
    return glm::mat4x3(glm::inverse(parent) * change * parent * glm::mat4(local));
}

glm::mat4x3 WithoutRounding(GizmoTool tool, bool isAboutOrigin, const glm::mat4x3& before,
                            const glm::mat4x3& after) {
    if (tool == GizmoTool::Move) return {before[0], before[1], before[2], after[3]};
    return {after[0], after[1], after[2], isAboutOrigin ? before[3] : after[3]};
}

}  // namespace raygraph::editor
