// A change of anything that a picture depends on restarts accumulation, and the picture is then bit for bit
// that of a viewport that has only ever had the new state.
#include <array>
#include <functional>
#include <string>
#include <utility>

#include "renderer/scene/animation/deform.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::reset_cause_test {

using passes::ResetCause;
using viewport::PathSettings;

namespace {

// As OpenBoxes below, seen through a lens, in two colors of light. Several share a Renderer, and so its
// pipelines.
class Viewed {
  public:
    Viewed(Renderer& ofRenderer, const char* name, Extent2D size, scene::SceneData data);

    // The scene, and all else as it was at first.
    void Set(scene::SceneData data);
    void RenderFrames(uint32_t count) {
        for (uint32_t i = 0; i < count; ++i) viewport.RenderFrame();
    }
    std::vector<uint8_t> Picture() {
        m_renderer.BeginFrame();
        const Readback readback = m_renderer.ReadBack(viewport.Declare());
        m_renderer.Execute();
        readback.Wait();
        return As<uint8_t>(readback.Bytes());
    }
    uint32_t Samples() const { return viewport.Progress().pathTracedSamples; }
    uint32_t AllResets() const {
        uint32_t count = 0;
        for (uint32_t i = 0; i < static_cast<uint32_t>(ResetCause::Count); ++i)
            count += viewport.ResetCount(static_cast<ResetCause>(i));
        return count;
    }

  private:
    Renderer& m_renderer;

