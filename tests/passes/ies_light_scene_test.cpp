// Lights with profiles, from the text of a glTF file to what is seen.
#include <cmath>
#include <numbers>

#include "passes/raster.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/ies_text.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::ies_light_scene_test {

namespace {

using test::GltfDocument;
using test::IesText;
using test::Json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr glm::vec3 kPlace(0.25f, 2.0f, -0.5f);  // of the light, above the floor

// A white floor at y = 0, and the light of `file` above it, whose -z is down and whose +x is the world's +z.
GltfDocument Floor(const IesText& file) {
    GltfDocument document;
    const size_t positions = document.AddAccessor<float>({-9, 0, 9, 9, 0, 9, 9, 0, -9, -9, 0, -9}, 3);
    const size_t indices = document.AddAccessor<uint16_t>({0, 1, 2, 0, 2, 3}, 1);
    document.AddNode({{"mesh", document.AddMesh({{"attributes", {{"POSITION", positions}}},
                                                 {"indices", indices},
                                                 {"material", document.AddMaterial(Json::object())}})}});
    document.json["extensions"]["EXT_lights_ies"]["lights"] =
        Json::array({{{"uri", test::DataUri(test::ToBytes(file.Text()))}}});
    document.AddNode(
        {{"translation", {kPlace.x, kPlace.y, kPlace.z}},
         {"rotation", {-0.5, -0.5, -0.5, 0.5}},
         {"scale", {2, 0.5, 3}},
         {"extensions", {{"EXT_lights_ies", {{"light", 0}, {"multiplier", 2}, {"color", {1, 0.5, 0.25}}}}}}});
    return document;
}

class IesLightScene : public VulkanTest {
  protected:
    static passes::TraceSettings LookDownAt(const glm::vec3& point) {
        passes::TraceSettings settings;
        settings.extent = {1, 1};
        settings.camera = ToRecord(scene::CameraView::LookAt(point + glm::vec3(0, 1, 0), point, {1, 0, 0}));
        settings.camera.right *= 1e-4f;
        settings.camera.up *= 1e-4f;
        settings.scattering.brdf = BrdfModel::Lambert;
        return settings;
    }
    glm::vec3 Traced(const glm::vec3& point) { return render.TraceOnce(LookDownAt(point)).At(0, 0); }
    glm::vec3 Drawn(const glm::vec3& point, passes::RasterShadows shadows) {
        const passes::TraceSettings settings = LookDownAt(point);
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, settings, passes::FilmPosition::Center);
        const Readback drawn = render.renderer.ReadBack(
            passes::RasterShade(render.renderer, ids, settings, seen, environment, {.shadows = shadows}));
        render.renderer.Execute();
        return ToFloatImage(drawn).At(0, 0);
    }
    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

// The radiance of a white floor under I candela: I cos / (pi d^2).
glm::vec3 Expected(const glm::vec3& point, const std::function<double(const glm::dvec3&)>& intensity) {
    const glm::dvec3 way = glm::dvec3(point) - glm::dvec3(kPlace);
    const double distance = glm::length(way);
    const glm::dvec3 own(way.z / distance, way.x / distance, way.y / distance);  // in the light's axes
    const double radiance = intensity(own) * (-way.y / distance) / (std::numbers::pi * distance * distance);
    return glm::vec3(2.0, 1.0, 0.5) * float(radiance);
}

void ExpectNear(const glm::vec3& seen, const glm::vec3& expected, const char* what) {
    EXPECT_LT(glm::distance(seen, expected), 1e-3f * glm::length(expected) + 1e-6f)
        << what << ": " << seen.x << ' ' << seen.y << ' ' << seen.z << " for " << expected.x << ' '
        << expected.y << ' ' << expected.z;
}

constexpr std::array<glm::vec3, 5> kPoints{
    {{0.5f, 0, -0.75f}, {1.0f, 0, -0.5f}, {0.3f, 0, 1.5f}, {-1.5f, 0, -2.0f}, {4.0f, 0, 1.0f}}};

}  // namespace

TEST_F(IesLightScene, IrradianceOnAPlaneIsThatOfTheProfile) {
    const auto c = [](double v, double h) { return (180.0 - v) * (30.0 + h); };
    render.scene.SetScene(
        test::Load(Floor({.vertical = {0, 180}, .horizontal = {0, 90, 180}, .candela = c})));
    const auto intensityC = [&](const glm::dvec3& d) {
        return c(std::acos(-d.z) / kDegree, std::atan2(std::abs(d.y), d.x) / kDegree);
    };
    for (const glm::vec3& point : kPoints) {
        const glm::vec3 expected = Expected(point, intensityC);
        ExpectNear(Traced(point), expected, "traced");
        ExpectNear(Drawn(point, passes::RasterShadows::Off), expected, "drawn");
        ExpectNear(Drawn(point, passes::RasterShadows::Maps), expected, "drawn with shadow maps");
    }
    // Horizontal angles are clockwise: positive ones towards the light's -y
    const auto b = [](double v, double h) { return 1000.0 + 5.0 * v + 3.0 * h; };
    render.scene.SetScene(
        test::Load(Floor({.type = 2, .vertical = {-90, 0, 90}, .horizontal = {-90, 90}, .candela = b})));
    const auto intensityB = [&](const glm::dvec3& d) {
        return b(std::atan2(d.x, -d.z) / kDegree, std::asin(-d.y) / kDegree);
    };
    for (const glm::vec3& point : kPoints) {
        ExpectNear(Traced(point), Expected(point, intensityB), "traced, type B");
        ExpectNear(Drawn(point, passes::RasterShadows::Off), Expected(point, intensityB), "drawn, type B");
    }
}

TEST_F(IesLightScene, EditsOfColorAndFactorShowAndOthersAreRefused) {
    render.scene.SetEnvironment({});
    const IesText file{.vertical = {0, 90}, .candela = [](double, double) { return 50.0; }};
    render.scene.SetScene(test::Load(Floor(file)));
    const auto constant = [](const glm::dvec3&) { return 50.0; };
    const glm::vec3 expected = Expected(kPoints[1], constant);
    ExpectNear(Traced(kPoints[1]), expected, "as in the file");
    scene::Light light = render.scene.Light(0);
    EXPECT_EQ(light.profile, 0u);
    light.intensity = 1.0f;
    light.color = {0.5f, 0.5f, 0.25f};
    render.scene.SetLight(0, light);
    ExpectNear(Traced(kPoints[1]), expected * glm::vec3(0.25f, 0.5f, 0.5f), "edited");
    light.profile = 1;
    EXPECT_THROW(render.scene.SetLight(0, light), Error);
    light.profile = scene::kNone;  // a point light of 1 cd
    render.scene.SetLight(0, light);
    ExpectNear(Traced(kPoints[1]), expected * glm::vec3(0.25f, 0.5f, 0.5f) / 50.0f, "without the profile");
    // The next scene has no profile
    GltfDocument plain = Floor(file);
    plain.json["nodes"][1].erase("extensions");
    render.scene.SetScene(test::Load(plain));
    EXPECT_EQ(Traced(kPoints[1]), glm::vec3(0.0f));
}

}  // namespace raygraph::testing::ies_light_scene_test
