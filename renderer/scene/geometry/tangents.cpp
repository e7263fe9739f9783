#include "renderer/scene/geometry/tangents.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

#include "base/check.h"
#include "renderer/scene/geometry/triangles.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {
namespace {

using glm::dvec2;
using glm::dvec3;

// A corner is 3 * triangle + 0, 1 or 2; its edge leads to the triangle's next corner.
uint32_t Next(uint32_t corner) {
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}
uint32_t Previous(uint32_t corner) {
    return corner % 3 == 0 ? corner + 2 : corner - 1;
}

// Zero stays zero: so the sum of such vectors is safe to use.
dvec3 Normalized(const dvec3& v) {
    const double length = glm::length(v);
    return length > 0.0 ? v / length : dvec3(0.0);
}
// Returns the part of v in the plane perpendicular to the unit vector n, at unit length or zero.
dvec3 Tangential(const dvec3& v, const dvec3& n) {
    return Normalized(v - n * glm::dot(n, v));
}

struct Face {
    dvec3 tangent{0.0};         // unit length, along increasing u; zero if neutral
    bool isMirrored = false;    // Its picture is seen mirrored. A neutral face: as the first group it joins.
    bool isNeutral = true;      // No area in uv: starts no group, adds to no mean.
    bool isDegenerate = false;  // two corners in one place: no part in grouping
};

Face Measure(const std::array<dvec3, 3>& p, const std::array<dvec2, 3>& uv) {
    Face face;
    face.isDegenerate = p[0] == p[1] || p[1] == p[2] || p[2] == p[0];
    // Solves p - p0 = (u - u0) tangent + (v - v0) bitangent for the two edges
    const dvec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
    const double area = a.x * b.y - a.y * b.x;
    const dvec3 tangent = b.y * (p[1] - p[0]) - a.y * (p[2] - p[0]);
    const dvec3 bitangent = a.x * (p[2] - p[0]) - b.x * (p[1] - p[0]);
    if (area == 0.0 || tangent == dvec3(0.0) || bitangent == dvec3(0.0)) return face;
    face.isNeutral = false;
    face.isMirrored = area > 0.0;  // v runs downwards
    face.tangent = Normalized(area < 0.0 ? -tangent : tangent);
    return face;
}

// Returns the contribution of a face to the tangent of a vertex with this normal, to which two of its edges
// lead: its own tangent in the plane perpendicular to the normal, weighted by its angle, measured in that
// plane.
dvec3 Share(const Face& face, const dvec3& normal, const dvec3& edge, const dvec3& otherEdge) {
    const dvec3 a = Tangential(edge, normal), b = Tangential(otherEdge, normal);
    return std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0)) * Tangential(face.tangent, normal);
}

// Returns, by vertex, the first of those that have equal bits. -0 counts as +0.
template <size_t Count>
std::vector<uint32_t> FirstOfEqual(size_t vertexCount, const auto& valuesOf) {
    struct Entry {
        std::array<uint32_t, Count> bits;
        uint32_t vertex;
        auto operator<=>(const Entry&) const = default;
    };
    std::vector<Entry> entries(vertexCount);
    for (uint32_t i = 0; i < entries.size(); ++i) {
        const std::array<float, Count> values = valuesOf(i);
        for (size_t k = 0; k < Count; ++k)  // -0 + 0 is +0
            entries[i].bits[k] = std::bit_cast<uint32_t>(values[k] + 0.0f);
        entries[i].vertex = i;
    }
    std::sort(entries.begin(), entries.end());
    std::vector<uint32_t> firsts(vertexCount);
    uint32_t first = 0;
    for (size_t i = 0; i < entries.size(); ++i) {
        if (i == 0 || entries[i].bits != entries[i - 1].bits) first = entries[i].vertex;
        firsts[entries[i].vertex] = first;
    }
    return firsts;
}

// Returns zero if the mean has no direction: if it has no length, or lies along the normal.
dvec3 DirectionOf(const dvec3& mean, const dvec3& normal) {
    return glm::length(mean) > 1e-12 ? Tangential(mean, normal) : dvec3(0.0);
}

class TangentGenerator {
  public:
    TangentGenerator(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                     std::span<const glm::vec2> uv, std::span<const uint32_t> indices)
        : m_positions(positions), m_normals(normals), m_uv(uv), m_indices(indices) {}

    TangentMesh Generate() {
        Weld();
        MeasureFaces();
        JoinEdges();
        FormGroups();
        FillDegenerateFaces();
        return Split();
    }

  private:
    static size_t FaceOf(uint32_t corner) { return corner / 3; }
    dvec3 Position(uint32_t corner) const { return m_positions[m_indices[corner]]; }
    dvec2 Uv(uint32_t corner) const { return m_uv[m_indices[corner]]; }
    uint32_t CornerCount() const { return static_cast<uint32_t>(m_indices.size()); }

