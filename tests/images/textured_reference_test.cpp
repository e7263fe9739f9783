// Compares a textured scene with the picture that support/direct_light_reference computes independently.
#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/direct_light_reference.h"
#include "tests/support/image_compare.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::textured_reference_test {

namespace {

using scene::AlphaMode;
using scene::ColorSpace;
using scene::FilterMode;
using scene::WrapMode;

constexpr std::array kModes{WrapMode::Repeat, WrapMode::MirroredRepeat, WrapMode::ClampToEdge};

// Makes texels with values of all kinds; they are the same in every run.
scene::ImageData Texels(uint32_t width, uint32_t height, uint32_t step) {
    scene::ImageData image{.name = "texels", .width = width, .height = height, .rgba = {}};
    for (uint32_t i = 0; i < 4 * width * height; ++i)
        image.rgba.push_back(static_cast<uint8_t>((17 + step * (i + i / 4)) % 256));
    return image;
}

int32_t AddTexture(scene::SceneData& scene, uint32_t image, WrapMode wrapU, WrapMode wrapV,
                   FilterMode filter) {
    scene.textures.push_back(
        {.name = "texture",
         .image = image,
         .sampler = {.wrapU = wrapU, .wrapV = wrapV, .magFilter = filter, .minFilter = filter},
         .colorSpace = ColorSpace::Srgb});
    return static_cast<int32_t>(scene.textures.size() - 1);
}

std::vector<glm::vec2> Coordinates(const glm::vec2& upperLeft, const glm::vec2& lowerRight) {
    return {{upperLeft.x, lowerRight.y}, lowerRight, {lowerRight.x, upperLeft.y}, upperLeft};
}

// Makes nine tiles, one for each pair of wrap modes: base color by one set of coordinates, emission by the
// other.
void AddWall(scene::SceneData& scene) {
    for (uint32_t tile = 0; tile < 9; ++tile) {
        const WrapMode wrapU = kModes[tile % 3], wrapV = kModes[tile / 3];
        const int32_t set = static_cast<int32_t>(tile % 2);
        scene::Material material = Lambert({0.9f, 0.8f, 0.95f}, {0.3f, 0.2f, 0.4f});
        material.isDoubleSided = false;
        material.baseColorTexture = {.texture = AddTexture(scene, 0, wrapU, wrapV, FilterMode::Linear),
                                     .texCoord = set};
        material.emissiveTexture = {.texture = AddTexture(scene, 1, wrapV, wrapU, FilterMode::Nearest),
                                    .texCoord = 1 - set};
        material.emissiveStrength = 1.5f;
        scene::Mesh mesh = QuadMesh(0.5f, static_cast<uint32_t>(scene.materials.size()));
        const auto forColor = Coordinates({-0.7f, -1.2f}, {1.9f, 1.6f});
        const auto forEmission = Coordinates({1.45f, -0.35f}, {-0.55f, 1.35f});
        mesh.primitives[0].uv0 = set == 0 ? forColor : forEmission;
        mesh.primitives[0].uv1 = set == 1 ? forColor : forEmission;
        scene.instances.push_back(
            {.mesh = static_cast<uint32_t>(scene.meshes.size()),
             .objectToWorld = Translation({float(tile % 3) - 1.0f, 1.0f - float(tile / 3), 0})});
        scene.meshes.push_back(mesh);
        scene.materials.push_back(material);
    }
}

// Makes four strips of one mesh before the wall: two of MASK, one of BLEND, and one whose alpha is ignored.
void AddStrips(scene::SceneData& scene) {
    scene::Mesh mesh;
    for (const AlphaMode mode : {AlphaMode::Mask, AlphaMode::Blend, AlphaMode::Mask, AlphaMode::Opaque}) {
        const uint32_t strip = static_cast<uint32_t>(mesh.primitives.size());
        scene::Material material = Lambert({0.7f, 0.9f, 0.8f});
        material.baseColorFactor.a = 0.8f;
        material.alphaMode = mode;
        material.alphaCutoff = 0.35f;
        material.baseColorTexture = {
            .texture = AddTexture(scene, 2, kModes[strip % 3], kModes[(strip + 1) % 3],
                                  strip == 1 ? FilterMode::Nearest : FilterMode::Linear),
            .texCoord = static_cast<int32_t>(strip % 2)};
        scene::Primitive primitive =
            QuadMesh(0.5f, static_cast<uint32_t>(scene.materials.size())).primitives[0];
        for (glm::vec3& position : primitive.positions)
            position = glm::vec3(0.5f * position.x + 0.75f * float(strip) - 1.1f, 2.2f * position.y, 0.5f);
        primitive.bounds = {};
        for (const glm::vec3& position : primitive.positions) primitive.bounds.Extend(position);
        primitive.uv0 = Coordinates({-0.3f + 0.3f * float(strip), -0.6f}, {0.8f, 2.1f});
        primitive.uv1 = Coordinates({0.9f, 1.7f - 0.3f * float(strip)}, {-0.4f, -0.8f});
        if (mode == AlphaMode::Blend)
            primitive.colors = {{1.0f, 0.5f, 0.5f, 0.9f},
                                {0.5f, 1.0f, 0.5f, 0.5f},
                                glm::vec4(1.0f),
                                {0.2f, 0.4f, 1.0f, 0.7f}};
        mesh.primitives.push_back(primitive);
        scene.materials.push_back(material);
    }
    // Mirrored and rotated a little about +y
    glm::mat4x3 placement(1.0f);
    placement[0] = {-0.98f, 0.0f, 0.2f};
    placement[2] = {0.2f, 0.0f, 0.98f};
    scene.instances.push_back(
        {.mesh = static_cast<uint32_t>(scene.meshes.size()), .objectToWorld = placement});
    scene.meshes.push_back(mesh);
}

scene::SceneData TexturedScene() {
    scene::SceneData scene;
    scene.images = {Texels(4, 3, 83), Texels(3, 5, 131), Texels(5, 4, 59)};
    AddWall(scene);
    AddStrips(scene);
    scene::Light sun;
    sun.type = scene::LightType::Directional;
    sun.color = {1.0f, 0.9f, 0.8f};
    sun.intensity = 3.0f;
    // Light goes along the node's -z
    sun.lightToWorld[2] = glm::normalize(glm::vec3(0.35f, 0.5f, 0.8f));
    sun.lightToWorld[0] = glm::normalize(glm::cross(glm::vec3(0, 1, 0), sun.lightToWorld[2]));
    sun.lightToWorld[1] = glm::cross(sun.lightToWorld[2], sun.lightToWorld[0]);
    scene.lights.push_back(sun);
    return scene;
}

class TexturedReference : public VulkanTest {
  protected:
    SceneRender render{Device()};
};

test::PlaneView Channel(const std::vector<glm::vec4>& values, uint32_t size, int channel) {
    return {size, size, std::span(&values[0].x, 4 * values.size()).subspan(static_cast<size_t>(channel)), 4};
}

// Returns the variance of each pixel's mean. Few samples or none see what lies at the edge of a pixel, so it
// is the largest of the pixel and its neighbors.
std::vector<glm::vec4> VarianceOfMean(const RenderedImage& image) {
    const int width = static_cast<int>(image.mean.extent.width);
    const int height = static_cast<int>(image.mean.extent.height);
    std::vector<glm::vec4> result;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            glm::vec4 largest(0.0f);
            for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v)
                for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u)
                    largest = glm::max(largest,
                                       image.variance.At(static_cast<uint32_t>(u), static_cast<uint32_t>(v)));
            result.push_back(largest / float(image.sampleCount));
        }
    return result;
}

}  // namespace

