// Small text helpers of the graph's messages and plan text.
#pragma once

#include <cstdint>
#include <string>

#include "base/printable.h"  // Quoted
#include "rhi/vulkan.h"

namespace raygraph {

// "512 B", "3.5 KiB", "7.9 MiB", "1.2 GiB".
std::string BytesText(uint64_t bytes);
// "RayTracingShader", "ComputeShader|Copy", "nothing".
std::string StagesText(VkPipelineStageFlags2 stages);
// "read", "write", "read+write"; "" for none.
const char* AccessText(VkAccessFlags2 access);
// "General", "ShaderReadOnly", ...
const char* LayoutText(VkImageLayout layout);

}  // namespace raygraph
