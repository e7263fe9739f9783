// Tests that every option of Trace and of the raster view has an effect: with the same random numbers, the
// picture differs. An option must not affect anything else: without a bounce, the light of visible surfaces
// keeps its bits, and so do the first hits. convergence_test.cpp shows that options converge to one picture
// where they should.
#include <algorithm>
#include <limits>
#include <string>

#include "passes/raster.h"
#include "tests/passes/level_texture.h"
#include "tests/support/option_rows.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_options_test {

using passes::PathSettings;
using passes::TraceSettings;

namespace {

// Bound on the pixels, of 256, that may differ. Equal random numbers give equal bits, and roulette changes
// few paths.
constexpr size_t kFew = 5;

// Tells what an option changes besides the light.
enum class Moves : uint8_t { Nothing, Background, CameraRays, FirstHits };

struct Option {
    const char* name;
    void (*change)(TraceSettings&);
    bool isOfRaster = false;  // also changes the raster view
    Moves moves = Moves::Nothing;
    void (*prepare)(TraceSettings&) = nullptr;  // sets up the case in which the option has an effect
};

// Options of glTF's material.
const Option kOfScattering[] = {
    {"lambert", [](TraceSettings& s) { s.scattering.brdf = BrdfModel::Lambert; }, true},
    {"lafortune", [](TraceSettings& s) { s.scattering.brdf = BrdfModel::Lafortune; }, true},
    {"beckmann", [](TraceSettings& s) { s.scattering.distribution = MicrofacetModel::Beckmann; }, true},
    {"phong", [](TraceSettings& s) { s.scattering.distribution = MicrofacetModel::Phong; }, true},
    {"separable", [](TraceSettings& s) { s.scattering.masking = MaskingModel::Separable; }, true},
    {"shortcut", [](TraceSettings& s) { s.scattering.masking = MaskingModel::Shortcut; }, true},
    {"dielectric", [](TraceSettings& s) { s.scattering.fresnel = FresnelModel::Dielectric; }, true},
    {"conductor", [](TraceSettings& s) { s.scattering.fresnel = FresnelModel::Conductor; }, true},
    {"lazanyi", [](TraceSettings& s) { s.scattering.fresnel = FresnelModel::Lazanyi; }, true},
    {"no multiscatter", [](TraceSettings& s) { s.scattering.multiscatter = MultiscatterKind::Off; }, true},
    {"walk", [](TraceSettings& s) { s.scattering.multiscatter = MultiscatterKind::Walk; }, true},
    {"regularization", [](TraceSettings& s) { s.biases.regularize = 0.8f; }},
};

// Options of any material; tested with Lambert's, whose pipelines are made sooner.
const Option kOfPaths[] = {
    {"uniform lights", [](TraceSettings& s) { s.lights.sampler = LightSampler::Uniform; }},
    {"lights by power", [](TraceSettings& s) { s.lights.sampler = LightSampler::Power; }},
    {"light sampling", [](TraceSettings& s) { s.lights.isOn = false; }},
    {"balance", [](TraceSettings& s) { s.lights.mis = MisHeuristic::Balance; }},
    {"mis off", [](TraceSettings& s) { s.lights.mis = MisHeuristic::Off; }},
    {"constant roulette", [](TraceSettings& s) { s.roulette.kind = Roulette::Constant; }},
    {"roulette of the frame", [](TraceSettings& s) { s.roulette.kind = Roulette::Frame; }},
    {"roulette off", [](TraceSettings& s) { s.roulette.kind = Roulette::Off; }},
    {"roulette's start", [](TraceSettings& s) { s.roulette.start = 1; }},
    {"survival", [](TraceSettings& s) { s.roulette.survival = 0.3f; }, false, Moves::Nothing,
     [](TraceSettings& s) { s.roulette.kind = Roulette::Constant; }},
    {"depth", [](TraceSettings& s) { s.biases.maxDepth = 1; }},
    {"clamp", [](TraceSettings& s) { s.biases.clampIndirect = 0.01f; }},
    {"shadow terminator", [](TraceSettings& s) { s.biases.shadowTerminator = true; }},
    {"texture levels", [](TraceSettings& s) { s.biases.textureLod = 1.0f; }},
    {"hidden environment", [](TraceSettings& s) { s.isEnvironmentHidden = true; }, false, Moves::Background},
    {"seed", [](TraceSettings& s) { s.seed = 9; }, true, Moves::CameraRays},
    {"sample", [](TraceSettings& s) { s.sampleIndex = 9; }, true, Moves::CameraRays},
    {"pcg", [](TraceSettings& s) { s.sampler = SamplerKind::Pcg; }, true, Moves::CameraRays},
    {"tea", [](TraceSettings& s) { s.sampler = SamplerKind::Tea; }, true, Moves::CameraRays},
    {"camera", [](TraceSettings& s) { s.camera.origin.x += 0.1f; }, true, Moves::FirstHits},
    {"extent",
     [](TraceSettings& s) {
         s.extent = {15, 16};
     },
     true, Moves::FirstHits},
    {"region",
     [](TraceSettings& s) {
         s.region = {2, 3, 9, 8};
     },
     false, Moves::FirstHits},
};

// Structured bindings name the fields of a class or of its base, not both: a field of TraceSettings besides
// the seven, of which FieldsOf names four, makes one more initializer valid.
template <typename Settings>
concept HasEightFieldsOfItsOwn = requires {
    Settings{PathSettings{}, {}, {}, {}, {}, {}, {}, {}, {}};
}
&&!requires {
    Settings{PathSettings{}, {}, {}, {}, {}, {}, {}, {}, {}, {}};
};
static_assert(HasEightFieldsOfItsOwn<TraceSettings>);

auto FieldsOf(TraceSettings& s) {
    // These are all fields but `sampleCount`, `traversal` and `form`, which change no picture
    // (tests/cli/session_test.cpp), and `pixels` (session_adaptive_test.cpp)
    auto& [sampler, seed, scattering, lights, roulette, biases, isEnvironmentHidden] =
        static_cast<PathSettings&>(s);
    auto& [brdf, distribution, masking, fresnel, multiscatter] = scattering;
    auto& [isOn, lightSampler, mis] = lights;
    auto& [kind, start, survival] = roulette;
    auto& [maxDepth, clampIndirect, regularize, shadowTerminator, textureLod] = biases;
    return std::tie(s.extent, s.region, s.camera, sampler, seed, s.sampleIndex, brdf, distribution, masking,
                    fresnel, multiscatter, isOn, lightSampler, mis, kind, start, survival, maxDepth,
                    clampIndirect, regularize, shadowTerminator, textureLod, isEnvironmentHidden);
}

class TraceOptions : public VulkanTest {
  protected:
    TraceOptions() {
        render.more = {};  // or programs would not show what options do to them
        scene::Material metal = Lambert({0.7f, 0.5f, 0.3f});
        metal.metallicFactor = 0.6f;
        metal.roughnessFactor = 0.5f;
        scene::Material squares = metal;
        squares.baseColorTexture = {.texture = 0};
        scene::Mesh floor = QuadMesh(2.0f, 3);
        floor.primitives[0].uv0 = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        // The scene has two lamps of different brightness, so that light sampling has a choice
        scene::SceneData scene = SceneOf(
            {floor, BoxMesh(0.4f, 0), QuadMesh(0.4f, 1), QuadMesh(2.0f, 0), SphereMesh(0.5f, 4, 0),
             QuadMesh(0.3f, 2)},
            {metal, Lambert({}, glm::vec3(6.0f)), Lambert({}, {1.0f, 2.0f, 1.0f}), squares},
            {glm::mat4x3(1.0f), Translation({0.2f, -0.3f, 0.4f}), Translation({0.5f, 0.6f, 1.8f}),
             Translation({0, 0, 2.2f}), Translation({-0.7f, -0.2f, 0.6f}), Translation({-0.9f, 0.9f, 1.0f})});
        scene.images = {CheckerImage(512, 200, 250)};
        scene.textures = {{.name = "squares", .image = 0}};
        scene::Light light;
        light.intensity = 2.0f;
        light.lightToWorld = Translation({-0.8f, 0.5f, 1.0f});
        scene.lights.push_back(light);
        render.scene.SetScene(std::move(scene));
        render.scene.SetEnvironment({.radiance = glm::vec3(0.1f)});
    }
    static TraceSettings View(BrdfModel brdf) {
        TraceSettings settings = LookAt({0.0f, -1.8f, 1.5f}, {0.2f, 0.2f, 0.4f}, 1.0f, 16);
        settings.scattering.brdf = brdf;
        return settings;
    }
    FloatImage Draw(const TraceSettings& settings) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, settings, passes::FilmPosition::Center);
        const Readback readback = render.renderer.ReadBack(passes::RasterShade(
            render.renderer, ids, settings, seen, environment,
            {.shadows = passes::RasterShadows::Off, .hasOcclusion = false, .hasTransmission = false}));
        render.renderer.Execute();
        return ToFloatImage(readback);
    }
    // Returns how many pixels differ.
    static size_t Different(const FloatImage& a, const FloatImage& b) {
        if (!(a.extent == b.extent)) return std::numeric_limits<size_t>::max();
        size_t count = 0;
        for (size_t i = 0; i < a.values.size(); ++i) count += a.values[i] != b.values[i];
        return count;
    }
    struct Row {
        const Option& option;
        TraceSettings before, after;
    };
    template <typename Visit>
    static void ForEach(std::span<const Option> options, const TraceSettings& settings, Visit&& visit) {
        for (const Option& option : options) {
            SCOPED_TRACE(option.name);
            TraceSettings before = settings;
            if (option.prepare != nullptr) option.prepare(before);
            TraceSettings after = before;
            option.change(after);
            visit(Row{option, before, after});
        }
    }
    // Each picture must differ from that of the defaults, and from that of each other row.
    void ExpectEachMatters(std::span<const Option> options, const TraceSettings& settings) {
        const auto withoutBounce = [](TraceSettings seen) {
            seen.biases.maxDepth = 0;
            return seen;
        };
        const FloatImage emission = render.TraceOnce(withoutBounce(settings));
        const SceneRender::Hits hits = render.PrimaryHits(settings);
        std::vector<std::pair<const char*, FloatImage>> pictures{
            {"the defaults", render.TraceOnce(settings)}};
        ForEach(options, settings, [&](const Row& row) {
            FloatImage picture = render.TraceOnce(row.after);
            if (row.option.prepare != nullptr) {
                EXPECT_GT(Different(picture, render.TraceOnce(row.before)), kFew);
            }
            for (const auto& [name, other] : pictures)
                EXPECT_GT(Different(picture, other), kFew) << "is as " << name;
            pictures.emplace_back(row.option.name, std::move(picture));
            if (row.option.moves == Moves::FirstHits) return;
            EXPECT_EQ(render.PrimaryHits(row.after).ids, hits.ids) << "sees other surfaces";
            if (row.option.moves != Moves::Nothing) return;
            EXPECT_EQ(Different(render.TraceOnce(withoutBounce(row.after)), emission), 0u)
                << "changes what is seen without a bounce";
        });
    }
    void ExpectRasterKnows(std::span<const Option> options, const TraceSettings& settings) {
        std::vector<std::pair<const char*, FloatImage>> pictures{{"the defaults", Draw(settings)}};
        ForEach(options, settings, [&](const Row& row) {
            if (row.option.moves == Moves::FirstHits && !row.option.isOfRaster) return;
            FloatImage picture = Draw(row.after);
            if (!row.option.isOfRaster) {
                EXPECT_EQ(Different(picture, pictures[0].second), 0u) << "is of paths alone";
                return;
            }
            for (const auto& [name, other] : pictures)
                EXPECT_GT(Different(picture, other), kFew) << "is as " << name;
            pictures.emplace_back(row.option.name, std::move(picture));
        });
    }

    SceneRender render{Device(), {.textureLevels = true}};
    passes::FilteredEnvironment environment{"environment"};
};

}  // namespace

