// Meshes that are split, and their tangents.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <ctime>
#include <glm/gtc/constants.hpp>
#include <numeric>
#include <random>
#include <set>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/geometry/split_mesh.h"
#include "renderer/scene/geometry/tangents.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"

// Primitives in pieces: every triangle once, with the bits of its vertices, and no piece beyond its limits.
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

// Tangents that are generated where a file has none.
namespace raygraph::test::tangents_test {
namespace {

using glm::vec2;
using glm::vec3;
using glm::vec4;
using scene::TangentMesh;

// A mesh for tangents; `uv` is a function of the position unless given.
struct Surface {
    std::vector<vec3> positions;
    std::vector<vec3> normals;
    std::vector<vec2> uv;
    std::vector<uint32_t> indices;

    TangentMesh Tangents() const { return scene::GenerateTangents(positions, normals, uv, indices); }
};

// The unit square in the xy plane, facing +z; corners bottom left, bottom right, top right, top left.
Surface Quad(std::vector<vec2> uv) {
    return {.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
            .normals = std::vector<vec3>(4, vec3(0, 0, 1)),
            .uv = std::move(uv),
            .indices = {0, 1, 2, 0, 2, 3}};
}
const std::vector<vec2> kUpright{{0, 1}, {1, 1}, {1, 0}, {0, 0}};  // v downwards, as glTF has it
const std::vector<vec2> kMirrored{{1, 1}, {0, 1}, {0, 0}, {1, 0}};

// Latitudes and longitudes with the picture of a globe; the seam and the poles have vertices of their own.
Surface Globe(uint32_t rings) {
    Surface globe;
    const uint32_t segments = 2 * rings;
    for (uint32_t ring = 0; ring <= rings; ++ring)
        for (uint32_t segment = 0; segment <= segments; ++segment) {
            const float u = float(segment) / float(segments), v = float(ring) / float(rings);
            const float theta = glm::pi<float>() * v, phi = glm::two_pi<float>() * u;
            const vec3 p(std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi));
            globe.positions.push_back(p);
            globe.normals.push_back(p);
            globe.uv.push_back({u, v});
        }
    for (uint32_t ring = 0; ring < rings; ++ring)
        for (uint32_t segment = 0; segment < segments; ++segment) {
            const uint32_t a = ring * (segments + 1) + segment, b = a + segments + 1;
            if (ring > 0) globe.indices.insert(globe.indices.end(), {a, b, a + 1});
            if (ring + 1 < rings) globe.indices.insert(globe.indices.end(), {a + 1, b, b + 1});
        }
    return globe;
}

void ExpectWellFormed(const Surface& surface, const TangentMesh& mesh) {
    ASSERT_EQ(mesh.sources.size(), mesh.tangents.size());
    ASSERT_GE(mesh.sources.size(), surface.positions.size());
    ASSERT_EQ(mesh.indices.size(), surface.indices.size());
    for (size_t i = 0; i < surface.positions.size(); ++i) ASSERT_EQ(mesh.sources[i], i);
    for (size_t i = 0; i < mesh.indices.size(); ++i)
        ASSERT_EQ(mesh.sources.at(mesh.indices[i]), surface.indices[i]) << "a corner stays where it was";
    for (size_t i = 0; i < mesh.tangents.size(); ++i) {
        const vec3 tangent(mesh.tangents[i]);
        ASSERT_NEAR(glm::length(tangent), 1.0f, 1e-5f) << i;
        ASSERT_NEAR(glm::dot(tangent, surface.normals[mesh.sources[i]]), 0.0f, 1e-5f) << i;
        ASSERT_EQ(std::abs(mesh.tangents[i].w), 1.0f) << i;
    }
}

TEST(Tangents, QuadsTangentRunsAlongUAndItsBitangentToThePicturesTop) {
    const Surface quad = Quad(kUpright);
    const TangentMesh mesh = quad.Tangents();
    ExpectWellFormed(quad, mesh);
    EXPECT_EQ(mesh.tangents, std::vector<vec4>(4, vec4(1, 0, 0, 1)));
    const vec3 bitangent = glm::cross(vec3(0, 0, 1), vec3(mesh.tangents[0])) * mesh.tangents[0].w;
    EXPECT_EQ(bitangent, vec3(0, 1, 0));
}

TEST(Tangents, QuadThatShowsItsPictureTurnedHasItsTangentTurned) {
    // A quarter turn clockwise: u runs down
    const TangentMesh mesh = Quad({{1, 1}, {1, 0}, {0, 0}, {0, 1}}).Tangents();
    for (const vec4& tangent : mesh.tangents)
        EXPECT_LT(glm::length(tangent - vec4(0, -1, 0, 1)), 1e-6f) << tangent.x << " " << tangent.y;
}

TEST(Tangents, MirroredPictureGivesTheOtherSign) {
    EXPECT_EQ(Quad(kMirrored).Tangents().tangents, std::vector<vec4>(4, vec4(-1, 0, 0, -1)));
    // v upwards: upside down
    EXPECT_EQ(Quad({{0, 0}, {1, 0}, {1, 1}, {0, 1}}).Tangents().tangents,
              std::vector<vec4>(4, vec4(1, 0, 0, -1)));
}

TEST(Tangents, VerticesOnASeamOfMirroredPicturesAreSplit) {
    // Two squares side by side, the second the mirror image of the first in position and uv
    Surface surface = Quad(kUpright);
    surface.positions.insert(surface.positions.end(), {{2, 0, 0}, {2, 1, 0}});
    surface.normals.resize(6, vec3(0, 0, 1));
    surface.uv.insert(surface.uv.end(), {{0, 1}, {0, 0}});
    surface.indices.insert(surface.indices.end(), {1, 4, 5, 1, 5, 2});
    const TangentMesh mesh = surface.Tangents();
    ExpectWellFormed(surface, mesh);
    EXPECT_EQ(mesh.sources.size(), 8u) << "two vertices on the seam";
    for (size_t i = 0; i < 12; ++i)
        EXPECT_EQ(mesh.tangents[mesh.indices[i]], i < 6 ? vec4(1, 0, 0, 1) : vec4(-1, 0, 0, -1)) << i;
}

TEST(Tangents, EqualVerticesShareTheirTangentAlthoughTheFileHasThemTwice) {
    // A fold along the y axis without shared indices: equal normals on it, so the tangent is the mean
    const float c = std::sqrt(0.5f);
    Surface fold{.positions = {{-1, 0, -1}, {0, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, -1}, {0, 1, 0}},
                 .normals = {{-c, 0, c}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {c, 0, c}, {0, 0, 1}},
                 .uv = {{0, 1}, {1, 1}, {1, 0}, {1, 1}, {2, 1}, {1, 0}},
                 .indices = {0, 1, 2, 3, 4, 5}};
    const TangentMesh mesh = fold.Tangents();
    ExpectWellFormed(fold, mesh);
    EXPECT_EQ(mesh.tangents[1], mesh.tangents[3]);
    EXPECT_EQ(mesh.tangents[2], mesh.tangents[5]);
    EXPECT_LT(glm::length(mesh.tangents[1] - vec4(1, 0, 0, 1)), 1e-6f);
    EXPECT_LT(glm::length(mesh.tangents[0] - vec4(c, 0, c, 1)), 1e-6f) << "its own triangle's alone";
    fold.normals[3] = vec3(0.6f, 0, 0.8f);
    const TangentMesh creased = fold.Tangents();
    EXPECT_NE(creased.tangents[1], creased.tangents[3]) << "a crease has two normals and two tangents";
}

TEST(Tangents, MeanIsWeightedByAnglesNotByAreasOrByTheNumberOfTriangles) {
    // Around the origin: one right angle whose u runs along +x, and another, cut in three, whose u is turned
    // by 20 degrees.
    Surface fan;
    const float turn = glm::radians(20.0f);
    const auto add = [&](const vec3& p, const vec2& uv) {
        fan.positions.push_back(p);
        fan.normals.push_back({0, 0, 1});
        fan.uv.push_back(uv);
        return static_cast<uint32_t>(fan.positions.size() - 1);
    };
    const uint32_t center = add({0, 0, 0}, {0, 0});
    const uint32_t first = add({5, 0, 0}, {5, 0});
    const uint32_t shared = add({0, 1, 0}, {0, -1});
    fan.indices.insert(fan.indices.end(), {center, first, shared});
    uint32_t last = shared;
    for (const float degrees : {120.0f, 150.0f, 180.0f}) {
        // The map that agrees with the first triangle's on the shared edge, and whose u runs along `turn`
        const vec3 p(std::cos(glm::radians(degrees)), std::sin(glm::radians(degrees)), 0);
        const float u = p.x / std::cos(turn);
        const uint32_t next = add(p, {u, u * std::sin(turn) - p.y});
        fan.indices.insert(fan.indices.end(), {center, last, next});
        last = next;
    }
    const TangentMesh mesh = fan.Tangents();
    ExpectWellFormed(fan, mesh);
    EXPECT_EQ(mesh.sources.size(), fan.positions.size());
    const vec4 expected(std::cos(0.5f * turn), std::sin(0.5f * turn), 0, 1);  // equal angles: the mean
    EXPECT_LT(glm::length(mesh.tangents[center] - expected), 1e-5f);
}

TEST(Tangents, GlobesTangentsRunEast) {
    const Surface globe = Globe(32);
    const TangentMesh mesh = globe.Tangents();
    ExpectWellFormed(globe, mesh);
    EXPECT_EQ(mesh.sources.size(), globe.positions.size()) << "nothing is mirrored, nothing is split";
    std::set<uint32_t> used(mesh.indices.begin(), mesh.indices.end());
    for (const uint32_t i : used) {
        const vec3 p = globe.positions[i];
        EXPECT_EQ(mesh.tangents[i].w, 1.0f);
        if (std::abs(p.y) > 0.95f) continue;  // at the poles the triangles' own longitudes count
        const vec3 east = glm::normalize(vec3(p.z, 0, -p.x));
        // Vertices on the seam have triangles on one side only: half a segment off
        const bool isSeam = globe.uv[i].x == 0.0f || globe.uv[i].x == 1.0f;
        EXPECT_GT(glm::dot(vec3(mesh.tangents[i]), east), isSeam ? 0.998f : 0.9999f) << p.y;
    }
}

TEST(Tangents, TriangleWithoutAreaInUvTakesItsNeighborsTangent) {
    Surface quad = Quad(kUpright);
    // A third triangle beyond the upper edge, all its uv on one line
    quad.positions.push_back({0.5f, 2, 0});
    quad.normals.push_back({0, 0, 1});
    quad.uv.push_back({0.5f, 0});
    quad.indices.insert(quad.indices.end(), {3, 2, 4});
    const TangentMesh mesh = quad.Tangents();
    ExpectWellFormed(quad, mesh);
    for (size_t i = 0; i < 4; ++i) EXPECT_EQ(mesh.tangents[i], vec4(1, 0, 0, 1));
    EXPECT_EQ(mesh.sources.size(), 5u) << "it joins its neighbor's groups";
}

TEST(Tangents, TriangleWithoutAreaInSpaceTakesATangentAtItsVertices) {
    Surface quad = Quad(kUpright);
    quad.indices.insert(quad.indices.end(), {1, 1, 2});
    const TangentMesh mesh = quad.Tangents();
    ExpectWellFormed(quad, mesh);
    EXPECT_EQ(mesh.sources.size(), 4u);
}

TEST(Tangents, UvOfNoUseGivesSomePerpendicular) {
    for (const vec3 normal : {vec3(1, 0, 0), vec3(0, 0, 1), glm::normalize(vec3(1, 2, 3))}) {
        Surface quad = Quad(std::vector<vec2>(4, vec2(0.5f)));
        quad.normals.assign(4, normal);
        ExpectWellFormed(quad, quad.Tangents());
    }
    Surface flat = Quad(kUpright);
    flat.normals.assign(4, vec3(1, 0, 0));  // the tangent is the normal
    ExpectWellFormed(flat, flat.Tangents());
    ExpectWellFormed({}, Surface{}.Tangents());
}

TEST(Tangents, NumbersOfAnySizeStayFinite) {
    std::mt19937 random(7);
    for (const float scale : {1e-38f, 1e-20f, 1.0f, 1e20f, 1e38f})
        for (const float uvScale : {1e-38f, 1.0f, 1e38f}) {
            Surface soup;
            std::uniform_real_distribution<float> value(-1.0f, 1.0f);
            for (uint32_t i = 0; i < 90; ++i) {
                soup.positions.push_back(scale * vec3(value(random), value(random), value(random)));
                soup.normals.push_back(glm::normalize(vec3(value(random), value(random), 1.5f)));
                soup.uv.push_back(uvScale * vec2(value(random), value(random)));
                soup.indices.push_back(static_cast<uint32_t>(random() % (i + 1)));
            }
            ExpectWellFormed(soup, soup.Tangents());
        }
}

TEST(Tangents, TimeIsNearlyLinearWhateverTheTopology) {
    // Measures processor time, not the clock: the machine may be busy
    const auto seconds = [](const Surface& surface) {
        const std::clock_t start = std::clock();
        ExpectWellFormed(surface, surface.Tangents());
        return double(std::clock() - start) / CLOCKS_PER_SEC;
    };
    EXPECT_LT(seconds(Globe(224)), 2.0) << "100,000 triangles";
    // 100,000 triangles about one vertex without a common edge; then all of them on one edge
    Surface star, book;
    const uint32_t count = 100000;
    for (uint32_t i = 0; i < 2 * count + 2; ++i) {
        const float a = float(i) * 1e-4f;
        star.positions.push_back({std::cos(a), std::sin(a), 0.0f});
        star.normals.push_back({0, 0, 1});
        star.uv.push_back({std::cos(a), (i & 2 ? 1.0f : -1.0f) * std::sin(a)});
    }
    star.positions[0] = vec3(0.0f);
    book = star;
    for (uint32_t i = 0; i < count; ++i) {
        star.indices.insert(star.indices.end(), {0, 2 * i + 1, 2 * i + 2});
        book.indices.insert(book.indices.end(), {i & 1, 1 - (i & 1), i + 2});
    }
    EXPECT_LT(seconds(star), 2.0);
    EXPECT_LT(seconds(book), 2.0);
}

// A surface whose vertices are split as its tangents want it.
Surface SplitFor(const Surface& surface, const TangentMesh& mesh) {
    Surface split{.positions = {}, .normals = {}, .uv = {}, .indices = mesh.indices};
    for (const uint32_t source : mesh.sources) {
        split.positions.push_back(surface.positions[source]);
        split.normals.push_back(surface.normals[source]);
        split.uv.push_back(surface.uv[source]);
    }
    return split;
}

TEST(MoveTangents, TurnsThemWithTheShape) {
    for (const Surface& surface : {Globe(8), Quad(kMirrored), Quad(kUpright)}) {
        const TangentMesh mesh = surface.Tangents();
        const Surface rest = SplitFor(surface, mesh);
        Surface turned = rest;
        const auto turn = [](const vec3& v) { return vec3(v.z, -v.x, -v.y); };
        for (vec3& position : turned.positions) position = 3.0f * turn(position) + vec3(1, 2, 3);
        for (vec3& normal : turned.normals) normal = turn(normal);
        const auto moves = [&](const Surface& moved) {
            return scene::MoveTangents({rest.positions, rest.normals}, {moved.positions, moved.normals},
                                       mesh.tangents, rest.uv, rest.indices);
        };
        const std::vector<vec3> none = moves(rest), all = moves(turned);
        ASSERT_EQ(all.size(), mesh.tangents.size());
        std::set<uint32_t> used(rest.indices.begin(), rest.indices.end());
        for (const uint32_t i : used) {
            const vec3 tangent(mesh.tangents[i]);
            EXPECT_LT(glm::length(none[i]), 1e-6f) << i;
            EXPECT_LT(glm::distance(tangent + all[i], turn(tangent)), 1e-5f) << i;
        }
    }
}

TEST(MoveTangents, StayWhereTheMovedImageHasNoDirection) {
    const Surface surface = Quad(kUpright);
    const TangentMesh mesh = surface.Tangents();
    const std::vector<vec3> point(4, vec3(1, 1, 1));
    for (const vec3& move :
         scene::MoveTangents({surface.positions, surface.normals}, {point, surface.normals}, mesh.tangents,
                             surface.uv, surface.indices))
        EXPECT_EQ(move, vec3(0.0f));
}

}  // namespace
}  // namespace raygraph::test::tangents_test

