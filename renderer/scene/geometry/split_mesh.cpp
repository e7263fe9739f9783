#include "renderer/scene/geometry/split_mesh.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

#include "base/text.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/geometry/round_primitives.h"

namespace raygraph::scene {
namespace {

template <typename T>
uint64_t Bytes(const std::vector<T>& values) {
    return values.size() * sizeof(T);
}

// Calls visit(stream, elements a vertex) for each stream that has something of each vertex, of one primitive
// or of two side by side.
template <typename Visit, typename... P>
void ForEachVertexStream(Visit&& visit, P&... primitive) {
    visit(1u, primitive.positions...);
    visit(1u, primitive.normals...);
    visit(1u, primitive.tangents...);
    visit(1u, primitive.frameTurns...);
    visit(1u, primitive.uv0...);
    visit(1u, primitive.uv1...);
    visit(1u, primitive.colors...);
    const uint32_t perVertex = std::max({primitive.influences.perVertex...});
    visit(perVertex, primitive.influences.joints...);
    visit(perVertex, primitive.influences.weights...);
    const size_t targetCount = std::min({primitive.targets.size()...});
    for (size_t i = 0; i < targetCount; ++i) {
        visit(1u, primitive.targets[i].positions...);
        visit(1u, primitive.targets[i].normals...);
        visit(1u, primitive.targets[i].tangents...);
    }
}

using Range = std::span<uint32_t>;  // of triangles or capsules

class Splitter {
  public:
    Splitter(const Primitive& primitive, const PieceLimits& limits)
        : m_primitive(primitive),
          m_limits(limits),
          m_corners(primitive.IsRound() ? 2 : 3),
          m_seenIn(primitive.positions.size(), 0),
          m_order(primitive.indices.size() / m_corners) {
        const auto add = [this](uint32_t perVertex, const auto& stream) {
            if (!stream.empty()) m_vertexBytes += perVertex * sizeof(stream[0]);
        };
        ForEachVertexStream(add, primitive);
        m_triangleBytes = m_corners * sizeof(uint32_t) + (primitive.IsRound() ? sizeof(float) : 0);
        std::iota(m_order.begin(), m_order.end(), 0u);
    }

    std::vector<PrimitivePiece> Split() {
        std::vector<Range> ranges;
        SplitRange(m_order, ranges);
        std::vector<PrimitivePiece> pieces;
        pieces.reserve(ranges.size());
        for (const Range range : ranges) {
            std::ranges::sort(range);
            pieces.push_back(PieceOf(range));
        }
        return pieces;
    }

  private:
    std::span<const uint32_t> CornersOf(uint32_t triangle) const {
        return std::span(m_primitive.indices).subspan(m_corners * size_t{triangle}, m_corners);
    }

    glm::vec3 Centroid(uint32_t triangle) const {
        glm::vec3 sum(0.0f);
        // Each is divided first: a sum could be beyond the range of float
        for (const uint32_t corner : CornersOf(triangle))
            sum += m_primitive.positions[corner] / static_cast<float>(m_corners);
        return sum;
    }

    uint64_t CountVertices(std::span<const uint32_t> range) {
        ++m_rangeCount;
        uint64_t count = 0;
        for (const uint32_t triangle : range)
            for (const uint32_t corner : CornersOf(triangle))
                count += std::exchange(m_seenIn[corner], m_rangeCount) != m_rangeCount ? 1 : 0;
        return count;
    }

    bool Fits(std::span<const uint32_t> range) {
        if (range.size() > m_limits.maxTriangles) return false;
        const uint64_t vertexCount = CountVertices(range);
        return vertexCount <= m_limits.maxVertices &&
               vertexCount * m_vertexBytes + range.size() * m_triangleBytes <= m_limits.maxBytes;
    }

