#include "renderer/gpu_scene/deform/deform_outline.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "renderer/gpu_scene/geometry/blas_set.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/model/check.h"
#include "shaders/shared/ray_clearance.h"

namespace raygraph {
namespace {

// Returns the part of a box that a view can show, whose squares are finite. Where a vertex moves beyond the
// range of floats, it may be anywhere in that part.
scene::Bounds Showable(const scene::Bounds& bounds) {
    const glm::vec3 far(1e15f);
    if (!scene::IsFinite(bounds.min) || !scene::IsFinite(bounds.max)) return {-far, far};
    return {glm::clamp(bounds.min, -far, far), glm::clamp(bounds.max, -far, far)};
}

// Bounds how far two devices, which round and fuse operations as they like, may disagree about a coordinate
// of a moved vertex. The terms of the sum may cancel, so their sizes count and not that of the result. Each
// passes, on either device, a product and the sum of the targets, a product and the sum of the joints'
// matrices, and a product and the sum of a matrix times a vector (N. Higham 2002, chapter 3).
float DisagreementAt(const scene::Primitive& part, size_t vertex, std::span<const float> weights,
                     std::span<const glm::mat4x3> jointMatrices) {
    glm::vec3 size = glm::abs(part.positions[vertex]);
    for (size_t i = 0; i < weights.size(); ++i)
        if (!part.targets[i].positions.empty())
            size += std::abs(weights[i]) * glm::abs(part.targets[i].positions[vertex]);
    size_t roundings = weights.size() + 1;
    const scene::JointInfluences& influences = part.influences;
    if (!jointMatrices.empty() && !influences.IsEmpty()) {
        glm::vec3 moved(0.0f);
        for (size_t i = influences.perVertex * vertex; i < influences.perVertex * (vertex + 1); ++i) {
            const glm::mat4x3& matrix = jointMatrices[influences.joints[i]];
            glm::vec3 terms = glm::abs(matrix[3]);
            for (int column = 0; column < 3; ++column) terms += glm::abs(matrix[column]) * size[column];
            moved += influences.weights[i] * terms;
        }
        size = moved;
        roundings += influences.perVertex + 4;
    }
    const float largest = std::max({size.x, size.y, size.z});
    return std::isfinite(largest) ? 2.0f * static_cast<float>(roundings) * gpu::kRoundoff * largest : 0.0f;
}

// Returns the vertices `from` of a primitive, whose positions have been moved out of it, with their joints,
// weights and targets.
scene::Primitive ExtractVertices(const scene::Primitive& primitive, std::span<const glm::vec3> positions,
                                 std::span<const uint32_t> from) {
    scene::Primitive kept;
    const scene::JointInfluences& influences = primitive.influences;
    kept.bounds = primitive.bounds;
    kept.influences.perVertex = influences.perVertex;
    kept.influences.bounds = influences.bounds;
    kept.targets.resize(primitive.targets.size());
    for (const uint32_t vertex : from) {
        kept.positions.push_back(positions[vertex]);
        for (size_t i = 0; i < influences.perVertex; ++i) {
            const size_t at = size_t{influences.perVertex} * vertex + i;
            kept.influences.joints.push_back(influences.joints[at]);
            kept.influences.weights.push_back(influences.weights[at]);
        }
    }
    for (size_t i = 0; i < kept.targets.size(); ++i) {
        const scene::MorphTarget& target = primitive.targets[i];
        kept.targets[i].bounds = target.bounds;
        if (target.positions.empty()) continue;
        for (const uint32_t vertex : from) kept.targets[i].positions.push_back(target.positions[vertex]);
    }
    return kept;
}

}  // namespace

DeformOutline::DeformOutline(const GroupTriangles& triangles, std::span<scene::Primitive* const> primitives,
                             std::span<const Emitter> emitters) {
    // Corners are indices of the group's vertices here, and are replaced by indices of the kept ones below
    for (const Emitter& emitter : emitters)
        for (size_t i = 0; i < 3; ++i)
            m_emitters.push_back(triangles.indices[size_t{3} * emitter.primitive + i]);
    const size_t count = triangles.indices.size() / 3, samples = std::min(count, RefitQuality::kSampleCount);
    for (size_t sample = 0; sample < samples; ++sample)
        for (size_t i = 0; i < 3; ++i)
            m_samples.push_back(triangles.indices[3 * (sample * count / samples) + i]);
    std::vector<glm::vec3> atRest;
    for (const uint32_t corner : m_samples) atRest.push_back(triangles.positions[corner]);
    m_fullness = Enclosure::Of(atRest).Fullness();
    std::vector<uint32_t> used = m_emitters;
    used.insert(used.end(), m_samples.begin(), m_samples.end());
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (std::vector<uint32_t>* corners : {&m_emitters, &m_samples})
        for (uint32_t& corner : *corners)
            corner = static_cast<uint32_t>(std::ranges::lower_bound(used, corner) - used.begin());

    size_t next = 0;
    for (size_t p = 0; p < primitives.size(); ++p) {
        const uint32_t firstVertex = triangles.firstVertices[p];
        const bool isLast = p + 1 == primitives.size();
        const size_t end = isLast ? triangles.positions.size() : triangles.firstVertices[p + 1];
        const size_t first = next;
        while (next < used.size() && used[next] < end) used[next++] -= firstVertex;
        const std::span<const glm::vec3> positions =
            std::span(triangles.positions).subspan(firstVertex, end - firstVertex);
        m_parts.push_back(
            ExtractVertices(*primitives[p], positions, std::span(used).subspan(first, next - first)));
    }
}

void DeformOutline::Deform(std::span<const float> weights, std::span<const glm::mat4x3> jointMatrices,
                           OutlinePose& pose) const {
    std::vector<glm::vec3> places;
    std::vector<float> errors;
    scene::DeformedStreams streams;
    pose.bounds = {};
    for (const scene::Primitive& part : m_parts) {
        const std::span<const float> own = part.targets.empty() ? std::span<const float>() : weights;
        scene::DeformPrimitive(part, own, jointMatrices, streams);
        // Positions beyond the range of floats are as the device has them.
        for (size_t i = 0; i < part.positions.size(); ++i)
            places.push_back(scene::IsFinite(streams.positions[i]) ? streams.positions[i]
                                                                   : part.positions[i]);
        for (size_t i = 0; i < part.positions.size() && !m_emitters.empty(); ++i)
            errors.push_back(DisagreementAt(part, i, own, jointMatrices));
        pose.bounds.Extend(Showable(scene::DeformedBounds(part, own, jointMatrices)));
    }
    const auto take = [&](const std::vector<uint32_t>& corners, std::vector<glm::vec3>& into) {
        into.clear();
        for (const uint32_t corner : corners) into.push_back(places[corner]);
    };
    take(m_emitters, pose.emitters);
    take(m_samples, pose.samples);
    // For a cube, this value leaves a height of 1/256 of the edge. It is relative to the samples at rest,
    // because a sample has less area than all triangles
    constexpr double kFlat = 0.02;
    pose.isFlattened = !m_emitters.empty() && Enclosure::Of(pose.samples).Fullness() < kFlat * m_fullness;
    pose.emitterError = 0.0f;
    for (const uint32_t corner : m_emitters) pose.emitterError = std::max(pose.emitterError, errors[corner]);
}

DeformPlan PlanDeformation(const scene::SceneData& scene) {
    DeformPlan plan;
    plan.copyOf.assign(scene.instances.size(), scene::kNone);
    std::vector<bool> isPlaced(scene.meshes.size());
    plan.isBaseShapeDrawn.assign(scene.meshes.size(), false);
    struct Owner {  // of the weights
        bool hasTargets = false, isNode = false;
        uint32_t index = 0;
        auto operator<=>(const Owner&) const = default;
    };
    std::map<std::tuple<uint32_t, uint32_t, Owner>, std::vector<uint32_t>> copies;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const scene::Instance& instance = scene.instances[i];
        const bool hasSkin = instance.isDeformed && scene::HasSkin(scene, instance);
        const bool hasTargets = instance.isDeformed && scene::HasTargets(scene, instance);
        isPlaced[instance.mesh] = true;
        if (!hasSkin && !hasTargets) {
            plan.isBaseShapeDrawn[instance.mesh] = true;
            continue;
        }
        const uint32_t skin = hasSkin ? scene.nodes[instance.node].skin : scene::kNone;
        const bool isNode = instance.node != scene::kNone;
        const Owner owner = hasTargets ? Owner{true, isNode, isNode ? instance.node : i} : Owner{};
        copies[{instance.mesh, skin, owner}].push_back(i);
    }
    for (size_t mesh = 0; mesh < isPlaced.size(); ++mesh)
        if (!isPlaced[mesh]) plan.isBaseShapeDrawn[mesh] = true;
    for (auto& [key, instances] : copies) {
        for (const uint32_t instance : instances)
            plan.copyOf[instance] = static_cast<uint32_t>(plan.copies.size());
        plan.copies.push_back({.mesh = std::get<0>(key),
                               .skin = std::get<1>(key),
                               .hasTargets = std::get<2>(key).hasTargets,
                               .instances = std::move(instances)});
    }
    return plan;
}

}  // namespace raygraph
