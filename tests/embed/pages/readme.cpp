// The samples of the README compile. They end nowhere and read a shader that is not there, so they do not
// run.
#include <vulkan/vulkan.h>
#include "passes/accumulate.h"
#include "passes/tonemap.h"
#include "passes/trace.h"
#include "renderer/gpu_scene/camera_record.h"
#include "renderer/gpu_scene/gpu_scene.h"

#include "renderer/graph/pass_harness.h"
#include "renderer/scene/camera_view.h"
#include "renderer/scene/load_gltf.h"

using namespace raygraph;  // NOLINT: as in the README

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
