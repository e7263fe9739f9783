#include "rhi/shader_specializer.h"

#include <algorithm>
#include <spirv.hpp>
#include <unordered_map>
#include <unordered_set>

#ifdef RAYGRAPH_HAS_SPIRV_TOOLS
#include <spirv-tools/libspirv.h>
#include <spirv-tools/optimizer.hpp>
#endif

namespace raygraph::rhi {
namespace {

constexpr size_t kHeaderWords = 5;

// Calls visit(opcode, words of the instruction) for each instruction; stops at one that is truncated.
template <typename Words, typename Visit>
void ForEachInstruction(Words spirv, Visit visit) {
    for (size_t at = kHeaderWords; at < spirv.size();) {
        const size_t count = spirv[at] >> spv::WordCountShift;
        if (count == 0 || count > spirv.size() - at) return;
        visit(static_cast<spv::Op>(spirv[at] & spv::OpCodeMask), spirv.subspan(at, count));
        at += count;
    }
}

}  // namespace

std::vector<SpecializationValue> ValuesOf(std::span<const uint32_t> spirv,
                                          std::span<const SpecializationValue> values) {
    std::vector<SpecializationValue> own;
    ForEachInstruction(spirv, [&](spv::Op op, std::span<const uint32_t> words) {
        if (op != spv::OpDecorate || words.size() != 4 || words[2] != spv::DecorationSpecId) return;
        const auto value =
            std::find_if(values.begin(), values.end(), [&](const auto& v) { return v.id == words[3]; });
        if (value != values.end()) own.push_back(*value);
    });
    return own;
}

#ifndef RAYGRAPH_HAS_SPIRV_TOOLS

std::string SpecializerVersion() {
    return {};
}

std::vector<uint32_t> SpecializeSpirv(std::span<const uint32_t>, std::span<const SpecializationValue>) {
    return {};
}

#else

namespace {

// Returns the functions that do nothing except return a constant of the module, with that constant.
std::unordered_map<uint32_t, uint32_t> ConstantFunctions(std::span<const uint32_t> spirv) {
    std::unordered_map<uint32_t, uint32_t> found;
    std::unordered_set<uint32_t> constants;
    uint32_t function = 0;
    uint32_t returned = 0;  // no id is 0
    bool isPlain = false;
    ForEachInstruction(spirv, [&](spv::Op op, std::span<const uint32_t> words) {
        switch (op) {
            case spv::OpConstant:
            case spv::OpConstantTrue:
            case spv::OpConstantFalse:
            case spv::OpConstantComposite:
            case spv::OpConstantNull:
                constants.insert(words[2]);
                break;
            case spv::OpFunction:
                function = words[2];
                returned = 0;
                isPlain = true;
                break;
            case spv::OpReturnValue:
                if (constants.count(words[1]) == 0) isPlain = false;
                returned = words[1];
                break;
            case spv::OpFunctionEnd:
                if (isPlain && returned != 0) found[function] = returned;
                function = 0;
                break;
            case spv::OpFunctionParameter:
            case spv::OpLabel:
            case spv::OpBranch:
                break;
            default:
                isPlain = false;
        }
    });
    return found;
}

// Replaces each call of such a function by a copy of its result, through which constants propagate as they do
// not through calls. Returns false if there was no such call.
bool FoldConstantCalls(std::vector<uint32_t>& spirv) {
    const std::unordered_map<uint32_t, uint32_t> functions = ConstantFunctions(spirv);
    if (functions.empty()) return false;
    std::vector<uint32_t> folded(spirv.begin(), spirv.begin() + kHeaderWords);
    folded.reserve(spirv.size());
    ForEachInstruction(std::span<const uint32_t>(spirv), [&](spv::Op op, std::span<const uint32_t> words) {
        const auto called = op == spv::OpFunctionCall ? functions.find(words[3]) : functions.end();
        if (called == functions.end()) {
            folded.insert(folded.end(), words.begin(), words.end());
            return;
        }
        const uint32_t copy[]{4u << spv::WordCountShift | spv::OpCopyObject, words[1], words[2],
                              called->second};
        folded.insert(folded.end(), std::begin(copy), std::end(copy));
    });
    spirv = std::move(folded);
    return true;
}

bool Optimize(std::vector<uint32_t>& spirv, std::vector<spvtools::Optimizer::PassToken> passes) {
    spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_3);
    for (spvtools::Optimizer::PassToken& pass : passes) optimizer.RegisterPass(std::move(pass));
    spvtools::OptimizerOptions options;
    options.set_run_validator(false);  // glslang has validated the shaders
    options.set_preserve_bindings(true);
    std::vector<uint32_t> optimized;
    if (!optimizer.Run(spirv.data(), spirv.size(), &optimized, options)) return false;
    spirv = std::move(optimized);
    return true;
}

// Removes code that constants decide. Expressions that short-circuit on a constant become constant themselves
// once branches are gone, so that a round on branches comes first; the propagation is the slowest pass, and
// then has half as much to do.
std::vector<spvtools::Optimizer::PassToken> Pruning() {
    std::vector<spvtools::Optimizer::PassToken> passes;
    passes.push_back(spvtools::CreateDeadBranchElimPass());
    passes.push_back(spvtools::CreateEliminateDeadFunctionsPass());
    passes.push_back(spvtools::CreateCCPPass());
    passes.push_back(spvtools::CreateDeadBranchElimPass());
    passes.push_back(spvtools::CreateEliminateDeadFunctionsPass());
    constexpr bool kPreservesInterface = true;
    passes.push_back(spvtools::CreateAggressiveDCEPass(kPreservesInterface));
    return passes;
}

}  // namespace

std::string SpecializerVersion() {
    return RAYGRAPH_SPECIALIZER_HASH " " + std::string(spvSoftwareVersionDetailsString());
}

std::vector<uint32_t> SpecializeSpirv(std::span<const uint32_t> spirv,
                                      std::span<const SpecializationValue> values) {
    if (spirv.size() < kHeaderWords) return {};
    std::unordered_map<uint32_t, std::vector<uint32_t> > bits;
    for (const SpecializationValue& value : values) bits[value.id] = {value.value};

    std::vector<spvtools::Optimizer::PassToken> passes;
    passes.push_back(spvtools::CreateStripDebugInfoPass());
    passes.push_back(spvtools::CreateSetSpecConstantDefaultValuePass(bits));
    passes.push_back(spvtools::CreateFreezeSpecConstantValuePass());
    passes.push_back(spvtools::CreateFoldSpecConstantOpAndCompositePass());
    for (spvtools::Optimizer::PassToken& pass : Pruning()) passes.push_back(std::move(pass));
    std::vector<uint32_t> words(spirv.begin(), spirv.end());
    if (!Optimize(words, std::move(passes))) return {};

    // Each round makes more functions constant. Values that pass through variables are followed only when
    // less code is left, because that takes long.
    constexpr int kMaxRounds = 3;
    for (int round = 0; round < kMaxRounds; ++round) {
        if (!FoldConstantCalls(words) && round > 0) break;
        passes.clear();
        passes.push_back(spvtools::CreateSSARewritePass());
        for (spvtools::Optimizer::PassToken& pass : Pruning()) passes.push_back(std::move(pass));
        passes.push_back(spvtools::CreateEliminateDeadConstantPass());
        if (!Optimize(words, std::move(passes))) return {};
    }
    return words;
}

#endif

}  // namespace raygraph::rhi
