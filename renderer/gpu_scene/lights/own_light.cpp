#include "renderer/gpu_scene/lights/own_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "renderer/bvh/facet_scene.h"
#include "renderer/gpu_scene/lights/emitters.h"
#include "renderer/gpu_scene/lights/surface_glow.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/model/camera_view.h"
#include "shaders/shared/ray_clearance.h"

namespace raygraph {

namespace {

// The fraction of the visible surface points that must be visible in the scene's own light.
constexpr double kLeastShare = 0.25;
// Points with this luminance are visible: six stops below middle gray, which is all but black in a picture at
// exposure 0.
constexpr double kLeastLuminance = 0.18 / 64.0;
constexpr float kReflectance = 0.5f;
constexpr size_t kMaxCameras = 8;
constexpr uint32_t kPointsAcross = 32;  // points along the longer side of a view
constexpr uint32_t kPaths = 16;
constexpr float kAspect = 16.0f / 9.0f;

// A generator of numbers in [0, 1) whose sequence is the same on every platform.
class Random {
  public:
    float Next() { return static_cast<float>(m_engine() >> 8) * 0x1p-24f; }

  private:
    std::mt19937 m_engine;
};

class Measurement {
  public:
    // `glow` must be that of the scene.
    Measurement(const scene::SceneData& scene, SurfaceGlow& glow, uint32_t maxThreads)
        : m_data(scene),
          m_glow(glow),
          m_center(scene.bounds.IsEmpty() ? glm::vec3(0.0f) : scene.bounds.Center()) {
        Collect(maxThreads);
    }

    bool IsLit() {
        double shown = 0.0, seen = 0.0;
        const size_t cameras = std::min(m_data.cameras.size(), kMaxCameras);
        const auto across = static_cast<uint32_t>(
            kPointsAcross / std::sqrt(static_cast<double>(std::max<size_t>(cameras, 1))));
        for (size_t i = 0; i < cameras; ++i) {
            const scene::Camera& camera = m_data.cameras[i];
            const float aspect = camera.aspectRatio > 0.0f ? camera.aspectRatio : kAspect;
            Look(scene::ViewOf(camera, aspect), m_center, across, shown, seen);
        }
        if (seen == 0.0) {
            const Box& box = m_facets->Bounds();
            Look(scene::ViewOfBounds({box.min, box.max}, kAspect), glm::dvec3(0.0), kPointsAcross, shown,
                 seen);
        }
        return seen > 0.0 && shown >= kLeastShare * seen;
    }

  private:
    // Returns the placed meshes. One that is hidden in the current pose, and that glows when an animation
    // shows it, is included.
    std::vector<BvhInstance> Placed() const {
        const std::vector<bool> visible = scene::VisibleNodes(m_data);
        std::vector<BvhInstance> instances;
        for (const scene::Instance& instance : m_data.instances) {
            const bool isShown = scene::IsVisible(visible, instance) ||
                                 (scene::IsVisible(m_glow.Pose().visibleNodes, instance) &&
                                  m_glow.MayGlow(m_data.meshes[instance.mesh]));
            if (!isShown) continue;
            const scene::PlacedTransform placed{instance.objectToWorld, instance.translationResidual};
            instances.push_back({instance.mesh, placed.RelativeTo(m_center)});
        }
        return instances;
    }

    void Collect(uint32_t maxThreads) {
        std::vector<BvhInstance> instances = Placed();
        std::vector<std::vector<Facet>> meshes(m_data.meshes.size());
        m_weights.resize(meshes.size());
        std::vector<glm::dmat3> squares(meshes.size(), glm::dmat3(0.0));  // sums of weight n n^T
        std::vector<bool> isAdded(meshes.size());
        EmitterFinder finder(m_data);
        for (const BvhInstance& instance : instances) {
            if (isAdded[instance.mesh]) continue;
            isAdded[instance.mesh] = true;
            std::vector<Facet>& facets = meshes[instance.mesh];
            facets = m_glow.AddMesh(instance.mesh);
            const std::vector<float> means = m_glow.EmittedMeans(instance.mesh, facets.size(), finder);
            double sum = 0.0;
            for (size_t f = 0; f < facets.size(); ++f) {
                const Facet& facet = facets[f];
                const glm::dvec3 across(glm::cross(facet.p1 - facet.p0, facet.p2 - facet.p0));
                const double area = glm::length(across), weight = double{means[f]} * area;
                if (weight > 0.0)
                    squares[instance.mesh] += weight / (area * area) * glm::outerProduct(across, across);
                sum += weight;
                m_weights[instance.mesh].push_back(sum);
            }
        }
        double sum = 0.0;
        for (const BvhInstance& instance : instances) {
            sum += PlacedPower(instance.objectToWorld, m_weights[instance.mesh], squares[instance.mesh]);
            m_weightsOfInstances.push_back(sum);
        }
        const auto isSolid = [this](uint32_t instance, uint32_t facet, const glm::vec2& barycentrics) {
            const float opacity = m_glow.OpacityAt(m_facets->Instances()[instance].mesh, facet, barycentrics);
            // No number is drawn where the decision is certain
            return opacity > 0.0f && (opacity >= 1.0f || m_random.Next() < opacity);
        };
        m_facets.emplace(std::move(meshes), std::move(instances), maxThreads, isSolid);
    }