    // Fills in m_welded: by vertex, the first of those equal to it in position, normal and uv.
    void Weld() {
        m_welded = FirstOfEqual<8>(m_positions.size(), [this](uint32_t i) {
            const glm::vec3 &p = m_positions[i], &n = m_normals[i];
            return std::array{p.x, p.y, p.z, n.x, n.y, n.z, m_uv[i].x, m_uv[i].y};
        });
    }
    uint32_t Welded(uint32_t corner) const { return m_welded[m_indices[corner]]; }

    void MeasureFaces() {
        m_faces.resize(m_indices.size() / 3);
        for (uint32_t corner = 0; corner < CornerCount(); corner += 3) {
            m_faces[FaceOf(corner)] = Measure({Position(corner), Position(corner + 1), Position(corner + 2)},
                                              {Uv(corner), Uv(corner + 1), Uv(corner + 2)});
        }
    }

    // m_opposite: by corner, the corner whose edge is the same one the other way round; kNone: a border.
    // Where more than two triangles meet in an edge, they are paired in their order.
    void JoinEdges() {
        struct Edge {
            uint32_t low, high;  // welded vertices
            bool isForward;      // from low to high
            uint32_t corner;
            auto operator<=>(const Edge&) const = default;
        };
        std::vector<Edge> edges;
        edges.reserve(m_indices.size());
        for (uint32_t corner = 0; corner < CornerCount(); ++corner) {
            if (m_faces[FaceOf(corner)].isDegenerate) continue;
            const uint32_t from = Welded(corner), to = Welded(Next(corner));
            edges.push_back({std::min(from, to), std::max(from, to), from < to, corner});
        }
        std::sort(edges.begin(), edges.end());
        m_opposite.assign(m_indices.size(), kNone);
        for (size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
            const auto isSame = [&](const Edge& e) {
                return e.low == edges[begin].low && e.high == edges[begin].high;
            };
            while (end < edges.size() && isSame(edges[end])) ++end;
            size_t forward = begin;
            while (forward < end && !edges[forward].isForward) ++forward;
            for (size_t i = begin, j = forward; i < forward && j < end; ++i, ++j) {
                m_opposite[edges[i].corner] = edges[j].corner;
                m_opposite[edges[j].corner] = edges[i].corner;
            }
        }
    }

    void FormGroups() {
        m_groupOf.assign(m_indices.size(), kNone);
        std::vector<uint32_t> members;
        for (uint32_t corner = 0; corner < CornerCount(); ++corner) {
            const Face& face = m_faces[FaceOf(corner)];
            if (face.isDegenerate || face.isNeutral || m_groupOf[corner] != kNone) continue;
            Gather(corner, members);
            m_groupTangents.push_back(MeanTangent(members));
        }
    }

    // Walks from edge to edge around the vertex at `start`, giving a new group to every corner there that is
    // free and mirrored alike.
    void Gather(uint32_t start, std::vector<uint32_t>& members) {
        const auto group = static_cast<uint32_t>(m_groupTangents.size());
        const bool isMirrored = m_faces[FaceOf(start)].isMirrored;
        const auto take = [&](uint32_t corner) {
            if (corner == kNone || m_groupOf[corner] != kNone) return;
            Face& face = m_faces[FaceOf(corner)];
            const bool isFree = m_groupOf[Next(corner)] == kNone && m_groupOf[Previous(corner)] == kNone;
            if (face.isNeutral && isFree) face.isMirrored = isMirrored;
            if (face.isMirrored != isMirrored) return;
            m_groupOf[corner] = group;
            members.push_back(corner);
        };
        members.clear();
        take(start);
        for (size_t i = 0; i < members.size(); ++i) {
            // Across the edge that leaves the vertex: the other face's edge ends there. Across the one that
            // arrives: the other's starts there.
            const uint32_t leaving = m_opposite[members[i]];
            take(leaving == kNone ? kNone : Next(leaving));
            take(m_opposite[Previous(members[i])]);
        }
    }

    // Returns the mean of the tangents of corners of one group.
    glm::vec4 MeanTangent(std::span<const uint32_t> corners) const {
        const dvec3 normal = m_normals[m_indices[corners[0]]];
        dvec3 sum(0.0);
        for (const uint32_t corner : corners) {
            const Face& face = m_faces[FaceOf(corner)];
            if (face.isNeutral) continue;
            const dvec3 p = Position(corner);
            sum += Share(face, normal, Position(Next(corner)) - p, Position(Previous(corner)) - p);
        }
        return Tangent(sum, normal, m_faces[FaceOf(corners[0])].isMirrored ? -1.0f : 1.0f);
    }

    // If the mean has no direction, returns some perpendicular to the normal.
    static glm::vec4 Tangent(const dvec3& mean, const dvec3& normal, float sign) {
        const dvec3 direction = DirectionOf(mean, normal);
        return {direction != dvec3(0.0) ? glm::vec3(direction) : Perpendicular(glm::vec3(normal)), sign};
    }

