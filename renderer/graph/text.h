// Small text helpers of the graph's messages and plan text.
#pragma once

#include <cstdint>
#include <string>

#include "base/printable.h"  // Quoted
#include "base/text.h"       // BytesText
#include "rhi/vulkan.h"

namespace raygraph {

// "RayTracingShader", "ComputeShader|Copy", "nothing".
std::string StagesText(VkPipelineStageFlags2 stages);
// "read", "write", "read+write"; "" for none.
const char* AccessText(VkAccessFlags2 access);
// "General", "ShaderReadOnly", ...
const char* LayoutText(VkImageLayout layout);

}  // namespace raygraph
