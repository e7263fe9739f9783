// The wide tree: what its builder promises, and its traversal, the text that the device runs, against all
// triangles one after the other.
#include <gtest/gtest.h>

#include <cstring>

#include "renderer/bvh/wide_bvh.h"
#include "renderer/bvh/wide_scene.h"
#include "tests/support/triangle_soup.h"

namespace raygraph::shading {
namespace {

thread_local const WideScene* s_scene = nullptr;
thread_local glm::uvec2 s_stack[gpu::kWideStackSize];

template <typename T>
glm::uvec4 WordOf(const std::vector<T>& records, uint32_t at) {
    glm::uvec4 word;
    std::memcpy(&word, reinterpret_cast<const std::byte*>(records.data()) + 16 * size_t{at}, 16);
    return word;
}
glm::uvec4 WideNodeWord(uint32_t at) {
    return WordOf(s_scene->nodes, at);
}
glm::uvec4 WideTriangleWord(uint32_t at) {
    return WordOf(s_scene->triangles, at);
}
glm::uvec4 WideInstanceWord(uint32_t at) {
    return WordOf(s_scene->instances, at);
}
void PushGroup(uint32_t at, glm::uvec2 group) {
    ASSERT_LT(at, gpu::kWideStackSize);
    s_stack[at] = group;
}
glm::uvec2 GroupAt(uint32_t at) {
    return s_stack[at];
}

}  // namespace
}  // namespace raygraph::shading

#include "bench/wide_bvh.glsl"

namespace raygraph {
namespace {

using testing::RandomRays;
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

gpu::BenchHit Traverse(const WideScene& scene, const gpu::BenchRay& ray, bool isAny) {
    shading::s_scene = &scene;
    gpu::BenchCounts counts{};
    return shading::TraverseWide(ray.origin, ray.direction, ray.tMax, isAny, counts);
}

TEST(WideTraversal, FindsWhatIsNearestOfAllTriangles) {
    const BvhScene scene = testing::SoupWithInstances();
    const WideScene wide = BuildWideScene(scene);
    uint32_t hits = 0, differences = 0;
    const std::vector<gpu::BenchRay> rays = RandomRays(2000, 7);
    for (const gpu::BenchRay& ray : rays) {
        const gpu::BenchHit hit = Traverse(wide, ray, false);
        const ExactHit exact = TraceExactly(scene, ray);
        if (exact.isDoubtful) continue;
        hits += exact.t >= 0.0 ? 1 : 0;
        if (exact.t < 0.0) {
            EXPECT_LT(hit.t, 0.0f);
            continue;
        }
        ASSERT_GE(hit.t, 0.0f);
        EXPECT_NEAR(double{hit.t}, exact.t, 1e-4 * exact.t);
        if (hit.instance != exact.instance || hit.primitive != exact.primitive) ++differences;
    }
    EXPECT_GT(hits, rays.size() / 4);
    EXPECT_LT(hits, rays.size());
    EXPECT_EQ(differences, 0u);
}

TEST(WideTraversal, AnyHitIsWhetherSomethingIsNearer) {
    const BvhScene scene = testing::SoupWithInstances();
    const WideScene wide = BuildWideScene(scene);
    uint32_t hits = 0;
    std::vector<gpu::BenchRay> rays = RandomRays(2000, 8);
    for (gpu::BenchRay& ray : rays) {
        ray.tMax = 0.8f;
        const ExactHit exact = TraceExactly(scene, ray);
        if (exact.isDoubtful) continue;
        EXPECT_EQ(Traverse(wide, ray, true).t >= 0.0f, exact.t >= 0.0);
        hits += exact.t >= 0.0 ? 1 : 0;
    }
    EXPECT_GT(hits, rays.size() / 10);
    EXPECT_LT(hits, rays.size() / 2);
}

// Rays along the axes, on triangles without extent in one of them.
TEST(WideTraversal, FlatTrianglesAndAxisParallelRays) {
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
    const WideScene wide = BuildWideScene(scene);
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            const gpu::BenchRay ray{.origin = {float(x) + 0.25f, 3.0f, float(y) + 0.25f},
                                    .tMax = 1e30f,
                                    .direction = {0.0f, -1.0f, 0.0f}};
            const gpu::BenchHit hit = Traverse(wide, ray, false);
            ASSERT_EQ(hit.t, 3.0f);
            EXPECT_EQ(hit.primitive, 2 * (y * kSide + x));
        }
}

}  // namespace
}  // namespace raygraph
