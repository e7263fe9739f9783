// Topology of triangles, points and lines, and normals of a triangle list, free of any file format.
// Internal to renderer/scene.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace raygraph::scene {

// The values are glTF's and OpenGL's.
enum class PrimitiveMode : uint8_t {
    Points,
    Lines,
    LineLoop,
    LineStrip,
    Triangles,
    TriangleStrip,
    TriangleFan
};

// Returns a list of the triangles that `indices` draw in `mode` (one of the three triangle modes), each wound
// as glTF 3.7.2.1 says: strip triangle i is (i, i + 1 + i % 2, i + 2 - i % 2), fan triangle i is (i + 1, i +
// 2, 0). Indices left over at the end draw nothing.
std::vector<uint32_t> TriangleList(PrimitiveMode mode, std::vector<uint32_t> indices);

// Returns two indices for each of the points or segments that `indices` draw in `mode` (one of the other
// modes). A point is a segment from a vertex to itself. A loop of two vertices is one segment.
std::vector<uint32_t> SegmentList(PrimitiveMode mode, std::span<const uint32_t> indices);
// Returns how many segments so many indices make.
uint64_t SegmentCount(PrimitiveMode mode, uint64_t indexCount);

// Returns each triangle's own unit normal, for vertices that no two triangles share (three a triangle, in
// order). A triangle without area gets +z.
std::vector<glm::vec3> FlatNormals(std::span<const glm::vec3> positions);

// Makes every normal unit length. One too short to have a direction becomes the area-weighted mean of the
// triangles around its vertex, or +z. Returns how many of those there were.
size_t NormalizeNormals(std::span<glm::vec3> normals, std::span<const glm::vec3> positions,
                        std::span<const uint32_t> indices);

// Makes every tangent's xyz unit length and its w +1 or -1. One too short becomes some vector perpendicular
// to the normal. Returns how many of those there were.
size_t NormalizeTangents(std::span<glm::vec4> tangents, std::span<const glm::vec3> normals);

// Returns a unit vector perpendicular to the unit vector n.
glm::vec3 Perpendicular(const glm::vec3& n);

}  // namespace raygraph::scene
