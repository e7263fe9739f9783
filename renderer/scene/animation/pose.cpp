#include "renderer/scene/animation/pose.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "base/text.h"
#include "renderer/scene/animation/animated_values.h"

namespace raygraph::scene {
namespace {

AnimationTarget Whole(AnimationTarget target) {
    if (IsMorphWeights(target)) target.element = kNone;
    return target;
}

bool IsTransform(const AnimationTarget& target) {
    return target.property == AnimatedProperty::Translation ||
           target.property == AnimatedProperty::Rotation || target.property == AnimatedProperty::Scale;
}

bool IsIgnored(const SceneData& scene, const AnimationTarget& target) {
    return WidthOf(scene, target) == 0 || (IsTransform(target) && scene.nodes[target.object].matrix);
}

bool Plays(const ClipState& clip) {
    return clip.weight > 0.0f && std::isfinite(clip.weight);
}

// Returns the dot product of two quaternions.
double Dot(const double* a, const double* b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

// Converts a value to its reciprocal and back. Infinite is 0 on either side.
double Reciprocal(double value) {
    return value == 0.0 ? 0.0 : 1.0 / value;
}

}  // namespace

PoseEvaluator::PoseEvaluator(const SceneData& scene) {
    std::vector<AnimationTarget> targets;
    for (const Animation& animation : scene.animations)
        for (const AnimationChannel& channel : animation.channels)
            if (!IsIgnored(scene, channel.target)) {
                targets.push_back(Whole(channel.target));
                if (const auto follower = DependentOf(channel.target)) targets.push_back(*follower);
            }
    std::ranges::sort(targets);
    targets.erase(std::unique(targets.begin(), targets.end()), targets.end());

    size_t valueCount = 0, widest = 0;
    for (const AnimationTarget& target : targets) {
        const size_t width = WidthOf(scene, target);
        m_pose.properties.push_back({target, valueCount, width});
        valueCount += width;
        m_areReciprocals.resize(valueCount, IsInfiniteAtZero(target) ? 1 : 0);
        widest = std::max(widest, width);
    }
    m_pose.values.resize(valueCount);
    m_totals.resize(valueCount);
    m_rest.resize(valueCount);
    m_sample.resize(widest);
    ReadRest(scene);

    for (const Animation& animation : scene.animations) {
        m_firstChannel.push_back(m_channels.size());
        for (const AnimationChannel& channel : animation.channels) {
            if (IsIgnored(scene, channel.target)) continue;
            const auto at = std::ranges::lower_bound(targets, Whole(channel.target));
            size_t first = m_pose.properties[static_cast<size_t>(at - targets.begin())].first;
            const bool isOneWeight = IsMorphWeights(channel.target) && channel.target.element != kNone;
            if (isOneWeight) first += channel.target.element;
            m_channels.push_back({.sampler = channel.sampler,
                                  .first = first,
                                  .isRotation = channel.target.property == AnimatedProperty::Rotation});
        }
    }
    m_firstChannel.push_back(m_channels.size());
    Rest();
}

void PoseEvaluator::ReadRest(const SceneData& scene) {
    for (const PosedProperty& property : m_pose.properties)
        GetValue(scene, property.target, &m_rest[property.first]);
}

void RequirePlayable(const SceneData& scene, std::span<const ClipState> clips) {
    for (const ClipState& clip : clips) {
        if (clip.animation >= scene.animations.size())
            throw MakeError(ErrorKind::Usage, "there is no animation {}, the scene has {}", clip.animation,
                            scene.animations.size());
        const std::string& defect = scene.animations[clip.animation].defect;
        if (Plays(clip) && !defect.empty()) throw Error(ErrorKind::BadInput, defect);
    }
}

const Pose& PoseEvaluator::Rest() {
    m_pose.values = m_rest;
    return m_pose;
}

const Pose& PoseEvaluator::Evaluate(const SceneData& scene, std::span<const ClipState> clips) {
    RG_CHECK_EQ(scene.animations.size() + 1, m_firstChannel.size());
    RequirePlayable(scene, clips);
    std::ranges::fill(m_pose.values, 0.0);
    std::ranges::fill(m_totals, 0.0);
    for (const ClipState& clip : clips) {
        if (!Plays(clip)) continue;
        const Animation& animation = scene.animations[clip.animation];
        for (size_t i = m_firstChannel[clip.animation]; i < m_firstChannel[clip.animation + size_t{1}]; ++i)
            Add(animation.samplers[m_channels[i].sampler], m_channels[i], clip.seconds, double{clip.weight});
    }
    for (const PosedProperty& property : m_pose.properties) Finish(property);
    return m_pose;
}

void PoseEvaluator::Add(const AnimationSampler& sampler, Channel& channel, double seconds, double weight) {
    SampleAnimation(sampler, seconds, channel.isRotation, channel.interval, m_sample.data());
    double* const sum = &m_pose.values[channel.first];
    const bool isTurned = channel.isRotation && Dot(sum, m_sample.data()) < 0.0;
    for (size_t i = 0; i < sampler.width; ++i) {
        const double sample = m_areReciprocals[channel.first + i] ? Reciprocal(m_sample[i]) : m_sample[i];
        sum[i] += (isTurned ? -weight : weight) * sample;
        m_totals[channel.first + i] += weight;
    }
}

void PoseEvaluator::Finish(const PosedProperty& property) {
    double* const sum = &m_pose.values[property.first];
    const double *const total = &m_totals[property.first], *const rest = &m_rest[property.first];
    const bool isRotation = property.target.property == AnimatedProperty::Rotation;
    const bool isTurned = isRotation && Dot(sum, rest) < 0.0;
    for (size_t i = 0; i < property.count; ++i) {
        const bool isReciprocal = m_areReciprocals[property.first + i] != 0;
        if (total[i] == 0.0) {
            sum[i] = rest[i];
            continue;
        }
        if (total[i] < 1.0)
            sum[i] +=
                (isTurned ? total[i] - 1.0 : 1.0 - total[i]) * (isReciprocal ? Reciprocal(rest[i]) : rest[i]);
        else if (total[i] > 1.0)
            sum[i] /= total[i];
        if (isReciprocal) sum[i] = Reciprocal(sum[i]);
    }
    if (!isRotation || total[0] == 0.0) return;
    const double length = std::sqrt(Dot(sum, sum));
    for (size_t i = 0; i < 4; ++i) sum[i] = length > 1e-9 ? sum[i] / length : rest[i];
}

}  // namespace raygraph::scene
