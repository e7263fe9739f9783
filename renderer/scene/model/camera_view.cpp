#include "renderer/scene/model/camera_view.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::scene {
namespace {

bool HasDirection(const glm::vec3& v) {
    const float length = glm::length(v);
    return length > 1e-20f && std::isfinite(length);
}

// Sets the frame from a unit `forward` and a rough up.
void SetFrame(CameraView& view, const glm::vec3& forward, const glm::vec3& up) {
    view.forward = forward;
    glm::vec3 right = HasDirection(up) ? glm::cross(forward, glm::normalize(up)) : glm::vec3(0.0f);
    // Where forward and up are parallel within rounding, +y stands for up; if that is parallel, too, -z does,
    // which is "north" when looking straight down.
    if (glm::length(right) < 1e-4f) right = glm::cross(forward, glm::vec3(0, 1, 0));
    if (glm::length(right) < 1e-4f) right = glm::cross(forward, glm::vec3(0, 0, -1));
    view.right = glm::normalize(right);
    view.up = glm::cross(view.right, forward);
}

// Returns the numbers of `text`, or nothing if it holds anything else.
std::optional<std::vector<double>> Numbers(std::string_view text) {
    const auto isSeparator = [](char c) { return c == ' ' || c == ',' || c == '\t'; };
    std::vector<double> numbers;
    while (true) {
        while (!text.empty() && isSeparator(text.front())) text.remove_prefix(1);
        if (text.empty()) return numbers;
        if (text.front() == '+' && text.size() > 1 && text[1] != '-') text.remove_prefix(1);
        double number = 0.0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (error != std::errc() || !std::isfinite(static_cast<float>(number))) return std::nullopt;
        text.remove_prefix(static_cast<size_t>(end - text.data()));
        if (!text.empty() && !isSeparator(text.front())) return std::nullopt;
        numbers.push_back(number);
    }
}

// `text` without the m of a height that ends it; true if there was one.
bool TakeMeters(std::string_view& text) {
    while (text.ends_with(' ')) text.remove_suffix(1);
    if (text.size() < 2 || text.back() != 'm' ||
        !(std::isdigit(text[text.size() - 2]) || text[text.size() - 2] == '.'))
        return false;
    text.remove_suffix(1);
    return true;
}

constexpr std::string_view kOrbit = "orbit ", kTurntable = "turntable ";

// A camera frames a box, or the upright cylinder that it sweeps when it turns about its middle.
struct FramedShape {
    glm::dvec3 center{0.0};
    glm::dvec3 half{0.5};  // half of the extent along x, y and z
    bool isCylinder = false;

