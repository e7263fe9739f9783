// Our own trees: their structure, and rays that leave surfaces.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <numeric>
#include <random>

#include "core/frame.glsl"
#include "core/ray_offset.glsl"
#include "renderer/bvh/wide_bvh.h"
#include "renderer/bvh/wide_scene.h"
#include "tests/shading/random_values.h"
#include "tests/support/triangle_soup.h"

// Own trees traversed on the host, by the text that the device runs.
namespace raygraph::shading {

inline thread_local const WideScene* s_scene = nullptr;
inline thread_local glm::uvec2 s_stack[gpu::kWideStackSize];
inline thread_local std::function<bool(const gpu::WideHit&, bool isBack, bool isAny)> s_isAccepted;

template <typename T>
glm::uvec4 WordOf(const std::vector<T>& records, uint32_t at) {
    glm::uvec4 word;
    std::memcpy(&word, reinterpret_cast<const std::byte*>(records.data()) + 16 * size_t{at}, 16);
    return word;
}
inline glm::uvec4 WideNodeWord(uint32_t at) {
    return WordOf(s_scene->nodes, at);
}
inline glm::uvec4 WideTriangleWord(uint32_t at) {
    return WordOf(s_scene->triangles, at);
}
inline glm::uvec4 WideInstanceWord(uint32_t at) {
    return WordOf(s_scene->instances, at);
}
inline void PushGroup(uint32_t at, glm::uvec2 group) {
    ASSERT_LT(at, gpu::kWideStackSize);
    s_stack[at] = group;
}
inline glm::uvec2 GroupAt(uint32_t at) {
    return s_stack[at];
}
inline bool IsAccepted(const gpu::WideHit& hit, bool isBack, bool isAny) {
    return s_isAccepted(hit, isBack, isAny);
}

}  // namespace raygraph::shading

#include "scene/wide_bvh.glsl"

namespace raygraph {

// A scene whose only instance is none has one level.
inline gpu::WideHit Traverse(const WideScene& scene, const gpu::BenchRay& ray, bool isAny) {
    shading::s_scene = &scene;
    gpu::WideCounts counts{};
    const bool hasOneLevel = scene.instances.size() == 1;
    return shading::TraverseWide(ray.origin, ray.direction, ray.tMax, isAny, hasOneLevel, counts);
}

}  // namespace raygraph

