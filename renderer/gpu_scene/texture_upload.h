// Brings the textures of a scene to the device: the levels that fit, made there. For renderer/gpu_scene.
// Threads: that of the uploader.
#pragma once

#include <cstdint>
#include <string>

#include "renderer/gpu_scene/scene_resources.h"

namespace raygraph {

struct TextureUploadSettings {
    bool hasLevels = false;        // of textures whose samplers filter by them
    uint64_t budget = UINT64_MAX;  // bytes of all textures
    float maxAnisotropy = 1.0f;    // of those with levels, where they are filtered linearly
    // In the slot of a table without textures, which a shader may look at. They outlive the resources.
    const rhi::Texture* defaultTexture = nullptr;
    const rhi::Sampler* defaultSampler = nullptr;
};

// Fills SceneResources::textures, textureImages, samplers, textureTable, textureBytes and textureReduction.
// Frees each image after its last use. Where levels are made, returns when the device has made them.
void UploadTextures(rhi::Device& device, rhi::Uploader& uploader, scene::SceneData& scene,
                    const TextureUploadSettings& settings, SceneResources& resources);

// Half of what the process may use of the largest heap of device memory, but no more than is left of it.
uint64_t DefaultTextureBudget(const rhi::Device& device);

}  // namespace raygraph
