// The environment on the device: textures of one color, and the table that its directions are sampled from.
// Threads: those of the Uploader.
#pragma once

#include <cstddef>
#include <span>

#include "renderer/gpu_scene/environment_alias.h"
#include "rhi/device.h"
#include "rhi/upload.h"

namespace raygraph {

// Of one texel: for unused texture slots, and for a missing environment map.
rhi::Texture WhiteTexture(rhi::Device& device, rhi::Uploader& uploader);
rhi::Texture BlackEnvironment(rhi::Device& device, rhi::Uploader& uploader);

// A storage buffer of the table's entries, filled once the uploader's work is done. Error{OutOfMemory} if the
// device cannot bind that many, or has no memory for them.
rhi::Buffer UploadAlias(rhi::Device& device, rhi::Uploader& uploader, const EnvironmentAlias& alias);

}  // namespace raygraph
