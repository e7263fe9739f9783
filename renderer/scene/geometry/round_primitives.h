// Round primitives: the radii that an importer gives to points and lines, and their boxes.
//
//   scene::LoadGltf("scan.gltf", {.pointsAndLines = {.points = scene::ParseRoundRadius("0.01")}});
//
// Threads: pure functions, for any thread.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <string>
#include <string_view>

#include "base/api.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// The limits of radii in object space. The products that shading computes of them stay far from the limits of
// float.
inline constexpr float kMinRadius = 1e-9f;
inline constexpr float kMaxRadius = 1e9f;

// Holds the radius that points or lines are given; 0: they are left out.
struct RoundRadius {
    float value = 0.0f;       // meters in the world,
    bool isRelative = false;  // or diagonals of the bounds of the scene's vertices

    bool IsOn() const { return value > 0.0f; }
    bool operator==(const RoundRadius&) const = default;
};

struct PointsAndLines {
    RoundRadius points;
    RoundRadius lines;

    bool operator==(const PointsAndLines&) const = default;
};

// Parses "0.01" (in meters), "0.2%" (relative to the diagonal) or "off". Throws Error{Usage} for anything
// else, and for a radius that is not between 1e-9 and 1e9 meters, or 1e-7 and 1000 percent.
RAYGRAPH_API RoundRadius ParseRoundRadius(std::string_view text);
// Returns the text that ParseRoundRadius reads as the same radius.
RAYGRAPH_API std::string ToText(const RoundRadius& radius);

// Returns a box around a capsule, with room for the rounding of a ray's intersection with it.
RAYGRAPH_API Bounds RoundBox(const glm::vec3& a, const glm::vec3& b, float radius);
// Returns the box around all capsules of a primitive, and the one around positions.
RAYGRAPH_API Bounds RoundBounds(const Primitive& primitive);
RAYGRAPH_API Bounds BoundsOf(std::span<const glm::vec3> positions);

}  // namespace raygraph::scene
