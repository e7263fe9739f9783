#include "renderer/bvh/facet_scene.h"

#include <cmath>
#include <limits>
#include <utility>

namespace raygraph {

namespace {

// Balanced trees are built fast, and are no deeper than the stack of a ray.
constexpr uint32_t kMaxDepth = 40;

BinaryBvh TreeOf(std::span<const Box> boxes, uint32_t maxThreads) {
    return BuildBinaryBvh(boxes, {.isBalanced = true, .maxThreads = maxThreads});
}

Box BoxOf(const Facet& facet) {
    Box box;
    for (const glm::vec3& corner : {facet.p0, facet.p1, facet.p2}) box.Extend(corner);
    return box;
}

// Returns the reciprocal of the direction. A zero component is replaced by 1e-18, so that slab distances stay
// finite for coordinates below 1e20.
glm::vec3 Inverse(const glm::vec3& direction) {
    glm::vec3 inverse;
    for (int axis = 0; axis < 3; ++axis)
        inverse[axis] = 1.0f / (std::abs(direction[axis]) > 1e-18f ? direction[axis] : 1e-18f);
    return inverse;
}

bool IntersectsBox(const Box& box, const glm::vec3& origin, const glm::vec3& inverse, float tMax) {
    const glm::vec3 a = (box.min - origin) * inverse, b = (box.max - origin) * inverse;
    const glm::vec3 low = glm::min(a, b), high = glm::max(a, b);
    // The margin keeps hits in flat boxes, and on edges that facets share, in spite of rounding
    constexpr float kMargin = 1.0f + 1e-5f;
    const float near = std::max(std::max(low.x, low.y), std::max(low.z, 0.0f));
    const float far = std::min(std::min(high.x, high.y), high.z) * kMargin;
    return near <= far && near < tMax;
}

// Calls onLeaf(primitive) for each primitive whose box the ray enters before `tMax`, which onLeaf may lower.
template <typename OnLeaf>
void Walk(const BinaryBvh& tree, const glm::vec3& origin, const glm::vec3& direction, const float& tMax,
          OnLeaf&& onLeaf) {
    if (tree.nodes.empty()) return;
    const glm::vec3 inverse = Inverse(direction);
    uint32_t stack[kMaxDepth + 1] = {0};
    for (uint32_t count = 1; count > 0;) {
        const BinaryNode& node = tree.nodes[stack[--count]];
        if (!IntersectsBox(node.box, origin, inverse, tMax)) continue;
        if (node.IsLeaf()) {
            onLeaf(tree.order[node.left]);
            continue;
        }
        // The nearer child is pushed last, so that it is visited first
        const bool isLeftNearer = glm::dot(tree.nodes[node.left].box.Center(), direction) <
                                  glm::dot(tree.nodes[node.right].box.Center(), direction);
        stack[count++] = isLeftNearer ? node.right : node.left;
        stack[count++] = isLeftNearer ? node.left : node.right;
    }
}

// Returns the distance of the hit, negative on a miss (Moller and Trumbore 1997). Sets the barycentric
// coordinates of p1 and p2 on a hit.
float Intersect(const Facet& facet, const glm::vec3& origin, const glm::vec3& direction,
                glm::vec2& barycentrics) {
    const glm::vec3 e1 = facet.p1 - facet.p0, e2 = facet.p2 - facet.p0;
    const glm::vec3 p = glm::cross(direction, e2);
    const float determinant = glm::dot(e1, p);  // positive: the ray meets the front
    if (determinant == 0.0f || (facet.isBackCulled && determinant < 0.0f)) return -1.0f;
    const glm::vec3 s = origin - facet.p0;
    const float u = glm::dot(s, p) / determinant;
    const glm::vec3 q = glm::cross(s, e1);
    const float v = glm::dot(direction, q) / determinant;
    if (!(u >= 0.0f && v >= 0.0f && u + v <= 1.0f)) return -1.0f;
    barycentrics = {u, v};
    return glm::dot(e2, q) / determinant;
}

}  // namespace

FacetScene::FacetScene(std::vector<std::vector<Facet>> meshes, std::vector<BvhInstance> instances,
                       uint32_t maxThreads, FacetTest test)
    : m_instances(std::move(instances)), m_test(std::move(test)) {
    for (std::vector<Facet>& facets : meshes) {
        std::vector<Box> boxes;
        boxes.reserve(facets.size());
        for (const Facet& facet : facets) boxes.push_back(BoxOf(facet));
        m_meshes.push_back({std::move(facets), TreeOf(boxes, maxThreads)});
    }
    std::vector<Box> boxes;
    for (uint32_t i = 0; i < m_instances.size(); ++i) {
        const BvhInstance& instance = m_instances[i];
        const BinaryBvh& tree = m_meshes[instance.mesh].tree;
        if (tree.nodes.empty()) continue;
        const glm::dmat3 linear = glm::inverse(glm::dmat3(glm::mat3(instance.objectToWorld)));
        const glm::dvec3 place = -(linear * glm::dvec3(instance.objectToWorld[3]));
        const glm::mat4x3 toObject{linear[0], linear[1], linear[2], place};
        const Box box = PlacedBox(tree.nodes[0].box, instance.objectToWorld);
        bool isFinite = box.IsFinite();
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 3; ++row) isFinite &= std::isfinite(toObject[column][row]);
        if (!isFinite) continue;
        boxes.push_back(box);
        m_bounds.Extend(box);
        m_hittable.push_back(i);
        m_toObject.push_back(toObject);
    }
    m_tree = TreeOf(boxes, maxThreads);
}

template <bool isAny>
std::optional<FacetHit> FacetScene::Find(const glm::vec3& origin, const glm::vec3& direction,
                                         float tMax) const {
    std::optional<FacetHit> hit;
    uint32_t place = 0;
    Walk(m_tree, origin, direction, tMax, [&](uint32_t candidate) {
        const glm::mat4x3& toObject = m_toObject[candidate];
        const uint32_t instance = m_hittable[candidate];
        const Mesh& mesh = m_meshes[m_instances[instance].mesh];
        const glm::vec3 from = toObject * glm::vec4(origin, 1.0f), along = glm::mat3(toObject) * direction;
        Walk(mesh.tree, from, along, tMax, [&](uint32_t facet) {
            glm::vec2 barycentrics(0.0f);
            const float t = Intersect(mesh.facets[facet], from, along, barycentrics);
            if (!(t > 0.0f && t < tMax)) return;
            if (mesh.facets[facet].isTested && m_test && !m_test(instance, facet, barycentrics)) return;
            hit = FacetHit{.t = t, .instance = instance, .facet = facet, .barycentrics = barycentrics};
            place = candidate;
            tMax = isAny ? 0.0f : t;
        });
    });
    if (isAny || !hit) return hit;
    const Facet& facet = m_meshes[m_instances[hit->instance].mesh].facets[hit->facet];
    const glm::vec3 across = glm::cross(facet.p1 - facet.p0, facet.p2 - facet.p0);
    const glm::vec3 normal = glm::transpose(glm::mat3(m_toObject[place])) * across;
    hit->normal = glm::normalize(glm::dot(normal, direction) > 0.0f ? -normal : normal);
    return hit;
}

std::optional<FacetHit> FacetScene::Trace(const glm::vec3& origin, const glm::vec3& direction) const {
    return Find<false>(origin, direction, std::numeric_limits<float>::infinity());
}

bool FacetScene::IsOccluded(const glm::vec3& origin, const glm::vec3& direction, float tMax) const {
    return Find<true>(origin, direction, tMax).has_value();
}

}  // namespace raygraph
