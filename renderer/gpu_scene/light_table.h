// All lights of a scene as the tables of shaders/shared/light_records.h, made on the host.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/gpu_scene/light_groups.h"
#include "renderer/scene/scene_data.h"
#include "shaders/shared/light_records.h"

namespace raygraph {

// A triangle that emits if its material does. Object space.
struct Emitter {
    glm::vec3 p0{0.0f}, p1{0.0f}, p2{0.0f};
    uint32_t primitive = 0;  // its number in the BLAS
    uint32_t material = 0;
    bool isDoubleSided = false;   // double-sided: its back face emits, too
    glm::vec3 meanTexture{1.0f};  // of the emissive texture over the triangle; linear
    float error = 0.0f;           // of each coordinate, against those on the device
};

// One TLAS instance of a group with emitters. Its lights are numbered in the order of the emitters.
struct EmitterPlacement {
    uint32_t record = 0;    // index of its InstanceRecord
    uint32_t instance = 0;  // into LightScene::instances
    uint32_t group = 0;     // into LightScene::groups
    uint32_t firstLight = 0;
};

// The profiles of a scene's lights, as in the buffer of shaders/lights/light_profile.glsl.
struct ProfileTable {
    std::vector<float> words;
    std::vector<uint32_t> firstWords;  // by profile
    std::vector<double> means;         // intensity over all directions, candela
};
ProfileTable MakeProfileTable(std::span<const scene::LightProfile> profiles);

// Everything that the tables depend on.
struct LightScene {
    struct Instance {
        glm::mat4x3 objectToWorld{1.0f};
        bool isVisible = true;
    };
    std::vector<std::vector<Emitter>> groups;  // those without emitters are empty
    std::vector<EmitterPlacement> placements;
    std::vector<Instance> instances;
    std::vector<glm::vec3> emission;  // by material: radiance, before the texture
    std::vector<scene::Light> punctual;
    std::vector<bool> isPunctualHidden;  // empty: none is
    ProfileTable profiles;
    float radius = 0.0f;  // of what is visible, m: what infinite lights shine on

    LightGroups lightGroups;

    glm::vec3 environmentRadiance{0.0f};  // mean over the sphere
    float environmentRotation = 0.0f;
    uint32_t environmentWidth = 1, environmentHeight = 1;  // cells of its table

    // Numbers the lights of the placements from 0 on; returns how many there are.
    uint32_t NumberEmitters();
};

struct LightTable {
    std::vector<gpu::LightRecord> lights;
    std::vector<gpu::LightNode> nodes;
    std::vector<gpu::AliasEntry> alias;
    gpu::LightSetRecord set{};
    uint32_t emissiveTriangleCount = 0;  // those that shine
};

// Depends only on `scene`, in which the emitters are numbered. Triangles that are hidden, dark or without
// area keep their number and have probability 0. With the tree, infinite lights are chosen by their share of
// the power, but neither they nor the bounded lights with less than kMinLightShare, because it is not known
// how much of the infinite light reaches a point. O(n log n).
LightTable BuildLightTable(const LightScene& scene);

inline constexpr double kMinLightShare = 0.1;

// Brings the table of `scene` up to date after all of its transforms have been moved by the same translation:
// positions, offsets and boxes. Powers, probabilities and the tree's topology stay. O(n); takes no memory.
void PlaceLights(LightTable& table, const LightScene& scene);

}  // namespace raygraph
