#include "renderer/scene/geometry/triangles.h"

#include <cmath>

#include "base/check.h"

namespace raygraph::scene {
namespace {

// `v` over its length, in double so that neither 1e-30 nor 1e30 is lost; false if it has no direction.
bool Normalize(glm::dvec3 v, glm::vec3& out) {
    const double length = glm::length(v);
    if (!(length > 1e-30) || !std::isfinite(length)) return false;
    out = glm::vec3(v / length);
    return true;
}

// Returns twice the triangle's area times its normal.
glm::dvec3 AreaNormal(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    const glm::dvec3 origin(a);
    return glm::cross(glm::dvec3(b) - origin, glm::dvec3(c) - origin);
}

}  // namespace

glm::vec3 Perpendicular(const glm::vec3& n) {
    const glm::vec3 axis = std::abs(n.x) < 0.6f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    return glm::normalize(glm::cross(n, axis));
}

std::vector<uint32_t> TriangleList(PrimitiveMode mode, std::vector<uint32_t> indices) {
    RG_CHECK(mode >= PrimitiveMode::Triangles);
    if (mode == PrimitiveMode::Triangles) {
        indices.resize(indices.size() / 3 * 3);
        return indices;
    }
    std::vector<uint32_t> list;
    if (indices.size() < 3) return list;
    const size_t triangleCount = indices.size() - 2;
    list.reserve(3 * triangleCount);
    for (size_t i = 0; i < triangleCount; ++i) {
        if (mode == PrimitiveMode::TriangleStrip) {
            list.insert(list.end(), {indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]});
        } else {
            list.insert(list.end(), {indices[i + 1], indices[i + 2], indices[0]});
        }
    }
    return list;
}

uint64_t SegmentCount(PrimitiveMode mode, uint64_t indexCount) {
    switch (mode) {
        case PrimitiveMode::Points:
            return indexCount;
        case PrimitiveMode::Lines:
            return indexCount / 2;
        case PrimitiveMode::LineLoop:
            return indexCount > 2 ? indexCount : indexCount / 2;
        case PrimitiveMode::LineStrip:
            return indexCount > 0 ? indexCount - 1 : 0;
        default:
            return 0;
    }
}

std::vector<uint32_t> SegmentList(PrimitiveMode mode, std::span<const uint32_t> indices) {
    RG_CHECK(mode < PrimitiveMode::Triangles);
    const size_t count = SegmentCount(mode, indices.size());
    const size_t step = mode == PrimitiveMode::Lines ? 2 : 1, next = mode == PrimitiveMode::Points ? 0 : 1;
    std::vector<uint32_t> list;
    list.reserve(2 * count);
    for (size_t i = 0; i < count; ++i)
        list.insert(list.end(), {indices[step * i], indices[(step * i + next) % indices.size()]});
    return list;
}

std::vector<glm::vec3> FlatNormals(std::span<const glm::vec3> positions) {
    RG_CHECK_EQ(positions.size() % 3, 0u);
    std::vector<glm::vec3> normals(positions.size());
    for (size_t i = 0; i < positions.size(); i += 3) {
        glm::vec3 normal(0, 0, 1);
        Normalize(AreaNormal(positions[i], positions[i + 1], positions[i + 2]), normal);
        normals[i] = normals[i + 1] = normals[i + 2] = normal;
    }
    return normals;
}

size_t NormalizeNormals(std::span<glm::vec3> normals, std::span<const glm::vec3> positions,
                        std::span<const uint32_t> indices) {
    std::vector<uint32_t> lost;  // in ascending order
    for (size_t i = 0; i < normals.size(); ++i)
        if (!Normalize(normals[i], normals[i])) lost.push_back(static_cast<uint32_t>(i));
    if (lost.empty()) return 0;

    std::vector<glm::dvec3> sums(normals.size(), glm::dvec3(0));
    for (size_t i = 0; i + 2 < indices.size(); i += 3) {
        const glm::dvec3 area =
            AreaNormal(positions[indices[i]], positions[indices[i + 1]], positions[indices[i + 2]]);
        for (size_t k = 0; k < 3; ++k) sums[indices[i + k]] += area;
    }
    for (const uint32_t vertex : lost) {
        normals[vertex] = glm::vec3(0, 0, 1);
        Normalize(sums[vertex], normals[vertex]);
    }
    return lost.size();
}

size_t NormalizeTangents(std::span<glm::vec4> tangents, std::span<const glm::vec3> normals) {
    size_t lostCount = 0;
    for (size_t i = 0; i < tangents.size(); ++i) {
        glm::vec3 direction;
        if (!Normalize(glm::dvec3(tangents[i]), direction)) {
            direction = Perpendicular(normals[i]);
            ++lostCount;
        }
        tangents[i] = glm::vec4(direction, tangents[i].w < 0.0f ? -1.0f : 1.0f);
    }
    return lostCount;
}

}  // namespace raygraph::scene
