#include "renderer/scene/gltf_animations.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "base/text.h"
#include "renderer/scene/animated_values.h"

namespace raygraph::scene {
namespace {

constexpr const char* Name(Interpolation interpolation) {
    constexpr const char* kNames[] = {"STEP", "LINEAR", "CUBICSPLINE"};
    return kNames[static_cast<size_t>(interpolation)];
}

class AnimationReader {
  public:
    AnimationReader(GltfContext& context, const AccessorTables& tables, const std::vector<MeshLayout>& meshes,
                    const PointedScene& pointed)
        : m_context(context), m_tables(tables), m_meshes(meshes), m_pointed(pointed) {}

    AnimationLayout Read(const AnimationSource& source, const Place& where) {
        AnimationLayout layout{.name = source.name, .samplers = {}, .channels = {}};
        std::set<AnimationTarget> seen;
        m_samplerOf.assign(source.samplers.size(), {});
        for (size_t i = 0; i < source.samplers.size(); ++i)
            CheckInput(source.samplers[i].input, where["samplers"][i]);
        for (size_t i = 0; i < source.channels.size(); ++i) {
            const AnimationSource::Channel& channel = source.channels[i];
            const Place target = where["channels"][i]["target"];
            const PointedTargets found = TargetsOf(channel, target);
            for (const AnimationTarget& one : found.targets) {
                if (!IsMovable(one, target)) continue;
                if (!IsFirst(seen, one)) {
                    m_context.Warn(target, "animated twice",
                                   "is that of another channel, too: the first one counts");
                    continue;
                }
                const bool isWeights = IsOfWeights(one);
                Charge(one, target);
                const uint32_t sampler = SamplerFor(source, channel.sampler, found.kind, WidthOf(one),
                                                    isWeights, where["samplers"], layout);
                if (sampler != kNone) layout.channels.push_back({sampler, one});
            }
        }
        return layout;
    }

  private:
    void CheckInput(uint32_t input, const Place& where) const {
        const Accessor& accessor = m_tables.accessors[input];
        if (accessor.isMatrix || accessor.componentCount != 1 ||
            accessor.componentType != ComponentType::Float)
            m_context.Fail(where["input"], Text("accessors[{}] must be SCALAR of float", input));
    }

    PointedTargets TargetsOf(const AnimationSource::Channel& channel, const Place& where) {
        if (channel.path == "pointer" && channel.pointer) {
            if (channel.node != kNone)
                m_context.Warn(where["node"], "node of a pointer", "is set beside a pointer, ignored");
            const Place pointer = where["extensions"][kAnimationPointer]["pointer"];
            return ResolvePointer(m_context, *channel.pointer, m_pointed, pointer);
        }
        AnimationTarget target{.object = channel.node};
        if (channel.path == "translation")
            target.property = AnimatedProperty::Translation;
        else if (channel.path == "rotation")
            target.property = AnimatedProperty::Rotation;
        else if (channel.path == "scale")
            target.property = AnimatedProperty::Scale;
        else if (channel.path == "weights")
            target.property = AnimatedProperty::Weights;
        else {
            m_context.Warn(where["path"], "animated path", "is none that is read, ignored");
            return {};
        }
        if (channel.node == kNone) {
            m_context.Warn(where, "animated nothing", "has no node, ignored");
            return {};
        }
        const bool isRotation = target.property == AnimatedProperty::Rotation;
        return {isRotation ? ValueKind::Rotation : ValueKind::Plain, {target}};
    }

    size_t WidthOf(const AnimationTarget& target) const {
        if (!IsOfWeights(target)) return scene::WidthOf(m_pointed.scene, target);
        const bool isOfNode = target.property == AnimatedProperty::Weights;
        const uint32_t mesh = isOfNode ? m_pointed.scene.nodes[target.object].mesh : target.object;
        const size_t count = mesh == kNone ? 0 : m_meshes[mesh].weights.size();
        return target.element == kNone ? count : target.element < count ? 1 : 0;
    }

    // Whether the object has what is to be moved.
    bool IsMovable(const AnimationTarget& target, const Place& where) {
        const bool isTransform = target.property == AnimatedProperty::Translation ||
                                 target.property == AnimatedProperty::Rotation ||
                                 target.property == AnimatedProperty::Scale;
        if (isTransform && m_pointed.scene.nodes[target.object].matrix) {
            m_context.Warn(where, "animated matrix",
                           Text("nodes[{}] has a matrix, and cannot be animated", target.object));
            return false;
        }
        if (WidthOf(target) > 0) return true;
        m_context.Warn(
            where, "animated weights",
            Text("{}[{}] has no such morph targets, ignored",
                 target.property == AnimatedProperty::Weights ? "nodes" : "meshes", target.object));
        return false;
    }

