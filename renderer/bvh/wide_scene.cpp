#include "renderer/bvh/wide_scene.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "renderer/bvh/wide_bvh.h"

namespace raygraph {
namespace {

// Where an instance is in its own space; none without an inverse in float.
bool ToWideInstance(const WidePlacement& placement, gpu::WideInstance& wide) {
    const glm::dmat3 linear = glm::inverse(glm::dmat3(glm::mat3(placement.objectToWorld)));
    const glm::dvec3 origin = -(linear * glm::dvec3(placement.objectToWorld[3]));
    wide = {.root = placement.root, .instance = placement.number, .flags = placement.flags};
    for (int row = 0; row < 3; ++row) {
        wide.toObject[row] = glm::dvec4(linear[0][row], linear[1][row], linear[2][row], origin[row]);
        for (int column = 0; column < 4; ++column)
            if (!std::isfinite(wide.toObject[row][column])) return false;
    }
    return true;
}

Box BoxOf(std::span<const gpu::WideTriangle> triangles) {
    Box box;
    for (const gpu::WideTriangle& triangle : triangles)
        for (const glm::vec3& corner : {triangle.p0, triangle.p1, triangle.p2}) box.Extend(corner);
    return box;
}

// Farther away, the distance of a side of a box has no end along axes that rays are parallel to.
bool IsNearEnough(const Box& box) {
    constexpr float kFarthest = 1e18f;
    const glm::vec3 reach = glm::max(glm::abs(box.min), glm::abs(box.max));
    return box.IsFinite() && std::max({reach.x, reach.y, reach.z}) < kFarthest;
}

WideMesh WithoutFlat(std::vector<gpu::WideTriangle> triangles) {
    std::erase_if(triangles, [](const gpu::WideTriangle& t) {
        return glm::cross(glm::dvec3(t.p1) - glm::dvec3(t.p0), glm::dvec3(t.p2) - glm::dvec3(t.p0)) ==
               glm::dvec3(0.0);
    });
    const Box box = BoxOf(triangles);
    return {.triangles = std::move(triangles), .box = box};
}

}  // namespace

std::vector<Box> TriangleBoxes(std::span<const glm::vec3> positions, std::span<const uint32_t> indices) {
    std::vector<Box> boxes(indices.size() / 3);
    for (size_t i = 0; i < 3 * boxes.size(); ++i) boxes[i / 3].Extend(positions[indices[i]]);
    return boxes;
}

Box PlacedBox(const Box& mesh, const glm::mat4x3& objectToWorld) {
    constexpr float kRoundings = 8.0f * std::numeric_limits<float>::epsilon();
    Box box;
    for (uint32_t corner = 0; corner < 8; ++corner) {
        const glm::vec3 at(corner & 1u ? mesh.max.x : mesh.min.x, corner & 2u ? mesh.max.y : mesh.min.y,
                           corner & 4u ? mesh.max.z : mesh.min.z);
        box.Extend(objectToWorld * glm::vec4(at, 1.0f));
    }
    const glm::vec3 margin = kRoundings * glm::max(glm::abs(box.min), glm::abs(box.max));
    box.min -= margin;
    box.max += margin;
    return box;
}

std::vector<Box> InstanceBoxes(const BvhScene& scene) {
    std::vector<Box> ofMeshes(scene.meshes.size()), boxes(scene.instances.size());
    for (size_t i = 0; i < scene.meshes.size(); ++i)
        for (const glm::vec3& position : scene.meshes[i].positions) ofMeshes[i].Extend(position);
    for (size_t i = 0; i < boxes.size(); ++i)
        boxes[i] = PlacedBox(ofMeshes[scene.instances[i].mesh], scene.instances[i].objectToWorld);
    return boxes;
}

WideMesh CollectTriangles(std::span<const glm::vec3> positions, std::span<const uint32_t> indices) {
    std::vector<gpu::WideTriangle> triangles;
    triangles.reserve(indices.size() / 3);
    for (uint32_t i = 0; i < indices.size() / 3; ++i) {
        const auto corner = [&](uint32_t c) { return positions[indices[size_t{3} * i + c]]; };
        triangles.push_back({.p0 = corner(0), .primitive = i, .p1 = corner(1), .p2 = corner(2)});
    }
    return WithoutFlat(std::move(triangles));
}

void BuildTree(WideMesh& mesh, uint32_t maxThreads) {
    if (!mesh.triangles.empty() && !IsNearEnough(mesh.box)) return;
    std::vector<Box> boxes;
    boxes.reserve(mesh.triangles.size());
    for (const gpu::WideTriangle& triangle : mesh.triangles) boxes.push_back(BoxOf({&triangle, 1}));
    WideBvh tree = CollapseToWide(BuildBinaryBvh(boxes, {.maxThreads = maxThreads}));
    if (tree.depth > kMaxMeshDepth)
        tree = CollapseToWide(BuildBinaryBvh(boxes, {.isBalanced = true, .maxThreads = maxThreads}));
    std::vector<gpu::WideTriangle> ordered;
    ordered.reserve(tree.primitives.size());
    for (const uint32_t primitive : tree.primitives) ordered.push_back(mesh.triangles[primitive]);
    mesh.triangles = std::move(ordered);
    mesh.nodes = std::move(tree.nodes);
    mesh.depth = tree.depth;
    mesh.sahCost = tree.sahCost;
}

WideMesh BuildWideMesh(std::span<const glm::vec3> positions, std::span<const uint32_t> indices,
                       uint32_t maxThreads) {
    WideMesh mesh = CollectTriangles(positions, indices);
    BuildTree(mesh, maxThreads);
    return mesh;
}

WideMesh BuildWideLevel(std::span<const PlacedTriangles> placed) {
    std::vector<gpu::WideTriangle> triangles;
    for (const PlacedTriangles& mesh : placed) {
        if (gpu::WideInstance ignored; !ToWideInstance({.objectToWorld = mesh.objectToWorld}, ignored))
            continue;
        // In double: a vertex is rounded once, less than RayClearance allows for rays in object space
        const glm::dmat4x3 toWorld(mesh.objectToWorld);
        const auto place = [&](const glm::vec3& p) { return glm::vec3(toWorld * glm::dvec4(p, 1.0)); };
        const bool isMirrored = glm::determinant(glm::dmat3(toWorld)) < 0.0;
        const uint32_t flags = mesh.flags | (isMirrored ? gpu::kWideMirrored : 0u);
        const size_t first = triangles.size();
        for (const gpu::WideTriangle& triangle : mesh.triangles)
            triangles.push_back({.p0 = place(triangle.p0),
                                 .primitive = triangle.primitive,
                                 .p1 = place(triangle.p1),
                                 .instance = mesh.number,
                                 .p2 = place(triangle.p2),
                                 .flags = flags});
        if (!IsNearEnough(BoxOf(std::span(triangles).subspan(first)))) triangles.resize(first);
    }
    WideMesh level = WithoutFlat(std::move(triangles));
    BuildTree(level);
    return level;
}

WideInstances BuildWideInstances(std::span<const WidePlacement> placements) {
    std::vector<Box> boxes;
    std::vector<gpu::WideInstance> placed;
    for (const WidePlacement& placement : placements) {
        gpu::WideInstance instance;
        if (!placement.box.IsFinite() || !ToWideInstance(placement, instance)) continue;
        const Box box = PlacedBox(placement.box, placement.objectToWorld);
        if (!IsNearEnough(box)) continue;
        boxes.push_back(box);
        placed.push_back(instance);
    }
    WideBvh tree = CollapseToWide(BuildBinaryBvh(boxes));
    if (tree.depth > kMaxInstanceDepth) tree = CollapseToWide(BuildBinaryBvh(boxes, {.isBalanced = true}));
    WideInstances result{.nodes = std::move(tree.nodes), .depth = tree.depth, .sahCost = tree.sahCost};
    MoveNodes(result.nodes, 0, 1);
    result.instances.reserve(placed.size() + 1);
    result.instances.emplace_back();
    for (const uint32_t i : tree.primitives) result.instances.push_back(placed[i]);
    return result;
}

void MoveNodes(std::span<gpu::WideNode> nodes, uint32_t firstNode, uint32_t firstPrimitive) {
    for (gpu::WideNode& node : nodes) {
        node.firstChild += firstNode;
        node.firstPrimitive += firstPrimitive;
    }
}

WideScene BuildWideScene(const BvhScene& scene) {
    const Stopwatch watch;
    WideScene wide;
    std::vector<uint32_t> roots;
    std::vector<Box> boxes;
    uint32_t depth = 0;
    for (const BvhMesh& mesh : scene.meshes) {
        WideMesh tree = BuildWideMesh(mesh.positions, mesh.indices);
        if (tree.nodes.empty())
            throw Error(ErrorKind::Usage, "a wide tree of a mesh that reaches farther than 1e18");
        roots.push_back(static_cast<uint32_t>(wide.nodes.size()));
        boxes.push_back(tree.box);
        MoveNodes(tree.nodes, roots.back(), static_cast<uint32_t>(wide.triangles.size()));
        wide.nodes.insert(wide.nodes.end(), tree.nodes.begin(), tree.nodes.end());
        wide.triangles.insert(wide.triangles.end(), tree.triangles.begin(), tree.triangles.end());
        wide.sahOfMeshes += tree.sahCost * static_cast<double>(mesh.TriangleCount());
        depth = std::max(depth, tree.depth);
    }
    if (!wide.triangles.empty()) wide.sahOfMeshes /= static_cast<double>(wide.triangles.size());
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
    wide.sahOfInstances = instances.sahCost;
    instances.instances[0].root = static_cast<uint32_t>(wide.nodes.size());
    MoveNodes(instances.nodes, instances.instances[0].root, 0);
    wide.nodes.insert(wide.nodes.end(), instances.nodes.begin(), instances.nodes.end());
    wide.instances = std::move(instances.instances);
    wide.buildSeconds = watch.Seconds();
    return wide;
}

WideScene BuildOneLevel(const BvhScene& scene) {
    const Stopwatch watch;
    std::vector<WideMesh> meshes;
    for (const BvhMesh& mesh : scene.meshes) meshes.push_back(CollectTriangles(mesh.positions, mesh.indices));
    std::vector<PlacedTriangles> placed;
    for (const BvhInstance& instance : scene.instances)
        placed.push_back({.triangles = meshes[instance.mesh].triangles,
                          .objectToWorld = instance.objectToWorld,
                          .number = static_cast<uint32_t>(placed.size())});
    WideMesh level = BuildWideLevel(placed);
    if (level.depth > kMaxMeshDepth)
        throw MakeError(ErrorKind::Usage, "a wide tree of {} levels: there is room for {}", level.depth,
                        kMaxMeshDepth);
    return {.nodes = std::move(level.nodes),
            .triangles = std::move(level.triangles),
            .instances = {{}},
            .sahOfMeshes = level.sahCost,
            .buildSeconds = watch.Seconds()};
}

}  // namespace raygraph
