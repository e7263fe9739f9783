// Tests whole renders by the built program. It needs a device.
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <numeric>

#include "base/text.h"
#include "renderer/image/exr.h"
#include "renderer/image/image.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_render_test {
namespace {

using test::ProgramResult;
using test::RunProgram;
using test::SceneFile;

// Renders a small picture of the Cornell box, which must succeed.
ProgramResult RenderCornell(const test::TemporaryFolder& folder, const std::string& options) {
    const ProgramResult result = RunProgram(folder, "render @cornell.gltf --size 32x32 " + options);
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    return result;
}

nlohmann::json JsonOf(const std::filesystem::path& path) {
    std::ifstream file(path);
    return nlohmann::json::parse(file);
}

// Expects equal bits, also of NaN.
void ExpectSameChannels(const image::ExrImage& a, const image::ExrImage& b) {
    ASSERT_EQ(a.channels.size(), b.channels.size());
    for (size_t i = 0; i < a.channels.size(); ++i) {
        EXPECT_EQ(a.channels[i].name, b.channels[i].name);
        const auto* floats = a.FloatChannel(a.channels[i].name);
        const auto* otherFloats = b.FloatChannel(a.channels[i].name);
        if (floats == nullptr) {
            EXPECT_EQ(a.channels[i].samples, b.channels[i].samples) << a.channels[i].name;
            continue;
        }
        ASSERT_NE(otherFloats, nullptr);
        ASSERT_EQ(floats->size(), otherFloats->size());
        EXPECT_EQ(std::memcmp(floats->data(), otherFloats->data(), 4 * floats->size()), 0)
            << a.channels[i].name;
    }
}

TEST(ProgramRender, WritesEveryKindOfPictureAndTheReport) {
    const test::TemporaryFolder folder;
    const ProgramResult result =
        RenderCornell(folder, "--spp 4 --aov all -o a.png -o a.exr -o a.hdr --report r.json");
    EXPECT_EQ(result.messages, "");
    for (const char* text : {"a.png", "a.exr", "a.hdr", "r.json", "4 samples a pixel", "32x32"})
        EXPECT_NE(result.output.find(text), std::string::npos) << result.output << "lacks " << text;

    const session::RenderFile render = session::ReadRenderFile(folder / "a.exr");
    EXPECT_EQ(render.samples, (session::SampleRanges{{0, 4}}));
    EXPECT_EQ(render.sceneFile, "cornell.gltf");
    EXPECT_FALSE(render.device.empty() || render.driver.empty() || render.variance.empty());
    EXPECT_FALSE(render.albedo.empty() || render.normal.empty() || render.depth.empty());
    for (const session::Texels& part : render.parts) EXPECT_EQ(part.size(), render.radiance.size());
    const double sum = std::accumulate(render.radiance.begin(), render.radiance.end(), 0.0);
    EXPECT_GT(sum, 0.0);
    // The box fills the picture's middle: the depth there is finite and positive
    const size_t middle = 16 * 32 + 16;
    EXPECT_GT(render.depth[middle], 0.0f);
    EXPECT_LT(render.instance[middle], 100u);
    const glm::vec3 normal(render.normal[4 * middle], render.normal[4 * middle + 1],
                           render.normal[4 * middle + 2]);
    EXPECT_NEAR(glm::length(normal), 1.0f, 0.5f);

    const image::Environment hdr = image::ReadEnvironment(folder / "a.hdr");
    const float brightest = *std::max_element(render.radiance.begin(), render.radiance.end());
    for (size_t i = 0; i < render.radiance.size(); i += 4)
        EXPECT_NEAR(hdr.image.rgba[i], render.radiance[i], 0.01f * brightest);

    const nlohmann::json report = JsonOf(folder / "r.json");
    EXPECT_EQ(report.at("samples"), 4);
    EXPECT_EQ(report.at("scene").at("triangles_placed"), report.at("scene").at("triangles_unique"));
    EXPECT_GT(report.at("throughput").at("msamples_per_s").get<double>(), 0.0);
    EXPECT_GT(report.at("throughput").at("rays_per_sample").get<double>(), 1.0);
    EXPECT_GT(report.at("memory").at("device_peak_bytes").get<uint64_t>(), 32u * 32 * 16);
    EXPECT_GT(report.at("image").at("relative_error").get<double>(), 0.0);
    EXPECT_EQ(report.at("image").at("nonfinite_samples"), 0);
    const auto& passes = report.at("passes");
    const auto trace = std::find_if(passes.begin(), passes.end(), [](const auto& pass) {
        const std::string name = pass.at("name");  // depends on the form
        return name == "Trace" || name == "WaveFirst";
    });
    ASSERT_NE(trace, passes.end()) << passes.dump();
    EXPECT_GE(trace->at("count"), 1);
    EXPECT_LE(trace->at("count"), 4) << "samples may be traced several at once";
    EXPECT_GT(trace->at("gpu_ms_median").get<double>(), 0.0);
}

TEST(ProgramRender, ResumedEqualsUninterruptedBitForBit) {
    const test::TemporaryFolder folder;
    const std::string options = "--aov all --seed 5 --sample-offset 3";
    RenderCornell(folder, options + " --spp 3 -o part.exr");
    RenderCornell(folder, options + " --spp 9 -o whole.exr");
    const ProgramResult resumed =
        RunProgram(folder, "render @cornell.gltf --resume part.exr --spp 9 -o resumed.exr");
    EXPECT_EQ(resumed.exitCode, 0) << resumed.messages;
    EXPECT_NE(resumed.output.find("6 of them new"), std::string::npos) << resumed.output;
    ExpectSameChannels(image::ReadExr(folder / "resumed.exr"), image::ReadExr(folder / "whole.exr"));
    EXPECT_EQ(session::ReadRenderFile(folder / "resumed.exr").samples, (session::SampleRanges{{3, 9}}));
}

TEST(ProgramRender, ResumeWithoutOutputReplacesTheFile) {
    const test::TemporaryFolder folder;
    RenderCornell(folder, "--spp 2 -o a.exr");
    const ProgramResult resumed = RunProgram(folder, "render @cornell.gltf --resume a.exr --spp 4");
    EXPECT_EQ(resumed.exitCode, 0) << resumed.messages;
    EXPECT_EQ(session::ReadRenderFile(folder / "a.exr").samples, (session::SampleRanges{{0, 4}}));
}

TEST(ProgramRender, ResumeRefusesAnotherScene) {
    const test::TemporaryFolder folder;
    RenderCornell(folder, "--spp 2 -o a.exr");
    const ProgramResult resumed = RunProgram(folder, "render @furnace_sphere.gltf --resume a.exr --spp 4");
    EXPECT_EQ(resumed.exitCode, 4);
    EXPECT_NE(resumed.messages.find("scene: cornell.gltf against furnace_sphere.gltf"), std::string::npos)
        << resumed.messages;
    EXPECT_EQ(session::ReadRenderFile(folder / "a.exr").samples, (session::SampleRanges{{0, 2}}));
}

// With a lens, biases, parts and groups of lights, the files have every kind of channel.
TEST(ProgramRender, MergedPartsAndResumedOnesHaveTheBitsOfOneRun) {
    const test::TemporaryFolder folder;
    const std::string options = "--aov all --light-group lamp=la* --aperture 0.01 --max-depth 2";
    const auto render = [&](int first, int count, const char* name) {
        RenderCornell(folder, Text("{} --sample-offset {} --spp {} -o {}", options, first, count, name));
    };
    render(12, 1, "a.exr");
    render(13, 2, "b.exr");
    render(15, 5, "c.exr");
    render(12, 8, "whole.exr");
    const image::ExrImage whole = image::ReadExr(folder / "whole.exr");
    for (const char* parts : {"a.exr b.exr c.exr", "c.exr b.exr a.exr"}) {
        const ProgramResult result = RunProgram(folder, Text("merge {} -o m.exr", parts));
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        ExpectSameChannels(image::ReadExr(folder / "m.exr"), whole);
    }
    for (const int total : {3, 8}) {
        const ProgramResult resumed =
            RunProgram(folder, Text("render @cornell.gltf --resume a.exr --spp {}", total));
        EXPECT_EQ(resumed.exitCode, 0) << resumed.messages;
    }
    ExpectSameChannels(image::ReadExr(folder / "a.exr"), whole);
}

TEST(ProgramRender, AnotherSeedIsAnotherPictureAndTheSameSeedTheSame) {
    const test::TemporaryFolder folder;
    RenderCornell(folder, "--spp 2 -o a.exr");
    RenderCornell(folder, "--spp 2 -o b.exr");
    RenderCornell(folder, "--spp 2 --seed 1 -o c.exr");
    const session::RenderFile a = session::ReadRenderFile(folder / "a.exr");
    ExpectSameChannels(image::ReadExr(folder / "a.exr"), image::ReadExr(folder / "b.exr"));
    EXPECT_NE(a.radiance, session::ReadRenderFile(folder / "c.exr").radiance);
}

TEST(ProgramRender, ViewsWithoutLightAreRendered) {
    const test::TemporaryFolder folder;
    for (const std::string view :
         {"albedo", "normals", "depth", "instance", "material", "wireframe", "overdraw", "ray-cost"}) {
        const std::filesystem::path png = folder / (view + ".png"), exr = folder / (view + ".exr");
        const bool isSingle = view == "depth" || view == "instance" || view == "material";
        RenderCornell(folder, Text("--view {0} -o {0}.png -o {0}.exr {1}", view, isSingle ? "" : "--spp 2"));
        std::ifstream file(png, std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(file), {}};
        const image::Image8 picture = image::DecodeImage8(std::as_bytes(std::span(bytes)), view);
        EXPECT_EQ(picture.width, 32u);
        EXPECT_GT(std::ranges::count_if(picture.rgba, [](uint8_t v) { return v != 0 && v != 255; }), 500)
            << view;
        EXPECT_TRUE(session::HasSums(session::ReadRenderFile(exr))) << view;
    }
}

TEST(ProgramRender, RasterViewIsDirectLightWithTheShadowsAskedFor) {
    const test::TemporaryFolder folder;
    RenderCornell(folder,
                  "--view raster --shadows off --validate --spp 8 -o drawn.exr -o drawn.png --report r.json");
    RenderCornell(folder, "--max-depth 1 --spp 32 -o traced.exr");
    const session::Texels drawn = session::ReadRenderFile(folder / "drawn.exr").radiance;
    const session::Texels traced = session::ReadRenderFile(folder / "traced.exr").radiance;
    double drawnSum = 0.0, tracedSum = 0.0;
    for (size_t i = 0; i < drawn.size(); i += 4) {
        drawnSum += drawn[i];
        tracedSum += traced[i];
    }
    EXPECT_GT(drawnSum, tracedSum) << "which has shadows";
    EXPECT_LT(drawnSum, 1.3 * tracedSum);
    RenderCornell(folder, "--view raster --spp 32 -o rays.exr");
    const session::Texels rays = session::ReadRenderFile(folder / "rays.exr").radiance;
    double raysSum = 0.0;
    for (size_t i = 0; i < rays.size(); i += 4) raysSum += rays[i];
    EXPECT_NEAR(raysSum, tracedSum, 0.03 * tracedSum);
}

TEST(ProgramRender, TimeLimitEndsTheRender) {
    const test::TemporaryFolder folder;
    RenderCornell(folder, "--time 0.5 -o a.exr --report r.json");
    const nlohmann::json report = JsonOf(folder / "r.json");
    EXPECT_GE(report.at("samples").get<int>(), 1);
    EXPECT_FALSE(report.at("stopped"));
    const double first = report.at("timings_ms").at("first_sample"),
                 all = report.at("timings_ms").at("render");
    EXPECT_GE(std::max(first, all), 500.0);
}

// Runs a render that would take hours, and sends `signal` once it shows its progress.
ProgramResult RenderUntil(const test::TemporaryFolder& folder, int signal, const std::string& options) {
    bool isSent = false;
    return test::RunProgramOnTerminal(folder, "render @cornell.gltf --size 64x64 --spp 100000000 " + options,
                                      [&](pid_t process, const std::string& shown) {
                                          if (isSent || shown.find("/100000000 samples") == std::string::npos)
                                              return;
                                          isSent = true;
                                          kill(process, signal);
                                      });
}

TEST(ProgramRender, InterruptWritesWhatThereIsAndSaysSo) {
    const test::TemporaryFolder folder;
    const ProgramResult result = RenderUntil(folder, SIGINT, "-o a.exr -o a.png");
    EXPECT_EQ(result.exitCode, 0) << result.output;
    EXPECT_NE(result.output.find("stopped after "), std::string::npos) << result.output;
    const uint64_t samples = session::SampleCount(session::ReadRenderFile(folder / "a.exr").samples);
    EXPECT_GE(samples, 1u);
    EXPECT_NE(result.output.find("stopped after " + std::to_string(samples) + " of 100000000"),
              std::string::npos)
        << result.output;
    EXPECT_TRUE(std::filesystem::exists(folder / "a.png"));
}

TEST(ProgramRender, AKilledRenderLeavesTheOldFile) {
    const test::TemporaryFolder folder;
    std::ofstream(folder / "a.png") << "old";
    const ProgramResult result = RenderUntil(folder, SIGKILL, "-o a.png");
    EXPECT_EQ(result.exitCode, -1);
    EXPECT_EQ(std::filesystem::file_size(folder / "a.png"), 3u);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.Path()), {}), 1);
}

