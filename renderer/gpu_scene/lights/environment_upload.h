// The environment on the device: textures of one color, and the table that its directions are sampled from.
// Threads: those of the Uploader.
#pragma once

#include <cstddef>
#include <span>

#include "renderer/gpu_scene/lights/environment_table.h"
#include "renderer/graph/access.h"
#include "rhi/device.h"
#include "rhi/upload.h"

namespace raygraph {

// Of one texel, for unused texture slots.
rhi::Texture WhiteTexture(rhi::Device& device, rhi::Uploader& uploader);

// A map, with the table for directions to it.
struct EnvironmentOnDevice {
    rhi::Texture map;
    ResourceState mapState{.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    rhi::Buffer table;
    ResourceState tableState;
    glm::uvec2 cells{1};
    glm::vec3 meanRadiance{1.0f};
};

// Filled once the uploader's work is done. Error{OutOfMemory} if the device cannot bind that many entries of
// a table, or has no memory for them.
EnvironmentOnDevice UploadEnvironment(rhi::Device& device, rhi::Uploader& uploader, const image::ImageF& map);
// For an environment without a map: a black texel.
EnvironmentOnDevice BlankEnvironment(rhi::Device& device, rhi::Uploader& uploader);

}  // namespace raygraph
