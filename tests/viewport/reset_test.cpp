// Which changes restart accumulation, with which cause, and which do not.
#include <gmock/gmock.h>
#include <array>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "renderer/scene/animation/deform.h"
#include "tests/support/option_rows.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::reset_test {

using passes::ResetCause;
using ::testing::HasSubstr;
using ::testing::Not;

namespace {

class ViewportReset : public VulkanTest {
  protected:
    void ExpectNoReset(const std::function<void()>& edit) {
        viewed.RenderFrames(1);
        const uint32_t samples = viewed.Samples(), resets = viewed.AllResets();
        edit();
        viewed.RenderFrames(1);
        EXPECT_EQ(viewed.Samples(), samples + 1);
        EXPECT_EQ(viewed.AllResets(), resets);
    }

    ViewedScene viewed{Device()};
};

std::string CulledPasses(const std::string& plan) {
    const size_t begin = plan.find("\nculled\n");
    if (begin == std::string::npos) return "";
    return plan.substr(begin, plan.find("\n\n", begin + 1) - begin);
}

}  // namespace

// All other causes are below.
TEST_F(ViewportReset, Resize_StartsAnewAndIsCountedByItsCause) {
    viewed.RenderFrames(2);
    ASSERT_EQ(viewed.Samples(), 2u);
    viewed.viewport.SetSize({17, 9});
    viewed.RenderFrames(1);
    EXPECT_EQ(viewed.Samples(), 1u);
    EXPECT_EQ(viewed.viewport.ResetCount(ResetCause::Resize), 1u);
    EXPECT_EQ(viewed.AllResets(), 1u);
}

TEST_F(ViewportReset, EditsThatChangeNothing_DoNotReset) {
    viewed.scene.SetVisible(1, true);
    ExpectNoReset([&] {
        viewed.viewport.SetCamera(InsideBoxes());
        viewed.viewport.SetSize(viewed.viewport.Size());
        viewed.viewport.SetPaths(viewed.viewport.Paths());
        viewed.viewport.SetScene(viewed.scene);
        viewed.scene.SetTransform(1, viewed.scene.Transform(1));
        viewed.scene.SetVisible(1, true);
        viewed.scene.SetMaterial(1, Lambert(glm::vec3(0.8f)));
        viewed.scene.SetLight(0, viewed.scene.Light(0));
        viewed.scene.SetEnvironment(viewed.scene.Environment());
        viewed.scene.RemoveEnvironmentMap();
    });
}

TEST_F(ViewportReset, RasterSettings_ResetTheRasterViewAlone) {
    viewed.viewport.SetView(View::Wipe);
    viewed.RenderFrames(2);
    viewed.viewport.SetRaster({.shadows = passes::RasterShadows::Off, .hasOcclusion = true});
    viewed.RenderFrames(1);
    EXPECT_EQ(viewed.Samples(), 3u);
    EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 1u);
    EXPECT_EQ(viewed.AllResets(), 0u);
}

TEST_F(ViewportReset, WhatComesAfterAccumulation_NeverResets) {
    ExpectNoReset([&] {
        viewport::ShowSettings show;
        show.tonemap = {.exposureEv = 3.0f, .tonemapOperator = TonemapOperator::Aces};
        show.maxError = 0.1f;
        viewed.viewport.SetShow(show);
    });
    ExpectNoReset([&] {
        viewport::ShowSettings show = viewed.viewport.Show();
        show.view = View::Wipe;
        show.wipePosition = 0.2f;
        viewed.viewport.SetShow(show);
    });
    ExpectNoReset([&] { viewed.viewport.SetBudget({.frameMs = 1000.0, .samplesPerFrame = 1}); });
}