// The wide tree: what its builder promises, and its traversal, the text that the device runs, against all
// triangles one after the other.
namespace raygraph::wide_bvh_test {
namespace {

using testing::BuildWideMesh;
using testing::BuildWideScene;
using testing::RandomRays;
using testing::TriangleBoxes;
using testing::TriangleSoup;

// Checks a subtree, and appends its primitives.
void CheckSubtree(const BinaryBvh& tree, std::span<const Box> boxes, uint32_t index,
                  std::vector<uint32_t>& found) {
    const BinaryNode& node = tree.nodes[index];
    Box box;
    if (node.IsLeaf()) {
        ASSERT_EQ(node.left, found.size()) << "leaves are in order";
        found.push_back(tree.order[node.left]);
        box = boxes[found.back()];
    } else {
        for (const uint32_t child : {node.left, node.right}) {
            ASSERT_GT(child, index) << "children come after their parents";
            CheckSubtree(tree, boxes, child, found);
            box.Extend(tree.nodes[child].box);
        }
    }
    EXPECT_EQ(box.min, node.box.min) << index;
    EXPECT_EQ(box.max, node.box.max) << index;
}

void ExpectEachOnce(std::vector<uint32_t> found, size_t count) {
    std::ranges::sort(found);
    ASSERT_EQ(found.size(), count);
    for (uint32_t i = 0; i < count; ++i) ASSERT_EQ(found[i], i);
}

bool Contains(const Box& outer, const Box& inner) {
    return glm::all(glm::lessThanEqual(outer.min, inner.min)) &&
           glm::all(glm::greaterThanEqual(outer.max, inner.max));
}

// Checks that every child's stored box contains the primitives below it; returns these.
std::vector<uint32_t> CheckWide(const WideBvh& tree, std::span<const Box> boxes, uint32_t index) {
    const gpu::WideNode& node = tree.nodes[index];
    std::vector<uint32_t> all;
    uint32_t inner = node.firstChild;
    for (uint32_t slot = 0; slot < gpu::kWideChildren; ++slot) {
        const uint32_t meta = WideMeta(node, slot);
        if (meta == 0u) continue;
        std::vector<uint32_t> below;
        if (IsWideNode(node, slot)) {
            EXPECT_EQ(meta, 0x20u | (24 + slot));
            EXPECT_GT(inner, index);
            below = CheckWide(tree, boxes, inner++);
        } else {
            for (uint32_t i = 0; meta >> (5 + i) != 0u; ++i) {
                EXPECT_EQ(meta >> (5 + i) & 1u, 1u);
                below.push_back(tree.primitives.at(node.firstPrimitive + (meta & 0x1Fu) + i));
            }
        }
        for (const uint32_t primitive : below)
            EXPECT_TRUE(Contains(WideChildBox(node, slot), boxes[primitive])) << index << ", slot " << slot;
        all.insert(all.end(), below.begin(), below.end());
    }
    return all;
}

std::vector<BvhMesh> Meshes() {
    BvhMesh flat = TriangleSoup(40, 0.3f, 3), same, one = TriangleSoup(1, 1.0f, 4);
    for (glm::vec3& position : flat.positions) position.y = 2.5f;
    for (uint32_t i = 0; i < 25; ++i) same.indices.insert(same.indices.end(), {0, 1, 2});
    same.positions = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    return {TriangleSoup(1000, 0.1f, 1), TriangleSoup(20000, 0.02f, 2), flat, same, one};
}

TEST(BinaryBvh, EveryPrimitiveIsInOneLeafAndBoxesFit) {
    for (const BvhMesh& mesh : Meshes()) {
        const std::vector<Box> boxes = TriangleBoxes(mesh);
        const BinaryBvh tree = BuildBinaryBvh(boxes);
        EXPECT_EQ(tree.nodes.size(), 2 * boxes.size() - 1);
        std::vector<uint32_t> found;
        CheckSubtree(tree, boxes, 0, found);
        ExpectEachOnce(found, boxes.size());
    }
}

// Meshes whose tree would be too deep have parts of which each is half as small as the one before.
TEST(WideBvh, DeepTreesAreBalanced) {
    BvhMesh mesh;
    for (uint32_t i = 0; i < 140; ++i)
        for (const glm::vec3& corner : {glm::vec3(0, 0, 0), glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)}) {
            mesh.indices.push_back(static_cast<uint32_t>(mesh.positions.size()));
            mesh.positions.push_back(std::ldexp(1.0f, -static_cast<int>(i)) * (corner + glm::vec3(1.0f)));
        }
    const std::vector<Box> boxes = TriangleBoxes(mesh);
    const BinaryBvh tree = BuildBinaryBvh(boxes, {.isBalanced = true});
    std::vector<uint32_t> found;
    CheckSubtree(tree, boxes, 0, found);
    ExpectEachOnce(found, boxes.size());
    const WideMesh wide = BuildWideMesh(mesh);
    EXPECT_LE(wide.depth, kMaxMeshDepth);
    EXPECT_EQ(wide.triangles.size(), 140u);
}

TEST(WideBvh, EveryPrimitiveIsInOneLeafAndStoredBoxesContainIt) {
    for (const BvhMesh& mesh : Meshes()) {
        const std::vector<Box> boxes = TriangleBoxes(mesh);
        const WideBvh tree = CollapseToWide(BuildBinaryBvh(boxes));
        ExpectEachOnce(CheckWide(tree, boxes, 0), boxes.size());
        // Nodes have six children in the mean, and more where there are many
        if (boxes.size() >= 1000) {
            EXPECT_LT(tree.nodes.size(), boxes.size() / 4);
        }
    }
}

// Dynamic programming never costs more than what it may choose: three primitives a leaf, eight children a node.
TEST(WideBvh, CostIsBelowThatOfTheBinaryTree) {
    const BinaryBvh tree = BuildBinaryBvh(TriangleBoxes(TriangleSoup(5000, 0.1f, 6)));
    EXPECT_LT(CollapseToWide(tree).sahCost, 0.5 * tree.SahCost());
}

TEST(WideBvh, WithoutPrimitivesIsOneEmptyNode) {
    const WideBvh tree = CollapseToWide(BuildBinaryBvh({}));
    ASSERT_EQ(tree.nodes.size(), 1u);
    for (uint32_t slot = 0; slot < gpu::kWideChildren; ++slot) EXPECT_EQ(WideMeta(tree.nodes[0], slot), 0u);
}

// Primitives that have moved: the nodes hold them, and are the same by whatever way they came there.
TEST(WideRefit, BoxesFollowWhatMovesWhateverCameBetween) {
    std::vector<Box> boxes = TriangleBoxes(TriangleSoup(3000, 0.1f, 5));
    WideBvh tree = CollapseToWide(BuildBinaryBvh(boxes));
    const auto bytes = [&] {
        const auto* first = reinterpret_cast<const char*>(tree.nodes.data());
        return std::string(first, tree.nodes.size() * sizeof(gpu::WideNode));
    };
    const auto boxOf = [&](uint32_t place) { return boxes[tree.primitives[place]]; };
    std::vector<uint32_t> all(boxes.size());
    std::iota(all.begin(), all.end(), 0u);
    WideRefit refit(tree.nodes, boxOf);
    const std::string made = bytes();
    EXPECT_EQ(refit.Refit(tree.nodes, all, boxOf).size(), tree.nodes.size());
    EXPECT_EQ(bytes(), made) << "as the builder stores them";
    EXPECT_DOUBLE_EQ(refit.Decay(), 1.0);

    const auto move = [&](std::span<const uint32_t> places, const glm::vec3& by) {
        for (const uint32_t place : places) {
            Box& box = boxes[tree.primitives[place]];
            box = {box.min + by, box.max + by};
        }
        return refit.Refit(tree.nodes, places, boxOf);
    };
    const std::vector<uint32_t> one{17}, some{17, 4, 2000, 2001, 100};
    EXPECT_LE(move(one, {0.5f, 0, 0}).size(), tree.depth);
    ExpectEachOnce(CheckWide(tree, boxes, 0), boxes.size());
    move(some, {0, 8.0f, 0});
    ExpectEachOnce(CheckWide(tree, boxes, 0), boxes.size());
    EXPECT_GT(refit.Decay(), 1.0);
    const std::string there = bytes();
    move(some, {0, 0, -64.0f});
    move(one, {16.0f, 0, 0});
    EXPECT_NE(bytes(), there);
    move(one, {-16.0f, 0, 0});
    move(some, {0, 0, 64.0f});
    EXPECT_EQ(bytes(), there);
    // All boxes are in one place: their spatial order is lost
    for (Box& box : boxes) box = {glm::vec3(0.0f), glm::vec3(1.0f)};
    refit.Refit(tree.nodes, all, boxOf);
    ExpectEachOnce(CheckWide(tree, boxes, 0), boxes.size());
    EXPECT_GT(refit.Decay(), 3.0);
}

class WideLevels : public ::testing::TestWithParam<uint32_t> {
  protected:
    static WideScene Build(const BvhScene& scene) {
        return GetParam() == 1 ? BuildOneLevel(scene) : BuildWideScene(scene);
    }
};
INSTANTIATE_TEST_SUITE_P(WideTraversal, WideLevels, ::testing::Values(1u, 2u));

TEST_P(WideLevels, FindTheNearestOfAllTriangles) {
    const BvhScene scene = testing::InstancedTriangleSoup();
    const WideScene wide = Build(scene);
    uint32_t hits = 0, differences = 0;
    const std::vector<gpu::BenchRay> rays = RandomRays(2000, 7);
    for (const gpu::BenchRay& ray : rays) {
        const gpu::WideHit hit = Traverse(wide, ray, false);
        const ExactHit exact = TraceExactly(scene, ray);
        if (exact.isAmbiguous) continue;
        hits += exact.t >= 0.0 ? 1 : 0;
        if (exact.t < 0.0) {
            EXPECT_LT(hit.t, 0.0f);
            continue;
        }
        ASSERT_GE(hit.t, 0.0f);
        EXPECT_NEAR(double{hit.t}, exact.t, 1e-4 * exact.t);
        if (hit.instance != exact.instance || hit.primitive != exact.primitive) {
            ++differences;
            continue;
        }
        const BvhMesh& mesh = scene.meshes[scene.instances[hit.instance].mesh];
        const auto corner = [&](uint32_t i) { return mesh.positions[mesh.indices[3 * hit.primitive + i]]; };
        const glm::vec3 inObject = corner(0) + hit.barycentrics.x * (corner(1) - corner(0)) +
                                   hit.barycentrics.y * (corner(2) - corner(0));
        const glm::vec3 point = scene.instances[hit.instance].objectToWorld * glm::vec4(inObject, 1.0f);
        EXPECT_LT(glm::distance(point, ray.origin + hit.t * ray.direction), 1e-4f);
    }
    EXPECT_GT(hits, rays.size() / 4);
    EXPECT_LT(hits, rays.size());
    EXPECT_EQ(differences, 0u);
}

TEST_P(WideLevels, AnyHitIsWhetherSomethingIsNearer) {
    const BvhScene scene = testing::InstancedTriangleSoup();
    const WideScene wide = Build(scene);
    uint32_t hits = 0;
    std::vector<gpu::BenchRay> rays = RandomRays(2000, 8);
    for (gpu::BenchRay& ray : rays) {
        ray.tMax = 0.8f;
        const ExactHit exact = TraceExactly(scene, ray);
        if (exact.isAmbiguous) continue;
        EXPECT_EQ(Traverse(wide, ray, true).t >= 0.0f, exact.t >= 0.0);
        hits += exact.t >= 0.0 ? 1 : 0;
    }
    EXPECT_GT(hits, rays.size() / 10);
    EXPECT_LT(hits, rays.size() / 2);
}

// A quad in the plane z = 0, whose front faces +z, placed; in two levels, and in one.
std::array<WideScene, 2> PlacedQuad(const glm::mat4x3& objectToWorld, uint32_t flags) {
    WideMesh mesh = BuildWideMesh(
        {.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, .indices = {0, 1, 2, 0, 2, 3}});
    WideInstances instances =
        BuildWideInstances(std::vector<WidePlacement>{{objectToWorld, mesh.box, 0, 7, flags}});
    const WideMesh level =
        BuildWideLevel(std::vector<PlacedTriangles>{{mesh.triangles, objectToWorld, 7, flags}}).mesh;
    WideScene scene{.nodes = mesh.nodes, .triangles = mesh.triangles, .instances = instances.instances};
    scene.instances[0].root = static_cast<uint32_t>(scene.nodes.size());
    // One instance is none and stands for one level: another one is added, which nothing leads to
    if (scene.instances.size() == 1) scene.instances.emplace_back();
    MoveNodes(instances.nodes, scene.instances[0].root, 0);
    scene.nodes.insert(scene.nodes.end(), instances.nodes.begin(), instances.nodes.end());
    return {scene, {.nodes = level.nodes, .triangles = level.triangles, .instances = {{}}}};
}

glm::mat4x3 Scaling(float x, float y, float z) {
    return {glm::vec3(x, 0, 0), glm::vec3(0, y, 0), glm::vec3(0, 0, z), glm::vec3(0.0f)};
}

// Traces from +z and from -z, in the plane of the quad a step from its center, so that both triangles are
// met.
std::array<bool, 2> Seen(const std::array<WideScene, 2>& scenes) {
    std::array<std::array<bool, 2>, 2> seen{};
    for (const float side : {1.0f, -1.0f})
        for (size_t i = 0; i < 2; ++i) {
            const gpu::WideHit hit = Traverse(
                scenes[i], {.origin = {0.1f, 0.3f, 3.0f * side}, .tMax = 10.0f, .direction = {0, 0, -side}},
                false);
            seen[i][side > 0.0f ? 0 : 1] = hit.t >= 0.0f;
            if (hit.t < 0.0f) continue;
            EXPECT_NEAR(hit.t, 3.0f, 1e-6f);
            EXPECT_EQ(hit.instance, 7u);
        }
    EXPECT_EQ(seen[0], seen[1]) << "two levels, and one";
    return seen[0];
}

TEST(WideTraversal, BackFacesAreCulledWhereTheInstanceSaysSo) {
    const std::array<bool, 2> kBoth{true, true}, kFront{true, false}, kBack{false, true};
    EXPECT_EQ(Seen(PlacedQuad(glm::mat4x3(1.0f), 0)), kBoth);
    EXPECT_EQ(Seen(PlacedQuad(glm::mat4x3(1.0f), gpu::kWideBackCulled)), kFront);
    // A face keeps its side under a mirroring transform
    EXPECT_EQ(Seen(PlacedQuad(Scaling(-1, 1, 1), gpu::kWideBackCulled)), kFront);
    EXPECT_EQ(Seen(PlacedQuad(Scaling(1, 1, -1), gpu::kWideBackCulled)), kBack);
    EXPECT_EQ(Seen(PlacedQuad(Scaling(-2, -3, 0.5f), gpu::kWideBackCulled)), kFront);
}

// Flat instances have no inverse. No ray meets them, as with the driver, and the others are not affected.
TEST(WideTraversal, FlatInstancesAreNotThere) {
    EXPECT_EQ(Seen(PlacedQuad(Scaling(1, 1, 0), 0)), (std::array<bool, 2>{false, false}));
}

TEST(WideTraversal, TestedTrianglesAreAskedForOnceEach) {
    const std::array<WideScene, 2> scenes = PlacedQuad(Scaling(1, -1, 1), gpu::kWideTested);
    const gpu::BenchRay ray{.origin = {0.1f, 0.3f, 3.0f}, .tMax = 10.0f, .direction = {0, 0, -1}};
    for (uint32_t i = 0; i < 8; ++i) {
        const bool isAny = (i & 1u) != 0, isHit = (i & 2u) != 0;
        const WideScene& scene = scenes[i >> 2];
        uint32_t asked = 0;
        shading::s_isAccepted = [&](const gpu::WideHit& hit, bool isBack, bool ofAny) {
            ++asked;
            EXPECT_NEAR(hit.t, 3.0f, 1e-6f);
            EXPECT_EQ(hit.instance, 7u);
            EXPECT_FALSE(isBack);
            EXPECT_EQ(ofAny, isAny);
            return isHit;
        };
        EXPECT_EQ(Traverse(scene, ray, isAny).t >= 0.0f, isHit);
        EXPECT_EQ(asked, 1u);
    }
}

TEST(WideTraversal, TrianglesWithoutAnAreaAreNotThere) {
    BvhScene scene;
    scene.meshes.push_back({{{0, 0, 0}, {1, 1, 0}, {0.5f, 0.5f, 0}, {0, 0, 0}}, {0, 1, 2, 0, 3, 1, 1, 1, 1}});
    scene.instances.push_back({});
    const WideScene wide = BuildWideScene(scene);
    for (const gpu::BenchRay& ray : RandomRays(1000, 5)) {
        gpu::BenchRay at = ray;
        at.direction = glm::vec3(0.25f, 0.25f, 0.0f) - ray.origin;
        EXPECT_LT(Traverse(wide, at, false).t, 0.0f);
    }
}

// Neither they nor what reaches too far take others with them, wherever they stand among them.
TEST(WideTraversal, InstancesThatNoRayMeetsLeaveTheOthers) {
    BvhMesh quad{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {0, 1, 2, 0, 2, 3}};
    const BvhMesh point{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {0, 1, 2}};
    const glm::mat4x3 turned(glm::rotate(glm::mat4(1.0f), 1.0f, glm::vec3(0.3f, 0.5f, 0.8f)));
    glm::mat4x3 farAway(1.0f);
    farAway[0] = farAway[1] = farAway[2] = glm::vec3(0.0f);
    for (int axis = 0; axis < 3; ++axis) farAway[axis][axis] = 1e19f;
    for (const auto& [mesh, objectToWorld] :
         {std::pair{1u, glm::mat4x3(1.0f)}, std::pair{1u, turned}, std::pair{0u, farAway}})
        for (uint32_t place = 0; place < 4; ++place) {
            BvhScene scene;
            scene.meshes = {quad, point};
            for (uint32_t i = 0; i < 3; ++i) {
                if (i == place) scene.instances.push_back({mesh, objectToWorld});
                glm::mat4x3 at(1.0f);
                at[3] = glm::vec3(3.0f * float(i), 0.0f, 0.0f);
                scene.instances.push_back({0, at});
            }
            if (place == 3) scene.instances.push_back({mesh, objectToWorld});
            for (const WideScene& wide : {BuildWideScene(scene), BuildOneLevel(scene)})
                for (uint32_t i = 0; i < 3; ++i) {
                    const gpu::BenchRay ray{.origin = {3.0f * float(i) + 0.1f, 0.3f, 3.0f},
                                            .tMax = 10.0f,
                                            .direction = {0, 0, -1}};
                    const gpu::WideHit hit = Traverse(wide, ray, false);
                    EXPECT_NEAR(hit.t, 3.0f, 1e-6f) << place << " " << i;
                    EXPECT_EQ(hit.instance, i + (place <= i ? 1 : 0)) << place << " " << i;
                }
        }
}

// A sphere with bumps: closed, each vertex is shared.
BvhMesh ClosedBody(uint32_t rings, uint32_t sectors) {
    BvhMesh mesh;
    mesh.positions.push_back({0, 1, 0});
    for (uint32_t ring = 1; ring < rings; ++ring)
        for (uint32_t sector = 0; sector < sectors; ++sector) {
            const float a = glm::pi<float>() * float(ring) / float(rings);
            const float b = glm::two_pi<float>() * float(sector) / float(sectors);
            const float radius = 1.0f + 0.1f * std::sin(5.0f * a) * std::sin(3.0f * b);
            mesh.positions.push_back(
                radius * glm::vec3(std::sin(a) * std::cos(b), std::cos(a), std::sin(a) * std::sin(b)));
        }
    mesh.positions.push_back({0, -1, 0});
    const auto at = [&](uint32_t ring, uint32_t sector) {
        return ring == 0 ? 0
                         : (ring == rings ? 1 + (rings - 1) * sectors
                                          : 1 + (ring - 1) * sectors + sector % sectors);
    };
    for (uint32_t ring = 0; ring < rings; ++ring)
        for (uint32_t sector = 0; sector < sectors; ++sector) {
            const uint32_t a = at(ring, sector), b = at(ring, sector + 1), c = at(ring + 1, sector),
                           d = at(ring + 1, sector + 1);
            if (a != b) mesh.indices.insert(mesh.indices.end(), {a, b, d});
            if (c != d) mesh.indices.insert(mesh.indices.end(), {a, d, c});
        }
    return mesh;
}

// Rays start inside, at the very edges and vertices.
TEST_P(WideLevels, NoRayLeavesAClosedBody) {
    BvhScene scene;
    scene.meshes = {ClosedBody(24, 40)};
    scene.instances.push_back({0, glm::mat4x3(1.0f)});
    scene.instances[0].objectToWorld[3] = glm::vec3(0.3f, -0.2f, 0.1f);
    const WideScene wide = Build(scene);
    const BvhMesh& mesh = scene.meshes[0];
    std::mt19937 random(3);
    const auto unit = [&] { return float(random() >> 8) / 16777216.0f; };
    uint32_t leaks = 0;
    for (uint32_t i = 0; i < 200000; ++i) {
        const auto triangle = static_cast<uint32_t>(random() % mesh.TriangleCount());
        const auto edge = static_cast<uint32_t>(random() % 3);
        const glm::vec3 a = mesh.positions[mesh.indices[3 * triangle + edge]];
        const glm::vec3 b = mesh.positions[mesh.indices[3 * triangle + (edge + 1) % 3]];
        const float share = i % 4 == 0 ? 0.0f : unit();
        const glm::vec3 target = glm::mix(a, b, share) + scene.instances[0].objectToWorld[3];
        const glm::vec3 origin =
            0.4f * (2.0f * glm::vec3(unit(), unit(), unit()) - 1.0f) + scene.instances[0].objectToWorld[3];
        const gpu::BenchRay ray{.origin = origin, .tMax = 1e30f, .direction = target - origin};
        if (Traverse(wide, ray, i % 2 == 0).t < 0.0f) ++leaks;
    }
    EXPECT_EQ(leaks, 0u);
}

// Rays along the axes, on triangles without extent in one of them.
TEST_P(WideLevels, FlatTrianglesAndAxisParallelRays) {
    BvhScene scene;
    BvhMesh& grid = scene.meshes.emplace_back();
    constexpr uint32_t kSide = 16;
    for (uint32_t y = 0; y <= kSide; ++y)
        for (uint32_t x = 0; x <= kSide; ++x) grid.positions.push_back({float(x), 0.0f, float(y)});
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            const uint32_t a = y * (kSide + 1) + x, b = a + 1, c = a + kSide + 1, d = c + 1;
            grid.indices.insert(grid.indices.end(), {a, b, c, b, d, c});
        }
    scene.instances.push_back({0, glm::mat4x3(1.0f)});
    const WideScene wide = Build(scene);
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            const gpu::BenchRay ray{.origin = {float(x) + 0.25f, 3.0f, float(y) + 0.25f},
                                    .tMax = 1e30f,
                                    .direction = {0.0f, -1.0f, 0.0f}};
            const gpu::WideHit hit = Traverse(wide, ray, false);
            ASSERT_NEAR(hit.t, 3.0f, 1e-6f);
            EXPECT_EQ(hit.primitive, 2 * (y * kSide + x));
        }
}

}  // namespace
}  // namespace raygraph::wide_bvh_test

