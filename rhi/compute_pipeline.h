// A compute pipeline. Threads: any.
#pragma once

#include <array>
#include <vector>

#include "base/api.h"
#include "rhi/pipeline.h"

namespace raygraph::rhi {

struct ComputePipelineDesc {
    std::string name = "compute pipeline";
    ShaderStage shader{};
    std::vector<SpecializationValue> specialization{};
};

class RAYGRAPH_API ComputePipeline : public Pipeline {
  public:
    ComputePipeline() = default;
    // Returns the invocations of a workgroup along x, y, z, with the specialization applied.
    std::array<uint32_t, 3> WorkgroupSize() const { return m_workgroupSize; }

  private:
    friend ComputePipeline CreateComputePipeline(Device& device, const ComputePipelineDesc& desc);
    ComputePipeline(Device& device, const ComputePipelineDesc& desc);
    std::array<uint32_t, 3> m_workgroupSize{1, 1, 1};
};

// Throws Error{Usage} naming the pipeline for a shader of another stage, a specialization id that the shader
// does not have, or more push constants or bindings than the device takes; Error{Vulkan} or {OutOfMemory}
// from the driver.
RAYGRAPH_API ComputePipeline CreateComputePipeline(Device& device, const ComputePipelineDesc& desc);

}  // namespace raygraph::rhi
