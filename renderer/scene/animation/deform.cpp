#include "renderer/scene/animation/deform.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/check.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/geometry/triangles.h"
#include "renderer/scene/model/check.h"
#include "shaders/shared/unit_vector.h"

namespace raygraph::scene {
namespace {

// Returns a stream's element; 0 of one that is absent.
template <typename Vector>
Vector At(const std::vector<Vector>& stream, uint32_t vertex) {
    return stream.empty() ? Vector(0.0f) : stream[vertex];
}

// Returns a box in which the displacements of all targets lie. It contains 0.
Bounds DisplacementBounds(const Primitive& primitive, std::span<const float> weights) {
    Bounds sum{glm::vec3(0.0f), glm::vec3(0.0f)};
    for (size_t i = 0; i < weights.size() && i < primitive.targets.size(); ++i) {
        const Bounds& bounds = primitive.targets[i].bounds;
        if (bounds.IsEmpty()) continue;
        sum.min += glm::min(weights[i] * bounds.min, weights[i] * bounds.max);
        sum.max += glm::max(weights[i] * bounds.min, weights[i] * bounds.max);
    }
    return sum;
}

Bounds Sum(const Bounds& a, const Bounds& b) {
    return a.IsEmpty() ? a : Bounds{a.min + b.min, a.max + b.max};
}

}  // namespace

bool HasSkin(const SceneData& scene, const Instance& instance) {
    return instance.node != kNone && scene.nodes[instance.node].skin != kNone &&
           std::ranges::any_of(scene.meshes[instance.mesh].primitives,
                               [](const Primitive& p) { return !p.influences.IsEmpty(); });
}

bool HasTargets(const SceneData& scene, const Instance& instance) {
    return std::ranges::any_of(scene.meshes[instance.mesh].primitives,
                               [](const Primitive& p) { return !p.targets.empty(); });
}

void DeformInstances(SceneData& scene) {
    for (Instance& instance : scene.instances)
        instance.isDeformed = HasSkin(scene, instance) || HasTargets(scene, instance);
    UpdateWorldTransforms(scene);
}

PlacedTransform SkinFrame(std::span<const PlacedTransform> nodeToWorld, const Skin& skin) {
    const PlacedTransform& first = nodeToWorld[skin.joints.front()];
    const glm::dmat3 moved = glm::dmat3(first.matrix) * glm::dmat3(skin.inverseBinds.front());
    PlacedTransform frame;
    if (glm::determinant(moved) < 0.0) frame.matrix[0].x = -1.0f;
    const FloatPair place = ToFloatPair(first.Place());
    frame.matrix[3] = place.rounded;
    frame.rest = place.rest;
    return frame;
}

void JointMatrices(std::span<const PlacedTransform> nodeToWorld, const Skin& skin,
                   const PlacedTransform& objectToWorld, std::span<glm::mat4x3> matrices) {
    RG_CHECK_EQ(matrices.size(), skin.joints.size());
    const glm::dmat3 worldToObject = glm::inverse(glm::dmat3(objectToWorld.matrix));
    const glm::dvec3 origin = objectToWorld.Place();
    for (size_t i = 0; i < skin.joints.size(); ++i) {
        const PlacedTransform& joint = nodeToWorld[skin.joints[i]];
        const glm::dmat3 linear = worldToObject * glm::dmat3(joint.matrix);
        const glm::dmat4x3 bind(skin.inverseBinds[i]);
        const glm::dvec3 place = linear * bind[3] + worldToObject * (joint.Place() - origin);
        matrices[i] = {glm::vec3(linear * bind[0]), glm::vec3(linear * bind[1]), glm::vec3(linear * bind[2]),
                       glm::vec3(place)};
    }
}

std::span<const float> MorphWeights(const SceneData& scene, const Instance& instance) {
    if (instance.node != kNone && !scene.nodes[instance.node].weights.empty())
        return scene.nodes[instance.node].weights;
    return scene.meshes[instance.mesh].weights;
}

DeformedVertex MorphVertex(const Primitive& primitive, uint32_t vertex, std::span<const float> weights) {
    DeformedVertex base{primitive.positions[vertex], At(primitive.normals, vertex),
                        At(primitive.tangents, vertex)};
    if (weights.empty() || primitive.targets.empty()) return base;
    RG_CHECK_EQ(weights.size(), primitive.targets.size());
    glm::vec3 position = base.position, normal = base.normal, tangent(base.tangent);
    for (size_t i = 0; i < weights.size(); ++i) {
        position += weights[i] * At(primitive.targets[i].positions, vertex);
        normal += weights[i] * At(primitive.targets[i].normals, vertex);
        tangent += weights[i] * At(primitive.targets[i].tangents, vertex);
    }
    return {position, gpu::UnitOr(normal, base.normal),
            glm::vec4(gpu::UnitOr(tangent, glm::vec3(base.tangent)), base.tangent.w)};
}

DeformedVertex SkinVertex(const Primitive& primitive, uint32_t vertex, const DeformedVertex& morphed,
                          std::span<const glm::mat4x3> jointMatrices) {
    const JointInfluences& influences = primitive.influences;
    if (influences.IsEmpty()) return morphed;
    glm::mat4x3 sum(0.0f);
    const size_t first = size_t{influences.perVertex} * vertex;
    for (size_t i = first; i < first + influences.perVertex; ++i) {
        // The matrix of a joint that moves nothing need not be finite
        if (influences.weights[i] == 0.0f) continue;
        sum += influences.weights[i] * jointMatrices[influences.joints[i]];
    }
    const glm::mat3 linear(sum);
    return {sum * glm::vec4(morphed.position, 1.0f),
            gpu::UnitOr(Cofactors(linear) * morphed.normal, morphed.normal),
            glm::vec4(gpu::UnitOr(linear * glm::vec3(morphed.tangent), glm::vec3(morphed.tangent)),
                      morphed.tangent.w)};
}

glm::vec4 TangentInPlane(const glm::vec4& tangent, const glm::vec3& normal) {
    constexpr float kLeast = 1e-3f;  // below, what is left is rounding
    const glm::vec3 inPlane = glm::vec3(tangent) - glm::dot(glm::vec3(tangent), normal) * normal;
    const float length = glm::length(inPlane);
    return length > kLeast ? glm::vec4(inPlane / length, tangent.w) : tangent;
}

void DeformPrimitive(const Primitive& primitive, std::span<const float> weights,
                     std::span<const glm::mat4x3> jointMatrices, DeformedStreams& deformed) {
    const auto count = static_cast<uint32_t>(primitive.positions.size());
    deformed.positions.resize(count);
    deformed.normals.resize(primitive.normals.size());
    deformed.tangents.resize(primitive.tangents.size());
    for (uint32_t i = 0; i < count; ++i) {
        DeformedVertex vertex = MorphVertex(primitive, i, weights);
        if (!jointMatrices.empty()) vertex = SkinVertex(primitive, i, vertex, jointMatrices);
        deformed.positions[i] = vertex.position;
        if (!deformed.normals.empty()) deformed.normals[i] = vertex.normal;
        if (!deformed.tangents.empty()) deformed.tangents[i] = vertex.tangent;
    }
    if (primitive.hasFlatNormals) deformed.normals = FlatNormals(deformed.positions);
    const bool isMorphed = !weights.empty() && !primitive.targets.empty();
    if (deformed.normals.empty() || !(isMorphed || primitive.hasFlatNormals)) return;
    for (size_t i = 0; i < deformed.tangents.size(); ++i)
        deformed.tangents[i] = TangentInPlane(deformed.tangents[i], deformed.normals[i]);
}

Bounds DeformedBounds(const Primitive& primitive, std::span<const float> weights,
                      std::span<const glm::mat4x3> jointMatrices) {
    const Bounds displacement = DisplacementBounds(primitive, weights);
    const JointInfluences& influences = primitive.influences;
    if (jointMatrices.empty() || influences.IsEmpty()) return Sum(primitive.bounds, displacement);
    // A vertex is a weighted mean of where its joints move it, so it is between these places
    Bounds bounds;
    for (size_t i = 0; i < influences.bounds.size(); ++i) {
        const Bounds moved = Sum(influences.bounds[i], displacement);
        if (moved.IsEmpty()) continue;
        const Bounds placed = moved.Transformed(jointMatrices[i]);
        // A box of what is no number would be left out of the others
        constexpr float kInfinity = std::numeric_limits<float>::infinity();
        if (!IsFinite(jointMatrices[i]) || !IsFinite(moved.min) || !IsFinite(moved.max) ||
            !IsFinite(placed.min) || !IsFinite(placed.max))
            return {glm::vec3(-kInfinity), glm::vec3(kInfinity)};
        bounds.Extend(placed);
    }
    return bounds;
}

void UpdateDeformationBounds(Primitive& primitive) {
    for (MorphTarget& target : primitive.targets) {
        target.bounds = {};
        for (const glm::vec3& displacement : target.positions) target.bounds.Extend(displacement);
    }
    JointInfluences& influences = primitive.influences;
    influences.bounds.clear();
    for (size_t i = 0; i < influences.joints.size(); ++i) {
        const size_t joint = influences.joints[i];
        if (joint >= influences.bounds.size()) influences.bounds.resize(joint + 1);
        if (influences.weights[i] > 0.0f)
            influences.bounds[joint].Extend(primitive.positions[i / influences.perVertex]);
    }
}

}  // namespace raygraph::scene
