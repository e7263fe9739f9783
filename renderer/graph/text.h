// Text helpers for messages and plan text of the graph. Threads: pure functions.
#pragma once

#include <cstdint>
#include <string>

#include "base/printable.h"  // Quoted
#include "base/text.h"       // BytesText
#include "rhi/vulkan.h"

namespace raygraph {

// Returns text such as "RayTracingShader", "ComputeShader|Copy", "nothing".
std::string StagesText(VkPipelineStageFlags2 stages);
// Returns "read", "write", "read+write", or "" for none.
const char* AccessText(VkAccessFlags2 access);
// Returns text such as "General", "ShaderReadOnly".
const char* LayoutText(VkImageLayout layout);

}  // namespace raygraph
