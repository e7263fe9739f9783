#include "rhi/compute_pipeline.h"

#include "base/stopwatch.h"
#include "base/text.h"
#include "rhi/device.h"
#include "rhi/stage_set.h"

namespace raygraph::rhi {

ComputePipeline::ComputePipeline(Device& device, const ComputePipelineDesc& desc)
    : Pipeline(device, desc.name, std::span(&desc.shader, 1)) {
    StageSet stages(device, m_name, m_interface, desc.specialization);
    stages.Add(desc.shader, StageKind::Compute);

    const ShaderReflection reflection = ReflectionOf(desc.shader);
    m_workgroupSize = reflection.workgroupSize;
    for (const SpecializationValue& value : desc.specialization)
        for (size_t axis = 0; axis < m_workgroupSize.size(); ++axis)
            if (reflection.workgroupSizeIds[axis] == value.id) m_workgroupSize[axis] = value.value;

    VkComputePipelineCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
    create.stage = stages.Infos()[0];
    create.layout = m_layout;
    create.flags = device.PipelineFlags();
    const Stopwatch stopwatch;
    device.Check(device.Vk().vkCreateComputePipelines(device.Handle(), device.PipelineCache(), 1, &create,
                                                      device.AllocationCallbacks(), &m_pipeline),
                 m_name + ": vkCreateComputePipelines");
    m_creationMs = stopwatch.Milliseconds();
    device.SetName(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<uint64_t>(m_pipeline), m_name);
}

ComputePipeline CreateComputePipeline(Device& device, const ComputePipelineDesc& desc) {
    if (desc.shader.IsEmpty()) throw MakeError(ErrorKind::Usage, "{}: has no compute shader", desc.name);
    return {device, desc};
}

}  // namespace raygraph::rhi
