// Tangents that are generated where a file has none.
#include "renderer/scene/tangents.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <glm/gtc/constants.hpp>
#include <numeric>
#include <random>
#include <set>

#include "tests/scene/gltf_document.h"

namespace raygraph::test {
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
    // Of the processor, not of the clock: the machine may be busy
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

// A quad with a normal map, as a file.
GltfDocument QuadWithNormalMap(uint32_t texCoord) {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    primitive["attributes"]["TEXCOORD_0"] = document.AddAccessor<float>({0, 1, 1, 1, 0, 0}, 2);
    primitive["attributes"]["TEXCOORD_1"] = document.AddAccessor<float>({1, 1, 0, 1, 1, 0}, 2);
    document.Add("images", {{"uri", DataUri(MakePng(1, 1, {128, 128, 255, 255}))}});
    document.Add("textures", {{"source", 0}});
    primitive["material"] = document.AddMaterial({{"normalTexture", {{"index", 0}, {"texCoord", texCoord}}}});
    return document;
}

TEST(ImportTangents, AreMadeForTheTextureCoordinatesOfTheNormalMap) {
    const scene::SceneData first = Load(QuadWithNormalMap(0));
    EXPECT_EQ(OnlyPrimitive(first).tangents, std::vector<vec4>(3, vec4(1, 0, 0, 1)));
    const scene::SceneData second = Load(QuadWithNormalMap(1));
    EXPECT_EQ(OnlyPrimitive(second).tangents, std::vector<vec4>(3, vec4(-1, 0, 0, -1)));
}

// A transform may be edited or animated, so that it turns the frame where the map is read, not the tangents.
TEST(ImportTangents, TransformOfTheNormalMap_ChoosesTheSetAndTurnsNothing) {
    GltfDocument document = QuadWithNormalMap(0);
    Json& map = document.json["materials"][0]["normalTexture"];
    map["extensions"]["KHR_texture_transform"] = {{"rotation", glm::half_pi<double>()}};
    for (const Json& kept : {Json{{"rotation", glm::half_pi<double>()}}, Json{{"scale", {-1, 1}}}}) {
        map["extensions"]["KHR_texture_transform"] = kept;
        const scene::SceneData scene = Load(document);
        EXPECT_EQ(OnlyPrimitive(scene).tangents, std::vector<vec4>(3, vec4(1, 0, 0, 1)));
        EXPECT_EQ(OnlyPrimitive(scene).tangentTexCoord, 0u);
    }
    map["extensions"]["KHR_texture_transform"] = {{"texCoord", 1}};
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).tangents, std::vector<vec4>(3, vec4(-1, 0, 0, -1)));
    EXPECT_EQ(OnlyPrimitive(scene).tangentTexCoord, 1u);
}

// A map whose texture coordinates the primitive lacks determines no tangents; the next map does.
TEST(ImportTangents, MapWithoutCoordinates_LeavesThemToTheNext) {
    GltfDocument document = QuadWithNormalMap(1);
    document.json["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_1");
    EXPECT_TRUE(OnlyPrimitive(Load(document)).tangents.empty());
    document.json["materials"][0]["extensions"]["KHR_materials_clearcoat"] = {
        {"clearcoatFactor", 1}, {"clearcoatNormalTexture", {{"index", 0}}}};
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).tangents, std::vector<vec4>(3, vec4(1, 0, 0, 1)));
    EXPECT_EQ(OnlyPrimitive(scene).tangentTexCoord, 0u);
}

TEST(ImportTangents, AreLeftOutWithoutANormalMapOrItsTextureCoordinates) {
    GltfDocument document = QuadWithNormalMap(0);
    document.json["materials"][0] = Json::object();
    EXPECT_TRUE(OnlyPrimitive(Load(document)).tangents.empty());
    document = QuadWithNormalMap(0);
    document.json["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
    EXPECT_TRUE(OnlyPrimitive(Load(document)).tangents.empty());
}

// Stretched highlights lie along the tangents of the normal map; without one of their own texture, and without
// that of the first texture coordinates.
TEST(ImportTangents, AreMadeForAnisotropicMaterials) {
    const vec4 first(1, 0, 0, 1), second(-1, 0, 0, -1);
    const auto made = [](const Json& anisotropy, bool hasNormalMap) {
        GltfDocument document = QuadWithNormalMap(0);
        Json& material = document.json["materials"][0];
        if (!hasNormalMap) material = Json::object();
        material["extensions"]["KHR_materials_anisotropy"] = anisotropy;
        return OnlyPrimitive(Load(document)).tangents;
    };
    const Json texture{{"index", 0}, {"texCoord", 1}};
    EXPECT_EQ(made({{"anisotropyStrength", 0.5}}, false), std::vector<vec4>(3, first));
    EXPECT_EQ(made({{"anisotropyStrength", 0.5}, {"anisotropyTexture", texture}}, false),
              std::vector<vec4>(3, second));
    EXPECT_EQ(made({{"anisotropyStrength", 0.5}, {"anisotropyTexture", texture}}, true),
              std::vector<vec4>(3, first));
    EXPECT_TRUE(made({{"anisotropyTexture", texture}}, false).empty()) << "a strength of 0 wants none";
}

TEST(ImportTangents, GivenOnesAreUsed) {
    GltfDocument document = QuadWithNormalMap(0);
    document.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] =
        document.AddAccessor<float>({0, 1, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1}, 4);
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).tangents, std::vector<vec4>(3, vec4(0, 1, 0, -1)));
    EXPECT_EQ(OnlyPrimitive(scene).tangentTexCoord, scene::kNone);
}