TEST(ProgramRender, ProgressIsOneLineAndQuietIsSilent) {
    const test::TemporaryFolder folder;
    const std::string line = "render @cornell.gltf --size 32x32 --spp 4 -o a.png";
    const ProgramResult shown = test::RunProgramOnTerminal(folder, line, [](pid_t, const std::string&) {});
    EXPECT_EQ(shown.exitCode, 0);
    EXPECT_NE(shown.output.find("compiling shaders"), std::string::npos) << shown.output;
    EXPECT_EQ(shown.output.find('\x1b'), std::string::npos) << "an escape sequence";
    // Two lines remain: the file and the summary
    EXPECT_EQ(std::ranges::count(shown.output, '\n'), 2) << shown.output;

    const ProgramResult quiet =
        test::RunProgramOnTerminal(folder, line + " --quiet", [](pid_t, const std::string&) {});
    EXPECT_EQ(quiet.exitCode, 0);
    EXPECT_EQ(quiet.output, "");
}

TEST(ProgramRender, ValidationFindsNothing) {
    const test::TemporaryFolder folder;
    RenderCornell(folder, "--validate --spp 3 --aov all -o a.png -o a.exr --report r.json");
}

TEST(ProgramRender, ADeviceThatDoesNotExistIsThree) {
    const test::TemporaryFolder folder;
    const ProgramResult result =
        RunProgram(folder, "render @cornell.gltf -o a.png --device 'no such device'");
    EXPECT_EQ(result.exitCode, 3) << result.messages;
    EXPECT_NE(result.messages.find("no such device"), std::string::npos) << result.messages;
}