  public:
    GpuScene scene;
    Viewport viewport;
};

struct Edit {
    const char* name;
    ResetCause cause;
    std::function<void(Viewed&)> apply;
};

image::ImageF TwoColoredMap(const glm::vec3& left, const glm::vec3& right) {
    image::ImageF map{.width = 8, .height = 4, .rgba = {}};
    for (uint32_t i = 0; i < 32; ++i) {
        const glm::vec3& color = i % 8 < 4 ? left : right;
        map.rgba.insert(map.rgba.end(), {color.x, color.y, color.z, 1.0f});
    }
    return map;
}

// As Boxes, but the outer one is open to the environment, and the inner one has a morph target.
scene::SceneData OpenBoxes() {
    scene::SceneData data = Boxes();
    std::vector<uint32_t>& indices = data.meshes[0].primitives[0].indices;
    indices.resize(indices.size() - 6);
    scene::Mesh& inner = data.meshes[1];
    inner.weights = {0.0f};
    scene::MorphTarget& target = inner.primitives[0].targets.emplace_back();
    for (const glm::vec3& position : inner.primitives[0].positions)
        target.positions.push_back({0.5f * position.y, 0, 0});
    scene::UpdateDeformationBounds(inner.primitives[0]);
    data.instances[1].isDeformed = true;
    return data;
}

Edit OfCamera(const char* name, std::function<void(scene::CameraView&, viewport::LensSettings&)> change) {
    return {name, ResetCause::Camera, [change = std::move(change)](Viewed& viewed) {
                scene::CameraView camera = InsideBoxes();
                viewport::LensSettings lens{.radius = 0.05f, .focusDistance = 1.0f};
                change(camera, lens);
                viewed.viewport.SetCamera(camera, lens);
            }};
}

Edit OfPaths(const char* name, std::function<void(PathSettings&)> change) {
    return {name, ResetCause::Settings, [change = std::move(change)](Viewed& viewed) {
                PathSettings paths = viewed.viewport.Paths();
                change(paths);
                viewed.viewport.SetPaths(paths);
            }};
}

Edit OfMaterial(const char* name, std::function<void(scene::Material&)> change) {
    return {name, ResetCause::Material, [change = std::move(change)](Viewed& viewed) {
                scene::Material material = Lambert(glm::vec3(0.8f));
                change(material);
                viewed.scene.SetMaterial(1, material);
            }};
}

Edit OfLight(const char* name, std::function<void(scene::Light&)> change) {
    return {name, ResetCause::Light, [change = std::move(change)](Viewed& viewed) {
                scene::Light light = viewed.scene.Light(0);
                change(light);
                viewed.scene.SetLight(0, light);
            }};
}

Viewed::Viewed(Renderer& ofRenderer, const char* name, Extent2D size, scene::SceneData data)
    : m_renderer(ofRenderer), scene(ofRenderer), viewport(ofRenderer, scene, {.name = name, .size = size}) {
    Set(std::move(data));
    viewport.SetRaster(PlainRaster());
}

void Viewed::Set(scene::SceneData data) {
    scene.SetScene(std::move(data));
    scene.SetEnvironmentMap(TwoColoredMap({0.5f, 0.2f, 0.1f}, {0.1f, 0.3f, 0.6f}));
    scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    viewport.SetCamera(InsideBoxes(), {.radius = 0.05f, .focusDistance = 1.0f});
    PathSettings paths;
    paths.scattering.brdf = BrdfModel::Lambert;
    viewport.SetPaths(paths);
}

// What shows in a picture of Lambert surfaces and asks for no other pipeline.
std::vector<Edit> EditsThatShow() {
    using Camera = scene::CameraView;
    using Lens = viewport::LensSettings;
    return {
        OfCamera("eye", [](Camera& camera, Lens&) { camera.eye.y += 0.05f; }),
        OfCamera("direction",
                 [](Camera& camera, Lens&) {
                     const Camera turned = Camera::LookAt(camera.eye, {1.0f, -0.4f, 0.1f}, {0, 1, 0});
                     camera.forward = turned.forward, camera.right = turned.right, camera.up = turned.up;
                 }),
        OfCamera("field of view", [](Camera& camera, Lens&) { camera.yFov = 1.0f; }),
        OfCamera("projection",
                 [](Camera& camera, Lens&) { camera.projection = scene::Projection::Orthographic; }),
        OfCamera("lens radius", [](Camera&, Lens& lens) { lens.radius = 0.2f; }),
        OfCamera("no lens", [](Camera&, Lens& lens) { lens.radius = 0.0f; }),
        OfCamera("focus distance", [](Camera&, Lens& lens) { lens.focusDistance = 0.4f; }),
        {"transform", ResetCause::Transform,
         [](Viewed& viewed) {
             viewed.scene.SetTransform(1, Translation({0.3f, -0.4f, 0.1f}));
         }},
        {"shape", ResetCause::Transform,
         [](Viewed& viewed) { viewed.scene.SetMorphWeights(1, std::array{1.0f}); }},
        OfMaterial("base color",
                   [](scene::Material& material) {
                       material.baseColorFactor = {0.8f, 0.2f, 0.2f, 1.0f};
                   }),
        OfMaterial("emission", [](scene::Material& material) { material.emissiveFactor = glm::vec3(1.0f); }),
        OfLight("intensity", [](scene::Light& light) { light.intensity *= 4.0f; }),
        OfLight("color",
                [](scene::Light& light) {
                    light.color = {1.0f, 0.5f, 0.1f};
                }),
        OfLight("place", [](scene::Light& light) { light.lightToWorld[3].x += 0.3f; }),
        OfLight("kind", [](scene::Light& light) { light.type = scene::LightType::Spot; }),
        {"visibility", ResetCause::Geometry, [](Viewed& viewed) { viewed.scene.SetVisible(1, false); }},
        {"scene", ResetCause::Geometry,
         [](Viewed& viewed) {
             scene::SceneData data = OpenBoxes();
             data.instances[1].objectToWorld = Translation({0.1f, -0.5f, 0.2f});
             viewed.scene.SetScene(std::move(data));
         }},
        {"environment's factor", ResetCause::Environment,
         [](Viewed& viewed) { viewed.scene.SetEnvironment({.radiance = glm::vec3(3.0f)}); }},
        {"environment's rotation", ResetCause::Environment,
         [](Viewed& viewed) {
             viewed.scene.SetEnvironment({.radiance = glm::vec3(1.0f), .rotation = 1.5f});
         }},
        {"environment map", ResetCause::Environment,
         [](Viewed& viewed) {
             viewed.scene.SetEnvironmentMap(TwoColoredMap({0.1f, 0.9f, 0.1f}, {0.9f, 0.1f, 0.9f}));
         }},
        {"no environment map", ResetCause::Environment,
         [](Viewed& viewed) { viewed.scene.RemoveEnvironmentMap(); }},
        OfPaths("seed", [](PathSettings& paths) { paths.seed = 5; }),
        OfPaths("depth", [](PathSettings& paths) { paths.biases.maxDepth = 1; }),
        OfPaths("roulette's start", [](PathSettings& paths) { paths.roulette.start = 1; }),
        OfPaths("clamp", [](PathSettings& paths) { paths.biases.clampIndirect = 0.02f; }),
    };
}

// What shows in other scenes alone. All of the viewport's own settings: reset_settings_test.cpp.
std::vector<Edit> OtherEdits() {
    return {
        OfMaterial("alpha", [](scene::Material& material) { material.baseColorFactor.a = 0.5f; }),
        OfMaterial("metallic", [](scene::Material& material) { material.metallicFactor = 0.5f; }),
        OfMaterial("roughness", [](scene::Material& material) { material.roughnessFactor = 0.5f; }),
        OfMaterial("ior", [](scene::Material& material) { material.ior = 1.3f; }),
        OfMaterial("specular", [](scene::Material& material) { material.specularFactor = 0.5f; }),
        OfMaterial("specular color",
                   [](scene::Material& material) { material.specularColorFactor.x = 0.5f; }),
        OfMaterial("normal scale", [](scene::Material& material) { material.normalScale = 0.5f; }),
    };
}

class ViewportResetCause : public VulkanTest {
  protected:
    static constexpr Extent2D kSize{24, 16};

