#include "renderer/scene/gltf/animations.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "base/printable.h"
#include "base/text.h"
#include "renderer/scene/animation/animated_values.h"

namespace raygraph::scene {
namespace {

constexpr const char* Name(Interpolation interpolation) {
    constexpr const char* kNames[] = {"STEP", "LINEAR", "CUBICSPLINE"};
    return kNames[static_cast<size_t>(interpolation)];
}

// Knows which targets pictures show, whatever the command: all cameras, lights and variants count.
class ShownTargets {
  public:
    ShownTargets(const SceneData& scene, const std::vector<MeshLayout>& meshes)
        : m_scene(scene),
          m_isPlaced(scene.nodes.size()),
          m_isShown(scene.nodes.size()),
          m_isSkinUsed(scene.skins.size()),
          m_isMeshUsed(meshes.size()),
          m_isMaterialUsed(scene.materials.size()) {
        for (const uint32_t index : scene.nodeOrder) ShowNode(scene.nodes[index], index, meshes);
        for (const Camera& camera : scene.cameras) ShowPath(camera.node);
        for (const Light& light : scene.lights) ShowPath(light.node);
    }

    bool Has(const AnimationTarget& target) const {
        switch (target.property) {
            case AnimatedProperty::Translation:
            case AnimatedProperty::Rotation:
            case AnimatedProperty::Scale:
            case AnimatedProperty::Visibility:
                return m_isShown[target.object];
            case AnimatedProperty::Weights:
                return m_isPlaced[target.object];
            case AnimatedProperty::MeshWeights:
                return m_isMeshUsed[target.object];
            case AnimatedProperty::MaterialField:
            case AnimatedProperty::TextureTransform:
                return m_isMaterialUsed[target.object];
            case AnimatedProperty::CameraField:
            case AnimatedProperty::LightField:
                return true;  // The scene has only those that are placed.
        }
        return true;
    }

  private:
    void ShowNode(const Node& node, uint32_t index, const std::vector<MeshLayout>& meshes) {
        m_isPlaced[index] = true;
        if (node.mesh == kNone) return;
        ShowPath(index);
        if (node.skin != kNone && !m_isSkinUsed[node.skin]) {
            m_isSkinUsed[node.skin] = true;
            for (const uint32_t joint : m_scene.skins[node.skin].joints) ShowPath(joint);
        }
        if (m_isMeshUsed[node.mesh]) return;
        m_isMeshUsed[node.mesh] = true;
        const auto show = [&](uint32_t material) {
            if (material != kNone) m_isMaterialUsed[material] = true;
        };
        for (const PrimitiveLayout& primitive : meshes[node.mesh].primitives) {
            show(primitive.material);
            for (const VariantMaterial& variant : primitive.variants) show(variant.material);
        }
    }

    // A node that places something, and those above it.
    void ShowPath(uint32_t node) {
        for (; node != kNone && !m_isShown[node]; node = m_scene.nodes[node].parent) m_isShown[node] = true;
    }

    const SceneData& m_scene;
    std::vector<bool> m_isPlaced;  // By node: the scene has it.
    std::vector<bool> m_isShown;   // by node: the scene places something at it or below it
    std::vector<bool> m_isSkinUsed, m_isMeshUsed, m_isMaterialUsed;
};

class AnimationReader {
  public:
    AnimationReader(GltfContext& context, const AccessorTables& tables, const std::vector<MeshLayout>& meshes,
                    const PointerScene& pointed)
        : m_context(context),
          m_tables(tables),
          m_meshes(meshes),
          m_pointed(pointed),
          m_shown(pointed.scene, meshes) {}

