// Tests whole renders by the built program. It needs a device.
#include <signal.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <glm/glm.hpp>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>

#include "base/files.h"
#include "base/text.h"
#include "editor/session/file/render_file.h"
#include "editor/session/file/render_file_parts.h"
#include "passes/tonemap.h"
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
    const ProgramResult result = RenderCornell(
        folder, "--validate --spp 4 --aov all -o a.png -o a.jpg -o a.exr -o a.hdr --report r.json");
    EXPECT_EQ(result.messages, "");
    for (const char* text : {"a.png", "a.jpg", "a.exr", "a.hdr", "r.json", "4 samples a pixel", "32x32"})
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

    const auto read = [&](const char* name) { return image::DecodeImage8(ReadFile(folder / name), name); };
    const image::Image8 png = read("a.png"), jpg = read("a.jpg");
    ASSERT_EQ(jpg.rgba.size(), png.rgba.size());
    double difference = 0.0;
    for (size_t i = 0; i < png.rgba.size(); ++i) difference += std::abs(int{png.rgba[i]} - int{jpg.rgba[i]});
    EXPECT_LT(difference / static_cast<double>(png.rgba.size()), 4.0);

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

TEST(ProgramRender, ResumeRefusesAnotherScene) {
    const test::TemporaryFolder folder;
    RenderCornell(folder, "--brdf lambert --nee off --spp 2 -o a.exr");
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
        const std::string added = Text("{} of them new", total == 3 ? 2 : 5);
        EXPECT_NE(resumed.output.find(added), std::string::npos) << resumed.output;
    }
    EXPECT_EQ(session::ReadRenderFile(folder / "a.exr").samples, (session::SampleRanges{{12, 8}}));
    ExpectSameChannels(image::ReadExr(folder / "a.exr"), whole);
}

