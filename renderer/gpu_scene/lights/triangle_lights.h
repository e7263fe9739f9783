// Triangles that may emit, and each of them as a light. Threads: pure functions.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "shaders/shared/light_records.h"

namespace raygraph {

// A triangle that emits if its material does, in object space.
struct Emitter {
    glm::vec3 p0{0.0f}, p1{0.0f}, p2{0.0f};
    uint32_t primitive = 0;  // its number in the BLAS
    uint32_t material = 0;
    bool isDoubleSided = false;   // its back face emits, too
    glm::vec3 meanTexture{1.0f};  // mean of the emissive texture over the triangle, linear
    float error = 0.0f;           // bound of the difference between a coordinate here and on the device
    bool isOnClosedMesh = false;  // its mesh is closed (Enclosure)
    bool isThin = false;          // its mesh is thin at rest
    bool isFlattened = false;     // the pose flattens its mesh, see OutlinePose
};

// Tells whether light sampling ignores the emitter's back side, because it faces the inside of a closed mesh
// that is thin, or that its pose or the transform flattens, so that the opposite side of the mesh occludes
// it. Shadow rays cannot detect that, as they stop short of the light by more than the thickness. Paths that
// hit the back anyway count its emission in full.
bool IsBackInside(const Emitter& emitter, const glm::mat4x3& objectToWorld);

// Returns the luminance of a color.
double Luminance(const glm::vec3& color);

// Returns the triangle as `objectToWorld` places it, for the instance with that record.
gpu::LightRecord TriangleLight(const Emitter& emitter, uint32_t record, const glm::mat4x3& objectToWorld);

// Returns the power in luminance, W; `meanRadiance` is before the texture. 0 for a triangle without area.
double TrianglePower(const gpu::LightRecord& light, const glm::vec3& meanRadiance);

}  // namespace raygraph
