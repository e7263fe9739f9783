// Every option of Trace does something: the picture of the same random numbers is another one. And it does
// nothing to what it is not about: without a bounce, light is that of what is seen, to the bit. That options
// converge to one picture, where they should, is shown by convergence_test.cpp.
#include <algorithm>
#include <string>

#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

using passes::TraceSettings;

namespace {

struct Option {
    const char* name;
    void (*change)(TraceSettings&);
    bool movesCameraRays = false;
};

// What glTF's material is made of.
const Option kOfScattering[] = {
    {"distribution", [](TraceSettings& s) { s.scattering.distribution = MicrofacetModel::Beckmann; }},
    {"masking", [](TraceSettings& s) { s.scattering.masking = MaskingModel::Separable; }},
    {"fresnel", [](TraceSettings& s) { s.scattering.fresnel = FresnelModel::Conductor; }},
    {"multiscatter", [](TraceSettings& s) { s.scattering.multiscatter = MultiscatterKind::Off; }},
    {"brdf", [](TraceSettings& s) { s.scattering.brdf = BrdfModel::Lambert; }},
    {"regularization", [](TraceSettings& s) { s.biases.regularize = 0.8f; }},
};

// What there is of any material; shown with Lambert's, whose pipelines are made sooner.
const Option kOfPaths[] = {
    {"light sampler", [](TraceSettings& s) { s.lights.sampler = LightSampler::Uniform; }},
    {"light sampling", [](TraceSettings& s) { s.lights.isOn = false; }},
    {"mis", [](TraceSettings& s) { s.lights.mis = MisHeuristic::Off; }},
    {"roulette", [](TraceSettings& s) { s.roulette.kind = Roulette::Off; }},
    {"roulette's start", [](TraceSettings& s) { s.roulette.start = 1; }},
    {"depth", [](TraceSettings& s) { s.biases.maxDepth = 1; }},
    {"clamp", [](TraceSettings& s) { s.biases.clampIndirect = 0.01f; }},
    {"seed", [](TraceSettings& s) { s.seed = 9; }, true},
    {"sample", [](TraceSettings& s) { s.sampleIndex = 9; }, true},
    {"sampler", [](TraceSettings& s) { s.sampler = SamplerKind::Pcg; }, true},
};

class TraceOptions : public VulkanTest {
  protected:
    TraceOptions() {
        scene::Material metal = Lambert({0.7f, 0.5f, 0.3f});
        metal.metallicFactor = 0.6f;
        metal.roughnessFactor = 0.5f;
        scene::SceneData scene =
            SceneOf({QuadMesh(2.0f, 0), BoxMesh(0.4f, 0), QuadMesh(0.4f, 1), QuadMesh(2.0f, 0)},
                    {metal, Lambert({}, glm::vec3(6.0f))},
                    {glm::mat4x3(1.0f), Translation({0.2f, -0.3f, 0.4f}), Translation({0.5f, 0.6f, 1.8f}),
                     Translation({0, 0, 2.2f})});
        scene::Light light;
        light.intensity = 2.0f;
        light.lightToWorld = Translation({-0.8f, 0.5f, 1.0f});
        scene.lights.push_back(light);
        render.scene.SetScene(std::move(scene));
    }
    static TraceSettings View(BrdfModel brdf) {
        TraceSettings settings = LookAt({0.0f, -1.8f, 1.5f}, {0.2f, 0.2f, 0.4f}, 1.0f, 16);
        settings.scattering.brdf = brdf;
        return settings;
    }
    // How many pixels are other ones.
    static size_t Different(const FloatImage& a, const FloatImage& b) {
        size_t count = 0;
        for (size_t i = 0; i < a.values.size(); i++) count += a.values[i] != b.values[i];
        return count;
    }
    void ExpectEachMatters(std::span<const Option> options, const TraceSettings& settings) {
        TraceSettings seen = settings;
        seen.biases.maxDepth = 0;
        const FloatImage picture = render.TraceOnce(settings), emission = render.TraceOnce(seen);
        for (const Option& option : options) {
            TraceSettings changed = settings;
            option.change(changed);
            EXPECT_GT(Different(render.TraceOnce(changed), picture), 20u) << option.name << " does nothing";
            if (option.movesCameraRays) continue;
            changed.biases.maxDepth = 0;
            EXPECT_EQ(Different(render.TraceOnce(changed), emission), 0u)
                << option.name << " changes what is seen without a bounce";
        }
    }

    SceneRender render{Device()};
};

}  // namespace

TEST_F(TraceOptions, Trace_EveryOptionOfScatteringChangesThePicture) {
    ExpectEachMatters(kOfScattering, View(BrdfModel::Gltf));
}

TEST_F(TraceOptions, Trace_EveryOptionOfPathsChangesThePicture) {
    ExpectEachMatters(kOfPaths, View(BrdfModel::Lambert));
}

TEST_F(TraceOptions, Trace_SurvivalChangesThePicture) {
    TraceSettings settings = View(BrdfModel::Lambert);
    settings.roulette = {.kind = Roulette::Constant, .start = 1, .survival = 0.9f};
    const FloatImage often = render.TraceOnce(settings);
    settings.roulette.survival = 0.3f;
    EXPECT_GT(Different(render.TraceOnce(settings), often), 20u);
}

}  // namespace raygraph::testing
