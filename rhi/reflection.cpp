#include "rhi/reflection.h"

#include <algorithm>
#include <optional>
#include <spirv_cross.hpp>
#include <tuple>

#include "base/text.h"
#include "rhi/stage_set.h"

namespace raygraph::rhi {
namespace {

std::optional<StageKind> StageOf(spv::ExecutionModel model) {
    switch (model) {
        case spv::ExecutionModelRayGenerationKHR:
            return StageKind::RayGen;
        case spv::ExecutionModelMissKHR:
            return StageKind::Miss;
        case spv::ExecutionModelClosestHitKHR:
            return StageKind::ClosestHit;
        case spv::ExecutionModelAnyHitKHR:
            return StageKind::AnyHit;
        case spv::ExecutionModelIntersectionKHR:
            return StageKind::Intersection;
        case spv::ExecutionModelCallableKHR:
            return StageKind::Callable;
        case spv::ExecutionModelGLCompute:
            return StageKind::Compute;
        case spv::ExecutionModelVertex:
            return StageKind::Vertex;
        case spv::ExecutionModelFragment:
            return StageKind::Fragment;
        default:
            return std::nullopt;
    }
}

std::optional<Format> FormatOf(spv::ImageFormat format) {
    switch (format) {
        case spv::ImageFormatUnknown:
            return Format::Undefined;
        case spv::ImageFormatR8:
            return Format::R8Unorm;
        case spv::ImageFormatRg8:
            return Format::Rg8Unorm;
        case spv::ImageFormatRgba8:
            return Format::Rgba8Unorm;
        case spv::ImageFormatRgba16:
            return Format::Rgba16Unorm;
        case spv::ImageFormatR16f:
            return Format::R16Float;
        case spv::ImageFormatRgba16f:
            return Format::Rgba16Float;
        case spv::ImageFormatR32ui:
            return Format::R32Uint;
        case spv::ImageFormatRg32ui:
            return Format::Rg32Uint;
        case spv::ImageFormatRgba32ui:
            return Format::Rgba32Uint;
        case spv::ImageFormatR32f:
            return Format::R32Float;
        case spv::ImageFormatRg32f:
            return Format::Rg32Float;
        case spv::ImageFormatRgba32f:
            return Format::Rgba32Float;
        default:
            return std::nullopt;
    }
}

std::optional<ConstantType> ConstantTypeOf(const spirv_cross::SPIRType& type) {
    if (type.width != 32 && type.basetype != spirv_cross::SPIRType::Boolean) return std::nullopt;
    switch (type.basetype) {
        case spirv_cross::SPIRType::Float:
            return ConstantType::Float;
        case spirv_cross::SPIRType::Int:
            return ConstantType::Int;
        case spirv_cross::SPIRType::UInt:
            return ConstantType::Uint;
        case spirv_cross::SPIRType::Boolean:
            return ConstantType::Bool;
        default:
            return std::nullopt;
    }
}

// Reads one module; holds the state that all steps need.
class Reflector {
  public:
    Reflector(std::span<const uint32_t> spirv, std::string_view name)
        : m_name(name), m_compiler(spirv.data(), spirv.size()), m_used(StaticUse(spirv)) {}

