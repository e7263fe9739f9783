#include "renderer/scene/model/scene_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <span>

#include "base/check.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/geometry/split_mesh.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/model/check.h"

namespace raygraph::scene {
namespace {

uint64_t SphereCount(const Primitive& primitive) {
    uint64_t count = 0;
    for (size_t i = 0; i < primitive.radii.size(); ++i)
        count += primitive.indices[2 * i] == primitive.indices[2 * i + 1] ? 1 : 0;
    return count;
}

}  // namespace

void Bounds::Extend(const glm::vec3& point) {
    min = glm::min(min, point);
    max = glm::max(max, point);
}

void Bounds::Extend(const Bounds& other) {
    min = glm::min(min, other.min);
    max = glm::max(max, other.max);
}

Bounds Bounds::Transformed(const glm::mat4x3& transform) const {
    if (IsEmpty()) return {};
    // Each coordinate of a corner is a sum of one term an axis. Rounding keeps the order of numbers, so that
    // the smallest terms give the smallest sum, bit for bit.
    const auto low = [&](int axis) {
        return glm::min(transform[axis] * min[axis], transform[axis] * max[axis]);
    };
    const auto high = [&](int axis) {
        return glm::max(transform[axis] * min[axis], transform[axis] * max[axis]);
    };
    Bounds result;
    result.min = low(0) + low(1) + low(2) + transform[3];
    result.max = high(0) + high(1) + high(2) + transform[3];
    return result;
}

namespace {

// Returns the single-scattering albedo of a medium whose half space, seen from within, has the albedo
// `color`: Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks", as
// KHR_materials_volume_scatter says.
float SingleScatteringAlbedo(float color, float anisotropy) {
    if (!(color > 0.0f)) return 0.0f;
    const float s =
        4.09712f + 4.20863f * color - std::sqrt(9.59217f + 41.6808f * color + 17.7126f * color * color);
    return std::clamp((1.0f - s * s) / (1.0f - anisotropy * s * s), 0.0f, 1.0f);
}

}  // namespace

std::vector<TextureRef> Material::DirectionalTextures() const {
    std::vector<TextureRef> textures;
    if (normalTexture.IsPresent()) textures.push_back(normalTexture);
    if (IsAnisotropic() && anisotropyTexture.IsPresent()) textures.push_back(anisotropyTexture);
    if (clearcoatNormalTexture.IsPresent()) textures.push_back(clearcoatNormalTexture);
    if (IsAnisotropic() && textures.empty()) textures.emplace_back();
    return textures;
}

glm::vec3 Material::Extinction() const {
    glm::vec3 extinction(0.0f);
    if (attenuationDistance == 0.0f) return extinction;
    for (int i = 0; i < 3; ++i)
        if (attenuationColor[i] < 1.0f)  // The logarithm of 0 is minus infinity.
            extinction[i] = std::min(-std::log(attenuationColor[i]) / attenuationDistance, kMaxExtinction);
    return extinction;
}

glm::vec3 Material::Scattering() const {
    const glm::vec3 color =
        scatterStrengthFactor > 0.0f ? scatterStrengthFactor * scatterColorFactor : multiscatterColorFactor;
    glm::vec3 scattering = Extinction();
    for (int i = 0; i < 3; ++i) scattering[i] *= SingleScatteringAlbedo(color[i], ScatteringMeanCosine());
    return scattering;
}

float Material::ScatteringMeanCosine() const {
    return scatterStrengthFactor > 0.0f ? scatterMeanCosine : scatterAnisotropy;
}

glm::mat4x3 Node::LocalTransform() const {
    if (matrix) return *matrix;
    const glm::mat3 rotated = glm::mat3_cast(rotation);
    return {rotated[0] * scale.x, rotated[1] * scale.y, rotated[2] * scale.z, translation};
}

glm::mat4x3 PlacedTransform::RelativeTo(const glm::dvec3& origin) const {
    return {matrix[0], matrix[1], matrix[2], glm::vec3(Place() - origin)};
}

PlacedTransform Compose(const PlacedTransform& a, const PlacedTransform& b) {
    const glm::mat3 linear(a.matrix);
    const FloatPair place = ToFloatPair(glm::dmat3(linear) * b.Place() + a.Place());
    return {{linear * b.matrix[0], linear * b.matrix[1], linear * b.matrix[2], place.rounded}, place.rest};
}

std::vector<PlacedTransform> WorldTransforms(const SceneData& scene) {
    std::vector<PlacedTransform> transforms(scene.nodes.size());
    for (const uint32_t index : scene.nodeOrder) {
        const Node& node = scene.nodes[index];
        const PlacedTransform local{node.LocalTransform(), node.translationResidual};
        transforms[index] = node.parent == kNone ? local : Compose(transforms[node.parent], local);
    }
    return transforms;
}

PlacedTransform PlaceInstance(const PlacedTransform& nodeToWorld, const Instance& instance) {
    if (instance.objectToNode == glm::mat4x3(1.0f)) return nodeToWorld;
    return Compose(nodeToWorld, {instance.objectToNode, glm::vec3(0.0f)});
}

namespace {

// Computes the boxes of deformed instances in object space, once for each shape: a mesh, a skin and weights.
class DeformedBoxes {
  public:
    DeformedBoxes(const SceneData& scene, std::span<const PlacedTransform> nodeToWorld)
        : m_scene(scene), m_nodeToWorld(nodeToWorld), m_matrices(scene.skins.size()) {}

