// EditedScene is a scene that a binding of another language loads or makes of arrays, and edits between
// pictures. The Python package and the C interface share it; hosts in C++ have scene::SceneData itself.
// Threads: one at a time for each scene.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "base/api.h"
#include "editor/session/settings/picture_settings.h"
#include "editor/session/settings/scene_input.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::session {

struct RAYGRAPH_API EditedScene {
    SceneInput input;  // with its animations, in the rest pose
    // Set by edits: hash, statistics and world transforms are of an earlier state.
    bool isEdited = false;

    scene::SceneData& Edit() {
        isEdited = true;
        return input.data;
    }
    // Computes what follows from edits. Throws as scene::Check does.
    void Update();
    // Returns what a picture at a time of the animations takes, or without one of the rest pose.
    SceneInput InputFor(bool isAnimated) const;
};

// Returns the settings of a picture of this scene, or of its reference; a ground hides the environment as in
// `raygraph render` (HideBehindGround). Throws as SettingsFrom does.
RAYGRAPH_API PictureSettings SettingsFor(const EditedScene& scene, SettingTexts texts);

// --- Matrices of 16 numbers, column by column as in glTF: the translation is in 12 to 14 ---

// Throws Error{Usage} if the last row is not 0, 0, 0, 1, and if a number is not finite.
RAYGRAPH_API scene::PlacedTransform TransformOf(std::span<const double, 16> matrix);
RAYGRAPH_API std::array<double, 16> MatrixOf(const scene::PlacedTransform& placed);

// --- Objects, added at the ends of their lists; the functions return the index ---

RAYGRAPH_API uint32_t AddNode(EditedScene& scene, scene::Node node);
RAYGRAPH_API uint32_t AddMaterial(EditedScene& scene, std::string name);
// Add a light or a camera of the default values, placed by a node.
RAYGRAPH_API uint32_t AddLight(EditedScene& scene, uint32_t node, scene::LightType type, std::string name);
RAYGRAPH_API uint32_t AddCamera(EditedScene& scene, uint32_t node, scene::Projection projection,
                                std::string name);
// Adds a mesh of one primitive, which is complete.
RAYGRAPH_API uint32_t AddMesh(EditedScene& scene, scene::Primitive primitive, std::string name);
// Adds the instance of a mesh that a node without one places.
RAYGRAPH_API uint32_t AddInstance(EditedScene& scene, uint32_t node, uint32_t mesh);

// Completes a primitive of triangles whose positions, indices and optional streams are given: normals are
// made unit length, or those of the triangles are made, whose vertices are split then. Throws Error{Usage}
// that names the stream, such as "uvs: there are 3, and 4 positions", for one of another length, numbers that
// are not finite, indices out of range, no triangle, normals without a direction, and tangents without
// normals.
RAYGRAPH_API void CompleteTriangles(scene::Primitive& primitive);

// Makes an image the texture of a field of a material. It takes the place of the texture before it, if that
// has no other user. An image without texels removes the texture.
RAYGRAPH_API void SetTexture(EditedScene& scene, uint32_t material, const scene::TextureField& field,
                             scene::ImageData image);

// Sets a field of a camera. Throws Error{Usage} that calls it `name` if scene::Check would refuse the camera.
RAYGRAPH_API void SetCameraField(EditedScene& scene, uint32_t camera, float scene::Camera::*member,
                                 float value, const std::string& name);

// Lights the scene by a map of the host. Throws Error{Usage} for texels that are no radiance.
RAYGRAPH_API void SetEnvironmentMap(EditedScene& scene, image::ImageF map, std::string name);
RAYGRAPH_API void LoadEnvironmentMap(EditedScene& scene, const std::filesystem::path& path, const Log& log);

}  // namespace raygraph::session