    ShaderReflection Run() {
        ReadEntryPoint();
        const spirv_cross::ShaderResources resources = m_compiler.get_shader_resources();
        Reject(resources.separate_images, "a separate image or texel buffer (write sampler2D)");
        Reject(resources.separate_samplers, "a separate sampler (write sampler2D)");
        Reject(resources.subpass_inputs, "a subpass input");
        Reject(resources.atomic_counters, "an atomic counter");
        for (const auto& resource : resources.storage_images) AddImage(resource, BindingKind::StorageImage);
        for (const auto& resource : resources.sampled_images) AddImage(resource, BindingKind::SampledImage);
        for (const auto& resource : resources.storage_buffers)
            AddBuffer(resource, BindingKind::StorageBuffer);
        for (const auto& resource : resources.uniform_buffers)
            AddBuffer(resource, BindingKind::UniformBuffer);
        for (const auto& resource : resources.acceleration_structures)
            Add(resource, BindingKind::AccelerationStructure);
        for (const auto& resource : resources.push_constant_buffers) ReadPushConstants(resource);
        ReadSpecialization();
        if (m_result.stage == StageKind::Compute) ReadWorkgroupSize();
        m_compiler.update_active_builtins();
        m_result.writesLayer = m_result.stage == StageKind::Vertex &&
                               m_compiler.has_active_builtin(spv::BuiltInLayer, spv::StorageClassOutput);
        std::sort(m_result.bindings.begin(), m_result.bindings.end(), [](const Binding& a, const Binding& b) {
            return std::tie(a.set, a.binding, a.offset) < std::tie(b.set, b.binding, b.offset);
        });
        return std::move(m_result);
    }

  private:
    using Resource = spirv_cross::Resource;

    template <typename... Values>
    [[noreturn]] void Fail(fmt::format_string<Values...> format, Values&&... values) const {
        throw MakeError(ErrorKind::Usage, "{}: {}", m_name, Text(format, std::forward<Values>(values)...));
    }

    void ReadEntryPoint() {
        const auto entries = m_compiler.get_entry_points_and_stages();
        if (entries.size() != 1) Fail("has {} entry points, one is expected", entries.size());
        const std::optional<StageKind> stage = StageOf(entries[0].execution_model);
        if (!stage) Fail("is of an unknown stage");
        m_result.stage = *stage;
        m_result.entryPoint = entries[0].name;
    }

    void Reject(const spirv_cross::SmallVector<Resource>& resources, const char* what) const {
        if (!resources.empty()) Fail("'{}' is {}, which cannot be bound", resources[0].name, what);
    }

    std::string NameOf(const Resource& resource) const {
        const std::string& instance = m_compiler.get_name(resource.id);
        return instance.empty() ? m_compiler.get_name(resource.base_type_id) : instance;
    }

    Binding& Add(const Resource& resource, BindingKind kind) {
        Binding binding;
        binding.name = NameOf(resource);
        binding.set = m_compiler.get_decoration(resource.id, spv::DecorationDescriptorSet);
        binding.binding = m_compiler.get_decoration(resource.id, spv::DecorationBinding);
        binding.kind = kind;
        const spirv_cross::SPIRType& type = m_compiler.get_type(resource.type_id);
        if (type.array.size() > 1) Fail("'{}' is an array of arrays, which cannot be bound", binding.name);
        if (!type.array.empty()) {
            if (!type.array_size_literal[0])
                Fail("'{}' has an array size that is not a literal", binding.name);
            binding.count = type.array[0];
        }
        binding.isUsed = m_used.contains(resource.id);
        return m_result.bindings.emplace_back(std::move(binding));
    }

    void AddImage(const Resource& resource, BindingKind kind) {
        Binding& binding = Add(resource, kind);
        const auto& image = m_compiler.get_type(resource.base_type_id).image;
        const bool isCube = image.dim == spv::DimCube;
        if ((image.dim != spv::Dim2D && !isCube) || (isCube && image.arrayed) || image.ms)
            Fail("'{}' is not a 2D image, an array of them or a cube map, and cannot be bound", binding.name);
        binding.shape = isCube ? ImageShape::Cube : image.arrayed ? ImageShape::Array : ImageShape::Plain;
        const std::optional<ConstantType> texels = ConstantTypeOf(m_compiler.get_type(image.type));
        if (!texels) Fail("'{}' has texels that are not of a 32-bit type", binding.name);
        binding.texelType = *texels == ConstantType::Uint  ? TexelType::Uint
                            : *texels == ConstantType::Int ? TexelType::Int
                                                           : TexelType::Float;
        if (kind == BindingKind::SampledImage) return;
        binding.isReadable = !m_compiler.has_decoration(resource.id, spv::DecorationNonReadable);
        binding.isWritable = !m_compiler.has_decoration(resource.id, spv::DecorationNonWritable);
        const std::optional<Format> format = FormatOf(image.format);
        if (!format) Fail("'{}' has an image format that Raygraph does not know", binding.name);
        binding.imageFormat = *format;
    }

