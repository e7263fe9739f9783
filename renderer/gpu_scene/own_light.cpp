#include "renderer/gpu_scene/own_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "renderer/bvh/facet_scene.h"
#include "renderer/gpu_scene/emitters.h"
#include "renderer/scene/camera_view.h"

namespace raygraph {

namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kReflectance = 0.5f;
constexpr size_t kMaxCameras = 8;
constexpr uint32_t kPointsAcross = 32;  // of a view, where there is one
constexpr uint32_t kPaths = 16;
constexpr float kAspect = 16.0f / 9.0f;

bool MayShine(const scene::SceneData& scene) {
    if (scene.lights.empty()) return false;
    for (const scene::Animation& animation : scene.animations)
        for (const scene::AnimationChannel& channel : animation.channels)
            if (channel.target.property == scene::AnimatedProperty::LightField ||
                channel.target.property == scene::AnimatedProperty::Visibility)
                return true;
    const std::vector<bool> visible = scene::VisibleNodes(scene);
    return std::ranges::any_of(scene.lights, [&](const scene::Light& light) {
        return scene::IsVisible(visible, light.node) && light.intensity > 0.0f &&
               light.color != glm::vec3(0.0f);
    });
}

// Numbers in [0, 1) that are the same everywhere.
class Random {
  public:
    float Next() { return static_cast<float>(m_engine() >> 8) * 0x1p-24f; }

