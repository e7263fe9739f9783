// A part of the scene on its way to the device: what PreparedScene made of it, and how far it has come. For
// gpu_scene_parts.cpp alone.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/mesh_upload.h"
#include "renderer/gpu_scene/scene_content.h"
#include "renderer/gpu_scene/texture_upload.h"

namespace raygraph {

struct PartUpload {
    std::unique_ptr<SceneContent> content;
    std::shared_ptr<AddedPart> added;
    rhi::Uploader* uploader = nullptr;
    std::optional<TextureUpload> textures;  // refers to the content
    std::vector<bool> isVisible;            // by node
    bool isStreamed = false;                // never waits for the device
    uint64_t bytes = 0;                     // of streams and texels
    uint64_t meshBytes = 0;                 // of streams, of the meshes that are there
    // The next ones that are to be there.
    uint32_t light = 0, instance = 0, mesh = 0, material = 0, texture = 0;
    std::optional<MeshUpload> meshUpload;  // of the mesh that is next

    uint64_t CopiedBytes() const {
        return meshBytes + (meshUpload ? meshUpload->CopiedBytes() : 0) +
               (textures ? textures->CopiedBytes() : 0);
    }
};

}  // namespace raygraph