    // Returns the greatest dot product of `v` with a point of the shape, relative to its center.
    double Support(const glm::dvec3& v) const {
        if (isCylinder) return half.y * std::abs(v.y) + std::hypot(half.x, half.z) * std::hypot(v.x, v.z);
        return glm::dot(half, glm::abs(v));
    }
};

FramedShape ShapeOf(const Bounds& bounds, bool isCylinder) {
    FramedShape shape{.isCylinder = isCylinder};
    if (bounds.IsEmpty()) return shape;
    shape.center = 0.5 * (glm::dvec3(bounds.min) + glm::dvec3(bounds.max));
    shape.half = 0.5 * (glm::dvec3(bounds.max) - glm::dvec3(bounds.min));
    // A point still needs some distance
    const double least = 1e-4 * (1.0 + glm::length(shape.center));
    if (glm::length(shape.half) < least) shape.half = glm::dvec3(least / std::sqrt(3.0));
    return shape;
}

// Moves a view so that it sees all of the shape. Where right, up and forward are x, y and z, a point is
// within the left and right borders at slope s if x - ex <= s (z - ez) and ex - x <= s (z - ez). For all
// points of the shape that is ex - s ez >= A and -ex - s ez >= B, with the supports A of right - s forward
// and B of -right - s forward; so the eye can be no nearer than ez = -(A + B) / 2s, and ex = (A - B) / 2
// leaves as much on the left as on the right. Likewise for up. An orthographic view gets the height that
// fits, from the distance where its field of view would have it.
void Frame(CameraView& view, const FramedShape& shape) {
    const glm::dvec3 right(view.right), up(view.up), forward(view.forward);
    const double slope = std::tan(0.5 * double{view.yFov}), aspect = view.aspect;
    const double slopeY = kFramedShare * slope, slopeX = slopeY * aspect;
    double nearest = 0.0, x = 0.0, y = 0.0;
    if (view.projection == Projection::Orthographic) {
        const double half = std::max(shape.Support(up), shape.Support(right) / aspect) / kFramedShare;
        view.height = static_cast<float>(2.0 * half);
        nearest = half / slope;
    } else {
        const auto fit = [&](const glm::dvec3& across, double border) {
            const double above = shape.Support(across - border * forward),
                         below = shape.Support(-across - border * forward);
            nearest = std::max(nearest, (above + below) / (2.0 * border));
            return 0.5 * (above - below);
        };
        x = fit(right, slopeX);
        y = fit(up, slopeY);
    }
    // A line that points at the camera projects to a point, which it must not touch
    const double depth = shape.Support(forward);
    const double distance = std::max(nearest, depth + 1e-6 * glm::length(shape.half));
    view.eye = shape.center + x * right + y * up - distance * forward;
    view.zNear = static_cast<float>(std::min(1e-3 * distance, 0.5 * (distance - depth)));
}

// Returns a perspective camera in the direction `toEye` from the shape.
CameraView Framed(const FramedShape& shape, const glm::dvec3& toEye, const glm::dvec3& up, float aspect,
                  float yFov) {
    CameraView view = CameraView::LookAt(toEye, glm::dvec3(0.0), up);
    view.yFov = yFov;
    view.aspect = aspect;
    Frame(view, shape);
    return view;
}

// A box is a board if it is thinner than this share of its height and its width.
constexpr float kBoard = 0.15f;
// One that lies is taken for a floor, with something on it, unless it is thinner than this.
constexpr float kSheet = 0.01f;

glm::dvec3 DefaultDirection(const Bounds& bounds) {
    if (!bounds.IsEmpty()) {
        const glm::vec3 size = bounds.max - bounds.min;
        if (size.z < kBoard * std::min(size.x, size.y)) return {0.0, 0.0, 1.0};
        if (size.x < kBoard * std::min(size.y, size.z)) return {1.0, 0.0, 0.0};
        if (size.y < kSheet * std::min(size.x, size.z)) return {0.0, 1.0, 0.0};
    }
    return glm::normalize(glm::dvec3(0.5, 0.35, 1.0));
}

[[noreturn]] void FailChoice(const SceneData& scene, std::string_view choice) {
    std::string cameras;
    for (size_t i = 0; i < scene.cameras.size() && i < 8; ++i)
        cameras += Text("{}{} {}", i ? ", " : "", i, Quoted(scene.cameras[i].name, 40));
    if (scene.cameras.size() > 8) cameras += ", ...";
    throw MakeError(ErrorKind::Usage, "there is no camera {}; the scene has {}", Quoted(choice),
                    cameras.empty() ? "none" : cameras);
}

}  // namespace

CameraView CameraView::LookAt(const glm::dvec3& eye, const glm::dvec3& target, const glm::vec3& up) {
    CameraView view;
    view.eye = eye;
    const glm::vec3 direction = target - eye;
    SetFrame(view, HasDirection(direction) ? glm::normalize(direction) : glm::vec3(0, 0, -1), up);
    return view;
}

CameraView ViewOf(const Camera& camera, float aspect) {
    CameraView view;
    view.eye = PlacedTransform{camera.cameraToWorld, camera.translationResidual}.Place();
    const glm::vec3 back = camera.cameraToWorld[2];
    SetFrame(view, HasDirection(back) ? -glm::normalize(back) : glm::vec3(0, 0, -1), camera.cameraToWorld[1]);
    view.projection = camera.projection;
    view.yFov = camera.yFov;
    view.height = 2.0f * camera.yMag;
    view.aspect = aspect;
    if (camera.zNear > 0.0f) view.zNear = camera.zNear;
    view.zFar = camera.zFar;
    return view;
}

CameraView ViewOfBounds(const Bounds& bounds, float aspect, float yFov) {
    return Framed(ShapeOf(bounds, false), DefaultDirection(bounds), {0.0, 1.0, 0.0}, aspect, yFov);
}

CameraView ViewOfBounds(const Bounds& bounds, const Orbit& orbit, float aspect, float yFov) {
    const double azimuth = glm::radians(double{orbit.azimuth}),
                 elevation = glm::radians(double{orbit.elevation});
    const glm::dvec3 outward(std::sin(azimuth), 0.0, std::cos(azimuth)), upward(0.0, 1.0, 0.0);
    const glm::dvec3 toEye = std::cos(elevation) * outward + std::sin(elevation) * upward,
                     up = std::cos(elevation) * upward - std::sin(elevation) * outward;
    return Framed(ShapeOf(bounds, orbit.isTurntable), toEye, up, aspect, yFov);
}