TEST(ProgramRender, ACameraThatDoesNotExistIsTwo) {
    const test::TemporaryFolder folder;
    const ProgramResult result =
        RunProgram(folder, "render @cornell.gltf -o a.png --camera 'no such camera'");
    EXPECT_EQ(result.exitCode, 2) << result.messages;
    EXPECT_NE(result.messages.find("no such camera"), std::string::npos) << result.messages;
}

// One white triangle and nothing else.
constexpr const char* kTriangle = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
 "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [-1, -1, 0], "max": [1, 1, 0]}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "buffers": [{"byteLength": 36, "uri":
  "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}]})";

TEST(ProgramRender, DarknessIsWarnedOfUnlessThereIsLight) {
    const test::TemporaryFolder folder;
    std::ofstream(folder / "triangle.gltf") << kTriangle;
    const std::string line = "render triangle.gltf --size 8x8 --spp 1 -o a.exr";
    const ProgramResult dark = RunProgram(folder, line + " --light none");
    EXPECT_EQ(dark.exitCode, 0) << dark.messages;
    EXPECT_NE(dark.messages.find("nothing emits light"), std::string::npos) << dark.messages;

    const ProgramResult lit = RunProgram(folder, line + " --background 1,2,3");
    EXPECT_EQ(lit.exitCode, 0) << lit.messages;
    EXPECT_EQ(lit.messages, "");
    // The corners see past the triangle
    const session::Texels radiance = session::ReadRenderFile(folder / "a.exr").radiance;
    EXPECT_EQ((session::Texels(radiance.begin(), radiance.begin() + 4)), (session::Texels{1, 2, 3, 0}));
}