    // What a channel takes, here and in a PoseEvaluator; and once for all animations what it changes: a
    // value at rest, one of a pose, one for weights, and the scene's.
    void Charge(AnimationTarget target, const Place& where) {
        constexpr uint64_t kBytesAChannel = 128, kBytesATarget = 256;
        constexpr uint64_t kBytesANumber = 3 * sizeof(double) + sizeof(float);
        m_context.ChargeGeometry(where, kBytesAChannel);
        if (IsOfWeights(target)) target.element = kNone;
        if (m_wholes.insert(target).second)
            m_context.ChargeGeometry(where, kBytesATarget + WidthOf(target) * kBytesANumber);
    }

    // Also not a weight beside all.
    static bool IsFirst(std::set<AnimationTarget>& seen, const AnimationTarget& target) {
        if (IsOfWeights(target)) {
            AnimationTarget other = target;
            other.element = target.element == kNone ? 0 : kNone;
            const auto next = seen.lower_bound(other);
            const bool isBeside = next != seen.end() && next->property == target.property &&
                                  next->object == target.object &&
                                  (target.element == kNone || next->element == kNone);
            if (isBeside) return false;
        }
        return seen.insert(target).second;
    }

    // kNone, with a warning, if it has a wrong number of values.
    uint32_t SamplerFor(const AnimationSource& source, uint32_t index, ValueKind kind, size_t width,
                        bool isWeights, const Place& samplers, AnimationLayout& layout) {
        for (const uint32_t known : m_samplerOf[index])
            if (layout.samplers[known].kind == kind && layout.samplers[known].width == width &&
                layout.samplers[known].isOfWeights == isWeights)
                return known;
        const AnimationSource::Sampler& file = source.samplers[index];
        const SamplerLayout sampler{.where = samplers[index],
                                    .input = file.input,
                                    .output = file.output,
                                    .interpolation = file.interpolation,
                                    .kind = kind,
                                    .width = static_cast<uint32_t>(width),
                                    .isOfWeights = isWeights};
        if (!CheckOutput(sampler)) return kNone;
        if (kind == ValueKind::Flag && file.interpolation != Interpolation::Step)
            m_context.Warn(sampler.where, "interpolated flag", "interpolates true and false, taken as STEP");
        layout.samplers.push_back(sampler);
        m_samplerOf[index].push_back(static_cast<uint32_t>(layout.samplers.size() - 1));
        return m_samplerOf[index].back();
    }

