// The cameras and lights of a glTF file: punctual lights, the environment (EXT_lights_image_based), and
// lights with measured profiles (EXT_lights_ies). Internal to renderer/scene.
#pragma once

#include <array>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/scene/gltf/accessors.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/model.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Returns the file's cameras, and its punctual lights. They are not placed yet.
std::vector<Camera> ReadCameras(GltfContext& context, const gltf::Model& model);
std::vector<Light> ReadLights(GltfContext& context, const gltf::Model& model);

// --- The environment: EXT_lights_image_based ---
// Only the first level of the cube map is read: the others and the irradiance are filtered from it for
// rasterizers.

inline constexpr const char* kImageLightExtension = "EXT_lights_image_based";

struct ImageLight {
    std::string name;
    uint32_t index = 0;  // into the file's list
    float intensity = 1.0f;
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};
    uint32_t size = 0;                // specularImageSize; 0: the file does not say.
    std::array<uint32_t, 6> faces{};  // images: +x, -x, +y, -y, +z, -z
};

// Returns the image light of a scene, if it has one. `scene` is kNone if the file has no scenes. Opens
// nothing.
std::optional<ImageLight> ReadImageLight(GltfContext& context, const gltf::Model& model, uint32_t scene);

// Returns the images that its faces are, each once.
std::vector<uint32_t> ImagesOf(const ImageLight& light);

// Resamples the faces; `images` are those of ImagesOf, decoded. Fails at a face that is not square, or of
// another size than the first.
EnvironmentLight MakeEnvironmentLight(GltfContext& context, const ImageLight& light,
                                      std::span<const ImageData> images);

// --- Lights with measured profiles: EXT_lights_ies ---

inline constexpr const char* kProfileExtension = "EXT_lights_ies";

struct ProfileSource {
    std::string name;
    uint32_t index = 0;              // into the file's list
    std::optional<std::string> uri;  // none: the buffer view
    uint32_t view = kNone;
};

Place ProfilePlace(size_t profile);

// Returns the profiles of the file that `profiles` lists, in that order. Opens nothing.
std::vector<ProfileSource> ReadProfileSources(const gltf::Model& model,
                                              const std::vector<uint32_t>& profiles);

// Returns the light of a node that has one: its name, color and factor.
Light ReadProfileLight(const gltf::Model& model, uint32_t node);

// Decodes the profiles. Fails at a file that cannot be read or is not of IES LM-63.
std::vector<LightProfile> DecodeProfiles(GltfContext& context, const std::vector<ProfileSource>& sources,
                                         GltfBuffers& buffers);

}  // namespace raygraph::scene
