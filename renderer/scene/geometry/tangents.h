// Tangents of a triangle list as MikkTSpace defines them (Mikkelsen, "Simulation of Wrinkled Surfaces
// Revisited", 2008), against which normal maps are baked. Internal to renderer/scene.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Holds the vertices that a mesh has once it has tangents: a vertex where several tangents meet is split.
struct TangentMesh {
    // By new vertex: the old one, whose other attributes it takes. The first ones are the old vertices, in
    // order.
    std::vector<uint32_t> sources;
    std::vector<uint32_t> indices;  // in the order of the old ones, into the new vertices
    // By new vertex: unit length, perpendicular to the normal; w = +1 or -1.
    std::vector<glm::vec4> tangents;
};

// Streams are of one length and finite, normals of unit length, every index is below their length. `uv` is
// glTF's, v downwards: w has the sign for which cross(normal, tangent) * w points to the image's top.
//
// Vertices of equal position, normal and uv count as one. Around such a vertex, triangles that share edges
// and are mirrored alike in uv form a group; its tangent is the mean of theirs, weighted by their angles.
// Triangles whose uv has no area belong to any group they touch; those without two distinct edges take the
// tangent of a neighbor; what is then left gets some vector perpendicular to the normal.
//
// Time: n log n in the number of triangles, whatever their topology.
TangentMesh GenerateTangents(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                             std::span<const glm::vec2> uv, std::span<const uint32_t> indices);

// Describes a triangle list in one shape. Streams are of one length and finite, normals of unit length.
struct TangentShape {
    std::span<const glm::vec3> positions;
    std::span<const glm::vec3> normals;
};

// Returns, by vertex, how its tangent moves from the shape at rest, for which GenerateTangents made
// `tangents` and split the vertices, to another one. Which triangles form a group stays as it is at rest.
// Where the image has no direction in the moved shape, the tangent stays.
//
// Time: n log n in the number of vertices.
std::vector<glm::vec3> MoveTangents(const TangentShape& rest, const TangentShape& moved,
                                    std::span<const glm::vec4> tangents, std::span<const glm::vec2> uv,
                                    std::span<const uint32_t> indices);

}  // namespace raygraph::scene
