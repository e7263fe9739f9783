// Merges the reflections of a pipeline's stages (rhi/reflection.h).
#include <algorithm>

#include "base/text.h"
#include "rhi/reflection.h"

namespace raygraph::rhi {
namespace {

constexpr uint32_t kPassSet = 0;
constexpr uint32_t kTextureTableSet = 1;

std::string Describe(const Binding& binding) {
    std::string text = Text("{} '{}'", Name(binding.kind), binding.name);
    if (binding.count != 1) text += binding.count == 0 ? "[]" : Text("[{}]", binding.count);
    return binding.shape == ImageShape::Plain ? text : Text("{} ({})", text, Name(binding.shape));
}

[[noreturn]] void Fail(const std::string& text) {
    throw Error(ErrorKind::Usage, text);
}

void CheckTextureTable(const std::string& shader, const Binding& binding) {
    if (binding.binding != 0 || binding.kind != BindingKind::SampledImage ||
        binding.shape != ImageShape::Plain)
        Fail(Text("{}: set 1 binding {} is {}; set 1 is for the bindless textures, sampler2D[] at binding 0",
                  shader, binding.binding, Describe(binding)));
}

void CheckAgree(const BindingInfo& first, const std::string& shader, const Binding& second) {
    const bool sameSlot = first.binding == second.binding && first.offset == second.offset;
    const bool sameName = first.name == second.name;
    if (sameSlot && sameName && first.kind == second.kind && first.count == second.count &&
        first.shape == second.shape &&
        (first.imageFormat == second.imageFormat || first.imageFormat == Format::Undefined ||
         second.imageFormat == Format::Undefined))
        return;
    auto side = [](const std::string& where, const Binding& binding) {
        return Text(
            "{} has {}{} at binding {}", where, Describe(binding),
            (binding.imageFormat == Format::Undefined ? "" : std::string(" of ") + Name(binding.imageFormat)),
            binding.binding);
    };
    Fail("shaders disagree: " + side(first.firstShader, first) + ", " + side(shader, second));
}

// Tells whether a pipeline can have both only if they are equal: they share a name or a binding number.
bool Collide(const Binding& a, const Binding& b) {
    if (a.name == b.name) return true;
    return a.binding == b.binding && (a.offset == b.offset || a.kind != b.kind);
}

void MergeBinding(ShaderInterface& merged, const NamedReflection& stage, const Binding& binding) {
    const VkShaderStageFlags bit = ToVk(stage.reflection.stage);
    if (binding.set == kTextureTableSet) {
        CheckTextureTable(stage.name, binding);
        merged.usesTextureTable |= binding.isUsed;
        return;
    }
    if (binding.set != kPassSet)
        Fail(Text("{}: '{}' is in set {}; there are set 0 (the pass) and set 1 (bindless textures)",
                  stage.name, binding.name, binding.set));
    if (binding.count == 0)
        Fail(stage.name + ": '" + binding.name + "' is a runtime array in set 0; give it a size");
    for (BindingInfo& known : merged.bindings) {
        if (!Collide(known, binding)) continue;
        CheckAgree(known, stage.name, binding);
        known.stages |= bit;
        known.isReadable |= binding.isReadable;
        known.isWritable |= binding.isWritable;
        known.isUsed |= binding.isUsed;
        known.blockBytes = std::max(known.blockBytes, binding.blockBytes);
        known.elementBytes = std::max(known.elementBytes, binding.elementBytes);
        if (known.imageFormat == Format::Undefined) known.imageFormat = binding.imageFormat;
        return;
    }
    BindingInfo info;
    static_cast<Binding&>(info) = binding;
    info.stages = bit;
    info.firstShader = stage.name;
    merged.bindings.push_back(std::move(info));
}

}  // namespace

const BindingInfo* ShaderInterface::Find(std::string_view bindingName) const {
    for (const BindingInfo& binding : bindings)
        if (binding.name == bindingName) return &binding;
    return nullptr;
}

ShaderInterface MergeInterface(std::span<const NamedReflection> stages) {
    ShaderInterface merged;
    for (const NamedReflection& stage : stages) {
        const ShaderReflection& reflection = stage.reflection;
        merged.stages |= ToVk(reflection.stage);
        for (const Binding& binding : reflection.bindings) MergeBinding(merged, stage, binding);
        if (reflection.pushConstants.bytes > merged.pushConstants.bytes) {
            merged.pushConstants = reflection.pushConstants;
            merged.pushConstantShader = stage.name;
        }
        for (const SpecializationConstant& constant : reflection.specialization) {
            const bool isKnown = std::any_of(merged.specialization.begin(), merged.specialization.end(),
                                             [&](const auto& known) { return known.id == constant.id; });
            if (!isKnown) merged.specialization.push_back(constant);
        }
    }
    std::sort(merged.bindings.begin(), merged.bindings.end(), [](const Binding& a, const Binding& b) {
        return a.binding != b.binding ? a.binding < b.binding : a.offset < b.offset;
    });
    std::sort(merged.specialization.begin(), merged.specialization.end(),
              [](const auto& a, const auto& b) { return a.id < b.id; });
    return merged;
}

}  // namespace raygraph::rhi