    // Returns the block to which a buffer reference refers; null if the type is no buffer reference.
    const spirv_cross::SPIRType* Referenced(const spirv_cross::SPIRType& type) const {
        const bool isPointer = type.pointer && type.array.empty();
        if (!isPointer || type.storage != spv::StorageClassPhysicalStorageBufferEXT) return nullptr;
        return &m_compiler.get_type(type.parent_type);
    }

    bool IsTableOfAddresses(const spirv_cross::SPIRType& block) const {
        return std::all_of(
            block.member_types.begin(), block.member_types.end(),
            [&](spirv_cross::TypeID member) { return Referenced(m_compiler.get_type(member)) != nullptr; });
    }

    void AddAddresses(const Resource& resource) {
        if (!m_compiler.get_type(resource.type_id).array.empty())
            Fail("'{}' is an array of tables of addresses, which cannot be bound", NameOf(resource));
        const spirv_cross::SPIRType& table = m_compiler.get_type(resource.base_type_id);
        const auto found = m_used.find(resource.id);
        const UsedVariable used = found == m_used.end() ? UsedVariable() : found->second;
        for (uint32_t i = 0; i < table.member_types.size(); ++i) {
            const spirv_cross::SPIRType& block = *Referenced(m_compiler.get_type(table.member_types[i]));
            const auto isAll = [&](spv::Decoration decoration) {
                for (uint32_t member = 0; member < block.member_types.size(); ++member)
                    if (!m_compiler.has_member_decoration(block.self, member, decoration)) return false;
                return true;
            };
            const size_t fixed = m_compiler.get_declared_struct_size_runtime_array(block, 0);
            const size_t withOne = m_compiler.get_declared_struct_size_runtime_array(block, 1);
            Binding& binding = m_result.bindings.emplace_back();
            binding.name = m_compiler.get_member_name(resource.base_type_id, i);
            binding.set = m_compiler.get_decoration(resource.id, spv::DecorationDescriptorSet);
            binding.binding = m_compiler.get_decoration(resource.id, spv::DecorationBinding);
            binding.offset = m_compiler.type_struct_member_offset(table, i);
            binding.kind = BindingKind::BufferAddress;
            binding.isReadable = !isAll(spv::DecorationNonReadable);
            binding.isWritable = !isAll(spv::DecorationNonWritable);
            binding.isUsed = used.Uses(i);
            binding.blockBytes = static_cast<uint32_t>(fixed);
            binding.elementBytes = static_cast<uint32_t>(withOne - fixed);
        }
    }

    void AddBuffer(const Resource& resource, BindingKind kind) {
        if (kind == BindingKind::UniformBuffer &&
            IsTableOfAddresses(m_compiler.get_type(resource.base_type_id)))
            return AddAddresses(resource);
        Binding& binding = Add(resource, kind);
        const spirv_cross::SPIRType& type = m_compiler.get_type(resource.base_type_id);
        const size_t fixed = m_compiler.get_declared_struct_size_runtime_array(type, 0);
        const size_t withOne = m_compiler.get_declared_struct_size_runtime_array(type, 1);
        binding.blockBytes = static_cast<uint32_t>(fixed);
        binding.elementBytes = static_cast<uint32_t>(withOne - fixed);
        if (kind == BindingKind::UniformBuffer) return;
        const spirv_cross::Bitset flags = m_compiler.get_buffer_block_flags(resource.id);
        binding.isReadable = !flags.get(spv::DecorationNonReadable);
        binding.isWritable = !flags.get(spv::DecorationNonWritable);
    }