TEST_F(ViewportReset, ToggledAway_TheViewIsCulledAndGoesOnWhenItIsBack) {
    ViewedScene straight(Device());
    straight.RenderFrames(3);
    viewed.RenderFrames(2);
    viewed.viewport.SetView(View::Raster);
    viewed.RenderFrames(3);
    const std::string culled = CulledPasses(viewed.renderer.DescribePlan());
    const bool isLoop = passes::DefaultForm(Device()) == passes::IntegratorForm::Loop;
    const std::string tracing = isLoop ? "    Trace (" : "    WaveFirst (";
    EXPECT_THAT(culled, HasSubstr(tracing));
    EXPECT_THAT(culled, Not(HasSubstr("    RasterShade (")));
    EXPECT_EQ(viewed.Samples(), 2u);
    EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 3u);

    viewed.viewport.SetView(View::PathTraced);
    viewed.RenderFrames(1);
    const std::string culledNow = CulledPasses(viewed.renderer.DescribePlan());
    EXPECT_THAT(culledNow, HasSubstr("    RasterShade ("));
    EXPECT_THAT(culledNow, HasSubstr("    CullInstances ("));
    EXPECT_THAT(culledNow, Not(HasSubstr(tracing)));
    EXPECT_EQ(viewed.Samples(), 3u);
    EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 3u);
    EXPECT_EQ(viewed.AllResets(), 0u);
    EXPECT_EQ(viewed.Picture(), straight.Picture());
}

TEST_F(ViewportReset, AfterAViewThatShowsNoDisplay_ThePictureIsTheAccumulations) {
    ViewedScene straight(Device());
    straight.RenderFrames(4);
    viewed.RenderFrames(1);
    viewed.viewport.SetView(View::Difference);  // goes on accumulating, and shows neither picture
    viewed.RenderFrames(2);
    viewed.viewport.SetView(View::PathTraced);
    viewed.viewport.SetBudget({.maxSamples = 3});
    const std::vector<uint8_t> picture = viewed.Picture();
    EXPECT_EQ(viewed.Samples(), 3u);
    ViewedScene three(Device());
    three.RenderFrames(2);
    EXPECT_EQ(picture, three.Picture());
    EXPECT_NE(picture, straight.Picture());
}

TEST_F(ViewportReset, WhileTheCameraMoves_TheRasterViewStandsInIfAskedFor) {
    viewed.viewport.SetBudget({.whileMoving = viewport::MotionView::Raster, .settleMs = 1e9});
    viewed.RenderFrames(2);
    EXPECT_EQ(viewed.Samples(), 2u);
    scene::CameraView camera = InsideBoxes();
    camera.eye.x += 0.01f;
    viewed.viewport.SetCamera(camera);
    viewed.RenderFrames(2);
    EXPECT_EQ(viewed.Samples(), 0u);
    EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 2u);
    viewed.viewport.SetBudget({.whileMoving = viewport::MotionView::Raster, .settleMs = 0.0});
    viewed.RenderFrames(2);
    EXPECT_EQ(viewed.Samples(), 2u);
    EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 2u);
}

TEST_F(ViewportReset, SceneRevisions_CountEditsByKind) {
    const SceneRevisions before = viewed.scene.Revisions();
    viewed.scene.SetTransform(1, Translation({0.1f, 0.0f, 0.0f}));
    viewed.scene.SetTransform(1, Translation({0.2f, 0.0f, 0.0f}));
    viewed.scene.SetVisible(0, false);
    EXPECT_FALSE(viewed.scene.IsVisible(0));
    SceneRevisions expected = before;
    expected.transforms += 2;
    ++expected.geometry;
    EXPECT_EQ(viewed.scene.Revisions(), expected);
}

TEST_F(ViewportReset, SetLight_IsSeenAndRebuildsTheLightTablesAlone) {
    viewed.RenderFrames(2);
    const std::vector<uint8_t> dim = viewed.Picture();
    // Compaction, which ends when the device has told the sizes, rebuilds the instances' structure
    for (int frame = 0; frame < 16 && !viewed.scene.IsSettled(); ++frame) {
        Device().WaitIdle();
        viewed.RenderFrames(1);
    }
    ASSERT_TRUE(viewed.scene.IsSettled());
    const GpuSceneStatistics before = viewed.scene.Statistics();
    scene::Light light = viewed.scene.Light(0);
    light.intensity *= 20.0f;
    viewed.scene.SetLight(0, light);
    const std::vector<uint8_t> bright = viewed.Picture();
    uint64_t dimSum = 0, brightSum = 0;
    for (size_t i = 0; i < dim.size(); ++i) {
        dimSum += dim[i];
        brightSum += bright[i];
    }
    EXPECT_GT(brightSum, dimSum + dimSum / 20);
    EXPECT_EQ(viewed.scene.Statistics().lightRebuilds, before.lightRebuilds + 1);
    EXPECT_EQ(viewed.scene.Statistics().tlasRebuilds, before.tlasRebuilds);
    EXPECT_EQ(viewed.scene.Statistics().tlasUpdates, before.tlasUpdates);

    light.intensity = -1.0f;
    EXPECT_THROW(viewed.scene.SetLight(0, light), Error);
    EXPECT_THROW(viewed.scene.SetLight(1, viewed.scene.Light(0)), Error);
}

}  // namespace raygraph::testing::reset_test