// Normal maps that are stored with two channels.
namespace raygraph::test::normal_maps_test {
namespace {

using Texels = std::vector<uint8_t>;

// Returns the imported texels of an image of two texels that a material uses in this way.
Texels Imported(const Texels& texels, const Json& material) {
    GltfDocument document;
    document.Add("images", {{"uri", DataUri(MakePngOf(2, 1, texels))}});
    document.Add("textures", {{"source", 0}});
    document.AddTriangle()["material"] = document.AddMaterial(material);
    return Load(document).images.at(0).rgba;
}

const Texels kTwoChannels{128, 128, 0, 255, 204, 76, 0, 255};
const Json kTexture{{"index", 0}};

TEST(NormalMaps, ThirdChannelIsMadeWhereThereIsNone) {
    // (0, 0) points up: 255; (0.6, -0.404): z = sqrt(1 - 0.36 - 0.1631) = 0.6905 is 216 of 255
    const Texels complete{128, 128, 255, 255, 204, 76, 216, 255};
    EXPECT_EQ(Imported(kTwoChannels, {{"normalTexture", kTexture}}), complete);
    const Json coat{{"extensions", {{"KHR_materials_clearcoat", {{"clearcoatNormalTexture", kTexture}}}}}};
    EXPECT_EQ(Imported(kTwoChannels, coat), complete);
}

TEST(NormalMaps, OthersStayAsTheyAre) {
    EXPECT_EQ(Imported(kTwoChannels, {{"emissiveTexture", kTexture}}), kTwoChannels);
    EXPECT_EQ(Imported(kTwoChannels, {{"normalTexture", kTexture}, {"occlusionTexture", kTexture}}),
              kTwoChannels);
    const Texels threeChannels{128, 128, 0, 255, 204, 76, 1, 255};
    EXPECT_EQ(Imported(threeChannels, {{"normalTexture", kTexture}}), threeChannels);
    // Longer than a unit: it lies in the surface
    EXPECT_EQ(Imported({255, 255, 0, 255, 128, 128, 0, 255}, {{"normalTexture", kTexture}}),
              (Texels{255, 255, 128, 255, 128, 128, 255, 255}));
}

}  // namespace
}  // namespace raygraph::test::normal_maps_test
