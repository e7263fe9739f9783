// SceneContext: the part of a GpuScene that stays when its scene is replaced. For renderer/gpu_scene alone.
// Threads: that of the Renderer.
#pragma once

#include "base/disposer.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/lights/environment.h"
#include "renderer/gpu_scene/materials/texture_set.h"
#include "rhi/blas_builder.h"
#include "rhi/transfer.h"

namespace raygraph {

// It outlives the objects of all scenes, which refer to it.
struct SceneContext {
    SceneContext(rhi::Device& sceneDevice, const GpuSceneDesc& sceneDesc)
        : desc(sceneDesc),
          device(sceneDevice),
          traversal(desc.traversal == Traversal::Auto ? FasterTraversal(device) : desc.traversal),
          uploader(device),
          environment(device, uploader),
          builder(device, {.name = "scene BLASes",
                           .scratchBudget = desc.scratchBudget,
                           .compactionBudget = desc.compactionBudget}),
          defaultTexture(WhiteTexture(device, uploader)),
          defaultSampler(device.CreateSampler({.name = "default sampler"})) {}

    TextureUploadSettings TextureSettings(uint64_t budget) const {
        return {.makesMipLevels = desc.textureLevels, .budget = budget, .maxAnisotropy = desc.maxAnisotropy};
    }

    GpuSceneDesc desc;
    rhi::Device& device;
    Traversal traversal;  // Driver or Own
    rhi::Uploader uploader;
    SceneEnvironment environment;
    rhi::BlasBuilder builder;
    Disposer disposer;
    rhi::Texture defaultTexture;
    rhi::Sampler defaultSampler;
    SceneRevisions revisions;
    GpuSceneStatistics statistics;
    ResourceState blasState;  // frames of one scene also build the BLASes of the next, so it is kept here
};

}  // namespace raygraph
