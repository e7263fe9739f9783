#include "tests/support/triangle_soup.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "base/text.h"

namespace raygraph::testing {
namespace {

class Random {
  public:
    explicit Random(uint32_t seed) : m_engine(seed) {}
    // Returns a number in [-1, 1).
    float Get() { return 2.0f * static_cast<float>(m_engine() >> 8) / 16777216.0f - 1.0f; }
    glm::vec3 Vector() {
        const float x = Get(), y = Get();
        return {x, y, Get()};
    }

  private:
    std::mt19937 m_engine;
};

}  // namespace

BvhMesh TriangleSoup(uint32_t count, float size, uint32_t seed) {
    Random random(seed);
    BvhMesh mesh;
    for (uint32_t i = 0; i < count; ++i) {
        const glm::vec3 center = random.Vector();
        for (uint32_t corner = 0; corner < 3; ++corner) {
            mesh.indices.push_back(static_cast<uint32_t>(mesh.positions.size()));
            mesh.positions.push_back(center + size * random.Vector());
        }
    }
    return mesh;
}

BvhScene InstancedTriangleSoup() {
    BvhScene scene;
    scene.meshes = {TriangleSoup(300, 0.15f, 11), TriangleSoup(50, 0.4f, 12)};
    const glm::mat4 one(1.0f);
    const auto place = [&](uint32_t mesh, const glm::mat4& objectToWorld) {
        scene.instances.push_back({mesh, glm::mat4x3(objectToWorld)});
    };
    place(0, glm::scale(one, {0.6f, 0.6f, 0.6f}));
    place(0, glm::scale(glm::translate(one, {0.8f, -0.3f, 0.1f}), {0.1f, 0.7f, 0.4f}));
    place(1, glm::rotate(glm::scale(glm::translate(one, {-0.7f, 0.2f, 0.3f}), {0.3f, 0.2f, -0.6f}), 0.7f,
                         {1, 2, 3}));
    place(1, glm::scale(glm::rotate(glm::translate(one, {0.1f, 0.8f, -0.6f}), -1.1f, {3, 1, 2}),
                        {0.5f, 0.05f, 0.4f}));
    for (uint32_t i = 0; i < 20; ++i)
        place(i % 2, glm::scale(glm::translate(one, {0.1f * float(i) - 1.0f, -0.9f, 0.05f * float(i)}),
                                glm::vec3(0.1f)));
    return scene;
}

std::vector<gpu::BenchRay> RandomRays(uint32_t count, uint32_t seed) {
    Random random(seed);
    std::vector<gpu::BenchRay> rays(count);
    for (gpu::BenchRay& ray : rays) {
        ray.origin = 2.0f * random.Vector();
        ray.direction = (0.8f + 0.5f * random.Get()) * (random.Vector() - ray.origin);
        ray.tMax = 1e30f;
    }
    return rays;
}

std::vector<Box> TriangleBoxes(const BvhMesh& mesh) {
    std::vector<Box> boxes(mesh.TriangleCount());
    for (size_t i = 0; i < mesh.indices.size(); ++i) boxes[i / 3].Extend(mesh.positions[mesh.indices[i]]);
    return boxes;
}

WideMesh BuildWideMesh(const BvhMesh& mesh) {
    WideMesh wide = CollectTriangles(mesh.positions, mesh.indices);
    BuildTree(wide);
    return wide;
}

WideScene BuildWideScene(const BvhScene& scene) {
    WideScene wide;
    std::vector<uint32_t> roots;
    std::vector<Box> boxes;
    uint32_t depth = 0;
    for (const BvhMesh& mesh : scene.meshes) {
        WideMesh tree = BuildWideMesh(mesh);
        if (tree.nodes.empty())
            throw Error(ErrorKind::Usage, "a wide tree of a mesh that reaches farther than 1e18");
        roots.push_back(static_cast<uint32_t>(wide.nodes.size()));
        boxes.push_back(tree.box);
        MoveNodes(tree.nodes, roots.back(), static_cast<uint32_t>(wide.triangles.size()));
        wide.nodes.insert(wide.nodes.end(), tree.nodes.begin(), tree.nodes.end());
        wide.triangles.insert(wide.triangles.end(), tree.triangles.begin(), tree.triangles.end());
        depth = std::max(depth, tree.depth);
    }
    std::vector<WidePlacement> placements;
    for (const BvhInstance& instance : scene.instances)
        placements.push_back({.objectToWorld = instance.objectToWorld,
                              .box = boxes[instance.mesh],
                              .root = roots[instance.mesh],
                              .number = static_cast<uint32_t>(placements.size())});
    WideInstances instances = BuildWideInstances(placements);
    if (depth > kMaxMeshDepth || instances.depth > kMaxInstanceDepth)
        throw MakeError(ErrorKind::Usage, "wide trees of {} and {} levels: there is room for {} and {}",
                        instances.depth, depth, kMaxInstanceDepth, kMaxMeshDepth);
    instances.instances[0].root = static_cast<uint32_t>(wide.nodes.size());
    MoveNodes(instances.nodes, instances.instances[0].root, 0);
    wide.nodes.insert(wide.nodes.end(), instances.nodes.begin(), instances.nodes.end());
    wide.instances = std::move(instances.instances);
    return wide;
}

}  // namespace raygraph::testing