TEST(ProgramRender, ResumeRefusesAMaterialThatHasChanged) {
    const test::TemporaryFolder folder;
    const auto write = [&](const std::string& ior) {
        std::string text = kTriangle;
        text.insert(1, R"("materials": [{"extensions": {"KHR_materials_ior": {"ior": )" + ior + "}}}],");
        text.insert(1, R"("extensionsUsed": ["KHR_materials_ior"],)");
        text.replace(text.find(R"({"POSITION": 0})"), 15, R"({"POSITION": 0}, "material": 0)");
        std::ofstream(folder / "triangle.gltf") << text;
    };
    const std::string line = "render triangle.gltf --background 1,2,3";
    write("1.5");
    const ProgramResult first = RunProgram(folder, line + " --size 8x8 --spp 1 -o a.exr");
    EXPECT_EQ(first.exitCode, 0) << first.messages;
    write("1.1");
    const ProgramResult resumed = RunProgram(folder, line + " --resume a.exr --spp 2");
    EXPECT_EQ(resumed.exitCode, 4);
    EXPECT_NE(resumed.messages.find("the content of triangle.gltf has changed"), std::string::npos)
        << resumed.messages;
}

TEST(ProgramRender, TheEnvironmentMapIsRecordedAndAskedForAgain) {
    const test::TemporaryFolder folder;
    std::ofstream(folder / "triangle.gltf") << kTriangle;
    image::ImageF sky{8, 4, std::vector<float>(8 * 4 * 4, 0.5f)};
    image::WriteHdr(folder / "sky.hdr", sky);
    const std::string line = "render triangle.gltf --env sky.hdr";
    const ProgramResult first = RunProgram(folder, line + " --size 8x8 --spp 1 -o a.exr");
    EXPECT_EQ(first.exitCode, 0) << first.messages;
    const session::RenderFile render = session::ReadRenderFile(folder / "a.exr");
    EXPECT_EQ(render.environmentFile, "sky.hdr");
    EXPECT_NEAR(render.radiance[0], 0.5f, 0.01f);

    const ProgramResult without = RunProgram(folder, "render triangle.gltf --resume a.exr --spp 2");
    EXPECT_EQ(without.exitCode, 4);
    EXPECT_NE(without.messages.find("environment: sky.hdr against none"), std::string::npos)
        << without.messages;
    const ProgramResult with = RunProgram(folder, line + " --resume a.exr --spp 2");
    EXPECT_EQ(with.exitCode, 0) << with.messages;
    sky.rgba[4] = 3.0f;
    image::WriteHdr(folder / "sky.hdr", sky);
    const ProgramResult changed = RunProgram(folder, line + " --resume a.exr --spp 3");
    EXPECT_EQ(changed.exitCode, 4);
    EXPECT_NE(changed.messages.find("sky.hdr has changed"), std::string::npos) << changed.messages;
}

TEST(ProgramGraph, ShowsThePassesOfAFrame) {
    const test::TemporaryFolder folder;
    const ProgramResult later = RunProgram(folder, "graph @cornell.gltf --size 16x16");
    ASSERT_EQ(later.exitCode, 0) << later.messages;
    for (const char* pass : {"Trace", "Accumulate", "Tonemap"})
        EXPECT_NE(later.output.find(pass), std::string::npos) << later.output << "lacks " << pass;
    EXPECT_EQ(later.output.find("UploadWideNodes"), std::string::npos) << later.output;
    const ProgramResult first = RunProgram(folder, "graph @cornell.gltf --first --dot");
    ASSERT_EQ(first.exitCode, 0) << first.messages;
    EXPECT_EQ(first.output.find("digraph"), 0u) << first.output;
    EXPECT_NE(first.output.find("UploadInstances"), std::string::npos) << first.output;
}

TEST(ProgramInfo, ListsTheDevices) {
    const ProgramResult result = RunProgram(test::TemporaryFolder(), "info --devices");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_NE(result.output.find("suitable  yes"), std::string::npos) << result.output;
}

}  // namespace
}  // namespace raygraph::program_render_test
