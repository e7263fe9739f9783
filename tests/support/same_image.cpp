#include "tests/support/same_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raygraph::testing {

namespace {

constexpr uint32_t kBlock = 8;
constexpr double kSigmas = 4.0;
constexpr double kMinShare = 0.9975;
constexpr double kMaxError = 0.02;

// Sums over a block of the mean and of what makes its error.
struct BlockSums {
    glm::dvec3 mean{0.0};
    glm::dvec3 squaredError{0.0};  // error of the sum for independent errors
    glm::dvec3 error{0.0};         // error of the sum for shared errors
};

BlockSums SumsOf(const RenderedImage& image, uint32_t left, uint32_t top) {
    BlockSums sums;
    for (uint32_t y = top; y < std::min(top + kBlock, image.mean.extent.height); ++y)
        for (uint32_t x = left; x < std::min(left + kBlock, image.mean.extent.width); ++x) {
            sums.mean += glm::dvec3(image.mean.At(x, y));
            const glm::dvec3 squared = glm::dvec3(image.variance.At(x, y)) / double(image.sampleCount);
            sums.squaredError += squared;
            sums.error += glm::sqrt(squared);
        }
    return sums;
}

double ErrorOf(const BlockSums& sums, PixelErrors errors, int channel) {
    return errors == PixelErrors::Shared ? sums.error[channel] : std::sqrt(sums.squaredError[channel]);
}

}  // namespace

void ExpectSameImage(const RenderedImage& image, const RenderedImage& reference, const std::string& name,
                     PixelErrors errors) {
    ASSERT_EQ(image.mean.extent.width, reference.mean.extent.width) << name;
    ASSERT_EQ(image.mean.extent.height, reference.mean.extent.height) << name;
    size_t count = 0, passed = 0;
    BlockSums all, allOfReference;
    for (uint32_t top = 0; top < image.mean.extent.height; top += kBlock)
        for (uint32_t left = 0; left < image.mean.extent.width; left += kBlock) {
            const BlockSums a = SumsOf(image, left, top), b = SumsOf(reference, left, top);
            for (int channel = 0; channel < 3; ++channel) {
                const double sigma =
                    std::hypot(ErrorOf(a, errors, channel), ErrorOf(b, PixelErrors::Independent, channel));
                ++count;
                if (std::abs(a.mean[channel] - b.mean[channel]) <= kSigmas * sigma + 1e-6) ++passed;
            }
            all.mean += a.mean, all.squaredError += a.squaredError, all.error += a.error;
            allOfReference.mean += b.mean, allOfReference.squaredError += b.squaredError;
        }
    EXPECT_GE(double(passed), kMinShare * double(count))
        << name << ": of " << count << " blocks and channels";
    for (int channel = 0; channel < 3; ++channel) {
        const double error = ErrorOf(all, errors, channel);
        const double sigma = std::hypot(error, ErrorOf(allOfReference, PixelErrors::Independent, channel));
        EXPECT_LE(std::abs(all.mean[channel] - allOfReference.mean[channel]), kSigmas * sigma)
            << name << ", channel " << channel << ", sums over the image " << all.mean[channel] << " and "
            << allOfReference.mean[channel];
        if (errors == PixelErrors::Independent) {
            EXPECT_LT(error, kMaxError * all.mean[channel]) << name << " is too noisy to prove anything";
        }
    }
}

scene::SceneData RoomWithLamp() {
    scene::Material floor = Lambert(glm::vec3(0.7f, 0.5f, 0.3f));
    floor.roughnessFactor = 0.4f;
    floor.metallicFactor = 0.5f;
    scene::Material lamp = Lambert(glm::vec3(0.0f), glm::vec3(12.0f));
    lamp.alphaMode = scene::AlphaMode::Blend;
    lamp.baseColorFactor.w = 0.6f;
    lamp.emissiveTexture = {.texture = 0};
    scene::SceneData scene =
        SceneOf({QuadMesh(2.0f, 0), BoxMesh(0.3f, 1), QuadMesh(0.3f, 2)},
                {floor, Lambert(glm::vec3(0.6f, 0.7f, 0.8f)), lamp},
                {glm::mat4x3(1.0f), Translation({0.2f, -0.3f, 0.3f}), Translation({0.5f, 0.6f, 1.5f})});
    scene.images = {{.name = "four texels",
                     .width = 2,
                     .height = 2,
                     .rgba = {255, 40, 40, 255, 255, 255, 90, 255, 60, 90, 255, 255, 255, 255, 255, 255}}};
    scene.textures = {{.name = "four texels", .image = 0, .colorSpace = scene::ColorSpace::Srgb}};
    scene.meshes[2].primitives[0].uv0 = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    return scene;
}

image::ImageF EveningSky() {
    image::ImageF sky{.width = 32, .height = 16, .rgba = {}};
    for (uint32_t y = 0; y < sky.height; ++y)
        for (uint32_t x = 0; x < sky.width; ++x) {
            const bool isSun = y >= 4 && y < 7 && x >= 8 && x < 12;
            const float glow = y < 8 ? 0.05f + 0.3f * float(x) / 32.0f : 0.0f;
            sky.rgba.insert(sky.rgba.end(), {isSun ? 4.0f : glow, isSun ? 3.0f : 0.8f * glow, glow, 1.0f});
        }
    return sky;
}

passes::TraceSettings ViewOfRoom(uint32_t size) {
    passes::TraceSettings settings = LookAt({0.0f, -2.0f, 1.5f}, {0, 0, 0}, 0.9f, size);
    settings.scattering.brdf = BrdfModel::Gltf;
    return settings;
}

scene::SceneData EmissiveRoom() {
    return SceneOf({BoxMesh(1.0f), BoxMesh(0.4f, 1)},
                   {Lambert(glm::vec3(0.6f, 0.3f, 0.7f), glm::vec3(0.3f)), Lambert(glm::vec3(0.8f))},
                   {glm::mat4x3(1.0f), Translation({0.4f, -0.5f, 0.1f})});
}

passes::TraceSettings ViewOfEmissiveRoom(uint32_t size) {
    return LookAt({-0.8f, 0.1f, 0.3f}, {1.0f, -0.5f, 0.0f}, 1.2f, size);
}

}  // namespace raygraph::testing
