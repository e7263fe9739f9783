#include "rhi/stage_set.h"

#include <algorithm>
#include <spirv_cross/spirv.hpp>
#include <vector>

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

// --- Static use ---

namespace {

constexpr size_t kHeaderWords = 5;

using Words = std::span<const uint32_t>;

struct Function {
    std::unordered_map<uint32_t, UsedVariable> used;
    std::unordered_set<uint32_t> called;
};

class Scan {
  public:
    explicit Scan(Words spirv) {
        for (size_t at = kHeaderWords; at < spirv.size();) {
            const uint32_t count = spirv[at] >> spv::WordCountShift;
            if (count == 0 || count > spirv.size() - at) return;
            Read(static_cast<spv::Op>(spirv[at] & spv::OpCodeMask), spirv.subspan(at, count));
            at += count;
        }
    }

    std::unordered_map<uint32_t, UsedVariable> OfEntryPoint() {
        std::unordered_map<uint32_t, UsedVariable> used;
        std::vector<uint32_t> left{m_entry};
        std::unordered_set<uint32_t> seen{m_entry};
        while (!left.empty()) {
            const Function& function = m_functions[left.back()];
            left.pop_back();
            for (const auto& [variable, use] : function.used) {
                UsedVariable& sum = used[variable];
                sum.isWhole |= use.isWhole;
                sum.members.insert(use.members.begin(), use.members.end());
            }
            for (const uint32_t next : function.called)
                if (seen.insert(next).second) left.push_back(next);
        }
        return used;
    }

  private:
    // Marks the variable with this id, if there is one.
    void Use(Words instruction, size_t word) {
        if (word < instruction.size() && m_variables.contains(instruction[word]))
            m_function->used[instruction[word]].isWhole = true;
    }

    // Marks a member of a block, which is the first index. If that is no constant, the variable is an array.
    void UseMember(Words instruction) {
        constexpr size_t kBase = 3, kIndex = 4;
        if (instruction.size() <= kBase || !m_variables.contains(instruction[kBase])) return;
        const auto index =
            instruction.size() > kIndex ? m_constants.find(instruction[kIndex]) : m_constants.end();
        if (index == m_constants.end()) return Use(instruction, kBase);
        m_function->used[instruction[kBase]].members.insert(index->second);
    }

    void Read(spv::Op op, Words instruction) {
        constexpr size_t kShortest = 4;  // the number of words with which these instructions are complete
        const bool isRead = op == spv::OpEntryPoint || op == spv::OpConstant || op == spv::OpVariable ||
                            op == spv::OpFunction || op == spv::OpFunctionCall;
        if (isRead && instruction.size() < kShortest) return;
        switch (op) {
            case spv::OpEntryPoint:
                if (m_entry == 0) m_entry = instruction[2];
                return;
            case spv::OpConstant:
                m_constants[instruction[2]] = instruction[3];
                return;
            case spv::OpVariable:
                if (!m_function) m_variables.insert(instruction[2]);
                return;
            case spv::OpFunction:
                m_function = &m_functions[instruction[2]];
                return;
            case spv::OpFunctionEnd:
                m_function = nullptr;
                return;
            default:
                if (m_function) ReadInFunction(op, instruction);
        }
    }

    void ReadInFunction(spv::Op op, Words instruction) {
        const auto useFrom = [&](size_t word) {
            for (; word < instruction.size(); ++word) Use(instruction, word);
        };
        switch (op) {
            case spv::OpFunctionCall:
                m_function->called.insert(instruction[3]);
                return useFrom(4);
            case spv::OpAccessChain:
            case spv::OpInBoundsAccessChain:
            case spv::OpPtrAccessChain:
            case spv::OpInBoundsPtrAccessChain:
                return UseMember(instruction);
            case spv::OpLoad:
            case spv::OpArrayLength:
            case spv::OpImageTexelPointer:
            case spv::OpCopyObject:
                return Use(instruction, 3);
            case spv::OpStore:
            case spv::OpAtomicStore:
                return Use(instruction, 1);
            case spv::OpCopyMemory:
            case spv::OpCopyMemorySized:
                Use(instruction, 1);
                return Use(instruction, 2);
            case spv::OpSelect:
            case spv::OpPhi:
                return useFrom(3);
            case spv::OpExtInst:
                return useFrom(5);
            case spv::OpTraceRayKHR:  // the payload is the last operand
            case spv::OpExecuteCallableKHR:
                return Use(instruction, instruction.size() - 1);
            default:
                if ((op >= spv::OpAtomicLoad && op <= spv::OpAtomicXor) || op == spv::OpAtomicFAddEXT ||
                    op == spv::OpAtomicFMinEXT || op == spv::OpAtomicFMaxEXT)
                    Use(instruction, 3);
        }
    }

    uint32_t m_entry = 0;
    std::unordered_map<uint32_t, uint32_t> m_constants;
    std::unordered_set<uint32_t> m_variables;
    std::unordered_map<uint32_t, Function> m_functions;
    Function* m_function = nullptr;  // the function that is being read; elements of the map do not move
};

}  // namespace

std::unordered_map<uint32_t, UsedVariable> StaticUse(Words spirv) {
    return Scan(spirv).OfEntryPoint();
}

}  // namespace raygraph::rhi
