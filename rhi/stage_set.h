// Creates the stages of a pipeline: StageSet has their shader modules and specialization, StaticUse
// tells which resources a module uses. For rhi/ alone.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "rhi/shader_stage.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

class Device;
struct ShaderInterface;

// The shader modules and the specialization of one pipeline while it is being created.
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

// --- Static use ---
// Finds the resources that the entry point of a SPIR-V module uses statically: those that any function which
// it calls names, in any branch. It reads the module once, whereas SPIRV-Cross reads a function again for
// each call of it.

struct UsedVariable {
    bool isWhole = false;                  // more than single members are used
    std::unordered_set<uint32_t> members;  // numbers of the used members of a block
    bool Uses(uint32_t member) const { return isWhole || members.contains(member); }
};

// Returns the used variables outside of functions, by id, for the first entry point. The words must be those
// of a module that has been parsed.
std::unordered_map<uint32_t, UsedVariable> StaticUse(std::span<const uint32_t> spirv);

}  // namespace raygraph::rhi
