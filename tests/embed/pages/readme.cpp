// The samples of the README compile. They end nowhere and read a shader that is not there, so they do not
// run.
#include <vulkan/vulkan.h>
#include "embed_headers.h"  // the README's includes, which must suffice for its samples

#include "renderer/graph/pass_harness.h"

namespace {

[[maybe_unused]] void EmbedInTwentyLines(VkInstance instance, VkPhysicalDevice physicalDevice,
                                         VkDevice vkDevice, VkQueue queue, uint32_t family,
                                         const std::vector<std::string>& extensions, VkImage hostImage) {
#include "embed_in_twenty_lines.inc"
}

#include "blur.inc"

[[maybe_unused]] void TestBlur(rhi::Device& device) {
#include "test_blur.inc"
}

}  // namespace