    const Bounds& Of(const Instance& instance, uint32_t skin) {
        const bool hasWeights = instance.node != kNone && !m_scene.nodes[instance.node].weights.empty();
        const auto [found, isNew] =
            m_boxes.try_emplace({instance.mesh, skin, hasWeights ? instance.node : kNone});
        if (!isNew) return found->second;
        const std::span<const glm::mat4x3> matrices = MatricesOf(skin);
        for (const Primitive& primitive : m_scene.meshes[instance.mesh].primitives)
            found->second.Extend(DeformedBounds(primitive, MorphWeights(m_scene, instance), matrices));
        return found->second;
    }

  private:
    std::span<const glm::mat4x3> MatricesOf(uint32_t index) {
        if (index == kNone) return {};
        const Skin& skin = m_scene.skins[index];
        if (m_matrices[index].empty()) {
            m_matrices[index].resize(skin.joints.size());
            JointMatrices(m_nodeToWorld, skin, SkinFrame(m_nodeToWorld, skin), m_matrices[index]);
        }
        return m_matrices[index];
    }

    const SceneData& m_scene;
    std::span<const PlacedTransform> m_nodeToWorld;
    std::vector<std::vector<glm::mat4x3>> m_matrices;  // indexed by skin
    std::map<std::array<uint32_t, 3>, Bounds> m_boxes;
};

}  // namespace

void UpdateWorldTransforms(SceneData& scene) {
    const std::vector<PlacedTransform> transforms = WorldTransforms(scene);
    // Objects that an editor has removed keep their placement, and do not count for the bounds
    std::vector<bool> isPresent(scene.nodes.size(), false);
    for (const uint32_t node : scene.nodeOrder) isPresent[node] = true;
    const auto place = [&](uint32_t node, glm::mat4x3& matrix, glm::vec3& rest) {
        if (node == kNone || !isPresent[node]) return;
        const PlacedTransform placed = WithDirections(scene, node, transforms[node]);
        matrix = placed.matrix;
        rest = placed.rest;
    };
    std::vector<Bounds> meshBounds(scene.meshes.size());
    for (size_t i = 0; i < scene.meshes.size(); ++i)
        for (const Primitive& primitive : scene.meshes[i].primitives) meshBounds[i].Extend(primitive.bounds);
    DeformedBoxes boxes(scene, transforms);
    const std::vector<bool> isVisible = VisibleNodes(scene);
    scene.bounds = {};
    for (Instance& instance : scene.instances) {
        RG_CHECK_LT(instance.mesh, scene.meshes.size());
        if (instance.node != kNone && !isPresent[instance.node]) continue;
        const uint32_t skin =
            instance.isDeformed && HasSkin(scene, instance) ? scene.nodes[instance.node].skin : kNone;
        if (instance.node != kNone) {
            const PlacedTransform placed = skin != kNone ? SkinFrame(transforms, scene.skins[skin])
                                                         : PlaceInstance(transforms[instance.node], instance);
            const std::optional<PlacedTransform> shown = WithThickness(scene, instance, placed);
            instance.isCollapsed = instance.isCollapsed && !shown;
            if (!instance.isCollapsed) {
                instance.objectToWorld = shown.value_or(placed).matrix;
                instance.translationResidual = shown.value_or(placed).rest;
            }
        }
        const Bounds& shape = instance.isDeformed ? boxes.Of(instance, skin) : meshBounds[instance.mesh];
        const Bounds bounds = shape.Transformed(instance.objectToWorld);
        // Joints may move vertices anywhere
        if (instance.isDeformed && !shape.IsEmpty() &&
            !(IsFinite(shape.min) && IsFinite(shape.max) && IsFinite(bounds.min) && IsFinite(bounds.max)))
            instance.isCollapsed = true;
        if (IsVisible(isVisible, instance)) scene.bounds.Extend(bounds);
    }
    for (Camera& camera : scene.cameras) place(camera.node, camera.cameraToWorld, camera.translationResidual);
    for (Light& light : scene.lights) place(light.node, light.lightToWorld, light.translationResidual);
}

std::vector<bool> VisibleNodes(const SceneData& scene) {
    std::vector<bool> isVisible(scene.nodes.size(), true);
    for (const uint32_t node : scene.nodeOrder)
        isVisible[node] = scene.nodes[node].isVisible && IsVisible(isVisible, scene.nodes[node].parent);
    return isVisible;
}

bool HasVisibleLight(const SceneData& scene) {
    const std::vector<bool> isVisible = VisibleNodes(scene);
    return std::ranges::any_of(scene.lights,
                               [&](const Light& light) { return IsVisible(isVisible, light.node); });
}

bool HasEmission(const SceneData& scene) {
    const std::vector<bool> isVisible = VisibleNodes(scene);
    std::vector<bool> isEmitting(scene.materials.size());
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        const Material& material = scene.materials[i];
        const glm::vec3 emitted =
            material.isUnlit ? glm::vec3(material.baseColorFactor) : material.EmittedRadiance();
        isEmitting[i] = emitted != glm::vec3(0.0f);
    }
    return std::ranges::any_of(scene.instances, [&](const Instance& instance) {
        if (!IsVisible(isVisible, instance)) return false;
        return std::ranges::any_of(scene.meshes[instance.mesh].primitives,
                                   [&](const Primitive& p) { return isEmitting[p.material]; });
    });
}

