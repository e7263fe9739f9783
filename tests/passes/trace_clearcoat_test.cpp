// The clear coat on the device: the light that it reflects and keeps, and its normal map.
#include <cmath>

#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_clearcoat_test {

using passes::TraceSettings;

namespace {

class TraceClearcoat : public VulkanTest {
  protected:
    static TraceSettings Gltf(const glm::vec3& eye, const glm::vec3& target, float yFov, uint32_t size) {
        TraceSettings settings = LookAt(eye, target, yFov, size);
        settings.scattering.brdf = BrdfModel::Gltf;
        return settings;
    }

    SceneRender render{Device()};
};

// A camera far off that sees the middle of a quad of the xy plane at an angle whose cosine is given.
glm::vec3 EyeAt(float cosTheta) {
    return 100.0f * glm::vec3(std::sqrt(1.0f - cosTheta * cosTheta), 0.0f, cosTheta);
}

// Upright: its x axis is the world's z.
glm::mat4x3 Upright(const glm::vec3& center) {
    return {glm::vec3(0, 0, 1), glm::vec3(0, 1, 0), glm::vec3(-1, 0, 0), center};
}

// A coat on a black body reflects by Fresnel, on a lamp it keeps that from getting out: seen at two angles, and
// as light on a wall, where sampling the lamp and finding it must agree.
TEST_F(TraceClearcoat, Trace_CoatReflectsAndDimsWhatIsBelow) {
    scene::Material coated;
    coated.baseColorFactor = {0.0f, 0.0f, 0.0f, 1.0f};
    coated.specularFactor = 0.0f;
    coated.metallicFactor = 0.0f;
    coated.clearcoatFactor = 0.8f;
    coated.isDoubleSided = true;
    scene::Material lamp = coated;
    lamp.emissiveFactor = glm::vec3(2.0f);
    for (const float cosTheta : {0.9f, 0.3f}) {
        const TraceSettings settings = Gltf(EyeAt(cosTheta), {0, 0, 0}, 1e-4f, 8);
        const double reflected = 0.8 * (0.04 + 0.96 * std::pow(1.0 - cosTheta, 5.0));
        const auto seen = [&](const scene::Material& material) {
            render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {material}));
            render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
            return render.TraceOnce(settings).Mean().y;
        };
        EXPECT_NEAR(seen(coated), reflected, 2e-3) << cosTheta;
        EXPECT_NEAR(seen(lamp), reflected + 2.0 * (1.0 - reflected), 4e-3) << cosTheta;
    }
    // The lamp stands upright beside the wall that is seen
    scene::Material wall = coated;
    wall.clearcoatFactor = 0.0f;
    wall.baseColorFactor = glm::vec4(1.0f);
    render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), QuadMesh(1.0f, 1)}, {wall, lamp},
                                  {glm::mat4x3(1.0f), Upright({1.0f, 0.0f, 1.0f})}));
    render.scene.SetEnvironment({.radiance = glm::vec3(0.0f)});
    TraceSettings settings = Gltf({-3.0f, 0.0f, 2.0f}, {0.5f, 0, 0}, 0.1f, 16);
    settings.biases.maxDepth = 1;
    const RenderedImage sampled = render.Render(settings, 256);
    settings.lights.isOn = false;
    const RenderedImage found = render.Render(settings, 512);
    const double error = std::hypot(sampled.StandardErrorOfMean().y, found.StandardErrorOfMean().y);
    EXPECT_LT(error, 0.01 * found.mean.Mean().y);
    EXPECT_NEAR(sampled.mean.Mean().y, found.mean.Mean().y, 4.0 * error);
    EXPECT_GT(found.mean.Mean().y, 0.05);
}

// The coat has the normal map that is named for it, and not that of the material below. From above, its mirror
// shows a lamp that stands at the side only if it is tilted.
TEST_F(TraceClearcoat, Trace_CoatHasANormalMapOfItsOwn) {
    const auto seenWith = [&](scene::TextureRef scene::Material::*map) {
        scene::Material black;
        black.baseColorFactor = {0.0f, 0.0f, 0.0f, 1.0f};
        black.specularFactor = 0.0f;
        black.clearcoatFactor = 1.0f;
        if (map) black.*map = {.texture = 0};
        scene::Mesh mirror = QuadMesh(1.0f, 0);
        mirror.primitives[0].uv0.assign(4, {0.5f, 0.5f});
        mirror.primitives[0].tangents.assign(4, {1.0f, 0.0f, 0.0f, 1.0f});
        scene::SceneData scene =
            SceneOf({mirror, QuadMesh(1.0f, 1)}, {black, Lambert(glm::vec3(0.0f), glm::vec3(10.0f))},
                    {glm::mat4x3(1.0f), Upright({4.33f, 0.0f, 2.5f})});
        // Tilted by 30 degrees towards +x
        scene.images = {{.name = "tilt", .width = 1, .height = 1, .rgba = {191, 128, 238, 255}}};
        scene.textures = {{.name = "tilt", .image = 0}};
        render.scene.SetScene(std::move(scene));
        return render.TraceOnce(Gltf({0, 0, 100.0f}, {0, 0, 0}, 1e-4f, 4)).Mean().x;
    };
    EXPECT_NEAR(seenWith(nullptr), 0.0, 1e-3);
    EXPECT_NEAR(seenWith(&scene::Material::normalTexture), 0.0, 1e-3) << "the material's own";
    EXPECT_NEAR(seenWith(&scene::Material::clearcoatNormalTexture), 0.4, 0.02);
}

// Where the shadow terminator's bias bends a surface, its coat reflects into what is then outside: here a normal
// map would mirror the view below the bent surface, though above the triangle.
TEST_F(TraceClearcoat, Trace_CoatFollowsASurfaceThatTheShadowTerminatorBends) {
    scene::Material black;
    black.baseColorFactor = {0.0f, 0.0f, 0.0f, 1.0f};
    black.specularFactor = 0.0f;
    black.metallicFactor = 0.0f;
    black.clearcoatFactor = 1.0f;
    black.clearcoatNormalTexture = {.texture = 0};
    scene::Mesh mirror = QuadMesh(1.0f, 0);
    scene::Primitive& quad = mirror.primitives[0];
    quad.uv0.assign(4, {0.5f, 0.5f});
    // 20 degrees towards +x, and by the map 60 degrees back
    quad.normals.assign(4, {0.34202f, 0.0f, 0.93969f});
    quad.tangents.assign(4, {0.93969f, 0.0f, -0.34202f, 1.0f});
    scene::SceneData scene = SceneOf({mirror}, {black});
    scene.images = {{.name = "tilt", .width = 1, .height = 1, .rgba = {17, 128, 191, 255}}};
    scene.textures = {{.name = "tilt", .image = 0}};
    render.scene.SetScene(std::move(scene));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings settings = Gltf({0, 0, 100.0f}, {0, 0, 0}, 1e-4f, 4);
    settings.biases.shadowTerminator = true;
    EXPECT_NEAR(render.TraceOnce(settings).Mean().x, 0.04, 2e-3);
}

}  // namespace
}  // namespace raygraph::testing::trace_clearcoat_test
