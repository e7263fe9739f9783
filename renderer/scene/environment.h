// What light comes from infinitely far away: the description; passes upload and sample it.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>

namespace raygraph::scene {

// An empty `imagePath` is a constant environment of `color`; else an equirectangular .hdr or .exr, read by
// image::ReadEnvironment, and `color` multiplies it.
//
// Direction d of the world (+y up) maps to the image at
//     u = 0.5 + atan2(d.z, d.x) / (2 pi),   v = acos(d.y) / pi,   v = 0 the top row,
// where d is first turned about +y by -rotationDegrees: a positive rotation turns the environment
// counter-clockwise as seen from above.
struct EnvironmentDesc {
    std::filesystem::path imagePath;
    glm::vec3 color{1.0f};         // Linear radiance, W/(sr m^2) as a number, or factors on the image.
    float intensity = 1.0f;        // Multiplies `color`.
    float rotationDegrees = 0.0f;  // About +y.

    bool IsConstant() const { return imagePath.empty(); }
    glm::vec3 Scale() const { return color * intensity; }
    // No light at all: nothing needs to be sampled.
    bool IsBlack() const { return Scale() == glm::vec3(0.0f); }
};

// World directions to the directions of the unturned environment, by which the image is looked up.
glm::mat3 WorldToEnvironment(const EnvironmentDesc& environment);

}  // namespace raygraph::scene