uint8_t LowestAlpha(const ImageData& image) {
    if (image.lowestAlpha) return *image.lowestAlpha;
    // The texels are read in parts, each without a branch for each texel.
    constexpr size_t kPart = size_t{4} << 12;
    uint8_t lowest = 255;
    for (size_t start = 0; start < image.rgba.size() && lowest > 0; start += kPart) {
        const size_t end = std::min(start + kPart, image.rgba.size());
        for (size_t i = start + 3; i < end; i += 4) lowest = std::min(lowest, image.rgba[i]);
    }
    return lowest;
}

SceneStatistics Statistics(const SceneData& scene) {
    std::vector<uint64_t> triangles(scene.meshes.size(), 0), spheres = triangles, capsules = triangles;
    SceneStatistics statistics;
    for (size_t i = 0; i < scene.meshes.size(); ++i) {
        for (const Primitive& primitive : scene.meshes[i].primitives) {
            triangles[i] += primitive.TriangleCount();
            const uint64_t sphereCount = SphereCount(primitive);
            spheres[i] += sphereCount;
            capsules[i] += primitive.radii.size() - sphereCount;
            statistics.geometryBytes += StreamBytes(primitive);
        }
    }
    std::vector<bool> isPlaced(scene.meshes.size(), false);
    for (const Instance& instance : scene.instances) {
        statistics.placedTriangles += triangles[instance.mesh];
        statistics.placedSpheres += spheres[instance.mesh];
        statistics.placedCapsules += capsules[instance.mesh];
        if (!isPlaced[instance.mesh]) {
            statistics.uniqueTriangles += triangles[instance.mesh];
            ++statistics.meshCount;
        }
        isPlaced[instance.mesh] = true;
    }
    for (const ImageData& image : scene.images) {
        statistics.imageBytes += std::span(image.rgba).size_bytes();
        for (const std::vector<std::byte>& level : image.blocks.levels) statistics.imageBytes += level.size();
    }
    statistics.imageBytes += std::span(scene.environment.map.rgba).size_bytes();
    statistics.instanceCount = scene.instances.size();
    statistics.materialCount = scene.materials.size();
    statistics.textureCount = scene.textures.size();
    statistics.lightCount = scene.lights.size();
    statistics.cameraCount = scene.cameras.size();
    return statistics;
}

}  // namespace raygraph::scene