    void ReadPushConstants(const Resource& resource) {
        m_result.pushConstants.name = NameOf(resource);
        const size_t bytes = m_compiler.get_declared_struct_size(m_compiler.get_type(resource.base_type_id));
        m_result.pushConstants.bytes = static_cast<uint32_t>((bytes + 3) / 4 * 4);
    }

    void ReadSpecialization() {
        for (const auto& constant : m_compiler.get_specialization_constants()) {
            SpecializationConstant out;
            out.id = constant.constant_id;
            out.name = m_compiler.get_name(constant.id);
            const auto& value = m_compiler.get_constant(constant.id);
            out.defaultValue = value.scalar();
            const std::optional<ConstantType> type = ConstantTypeOf(m_compiler.get_type(value.constant_type));
            if (!type) Fail("specialization constant {} '{}' is not of a 32-bit type", out.id, out.name);
            out.type = *type;
            m_result.specialization.push_back(std::move(out));
        }
        // The compiler may declare one id twice: for the workgroup size and for gl_WorkGroupSize.
        auto& all = m_result.specialization;
        std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
        all.erase(
            std::unique(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.id == b.id; }),
            all.end());
    }

    // SPIR-V 1.6 states the size by constants (LocalSizeId), older modules by literals.
    void ReadWorkgroupSize() {
        const auto& entry = m_compiler.get_entry_point(m_result.entryPoint, spv::ExecutionModelGLCompute);
        const auto& size = entry.workgroup_size;
        m_result.workgroupSize = {size.x, size.y, size.z};
        if (!entry.flags.get(spv::ExecutionModeLocalSizeId)) return;
        const std::array<uint32_t, 3> ids{size.id_x, size.id_y, size.id_z};
        for (size_t axis = 0; axis < ids.size(); ++axis) {
            m_result.workgroupSize[axis] = m_compiler.get_constant(ids[axis]).scalar();
            if (m_compiler.has_decoration(ids[axis], spv::DecorationSpecId))
                m_result.workgroupSizeIds[axis] = m_compiler.get_decoration(ids[axis], spv::DecorationSpecId);
        }
    }

    std::string m_name;
    spirv_cross::Compiler m_compiler;
    std::unordered_map<uint32_t, UsedVariable> m_used;
    ShaderReflection m_result;
};

}  // namespace

VkDescriptorType ToVk(BindingKind kind) {
    switch (kind) {
        case BindingKind::StorageImage:
            return VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
        case BindingKind::SampledImage:
            return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
        case BindingKind::StorageBuffer:
            return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        case BindingKind::UniformBuffer:
        case BindingKind::BufferAddress:
            return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
        case BindingKind::AccelerationStructure:
            return VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
    }
    return VK_DESCRIPTOR_TYPE_MAX_ENUM;
}

const char* Name(BindingKind kind) {
    switch (kind) {
        case BindingKind::StorageImage:
            return "storage image";
        case BindingKind::SampledImage:
            return "sampled image";
        case BindingKind::StorageBuffer:
            return "storage buffer";
        case BindingKind::UniformBuffer:
            return "uniform buffer";
        case BindingKind::AccelerationStructure:
            return "acceleration structure";
        case BindingKind::BufferAddress:
            return "buffer address";
    }
    return "?";
}

const char* Name(TexelType type) {
    switch (type) {
        case TexelType::Float:
            return "float";
        case TexelType::Int:
            return "int";
        case TexelType::Uint:
            return "uint";
    }
    return "?";
}

ShaderReflection Reflect(std::span<const uint32_t> spirv, std::string_view name) {
    constexpr uint32_t kHeaderWords = 5;
    if (spirv.size() < kHeaderWords || spirv[0] != spv::MagicNumber)
        throw MakeError(ErrorKind::Usage, "{}: is not a SPIR-V module", name);
    try {
        return Reflector(spirv, name).Run();
    } catch (const spirv_cross::CompilerError& error) {
        throw MakeError(ErrorKind::Usage, "{}: malformed SPIR-V: {}", name, error.what());
    }
}

