// Lights with measured profiles: EXT_lights_ies. Internal to renderer/scene.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderer/scene/gltf/buffers.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/model.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

inline constexpr const char* kProfileExtension = "EXT_lights_ies";

struct ProfileSource {
    std::string name;
    uint32_t index = 0;              // Into the file's list.
    std::optional<std::string> uri;  // None: the buffer view.
    uint32_t view = kNone;
};

Place ProfilePlace(size_t profile);

// Returns the profiles of the file that `profiles` lists, in that order. Opens nothing.
std::vector<ProfileSource> ReadProfileSources(const gltf::Model& model,
                                              const std::vector<uint32_t>& profiles);

// The light of a node that has one: its name, color and factor.
Light ReadProfileLight(const gltf::Model& model, uint32_t node);

// Decodes the profiles. Fails at a file that cannot be read or is not of IES LM-63.
std::vector<LightProfile> DecodeProfiles(GltfContext& context, const std::vector<ProfileSource>& sources,
                                         GltfBuffers& buffers);

}  // namespace raygraph::scene