    void SplitRange(Range range, std::vector<Range>& pieces) {
        if (Fits(range)) {
            pieces.push_back(range);
            return;
        }
        if (range.size() == 1)
            throw MakeError(
                ErrorKind::OutOfMemory,
                "a mesh cannot be split so that its pieces have at most {} triangles, {} vertices "
                "and {} bytes: triangle {} alone has {} vertices and {} bytes",
                m_limits.maxTriangles, m_limits.maxVertices, m_limits.maxBytes, range[0],
                CountVertices(range), CountVertices(range) * m_vertexBytes + m_triangleBytes);
        Bounds centroids;
        for (const uint32_t triangle : range) centroids.Extend(Centroid(triangle));
        const glm::vec3 size = centroids.max - centroids.min;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        // No two are equal, so that what is in each half does not depend on the library's algorithm
        const auto isBefore = [&](uint32_t a, uint32_t b) {
            return std::pair(Centroid(a)[axis], a) < std::pair(Centroid(b)[axis], b);
        };
        const size_t half = range.size() / 2;
        std::ranges::nth_element(range, range.begin() + static_cast<std::ptrdiff_t>(half), isBefore);
        SplitRange(range.first(half), pieces);
        SplitRange(range.subspan(half), pieces);
    }

    // Vertices in order of their first use: of three a triangle, in order, they stay that.
    PrimitivePiece PieceOf(std::span<const uint32_t> range) {
        ++m_rangeCount;
        m_places.resize(m_seenIn.size());
        std::vector<uint32_t> vertices;
        PrimitivePiece piece;
        Primitive& made = piece.primitive;
        piece.originals.assign(range.begin(), range.end());
        made.indices.reserve(m_corners * range.size());
        if (m_primitive.IsRound()) made.radii.reserve(range.size());
        for (const uint32_t triangle : range) {
            for (const uint32_t corner : CornersOf(triangle)) {
                if (std::exchange(m_seenIn[corner], m_rangeCount) != m_rangeCount) {
                    m_places[corner] = static_cast<uint32_t>(vertices.size());
                    vertices.push_back(corner);
                }
                made.indices.push_back(m_places[corner]);
            }
            if (m_primitive.IsRound()) made.radii.push_back(m_primitive.radii[triangle]);
        }
        made.material = m_primitive.material;
        made.variants = m_primitive.variants;
        made.tangentTexCoord = m_primitive.tangentTexCoord;
        made.hasFlatNormals = m_primitive.hasFlatNormals;
        made.influences.perVertex = m_primitive.influences.perVertex;
        made.targets.resize(m_primitive.targets.size());
        const auto copy = [&vertices](uint32_t perVertex, const auto& from, auto& to) {
            if (from.empty()) return;
            to.reserve(perVertex * vertices.size());
            for (const uint32_t vertex : vertices)
                for (size_t i = 0; i < perVertex; ++i) to.push_back(from[perVertex * size_t{vertex} + i]);
        };
        ForEachVertexStream(copy, m_primitive, made);
        made.bounds = made.IsRound() ? RoundBounds(made) : BoundsOf(made.positions);
        UpdateDeformationBounds(made);
        return piece;
    }

    const Primitive& m_primitive;
    const PieceLimits m_limits;
    const size_t m_corners;  // of a triangle or a capsule
    uint64_t m_vertexBytes = 0;
    uint64_t m_triangleBytes = 0;
    uint32_t m_rangeCount = 0;
    std::vector<uint32_t> m_seenIn;  // by vertex: the last range that was found to use it
    std::vector<uint32_t> m_places;  // by vertex: where it is in the last piece that uses it
    std::vector<uint32_t> m_order;
};

}  // namespace

uint64_t StreamBytes(const Primitive& primitive) {
    uint64_t bytes = Bytes(primitive.indices) + Bytes(primitive.radii);
    ForEachVertexStream([&bytes](uint32_t, const auto& stream) { bytes += Bytes(stream); }, primitive);
    return bytes;
}

std::vector<PrimitivePiece> SplitPrimitive(Primitive&& primitive, const PieceLimits& limits) {
    const size_t count = primitive.IsRound() ? primitive.radii.size() : primitive.TriangleCount();
    if (count == 0 || (count <= limits.maxTriangles && primitive.positions.size() <= limits.maxVertices &&
                       StreamBytes(primitive) <= limits.maxBytes)) {
        std::vector<PrimitivePiece> whole(1);
        whole[0].primitive = std::move(primitive);
        return whole;
    }
    std::vector<PrimitivePiece> pieces = Splitter(primitive, limits).Split();
    primitive = {};
    return pieces;
}

}  // namespace raygraph::scene
