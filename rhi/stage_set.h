// StageSet: the shader modules and specialization of one pipeline while it is being created. For rhi/ alone.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "rhi/shader_stage.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

class Device;
struct ShaderInterface;

class StageSet {
  public:
    // Throws Error{Usage} naming `pipeline` for a specialization id that no stage has.
    StageSet(Device& device, const std::string& pipeline, const ShaderInterface& interface,
             std::span<const SpecializationValue> specialization);
    ~StageSet();
    StageSet(const StageSet&) = delete;
    StageSet& operator=(const StageSet&) = delete;

    // Returns the index of the stage in Infos(). A stage that was added before for the same `partner` is not
    // added again. Throws Error{Usage} if the shader is not of the given stage.
    uint32_t Add(const ShaderStage& shader, StageKind expected, uint32_t partner = VK_SHADER_UNUSED_KHR);
    // Returns VK_SHADER_UNUSED_KHR for an empty stage.
    uint32_t AddIfPresent(const ShaderStage& shader, StageKind expected,
                          uint32_t partner = VK_SHADER_UNUSED_KHR);

    // Valid while the set lives and no stage is added.
    std::span<const VkPipelineShaderStageCreateInfo> Infos() const { return m_infos; }

  private:
    Device& m_device;
    std::string m_pipeline;
    std::vector<SpecializationValue> m_given;
    std::vector<uint32_t> m_values;
    std::vector<VkSpecializationMapEntry> m_entries;
    VkSpecializationInfo m_specialization{};
    // These lists are parallel: one entry for each stage.
    std::vector<const uint32_t*> m_words;
    std::vector<uint32_t> m_partners;
    std::vector<StageKind> m_kinds;
    std::vector<VkPipelineShaderStageCreateInfo> m_infos;
};

}  // namespace raygraph::rhi
