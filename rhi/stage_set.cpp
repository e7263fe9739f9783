#include "rhi/stage_set.h"

#include <algorithm>

#include "base/text.h"
#include "rhi/device.h"
#include "rhi/reflection.h"

namespace raygraph::rhi {

StageSet::StageSet(Device& device, const std::string& pipeline, const ShaderInterface& interface,
                   std::span<const SpecializationValue> specialization)
    : m_device(device), m_pipeline(pipeline), m_given(specialization.begin(), specialization.end()) {
    for (const SpecializationValue& value : specialization) {
        const auto& known = interface.specialization;
        if (std::none_of(known.begin(), known.end(), [&](const auto& c) { return c.id == value.id; })) {
            std::string ids;
            for (const SpecializationConstant& c : known) ids += Text(" {}", c.id);
            throw MakeError(ErrorKind::Usage,
                            "{}: specialization constant {} is in none of its shaders, which have{}",
                            pipeline, value.id, known.empty() ? " none" : ids);
        }
        m_entries.push_back(
            {value.id, static_cast<uint32_t>(m_values.size() * sizeof(uint32_t)), sizeof(uint32_t)});
        m_values.push_back(value.value);
    }
    m_specialization = {static_cast<uint32_t>(m_entries.size()), m_entries.data(),
                        m_values.size() * sizeof(uint32_t), m_values.data()};
}

StageSet::~StageSet() {
    for (const VkPipelineShaderStageCreateInfo& info : m_infos)
        m_device.Vk().vkDestroyShaderModule(m_device.Handle(), info.module, m_device.AllocationCallbacks());
}

uint32_t StageSet::Add(const ShaderStage& shader, StageKind expected, uint32_t partner) {
    size_t index = 0;
    while (index < m_words.size() && (m_words[index] != shader.spirv.data() || m_partners[index] != partner))
        ++index;
    const bool isKnown = index < m_words.size();
    const StageKind stage = isKnown ? m_kinds[index] : ReflectionOf(shader).stage;
    if (stage != expected)
        throw MakeError(ErrorKind::Usage, "{}: {} is a {} shader, given as {} shader", m_pipeline,
                        shader.name, Name(stage), Name(expected));
    if (isKnown) return static_cast<uint32_t>(index);

    VkShaderModuleCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    const auto specialized = m_device.Specialized(shader.spirv, m_given);
    const std::span<const uint32_t> words = specialized ? std::span(*specialized) : shader.spirv;
    create.codeSize = words.size_bytes();
    create.pCode = words.data();
    VkPipelineShaderStageCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage = ToVk(stage);
    info.pName = "main";
    info.pSpecializationInfo = m_entries.empty() || specialized ? nullptr : &m_specialization;
    m_words.push_back(shader.spirv.data());
    m_partners.push_back(partner);
    m_kinds.push_back(stage);
    m_infos.emplace_back();  // a null module is legal to destroy
    m_device.Check(m_device.Vk().vkCreateShaderModule(m_device.Handle(), &create,
                                                      m_device.AllocationCallbacks(), &info.module),
                   m_pipeline + ": vkCreateShaderModule of " + shader.name);
    m_device.SetName(VK_OBJECT_TYPE_SHADER_MODULE, reinterpret_cast<uint64_t>(info.module), shader.name);
    m_infos.back() = info;
    return static_cast<uint32_t>(index);
}

uint32_t StageSet::AddIfPresent(const ShaderStage& shader, StageKind expected, uint32_t partner) {
    return shader.IsEmpty() ? VK_SHADER_UNUSED_KHR : Add(shader, expected, partner);
}

}  // namespace raygraph::rhi