TEST(ImportTangents, GivenOnesAreNotUsedWithNormalsThatAreMade) {
    GltfDocument document = QuadWithNormalMap(0);
    Json& attributes = document.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TANGENT"] = document.AddAccessor<float>({0, 1, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1}, 4);
    attributes.erase("NORMAL");
    EXPECT_EQ(OnlyPrimitive(Load(document)).tangents, std::vector<vec4>(3, vec4(1, 0, 0, 1)));
}

// The map of a coat reads the other set: frameTurns has the angle from the base's tangents to those of that
// set, if both are generated.
TEST(ImportTangents, MapOfTheOtherSet_HasAnglesToTheFirst) {
    GltfDocument document = QuadWithNormalMap(0);
    Json& primitive = document.json["meshes"][0]["primitives"][0];
    Json& coat = document.json["materials"][0]["extensions"]["KHR_materials_clearcoat"];
    coat = {{"clearcoatFactor", 1}, {"clearcoatNormalTexture", {{"index", 0}}}};
    EXPECT_TRUE(OnlyPrimitive(Load(document)).frameTurns.empty()) << "of the same set";
    coat["clearcoatNormalTexture"]["texCoord"] = 1;
    // u of the second set grows to the top, v grows to the right
    primitive["attributes"]["TEXCOORD_1"] = document.AddAccessor<float>({0, 0, 0, 1, 1, 0}, 2);
    const auto turned = [&] { return OnlyPrimitive(Load(document)).frameTurns; };
    EXPECT_EQ(turned(), std::vector<vec2>(3, vec2(0, 1)));
    EXPECT_EQ(OnlyPrimitive(Load(document)).tangents, std::vector<vec4>(3, vec4(1, 0, 0, 1)));
    primitive["attributes"]["TANGENT"] =
        document.AddAccessor<float>({0, 1, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1}, 4);
    EXPECT_TRUE(turned().empty()) << "given tangents are those of all maps";
    primitive["attributes"].erase("TANGENT");
    primitive["targets"] = {{{"POSITION", document.AddAccessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, 3)}}};
    EXPECT_TRUE(turned().empty()) << "targets change the angles";
}

// A vertex may have one tangent along the first set, and two along the second.
TEST(ImportTangents, MapOfTheOtherSet_SplitsVerticesOfTheFirst) {
    GltfDocument document = QuadWithNormalMap(0);
    Json& primitive = document.json["meshes"][0]["primitives"][0];
    document.json["materials"][0]["extensions"]["KHR_materials_clearcoat"] = {
        {"clearcoatFactor", 1}, {"clearcoatNormalTexture", {{"index", 0}, {"texCoord", 1}}}};
    primitive["attributes"] = {
        {"POSITION", document.AddAccessor<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0}, 3)},
        {"NORMAL", document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3)},
        {"TEXCOORD_0", document.AddAccessor<float>({0, 1, 1, 1, 1, 0, 2, 1}, 2)},
        {"TEXCOORD_1", document.AddAccessor<float>({0, 1, 1, 1, 1, 0, 0, 1}, 2)}};
    primitive["indices"] = document.AddAccessor<uint16_t>({0, 1, 2, 1, 3, 2}, 1);
    const scene::SceneData scene = Load(document);
    const scene::Primitive& loaded = OnlyPrimitive(scene);
    ASSERT_EQ(loaded.positions.size(), 6u);
    EXPECT_EQ(loaded.tangents, std::vector<vec4>(6, vec4(1, 0, 0, 1)));
    ASSERT_EQ(loaded.frameTurns.size(), 6u);
    for (size_t i = 0; i < 6; ++i)
        EXPECT_EQ(loaded.frameTurns[loaded.indices[i]], i < 3 ? vec2(1, 0) : vec2(-1, 0));
}

TEST(ImportTangents, SplitVerticesKeepTheirOtherAttributes) {
    GltfDocument document = QuadWithNormalMap(0);
    Json& primitive = document.json["meshes"][0]["primitives"][0];
    // Two triangles on one edge whose pictures mirror each other
    primitive["attributes"] = {
        {"POSITION", document.AddAccessor<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0}, 3)},
        {"NORMAL", document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3)},
        {"TEXCOORD_0", document.AddAccessor<float>({0, 1, 1, 1, 1, 0, 0, 1}, 2)},
        {"TEXCOORD_1", document.AddAccessor<float>({1, 2, 3, 4, 5, 6, 7, 8}, 2)},
        {"COLOR_0", document.AddAccessor<float>({0, 0, 0, 0.25f, 0, 0, 0.5f, 0, 0, 0.75f, 0, 0}, 3)}};
    primitive["indices"] = document.AddAccessor<uint16_t>({0, 1, 2, 1, 3, 2}, 1);
    const scene::SceneData scene = Load(document);
    const scene::Primitive& loaded = OnlyPrimitive(scene);
    ASSERT_EQ(loaded.positions.size(), 6u);
    for (size_t size : {loaded.normals.size(), loaded.uv0.size(), loaded.uv1.size(), loaded.colors.size(),
                        loaded.tangents.size()})
        EXPECT_EQ(size, 6u);
    const std::vector<uint32_t> file{0, 1, 2, 1, 3, 2};
    for (size_t i = 0; i < 6; ++i) {
        const uint32_t vertex = loaded.indices[i];
        EXPECT_EQ(loaded.positions[vertex], loaded.positions[file[i]]);
        EXPECT_EQ(loaded.uv1[vertex], vec2(float(2 * file[i] + 1), float(2 * file[i] + 2)));
        EXPECT_EQ(loaded.colors[vertex].x, 0.25f * float(file[i]));
        EXPECT_EQ(loaded.tangents[vertex].w, i < 3 ? 1.0f : -1.0f);
    }
}

}  // namespace
}  // namespace raygraph::test
