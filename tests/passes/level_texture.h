// A texture whose value is its level, for tests of what chooses levels.
#pragma once

#include <cmath>

#include "tests/support/scene_render.h"

namespace raygraph::testing {

inline constexpr uint32_t kLevelTexels = 64;  // a side
inline constexpr double kFinestLevel = 6.0;   // of levels 0 to 6, that of one texel
inline constexpr double kLevelStep = 20.0, kCoarsest = 128.0;

// Squares of all sizes on one another along u, each of kLevelStep; nothing changes along v. A level has lost
// those that are smaller than its texels: in the first column, where all of them are bright, it is darker
// than the next finer level by a step, and what is between levels is between the values.
inline scene::ImageData LevelImage() {
    scene::ImageData image{.name = "levels", .width = kLevelTexels, .height = kLevelTexels, .rgba = {}};
    for (uint32_t i = 0; i < kLevelTexels * kLevelTexels; ++i) {
        double value = kCoarsest;
        for (uint32_t bit = 0; bit < uint32_t(kFinestLevel); ++bit)
            value += (i % kLevelTexels >> bit & 1u) != 0 ? -kLevelStep : kLevelStep;
        const auto byte = static_cast<uint8_t>(value);
        image.rgba.insert(image.rgba.end(), {byte, byte, byte, 255});
    }
    return image;
}

inline double LevelOf(float radiance) {
    return kFinestLevel - (255.0 * double(radiance) - kCoarsest) / kLevelStep;
}

// Emission of LevelImage, in this set of texture coordinates; nothing is reflected.
inline scene::Material LevelMaterial(int texCoord = 0) {
    scene::Material material;
    material.baseColorFactor = {0.0f, 0.0f, 0.0f, 1.0f};
    material.metallicFactor = 1.0f;
    material.emissiveFactor = glm::vec3(1.0f);
    material.emissiveTexture = {.texture = 0, .texCoord = texCoord};
    material.isDoubleSided = true;
    return material;
}

// A square whose texture coordinates stay in the first column along x, and count `repeats` along y.
constexpr float kColumn = 1e-3f;  // of u
inline scene::Mesh LevelQuad(float halfSize, float repeats, uint32_t material = 0) {
    scene::Mesh mesh = QuadMesh(halfSize, material);
    const float u = 0.5f / float(kLevelTexels);
    for (const glm::vec3& position : mesh.primitives[0].positions)
        mesh.primitives[0].uv0.push_back(
            {u + 0.5f * kColumn * position.x / halfSize, 0.5f * repeats * position.y / halfSize});
    return mesh;
}

// Texels of level 0 in a square meter of it.
inline double LevelDensity(float halfSize, float repeats) {
    return double(kColumn) * double(repeats) * kLevelTexels * kLevelTexels /
           (4.0 * double(halfSize) * double(halfSize));
}

inline scene::SceneData LevelScene(std::vector<scene::Mesh> meshes, std::vector<scene::Material> materials,
                                   std::vector<glm::mat4x3> transforms = {}) {
    scene::SceneData scene = SceneOf(std::move(meshes), std::move(materials), std::move(transforms));
    scene.images = {LevelImage()};
    scene.textures = {
        {.name = "levels",
         .image = 0,
         .sampler = {.magFilter = scene::FilterMode::Nearest, .minFilter = scene::FilterMode::Nearest},
         .colorSpace = scene::ColorSpace::Linear}};
    return scene;
}

// Black and white squares, `squares` a side, one texel each.
inline scene::ImageData CheckerImage(uint32_t squares, uint8_t dark = 0, uint8_t bright = 255) {
    scene::ImageData image{.name = "checker", .width = squares, .height = squares, .rgba = {}};
    for (uint32_t i = 0; i < squares * squares; ++i) {
        const uint8_t byte = (i % squares + i / squares) % 2 != 0 ? bright : dark;
        image.rgba.insert(image.rgba.end(), {byte, byte, byte, byte});
    }
    return image;
}

}  // namespace raygraph::testing
