// Shader stages as input of pipelines: a name, SPIR-V words and specialization values. Threads: plain values
// and pure functions, for any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/api.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

enum class StageKind : uint8_t {
    RayGen,
    Miss,
    ClosestHit,
    AnyHit,
    Intersection,
    Callable,
    Compute,
    Vertex,
    Fragment,
};

RAYGRAPH_API VkShaderStageFlagBits ToVk(StageKind stage);
// Returns text such as "ray generation" or "closest hit", for errors.
RAYGRAPH_API const char* Name(StageKind stage);
// Returns the stage by the suffix of the file: .rgen .rmiss .rchit .rahit .rint .rcall .comp .vert .frag;
// nullopt for any other.
RAYGRAPH_API std::optional<StageKind> StageOfFile(std::string_view fileName);

struct ShaderReflection;

// Describes one stage of a pipeline. Words and reflection are read while the pipeline is created and may be
// freed afterwards. A stage without words is absent.
struct ShaderStage {
    std::string name{};  // "pathtrace/pathtrace.rgen": for errors and labels
    std::span<const uint32_t> spirv{};
    const ShaderReflection* reflection = nullptr;  // reflection of the words (Reflect), if the caller has it

    bool IsEmpty() const { return spirv.empty(); }
};

// Describes a 32-bit specialization constant (int, uint, float bits, or bool as 0 and 1) by its constant_id.
struct SpecializationValue {
    uint32_t id = 0;
    uint32_t value = 0;

    bool operator==(const SpecializationValue&) const = default;
};

}  // namespace raygraph::rhi
