// The view of a scene: camera, environment, and how the picture is shown. The editor stores it beside the
// scene's file. Threads: plain values, and functions of files for any thread.
#pragma once

#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "editor/app/settings.h"
#include "renderer/gpu_scene/lights/own_light.h"

namespace raygraph::editor {

struct SceneView {
    std::string camera;                 // see scene::ChooseView; stored as session::CameraText
    float aperture = 0.0f;              // radius of the lens in meters; 0: a pinhole
    float focus = 0.0f;                 // in meters; 0: session::DefaultFocus
    std::filesystem::path environment;  // file of the environment map; "": none
    bool usesScene = true;              // see EnvironmentSettings, as the next three
    DefaultLight light = DefaultLight::Auto;
    glm::vec3 radiance{1.0f};
    float rotation = 0.0f;         // degrees about +y
    std::string backdrop = "map";  // session::ParseBackdrop
    bool hasGround = false;        // as `render --ground on`
    float exposureEv = Settings().show.tonemap.exposureEv;
    int whitePoint = Settings().whitePoint;  // kelvin
    TonemapOperator tonemap = Settings().show.tonemap.tonemapOperator;

    // Makes the light that of the scene alone, as in a new SceneView.
    void ResetEnvironment();
    bool operator==(const SceneView&) const = default;
};

// Changes the view that a scene would be opened with.
using ChangeView = std::function<void(SceneView&)>;

// Returns SCENE.view.json, where SCENE has its extension: box.glb.view.json.
std::filesystem::path ViewFileOf(const std::filesystem::path& scene);

// Returns the view that is stored beside the scene; none if there is no such file, or if it cannot be read:
// then `message` gets one line that says why. The scene may lack the camera.
std::optional<SceneView> ReadView(const std::filesystem::path& scene, std::string& message);
// Stores the view beside the scene; the map's name is relative to the scene's folder. Throws Error{Io}.
void WriteView(const std::filesystem::path& scene, const SceneView& view);

}  // namespace raygraph::editor