std::vector<BlockMember> PushConstantMembers(std::span<const uint32_t> spirv) {
    const spirv_cross::Compiler compiler(spirv.data(), spirv.size());
    std::vector<BlockMember> members;
    for (const auto& resource : compiler.get_shader_resources().push_constant_buffers) {
        const spirv_cross::SPIRType& block = compiler.get_type(resource.base_type_id);
        for (uint32_t i = 0; i < block.member_types.size(); ++i) {
            const spirv_cross::SPIRType& type = compiler.get_type(block.member_types[i]);
            const std::optional<ConstantType> known = ConstantTypeOf(type);
            const bool isVector = known && type.columns == 1 && type.array.empty();
            members.push_back({.name = compiler.get_member_name(resource.base_type_id, i),
                               .offset = compiler.type_struct_member_offset(block, i),
                               .type = known.value_or(ConstantType::Float),
                               .count = isVector ? type.vecsize : 0});
        }
    }
    return members;
}

ShaderReflection ReflectionOf(const ShaderStage& stage) {
    return stage.reflection ? *stage.reflection : Reflect(stage.spirv, stage.name);
}

// --- The interface of a pipeline, merged from the reflections of its stages ---

namespace {

constexpr uint32_t kPassSet = 0;
constexpr uint32_t kTextureTableSet = 1;

std::string Describe(const Binding& binding) {
    std::string text = Text("{} '{}'", Name(binding.kind), binding.name);
    if (binding.count != 1) text += binding.count == 0 ? "[]" : Text("[{}]", binding.count);
    if (binding.texelType != TexelType::Float) text += Text(" of {} texels", Name(binding.texelType));
    return binding.shape == ImageShape::Plain ? text : Text("{} ({})", text, Name(binding.shape));
}

[[noreturn]] void Fail(const std::string& text) {
    throw Error(ErrorKind::Usage, text);
}

void CheckTextureTable(const std::string& shader, const Binding& binding) {
    if (binding.binding != 0 || binding.kind != BindingKind::SampledImage ||
        binding.shape != ImageShape::Plain || binding.texelType != TexelType::Float)
        Fail(Text("{}: set 1 binding {} is {}; set 1 is for the bindless textures, sampler2D[] at binding 0",
                  shader, binding.binding, Describe(binding)));
}

void CheckAgree(const BindingInfo& first, const std::string& shader, const Binding& second) {
    const bool sameSlot = first.binding == second.binding && first.offset == second.offset;
    const bool sameName = first.name == second.name;
    if (sameSlot && sameName && first.kind == second.kind && first.count == second.count &&
        first.shape == second.shape && first.texelType == second.texelType &&
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
    constexpr uint32_t kMaxElements = 4096;  // far more than devices bind, and few enough to list
    if (binding.count > kMaxElements)
        Fail(Text("{}: '{}' is an array of {} in set 0, at most {} are bound", stage.name, binding.name,
                  binding.count, kMaxElements));
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

// Replaces each array by its elements, "shadowMaps" by "shadowMaps[0]" and so on.
void ListElements(std::vector<BindingInfo>& bindings) {
    std::vector<BindingInfo> elements;
    for (const BindingInfo& info : bindings) {
        for (uint32_t i = 0; i < info.count; ++i) {
            BindingInfo& element = elements.emplace_back(info);
            element.element = i;
            if (info.count > 1) element.name = Text("{}[{}]", info.name, i);
        }
    }
    bindings = std::move(elements);
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
    ListElements(merged.bindings);
    std::sort(merged.specialization.begin(), merged.specialization.end(),
              [](const auto& a, const auto& b) { return a.id < b.id; });
    return merged;
}

}  // namespace raygraph::rhi
