// A raster pipeline for dynamic rendering. There is no vertex input: the vertex shader fetches its attributes
// from storage buffers by gl_VertexIndex. Not supported: MSAA, stencil, tessellation, geometry and mesh
// shaders. Threads: any.
#pragma once

#include <vector>

#include "base/api.h"
#include "rhi/format.h"
#include "rhi/pipeline.h"

namespace raygraph::rhi {

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

}  // namespace raygraph::rhi
