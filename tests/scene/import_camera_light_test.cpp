#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/gtc/constants.hpp>

#include "tests/scene/gltf_document.h"

namespace raygraph::test::import_camera_light_test {
namespace {

using glm::vec3;
using ::testing::ElementsAre;

// A document with one camera on one node.
GltfDocument WithCamera(const Json& camera) {
    GltfDocument document;
    document.Add("cameras", camera);
    document.AddNode({{"camera", 0}, {"name", "stand"}, {"translation", {1, 2, 3}}});
    return document;
}

GltfDocument WithLight(const Json& light) {
    GltfDocument document;
    document.json["extensionsUsed"] = {"KHR_lights_punctual"};
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({light});
    document.AddNode({{"name", "pole"},
                      {"translation", {1, 2, 3}},
                      {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    return document;
}

TEST(Cameras, PerspectiveIsRead) {
    const scene::SceneData scene = Load(
        WithCamera({{"name", "eye"},
                    {"type", "perspective"},
                    {"perspective", {{"yfov", 0.5}, {"znear", 0.25}, {"zfar", 100}, {"aspectRatio", 1.5}}}}));
    ASSERT_EQ(scene.cameras.size(), 1u);
    const scene::Camera& camera = scene.cameras[0];
    EXPECT_EQ(camera.name, "eye");
    EXPECT_EQ(camera.node, 0u);
    EXPECT_EQ(camera.projection, scene::Projection::Perspective);
    EXPECT_EQ(camera.yFov, 0.5f);
    EXPECT_EQ(camera.zNear, 0.25f);
    EXPECT_EQ(camera.zFar, 100.0f);
    EXPECT_EQ(camera.aspectRatio, 1.5f);
    EXPECT_EQ(camera.cameraToWorld[3], vec3(1, 2, 3));
}

TEST(Cameras, OptionalPropertiesMayBeMissing) {
    const scene::SceneData scene =
        Load(WithCamera({{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.25}}}}));
    EXPECT_EQ(scene.cameras[0].name, "stand") << "the node's name where the camera has none";
    EXPECT_EQ(scene.cameras[0].zFar, 0.0f);
    EXPECT_EQ(scene.cameras[0].aspectRatio, 0.0f);
}

TEST(Cameras, OrthographicIsRead) {
    const scene::SceneData scene = Load(WithCamera(
        {{"type", "orthographic"}, {"orthographic", {{"xmag", 2}, {"ymag", 3}, {"znear", 0}, {"zfar", 9}}}}));
    EXPECT_EQ(scene.cameras[0].projection, scene::Projection::Orthographic);
    EXPECT_EQ(scene.cameras[0].xMag, 2.0f);
    EXPECT_EQ(scene.cameras[0].yMag, 3.0f);
    EXPECT_EQ(scene.cameras[0].zFar, 9.0f);
}

TEST(Cameras, AreListedByIndexOncePerPlace) {
    GltfDocument document =
        WithCamera({{"name", "a"}, {"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}});
    document.Add("cameras",
                 {{"name", "b"}, {"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}});
    document.json["nodes"][0]["camera"] = 1;
    document.AddNode({{"camera", 0}});
    document.AddNode({{"camera", 1}});
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.cameras.size(), 3u);
    EXPECT_EQ(scene.cameras[0].name, "a");
    EXPECT_EQ(scene.cameras[0].node, 1u);
    EXPECT_EQ(scene.cameras[1].node, 0u);
    EXPECT_EQ(scene.cameras[2].node, 2u);
}

TEST(Cameras, MalformedOnesAreRefused) {
    ExpectRefused(
        WithCamera({{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}),
        {{"/cameras/0/perspective",
          {{"znear", 1}},
          "cameras[0].perspective.yfov: is absent, must be a number"},
         {"/cameras/0/perspective/yfov", 0, "cameras[0].perspective.yfov: is 0, must be above 0"},
         {"/cameras/0/perspective/yfov", 4, "cameras[0].perspective.yfov: is 4, must be below pi"},
         {"/cameras/0/perspective/znear", 0, "cameras[0].perspective.znear: is 0, must be above 0"},
         {"/cameras/0/perspective", nullptr, "cameras[0].perspective: is null, must be an object"},
         {"/cameras/0/type", "fisheye",
          "cameras[0].type: is \"fisheye\", must be perspective or orthographic"},
         {"/cameras/0",
          {{"type", "orthographic"}, {"orthographic", {{"xmag", 0}, {"ymag", 1}, {"znear", 0}, {"zfar", 1}}}},
          "cameras[0].orthographic.xmag: is 0, must not be"},
         {"/cameras/0",
          {{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 2}, {"zfar", 1}}}},
          "cameras[0]: zfar (1.000000) must be greater than znear (2.000000)"}});
}

TEST(Cameras, FarPlaneOfAPerspectiveViewMayBeWrongBecauseNoneIsUsed) {
    const auto warnings = [](const Json& zFar) {
        const scene::SceneData scene = Load(WithCamera(
            {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}, {"zfar", zFar}}}}));
        EXPECT_EQ(scene.cameras.at(0).zFar, 0.0f);
        return scene.warnings;
    };
    EXPECT_THAT(warnings(0.5),
                ElementsAre("scene.gltf: cameras[0]: zfar (0.500000) must be greater than znear "
                            "(1.000000), taken as infinite, as in all perspective views"));
    EXPECT_THAT(warnings(0),
                ElementsAre("scene.gltf: cameras[0].perspective.zfar: is 0, must be above 0, taken "
                            "as infinite"));
}

TEST(Lights, PointLightIsRead) {
    const scene::SceneData scene =
        Load(WithLight({{"type", "point"}, {"color", {1, 0.5, 0.25}}, {"intensity", 40}, {"range", 7}}));
    ASSERT_EQ(scene.lights.size(), 1u);
    const scene::Light& light = scene.lights[0];
    EXPECT_EQ(light.type, scene::LightType::Point);
    EXPECT_EQ(light.name, "pole");
    EXPECT_EQ(light.color, vec3(1, 0.5f, 0.25f));
    EXPECT_EQ(light.intensity, 40.0f);
    EXPECT_EQ(light.range, 7.0f);
    EXPECT_EQ(light.lightToWorld[3], vec3(1, 2, 3));
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(Lights, DirectionalOnesAndConesAreRead) {
    EXPECT_EQ(Load(WithLight({{"type", "directional"}})).lights.at(0).type, scene::LightType::Directional);
    const scene::Light spot =
        Load(WithLight({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}}))
            .lights.at(0);
    EXPECT_EQ(spot.innerConeAngle, 0.25f);
    EXPECT_EQ(spot.outerConeAngle, 0.5f);
}

// three.js writes so: a light of which no penumbra was asked.
TEST(Lights, ConeWithoutASoftEdgeIsRead) {
    const scene::SceneData scene =
        Load(WithLight({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.5}, {"outerConeAngle", 0.5}}}}));
    const scene::Light& spot = scene.lights.at(0);
    EXPECT_EQ(spot.outerConeAngle, 0.5f);
    EXPECT_EQ(spot.innerConeAngle, std::nextafter(0.5f, 0.0f));
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_THAT(scene.warnings[0],
                ::testing::HasSubstr("spot.innerConeAngle: is 0.5, which outerConeAngle is too"));
}

TEST(Lights, RangeThatIsNoneIsInfinite) {
    for (const Json& range : {Json(0), Json(-1), Json(nullptr), Json(1e300)}) {
        const scene::SceneData scene = Load(WithLight({{"type", "point"}, {"range", range}}));
        EXPECT_EQ(scene.lights.at(0).range, 0.0f) << range;
        EXPECT_EQ(scene.warnings.size(), 1u) << range;
    }
}

TEST(Lights, DefaultsAreTheExtensions) {
    const scene::Light light = Load(WithLight({{"type", "spot"}, {"spot", Json::object()}})).lights.at(0);
    EXPECT_EQ(light.type, scene::LightType::Spot);
    EXPECT_EQ(light.color, vec3(1));
    EXPECT_EQ(light.intensity, 1.0f);
    EXPECT_EQ(light.range, 0.0f);
    EXPECT_EQ(light.innerConeAngle, 0.0f);
    EXPECT_EQ(light.outerConeAngle, glm::quarter_pi<float>());
}

TEST(Lights, MalformedOnesAreRefused) {
    const struct {
        Json light;
        const char* message;
    } rows[] = {
        {{{"type", "area"}}, ".type: is \"area\", must be directional, point or spot"},
        {{{"type", "point"}, {"intensity", -1}}, ".intensity: is -1, must not be negative"},
        {{{"type", "spot"}}, ".spot: is absent, must be an object"},
        {{{"type", "spot"}, {"spot", {{"innerConeAngle", 1}, {"outerConeAngle", 0.5}}}},
         ".spot: innerConeAngle must be below outerConeAngle"},
        {{{"type", "spot"}, {"spot", {{"innerConeAngle", 0}, {"outerConeAngle", 0}}}},
         ".spot: innerConeAngle must be below outerConeAngle"},
        {{{"type", "spot"}, {"spot", {{"outerConeAngle", 1.6}}}},
         ".spot.outerConeAngle: is 1.6, must be at most 1.570806"},
    };
    for (const auto& [light, message] : rows)
        EXPECT_EQ(LoadError(WithLight(light)),
                  std::string("scene.gltf: extensions.KHR_lights_punctual.lights[0]") + message);
    EXPECT_EQ(LoadError(WithLight({{"type", "spot"}, {"spot", {{"outerConeAngle", 1.570797}}}})), "loaded")
        << "pi/2, rounded up";
}

}  // namespace
}  // namespace raygraph::test::import_camera_light_test