TEST(ProgramRender, ViewsWithoutLightAreRendered) {
    const test::TemporaryFolder folder;
    for (const std::string view :
         {"normals", "depth", "instance", "material", "overdraw", "ray-cost", "path-length"}) {
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

TEST(ProgramRender, RasterViewIsDirectLight) {
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
}

TEST(ProgramRender, TimeLimitEndsTheRender) {
    const test::TemporaryFolder folder;
    RenderCornell(folder, "--time 0.3 -o a.exr --report r.json");
    const nlohmann::json report = JsonOf(folder / "r.json");
    EXPECT_GE(report.at("samples").get<int>(), 1);
    EXPECT_FALSE(report.at("stopped"));
    const double first = report.at("timings_ms").at("first_sample"),
                 all = report.at("timings_ms").at("render");
    EXPECT_GE(std::max(first, all), 300.0);
}

// Runs a render that would take hours, and sends `signal` once it shows its progress.
ProgramResult RenderUntil(const test::TemporaryFolder& folder, int signal, const std::string& options) {
    bool isSent = false;
    return test::RunProgramOnTerminal(
        folder, "render @cornell.gltf --view albedo --size 64x64 --spp 100000000 " + options,
        [&](pid_t process, const std::string& shown) {
            if (isSent || shown.find("/100000000 samples") == std::string::npos) return;
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
    const std::string line = "render @cornell.gltf --view albedo --size 32x32 --spp 4 -o a.png";
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

TEST(ProgramExplain, ARendersNoiseIsPrintedWithTheCommandForItsFirstPixel) {
    const test::TemporaryFolder folder;
    const ProgramResult rendered = RunProgram(
        folder, "render @cornell.gltf --size 16x16 --spp 4 --light-group lamp=lamp* -o p.exr --quiet");
    ASSERT_EQ(rendered.exitCode, 0) << rendered.messages;
    const ProgramResult said =
        RunProgram(folder, "explain p.exr --noise-map noise.png --group-map groups.png");
    ASSERT_EQ(said.exitCode, 0) << said.messages;
    EXPECT_THAT(said.output, ::testing::HasSubstr("light: lamp 100 %\n"));
    EXPECT_THAT(said.output,
                ::testing::HasSubstr("raygraph explain FOLDER/cornell.gltf --settings-from p.exr --pixel "));
    for (const char* map : {"noise.png", "groups.png"})
        EXPECT_EQ(image::DecodeImage8(ReadFile(folder / map), map).width, 16u);
    const ProgramResult pixel =
        RunProgram(folder, "explain @cornell.gltf --settings-from p.exr --pixel 8,12");
    EXPECT_THAT(pixel.output, ::testing::HasSubstr("of 4 samples")) << "those of the render";
    const ProgramResult compared = RunProgram(folder, "compare p.exr p.exr");
    EXPECT_THAT(compared.messages, ::testing::HasSubstr("samples of the same seed"));
    EXPECT_EQ(compared.output.find("rms"), std::string::npos) << compared.output;
    EXPECT_EQ(RunProgram(folder, "explain p.exr --pixel 1,1").exitCode, 2);
    EXPECT_EQ(RunProgram(folder, "explain @cornell.gltf").exitCode, 2);
    EXPECT_EQ(RunProgram(folder, "explain @cornell.gltf --pixel 1,1 --noise-map n.png").exitCode, 2);
}

}  // namespace
}  // namespace raygraph::program_render_test

// Tests --crop: a part of a picture has the same bits as in the whole, in every channel. It needs a device.
namespace raygraph::program_crop_test {
namespace {

using test::ProgramResult;
using test::RunProgram;

// Position and size are odd, and no multiple of any kind of tile.
constexpr passes::Region kCrop{7, 5, 13, 9};
constexpr const char* kCropOption = " --crop 7,5,13,9";

void Render(const test::TemporaryFolder& folder, const std::string& options) {
    const ProgramResult result = RunProgram(folder, "render " + options);
    EXPECT_EQ(result.exitCode, 0) << result.messages;
}

// A channel with words of sums, which a file omits if they are 0 in all of its pixels.
bool IsOfSums(const image::ExrChannel& channel) {
    return channel.name.find("sum") != std::string::npos || channel.name.find("squares") != std::string::npos;
}

// Expects that every sum of `part` equals the one at its place in `whole`.
void ExpectSumsOf(session::RenderFile&& whole, session::RenderFile&& part, const passes::Region& crop) {
    const std::vector<passes::ExactSums*> inWhole = session::AllOf(whole.sums),
                                          inPart = session::AllOf(part.sums);
    ASSERT_EQ(inPart.size(), inWhole.size());
    size_t different = 0, compared = 0;
    for (size_t i = 0; i < inPart.size(); ++i) {
        ASSERT_EQ(inPart[i]->IsEmpty(), inWhole[i]->IsEmpty());
        ASSERT_EQ(inPart[i]->HasSquares(), inWhole[i]->HasSquares());
        for (const auto planes : {&passes::ExactSums::sums, &passes::ExactSums::squares})
            for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k) {
                const passes::ExactSums::Plane &some = (inPart[i]->*planes)[k],
                                               &all = (inWhole[i]->*planes)[k];
                for (size_t y = 0; !some.empty() && y < crop.height; ++y, ++compared)
                    different += std::memcmp(&some[4 * y * crop.width],
                                             &all[4 * ((y + crop.y) * whole.size.width + crop.x)],
                                             16 * crop.width) != 0;
            }
    }
    EXPECT_EQ(different, 0u) << "rows of sums";
    EXPECT_GT(compared, 0u);
}

// Expects that every other channel of `part` has the bits at its place in `whole`.
void ExpectPartOf(const image::ExrImage& whole, const image::ExrImage& part, const passes::Region& crop) {
    ASSERT_EQ(part.width, crop.width);
    ASSERT_EQ(part.height, crop.height);
    EXPECT_EQ(part.window, (image::ExrWindow{static_cast<int32_t>(crop.x), static_cast<int32_t>(crop.y),
                                             whole.width, whole.height}));
    EXPECT_EQ(whole.window, (image::ExrWindow{0, 0, whole.width, whole.height}));
    std::vector<image::ExrChannel> ofWhole, ofPart;
    std::ranges::copy_if(whole.channels, std::back_inserter(ofWhole), std::not_fn(IsOfSums));
    std::ranges::copy_if(part.channels, std::back_inserter(ofPart), std::not_fn(IsOfSums));
    ASSERT_EQ(ofPart.size(), ofWhole.size());
    for (size_t i = 0; i < ofPart.size(); ++i) {
        const image::ExrChannel &inPart = ofPart[i], &inWhole = ofWhole[i];
        ASSERT_EQ(inPart.name, inWhole.name);
        std::visit(
            [&](const auto& samples) {
                const auto& all = std::get<std::decay_t<decltype(samples)>>(inWhole.samples);
                size_t different = 0;
                for (size_t y = 0; y < crop.height; ++y)
                    different += std::memcmp(&samples[y * crop.width],
                                             &all[(y + crop.y) * whole.width + crop.x], 4 * crop.width) != 0;
                EXPECT_EQ(different, 0u) << "rows of " << inPart.name;
            },
            inPart.samples);
    }
}

// Renders the whole and the part with the options, and compares them.
void ExpectPartOfWhole(const std::string& options, const passes::Region& crop = kCrop) {
    SCOPED_TRACE(options);
    const test::TemporaryFolder folder;
    test::WriteBox(folder);
    const std::string common = options + " --size 30x21 --quiet -o ";
    Render(folder, common + "whole.exr");
    Render(folder, common + Text("part.exr --crop {},{},{},{}", crop.x, crop.y, crop.width, crop.height));
    const image::ExrImage whole = image::ReadExr(folder / "whole.exr");
    ASSERT_GT(whole.channels.size(), 4u);
    ExpectPartOf(whole, image::ReadExr(folder / "part.exr"), crop);
    if (std::ranges::any_of(whole.channels, IsOfSums))
        ExpectSumsOf(session::ReadRenderFile(folder / "whole.exr"),
                     session::ReadRenderFile(folder / "part.exr"), crop);
}

TEST(ProgramCrop, EveryChannelHasTheBitsOfTheWhole) {
    ExpectPartOfWhole(
        "@many_lights.gltf --spp 3 --aov all --light-group 'first=light [0-3]' --light-group shards=shards "
        "--sampler pcg --max-depth 3 --clamp-indirect 0.5 --aperture 0.1");
    ExpectPartOfWhole(
        "@points_and_lines.gltf --spp 2 --points 1% --lines 0.5% --background 1,1,1 --texture-lod 0");
}

TEST(ProgramCrop, MotionHasTheBitsOfTheWhole) {
    ExpectPartOfWhole("box.gltf --spp 2 --at 0 --shutter 0:0.5 --aov motion,depth");
}

TEST(ProgramCrop, ItMayBeOnePixelInACornerOrTheWhole) {
    ExpectPartOfWhole("@cornell.gltf --spp 2 --view albedo", {29, 20, 1, 1});
    ExpectPartOfWhole("@cornell.gltf --spp 2 --view albedo", {0, 0, 30, 21});
}

TEST(ProgramCrop, ViewsByRaysHaveTheBitsOfTheWhole) {
    for (const char* view : {"wireframe --spp 2", "ray-cost --spp 2", "depth"})
        ExpectPartOfWhole(std::string("@cornell.gltf --view ") + view);
}

TEST(ProgramCrop, PicturesForTheEyeHoldThePartAlone) {
    const test::TemporaryFolder folder;
    Render(folder, "@cornell.gltf --size 30x21 --spp 1 -o whole.png -o whole.hdr");
    Render(folder, std::string("@cornell.gltf --size 30x21 --spp 1 -o part.png -o part.hdr") + kCropOption);
    const auto expectPart = [&](const auto& whole, const auto& part) {
        ASSERT_EQ(part.width, kCrop.width);
        ASSERT_EQ(part.height, kCrop.height);
        for (uint32_t y = 0; y < kCrop.height; ++y)
            for (uint32_t i = 0; i < 4 * kCrop.width; ++i)
                ASSERT_EQ(part.rgba[4 * y * kCrop.width + i],
                          whole.rgba[4 * ((y + kCrop.y) * whole.width + kCrop.x) + i]);
    };
    const auto read = [&](const char* name) { return image::DecodeImage8(ReadFile(folder / name), name); };
    expectPart(read("whole.png"), read("part.png"));
    expectPart(image::ReadEnvironment(folder / "whole.hdr").image,
               image::ReadEnvironment(folder / "part.hdr").image);
}

TEST(ProgramCrop, AsAMapItStandsWhereItBelongs) {
    const test::TemporaryFolder folder;
    const std::string scene = "@cornell.gltf --size 30x21 --spp 2 --view albedo --quiet -o ";
    Render(folder, scene + "whole.exr");
    Render(folder, scene + "part.exr" + kCropOption);
    const image::ImageF whole = image::ReadEnvironment(folder / "whole.exr").image;
    const image::ImageF part = image::ReadEnvironment(folder / "part.exr").image;
    ASSERT_EQ(part.width, 30u);
    ASSERT_EQ(part.height, 21u);
    for (uint32_t i = 0; i < 30 * 21; ++i) {
        const uint32_t x = i % 30, y = i / 30;
        const bool isInside =
            x >= kCrop.x && x < kCrop.x + kCrop.width && y >= kCrop.y && y < kCrop.y + kCrop.height;
        for (uint32_t c = 0; c < 3; ++c)
            ASSERT_EQ(part.rgba[4 * i + c], isInside ? whole.rgba[4 * i + c] : 0.0f) << x << ", " << y;
    }
    Render(folder, "@cornell.gltf --size 8x8 --spp 1 --quiet --env part.exr -o lit.exr");
}

TEST(ProgramCrop, ItIsRecordedResumedAndMerged) {
    const test::TemporaryFolder folder;
    const std::string scene = "@cornell.gltf --brdf lambert --nee off --quiet ";
    const std::string cropped = scene + "--size 30x21" + kCropOption;
    Render(folder, cropped + " --spp 3 -o a.exr");
    Render(folder, cropped + " --spp 8 -o all.exr");
    Render(folder, "@cornell.gltf --resume a.exr --spp 8 --quiet -o resumed.exr");
    Render(folder, cropped + " --spp 5 --sample-offset 3 -o b.exr");
    ASSERT_EQ(RunProgram(folder, "merge a.exr b.exr -o merged.exr").exitCode, 0);
    const image::ExrImage all = image::ReadExr(folder / "all.exr");
    for (const char* name : {"resumed.exr", "merged.exr"}) {
        SCOPED_TRACE(name);
        const image::ExrImage other = image::ReadExr(folder / name);
        EXPECT_EQ(other.window, all.window);
        ASSERT_EQ(other.channels.size(), all.channels.size());
        for (size_t i = 0; i < all.channels.size(); ++i)
            EXPECT_EQ(other.channels[i].samples, all.channels[i].samples) << all.channels[i].name;
    }
    EXPECT_EQ(session::ReadRenderFile(folder / "merged.exr").settings.at("crop"), "7,5,13,9");

    // A crop of the same size elsewhere
    Render(folder, scene + "--size 30x21 --crop 8,5,13,9 --spp 5 --sample-offset 3 -o c.exr");
    const ProgramResult merge = RunProgram(folder, "merge a.exr c.exr -o x.exr");
    EXPECT_EQ(merge.exitCode, 4);
    EXPECT_EQ(merge.messages, "raygraph: a.exr and c.exr differ: crop: 7,5,13,9 against 8,5,13,9\n");
    const ProgramResult resume =
        RunProgram(folder, "render @cornell.gltf --resume a.exr --spp 8 --crop 8,5,13,9");
    EXPECT_EQ(resume.exitCode, 2);
    EXPECT_EQ(resume.messages, "raygraph: --crop 8,5,13,9: a.exr was rendered with 7,5,13,9\n");
}

}  // namespace
}  // namespace raygraph::program_crop_test

// Tests --white-point, --transparent, --exr-type and --settings-from by whole renders. It needs a device.
namespace raygraph::program_display_test {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::RunProgram;

void Render(const test::TemporaryFolder& folder, const std::string& options) {
    const ProgramResult result = RunProgram(folder, "render " + options);
    EXPECT_EQ(result.exitCode, 0) << result.messages;
}

image::Image8 Picture(const test::TemporaryFolder& folder, const char* name) {
    return image::DecodeImage8(ReadFile(folder / name), name);
}

// Returns the largest difference between red, green and blue of a pixel.
int Tint(const image::Image8& picture) {
    int tint = 0;
    for (size_t i = 0; i < picture.rgba.size(); i += 4) {
        const auto [least, most] = std::minmax({picture.rgba[i], picture.rgba[i + 1], picture.rgba[i + 2]});
        tint = std::max(tint, most - least);
    }
    return tint;
}

// Returns a color of luminance 1 with the chromaticity of a black body, which WhiteBalance turns white.
glm::dvec3 LightOf(double kelvin) {
    const glm::dmat3 balance(passes::WhiteBalance(passes::WhitePointAt(kelvin)));
    return glm::inverse(balance) * glm::dvec3(1.0);
}

TEST(ProgramDisplay, GrayUnderAWarmLightIsShownNeutral) {
    const test::TemporaryFolder folder;
    const glm::dvec3 light = LightOf(2856.0);
    EXPECT_GT(light.x, 2.0 * light.z);
    const std::string gray =
        Text("@furnace_sphere.gltf --size 16x16 --spp 4 --brdf lambert --exposure -2 --background {},{},{} ",
             light.x, light.y, light.z);
    Render(folder, gray + "-o plain.png");
    Render(folder, gray + "-o a.png --white-point 2856");
    Render(folder, gray + "-o auto.png --white-point auto --report auto.json");
    EXPECT_EQ(json::parse(std::ifstream(folder / "auto.json"))["settings"]["white-point"], "auto");
    EXPECT_GT(Tint(Picture(folder, "plain.png")), 40);
    EXPECT_LE(Tint(Picture(folder, "a.png")), 1);
    EXPECT_LE(Tint(Picture(folder, "auto.png")), 1);
    const image::Image8 balanced = Picture(folder, "a.png");
    EXPECT_GT(*std::min_element(balanced.rgba.begin(), balanced.rgba.end()), 60) << "not black";
}

// Writes an unlit square of one color in the middle of the picture, which covers half of the pixels at its
// edge.
void WriteSquare(const test::TemporaryFolder& folder) {
    json scene = json::parse(std::ifstream(test::SceneFile("furnace_sphere.gltf")));
    for (json& material : scene["materials"]) {
        material["pbrMetallicRoughness"] = {{"baseColorFactor", json::array({0.8, 0.4, 0.1, 1.0})}};
        material["extensions"] = {{"KHR_materials_unlit", json::object()}};
    }
    scene["extensionsUsed"] = json::array({"KHR_materials_unlit"});
    std::ofstream(folder / "square.gltf") << scene;
}

TEST(ProgramDisplay, TransparentPicturesHoldWhatAlphaCovers) {
    const test::TemporaryFolder folder;
    WriteSquare(folder);
    const std::string ball = "square.gltf --size 24x24 --spp 16 --tonemap srgb ";
    Render(folder, ball + "--background 0.5,0.7,1 --aov emission --transparent on -o ball.png -o ball.exr");
    Render(folder, ball + "--background 0.5,0.7,1 -o opaque.png -o opaque.exr");
    const image::Image8 picture = Picture(folder, "ball.png"), opaque = Picture(folder, "opaque.png");
    const session::RenderFile render = session::ReadRenderFile(folder / "ball.exr");
    const session::RenderFile whole = session::ReadRenderFile(folder / "opaque.exr");
    EXPECT_EQ(render.settings.at("transparent"), "on");
    const uint8_t* inside = &picture.rgba[4 * (12 * 24 + 12)];
    ASSERT_EQ(inside[3], 255);
    size_t empty = 0, soft = 0;
    for (size_t i = 0; i < picture.rgba.size(); i += 4) {
        const float alpha = render.radiance[i + 3];
        EXPECT_EQ(opaque.rgba[i + 3], 255);
        EXPECT_EQ(alpha, whole.radiance[i + 3]) << "coverage is the same";
        EXPECT_NEAR(picture.rgba[i + 3], 255.0f * alpha, 0.51f) << "linear";
        if (alpha == 0.0f) {
            ++empty;
            for (size_t c = 0; c < 4; ++c) EXPECT_EQ(picture.rgba[i + c], 0);
            for (size_t c = 0; c < 3; ++c) EXPECT_EQ(render.radiance[i + c], 0.0f);
            EXPECT_GT(whole.radiance[i + 2], 0.9f);
            continue;
        }
        soft += alpha < 1.0f;
        for (size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(picture.rgba[i + c], inside[c], 1) << "the ball's color, however little of it";
            // Composited over the background, the picture equals the whole
            const float sky[] = {0.5f, 0.7f, 1.0f};
            EXPECT_NEAR(render.radiance[i + c] + (1.0f - alpha) * sky[c], whole.radiance[i + c], 1e-5f);
        }
    }
    EXPECT_GT(empty, 50u);
    EXPECT_GT(soft, 10u);
}

TEST(ProgramDisplay, HalfFilesAreTheRoundedMeansWithoutSums) {
    const test::TemporaryFolder folder;
    const std::string box = "@cornell.gltf --size 24x16 --spp 4 --aov albedo,depth,instance --quiet ";
    Render(folder, box + "-o float.exr --exr-type float");
    Render(folder, box + "-o half.exr --exr-type half");
    const image::ExrImage whole = image::ReadExr(folder / "float.exr"),
                          half = image::ReadExr(folder / "half.exr");
    for (const image::ExrChannel& channel : half.channels) {
        EXPECT_EQ(channel.name.find("sum"), std::string::npos) << channel.name;
        EXPECT_EQ(channel.name.find("squares"), std::string::npos) << channel.name;
        const std::vector<float>*rounded = half.FloatChannel(channel.name),
              *exact = whole.FloatChannel(channel.name);
        if (rounded == nullptr) {
            ASSERT_NE(whole.UintChannel(channel.name), nullptr) << channel.name;
            EXPECT_EQ(*half.UintChannel(channel.name), *whole.UintChannel(channel.name)) << channel.name;
            continue;
        }
        ASSERT_NE(exact, nullptr) << channel.name;
        for (size_t i = 0; i < exact->size(); ++i)
            if (channel.name == "Z")
                EXPECT_EQ((*rounded)[i], (*exact)[i]);
            else
                EXPECT_NEAR((*rounded)[i], (*exact)[i], 0x1p-11f * std::abs((*exact)[i]) + 0x1p-25f);
    }
    ASSERT_NE(half.FloatChannel("albedo.R"), nullptr);
    EXPECT_LT(2 * std::filesystem::file_size(folder / "half.exr"),
              std::filesystem::file_size(folder / "float.exr"));

    const ProgramResult resumed = RunProgram(folder, "render @cornell.gltf --resume half.exr --spp 8");
    EXPECT_EQ(resumed.exitCode, 4);
    EXPECT_NE(resumed.messages.find("no channel sum0.R, as in any file of half floats"), std::string::npos)
        << resumed.messages;
    const ProgramResult merged = RunProgram(folder, "merge half.exr float.exr -o x.exr");
    EXPECT_EQ(merged.exitCode, 4);
    EXPECT_NE(merged.messages.find("as in any file of half floats"), std::string::npos) << merged.messages;
    const ProgramResult lost =
        RunProgram(folder, "render @cornell.gltf --resume float.exr --spp 8 --exr-type half");
    EXPECT_EQ(lost.exitCode, 2);
    EXPECT_NE(lost.messages.find("would lose its sums"), std::string::npos) << lost.messages;
    EXPECT_EQ(RunProgram(folder, "render @cornell.gltf --exr-type half -o a.png").exitCode, 2);
}

TEST(ProgramDisplay, WhatHalfCannotHoldIsClampedAndCounted) {
    const test::TemporaryFolder folder;
    const ProgramResult result = RunProgram(
        folder,
        "render @furnace_sphere.gltf --size 8x8 --spp 1 --background 1e5,1,1 -o a.exr --exr-type half");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_NE(result.messages.find("beyond 65504"), std::string::npos) << result.messages;
    const image::ExrImage half = image::ReadExr(folder / "a.exr");
    EXPECT_EQ(half.FloatChannel("R")->front(), 65504.0f);
    EXPECT_EQ(half.FloatChannel("G")->front(), 1.0f);
}

TEST(ProgramDisplay, SettingsOfARenderAreDefaultsOfAnother) {
    const test::TemporaryFolder folder;
    Render(folder,
           "@cornell.gltf --size 20x14 --seed 5 --max-depth 3 --crop 3,2,9,7 --spp 1 --sample-offset 4 "
           "--aov albedo --exr-type half --quiet -o model.exr");
    Render(folder, "@cornell.gltf --settings-from model.exr --spp 2 --seed 6 -o taken.exr --quiet");
    Render(folder,
           "@cornell.gltf --size 20x14 --seed 6 --max-depth 3 --crop 3,2,9,7 --spp 2 -o said.exr --quiet");
    const session::RenderFile taken = session::ReadRenderFile(folder / "taken.exr");
    const session::RenderFile said = session::ReadRenderFile(folder / "said.exr");
    EXPECT_EQ(taken.settings, said.settings);
    EXPECT_EQ(taken.radiance, said.radiance);
    EXPECT_EQ(taken.samples, (session::SampleRanges{{0, 2}})) << "from the first sample on";
    EXPECT_TRUE(taken.albedo.empty()) << "channels are no settings";

    const auto refusal = [&](int code, const std::string& options) {
        const ProgramResult result = RunProgram(folder, "render @cornell.gltf --settings-from " + options);
        EXPECT_EQ(result.exitCode, code) << options;
        return result.messages;
    };
    EXPECT_NE(refusal(2, "model.exr --resume model.exr").find("--resume"), std::string::npos);
    EXPECT_NE(refusal(2, "model.exr --size 8x8").find("--crop"), std::string::npos);
    EXPECT_NE(refusal(4, "none.exr").find("none.exr"), std::string::npos);
    EXPECT_NE(refusal(2, "model.exr -o model.exr").find("model.exr"), std::string::npos);
}

TEST(ProgramDisplay, TheMapOfTheOtherRenderIsAskedFor) {
    const test::TemporaryFolder folder;
    image::WriteHdr(folder / "sky.hdr", {2, 1, {1.0f, 1.0f, 1.0f, 1.0f, 0.5f, 0.5f, 0.5f, 1.0f}});
    const std::string ball = "@furnace_sphere.gltf --size 8x8 --spp 1 ";
    Render(folder, ball + "--env sky.hdr --env-rotation 90 -o model.exr");
    const ProgramResult unlit =
        RunProgram(folder, "render @furnace_sphere.gltf --settings-from model.exr --spp 1 -o a.exr");
    EXPECT_EQ(unlit.exitCode, 0) << unlit.messages;
    EXPECT_NE(unlit.messages.find("sky.hdr, which is no setting"), std::string::npos) << unlit.messages;
    const ProgramResult lit = RunProgram(
        folder, "render @furnace_sphere.gltf --settings-from model.exr --env sky.hdr --spp 1 -o b.exr");
    EXPECT_EQ(lit.messages, "");
    EXPECT_EQ(session::ReadRenderFile(folder / "b.exr").radiance,
              session::ReadRenderFile(folder / "model.exr").radiance);

    // A map replaces the background of the other render
    Render(folder, ball + "--background 0.2,0.4,0.8 -o flat.exr");
    const ProgramResult mapped = RunProgram(
        folder, "render @furnace_sphere.gltf --settings-from flat.exr --env sky.hdr --spp 1 -o d.exr");
    EXPECT_EQ(mapped.messages, "");
    EXPECT_EQ(session::ReadRenderFile(folder / "d.exr").settings.at("background"), "none");
}

}  // namespace
}  // namespace raygraph::program_display_test
