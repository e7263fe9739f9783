// Compute, raster and ray-tracing pipelines, their common base Pipeline, and the statistics of their
// compiled programs. The layout is derived from the shaders:
//   set 0  push descriptors (vkCmdPushDescriptorSetKHR) of every binding of any stage
//   set 1  the bindless textures (rhi/texture_table.h), if a stage declares set 1
//   push constants: one range from 0, visible to all stages
// Pipelines are owners as in rhi/resources.h: move-only, freed once the timeline has passed every submission
// made before. Threads: any, also for CreateComputePipeline, CreateRasterPipeline and
// CreateRayTracingPipeline; a pipeline does not change once it is created.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "rhi/format.h"
#include "rhi/reflection.h"
#include "rhi/resources.h"
#include "rhi/shader_binding_table.h"
#include "rhi/shader_stage.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

class Device;

class RAYGRAPH_API Pipeline {
  public:
    VkPipeline Handle() const { return m_pipeline; }
    VkPipelineLayout Layout() const { return m_layout; }
    const std::string& Name() const { return m_name; }
    explicit operator bool() const { return m_pipeline != VK_NULL_HANDLE; }

    // Returns the merged reflection of all stages.
    const ShaderInterface& Interface() const { return m_interface; }
    std::span<const BindingInfo> Bindings() const { return m_interface.bindings; }
    const BindingInfo* Find(std::string_view name) const { return m_interface.Find(name); }
    bool UsesTextureTable() const { return m_interface.usesTextureTable; }
    // Returns the bytes of the push-constant range, a multiple of 4; 0: none.
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

// --- Compute pipelines ---

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

// --- Raster pipelines ---
// They use dynamic rendering. There is no vertex input: the vertex shader fetches its attributes from
// storage buffers by gl_VertexIndex. Not supported: MSAA, stencil, tessellation, geometry and mesh shaders.

enum class Topology : uint8_t { TriangleList, TriangleStrip, LineList, PointList };
enum class CullMode : uint8_t { None, Front, Back };
enum class DepthCompare : uint8_t { Always, Less, LessOrEqual, Equal, Greater, GreaterOrEqual };
enum class BlendMode : uint8_t {
    Off,
    Alpha,          // straight alpha, over
    Premultiplied,  // premultiplied alpha, over
    Additive,
};

struct RasterPipelineDesc {
    std::string name = "raster pipeline";
    ShaderStage vertex{};
    ShaderStage fragment{};  // empty: only depth is drawn
    std::vector<SpecializationValue> specialization{};
    std::vector<Format> colorFormats{};
    Format depthFormat = Format::Undefined;  // Undefined: no depth target
    Topology topology = Topology::TriangleList;
    CullMode cull = CullMode::None;
    bool isFrontClockwise = false;  // as seen in the framebuffer; glTF's front is counter-clockwise with y up
    DepthCompare depthCompare = DepthCompare::LessOrEqual;
    bool writesDepth = true;
    BlendMode blend = BlendMode::Off;  // blending of every color target
    bool isWireframe = false;          // needs the feature fillModeNonSolid
};

class RAYGRAPH_API RasterPipeline : public Pipeline {
  public:
    RasterPipeline() = default;

  private:
    friend RasterPipeline CreateRasterPipeline(Device& device, const RasterPipelineDesc& desc);
    RasterPipeline(Device& device, const RasterPipelineDesc& desc);
};

// Throws as CreateComputePipeline does. Viewport and scissor are dynamic.
RAYGRAPH_API RasterPipeline CreateRasterPipeline(Device& device, const RasterPipelineDesc& desc);

// --- Ray-tracing pipelines ---
// They have shader groups and a shader binding table (rhi/shader_binding_table.h). Hit groups are given by
// hit set and, within it, by ray type. Ray types are numbers from 0 up that the caller assigns and passes to
// traceRayEXT. TlasInstance::hitRecord selects an instance's hit set. A shader calls a callable by its index
// in `callables`.

// A ray-generation, miss or callable shader with the data of its record (`shaderRecordEXT` in the shader).
struct GeneralShader {
    ShaderStage stage{};
    std::vector<std::byte> recordData{};
};

// Holds the shaders that a hit runs. If all are empty, triangles are hit without effect on the payload, and
// AABBs are never hit. With an intersection shader the group is for AABBs, without one for triangles.
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
    // The hit sets of the table, as indices into hitSets: a set that several of them share has its groups in
    // the pipeline once. Empty: each of hitSets, in their order.
    std::vector<uint32_t> tableSets{};
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
// ray-generation shader, a shader of the wrong stage, an index of tableSets out of range, and maxRecursion or
// record data above the device's limits; otherwise as CreateComputePipeline.
RAYGRAPH_API RayTracingPipeline CreateRayTracingPipeline(Device& device, const RayTracingPipelineDesc& desc);

// --- Statistics ---
// Numbers about the programs that a driver has compiled from a pipeline's shaders: registers, stack memory,
// occupancy. Names and units are the driver's.

struct ProgramStatistic {
    std::string name;         // "Register Count"
    std::string description;  // a sentence
    double value = 0.0;       // 1 or 0 for a boolean
};

struct ProgramStatistics {
    std::string name;           // the driver's name of the program: "RAY GENERATION"
    uint32_t subgroupSize = 0;  // 0: unknown
    std::vector<ProgramStatistic> statistics;
};

// Returns nothing unless DeviceDesc::capturesStatistics was set and the device supports it
// (OptionalFeatures::pipelineStatistics), and nothing for an empty pipeline. Throws Error{Vulkan} or
// {OutOfMemory} from the driver.
RAYGRAPH_API std::vector<ProgramStatistics> StatisticsOf(const Device& device, const Pipeline& pipeline);

}  // namespace raygraph::rhi
