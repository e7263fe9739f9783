#include "renderer/bvh/wide_scene.h"

#include "base/error.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "renderer/bvh/wide_bvh.h"

namespace raygraph {
namespace {

gpu::WideTriangle ToWideTriangle(const BvhMesh& mesh, uint32_t triangle) {
    const auto corner = [&](uint32_t i) { return mesh.positions[mesh.indices[3 * triangle + i]]; };
    return {.p0 = corner(0), .primitive = triangle, .e1 = corner(1) - corner(0), .e2 = corner(2) - corner(0)};
}

gpu::WideInstance ToWideInstance(const BvhInstance& instance, uint32_t number, uint32_t root) {
    const glm::dmat3 linear = glm::inverse(glm::dmat3(glm::mat3(instance.objectToWorld)));
    const glm::dvec3 origin = -(linear * glm::dvec3(instance.objectToWorld[3]));
    gpu::WideInstance wide{.root = root, .instance = number};
    for (int row = 0; row < 3; ++row)
        wide.toObject[row] = glm::dvec4(linear[0][row], linear[1][row], linear[2][row], origin[row]);
    return wide;
}

// Appends a tree's nodes; `firstPrimitive` is where its primitives will be.
uint32_t Append(WideScene& scene, const WideBvh& tree, size_t firstPrimitive) {
    const uint32_t first = static_cast<uint32_t>(scene.nodes.size());
    for (gpu::WideNode node : tree.nodes) {
        node.firstChild += first;
        node.firstPrimitive += static_cast<uint32_t>(firstPrimitive);
        scene.nodes.push_back(node);
    }
    return first;
}

}  // namespace

std::vector<Box> TriangleBoxes(const BvhMesh& mesh) {
    std::vector<Box> boxes(mesh.TriangleCount());
    for (size_t i = 0; i < mesh.indices.size(); ++i) boxes[i / 3].Extend(mesh.positions[mesh.indices[i]]);
    return boxes;
}

std::vector<Box> InstanceBoxes(const BvhScene& scene) {
    constexpr float kRoundings = 8.0f * std::numeric_limits<float>::epsilon();
    std::vector<Box> ofMeshes(scene.meshes.size()), boxes(scene.instances.size());
    for (size_t i = 0; i < scene.meshes.size(); ++i)
        for (const glm::vec3& position : scene.meshes[i].positions) ofMeshes[i].Extend(position);
    for (size_t i = 0; i < boxes.size(); ++i) {
        const BvhInstance& instance = scene.instances[i];
        const Box& box = ofMeshes[instance.mesh];
        for (uint32_t corner = 0; corner < 8; ++corner) {
            const glm::vec3 at(corner & 1u ? box.max.x : box.min.x, corner & 2u ? box.max.y : box.min.y,
                               corner & 4u ? box.max.z : box.min.z);
            boxes[i].Extend(instance.objectToWorld * glm::vec4(at, 1.0f));
        }
        const glm::vec3 margin = kRoundings * glm::max(glm::abs(boxes[i].min), glm::abs(boxes[i].max));
        boxes[i].min -= margin;
        boxes[i].max += margin;
    }
    return boxes;
}

WideScene BuildWideScene(const BvhScene& scene) {
    const Stopwatch watch;
    WideScene wide;
    const WideBvh instances = CollapseToWide(BuildBinaryBvh(InstanceBoxes(scene)));
    std::ignore = Append(wide, instances, 0);
    wide.sahOfInstances = instances.sahCost;
    std::vector<uint32_t> roots;
    uint32_t depth = 0;
    for (const BvhMesh& mesh : scene.meshes) {
        const WideBvh tree = CollapseToWide(BuildBinaryBvh(TriangleBoxes(mesh)));
        roots.push_back(Append(wide, tree, wide.triangles.size()));
        for (const uint32_t triangle : tree.primitives)
            wide.triangles.push_back(ToWideTriangle(mesh, triangle));
        wide.sahOfMeshes += tree.sahCost * static_cast<double>(mesh.TriangleCount());
        depth = std::max(depth, tree.depth);
    }
    if (!wide.triangles.empty()) wide.sahOfMeshes /= static_cast<double>(wide.triangles.size());
    // A level leaves one group behind, and going into a mesh another one
    if (instances.depth + depth + 1 > gpu::kWideStackSize)
        throw MakeError(ErrorKind::Usage, "wide trees of {} and {} levels: there is room for {}",
                        instances.depth, depth, gpu::kWideStackSize - 1);
    for (const uint32_t i : instances.primitives)
        wide.instances.push_back(ToWideInstance(scene.instances[i], i, roots[scene.instances[i].mesh]));
    wide.buildSeconds = watch.Seconds();
    return wide;
}

}  // namespace raygraph
