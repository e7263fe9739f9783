// Triangles that may emit, and each of them as a light.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "shaders/shared/light_records.h"

namespace raygraph {

// A triangle that emits if its material does. Object space.
struct Emitter {
    glm::vec3 p0{0.0f}, p1{0.0f}, p2{0.0f};
    uint32_t primitive = 0;  // its number in the BLAS
    uint32_t material = 0;
    bool isDoubleSided = false;   // double-sided: its back face emits, too
    glm::vec3 meanTexture{1.0f};  // of the emissive texture over the triangle; linear
    float error = 0.0f;           // of each coordinate, against those on the device
    // The extent of its mesh in object space, if that is about closed and double-sided; else negative.
    glm::vec3 closedExtent{-1.0f};
};

// Whether light sampling leaves out the back of the emitter: it is the inside of a mesh that is flat, which
// the other side of the mesh hides. A shadow ray would not find that out, because it ends before the
// thickness of the mesh. Paths that hit the back all the same find all of its light.
bool IsBackInside(const Emitter& emitter, const glm::mat4x3& objectToWorld);

// Luminance of a color.
double Luminance(const glm::vec3& color);

// The triangle where `objectToWorld` places it, of the instance with that record.
gpu::LightRecord TriangleLight(const Emitter& emitter, uint32_t record, const glm::mat4x3& objectToWorld);

// Luminance, W; `meanRadiance` is before the shape. 0 for a triangle without area.
double TrianglePower(const gpu::LightRecord& light, const glm::vec3& meanRadiance);

}  // namespace raygraph