// A change of anything that a picture depends on restarts accumulation, and the picture is then bit for bit
// that of a viewport that has only ever had the new state.
namespace raygraph::testing::reset_cause_test {

using passes::ResetCause;
using viewport::PathSettings;

namespace {

// A scene like OpenBoxes below, seen through a lens, in two colors of light. Several share a Renderer, and so
// its pipelines.
class Viewed {
  public:
    Viewed(Renderer& ofRenderer, const char* name, Extent2D size, scene::SceneData data);

    // Restores the scene and everything else. The map only if needed, since every new one is filtered.
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
    bool isMapDirty = true;
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

// Like Boxes, but the outer box is open to the environment, and the inner one has a morph target.
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
    if (std::exchange(isMapDirty, false))
        scene.SetEnvironmentMap(TwoColoredMap({0.5f, 0.2f, 0.1f}, {0.1f, 0.3f, 0.6f}));
    scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    viewport.SetCamera(InsideBoxes(), {.radius = 0.05f, .focusDistance = 1.0f});
    PathSettings paths;
    paths.scattering.brdf = BrdfModel::Lambert;
    viewport.SetPaths(paths);
}

// Edits that change a picture of Lambert surfaces and need no other pipeline.
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

// Edits that change pictures of other scenes only. All settings of a viewport are below.
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
        viewed.isMapDirty = edit.cause == ResetCause::Environment;
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
    std::set<ResetCause> causes;
    for (const Edit& edit : EditsThatShow()) {
        if (edit.cause == ResetCause::Camera && std::string(edit.name) != "lens radius") continue;
        if (!causes.insert(edit.cause).second) continue;
        SCOPED_TRACE(edit.name);
        Viewed edited(renderer, "edited", kLarge, OpenBoxes());
        Viewed fresh(renderer, "fresh", kLarge, OpenBoxes());
        for (Viewed* viewed : {&edited, &fresh})
            viewed->viewport.SetBudget({.frameMs = 1e-3, .whileMoving = viewport::MotionView::PathTraced});
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

// Every field of the settings that a picture is traced and drawn with, and every value of their enumerations,
// restarts the views that depend on it, once and for its cause.
namespace raygraph::testing::reset_settings_test {

using passes::RasterSettings;
using passes::RasterShadows;
using passes::ResetCause;
using scene::CameraView;
using viewport::LensSettings;
using viewport::PathSettings;

namespace {

template <typename Settings>
struct Row {
    const char* name;
    void (*change)(Settings&);
    bool resets = true;
};

const Row<PathSettings> kOfPaths[] = {
    {"pcg", [](PathSettings& s) { s.sampler = SamplerKind::Pcg; }},
    {"tea", [](PathSettings& s) { s.sampler = SamplerKind::Tea; }},
    {"seed", [](PathSettings& s) { s.seed = 5; }},
    {"gltf", [](PathSettings& s) { s.scattering.brdf = BrdfModel::Gltf; }},
    {"lafortune", [](PathSettings& s) { s.scattering.brdf = BrdfModel::Lafortune; }},
    {"beckmann", [](PathSettings& s) { s.scattering.distribution = MicrofacetModel::Beckmann; }},
    {"phong", [](PathSettings& s) { s.scattering.distribution = MicrofacetModel::Phong; }},
    {"separable", [](PathSettings& s) { s.scattering.masking = MaskingModel::Separable; }},
    {"shortcut", [](PathSettings& s) { s.scattering.masking = MaskingModel::Shortcut; }},
    {"dielectric", [](PathSettings& s) { s.scattering.fresnel = FresnelModel::Dielectric; }},
    {"conductor", [](PathSettings& s) { s.scattering.fresnel = FresnelModel::Conductor; }},
    {"lazanyi", [](PathSettings& s) { s.scattering.fresnel = FresnelModel::Lazanyi; }},
    {"no multiscatter", [](PathSettings& s) { s.scattering.multiscatter = MultiscatterKind::Off; }},
    {"walk", [](PathSettings& s) { s.scattering.multiscatter = MultiscatterKind::Walk; }},
    {"light sampling", [](PathSettings& s) { s.lights.isOn = false; }},
    {"uniform lights", [](PathSettings& s) { s.lights.sampler = LightSampler::Uniform; }},
    {"lights by power", [](PathSettings& s) { s.lights.sampler = LightSampler::Power; }},
    {"balance", [](PathSettings& s) { s.lights.mis = MisHeuristic::Balance; }},
    {"mis off", [](PathSettings& s) { s.lights.mis = MisHeuristic::Off; }},
    {"constant roulette", [](PathSettings& s) { s.roulette.kind = Roulette::Constant; }},
    {"roulette of the frame", [](PathSettings& s) { s.roulette.kind = Roulette::Frame; }},
    {"roulette off", [](PathSettings& s) { s.roulette.kind = Roulette::Off; }},
    {"roulette's start", [](PathSettings& s) { s.roulette.start = 1; }},
    {"survival", [](PathSettings& s) { s.roulette.survival = 0.5f; }},
    {"depth", [](PathSettings& s) { s.biases.maxDepth = 1; }},
    {"clamp", [](PathSettings& s) { s.biases.clampIndirect = 0.02f; }},
    {"regularization", [](PathSettings& s) { s.biases.regularize = 0.1f; }},
    {"shadow terminator", [](PathSettings& s) { s.biases.shadowTerminator = true; }},
    {"texture levels", [](PathSettings& s) { s.biases.textureLod = 0.5f; }},
    {"hidden environment", [](PathSettings& s) { s.isEnvironmentHidden = true; }},
};

const Row<CameraView> kOfCamera[] = {
    {"eye", [](CameraView& c) { c.eye.y += 0.05; }},
    {"forward", [](CameraView& c) { c.forward.x += 0.01f; }},
    {"up", [](CameraView& c) { c.up.x += 0.01f; }},
    {"right", [](CameraView& c) { c.right.x += 0.01f; }},
    {"projection", [](CameraView& c) { c.projection = scene::Projection::Orthographic; }},
    {"field of view", [](CameraView& c) { c.yFov = 1.0f; }},
    {"height", [](CameraView& c) { c.height = 1.0f; }},
    {"aspect", [](CameraView& c) { c.aspect = 3.0f; }, false},  // that of the size
    {"near", [](CameraView& c) { c.zNear = 0.02f; }},
    {"far", [](CameraView& c) { c.zFar = 90.0f; }},
};

const Row<LensSettings> kOfLens[] = {
    {"lens radius", [](LensSettings& s) { s.radius = 0.2f; }},
    {"focus distance", [](LensSettings& s) { s.focusDistance = 0.4f; }},
};

const Row<RasterSettings> kOfRaster[] = {
    {"maps", [](RasterSettings& s) { s.shadows = RasterShadows::Maps; }},
    {"rays", [](RasterSettings& s) { s.shadows = RasterShadows::Rays; }},
    {"atlas", [](RasterSettings& s) { s.shadowAtlasSize = 64; }},
    {"occlusion", [](RasterSettings& s) { s.hasOcclusion = true; }},
    {"transmission", [](RasterSettings& s) { s.hasTransmission = true; }},
    {"texture levels", [](RasterSettings& s) { s.hasTextureLevels = false; }},
};

class ViewportResetSettings : public VulkanTest {
  protected:
    // `set` gives settings to the viewport. Both views have a sample when a row changes `plain`, and the
    // frame after that shows neither, so that no pipeline is made for it.
    template <typename Settings, typename Fields, typename Set>
    void ExpectEachResets(std::span<const Row<Settings>> table, Settings plain, Fields fields, Set set,
                          ResetCause cause) {
        auto rows = OptionRowsOf<Settings>(fields);
        for (const Row<Settings>& row : table) {
            SCOPED_TRACE(row.name);
            set(plain);
            viewed.viewport.SetView(View::Wipe);
            viewed.RenderFrames(1);
            ASSERT_GE(viewed.Samples(), 1u);
            ASSERT_GE(viewed.viewport.Progress().rasterSamples, 1u);
            const uint32_t samples = viewed.Samples(), drawn = viewed.viewport.Progress().rasterSamples;
            const uint32_t resets = viewed.AllResets(), ofCause = viewed.viewport.ResetCount(cause);
            Settings changed = plain;
            row.change(changed);
            rows.Add(row.name, plain, changed);
            set(changed);
            viewed.viewport.SetView(View::Surface);
            viewed.RenderFrames(1);
            const bool isOfRasterAlone = std::is_same_v<Settings, RasterSettings>;
            const uint32_t pathResets = row.resets && !isOfRasterAlone ? 1u : 0u;
            EXPECT_EQ(viewed.Samples(), pathResets > 0 ? 0u : samples);
            EXPECT_EQ(viewed.viewport.Progress().rasterSamples, row.resets ? 0u : drawn);
            EXPECT_EQ(viewed.viewport.ResetCount(cause), ofCause + pathResets);
            EXPECT_EQ(viewed.AllResets(), resets + pathResets);
        }
        set(plain);
        rows.ExpectComplete();
    }

    ViewedScene viewed{Device()};
};

}  // namespace

TEST_F(ViewportResetSettings, EveryFieldAndValueOfPathsDoesSo) {
    ExpectEachResets(
        std::span<const Row<PathSettings>>(kOfPaths), viewed.viewport.Paths(),
        [](PathSettings& s) {
            auto& [sampler, seed, scattering, lights, roulette, biases, isEnvironmentHidden] = s;
            auto& [brdf, distribution, masking, fresnel, multiscatter] = scattering;
            auto& [isOn, lightSampler, mis] = lights;
            auto& [kind, start, survival] = roulette;
            auto& [maxDepth, clampIndirect, regularize, shadowTerminator, textureLod] = biases;
            return std::tie(sampler, seed, brdf, distribution, masking, fresnel, multiscatter, isOn,
                            lightSampler, mis, kind, start, survival, maxDepth, clampIndirect, regularize,
                            shadowTerminator, textureLod, isEnvironmentHidden);
        },
        [&](const PathSettings& s) { viewed.viewport.SetPaths(s); }, ResetCause::Settings);
}

TEST_F(ViewportResetSettings, EveryFieldOfCameraAndLensDoesSo) {
    LensSettings lens{.radius = 0.05f, .focusDistance = 1.0f};
    ExpectEachResets(
        std::span<const Row<CameraView>>(kOfCamera), InsideBoxes(),
        [](CameraView& c) {
            auto& [eye, forward, up, right, projection, yFov, height, aspect, zNear, zFar] = c;
            return std::tie(eye, forward, up, right, projection, yFov, height, aspect, zNear, zFar);
        },
        [&](const CameraView& c) { viewed.viewport.SetCamera(c, lens); }, ResetCause::Camera);
    ExpectEachResets(
        std::span<const Row<LensSettings>>(kOfLens), lens,
        [](LensSettings& s) {
            auto& [radius, focusDistance] = s;
            return std::tie(radius, focusDistance);
        },
        [&](const LensSettings& s) { viewed.viewport.SetCamera(InsideBoxes(), s); }, ResetCause::Camera);
}

TEST_F(ViewportResetSettings, EveryFieldAndValueOfTheRasterViewDoesSoToItAlone) {
    ExpectEachResets(
        std::span<const Row<RasterSettings>>(kOfRaster), PlainRaster(),
        [](RasterSettings& s) {
            auto& [shadows, shadowAtlasSize, hasOcclusion, hasTransmission, hasTextureLevels] = s;
            return std::tie(shadows, shadowAtlasSize, hasOcclusion, hasTransmission, hasTextureLevels);
        },
        [&](const RasterSettings& s) { viewed.viewport.SetRaster(s); }, ResetCause::Settings);
}

}  // namespace raygraph::testing::reset_settings_test
