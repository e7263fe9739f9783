// Punctual lights, with a profile or without, as records. Threads: pure functions.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/scene/model/scene_data.h"
#include "shaders/shared/light_records.h"

namespace raygraph {

// The profiles of a scene's lights in the layout of shaders/lights/light_profile.glsl.
struct ProfileTable {
    std::vector<float> words;
    std::vector<uint32_t> firstWords;  // by profile
    std::vector<double> means;         // mean intensity over all directions, candela
};
ProfileTable MakeProfileTable(std::span<const scene::LightProfile> profiles);

// A light and its power (luminance, W).
struct PoweredLight {
    gpu::LightRecord record;
    double power = 0.0;
};
// `sceneRadius`, in m, bounds the extent that infinite lights shine on. A hidden light has power 0.
PoweredLight PunctualLight(const scene::Light& light, bool isHidden, const ProfileTable& profiles,
                           double sceneRadius);

}  // namespace raygraph
