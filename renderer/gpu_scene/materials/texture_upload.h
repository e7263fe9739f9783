// Copies the textures of a scene to the device, with the levels that fit, which are made there; all at once,
// or each when it is needed, in pieces. For renderer/gpu_scene. Threads: that of the uploader.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "renderer/gpu_scene/materials/texture_set.h"
#include "renderer/scene/model/scene_data.h"
#include "rhi/upload.h"

namespace raygraph {

struct TextureUploadSettings {
    bool makesMipLevels = false;   // for textures whose samplers filter by levels
    uint64_t budget = UINT64_MAX;  // bytes of all textures
    float maxAnisotropy = 1.0f;    // for textures with levels that are filtered linearly
};

class TextureUpload {
  public:
    // Plans which levels fit. Keeps references to the device, the uploader, and the textures, images and
    // materials of the scene.
    TextureUpload(rhi::Device& device, rhi::Uploader& uploader, scene::SceneData& scene,
                  const TextureUploadSettings& settings);
    ~TextureUpload();
    TextureUpload(TextureUpload&& other) noexcept;

    // Continues with the texture, or with one on which it depends, and copies about `budget` bytes at most,
    // which it subtracts. Returns true once the texture is complete, with the making of its mip levels at
    // least submitted. At most two images are in work on the device: beyond that the call waits, or returns
    // false if mayWait is false. Frees each image after its last use.
    bool Make(uint32_t texture, uint64_t& budget, bool mayWait = true);
    // Returns whether the device still makes mip levels; the destructor waits for that.
    bool IsBusy() const;
    // Requires that the texture is complete.
    SceneTexture Get(uint32_t texture) const;
    // Bytes that all textures together will have copied in the end, and bytes copied so far.
    uint64_t Bytes() const;
    uint64_t CopiedBytes() const;
    // Returns the bytes that incomplete textures will take on the device.
    uint64_t PendingBytes() const;
    // Returns the message that images were made smaller; empty if none were.
    const std::string& Reduction() const;

  private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

// Returns half of what the process may use of the largest heap of device memory, but no more than is left of
// it.
uint64_t DefaultTextureBudget(const rhi::Device& device);

}  // namespace raygraph
