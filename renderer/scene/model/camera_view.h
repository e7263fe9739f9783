// The view of a picture: what a pass needs to generate camera rays, independent of any scene graph. Threads:
// plain values and pure functions, for any thread.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "base/api.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// right, up and -forward are a right-handed orthonormal frame. Image coordinates x, y in [-1, 1], y up:
//   perspective:  origin eye, direction forward + x * tan(yFov / 2) * aspect * right + y * tan(yFov / 2) * up
//   orthographic: origin eye + x * height / 2 * aspect * right + y * height / 2 * up, direction forward
struct RAYGRAPH_API CameraView {
    glm::dvec3 eye{0.0};
    glm::vec3 forward{0.0f, 0.0f, -1.0f};
    glm::vec3 up{0.0f, 1.0f, 0.0f};
    glm::vec3 right{1.0f, 0.0f, 0.0f};
    Projection projection = Projection::Perspective;
    float yFov = 0.8f;    // full vertical angle, radians; perspective only
    float height = 2.0f;  // Meters seen from bottom to top; orthographic only.
    float aspect = 1.0f;  // width over height of the picture
    float zNear = 0.01f;  // Meters, for raster views. Always above 0.
    float zFar = 0.0f;    // meters, for raster views; 0 = infinite

    bool operator==(const CameraView&) const = default;

    // A camera at `eye` that looks at `target`. `up` need not be perpendicular; if it is parallel to the view
    // direction or zero another is chosen. If eye and target are one point it looks along -z.
    static CameraView LookAt(const glm::dvec3& eye, const glm::dvec3& target, const glm::vec3& up);
};

// Returns a placed camera. The vertical extent is kept, whatever the aspect ratio of the picture is. Scale
// and shear of its node are ignored; a mirroring one does not mirror the picture.
RAYGRAPH_API CameraView ViewOf(const Camera& camera, float aspect);

// Gives the direction from which a scene is seen, in degrees.
struct Orbit {
    float azimuth = 0.0f;    // 0: from +z, the front of glTF; 90: from +x
    float elevation = 0.0f;  // above the horizon, -90 to 90; from straight above, -z is up in the picture
    // If true, the view is as far away as a camera that goes around the scene has to be, and looks at the
    // axis that it goes around: pictures of one elevation fit together.
    bool isTurntable = false;

    bool operator==(const Orbit&) const = default;
};

// Returns a perspective camera that sees all of `bounds`: the projected box is in the middle of the picture,
// and the side that fits tighter spans kFramedShare of it. Without an orbit it is seen from the front, the
// right and slightly above; a board (far thinner than wide and high), from where its face is seen. An empty
// box is taken as the unit cube around the origin.
inline constexpr float kFramedShare = 0.9f;
RAYGRAPH_API CameraView ViewOfBounds(const Bounds& bounds, float aspect, float yFov = 0.7f);
RAYGRAPH_API CameraView ViewOfBounds(const Bounds& bounds, const Orbit& orbit, float aspect,
                                     float yFov = 0.7f);
// Keeps direction, projection, field of view and aspect ratio of another view.
RAYGRAPH_API CameraView ViewOfBounds(const Bounds& bounds, const CameraView& from);

// Converts between an orbit and "orbit AZIMUTH ELEVATION" or "turntable AZIMUTH ELEVATION"; none: the text is
// not one of these, or its elevation is out of range.
RAYGRAPH_API std::optional<Orbit> OrbitFromText(std::string_view text);
RAYGRAPH_API std::string ToText(const Orbit& orbit);

// "eye target up fov": numbers separated by spaces or commas, fov the vertical angle in degrees.
//   10 numbers: eye, target, up, fov     9: eye, target, up     7: eye, target, fov     6: eye, target
// up +y, fov 40 where missing; a fov "2.5m": orthographic, that height. Error{Usage} that quotes the text.
RAYGRAPH_API CameraView ViewFromText(std::string_view text, float aspect);

// Returns whether this text is for ViewFromText rather than a camera's name or index. (Several numbers and
// nothing else.)
RAYGRAPH_API bool IsViewText(std::string_view text);

// Returns the camera of this name, else of this index; none: the scene has none such.
RAYGRAPH_API std::optional<uint32_t> FindCamera(const SceneData& scene, std::string_view choice);

// Returns the view of `--camera NAME|INDEX|"eye target up fov"`: a camera of the scene by name, then by
// index, then by text, also that of an orbit around its bounds; for an empty choice the scene's first camera,
// else one that frames its bounds. Throws Error{Usage} listing the cameras.
RAYGRAPH_API CameraView ChooseView(const SceneData& scene, std::string_view choice, float aspect);

}  // namespace raygraph::scene