TEST_F(TexturedReference, Trace_LambertUnderASunIsWhatTheReferenceProgramSays) {
    constexpr uint32_t kSize = 48, kSamples = 64;
    scene::SceneData scene = TexturedScene();
    scene::CameraView camera =
        scene::CameraView::LookAt({0.4f, -0.3f, 4.0f}, {0.05f, 0.02f, 0.0f}, {0, 1, 0});
    camera.yFov = 0.75f;
    const std::vector<glm::dvec4> exact = test::DirectLightReference(scene).Picture(camera, kSize, kSize, 16);
    const std::vector<glm::vec4> reference(exact.begin(), exact.end());

    passes::TraceSettings settings;
    settings.extent = {kSize, kSize};
    settings.camera = ToRecord(camera);
    settings.scattering.brdf = BrdfModel::Lambert;
    settings.biases.maxDepth = 1;  // light that was scattered once
    render.scene.SetScene(std::move(scene));
    const RenderedImage image = render.Render(settings, kSamples);

    const std::vector<glm::vec4> varianceOfMean = VarianceOfMean(image);
    for (int channel = 0; channel < 3; ++channel) {
        const test::PlaneView mean = Channel(image.mean.values, kSize, channel);
        const test::PlaneView expected = Channel(reference, kSize, channel);
        // The device's sRGB curve and weights of filters are good to about 0.5 / 255
        const test::ZTestResult result =
            test::ZTest({mean, Channel(varianceOfMean, kSize, channel)}, {expected, {}},
                        {.relativeFloor = 1e-3, .absoluteFloor = 5e-4});
        EXPECT_FALSE(result.HasFailures())
            << "channel " << channel << ": " << result.failedCount << " pixels, the worst at "
            << result.greatestPixel % kSize << ", " << result.greatestPixel / kSize << ": "
            << mean.At(result.greatestPixel) << " for " << expected.At(result.greatestPixel);
        EXPECT_NEAR(test::Mean(mean), test::Mean(expected), 0.003 * test::Mean(expected));
    }
    // Coverage
    const test::PlaneView alpha = Channel(image.mean.values, kSize, 3),
                          covered = Channel(reference, kSize, 3);
    EXPECT_LT(test::MaxAbsDifference(alpha, covered), 0.25);
    EXPECT_NEAR(test::Mean(alpha), test::Mean(covered), 0.003);
}

}  // namespace raygraph::testing::textured_reference_test