    // Both views have samples, then `edit` and a frame that shows neither: both have lost them, for its
    // cause.
    void ExpectReset(Viewed& viewed, const Edit& edit) {
        SCOPED_TRACE(edit.name);
        viewed.Set(OpenBoxes());
        viewed.viewport.SetView(View::Wipe);
        viewed.RenderFrames(1);
        ASSERT_EQ(viewed.Samples(), 1u);
        ASSERT_EQ(viewed.viewport.Progress().rasterSamples, 1u);
        const uint32_t resets = viewed.AllResets(), ofCause = viewed.viewport.ResetCount(edit.cause);
        viewed.viewport.SetView(View::Surface);
        edit.apply(viewed);
        viewed.RenderFrames(1);
        EXPECT_EQ(viewed.Samples(), 0u);
        EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 0u);
        EXPECT_EQ(viewed.viewport.ResetCount(edit.cause), ofCause + 1);
        EXPECT_EQ(viewed.AllResets(), resets + 1);
    }

    RendererLease lease{Device()};
    Renderer& renderer = *lease;
};

}  // namespace

TEST_F(ViewportResetCause, EveryPartOfEverySettingResetsBothViews) {
    Viewed viewed(renderer, "viewed", kSize, OpenBoxes());
    for (const Edit& edit : EditsThatShow()) ExpectReset(viewed, edit);
    for (const Edit& edit : OtherEdits()) ExpectReset(viewed, edit);
}

TEST_F(ViewportResetCause, WhatIsShownAfterAnEditIsAsIfItHadAlwaysBeenSo) {
    Viewed before(renderer, "before", kSize, OpenBoxes());
    before.RenderFrames(1);
    const std::vector<uint8_t> old = before.Picture();
    for (const Edit& edit : EditsThatShow()) {
        SCOPED_TRACE(edit.name);
        Viewed edited(renderer, "edited", kSize, OpenBoxes());
        Viewed fresh(renderer, "fresh", kSize, OpenBoxes());
        edited.RenderFrames(2);
        edit.apply(edited);
        edit.apply(fresh);
        edited.RenderFrames(1);
        fresh.RenderFrames(1);
        const std::vector<uint8_t> shown = edited.Picture();
        EXPECT_EQ(edited.Samples(), 2u);
        EXPECT_TRUE(shown == fresh.Picture());
        EXPECT_FALSE(shown == old) << "the edit does not show";
    }
}

// With a limit that nothing fits, the first picture is the coarsest one, whole.
TEST_F(ViewportResetCause, CoarserPicturesAreTracedAnewToo) {
    constexpr Extent2D kLarge{96, 64};
    for (const Edit& edit : EditsThatShow()) {
        if (edit.cause == ResetCause::Camera && std::string(edit.name) != "lens radius") continue;
        SCOPED_TRACE(edit.name);
        Viewed edited(renderer, "edited", kLarge, OpenBoxes());
        Viewed fresh(renderer, "fresh", kLarge, OpenBoxes());
        for (Viewed* viewed : {&edited, &fresh}) viewed->viewport.SetBudget({.frameMs = 1e-3});
        edited.RenderFrames(2);
        EXPECT_EQ(edited.viewport.Progress().coarseness, 4u);
        const std::vector<uint8_t> old = edited.Picture();
        edit.apply(edited);
        edit.apply(fresh);
        const std::vector<uint8_t> shown = edited.Picture();
        EXPECT_EQ(edited.viewport.Progress().coarseness, 4u);
        EXPECT_TRUE(shown == fresh.Picture());
        EXPECT_FALSE(shown == old) << "the edit does not show";
        EXPECT_EQ(edited.AllResets(), 1u);
    }
}

TEST_F(ViewportResetCause, AnotherSceneIsShownAtOnce) {
    Viewed viewed(renderer, "viewed", kSize, OpenBoxes());
    viewed.RenderFrames(2);
    const std::vector<uint8_t> old = viewed.Picture();
    GpuScene other(renderer);
    scene::SceneData data = OpenBoxes();
    data.materials[0] = Lambert({0.2f, 0.7f, 0.3f}, {0.1f, 0.4f, 0.2f});
    other.SetScene(std::move(data));
    viewed.viewport.SetScene(other);
    const std::vector<uint8_t> shown = viewed.Picture();
    EXPECT_EQ(viewed.Samples(), 1u);
    EXPECT_EQ(viewed.viewport.ResetCount(ResetCause::Geometry), 1u);
    EXPECT_FALSE(shown == old);
    Viewed fresh(renderer, "fresh", kSize, OpenBoxes());
    viewed.viewport.SetScene(viewed.scene);
    EXPECT_TRUE(viewed.Picture() == fresh.Picture());
    EXPECT_EQ(viewed.viewport.ResetCount(ResetCause::Geometry), 2u);
}

}  // namespace raygraph::testing::reset_cause_test