CameraView ViewOfBounds(const Bounds& bounds, const CameraView& from) {
    CameraView view = from;
    view.zFar = 0.0f;
    Frame(view, ShapeOf(bounds, false));
    return view;
}

std::optional<Orbit> OrbitFromText(std::string_view text) {
    for (const std::string_view kind : {kOrbit, kTurntable}) {
        if (!text.starts_with(kind)) continue;
        const auto numbers = Numbers(text.substr(kind.size()));
        if (!numbers || numbers->size() != 2 || std::abs(numbers->back()) > 90.0) return std::nullopt;
        return Orbit{static_cast<float>(numbers->front()), static_cast<float>(numbers->back()),
                     kind == kTurntable};
    }
    return std::nullopt;
}

std::string ToText(const Orbit& orbit) {
    return Text("{}{} {}", orbit.isTurntable ? kTurntable : kOrbit, orbit.azimuth, orbit.elevation);
}

CameraView ViewFromText(std::string_view text, float aspect) {
    const auto fail = [&](const char* why) -> CameraView {
        throw MakeError(ErrorKind::Usage, "camera {}: {}", Quoted(text), why);
    };
    std::string_view digits = text;
    const bool isHeight = TakeMeters(digits);
    const auto numbers = Numbers(digits);
    if (!numbers) return fail("must be numbers: eye target up fov");
    const std::vector<double>& n = *numbers;
    if (n.size() != 6 && n.size() != 7 && n.size() != 9 && n.size() != 10)
        return fail("must have 10 numbers (eye target up fov), or 9, 7 or 6 without fov or up");
    const glm::dvec3 eye(n[0], n[1], n[2]);
    const glm::dvec3 target(n[3], n[4], n[5]);
    const glm::vec3 up = n.size() >= 9 ? glm::vec3(n[6], n[7], n[8]) : glm::vec3(0, 1, 0);
    const bool hasFov = n.size() == 7 || n.size() == 10;
    if (isHeight && !hasFov) return fail("a height in meters has the place of the fov");
    const auto last = static_cast<float>(n.back());
    if (isHeight && !(last > 0.0f)) return fail("the height must be above 0");
    const float fovDegrees = hasFov && !isHeight ? last : 40.0f;
    if (!HasDirection(target - eye)) return fail("eye and target must differ");
    if (!(fovDegrees > 0.0f && fovDegrees < 180.0f)) return fail("fov must be between 0 and 180 degrees");
    CameraView view = CameraView::LookAt(eye, target, up);
    view.yFov = glm::radians(fovDegrees);
    if (isHeight) {
        view.projection = Projection::Orthographic;
        view.height = last;
    }
    view.aspect = aspect;
    return view;
}

bool IsViewText(std::string_view text) {
    TakeMeters(text);
    const auto numbers = Numbers(text);
    return numbers && numbers->size() > 1;
}

std::optional<uint32_t> FindCamera(const SceneData& scene, std::string_view choice) {
    for (size_t i = 0; i < scene.cameras.size(); ++i)
        if (scene.cameras[i].name == choice) return static_cast<uint32_t>(i);
    uint32_t index = 0;
    const auto [end, error] = std::from_chars(choice.data(), choice.data() + choice.size(), index);
    const bool isIndex = error == std::errc() && end == choice.data() + choice.size();
    if (isIndex && index < scene.cameras.size()) return index;
    return std::nullopt;
}

CameraView ChooseView(const SceneData& scene, std::string_view choice, float aspect) {
    if (choice.empty())
        return scene.cameras.empty() ? ViewOfBounds(scene.bounds, aspect) : ViewOf(scene.cameras[0], aspect);
    if (const std::optional<uint32_t> camera = FindCamera(scene, choice))
        return ViewOf(scene.cameras[*camera], aspect);
    if (const std::optional<Orbit> orbit = OrbitFromText(choice))
        return ViewOfBounds(scene.bounds, *orbit, aspect);
    if (IsViewText(choice)) return ViewFromText(choice, aspect);
    FailChoice(scene, choice);
}

}  // namespace raygraph::scene