TEST_F(TraceOptions, Trace_EveryFieldAndEveryValueHasARow) {
    auto rows = OptionRowsOf<TraceSettings>([](TraceSettings& s) { return FieldsOf(s); });
    const auto add = [&](const Row& row) { rows.Add(row.option.name, row.before, row.after); };
    ForEach(kOfScattering, View(BrdfModel::Gltf), add);
    ForEach(kOfPaths, View(BrdfModel::Lambert), add);
    rows.ExpectComplete();
}

TEST_F(TraceOptions, Trace_EveryOptionOfScatteringChangesThePicture) {
    ExpectEachMatters(kOfScattering, View(BrdfModel::Gltf));
}

TEST_F(TraceOptions, Trace_EveryOptionOfPathsChangesThePicture) {
    ExpectEachMatters(kOfPaths, View(BrdfModel::Lambert));
}

TEST_F(TraceOptions, RasterShade_EveryOptionOfScatteringAndSamplingChangesThePictureAndNoOther) {
    ExpectRasterKnows(kOfScattering, View(BrdfModel::Gltf));
    ExpectRasterKnows(kOfPaths, View(BrdfModel::Lambert));
}

TEST_F(TraceOptions, Trace_EveryOutputComesWhenAskedForAndLeavesTheRadiance) {
    struct OutputRow {
        const char* name;
        passes::TraceOutputs outputs;
    };
    const OutputRow kRows[] = {{"ray counts", {.rayCounts = true}},
                               {"parts", {.parts = true}},
                               {"light groups", {.lightGroups = true}}};
    auto rows = OptionRowsOf<passes::TraceOutputs>([](passes::TraceOutputs& s) {
        auto& [rayCounts, parts, lightGroups, record] = s;
        return std::tie(rayCounts, parts, lightGroups, record);
    });
    const TraceSettings settings = View(BrdfModel::Lambert);
    const FloatImage alone = render.TraceOnce(settings);
    const auto expectSame = [&](const passes::TraceOutputs& outputs) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::TraceIds traced = passes::Trace(render.renderer, ids, settings, outputs);
        const Readback radiance = render.renderer.ReadBack(traced.radiance);
        render.renderer.Execute();
        EXPECT_EQ(Different(ToFloatImage(radiance), alone), 0u);
        EXPECT_EQ(traced.rayCounts.IsValid(), outputs.rayCounts);
        for (const TextureId part : traced.parts) EXPECT_EQ(part.IsValid(), outputs.parts);
        EXPECT_EQ(traced.lightGroups.IsValid(), outputs.lightGroups);
    };
    for (const OutputRow& row : kRows) {
        SCOPED_TRACE(row.name);
        rows.Add(row.name, {}, row.outputs);
        expectSame(row.outputs);
    }
    rows.Add("record", {}, {.record = true});  // of one path only: tests/explain
    rows.ExpectComplete();
    expectSame({.parts = true, .lightGroups = true});
}

}  // namespace raygraph::testing::trace_options_test
