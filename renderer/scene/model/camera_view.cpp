#include "renderer/scene/model/camera_view.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <optional>
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
    const bool isEmpty = bounds.IsEmpty();
    const glm::vec3 center = isEmpty ? glm::vec3(0.0f) : bounds.Center();
    // A point still needs some distance.
    const float radius = isEmpty ? 0.866f : std::max(bounds.Radius(), 1e-4f * (1.0f + glm::length(center)));
    // The bounding sphere touches the narrower pair of the view's sides.
    const float halfY = 0.5f * yFov;
    const float halfX = std::atan(std::tan(halfY) * aspect);
    const float distance = radius / std::sin(std::min(halfX, halfY));
    const glm::vec3 toEye = glm::normalize(glm::vec3(0.5f, 0.35f, 1.0f));
    CameraView view = CameraView::LookAt(center + distance * toEye, center, glm::vec3(0, 1, 0));
    view.yFov = yFov;
    view.aspect = aspect;
    view.zNear = 1e-3f * distance;
    return view;
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
    if (IsViewText(choice)) return ViewFromText(choice, aspect);
    FailChoice(scene, choice);
}

}  // namespace raygraph::scene
