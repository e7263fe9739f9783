// Primitives in pieces: every triangle once, with the bits of its vertices, and no piece beyond its limits.
#include "renderer/scene/geometry/split_mesh.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>
#include <set>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "tests/support/error_of.h"

namespace raygraph::scene::split_mesh_test {
namespace {

class Numbers {
  public:
    explicit Numbers(uint32_t seed) : m_engine(seed) {}
    template <typename Vector>
    std::vector<Vector> Vectors(size_t count) {
        std::vector<Vector> vectors(count);
        for (Vector& vector : vectors)
            for (int i = 0; i < vector.length(); ++i) vector[i] = Next();
        return vectors;
    }
    float Next() { return std::uniform_real_distribution<float>(-1.0f, 1.0f)(m_engine); }
    uint32_t Below(uint32_t end) { return std::uniform_int_distribution<uint32_t>(0, end - 1)(m_engine); }

  private:
    std::mt19937 m_engine;
};

// Makes a primitive with all streams, with random numbers, over vertices that triangles share and that are
// all used.
Primitive AllStreams(size_t vertexCount, size_t triangleCount) {
    Numbers numbers(7);
    Primitive primitive;
    primitive.positions = numbers.Vectors<glm::vec3>(vertexCount);
    primitive.normals = numbers.Vectors<glm::vec3>(vertexCount);
    primitive.tangents = numbers.Vectors<glm::vec4>(vertexCount);
    primitive.tangentTexCoord = 1;
    primitive.frameTurns = numbers.Vectors<glm::vec2>(vertexCount);
    primitive.uv0 = numbers.Vectors<glm::vec2>(vertexCount);
    primitive.uv1 = numbers.Vectors<glm::vec2>(vertexCount);
    primitive.colors = numbers.Vectors<glm::vec4>(vertexCount);
    for (size_t i = 0; i < 3 * triangleCount; ++i)
        primitive.indices.push_back(i < vertexCount ? uint32_t(i) : numbers.Below(uint32_t(vertexCount)));
    primitive.targets.resize(2);
    primitive.targets[0].positions = numbers.Vectors<glm::vec3>(vertexCount);
    primitive.targets[0].normals = numbers.Vectors<glm::vec3>(vertexCount);
    primitive.targets[1].tangents = numbers.Vectors<glm::vec3>(vertexCount);
    primitive.influences.perVertex = 5;
    for (size_t i = 0; i < 5 * vertexCount; ++i) {
        primitive.influences.joints.push_back(uint16_t(numbers.Below(9)));
        primitive.influences.weights.push_back(std::abs(numbers.Next()));
    }
    primitive.material = 3;
    primitive.variants = {{0, 1}, {kNone, 3}};
    primitive.bounds = BoundsOf(primitive.positions);
    UpdateDeformationBounds(primitive);
    return primitive;
}

// Squares in a plane in a random order, each of two triangles with four vertices of its own.
Primitive Squares(uint32_t side) {
    std::vector<uint32_t> order(side * side);
    for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::shuffle(order.begin(), order.end(), std::mt19937(5));
    Primitive primitive;
    for (const uint32_t square : order) {
        const auto x = float(square % side), y = float(square / side);
        const auto first = uint32_t(primitive.positions.size());
        primitive.positions.insert(primitive.positions.end(),
                                   {{x, y, 0}, {x + 1, y, 0}, {x + 1, y + 1, 0}, {x, y + 1, 0}});
        for (const uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) primitive.indices.push_back(first + corner);
    }
    return primitive;
}

template <typename Vector>
void AddBits(const std::vector<Vector>& stream, size_t vertex, size_t perVertex,
             std::vector<uint32_t>& bits) {
    bits.push_back(stream.empty() ? 0u : 1u);
    for (size_t i = vertex * perVertex; !stream.empty() && i < (vertex + 1) * perVertex; ++i) {
        if constexpr (std::is_same_v<Vector, uint16_t>) {
            bits.push_back(stream[i]);
        } else if constexpr (std::is_same_v<Vector, float>) {
            bits.push_back(std::bit_cast<uint32_t>(stream[i]));
        } else {
            for (int k = 0; k < Vector::length(); ++k) bits.push_back(std::bit_cast<uint32_t>(stream[i][k]));
        }
    }
}

// Returns all data of a vertex, and which streams exist.
std::vector<uint32_t> VertexBits(const Primitive& primitive, size_t vertex) {
    std::vector<uint32_t> bits;
    AddBits(primitive.positions, vertex, 1, bits);
    AddBits(primitive.normals, vertex, 1, bits);
    AddBits(primitive.tangents, vertex, 1, bits);
    AddBits(primitive.frameTurns, vertex, 1, bits);
    AddBits(primitive.uv0, vertex, 1, bits);
    AddBits(primitive.uv1, vertex, 1, bits);
    AddBits(primitive.colors, vertex, 1, bits);
    AddBits(primitive.influences.joints, vertex, primitive.influences.perVertex, bits);
    AddBits(primitive.influences.weights, vertex, primitive.influences.perVertex, bits);
    bits.push_back(uint32_t(primitive.targets.size()));
    for (const MorphTarget& target : primitive.targets) {
        AddBits(target.positions, vertex, 1, bits);
        AddBits(target.normals, vertex, 1, bits);
        AddBits(target.tangents, vertex, 1, bits);
    }
    return bits;
}

void ExpectSameBounds(const Bounds& actual, const Bounds& expected) {
    EXPECT_EQ(actual.min, expected.min);
    EXPECT_EQ(actual.max, expected.max);
}

// Each triangle once, with its vertices in their order; boxes around what there is, and the limits kept.
void ExpectSame(const std::vector<PrimitivePiece>& pieces, const Primitive& whole,
                const PieceLimits& limits) {
    const size_t corners = whole.IsRound() ? 2 : 3;
    std::vector<int> seen(whole.indices.size() / corners, 0);
    for (const PrimitivePiece& piece : pieces) {
        const Primitive& part = piece.primitive;
        ASSERT_EQ(part.indices.size(), corners * piece.originals.size());
        EXPECT_TRUE(std::ranges::is_sorted(piece.originals));
        for (size_t i = 0; i < piece.originals.size(); ++i) {
            const size_t original = piece.originals[i];
            ++seen.at(original);
            for (size_t k = 0; k < corners; ++k)
                ASSERT_EQ(VertexBits(part, part.indices[corners * i + k]),
                          VertexBits(whole, whole.indices[corners * original + k]))
                    << "corner " << k << " of triangle " << original;
            if (whole.IsRound()) {
                EXPECT_EQ(part.radii.at(i), whole.radii[original]);
            }
        }
        const std::set<uint32_t> used(part.indices.begin(), part.indices.end());
        EXPECT_EQ(used.size(), part.positions.size()) << "vertices that no triangle of the piece has";
        EXPECT_LE(piece.originals.size(), limits.maxTriangles);
        EXPECT_LE(part.positions.size(), limits.maxVertices);
        EXPECT_LE(StreamBytes(part), limits.maxBytes);
        EXPECT_EQ(part.material, whole.material);
        EXPECT_EQ(part.variants, whole.variants);
        EXPECT_EQ(part.hasFlatNormals, whole.hasFlatNormals);
        EXPECT_EQ(part.tangentTexCoord, whole.tangentTexCoord);
        EXPECT_EQ(part.IsRound(), whole.IsRound());
        ExpectSameBounds(part.bounds, part.IsRound() ? RoundBounds(part) : BoundsOf(part.positions));
        Primitive bounded = part;
        UpdateDeformationBounds(bounded);
        ASSERT_EQ(part.influences.bounds.size(), bounded.influences.bounds.size());
        for (size_t i = 0; i < bounded.influences.bounds.size(); ++i)
            ExpectSameBounds(part.influences.bounds[i], bounded.influences.bounds[i]);
        for (size_t i = 0; i < bounded.targets.size(); ++i)
            ExpectSameBounds(part.targets[i].bounds, bounded.targets[i].bounds);
    }
    EXPECT_EQ(std::ranges::count(seen, 1), std::ptrdiff_t(seen.size()));
}

std::vector<PrimitivePiece> Split(Primitive primitive, const PieceLimits& limits) {
    return SplitPrimitive(std::move(primitive), limits);
}

TEST(SplitPrimitive, WithinTheLimitsIsOnePieceThatWasMoved) {
    Primitive primitive = AllStreams(100, 50);
    const glm::vec3* positions = primitive.positions.data();
    const std::vector<PrimitivePiece> pieces = SplitPrimitive(
        std::move(primitive), {.maxTriangles = 50, .maxVertices = 100, .maxBytes = StreamBytes(primitive)});
    ASSERT_EQ(pieces.size(), 1u);
    EXPECT_EQ(pieces[0].primitive.positions.data(), positions);
    EXPECT_TRUE(pieces[0].originals.empty());
}

TEST(SplitPrimitive, KeepsEveryTriangleWithTheBitsOfItsVertices) {
    const Primitive whole = AllStreams(300, 500);
    for (const PieceLimits& limits :
         {PieceLimits{.maxTriangles = 499}, PieceLimits{.maxTriangles = 7}, PieceLimits{.maxVertices = 299},
          PieceLimits{.maxVertices = 20}, PieceLimits{.maxBytes = StreamBytes(whole) - 1},
          PieceLimits{.maxBytes = 4000}, PieceLimits{.maxTriangles = 1}}) {
        SCOPED_TRACE(::testing::Message() << limits.maxTriangles << " triangles " << limits.maxVertices
                                          << " vertices " << limits.maxBytes << " bytes");
        const std::vector<PrimitivePiece> pieces = Split(whole, limits);
        EXPECT_GE(pieces.size(), 2u);
        ExpectSame(pieces, whole, limits);
    }
}

// Bytes of a vertex and of a triangle by hand: a limit of exactly two triangles is used in full.
TEST(SplitPrimitive, CountsTheBytesOfAllStreams) {
    Primitive whole = AllStreams(12, 4);
    for (uint32_t i = 0; i < 12; ++i) whole.indices[i] = i;
    const uint64_t vertexBytes = 12 + 12 + 16 + 8 + 8 + 8 + 16 + 5 * (2 + 4) + 12 + 12 + 12;
    EXPECT_EQ(StreamBytes(whole), 12 * vertexBytes + 4 * 12);
    EXPECT_EQ(Split(whole, {.maxBytes = 6 * vertexBytes + 2 * 12}).size(), 2u);
    EXPECT_EQ(Split(whole, {.maxBytes = 6 * vertexBytes + 2 * 12 - 1}).size(), 4u);
}

TEST(SplitPrimitive, SplitsByPlace) {
    const Primitive whole = Squares(16);
    const PieceLimits limits{.maxTriangles = 32};
    const std::vector<PrimitivePiece> pieces = Split(whole, limits);
    ExpectSame(pieces, whole, limits);
    ASSERT_EQ(pieces.size(), 16u);
    float area = 0.0f;
    for (const PrimitivePiece& piece : pieces) {
        const glm::vec3 size = piece.primitive.bounds.max - piece.primitive.bounds.min;
        area += size.x * size.y;
    }
    EXPECT_LT(area, 1.5f * 256.0f);  // in the file's order, each piece would be as large as nearly all of it
}

TEST(SplitPrimitive, SplitsAlongTheLongestAxis) {
    for (int axis = 0; axis < 3; ++axis) {
        Primitive whole = Squares(8);
        for (glm::vec3& position : whole.positions) {
            glm::vec3 turned(0.1f * position.x, 0.1f * position.x, 0.1f * position.x);
            turned[axis] = position.y;
            position = turned;
        }
        const std::vector<PrimitivePiece> pieces = Split(whole, {.maxTriangles = 64});
        ASSERT_EQ(pieces.size(), 2u);
        EXPECT_EQ(pieces[0].primitive.bounds.max[axis], 4.0f) << "axis " << axis;
        EXPECT_EQ(pieces[1].primitive.bounds.min[axis], 4.0f) << "axis " << axis;
    }
}

TEST(SplitPrimitive, TheSameInputGivesTheSamePieces) {
    const Primitive whole = AllStreams(50, 333);
    const std::vector<PrimitivePiece> once = Split(whole, {.maxTriangles = 10});
    const std::vector<PrimitivePiece> again = Split(whole, {.maxTriangles = 10});
    ASSERT_EQ(once.size(), again.size());
    for (size_t i = 0; i < once.size(); ++i) {
        EXPECT_EQ(once[i].originals, again[i].originals);
        EXPECT_EQ(once[i].primitive.indices, again[i].primitive.indices);
    }
}

// No median parts them: they are halved by their number.
TEST(SplitPrimitive, TrianglesOfOnePlaceAreHalved) {
    Primitive whole;
    whole.positions = {{1, 2, 3}, {1, 2, 3}, {1, 2, 3}};
    for (uint32_t i = 0; i < 3 * 100; ++i) whole.indices.push_back(i % 3);
    const PieceLimits limits{.maxTriangles = 25};
    const std::vector<PrimitivePiece> pieces = Split(whole, limits);
    ASSERT_EQ(pieces.size(), 4u);
    ExpectSame(pieces, whole, limits);
    for (uint32_t piece = 0; piece < 4; ++piece) EXPECT_EQ(pieces[piece].originals.front(), 25 * piece);
}

TEST(SplitPrimitive, PlacesBeyondHalfOfAllNumbersAreParted) {
    Primitive whole;
    for (const float place : {3e38f, -3e38f, 3.3e38f, -3.3e38f})
        whole.positions.insert(whole.positions.end(), 3, {place, 0, 0});
    for (uint32_t i = 0; i < 12; ++i) whole.indices.push_back(i);
    const std::vector<PrimitivePiece> pieces = Split(whole, {.maxTriangles = 2});
    ASSERT_EQ(pieces.size(), 2u);
    EXPECT_EQ(pieces[0].originals, (std::vector<uint32_t>{1, 3}));
    EXPECT_EQ(pieces[1].originals, (std::vector<uint32_t>{0, 2}));
}

TEST(SplitPrimitive, ATriangleBeyondTheLimitsIsAnErrorThatChangesNothing) {
    Primitive primitive = AllStreams(300, 20);
    primitive.indices[30] = 0, primitive.indices[31] = 1, primitive.indices[32] = 2;
    const Primitive before = primitive;
    for (const PieceLimits& limits :
         {PieceLimits{.maxBytes = 100}, PieceLimits{.maxVertices = 2}, PieceLimits{.maxTriangles = 0}}) {
        const std::string text = testing::ErrorTextOf([&] { SplitPrimitive(std::move(primitive), limits); },
                                                      ErrorKind::OutOfMemory);
        EXPECT_NE(text.find("a mesh cannot be split"), std::string::npos) << text;
        EXPECT_EQ(primitive.indices, before.indices);
        EXPECT_EQ(StreamBytes(primitive), StreamBytes(before));
    }
}

TEST(SplitPrimitive, FlatTrianglesKeepThreeVerticesEachInOrder) {
    Primitive whole;
    whole.positions = Numbers(3).Vectors<glm::vec3>(3 * 40);
    for (uint32_t i = 0; i < 3 * 40; ++i) whole.indices.push_back(i);
    whole.hasFlatNormals = true;
    for (const PrimitivePiece& piece : Split(whole, {.maxVertices = 15}))
        for (uint32_t i = 0; i < piece.primitive.indices.size(); ++i)
            ASSERT_EQ(piece.primitive.indices[i], i);
}

TEST(SplitPrimitive, RoundPrimitivesKeepTheirRadii) {
    Numbers numbers(11);
    Primitive whole;
    whole.positions = numbers.Vectors<glm::vec3>(100);
    whole.colors = numbers.Vectors<glm::vec4>(100);
    for (int i = 0; i < 200; ++i) {
        whole.indices.insert(whole.indices.end(), {numbers.Below(100), numbers.Below(100)});
        whole.radii.push_back(1.5f + numbers.Next());
    }
    whole.bounds = RoundBounds(whole);
    for (const PieceLimits& limits : {PieceLimits{.maxTriangles = 9}, PieceLimits{.maxBytes = 900}}) {
        const std::vector<PrimitivePiece> pieces = Split(whole, limits);
        EXPECT_GE(pieces.size(), 16u);
        ExpectSame(pieces, whole, limits);
    }
    // two vertices with colors, two indices and a radius
    EXPECT_EQ(testing::ErrorTextOf([&] { Split(whole, {.maxBytes = 2 * 28 + 12}); }), "accepted");
    EXPECT_NE(testing::ErrorTextOf([&] { Split(whole, {.maxBytes = 2 * 28 + 11}); }, ErrorKind::OutOfMemory),
              "accepted");
}

TEST(SplitPrimitive, WithoutTrianglesIsOnePiece) {
    EXPECT_EQ(Split({}, {.maxTriangles = 0, .maxVertices = 0, .maxBytes = 0}).size(), 1u);
}

}  // namespace
}  // namespace raygraph::scene::split_mesh_test