    // Returns the power of a placed mesh, from the sums of the powers of its facets. A transform scales an
    // area with the normal n by |C n|, where C are its cofactors. The whole mesh is scaled by the root mean
    // square of that, which is exact for a plane mesh and for a uniform scale.
    static double PlacedPower(const glm::mat4x3& objectToWorld, const std::vector<double>& sums,
                              const glm::dmat3& squares) {
        if (sums.empty() || !(sums.back() > 0.0)) return 0.0;
        const glm::dmat3 m{glm::mat3(objectToWorld)};
        const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
        const glm::dmat3 scaled = cofactors * squares * glm::transpose(cofactors);
        return std::sqrt(sums.back() * std::max(0.0, scaled[0][0] + scaled[1][1] + scaled[2][2]));
    }

    // Returns an estimate, from one point of one light, of what a white surface with this normal scatters.
    // Its expected value is the light of all lights that the surface scatters.
    float DirectLight(const glm::vec3& point, const glm::vec3& normal) {
        const double all = m_weightsOfInstances.empty() ? 0.0 : m_weightsOfInstances.back();
        if (all <= 0.0) return 0.0f;
        const auto choose = [&](const std::vector<double>& sums) {
            const auto found = std::ranges::upper_bound(sums, m_random.Next() * sums.back());
            return static_cast<uint32_t>(std::min<ptrdiff_t>(found - sums.begin(), std::ssize(sums) - 1));
        };
        const auto probability = [](const std::vector<double>& sums, uint32_t i) {
            return (sums[i] - (i > 0 ? sums[i - 1] : 0.0)) / sums.back();
        };
        const uint32_t i = choose(m_weightsOfInstances);
        const BvhInstance& instance = m_facets->Instances()[i];
        const uint32_t f = choose(m_weights[instance.mesh]);
        const Facet& facet = m_facets->FacetsOf(instance.mesh)[f];
        float u = m_random.Next(), v = m_random.Next();
        if (u + v > 1.0f) {
            u = 1.0f - u;
            v = 1.0f - v;
        }
        const auto place = [&](const glm::vec3& p) { return instance.objectToWorld * glm::vec4(p, 1.0f); };
        const glm::vec3 p0 = place(facet.p0), e1 = place(facet.p1) - p0, e2 = place(facet.p2) - p0;
        const glm::vec3 across = glm::cross(e1, e2);
        const glm::vec3 d = p0 + u * e1 + v * e2 - point;
        const float square = glm::dot(d, d);
        const double chance = probability(m_weightsOfInstances, i) * probability(m_weights[instance.mesh], f);
        if (!(square > 0.0f) || !(chance > 0.0)) return 0.0f;
        const float mirrored = scene::IsMirrored(instance.objectToWorld) ? -1.0f : 1.0f;
        // Twice the area, times both cosines, times the square of the distance
        const float received = glm::dot(normal, d);
        float sent = -mirrored * glm::dot(across, d);
        if (!facet.isBackCulled) sent = std::abs(sent);
        if (!(received > 0.0f && sent > 0.0f)) return 0.0f;
        const float luminance =
            m_glow.LuminanceAt(instance.mesh, f, {u, v}) * m_glow.OpacityAt(instance.mesh, f, {u, v});
        if (!(luminance > 0.0f) || m_facets->IsOccluded(point, d, 1.0f - 1e-3f)) return 0.0f;
        return static_cast<float>(luminance * 0.5 * sent * received /
                                  (double{square} * square * std::numbers::pi_v<float> * chance));
    }

    glm::vec3 ScatteredFrom(const glm::vec3& normal) {
        const float angle = 2.0f * std::numbers::pi_v<float> * m_random.Next(),
                    z = 2.0f * m_random.Next() - 1.0f;
        const float radius = std::sqrt(std::max(0.0f, 1.0f - z * z));
        // A point of the unit sphere around the tip of the normal is distributed in proportion to the cosine
        const glm::vec3 direction = normal + glm::vec3(radius * std::cos(angle), radius * std::sin(angle), z);
        const float length = glm::length(direction);
        return length > 1e-3f ? direction / length : normal;
    }