    AnimationLayout Read(const AnimationSource& source, const Place& where) {
        AnimationLayout layout{.name = source.name, .samplers = {}, .channels = {}};
        std::set<AnimationTarget> seen;
        m_samplerOf.assign(source.samplers.size(), {});
        for (size_t i = 0; i < source.samplers.size(); ++i)
            CheckInput(source.samplers[i].input, where["samplers"][i]);
        for (size_t i = 0; i < source.channels.size(); ++i) {
            const AnimationSource::Channel& channel = source.channels[i];
            const Place target = where["channels"][i]["target"];
            const PointerTargets found = TargetsOf(channel, target);
            for (const AnimationTarget& one : found.targets) {
                if (!IsMovable(one, target)) continue;
                if (!IsFirst(seen, one)) {
                    m_context.Warn(target, "animated twice",
                                   "is that of another channel, too: the first one counts");
                    continue;
                }
                const bool isWeights = IsMorphWeights(one);
                Charge(one, target);
                const uint32_t sampler = SamplerFor(source, channel.sampler, found.kind, WidthOf(one),
                                                    isWeights, where["samplers"], layout);
                if (m_shown.Has(one)) layout.samplers[sampler].isShown = true;
                layout.channels.push_back({sampler, one});
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

    PointerTargets TargetsOf(const AnimationSource::Channel& channel, const Place& where) {
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
        if (!IsMorphWeights(target)) return scene::WidthOf(m_pointed.scene, target);
        const bool isOfNode = target.property == AnimatedProperty::Weights;
        const uint32_t mesh = isOfNode ? m_pointed.scene.nodes[target.object].mesh : target.object;
        const size_t count = mesh == kNone ? 0 : m_meshes[mesh].weights.size();
        return target.element == kNone ? count : target.element < count ? 1 : 0;
    }

    // Returns whether the object has what is to be moved.
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

    // Charges the memory of a channel, here and in a PoseEvaluator. A target is charged once for all
    // animations: a value at rest, one of a pose, one for weights, and the scene's.
    void Charge(AnimationTarget target, const Place& where) {
        constexpr uint64_t kBytesPerChannel = 128, kBytesPerTarget = 256;
        constexpr uint64_t kBytesPerNumber = 3 * sizeof(double) + sizeof(float);
        m_context.ChargeGeometry(where, kBytesPerChannel);
        if (IsMorphWeights(target)) target.element = kNone;
        if (m_wholes.insert(target).second)
            m_context.ChargeGeometry(where, kBytesPerTarget + WidthOf(target) * kBytesPerNumber);
    }

    // Returns whether the target is new; a single weight is not, if all weights are a target.
    static bool IsFirst(std::set<AnimationTarget>& seen, const AnimationTarget& target) {
        if (IsMorphWeights(target)) {
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

    uint32_t SamplerFor(const AnimationSource& source, uint32_t index, ValueKind kind, size_t width,
                        bool isWeights, const Place& samplers, AnimationLayout& layout) {
        for (const uint32_t known : m_samplerOf[index])
            if (layout.samplers[known].kind == kind && layout.samplers[known].width == width &&
                layout.samplers[known].isMorphWeights == isWeights)
                return known;
        const AnimationSource::Sampler& file = source.samplers[index];
        SamplerLayout sampler{.where = samplers[index],
                              .input = file.input,
                              .output = file.output,
                              .interpolation = file.interpolation,
                              .kind = kind,
                              .width = static_cast<uint32_t>(width),
                              .isMorphWeights = isWeights};
        CheckOutput(sampler);
        if (kind == ValueKind::Flag && file.interpolation != Interpolation::Step)
            m_context.Warn(sampler.where, "interpolated flag", "interpolates true and false, taken as STEP");
        layout.samplers.push_back(std::move(sampler));
        m_samplerOf[index].push_back(static_cast<uint32_t>(layout.samplers.size() - 1));
        return m_samplerOf[index].back();
    }

    // Weights, of which there may be any number, are scalars, one after the other.
    void CheckOutput(SamplerLayout& sampler) const {
        const bool isWeights = sampler.isMorphWeights;
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
        if (accessor.count == wanted) return;
        sampler.defect = KeyDefect{where, "values of keys",
                                   Text("accessors[{}] has {}, must have {} for {} of {}", sampler.output,
                                        Counted(accessor.count, "element"), wanted, Counted(keys, "key"),
                                        Name(sampler.interpolation))};
    }

    GltfContext& m_context;
    const AccessorTables& m_tables;
    const std::vector<MeshLayout>& m_meshes;
    const PointerScene& m_pointed;
    ShownTargets m_shown;
    std::set<AnimationTarget> m_wholes;              // that some channel changes, a part of it at least
    std::vector<std::vector<uint32_t>> m_samplerOf;  // by the file's sampler, those of the layout
};

// Returns the first key that is not finite.
std::optional<KeyDefect> ReadKeys(AccessorReader& reader, uint32_t accessor, size_t components,
                                  std::vector<float>& keys, const Place& where) {
    const std::optional<size_t> broken = reader.ReadAny(accessor, components, keys.data());
    if (!broken) return std::nullopt;
    return KeyDefect{where, "endless keys",
                     Text("accessors[{}] element {} is not finite", accessor, *broken)};
}

std::optional<KeyDefect> DecodeTimes(GltfContext& context, AccessorReader& reader,
                                     const SamplerLayout& layout, std::vector<float>& times) {
    const Place where = layout.where["input"];
    const size_t count = reader.Info(layout.input).count;
    context.ChargeGeometry(where, count * sizeof(float));
    times.resize(count);
    if (std::optional<KeyDefect> defect = ReadKeys(reader, layout.input, 1, times, where)) return defect;
    if (times[0] < 0.0f)
        return KeyDefect{
            where, "times",
            Text("accessors[{}] element 0 is {}, a time must not be negative", layout.input, times[0])};
    for (size_t i = 1; i < count; ++i)
        if (!(times[i] > times[i - 1]))
            return KeyDefect{where, "times",
                             Text("accessors[{}] element {} is {}, not greater than the one before it",
                                  layout.input, i, times[i])};
    return std::nullopt;
}

std::optional<KeyDefect> ConvertRotations(GltfContext& context, const SamplerLayout& layout,
                                          std::vector<float>& values) {
    const bool isCubic = layout.interpolation == Interpolation::CubicSpline;
    for (size_t i = isCubic ? 4 : 0; i + 4 <= values.size(); i += isCubic ? 12 : 4) {
        double square = 0.0;
        for (size_t k = 0; k < 4; ++k) square += double{values[i + k]} * double{values[i + k]};
        const double length = std::sqrt(square);
        constexpr double kRounding = 1e-2;  // of four bytes
        const Place where = layout.where["output"];
        if (!(length > 1e-6))
            return KeyDefect{where, "rotation of length 0",
                             Text("key {} is a quaternion of length 0", i / (isCubic ? 12 : 4))};
        if (std::abs(length - 1.0) > kRounding)
            context.Warn(where, "rotation", "is not of unit length, normalized");
        if (isCubic) continue;  // its tangents are those of what is there
        for (size_t k = 0; k < 4; ++k) values[i + k] = static_cast<float>(double{values[i + k]} / length);
    }
    return std::nullopt;
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

// Returns why the keys cannot be used; the sampler is then unfinished.
std::optional<KeyDefect> DecodeSampler(GltfContext& context, AccessorReader& reader,
                                       const SamplerLayout& layout, AnimationSampler& sampler) {
    if (layout.defect) return layout.defect;
    sampler.interpolation = layout.interpolation;
    sampler.width = layout.width;
    if (std::optional<KeyDefect> defect = DecodeTimes(context, reader, layout, sampler.times)) return defect;
    const Accessor& output = reader.Info(layout.output);
    const Place where = layout.where["output"];
    const size_t count = output.count * output.componentCount;
    context.ChargeGeometry(where, count * sizeof(float));
    sampler.values.resize(count);
    std::optional<KeyDefect> defect =
        ReadKeys(reader, layout.output, output.componentCount, sampler.values, where);
    if (!defect && layout.kind == ValueKind::Rotation)
        defect = ConvertRotations(context, layout, sampler.values);
    if (defect) return defect;
    if (layout.kind == ValueKind::Flag) ConvertFlags(sampler);
    if (layout.kind == ValueKind::Glossiness) ConvertGlossiness(sampler);
    return std::nullopt;
}

// Warns of the defect, which the animation keeps if pictures show what the keys move.
void Report(GltfContext& context, const KeyDefect& defect, bool isShown, Animation& animation) {
    if (isShown && animation.defect.empty()) animation.defect = context.Line(defect.where, defect.what);
    context.Warn(
        defect.where, Text("{}{}", isShown ? "shown " : "", defect.topic),
        defect.what + (isShown ? "; the animation cannot be played" : "; its channels are left out"));
}

}  // namespace

std::vector<AnimationLayout> ReadAnimations(GltfContext& context, const std::vector<AnimationSource>& sources,
                                            const AccessorTables& tables,
                                            const std::vector<MeshLayout>& meshes,
                                            const PointerScene& pointed) {
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
            AnimationSampler sampler;
            const std::optional<KeyDefect> defect = DecodeSampler(context, reader, source, sampler);
            indices.push_back(defect ? kNone : static_cast<uint32_t>(animation.samplers.size()));
            if (defect) {
                Report(context, *defect, source.isShown, animation);
                continue;
            }
            animation.duration = std::max(animation.duration, sampler.times.back());
            animation.samplers.push_back(std::move(sampler));
        }
        for (AnimationChannel channel : layout.channels) {
            channel.sampler = indices[channel.sampler];
            if (channel.sampler != kNone) animation.channels.push_back(channel);
        }
    }
    return animations;
}

}  // namespace raygraph::scene
