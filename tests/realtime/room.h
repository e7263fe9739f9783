// A closed room with a body and a lamp, for tests of the real-time view.
#pragma once

#include "passes/trace.h"
#include "tests/support/scene_render.h"

namespace raygraph::testing {

inline scene::SceneData Room() {
    scene::SceneData data =
        SceneOf({BoxMesh(1.0f), BoxMesh(0.3f, 1)},
                {Lambert(glm::vec3(0.6f), glm::vec3(0.4f)), Lambert(glm::vec3(0.8f, 0.3f, 0.2f))},
                {glm::mat4x3(1.0f), Translation({0.3f, -0.5f, 0.1f})});
    scene::Light light;
    light.intensity = 0.3f;
    light.lightToWorld = Translation({-0.3f, 0.7f, 0.2f});
    data.lights.push_back(light);
    return data;
}

inline passes::TraceSettings RoomSettings(Extent2D extent, const glm::vec3& eye = {-0.8f, 0.1f, 0.3f}) {
    passes::TraceSettings settings = LookAt(eye, {1.0f, -0.5f, 0.0f}, 1.2f, 16);
    const float aspect = static_cast<float>(extent.width) / static_cast<float>(extent.height);
    settings.camera.right *= aspect;
    settings.extent = extent;
    return settings;
}

}  // namespace raygraph::testing
