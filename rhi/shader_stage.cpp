#include "rhi/shader_stage.h"

#include <array>

namespace raygraph::rhi {
namespace {

struct StageTraits {
    StageKind kind;
    VkShaderStageFlagBits bit;
    const char* name;
    std::string_view suffix;
};

constexpr std::array<StageTraits, 9> kStages{{
    {StageKind::RayGen, VK_SHADER_STAGE_RAYGEN_BIT_KHR, "ray generation", ".rgen"},
    {StageKind::Miss, VK_SHADER_STAGE_MISS_BIT_KHR, "miss", ".rmiss"},
    {StageKind::ClosestHit, VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR, "closest hit", ".rchit"},
    {StageKind::AnyHit, VK_SHADER_STAGE_ANY_HIT_BIT_KHR, "any hit", ".rahit"},
    {StageKind::Intersection, VK_SHADER_STAGE_INTERSECTION_BIT_KHR, "intersection", ".rint"},
    {StageKind::Callable, VK_SHADER_STAGE_CALLABLE_BIT_KHR, "callable", ".rcall"},
    {StageKind::Compute, VK_SHADER_STAGE_COMPUTE_BIT, "compute", ".comp"},
    {StageKind::Vertex, VK_SHADER_STAGE_VERTEX_BIT, "vertex", ".vert"},
    {StageKind::Fragment, VK_SHADER_STAGE_FRAGMENT_BIT, "fragment", ".frag"},
}};

}  // namespace

VkShaderStageFlagBits ToVk(StageKind stage) {
    return kStages[static_cast<size_t>(stage)].bit;
}

const char* Name(StageKind stage) {
    return kStages[static_cast<size_t>(stage)].name;
}

std::optional<StageKind> StageOfFile(std::string_view fileName) {
    for (const StageTraits& stage : kStages)
        if (fileName.ends_with(stage.suffix)) return stage.kind;
    return std::nullopt;
}

}  // namespace raygraph::rhi