    // A degenerate face's corners get the group of another triangle at the same vertex.
    void FillDegenerateFaces() {
        std::vector<uint32_t> groupAt(m_positions.size(), kNone);
        for (uint32_t corner = 0; corner < CornerCount(); ++corner)
            if (m_groupOf[corner] != kNone && groupAt[Welded(corner)] == kNone)
                groupAt[Welded(corner)] = m_groupOf[corner];
        for (uint32_t corner = 0; corner < CornerCount(); ++corner)
            if (m_faces[FaceOf(corner)].isDegenerate) m_groupOf[corner] = groupAt[Welded(corner)];
    }

    // A vertex keeps its number for the first group that uses it.
    TangentMesh Split() const {
        TangentMesh mesh;
        mesh.indices.assign(m_indices.begin(), m_indices.end());
        mesh.sources.resize(m_positions.size());
        std::iota(mesh.sources.begin(), mesh.sources.end(), 0u);

        std::vector<uint32_t> corners(m_indices.size());
        std::iota(corners.begin(), corners.end(), 0u);
        const auto key = [&](uint32_t corner) {
            return uint64_t{m_indices[corner]} << 32 | m_groupOf[corner];
        };
        std::sort(corners.begin(), corners.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
        std::vector<uint32_t> groupOfVertex(m_positions.size(), kNone);
        for (size_t i = 0; i < corners.size(); ++i) {
            const uint32_t corner = corners[i], source = m_indices[corner];
            const bool isSameVertex = i > 0 && m_indices[corners[i - 1]] == source;
            if (isSameVertex && m_groupOf[corners[i - 1]] == m_groupOf[corner]) {
                mesh.indices[corner] = mesh.indices[corners[i - 1]];
            } else if (isSameVertex) {
                mesh.indices[corner] = static_cast<uint32_t>(mesh.sources.size());
                mesh.sources.push_back(source);
                groupOfVertex.push_back(m_groupOf[corner]);
            } else {
                groupOfVertex[source] = m_groupOf[corner];
            }
        }
        mesh.tangents.reserve(mesh.sources.size());
        for (size_t vertex = 0; vertex < mesh.sources.size(); ++vertex) {
            const uint32_t group = groupOfVertex[vertex];
            mesh.tangents.push_back(group != kNone
                                        ? m_groupTangents[group]
                                        : Tangent(dvec3(0.0), m_normals[mesh.sources[vertex]], 1.0f));
        }
        return mesh;
    }

    std::span<const glm::vec3> m_positions;
    std::span<const glm::vec3> m_normals;
    std::span<const glm::vec2> m_uv;
    std::span<const uint32_t> m_indices;
    std::vector<uint32_t> m_welded;
    std::vector<Face> m_faces;
    std::vector<uint32_t> m_opposite;
    std::vector<uint32_t> m_groupOf;  // by corner; kNone: of no group
    std::vector<glm::vec4> m_groupTangents;
};

}  // namespace

TangentMesh GenerateTangents(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                             std::span<const glm::vec2> uv, std::span<const uint32_t> indices) {
    RG_CHECK_EQ(normals.size(), positions.size());
    RG_CHECK_EQ(uv.size(), positions.size());
    RG_CHECK_EQ(indices.size() % 3, 0u);
    return TangentGenerator(positions, normals, uv, indices).Generate();
}

std::vector<glm::vec3> MoveTangents(const TangentShape& rest, const TangentShape& moved,
                                    std::span<const glm::vec4> tangents, std::span<const glm::vec2> uv,
                                    std::span<const uint32_t> indices) {
    // A group is the vertices that are one at rest and have one tangent.
    const std::vector<uint32_t> groupOf = FirstOfEqual<12>(rest.positions.size(), [&](uint32_t i) {
        const glm::vec3 &p = rest.positions[i], &n = rest.normals[i];
        const glm::vec4& t = tangents[i];
        return std::array{p.x, p.y, p.z, n.x, n.y, n.z, uv[i].x, uv[i].y, t.x, t.y, t.z, t.w};
    });
    std::vector<dvec3> sums(groupOf.size(), dvec3(0.0));
    const auto position = [&](uint32_t corner) { return dvec3(moved.positions[indices[corner]]); };
    const auto coordinates = [&](uint32_t corner) { return dvec2(uv[indices[corner]]); };
    for (uint32_t first = 0; first + 2 < indices.size(); first += 3) {
        const Face face = Measure({position(first), position(first + 1), position(first + 2)},
                                  {coordinates(first), coordinates(first + 1), coordinates(first + 2)});
        if (face.isNeutral) continue;
        for (uint32_t corner = first; corner < first + 3; ++corner)
            sums[groupOf[indices[corner]]] +=
                Share(face, moved.normals[indices[corner]], position(Next(corner)) - position(corner),
                      position(Previous(corner)) - position(corner));
    }
    std::vector<glm::vec3> moves(groupOf.size(), glm::vec3(0.0f));
    for (size_t i = 0; i < moves.size(); ++i) {
        const dvec3 direction = DirectionOf(sums[groupOf[i]], moved.normals[i]);
        if (direction != dvec3(0.0)) moves[i] = glm::vec3(direction - dvec3(glm::vec3(tangents[i])));
    }
    return moves;
}

}  // namespace raygraph::scene
