#include "renderer/bvh/wide_scene.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/error.h"
#include "base/text.h"
#include "renderer/bvh/wide_bvh.h"

namespace raygraph {
namespace {

// Transforms an instance to its own space; returns false if it has no inverse in float.
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

// Farther away, the distances of a box's sides are not finite along axes that are perpendicular to the ray.
bool IsNearEnough(const Box& box) {
    constexpr float kFarthest = 1e18f;
    const glm::vec3 reach = glm::max(glm::abs(box.min), glm::abs(box.max));
    return box.IsFinite() && std::max({reach.x, reach.y, reach.z}) < kFarthest;
}

bool HasArea(const gpu::WideTriangle& t) {
    return glm::cross(glm::dvec3(t.p1) - glm::dvec3(t.p0), glm::dvec3(t.p2) - glm::dvec3(t.p0)) !=
           glm::dvec3(0.0);
}

WideMesh WithoutFlat(std::vector<gpu::WideTriangle> triangles) {
    std::erase_if(triangles, std::not_fn(HasArea));
    const Box box = BoxOf(triangles);
    return {.triangles = std::move(triangles), .box = box};
}

}  // namespace

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

WideMesh CollectTriangles(std::span<const glm::vec3> positions, std::span<const uint32_t> indices) {
    std::vector<gpu::WideTriangle> triangles;
    triangles.reserve(indices.size() / 3);
    for (uint32_t i = 0; i < indices.size() / 3; ++i) {
        const auto corner = [&](uint32_t c) { return positions[indices[size_t{3} * i + c]]; };
        triangles.push_back({.p0 = corner(0), .primitive = i, .p1 = corner(1), .p2 = corner(2)});
    }
    return WithoutFlat(std::move(triangles));
}

std::vector<uint32_t> BuildTree(WideMesh& mesh, uint32_t maxThreads) {
    if (!mesh.triangles.empty() && !IsNearEnough(mesh.box)) return {};
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
    return std::move(tree.primitives);
}

std::optional<std::vector<gpu::WideTriangle>> PlaceTriangles(const PlacedTriangles& placed) {
    if (gpu::WideInstance ignored; !ToWideInstance({.objectToWorld = placed.objectToWorld}, ignored))
        return std::nullopt;
    // The product is computed in double: a vertex is rounded once, less than RayClearance allows for rays in
    // object space.
    const glm::dmat4x3 toWorld(placed.objectToWorld);
    const auto place = [&](const glm::vec3& p) { return glm::vec3(toWorld * glm::dvec4(p, 1.0)); };
    const bool isMirrored = glm::determinant(glm::dmat3(toWorld)) < 0.0;
    const uint32_t flags = placed.flags | (isMirrored ? gpu::kWideMirrored : 0u);
    std::vector<gpu::WideTriangle> triangles;
    triangles.reserve(placed.triangles.size());
    for (const gpu::WideTriangle& triangle : placed.triangles) {
        gpu::WideTriangle& record = triangles.emplace_back(gpu::WideTriangle{.p0 = place(triangle.p0),
                                                                             .primitive = triangle.primitive,
                                                                             .p1 = place(triangle.p1),
                                                                             .instance = placed.number,
                                                                             .p2 = place(triangle.p2),
                                                                             .flags = flags});
        if (!HasArea(record)) record.p1 = record.p2 = record.p0;
    }
    if (!triangles.empty() && !IsNearEnough(BoxOf(triangles))) return std::nullopt;
    return triangles;
}

WideLevel BuildWideLevel(std::span<const PlacedTriangles> placed) {
    WideLevel level;
    std::vector<WideLevel::Source> sources;
    for (uint32_t i = 0; i < placed.size(); ++i) {
        const std::optional<std::vector<gpu::WideTriangle>> triangles = PlaceTriangles(placed[i]);
        if (!triangles) continue;
        for (uint32_t t = 0; t < triangles->size(); ++t) sources.push_back({i, t});
        level.mesh.triangles.insert(level.mesh.triangles.end(), triangles->begin(), triangles->end());
    }
    level.mesh.box = BoxOf(level.mesh.triangles);
    for (const uint32_t was : BuildTree(level.mesh)) level.sources.push_back(sources[was]);
    return level;
}

std::optional<PlacedInstance> PlaceInstance(const WidePlacement& placement) {
    PlacedInstance placed;
    if (!placement.box.IsFinite() || !ToWideInstance(placement, placed.instance)) return std::nullopt;
    placed.box = PlacedBox(placement.box, placement.objectToWorld);
    if (!IsNearEnough(placed.box)) return std::nullopt;
    return placed;
}

WideInstances BuildWideInstances(std::span<const WidePlacement> placements) {
    std::vector<Box> boxes;
    std::vector<gpu::WideInstance> placed;
    std::vector<uint32_t> numbers;
    for (uint32_t i = 0; i < placements.size(); ++i) {
        const std::optional<PlacedInstance> record = PlaceInstance(placements[i]);
        if (!record) continue;
        boxes.push_back(record->box);
        placed.push_back(record->instance);
        numbers.push_back(i);
    }
    WideBvh tree = CollapseToWide(BuildBinaryBvh(boxes));
    if (tree.depth > kMaxInstanceDepth) tree = CollapseToWide(BuildBinaryBvh(boxes, {.isBalanced = true}));
    WideInstances result{.nodes = std::move(tree.nodes),
                         .instances = {{}},
                         .boxes = {{}},
                         .placements = {std::numeric_limits<uint32_t>::max()},
                         .depth = tree.depth};
    MoveNodes(result.nodes, 0, 1);
    for (const uint32_t i : tree.primitives) {
        result.instances.push_back(placed[i]);
        result.boxes.push_back(boxes[i]);
        result.placements.push_back(numbers[i]);
    }
    return result;
}

void MoveNodes(std::span<gpu::WideNode> nodes, uint32_t firstNode, uint32_t firstPrimitive) {
    for (gpu::WideNode& node : nodes) {
        node.firstChild += firstNode;
        node.firstPrimitive += firstPrimitive;
    }
}

WideScene BuildOneLevel(const BvhScene& scene) {
    std::vector<WideMesh> meshes;
    for (const BvhMesh& mesh : scene.meshes) meshes.push_back(CollectTriangles(mesh.positions, mesh.indices));
    std::vector<PlacedTriangles> placed;
    for (const BvhInstance& instance : scene.instances)
        placed.push_back({.triangles = meshes[instance.mesh].triangles,
                          .objectToWorld = instance.objectToWorld,
                          .number = static_cast<uint32_t>(placed.size())});
    WideMesh level = BuildWideLevel(placed).mesh;
    if (level.depth > kMaxMeshDepth)
        throw MakeError(ErrorKind::Usage, "a wide tree of {} levels: there is room for {}", level.depth,
                        kMaxMeshDepth);
    return {.nodes = std::move(level.nodes), .triangles = std::move(level.triangles), .instances = {{}}};
}

}  // namespace raygraph