    float LuminanceOf(const FacetHit& hit) const {
        return m_glow.LuminanceAt(MeshOf(hit), hit.facet, hit.barycentrics);
    }
    uint32_t MeshOf(const FacetHit& hit) const { return m_facets->Instances()[hit.instance].mesh; }
    bool IsUnlit(const FacetHit& hit) const { return m_glow.IsUnlit(MeshOf(hit), hit.facet); }

    // Returns the origin of rays that leave the surface. Its distance follows from the hit alone: a fraction
    // of the scene's size would lead through thin walls.
    glm::vec3 StartAt(const FacetHit& hit) const {
        const BvhInstance& instance = m_facets->Instances()[hit.instance];
        const Facet& facet = m_facets->FacetsOf(instance.mesh)[hit.facet];
        const glm::vec3 e1 = facet.p1 - facet.p0, e2 = facet.p2 - facet.p0;
        const glm::vec3 p = facet.p0 + hit.barycentrics.x * e1 + hit.barycentrics.y * e2;
        const float clearance = gpu::RayClearance(glm::mat3(instance.objectToWorld),
                                                  instance.objectToWorld[3], facet.p0, e1, e2, p);
        return instance.objectToWorld * glm::vec4(p, 1.0f) + clearance * hit.normal;
    }

    bool IsVisible(const FacetHit& hit) {
        const double shown = LuminanceOf(hit);
        if (shown >= kLeastLuminance) return true;
        if (IsUnlit(hit)) return false;
        const glm::vec3 start = StartAt(hit);
        // Each of the two strategies finds all lights that shine there: the first is good for small lights,
        // the second for the nearest of many
        double sampled = 0.0, found = 0.0, scattered = 0.0;
        for (uint32_t i = 0; i < kPaths; ++i) {
            sampled += kReflectance * DirectLight(start, hit.normal);
            const glm::vec3 direction = ScatteredFrom(hit.normal);
            const std::optional<FacetHit> next = m_facets->Trace(start, direction);
            if (!next) continue;
            found += kReflectance * LuminanceOf(*next);
            if (IsUnlit(*next)) continue;
            scattered += kReflectance * kReflectance * DirectLight(StartAt(*next), next->normal);
        }
        return shown + (std::max(sampled, found) + scattered) / kPaths >= kLeastLuminance;
    }

    // `origin` is that of the facets, in the space of the view.
    void Look(const scene::CameraView& view, const glm::dvec3& origin, uint32_t across, double& shown,
              double& seen) {
        const glm::vec3 eye(view.eye - origin);
        const bool isParallel = view.projection == scene::Projection::Orthographic;
        const float halfY = isParallel ? 0.5f * view.height : std::tan(0.5f * view.yFov);
        for (uint32_t i = 0; i < across * across; ++i) {
            const float x = (static_cast<float>(i % across) + m_random.Next()) / static_cast<float>(across);
            const float y = (static_cast<float>(i / across) + m_random.Next()) / static_cast<float>(across);
            const glm::vec3 aside =
                (2.0f * x - 1.0f) * halfY * view.aspect * view.right + (1.0f - 2.0f * y) * halfY * view.up;
            const glm::vec3 from = isParallel ? eye + aside : eye;
            const glm::vec3 direction = isParallel ? view.forward : glm::normalize(view.forward + aside);
            const std::optional<FacetHit> hit = m_facets->Trace(from, direction);
            if (!hit) continue;
            seen += 1.0;
            shown += IsVisible(*hit) ? 1.0 : 0.0;
        }
    }

    const scene::SceneData& m_data;
    SurfaceGlow& m_glow;
    glm::dvec3 m_center;  // center of the facets' coordinates
    std::optional<FacetScene> m_facets;
    // Prefix sums of the powers of lights: by mesh and facet, and over all lights of instances.
    std::vector<std::vector<double>> m_weights;
    std::vector<double> m_weightsOfInstances;
    Random m_random;
};

}  // namespace

bool MayHaveOwnLight(const scene::SceneData& scene) {
    return SurfaceGlow(scene).IsAny();
}

bool HasOwnLight(const scene::SceneData& scene, uint32_t maxThreads) {
    SurfaceGlow glow(scene);
    if (glow.Pose().hasLight) return true;
    return glow.IsAny() && Measurement(scene, glow, maxThreads).IsLit();
}

}  // namespace raygraph
