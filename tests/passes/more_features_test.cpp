// Programs that can do more than a scene needs.
#include <cmath>
#include <functional>
#include <tuple>

#include "passes/scene_bindings.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::more_features_test {

using passes::TraceSettings;

namespace {

constexpr uint32_t kSamples = 64;
// Those of light and of what materials read; all of them would take a minute to compile.
constexpr TraceFeatures kMore =
    FeaturesOfKind(TraceFeatureKind::Lights) | kTraceMeshLights | kTraceTextures | kTraceVertexColors;

class MoreFeatures : public VulkanTest {
  protected:
    // The same mean, to the noise, with more features.
    void ExpectSameMean(TraceSettings settings) {
        const RenderedImage own = render.Render(settings, kSamples);
        settings.seed = 1;
        const RenderedImage more = Wide(settings, kSamples);
        const glm::dvec3 a = own.mean.Mean(), b = more.mean.Mean();
        const glm::dvec3 errorA = own.StandardErrorOfMean(), errorB = more.StandardErrorOfMean();
        EXPECT_GT(a.y, 0.0);
        for (int i = 0; i < 3; ++i) {
            const double error = std::hypot(errorA[i], errorB[i]);
            EXPECT_NEAR(a[i], b[i], 4.0 * error + 1e-6);
            EXPECT_LT(error, 0.03 * a[i]) << "too noisy to prove anything";
        }
    }

    // Samples of a program with more features than these scenes have.
    RenderedImage Wide(TraceSettings settings, uint32_t sampleCount) {
        passes::Accumulation accumulation("wide");
        RenderedImage image;
        for (uint32_t i = 0; i < sampleCount; ++i, ++settings.sampleIndex) {
            render.renderer.BeginFrame();
            const SceneIds ids = passes::WithFeatures(render.scene.Declare(render.renderer), kMore);
            std::ignore = passes::Accumulate(
                render.renderer, passes::Trace(render.renderer, ids, settings).radiance, accumulation, true);
            const passes::AccumulatedIds all =
                passes::Resolve(render.renderer, accumulation, settings.extent, true);
            const Readback mean = render.renderer.ReadBack(all.mean);
            const Readback variance = render.renderer.ReadBack(all.variance);
            render.renderer.Execute();
            if (i + 1 == sampleCount) image = {ToFloatImage(mean), ToFloatImage(variance), sampleCount};
        }
        return image;
    }

    SceneRender render{Device()};
};

TraceSettings Inside() {
    return LookAt({-0.8f, 0.1f, 0.3f}, {1.0f, -0.5f, 0.0f}, 1.2f, 24);
}

}  // namespace

// No light at all that could be sampled, no texture, nothing transparent: the sky alone, seen from inside.
TEST_F(MoreFeatures, OfAPlainScene_KeepTheMean) {
    scene::Material chalk;
    chalk.baseColorFactor = {0.7f, 0.5f, 0.3f, 1.0f};
    chalk.metallicFactor = 0.0f;
    chalk.roughnessFactor = 0.6f;
    render.scene.SetScene(SceneOf({QuadMesh(3.0f), BoxMesh(0.4f)}, {chalk},
                                  {Translation({0.0f, 0.0f, -2.0f}), Translation({0.4f, -0.5f, 0.1f})}));
    render.scene.SetEnvironment({.radiance = {0.4f, 0.5f, 0.6f}});
    ExpectSameMean(Inside());
}

TEST_F(MoreFeatures, OfALitRoom_KeepTheMean) {
    render.scene.SetScene(SceneOf({BoxMesh(1.0f), BoxMesh(0.4f, 1)},
                                  {Lambert(glm::vec3(0.6f), glm::vec3(0.3f)), Lambert(glm::vec3(0.8f))},
                                  {glm::mat4x3(1.0f), Translation({0.4f, -0.5f, 0.1f})}));
    ExpectSameMean(Inside());
}

// Nothing shines: features of light find none.
TEST_F(MoreFeatures, OfADarkScene_StayDark) {
    render.scene.SetScene(SceneOf({BoxMesh(1.0f)}, {Lambert(glm::vec3(0.6f))}));
    EXPECT_EQ(Wide(Inside(), 1).mean.Mean(), glm::dvec3(0.0));
}

// A scene that is given features has those of a scene with what they are for, and no others.
TEST(WithFeatures, AreThoseOfTheProgram) {
    TraceSettings settings = Inside();
    settings.scattering.brdf = BrdfModel::Gltf;
    const SceneIds scene{.features = kTraceOpaque};
    for (const TraceFeatures feature :
         {kTraceAnyHit, kTraceThinWalls, kTraceCapsules, kTraceVolumes, kMore}) {
        const SceneIds wide = passes::WithFeatures(scene, feature);
        EXPECT_EQ(passes::ProgramFeatures(wide, settings), kTraceOpaque | feature);
    }
    const SceneIds asSet = passes::WithFeatures(scene, FeaturesOfKind(TraceFeatureKind::Settings));
    EXPECT_EQ(passes::ProgramFeatures(asSet, settings), kTraceOpaque);
}

// Of what a scene has, programs have what settings use.
TEST(ProgramFeatures, AreThoseThatSettingsUse) {
    const TraceFeatures scene = ~FeaturesOfKind(TraceFeatureKind::Settings) | kTraceTextureLod;
    const auto of = [](TraceFeatures features, const std::function<void(TraceSettings&)>& set) {
        TraceSettings settings;
        set(settings);
        return passes::ProgramFeatures({.features = features}, settings);
    };
    const auto levels = [](TraceSettings& s) { s.biases.textureLod = 0.0f; };
    EXPECT_EQ(of(scene, levels), scene);
    EXPECT_EQ(of(scene, [](TraceSettings&) {}), scene & ~kTraceTextureLod);
    EXPECT_EQ(of(kTraceTextureLod | kTraceOpaque, levels), kTraceOpaque) << "nothing has levels";
    const TraceFeatures unlit = of(scene, [](TraceSettings& s) { s.lights.isOn = false; });
    EXPECT_EQ(unlit, scene & ~(FeaturesOfKind(TraceFeatureKind::Lights) | kTraceTextureLod));
    const TraceFeatures plain = of(scene, [](TraceSettings& s) { s.scattering.brdf = BrdfModel::Lambert; });
    EXPECT_EQ(plain, scene & ~(FeaturesOfKind(TraceFeatureKind::Lobes) | kTraceTextureLod));
    EXPECT_EQ(of({}, [](TraceSettings& s) { s.biases.shadowTerminator = true; }), kTraceShadowTerminator);
    EXPECT_EQ(of({}, [](TraceSettings& s) { s.isEnvironmentHidden = true; }), kTraceHiddenEnvironment);
}

}  // namespace raygraph::testing::more_features_test
