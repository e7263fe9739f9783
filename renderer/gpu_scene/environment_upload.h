// The environment on the device: textures of one color, and the table that its directions are sampled from.
// Threads: those of the Uploader.
#pragma once

#include <cstddef>
#include <span>

#include "renderer/gpu_scene/environment_alias.h"
#include "rhi/device.h"
#include "rhi/upload.h"

namespace raygraph {

// A 1x1 texture, for unused texture slots and a missing environment map. `texel` has the format's size.
rhi::Texture SolidTexture(rhi::Device& device, rhi::Uploader& uploader, const char* name, rhi::Format format,
                          std::span<const std::byte> texel);

// A storage buffer of the table's entries, filled once the uploader's work is done. Error{OutOfMemory} if the
// device cannot bind that many, or has no memory for them.
rhi::Buffer UploadAlias(rhi::Device& device, rhi::Uploader& uploader, const EnvironmentAlias& alias);

}  // namespace raygraph
