// The environment on the device: textures of one color, and the table from which its directions are sampled.
// Threads: that of the Uploader.
#pragma once

#include <cstddef>
#include <span>

#include "renderer/gpu_scene/lights/environment_table.h"
#include "renderer/graph/access.h"
#include "rhi/device.h"
#include "rhi/upload.h"

namespace raygraph {

// Returns a texture of one white texel, for unused texture slots.
rhi::Texture WhiteTexture(rhi::Device& device, rhi::Uploader& uploader);

// A map, and the table from which directions to it are sampled.
struct EnvironmentOnDevice {
    rhi::Texture map;
    ResourceState mapState{.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    rhi::Buffer table;
    ResourceState tableState;
    glm::uvec2 cells{1};
    glm::vec3 meanRadiance{1.0f};
};

// Uploads a map and its table, which are complete once the uploader's work is done. Throws Error{OutOfMemory}
// if the device cannot bind a table of that many entries, or has no memory for it.
EnvironmentOnDevice UploadEnvironment(rhi::Device& device, rhi::Uploader& uploader, const image::ImageF& map);
// Returns one black texel, for an environment without a map.
EnvironmentOnDevice BlankEnvironment(rhi::Device& device, rhi::Uploader& uploader);

}  // namespace raygraph
