// A ray-tracing pipeline with its shader groups and its shader binding table (rhi/shader_binding_table.h).
//
// Hit groups are given by hit set and, in it, by ray type. Ray types are numbers from 0 up that the caller
// assigns; traceRayEXT is given one. TlasInstance::hitRecord selects an instance's hit set. A shader calls a
// callable by its index in `callables`. Threads: any; a pipeline does not change once it is made.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "base/api.h"
#include "rhi/pipeline.h"
#include "rhi/resources.h"
#include "rhi/shader_binding_table.h"

namespace raygraph::rhi {

// A ray-generation, miss or callable shader with the data of its record (`shaderRecordEXT` in the shader).
struct GeneralShader {
    ShaderStage stage{};
    std::vector<std::byte> recordData{};
};

// The shaders that a hit runs. All may be empty: such a hit runs nothing and leaves the payload as it is.
// With an intersection shader the group is for AABBs, without one for triangles.
struct HitGroup {
    ShaderStage closestHit{};
    ShaderStage anyHit{};
    ShaderStage intersection{};
    std::vector<std::byte> recordData{};
};

// The hit groups of one hit set; the index is the ray type.
using HitGroupSet = std::vector<HitGroup>;

// The number of ray types is the length of the longest of `miss` and all hit sets, at least 1; shorter ones
// are filled up with empty shaders.
struct RayTracingPipelineDesc {
    std::string name = "ray tracing pipeline";
    GeneralShader rayGen{};
    std::vector<GeneralShader> miss{};   // by ray type; an empty stage: a miss leaves the payload as it is
    std::vector<HitGroupSet> hitSets{};  // empty: one set that runs nothing
    std::vector<GeneralShader> callables{};
    std::vector<SpecializationValue> specialization{};
    uint32_t maxRecursion = 1;  // 1: only ray generation traces
};

class RAYGRAPH_API RayTracingPipeline : public Pipeline {
  public:
    RayTracingPipeline() = default;
    // The regions for vkCmdTraceRaysKHR.
    const VkStridedDeviceAddressRegionKHR& RayGenRegion() const { return m_regions[0]; }
    const VkStridedDeviceAddressRegionKHR& MissRegion() const { return m_regions[1]; }
    const VkStridedDeviceAddressRegionKHR& HitRegion() const { return m_regions[2]; }
    const VkStridedDeviceAddressRegionKHR& CallableRegion() const { return m_regions[3]; }
    const TableLayout& Table() const { return m_tableLayout; }

  private:
    friend RayTracingPipeline CreateRayTracingPipeline(Device& device, const RayTracingPipelineDesc& desc);
    RayTracingPipeline(Device& device, const RayTracingPipelineDesc& desc);
    void CreateTable(const RayTracingPipelineDesc& desc, uint32_t groupCount);

    Buffer m_table;
    TableLayout m_tableLayout;
    std::array<VkStridedDeviceAddressRegionKHR, 4> m_regions{};
};

// A shader used by several groups is compiled once. Throws Error{Usage} naming the pipeline for a missing
// ray-generation shader, a shader of the wrong stage, maxRecursion or record data above the device's limits,
// and as CreateComputePipeline.
RAYGRAPH_API RayTracingPipeline CreateRayTracingPipeline(Device& device, const RayTracingPipelineDesc& desc);

}  // namespace raygraph::rhi
