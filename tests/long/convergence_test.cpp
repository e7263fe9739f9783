// Tests that every way to sample light, points and path lengths converges to one image, and that every
// microfacet model renders.
#include "tests/support/same_image.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::convergence_test {

using passes::TraceSettings;

namespace {

struct Variant {
    const char* name;
    void (*change)(TraceSettings&);
    uint32_t sampleCount = 96;
    PixelErrors errors = PixelErrors::Independent;
};

class Convergence : public VulkanTest {
  protected:
    void ExpectOneImage(const TraceSettings& settings, const RenderedImage& reference,
                        const Variant& variant) {
        TraceSettings changed = settings;
        changed.seed = 1;
        variant.change(changed);
        ExpectSameImage(render.Render(changed, variant.sampleCount), reference, variant.name, variant.errors);
    }

    SceneRender render{Device()};
};

}  // namespace

TEST_F(Convergence, Trace_EveryStrategyConvergesToOneImage) {
    scene::SceneData scene = RoomWithLamp();
    scene::Light light;
    light.lightToWorld = Translation({-1.0f, 0.5f, 1.0f});
    scene.lights = {light};
    render.scene.SetScene(std::move(scene));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    render.scene.SetEnvironmentMap(EveningSky());
    const TraceSettings settings = ViewOfRoom(64);
    const RenderedImage reference = render.Render(settings, 512);
    const Variant variants[] = {
        {"balance heuristic", [](TraceSettings& s) { s.lights.mis = MisHeuristic::Balance; }},
        {"light sampling alone", [](TraceSettings& s) { s.lights.mis = MisHeuristic::Off; }},
        {"uniform lights", [](TraceSettings& s) { s.lights.sampler = LightSampler::Uniform; }},
        {"lights by power", [](TraceSettings& s) { s.lights.sampler = LightSampler::Power; }},
        {"pcg", [](TraceSettings& s) { s.sampler = SamplerKind::Pcg; }},
        {"tea", [](TraceSettings& s) { s.sampler = SamplerKind::Tea; }},
        {"constant roulette",
         [](TraceSettings& s) { s.roulette = {.kind = Roulette::Constant, .start = 1, .survival = 0.7f}; }},
        {"a depth a frame",
         [](TraceSettings& s) { s.roulette = {.kind = Roulette::Frame, .start = 1, .survival = 0.7f}; }, 1024,
         PixelErrors::Shared},
        {"no roulette",
         [](TraceSettings& s) {
             s.roulette.kind = Roulette::Off;
             s.biases.maxDepth = 24;
         }},
    };
    for (const Variant& variant : variants) ExpectOneImage(settings, reference, variant);
}

TEST_F(Convergence, Trace_SamplersAndRoulettesAgreeInTheDepthOfARoom) {
    render.scene.SetScene(EmissiveRoom());
    TraceSettings settings = ViewOfEmissiveRoom(64);
    settings.roulette.start = 8;
    const RenderedImage reference = render.Render(settings, 256);
    const Variant variants[] = {
        {"pcg", [](TraceSettings& s) { s.sampler = SamplerKind::Pcg; }},
        {"tea", [](TraceSettings& s) { s.sampler = SamplerKind::Tea; }},
        {"roulette from 1", [](TraceSettings& s) { s.roulette.start = 1; }},
        {"constant roulette",
         [](TraceSettings& s) { s.roulette = {.kind = Roulette::Constant, .start = 3, .survival = 0.8f}; }},
        {"a depth a frame",
         [](TraceSettings& s) { s.roulette = {.kind = Roulette::Frame, .start = 3, .survival = 0.8f}; }, 512,
         PixelErrors::Shared},
    };
    for (const Variant& variant : variants) ExpectOneImage(settings, reference, variant);
}

TEST_F(Convergence, Trace_EveryMicrofacetModelLosesOnlyLight) {
    scene::Material metal;
    metal.metallicFactor = 1.0f;
    metal.roughnessFactor = 0.4f;
    render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {metal}));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    for (const auto distribution : {MicrofacetModel::Ggx, MicrofacetModel::Beckmann, MicrofacetModel::Phong})
        for (const auto masking : {MaskingModel::Correlated, MaskingModel::Separable, MaskingModel::Shortcut})
            for (const auto fresnel : {FresnelModel::Schlick, FresnelModel::Dielectric,
                                       FresnelModel::Conductor, FresnelModel::Lazanyi}) {
                TraceSettings settings = LookAt({60.0f, 0.0f, 80.0f}, {0, 0, 0}, 1e-4f, 16);
                settings.scattering = {.brdf = BrdfModel::Gltf,
                                       .distribution = distribution,
                                       .masking = masking,
                                       .fresnel = fresnel,
                                       .multiscatter = MultiscatterKind::Off};
                const double albedo = render.Render(settings, 32).mean.Mean().y;
                EXPECT_LT(albedo, masking == MaskingModel::Shortcut ? 1.1 : 1.005)
                    << int(distribution) << int(masking) << int(fresnel);
                EXPECT_GT(albedo, 0.8) << int(distribution) << int(masking) << int(fresnel);
            }
}

}  // namespace raygraph::testing::convergence_test
