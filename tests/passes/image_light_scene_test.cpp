// The environment that a scene brings along, from the text of a glTF file to what is seen.
#include "tests/scene/gltf_document.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::image_light_scene_test {

namespace {

using test::GltfDocument;
using test::Json;

// Red, green, blue, and the same at a fifth of the alpha: five times as bright. Above the triangle of the
// scene, which is small and far from the rays.
GltfDocument SixColors() {
    constexpr std::array<std::array<uint8_t, 4>, 6> kColors{{{255, 0, 0, 255},
                                                             {0, 255, 0, 255},
                                                             {0, 0, 255, 255},
                                                             {255, 0, 0, 51},
                                                             {0, 255, 0, 51},
                                                             {0, 0, 255, 51}}};
    GltfDocument document;
    document.AddTriangle();
    document.json["nodes"][0]["scale"] = {0.01, 0.01, 0.01};
    for (const auto& color : kColors)
        document.Add("images", {{"uri", test::DataUri(test::MakePng(1, 1, color))}});
    document.json["extensions"]["EXT_lights_image_based"]["lights"] =
        Json::array({{{"intensity", 0.5},
                      {"specularImageSize", 1},
                      {"specularImages", Json::array({{0, 1, 2, 3, 4, 5}})}}});
    document.json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;
    return document;
}

class ImageLightScene : public VulkanTest {
  protected:
    glm::vec3 Towards(const glm::vec3& direction) {
        const glm::vec3 eye(0.0f, 5.0f, 0.0f),
            up = direction.y == 0.0f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
        passes::TraceSettings settings;
        settings.extent = {1, 1};
        settings.camera = ToRecord(scene::CameraView::LookAt(eye, eye + direction, up));
        return render.TraceOnce(settings).At(0, 0);
    }
    void ExpectTowards(const glm::vec3& direction, const glm::vec3& radiance) {
        EXPECT_LT(glm::distance(Towards(direction), radiance), 1e-5f)
            << direction.x << ' ' << direction.y << ' ' << direction.z;
    }
    SceneRender render{Device()};
};

}  // namespace

TEST_F(ImageLightScene, LightsTheSceneFromEachSideAsItsFileSays) {
    render.scene.SetScene(test::Load(SixColors()));
    ExpectTowards({1, 0, 0}, {0.5f, 0, 0});
    ExpectTowards({-1, 0, 0}, {0, 0.5f, 0});
    ExpectTowards({0, 1, 0}, {0, 0, 0.5f});
    ExpectTowards({0, -1, 0.1f}, {2.5f, 0, 0});
    ExpectTowards({0, 0, 1}, {0, 2.5f, 0});
    ExpectTowards({0, 0, -1}, {0, 0, 2.5f});
    EXPECT_EQ(render.scene.Statistics().lightCount, 1u) << "it is sampled";
    EXPECT_TRUE(render.scene.Environment().usesScene);
}

TEST_F(ImageLightScene, GivesWayToWhatAHostSetsAndToTheNextScene) {
    GpuScene& scene = render.scene;
    scene.SetScene(test::Load(SixColors()));
    const auto black = glm::vec3(0.0f), red = glm::vec3(0.5f, 0, 0);
    ExpectTowards({1, 0, 0}, red);
    // Turned by a quarter, +x is at -z; tinted
    scene.SetEnvironment({.radiance = {2, 1, 1}, .rotation = 1.5707963f, .usesScene = true});
    ExpectTowards({0, 0, -1}, 2.0f * red);
    scene.SetEnvironment({.radiance = {1, 2, 3}});
    ExpectTowards({1, 0, 0}, {1, 2, 3});
    scene.SetEnvironment({});
    ExpectTowards({1, 0, 0}, black);
    EXPECT_EQ(scene.Statistics().lightCount, 0u);
    const EnvironmentSettings own{
        .radiance = glm::vec3(1.0f), .usesScene = true, .defaultLight = DefaultLight::None};
    scene.SetEnvironment(own);
    const uint64_t version = scene.Revisions().environment;
    scene.SetEnvironmentMap({1, 1, {4, 5, 6, 1}});
    EXPECT_GT(scene.Revisions().environment, version);
    ExpectTowards({1, 0, 0}, {4, 5, 6});
    scene.SetScene(test::Load(SixColors()));
    ExpectTowards({1, 0, 0}, {4, 5, 6});
    scene.RemoveEnvironmentMap();
    ExpectTowards({1, 0, 0}, red);
    GltfDocument plain = SixColors();
    plain.json["scenes"][0].erase("extensions");
    scene.SetScene(test::Load(plain));
    ExpectTowards({1, 0, 0}, black);
    EXPECT_EQ(scene.Statistics().lightCount, 0u);
    // Values that no file has are refused, and the old scene stays
    scene.SetScene(test::Load(SixColors()));
    scene::SceneData bad = test::Load(SixColors());
    bad.environment.map.rgba[7] = -1.0f;
    EXPECT_THROW(scene.SetScene(std::move(bad)), Error);
    ExpectTowards({1, 0, 0}, red);
}

}  // namespace raygraph::testing::image_light_scene_test
