// materials, textures, samplers, images. Internal to renderer/scene.
#pragma once

#include "renderer/scene/gltf/accessors.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/images.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Fills scene.materials and scene.textures; returns what each entry of scene.images will be. Texture::image
// already indexes that list.
std::vector<ImageChoice> ReadMaterials(GltfContext& context, const gltf::Model& model, SceneData& scene);

}  // namespace raygraph::scene
