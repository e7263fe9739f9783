#include "rhi/pipeline.h"

#include <utility>
#include <vector>

#include "base/text.h"
#include "rhi/device.h"

namespace raygraph::rhi {
namespace {

ShaderInterface InterfaceOf(const std::string& pipeline, std::span<const ShaderStage> stages) {
    std::vector<NamedReflection> reflections;
    for (const ShaderStage& stage : stages)
        if (!stage.IsEmpty()) reflections.push_back({stage.name, ReflectionOf(stage)});
    try {
        return MergeInterface(reflections);
    } catch (const Error& error) {
        throw MakeError(error.Kind(), "{}: {}", pipeline, error.what());
    }
}

VkDescriptorSetLayout CreatePassSetLayout(Device& device, const std::string& pipeline,
                                          const ShaderInterface& interface) {
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    uint32_t descriptorCount = 0;
    for (const BindingInfo& info : interface.bindings) {
        // The reflection lists each address of a table; the block that holds them is one binding.
        if (info.kind == BindingKind::BufferAddress && !bindings.empty() &&
            bindings.back().binding == info.binding) {
            bindings.back().stageFlags |= info.stages;
            continue;
        }
        VkDescriptorSetLayoutBinding binding{};
        binding.binding = info.binding;
        binding.descriptorType = ToVk(info.kind);
        binding.descriptorCount = info.count;
        binding.stageFlags = info.stages;
        bindings.push_back(binding);
        descriptorCount += info.count;
    }
    if (descriptorCount > device.Info().maxPushDescriptors)
        throw MakeError(ErrorKind::Usage, "{}: binds {} descriptors in set 0, maxPushDescriptors is {}",
                        pipeline, descriptorCount, device.Info().maxPushDescriptors);
    VkDescriptorSetLayoutCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    create.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR;
    create.bindingCount = static_cast<uint32_t>(bindings.size());
    create.pBindings = bindings.data();
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    device.Check(device.Vk().vkCreateDescriptorSetLayout(device.Handle(), &create,
                                                         device.AllocationCallbacks(), &layout),
                 pipeline + ": vkCreateDescriptorSetLayout");
    return layout;
}

}  // namespace

Pipeline::Pipeline(Device& device, std::string name, std::span<const ShaderStage> stages)
    : m_device(&device), m_name(std::move(name)), m_interface(InterfaceOf(m_name, stages)) {
    const uint32_t pushBytes = m_interface.pushConstants.bytes;
    if (pushBytes > device.Info().maxPushConstantBytes)
        throw MakeError(ErrorKind::Usage, "{}: {} has {} bytes of push constants, maxPushConstantsSize is {}",
                        m_name, m_interface.pushConstantShader, pushBytes,
                        device.Info().maxPushConstantBytes);
    m_setLayout = CreatePassSetLayout(device, m_name, m_interface);

    std::vector<VkDescriptorSetLayout> sets{m_setLayout};
    const VkPushConstantRange range{m_interface.stages, 0, pushBytes};
    VkPipelineLayoutCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    try {
        if (m_interface.usesTextureTable) sets.push_back(device.TextureTableLayout());
        create.setLayoutCount = static_cast<uint32_t>(sets.size());
        create.pSetLayouts = sets.data();
        create.pushConstantRangeCount = pushBytes > 0 ? 1 : 0;
        create.pPushConstantRanges = &range;
        VkPipelineLayout layout = VK_NULL_HANDLE;
        device.Check(device.Vk().vkCreatePipelineLayout(device.Handle(), &create,
                                                        device.AllocationCallbacks(), &layout),
                     m_name + ": vkCreatePipelineLayout");
        m_layout = layout;
    } catch (...) {
        Release();
        throw;
    }
    device.SetName(VK_OBJECT_TYPE_PIPELINE_LAYOUT, reinterpret_cast<uint64_t>(m_layout), m_name);
}

Pipeline& Pipeline::operator=(Pipeline&& other) noexcept {
    if (this == &other) return *this;
    Release();
    m_device = std::exchange(other.m_device, nullptr);
    m_name = std::move(other.m_name);
    m_interface = std::move(other.m_interface);
    m_pipeline = std::exchange(other.m_pipeline, VK_NULL_HANDLE);
    m_layout = std::exchange(other.m_layout, VK_NULL_HANDLE);
    m_setLayout = std::exchange(other.m_setLayout, VK_NULL_HANDLE);
    m_creationMs = other.m_creationMs;
    return *this;
}

Pipeline::~Pipeline() {
    Release();
}

void Pipeline::Release() noexcept {
    if (!m_device) return;
    m_device->Retire([device = m_device, pipeline = m_pipeline, layout = m_layout, setLayout = m_setLayout] {
        const DeviceFunctions& vk = device->Vk();
        vk.vkDestroyPipeline(device->Handle(), pipeline, device->AllocationCallbacks());
        vk.vkDestroyPipelineLayout(device->Handle(), layout, device->AllocationCallbacks());
        vk.vkDestroyDescriptorSetLayout(device->Handle(), setLayout, device->AllocationCallbacks());
    });
    m_device = nullptr;
}

}  // namespace raygraph::rhi
