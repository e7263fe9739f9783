#include "editor/cli/traversal_rays.h"

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "shaders/shared/mix_bits.h"

namespace raygraph::cli {

namespace {

constexpr float kFarthest = 1e30f;
constexpr uint32_t kTileWidth = 8, kTileHeight = 4;
// Relative to coordinates: how far off a surface rays start.
constexpr double kClearance = 1e-5;

double UnitNumber(uint32_t seed, uint32_t index, uint32_t dimension) {
    return gpu::MixBits(gpu::MixBits(seed * 0x9e3779b9u + index) + dimension * 0x85ebca6bu) / 4294967296.0;
}

// A place on a surface, a little off it.
struct Place {
    glm::dvec3 position;
    glm::dvec3 normal;  // on the ray's side
};

Place PlaceOf(const BvhScene& scene, const gpu::BenchRay& ray, const gpu::WideHit& hit) {
    const BvhInstance& instance = scene.instances[hit.instance];
    const BvhMesh& mesh = scene.meshes[instance.mesh];
    glm::dvec3 p[3];
    for (uint32_t corner = 0; corner < 3; ++corner)
        p[corner] = glm::dmat4x3(instance.objectToWorld) *
                    glm::dvec4(glm::dvec3(mesh.positions[mesh.indices[3 * hit.primitive + corner]]), 1.0);
    const glm::dvec3 across = glm::cross(p[1] - p[0], p[2] - p[0]);
    glm::dvec3 normal = across / std::max(glm::length(across), 1e-300);
    if (glm::dot(normal, glm::dvec3(ray.direction)) > 0.0) normal = -normal;
    const double u = double{hit.barycentrics.x}, v = double{hit.barycentrics.y};
    const glm::dvec3 position = (1.0 - u - v) * p[0] + u * p[1] + v * p[2];
    const glm::dvec3 size = glm::abs(position);
    return {position + kClearance * std::max({size.x, size.y, size.z}) * normal, normal};
}

template <typename MakeRay>
std::vector<gpu::BenchRay> RaysFrom(const BvhScene& scene, std::span<const gpu::BenchRay> rays,
                                    std::span<const gpu::WideHit> hits, MakeRay&& make) {
    std::vector<gpu::BenchRay> next;
    for (uint32_t i = 0; i < rays.size(); ++i)
        if (hits[i].t >= 0.0f) next.push_back(make(PlaceOf(scene, rays[i], hits[i]), i));
    return next;
}

}  // namespace

BvhScene BvhSceneOf(const scene::SceneData& data) {
    BvhScene result;
    std::vector<uint32_t> meshes;  // by the scene's
    for (const scene::Mesh& mesh : data.meshes) {
        BvhMesh triangles;
        for (const scene::Primitive& primitive : mesh.primitives) {
            if (primitive.IsRound()) continue;
            const uint32_t first = static_cast<uint32_t>(triangles.positions.size());
            triangles.positions.insert(triangles.positions.end(), primitive.positions.begin(),
                                       primitive.positions.end());
            for (const uint32_t index : primitive.indices) triangles.indices.push_back(first + index);
        }
        const bool isEmpty = triangles.indices.empty();
        meshes.push_back(isEmpty ? scene::kNone : static_cast<uint32_t>(result.meshes.size()));
        if (!isEmpty) result.meshes.push_back(std::move(triangles));
    }
    const std::vector<bool> visibleNodes = scene::VisibleNodes(data);
    for (const scene::Instance& instance : data.instances)
        if (meshes[instance.mesh] != scene::kNone && scene::IsVisible(visibleNodes, instance))
            result.instances.push_back({meshes[instance.mesh], instance.objectToWorld});
    return result;
}

std::vector<gpu::BenchRay> CameraRays(const scene::CameraView& view, Extent2D size) {
    std::vector<gpu::BenchRay> rays;
    rays.reserve(size_t{size.width} * size.height);
    const bool isParallel = view.projection == scene::Projection::Orthographic;
    const double halfHeight = isParallel ? 0.5 * double{view.height} : std::tan(0.5 * double{view.yFov});
    const glm::dvec3 forward(view.forward);
    const glm::dvec3 up = halfHeight * glm::dvec3(view.up);
    const glm::dvec3 right = halfHeight * double{view.aspect} * glm::dvec3(view.right);
    const auto add = [&](uint32_t x, uint32_t y) {
        const glm::dvec3 offset =
            ((2 * x + 1.0) / size.width - 1.0) * right + (1.0 - (2 * y + 1.0) / size.height) * up;
        rays.push_back({.origin = isParallel ? view.eye + offset : view.eye,
                        .tMax = kFarthest,
                        .direction = isParallel ? forward : glm::normalize(forward + offset)});
    };
    for (uint32_t tileY = 0; tileY < size.height; tileY += kTileHeight)
        for (uint32_t tileX = 0; tileX < size.width; tileX += kTileWidth)
            for (uint32_t y = tileY; y < std::min(tileY + kTileHeight, size.height); ++y)
                for (uint32_t x = tileX; x < std::min(tileX + kTileWidth, size.width); ++x) add(x, y);
    return rays;
}

std::vector<gpu::BenchRay> BounceRays(const BvhScene& scene, std::span<const gpu::BenchRay> rays,
                                      std::span<const gpu::WideHit> hits, uint32_t seed) {
    return RaysFrom(scene, rays, hits, [seed](const Place& place, uint32_t i) {
        // The normal and a point of the unit sphere add up to a cosine distribution
        const double z = 1.0 - 2.0 * UnitNumber(seed, i, 0);
        const double angle = 2.0 * glm::pi<double>() * UnitNumber(seed, i, 1);
        const double radius = std::sqrt(std::max(1.0 - z * z, 0.0));
        const glm::dvec3 sum =
            place.normal * (1.0 + 1e-6) + glm::dvec3(radius * std::cos(angle), radius * std::sin(angle), z);
        return gpu::BenchRay{.origin = place.position, .tMax = kFarthest, .direction = glm::normalize(sum)};
    });
}

std::vector<gpu::BenchRay> ShadowRays(const BvhScene& scene, std::span<const gpu::BenchRay> rays,
                                      std::span<const gpu::WideHit> hits, uint32_t seed) {
    Box bounds;
    for (const Box& box : InstanceBoxes(scene)) bounds.Extend(box);
    const glm::dvec3 low(bounds.min), size(bounds.max - bounds.min);
    return RaysFrom(scene, rays, hits, [&](const Place& place, uint32_t i) {
        const glm::dvec3 share(0.25 + 0.5 * UnitNumber(seed, i, 0), 0.99,
                               0.25 + 0.5 * UnitNumber(seed, i, 1));
        const glm::dvec3 way = low + share * size - place.position;
        const double distance = std::max(glm::length(way), 1e-30);
        return gpu::BenchRay{.origin = place.position,
                             .tMax = static_cast<float>(0.999 * distance),
                             .direction = way / distance};
    });
}

}  // namespace raygraph::cli