// The distance at which rays leave a triangle: that of its rounding, in the world and as every traversal has it.
namespace raygraph::shading::ray_clearance_test {
namespace {

// A placed triangle, and a point of it as scene/surface.glsl computes it.
struct Placed {
    mat3 linear{1.0f};
    vec3 translation{0.0f};
    vec3 p0{0.0f}, e1{0.0f}, e2{0.0f};
    vec2 weights{0.0f};

    vec3 ObjectPoint() const { return p0 + weights.x * e1 + weights.y * e2; }
    vec3 Point() const { return linear * ObjectPoint() + translation; }
    float Clearance() const { return RayClearance(linear, translation, p0, e1, e2, ObjectPoint()); }
    vec3 Normal() const {
        const vec3 n = cross(e1, e2);
        return normalize(n.x * cross(linear[1], linear[2]) + n.y * cross(linear[2], linear[0]) +
                         n.z * cross(linear[0], linear[1]));
    }
};

glm::dvec3 Double(vec3 v) {
    return glm::dvec3(v);
}

glm::dmat3 Double(const mat3& m) {
    return {Double(m[0]), Double(m[1]), Double(m[2])};
}

// Meters of `place` above the plane of the exact triangle, on the side of the normal.
double HeightAbove(const Placed& placed, const glm::dvec3& place) {
    const glm::dmat3 linear = Double(placed.linear);
    const glm::dvec3 normal = glm::normalize(glm::transpose(glm::inverse(linear)) *
                                             glm::cross(Double(placed.e1), Double(placed.e2))) *
                              (glm::determinant(linear) < 0.0 ? -1.0 : 1.0);
    return glm::dot(normal, place - (linear * Double(placed.p0) + Double(placed.translation)));
}

// Returns where a device puts the origin that inverts the transform in float and transforms the ray's origin
// to object space in float, transformed back to the world without further error.
glm::dvec3 AsDeviceHasIt(const Placed& placed, vec3 origin) {
    const glm::mat4 matrix(glm::vec4(placed.linear[0], 0.0f), glm::vec4(placed.linear[1], 0.0f),
                           glm::vec4(placed.linear[2], 0.0f), glm::vec4(placed.translation, 1.0f));
    const glm::mat4 inverse = glm::inverse(matrix);
    const vec3 inObject = vec3(inverse[0]) * origin.x + vec3(inverse[1]) * origin.y +
                          vec3(inverse[2]) * origin.z + vec3(inverse[3]);
    return Double(placed.linear) * Double(inObject) + Double(placed.translation);
}

mat3 RandomLinear(Uniform& generator, int kind) {
    if (kind == 0) return mat3(1.0f);
    const Frame turn = FrameFromZ(generator.Direction());
    const float angle = 6.0f * generator();
    const vec3 x = std::cos(angle) * turn.x + std::sin(angle) * turn.y;
    mat3 linear(x, cross(turn.z, x), turn.z);
    if (kind == 1) return linear;
    for (int i = 0; i < 3; ++i) linear[i] *= std::exp(2.0f * generator() - 1.0f);
    if (kind == 3) linear[0] = linear[0] + 0.5f * linear[1];  // sheared
    if (kind == 4) linear[2] = -linear[2];                    // mirrored
    return linear;
}

// A triangle of `extent` meters, `far` from its object's origin, at `near` from the world's.
Placed RandomTriangle(Uniform& generator, int kind, float extent, float far, float near) {
    Placed placed;
    placed.linear = RandomLinear(generator, kind);
    placed.p0 = far * generator.Direction() + extent * generator.Direction();
    placed.e1 = (placed.p0 + extent * generator.Direction()) - placed.p0;
    placed.e2 = (placed.p0 + extent * generator.Direction()) - placed.p0;
    placed.translation = near * generator.Direction() - placed.linear * placed.p0;
    const float b1 = std::sqrt(generator());
    placed.weights = vec2(b1, (1.0f - b1) * generator());
    return placed;
}

TEST(RayClearance, LeavesTheSurfaceInTheWorldAndAsTheDeviceHasIt) {
    struct Place {
        float extent, far, near;
    };
    Uniform generator(3);
    // Tiny things, rooms, towns, vertices and nodes that cancel, and what is far off
    for (const Place& place :
         {Place{0.001f, 0.01f, 0.01f}, Place{1.0f, 1.0f, 10.0f}, Place{1.0f, 1000.0f, 1.0f},
          Place{0.1f, 300.0f, 300.0f}, Place{100.0f, 1.0f, 10000.0f}, Place{1.0f, 1e5f, 10.0f},
          Place{1e4f, 1e6f, 1e6f}}) {
        for (int kind = 0; kind < 5; ++kind) {
            int behindCount = 0;
            double largest = 0.0;  // clearance over the size of a float step of the largest coordinate
            for (int i = 0; i < 20'000; ++i) {
                const Placed placed = RandomTriangle(generator, kind, place.extent, place.far, place.near);
                const float area = length(cross(placed.e1, placed.e2));
                if (area < 0.05f * place.extent * place.extent)
                    continue;  // slivers have a bound of their own
                const float clearance = placed.Clearance();
                for (const float side : {1.0f, -1.0f}) {
                    const vec3 origin = OffsetRayOrigin(placed.Point(), side * placed.Normal(), clearance);
                    if (!(side * HeightAbove(placed, Double(origin)) > 0.0)) ++behindCount;
                    if (!(side * HeightAbove(placed, AsDeviceHasIt(placed, origin)) > 0.0)) ++behindCount;
                }
                const double size = length(placed.Point()) + length(placed.translation) +
                                    length(placed.linear * placed.p0) + place.extent;
                largest = std::max(largest, double{clearance} / (size * 0x1p-23));
            }
            EXPECT_EQ(behindCount, 0)
                << place.extent << ' ' << place.far << ' ' << place.near << ", " << kind;
            // Rotations add up to the root of 3 on each axis, there and back; scale and shear some more
            EXPECT_LT(largest, kind == 0 ? 12.0 : 80.0) << place.far << ' ' << place.near << ", " << kind;
        }
    }
}

// The bound is made of what was rounded, axis by axis: what is exact costs nothing.
TEST(RayClearance, CountsOnlyWhatHasAnErrorAlongTheNormal) {
    Placed wall;  // faces along x, a meter wide, 100 m off along y
    wall.p0 = vec3(0.0f, 100.0f, 0.0f);
    wall.e1 = vec3(0.0f, 1.0f, 0.0f);
    wall.e2 = vec3(0.0f, 0.0f, 1.0f);
    wall.weights = vec2(0.25f, 0.25f);
    const float near = wall.Clearance();
    EXPECT_GT(near, 0.0f);
    EXPECT_LT(near, 1e-6f);
    wall.translation = vec3(0.0f, 10000.0f, 5000.0f);
    EXPECT_LT(wall.Clearance(), 1e-6f) << "moved along itself";
    wall.translation = vec3(1000.0f, 0.0f, 0.0f);
    // Two roundings of its place, six of the terms of the inverse: o.x - t.x
    EXPECT_NEAR(wall.Clearance(), gpu::kRoundoff * (2.0f + 6.0f * 2.0f) * 1000.0f, 1e-5f);
    EXPECT_LT(wall.Clearance(), 0.9e-3f) << "a pane of 1 mm at 1 km";
    wall.translation = vec3(-1000.0f, 0.0f, 0.0f);
    wall.p0.x = 1000.0f;
    // Two of the vertices and three of the transform, and the inverse
    EXPECT_NEAR(wall.Clearance(), gpu::kRoundoff * (2.0f + 3.0f + 6.0f) * 1000.0f, 1e-5f)
        << "the place is near 0, its terms are not";
}

// From triangles of 1e-12 m to those of 1e12 m; their normals are in square meters.
TEST(RayClearance, IsInProportionToTheSizeOfTheWorld) {
    Uniform generator(6);
    for (int i = 0; i < 1000; ++i) {
        const Placed placed = RandomTriangle(generator, 1, 1.0f, 1.0f, 1.0f);
        for (const float size : {0x1p-40f, 0x1p33f, 0x1p40f}) {
            Placed vertices = placed;
            for (vec3* v : {&vertices.p0, &vertices.e1, &vertices.e2, &vertices.translation}) *v *= size;
            const float expected = size * placed.Clearance();
            ASSERT_NEAR(vertices.Clearance(), expected, 1e-5f * expected) << size;
            Placed transform = placed;
            for (int axis = 0; axis < 3; ++axis) transform.linear[axis] *= size;
            transform.translation *= size;
            ASSERT_NEAR(transform.Clearance(), expected, 1e-5f * expected) << size;
        }
    }
}

TEST(RayClearance, GrowsWithTheScaleOfTheWorldAndIsFiniteForSlivers) {
    Uniform generator(5);
    for (int i = 0; i < 1000; ++i) {
        Placed placed = RandomTriangle(generator, 1, 1.0f, 10.0f, 10.0f);
        const float clearance = placed.Clearance();
        placed.linear = mat3(64.0f * placed.linear[0], 64.0f * placed.linear[1], 64.0f * placed.linear[2]);
        placed.translation *= 64.0f;
        EXPECT_NEAR(placed.Clearance(), 64.0f * clearance, 1e-3f * 64.0f * clearance);
        placed = RandomTriangle(generator, 1, 1.0f, 1.0f, 10.0f);
        placed.e2 = placed.e1 + 1e-5f * generator.Direction();
        EXPECT_GT(placed.Clearance(), 0.0f);
        EXPECT_LT(placed.Clearance(), 1e-3f);
        placed.e2 = placed.e1;  // without area
        EXPECT_GT(placed.Clearance(), 0.0f);
        EXPECT_LT(placed.Clearance(), 1e-3f);
    }
}

// Transforms under which a triangle has another shape in the world than in its object.
struct Distortion {
    const char* name;
    vec3 scale;
    float shear = 0.0f;  // shear of the first axis along the second one
    bool isTurned = false;
};
constexpr std::array kDistortions{Distortion{"none", vec3(1.0f)},
                                  Distortion{"flat along x", vec3(1.5e-5f, 1.0f, 1.0f)},
                                  Distortion{"flat along y", vec3(1.0f, 1.5e-5f, 1.0f)},
                                  Distortion{"flat along z", vec3(1.0f, 1.0f, 1.5e-5f)},
                                  Distortion{"flat and turned", vec3(1.0f, 1.0f, 1.5e-5f), 0.0f, true},
                                  Distortion{"slab", vec3(100.0f, 100.0f, 1.0f)},
                                  Distortion{"turned slab", vec3(100.0f, 100.0f, 0.01f), 0.0f, true},
                                  Distortion{"rail", vec3(1.0f, 1000.0f, 1.0f), 0.0f, true},
                                  Distortion{"sheared", vec3(1.0f), 300.0f, true}};

Placed Distorted(Uniform& generator, const Distortion& distortion) {
    Placed placed = RandomTriangle(generator, distortion.isTurned ? 1 : 0, 1.0f, 0.0f, 0.0f);
    placed.linear =
        placed.linear * mat3(vec3(distortion.scale.x, distortion.shear, 0.0f),
                             vec3(0.0f, distortion.scale.y, 0.0f), vec3(0.0f, 0.0f, distortion.scale.z));
    placed.translation = generator.Direction();
    return placed;
}

bool IsSliver(vec3 e1, vec3 e2) {
    const float extent = max(length(e1), max(length(e2), length(e2 - e1)));
    return length(cross(e1, e2)) < 0.05f * extent * extent;
}

// Tests rays in all directions away from the plane, many of them nearly along it.
TEST(RayClearance, NoTraversalMeetsTheTriangleThatARayLeaves) {
    constexpr uint32_t kTriangles = 200, kRays = 48;
    Uniform generator(8);
    for (const Distortion& distortion : kDistortions) {
        std::array<uint32_t, 2> met{};
        double largest = 0.0;  // clearance over a step of float of the triangle's size and place
        for (uint32_t i = 0; i < kTriangles;) {
            const Placed placed = Distorted(generator, distortion);
            const vec3 e1 = placed.linear * placed.e1, e2 = placed.linear * placed.e2;
            if (IsSliver(placed.e1, placed.e2) || IsSliver(e1, e2)) continue;
            ++i;
            BvhScene scene;
            scene.meshes.push_back({{placed.p0, placed.p0 + placed.e1, placed.p0 + placed.e2}, {0, 1, 2}});
            scene.instances.push_back(
                {0, glm::mat4x3(placed.linear[0], placed.linear[1], placed.linear[2], placed.translation)});
            const std::array levels{BuildOneLevel(scene), testing::BuildWideScene(scene)};
            const float clearance = placed.Clearance();
            for (uint32_t ray = 0; ray < kRays; ++ray) {
                const vec3 normal = ray % 2 == 0 ? placed.Normal() : -placed.Normal();
                vec3 direction = generator.Direction();
                direction -= dot(direction, normal) * normal;
                direction += std::exp(-12.0f * generator()) * normal;
                const gpu::BenchRay leaving{.origin = OffsetRayOrigin(placed.Point(), normal, clearance),
                                            .tMax = 1e30f,
                                            .direction = normalize(direction)};
                for (size_t level = 0; level < levels.size(); ++level)
                    met[level] += Traverse(levels[level], leaving, true).t >= 0.0f;
            }
            const double size = length(placed.Point()) + length(placed.translation) + length(e1) + length(e2);
            largest = std::max(largest, double{clearance} / (size * 0x1p-23));
        }
        EXPECT_EQ(met[0], 0u) << distortion.name << ", of one level";
        EXPECT_EQ(met[1], 0u) << distortion.name << ", of two levels";
        EXPECT_LT(largest, 80.0) << distortion.name;
    }
}

}  // namespace
}  // namespace raygraph::shading::ray_clearance_test
