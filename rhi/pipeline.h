// Pipeline: the common base of compute, raster and ray-tracing pipelines. The layout is derived from the
// shaders:
//   set 0  push descriptors (vkCmdPushDescriptorSetKHR) of every binding of any stage
//   set 1  the bindless textures (rhi/texture_table.h), if a stage declares set 1
//   push constants: one range from 0, visible to all stages
// Pipelines are owners as in rhi/resources.h: move-only, freed once the timeline has passed every submission
// made before. Threads: CreateComputePipeline, CreateRasterPipeline and CreateRayTracingPipeline may be
// called from any.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "base/api.h"
#include "rhi/reflection.h"
#include "rhi/shader_stage.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

class Device;
class ComputePipeline;     // rhi/compute_pipeline.h
class RasterPipeline;      // rhi/raster_pipeline.h
class RayTracingPipeline;  // rhi/ray_tracing_pipeline.h

class RAYGRAPH_API Pipeline {
  public:
    VkPipeline Handle() const { return m_pipeline; }
    VkPipelineLayout Layout() const { return m_layout; }
    const std::string& Name() const { return m_name; }
    explicit operator bool() const { return m_pipeline != VK_NULL_HANDLE; }

    // The merged reflection of all stages.
    const ShaderInterface& Interface() const { return m_interface; }
    std::span<const BindingInfo> Bindings() const { return m_interface.bindings; }
    const BindingInfo* Find(std::string_view name) const { return m_interface.Find(name); }
    bool UsesTextureTable() const { return m_interface.usesTextureTable; }
    // The bytes of the push-constant range, a multiple of 4; 0: none.
    uint32_t PushConstantBytes() const { return m_interface.pushConstants.bytes; }
    // Returns the stages for vkCmdPushConstants: those of the range in the layout.
    VkShaderStageFlags PushConstantStages() const { return m_interface.stages; }
    // Returns the wall time in which the driver created the pipeline.
    double CreationMs() const { return m_creationMs; }

  protected:
    Pipeline() = default;
    // Reflects and merges the stages and creates the layouts; the derived class then creates the VkPipeline.
    Pipeline(Device& device, std::string name, std::span<const ShaderStage> stages);
    Pipeline(Pipeline&& other) noexcept { *this = std::move(other); }
    Pipeline& operator=(Pipeline&& other) noexcept;
    ~Pipeline();

    Device* m_device = nullptr;
    std::string m_name;
    ShaderInterface m_interface;
    VkPipeline m_pipeline = VK_NULL_HANDLE;
    VkPipelineLayout m_layout = VK_NULL_HANDLE;
    VkDescriptorSetLayout m_setLayout = VK_NULL_HANDLE;
    double m_creationMs = 0.0;

  private:
    void Release() noexcept;
};

}  // namespace raygraph::rhi
