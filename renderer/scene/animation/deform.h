// Morph targets and skins: the one statement of how they deform a vertex, as functions on the CPU, which what
// runs on a device is compared with; and what a device needs for it, matrices and boxes.
//
// glTF 2.0: targets are added first (3.7.2.2), then joints move the result (3.7.3.3). A vertex becomes
//     sum over its influences of weight * (joint matrix * vertex),
//     joint matrix = inverse(objectToWorld of the instance) * jointToWorld * inverse bind matrix.
// The transform of the node that has the skin does not count: joints are nodes and place the mesh themselves.
// So the object space of a skinned instance is ours to choose. It has the axes of the world and its origin in
// the first joint (SkinFrame), which keeps the numbers of vertices small wherever the joints are; matrices
// are composed in double before they are rounded.
//
// Threads: pure functions of their arguments.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "base/api.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Returns whether something may deform an instance: a skin that its mesh has joints for, or morph targets.
RAYGRAPH_API bool HasSkin(const SceneData& scene, const Instance& instance);
RAYGRAPH_API bool HasTargets(const SceneData& scene, const Instance& instance);

// From now on the instances that can be deformed are drawn so: sets Instance::isDeformed, and places skinned
// ones by SkinFrame; then UpdateWorldTransforms. For a host that deforms; without it, all stay in their base
// shape, where their nodes are.
RAYGRAPH_API void DeformInstances(SceneData& scene);

// objectToWorld of the instances with a skin, the same one for all. `nodeToWorld`: one per node
// (WorldTransforms). Mirrored in x if the joints mirror the mesh, so that deformed triangles keep their
// winding, and the instance says that it is mirrored.
RAYGRAPH_API PlacedTransform SkinFrame(std::span<const PlacedTransform> nodeToWorld, const Skin& skin);

// Writes one matrix for each joint into `matrices`, from the mesh's object space to that of an instance.
RAYGRAPH_API void JointMatrices(std::span<const PlacedTransform> nodeToWorld, const Skin& skin,
                                const PlacedTransform& objectToWorld, std::span<glm::mat4x3> matrices);

// The weights of an instance's morph targets: its node's own, or the mesh's.
RAYGRAPH_API std::span<const float> MorphWeights(const SceneData& scene, const Instance& instance);

struct DeformedVertex {
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f};   // unit length; 0 of a primitive without normals
    glm::vec4 tangent{0.0f};  // xyz unit length; 0 of a primitive without tangents
};

// Returns a vertex with the targets added, as many weights as there are targets: normal + sum of weight *
// displacement, to unit length; the same of tangents, whose w stays. What has then no length stays as it was.
RAYGRAPH_API DeformedVertex MorphVertex(const Primitive& primitive, uint32_t vertex,
                                        std::span<const float> weights);

// Returns a vertex, morphed or not, moved by its joints. With M the weighted sum of their matrices: M *
// position; normals by the cofactors of M, which are its inverse transpose times its determinant: that needs
// no inverse, and keeps the normal on the side that the winding of the moved triangle says; tangents by M.
RAYGRAPH_API DeformedVertex SkinVertex(const Primitive& primitive, uint32_t vertex,
                                       const DeformedVertex& morphed,
                                       std::span<const glm::mat4x3> jointMatrices);

// Returns a tangent made perpendicular to the unit normal (Gram-Schmidt): tangent - dot(tangent, normal) *
// normal, to unit length, w as it was. One along the normal stays as it is.
RAYGRAPH_API glm::vec4 TangentInPlane(const glm::vec4& tangent, const glm::vec3& normal);

// Holds all vertices of a primitive. Without weights or matrices, that part is left out. Where the primitive
// has flat normals, they are those of the deformed triangles. The tangents of flat and of morphed vertices
// are TangentInPlane of what joints have moved: targets displace normals and tangents each by themselves.
struct DeformedStreams {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<glm::vec4> tangents;
};
RAYGRAPH_API void DeformPrimitive(const Primitive& primitive, std::span<const float> weights,
                                  std::span<const glm::mat4x3> jointMatrices, DeformedStreams& deformed);

// Returns a box around the deformed vertices, up to rounding, without looking at them: the targets' boxes by
// their weights around the box, and of joints the box of what each moves, where it moves it.
RAYGRAPH_API Bounds DeformedBounds(const Primitive& primitive, std::span<const float> weights,
                                   std::span<const glm::mat4x3> jointMatrices);

// Fills the boxes of joints and targets from the streams. The importer has done so.
RAYGRAPH_API void UpdateDeformationBounds(Primitive& primitive);

}  // namespace raygraph::scene
