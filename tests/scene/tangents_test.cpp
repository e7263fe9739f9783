// Tangents that are generated where a file has none.
#include "renderer/scene/geometry/tangents.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <glm/gtc/constants.hpp>
#include <numeric>
#include <random>
#include <set>

#include "tests/scene/gltf_document.h"

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
