// A ray-tracing pipeline with its shader groups and its shader binding table (rhi/shader_binding_table.h).
//
// Hit groups are given by hit set and, within it, by ray type. Ray types are numbers from 0 up that the
// caller assigns and passes to traceRayEXT. TlasInstance::hitRecord selects an instance's hit set. A shader
// calls a callable by its index in `callables`. Threads: any; a pipeline does not change once it is created.
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

// The shaders that a hit runs. All may be empty: such a hit runs nothing and does not change the payload.
// With an intersection shader the group is for AABBs, without one for triangles.
struct HitGroup {
    ShaderStage closestHit{};
    ShaderStage anyHit{};
    ShaderStage intersection{};
    std::vector<std::byte> recordData{};
};

// The hit groups of one hit set; the index is the ray type.
using HitGroupSet = std::vector<HitGroup>;

// The number of ray types is the length of the longest of `miss` and all hit sets, at least 1; shorter lists
// are filled up with empty shaders.
struct RayTracingPipelineDesc {
    std::string name = "ray tracing pipeline";
    GeneralShader rayGen{};
    // By ray type; with an empty stage, a miss does not change the payload.
    std::vector<GeneralShader> miss{};
    std::vector<HitGroupSet> hitSets{};  // empty: one set that runs nothing
    std::vector<GeneralShader> callables{};
    std::vector<SpecializationValue> specialization{};
    uint32_t maxRecursion = 1;  // 1: only ray generation traces
};

class RAYGRAPH_API RayTracingPipeline : public Pipeline {
  public:
    RayTracingPipeline() = default;
    // Returns the regions for vkCmdTraceRaysKHR.
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

// Compiles a shader that several groups use once. Throws Error{Usage} naming the pipeline for a missing
// ray-generation shader, a shader of the wrong stage, and maxRecursion or record data above the device's
// limits; otherwise as CreateComputePipeline.
RAYGRAPH_API RayTracingPipeline CreateRayTracingPipeline(Device& device, const RayTracingPipelineDesc& desc);

}  // namespace raygraph::rhi