    // Weights, of which there may be any number, are scalars, one after the other.
    bool CheckOutput(const SamplerLayout& sampler) const {
        const bool isWeights = sampler.isOfWeights;
        const Accessor& accessor = m_tables.accessors[sampler.output];
        constexpr const char* kShapes[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
        const uint64_t components = isWeights ? 1 : sampler.width;
        const Place where = sampler.where["output"];
        const bool isFloat = accessor.componentType == ComponentType::Float;
        const bool isShare = isWeights || sampler.kind == ValueKind::Rotation;
        if (accessor.isMatrix || accessor.componentCount != components ||
            accessor.componentType == ComponentType::Uint32 ||
            (isShare && !isFloat && !accessor.isNormalized))
            m_context.Fail(where,
                           Text("accessors[{}] must be {} of float{}", sampler.output, kShapes[components],
                                isShare ? ", normalized bytes or normalized shorts" : ", bytes or shorts"));
        const uint64_t keys = m_tables.accessors[sampler.input].count;
        const uint64_t wanted = keys * (sampler.interpolation == Interpolation::CubicSpline ? 3 : 1) *
                                (isWeights ? sampler.width : 1);
        if (accessor.count == wanted) return true;
        m_context.Warn(where, "values of keys",
                       Text("accessors[{}] has {} elements, {} keys of {} need {}, its channels are left out",
                            sampler.output, accessor.count, keys, Name(sampler.interpolation), wanted));
        return false;
    }

    GltfContext& m_context;
    const AccessorTables& m_tables;
    const std::vector<MeshLayout>& m_meshes;
    const PointedScene& m_pointed;
    std::set<AnimationTarget> m_wholes;              // that some channel changes, a part of it at least
    std::vector<std::vector<uint32_t>> m_samplerOf;  // by the file's sampler, those of the layout
};

// False, with a warning, if one is not finite.
bool ReadKeys(GltfContext& context, AccessorReader& reader, uint32_t accessor, size_t components,
              std::vector<float>& keys, const Place& where) {
    const std::optional<size_t> broken = reader.ReadAny(accessor, components, keys.data());
    if (broken)
        context.Warn(
            where, "endless keys",
            Text("accessors[{}] element {} is not finite; its channels are left out", accessor, *broken));
    return !broken;
}

// None, with a warning, if they cannot be those of keys.
std::vector<float> DecodeTimes(GltfContext& context, AccessorReader& reader, const SamplerLayout& layout) {
    const Place where = layout.where["input"];
    const size_t count = reader.Info(layout.input).count;
    context.ChargeGeometry(where, count * sizeof(float));
    std::vector<float> times(count);
    if (!ReadKeys(context, reader, layout.input, 1, times, where)) return {};
    if (times[0] < 0.0f) {
        context.Warn(
            where, "times",
            Text("accessors[{}] element 0 is {}, a time must not be negative; its channels are left out",
                 layout.input, times[0]));
        return {};
    }
    for (size_t i = 1; i < count; ++i) {
        if (times[i] > times[i - 1]) continue;
        context.Warn(where, "times",
                     Text("accessors[{}] element {} is {}, not greater than the one before it; its channels "
                          "are left out",
                          layout.input, i, times[i]));
        return {};
    }
    return times;
}

// False, with a warning, if one is none.
bool ConvertRotations(GltfContext& context, const SamplerLayout& layout, std::vector<float>& values) {
    const bool isCubic = layout.interpolation == Interpolation::CubicSpline;
    for (size_t i = isCubic ? 4 : 0; i + 4 <= values.size(); i += isCubic ? 12 : 4) {
        double square = 0.0;
        for (size_t k = 0; k < 4; ++k) square += double{values[i + k]} * double{values[i + k]};
        const double length = std::sqrt(square);
        constexpr double kRounding = 1e-2;  // of four bytes
        if (!(length > 1e-6)) {
            context.Warn(layout.where["output"], "rotation of length 0",
                         Text("key {} is a quaternion of length 0, its channels are left out",
                              i / (isCubic ? 12 : 4)));
            return false;
        }
        if (std::abs(length - 1.0) > kRounding)
            context.Warn(layout.where["output"], "rotation", "is not of unit length, normalized");
        if (isCubic) continue;  // its tangents are those of what is there
        for (size_t k = 0; k < 4; ++k) values[i + k] = static_cast<float>(double{values[i + k]} / length);
    }
    return true;
}

// Flags are held, whatever the file interpolates them by.
void ConvertFlags(AnimationSampler& sampler) {
    if (sampler.interpolation == Interpolation::CubicSpline) {
        for (size_t i = 0; i < sampler.times.size(); ++i) sampler.values[i] = sampler.values[3 * i + 1];
        sampler.values.resize(sampler.times.size());
    }
    sampler.interpolation = Interpolation::Step;
    for (float& value : sampler.values) value = value != 0.0f ? 1.0f : 0.0f;
}

void ConvertGlossiness(AnimationSampler& sampler) {
    const bool isCubic = sampler.interpolation == Interpolation::CubicSpline;
    for (size_t i = 0; i < sampler.values.size(); ++i) {
        const bool isTangent = isCubic && i % 3 != 1;
        sampler.values[i] = (isTangent ? 0.0f : 1.0f) - sampler.values[i];
    }
}

// Nothing, with a warning, if its keys cannot be used.
std::optional<AnimationSampler> DecodeSampler(GltfContext& context, AccessorReader& reader,
                                              const SamplerLayout& layout) {
    AnimationSampler sampler{.interpolation = layout.interpolation,
                             .width = layout.width,
                             .times = DecodeTimes(context, reader, layout),
                             .values = {}};
    if (sampler.times.empty()) return std::nullopt;
    const Accessor& output = reader.Info(layout.output);
    const size_t count = output.count * output.componentCount;
    context.ChargeGeometry(layout.where["output"], count * sizeof(float));
    sampler.values.resize(count);
    if (!ReadKeys(context, reader, layout.output, output.componentCount, sampler.values,
                  layout.where["output"]))
        return std::nullopt;
    if (layout.kind == ValueKind::Rotation && !ConvertRotations(context, layout, sampler.values))
        return std::nullopt;
    if (layout.kind == ValueKind::Flag) ConvertFlags(sampler);
    if (layout.kind == ValueKind::Glossiness) ConvertGlossiness(sampler);
    return sampler;
}

}  // namespace

std::vector<AnimationLayout> ReadAnimations(GltfContext& context, const std::vector<AnimationSource>& sources,
                                            const AccessorTables& tables,
                                            const std::vector<MeshLayout>& meshes,
                                            const PointedScene& pointed) {
    AnimationReader reader(context, tables, meshes, pointed);
    std::vector<AnimationLayout> layouts;
    for (size_t i = 0; i < sources.size(); ++i)
        layouts.push_back(reader.Read(sources[i], Place("animations")[i]));
    return layouts;
}

std::vector<Animation> DecodeAnimations(GltfContext& context, AccessorReader& reader,
                                        const std::vector<AnimationLayout>& layouts) {
    std::vector<Animation> animations;
    for (const AnimationLayout& layout : layouts) {
        Animation& animation = animations.emplace_back();
        animation.name = layout.name;
        std::vector<uint32_t> indices;  // of the layout's samplers
        for (const SamplerLayout& source : layout.samplers) {
            std::optional<AnimationSampler> sampler = DecodeSampler(context, reader, source);
            indices.push_back(sampler ? static_cast<uint32_t>(animation.samplers.size()) : kNone);
            if (!sampler) continue;
            animation.duration = std::max(animation.duration, sampler->times.back());
            animation.samplers.push_back(std::move(*sampler));
        }
        for (AnimationChannel channel : layout.channels) {
            channel.sampler = indices[channel.sampler];
            if (channel.sampler != kNone) animation.channels.push_back(channel);
        }
    }
    return animations;
}

}  // namespace raygraph::scene