  private:
    std::mt19937 m_engine;
};

// What a surface shows without being lit, as luminance.
struct Glow {
    float luminance = 0.0f;
    bool isLight = false;  // of what emits; an unlit surface is none
};

// The twelve triangles of a square bar around each capsule, or of a cube around a sphere.
void AppendBars(const scene::Primitive& primitive, std::vector<Facet>& facets) {
    for (size_t i = 0; i < primitive.radii.size(); ++i) {
        const glm::vec3 a = primitive.positions[primitive.indices[2 * i]];
        const glm::vec3 b = primitive.positions[primitive.indices[2 * i + 1]];
        const float radius = primitive.radii[i], length = glm::distance(a, b);
        const glm::vec3 axis = length > 0.0f ? (b - a) / length : glm::vec3(0.0f, 0.0f, 1.0f);
        const glm::vec3 other = std::abs(axis.x) < 0.5f ? glm::vec3(1.0f, 0.0f, 0.0f) : glm::vec3(0, 1, 0);
        const glm::vec3 u = radius * glm::normalize(glm::cross(axis, other)), v = glm::cross(axis, u);
        glm::vec3 corners[8];
        for (uint32_t c = 0; c < 8; ++c)
            corners[c] = ((c & 4u) != 0 ? b + radius * axis : a - radius * axis) + ((c & 1u) != 0 ? u : -u) +
                         ((c & 2u) != 0 ? v : -v);
        constexpr uint8_t kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                          {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
        for (const auto& face : kFaces) {
            facets.push_back({corners[face[0]], corners[face[1]], corners[face[2]]});
            facets.push_back({corners[face[0]], corners[face[2]], corners[face[3]]});
        }
    }
}

class Measurement {
  public:
    Measurement(const scene::SceneData& scene, uint32_t maxThreads)
        : m_data(scene), m_center(scene.bounds.IsEmpty() ? glm::vec3(0.0f) : scene.bounds.Center()) {
        const std::vector<bool> animated = AnimatedEmission(scene);
        m_radiances.resize(scene.materials.size());
        for (size_t i = 0; i < m_radiances.size(); ++i) {
            const scene::Material& material = scene.materials[i];
            m_radiances[i] = static_cast<float>(Luminance(material.EmittedRadiance()));
            if (animated[i]) m_radiances[i] = std::max(m_radiances[i], 1.0f);
        }
        Collect(maxThreads);
    }

    // None: no surface shows anything by itself.
    bool IsDark() const { return !m_facets; }
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
        return seen > 0.0 && shown >= kOwnLightShare * seen;
    }

  private:
    bool ShowsItself(const scene::Primitive& primitive) const {
        return m_radiances[primitive.material] > 0.0f || m_data.materials[primitive.material].isUnlit;
    }

    void Collect(uint32_t maxThreads) {
        const std::vector<bool> visible = scene::VisibleNodes(m_data);
        std::vector<bool> isPlaced(m_data.meshes.size());
        std::vector<BvhInstance> instances;
        bool showsSomething = false;
        for (const scene::Instance& instance : m_data.instances) {
            if (!scene::IsVisible(visible, instance)) continue;
            isPlaced[instance.mesh] = true;
            const scene::PlacedTransform placed{instance.objectToWorld, instance.translationRest};
            instances.push_back({instance.mesh, placed.RelativeTo(m_center)});
            showsSomething |= std::ranges::any_of(m_data.meshes[instance.mesh].primitives,
                                                  [&](const auto& p) { return ShowsItself(p); });
        }
        if (!showsSomething) return;
        m_glows.resize(m_data.meshes.size());
        m_weights.resize(m_data.meshes.size());
        std::vector<std::vector<Facet>> meshes(m_data.meshes.size());
        EmitterFinder finder(m_data);
        for (uint32_t i = 0; i < meshes.size(); ++i) {
            if (!isPlaced[i]) continue;
            for (const scene::Primitive& primitive : m_data.meshes[i].primitives)
                Append(primitive, finder, meshes[i], m_glows[i]);
            double sum = 0.0;
            for (size_t f = 0; f < meshes[i].size(); ++f) {
                const Facet& facet = meshes[i][f];
                if (m_glows[i][f].isLight)
                    sum += double{m_glows[i][f].luminance} *
                           glm::length(glm::dvec3(glm::cross(facet.p1 - facet.p0, facet.p2 - facet.p0)));
                m_weights[i].push_back(sum);
            }
        }
        double sum = 0.0;
        for (const BvhInstance& instance : instances) {
            const double scale =
                std::cbrt(std::abs(glm::determinant(glm::dmat3(glm::mat3(instance.objectToWorld)))));
            const std::vector<double>& weights = m_weights[instance.mesh];
            sum += weights.empty() ? 0.0 : weights.back() * scale * scale;
            m_weightsOfInstances.push_back(sum);
        }
        m_facets.emplace(std::move(meshes), std::move(instances), maxThreads);
        m_clearance = 1e-5f * glm::length(m_facets->Bounds().max - m_facets->Bounds().min);
    }

    void Append(const scene::Primitive& primitive, EmitterFinder& finder, std::vector<Facet>& facets,
                std::vector<Glow>& glows) const {
        const scene::Material& material = m_data.materials[primitive.material];
        const float radiance = m_radiances[primitive.material];
        const bool isClear = material.IsTransmissive() || material.alphaMode == scene::AlphaMode::Blend;
        if (isClear && !ShowsItself(primitive)) return;
        const size_t first = facets.size();
        Glow glow{.luminance = radiance, .isLight = radiance > 0.0f};
        // An unlit surface shows its base color, dark or not: light would not change it
        if (material.isUnlit) glow.luminance = static_cast<float>(kOwnLightLuminance);
        if (primitive.IsRound()) {
            AppendBars(primitive, facets);
            glows.resize(facets.size(), glow);
            return;
        }
        const auto corner = [&](size_t i) { return primitive.positions[primitive.indices[i]]; };
        for (size_t i = 0; i + 2 < primitive.indices.size(); i += 3)
            facets.push_back({corner(i), corner(i + 1), corner(i + 2), material.IsBackCulled()});
        glows.resize(facets.size(), glow);
        if (!glow.isLight || !material.emissiveTexture.IsPresent()) return;
        for (size_t i = first; i < glows.size(); ++i) glows[i] = {};
        const GroupTriangles triangles{.positions = primitive.positions,
                                       .indices = primitive.indices,
                                       .geometries = {},
                                       .originals = {},
                                       .firstVertices = {0}};
        const scene::Primitive* const only = &primitive;
        glm::vec3 factor = material.EmittedRadiance();
        if (Luminance(factor) < radiance) factor = glm::vec3(radiance);  // an animation makes it that
        for (const Emitter& emitter : finder.Find(triangles, {&only, 1}, material.isDoubleSided).emitters)
            glows[first + emitter.primitive] = {static_cast<float>(Luminance(factor * emitter.meanTexture)),
                                                true};
    }

    // An estimate, from one point of one light, of what a white surface with this normal scatters. Its mean
    // is what all lights make it scatter.
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
        const float mirrored = glm::determinant(glm::mat3(instance.objectToWorld)) < 0.0f ? -1.0f : 1.0f;
        // Twice the area times both cosines times the square of the distance
        const float received = glm::dot(normal, d);
        float sent = -mirrored * glm::dot(across, d);
        if (!facet.isBackCulled) sent = std::abs(sent);
        if (!(received > 0.0f && sent > 0.0f)) return 0.0f;
        if (m_facets->IsOccluded(point, d, 1.0f - 1e-3f)) return 0.0f;
        const float luminance = m_glows[instance.mesh][f].luminance;
        return static_cast<float>(luminance * 0.5 * sent * received /
                                  (double{square} * square * kPi * chance));
    }

