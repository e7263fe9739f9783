// The bridge of lights/lights.glsl over lights held on the host. Every test that uses lights.glsl in this
// program includes it through here: its functions are inline, and so one and the same everywhere.
#pragma once

#include <algorithm>
#include <vector>

#include "core/frame.glsl"
#include "lights/light_types.glsl"
#include "renderer/gpu_scene/lights/environment.h"
#include "renderer/gpu_scene/lights/light_table.h"
#include "tests/shading/random_values.h"

namespace raygraph::shading {

struct TestLights {
    LightScene scene{.groups = {{}},
                     .placements = {{}},
                     .instances = {{}},
                     .emission = {},
                     .punctual = {},
                     .radius = 1.0f};
    LightTable table;
    image::ImageF map{.width = 1, .height = 1, .rgba = {1.0f, 1.0f, 1.0f, 1.0f}};
    vec3 environmentTint{0.0f};
    EnvironmentTable environment = ConstantEnvironmentTable();

    void AddTriangle(vec3 p0, vec3 p1, vec3 p2, vec3 radiance, bool isDoubleSided = false) {
        const auto number = static_cast<uint32_t>(scene.emission.size());
        scene.emission.push_back(radiance);
        scene.groups[0].push_back({.p0 = p0,
                                   .p1 = p1,
                                   .p2 = p2,
                                   .primitive = number,
                                   .material = number,
                                   .isDoubleSided = isDoubleSided});
    }
    void AddPunctual(scene::LightType type, vec3 position, vec3 direction, vec3 intensity, float inner = 0.0f,
                     float outer = 0.7f) {
        scene::Light light;
        light.type = type;
        light.color = intensity;
        light.innerConeAngle = inner;
        light.outerConeAngle = outer;
        light.lightToWorld[2] = -direction;
        light.lightToWorld[3] = position;
        scene.punctual.push_back(light);
    }
    void SetEnvironment(image::ImageF image, vec3 tint, float rotation = 0.0f) {
        map = std::move(image);
        environment = BuildEnvironmentTable(map);
        environmentTint = tint;
        scene.environmentRotation = rotation;
    }
    void Build() {
        scene.NumberEmitters();
        scene.environmentRadiance = environmentTint * environment.meanRadiance;
        scene.environmentWidth = environment.width;
        scene.environmentHeight = environment.height;
        table = BuildLightTable(scene);
    }
};

inline thread_local TestLights testLights;

inline LightSetRecord LightSet() {
    return testLights.table.SetIn(testLights.scene);
}
inline LightRecord LightAt(uint light) {
    return testLights.table.LightAt(light);
}
inline LightNode LightNodeAt(uint node) {
    return testLights.table.NodeAt(node);
}
inline LightMeshRecord LightMeshAt(uint mesh) {
    return testLights.table.Meshes().at(mesh);
}
// Returns the transform of a placement whose record has the index of its instance.
inline mat4x3 LightPlacement(uint instance) {
    return testLights.scene.instances.at(instance).objectToWorld;
}
inline float LightProfileAt(uint word) {
    return testLights.scene.profiles.words.at(word);
}
inline AliasEntry LightAliasAt(uint slot) {
    return testLights.table.AliasAt(slot);
}
inline EnvironmentEntry EnvironmentEntryAt(uint slot) {
    return testLights.environment.entries.at(slot);
}
inline vec3 TriangleEmission(LightRecord light, vec2, vec3) {
    return testLights.scene.emission.at(light.primitive);
}

}  // namespace raygraph::shading

#include "core/equirect.glsl"

namespace raygraph::shading {

// The map as a sampler interpolates it: bilinear, repeated in u, clamped in v.
inline vec3 EnvironmentRadiance(vec3 direction) {
    const image::ImageF& map = testLights.map;
    const vec2 uv = EquirectFromDirection(direction, testLights.scene.environmentRotation);
    const float x = uv.x * float(map.width) - 0.5f;
    const float y = uv.y * float(map.height) - 0.5f;
    const vec2 share(x - floor(x), y - floor(y));
    const auto texel = [&](int dx, int dy) {
        const int width = int(map.width), height = int(map.height);
        const int column = (int(floor(x)) + dx + width) % width;
        const int row = std::clamp(int(floor(y)) + dy, 0, height - 1);
        const float* rgba = &map.rgba[4 * size_t(row * width + column)];
        return vec3(rgba[0], rgba[1], rgba[2]);
    };
    return testLights.environmentTint *
           mix(mix(texel(0, 0), texel(1, 0), share.x), mix(texel(0, 1), texel(1, 1), share.x), share.y);
}

}  // namespace raygraph::shading

#include "lights/lights.glsl"