    glm::vec3 ScatteredFrom(const glm::vec3& normal) {
        const float angle = 2.0f * kPi * m_random.Next(), z = 2.0f * m_random.Next() - 1.0f;
        const float radius = std::sqrt(std::max(0.0f, 1.0f - z * z));
        // A point of the unit sphere about the tip of the normal: in proportion to the cosine
        const glm::vec3 direction = normal + glm::vec3(radius * std::cos(angle), radius * std::sin(angle), z);
        const float length = glm::length(direction);
        return length > 1e-3f ? direction / length : normal;
    }

    const Glow& GlowOf(const FacetHit& hit) const {
        return m_glows[m_facets->Instances()[hit.instance].mesh][hit.facet];
    }

    bool IsVisible(const FacetHit& hit, const glm::vec3& point) {
        if (GlowOf(hit).luminance >= static_cast<float>(kOwnLightLuminance)) return true;
        const glm::vec3 start = point + m_clearance * hit.normal;
        // Either way finds all lights that shine there: small ones best the first, those among many that are
        // near best the second
        double sampled = 0.0, found = 0.0, scattered = 0.0;
        for (uint32_t i = 0; i < kPaths; ++i) {
            sampled += kReflectance * DirectLight(start, hit.normal);
            const glm::vec3 direction = ScatteredFrom(hit.normal);
            const std::optional<FacetHit> next = m_facets->Trace(start, direction);
            if (!next) continue;
            found += kReflectance * GlowOf(*next).luminance;
            const glm::vec3 there = start + next->t * direction + m_clearance * next->normal;
            scattered += kReflectance * kReflectance * DirectLight(there, next->normal);
        }
        return (std::max(sampled, found) + scattered) / kPaths >= kOwnLightLuminance;
    }

    // `origin`: of the facets, in the space of the view.
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
            shown += IsVisible(*hit, from + hit->t * direction) ? 1.0 : 0.0;
        }
    }

    const scene::SceneData& m_data;
    glm::dvec3 m_center;             // of the facets' coordinates
    std::vector<float> m_radiances;  // luminance that materials emit, before the texture
    std::optional<FacetScene> m_facets;
    float m_clearance = 0.0f;                // from a surface to where rays begin
    std::vector<std::vector<Glow>> m_glows;  // by mesh and facet
    // Sums of the powers of lights, up to each: by mesh and facet, and of all lights of instances.
    std::vector<std::vector<double>> m_weights;
    std::vector<double> m_weightsOfInstances;
    Random m_random;
};

}  // namespace

bool HasOwnLight(const scene::SceneData& scene, uint32_t maxThreads) {
    if (MayShine(scene)) return true;
    Measurement measurement(scene, maxThreads);
    return !measurement.IsDark() && measurement.IsLit();
}

}  // namespace raygraph
