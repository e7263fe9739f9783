#include <gtest/gtest.h>
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <limits>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "base/text.h"
#include "editor/cli/arguments.h"
#include "editor/cli/command_files.h"
#include "editor/cli/command_tree.h"
#include "editor/cli/device_list.h"
#include "editor/cli/exit_code.h"
#include "editor/cli/picture_list.h"
#include "editor/cli/rendering.h"
#include "editor/session/settings/setting_table.h"
#include "passes/tonemap.h"
#include "passes/trace.h"
#include "tests/cli/cli_test.h"

namespace raygraph::cli::arguments_test {
namespace {

Arguments Parse(const std::string& line) {
    const std::vector<std::string> words = test::Words("raygraph " + line);
    std::vector<const char*> pointers;
    for (const std::string& word : words) pointers.push_back(word.c_str());
    return ParseArguments(static_cast<int>(pointers.size()), pointers.data());
}

RenderArguments ParseRender(const std::string& line) {
    return std::get<RenderArguments>(Parse("render " + line));
}

template <typename... Texts>
void ExpectUsage(const std::string& line, const Texts&... texts) {
    test::ExpectError(
        ErrorKind::Usage, [&] { Parse(line); }, texts...);
}

TEST(Arguments, RenderTakesEveryOption) {
    const RenderArguments a = ParseRender(
        "box.gltf -o a.png -o b.EXR --output c.hdr --size 64x32 --spp 8 --seed 7 --sample-offset 16 "
        "--max-depth 5 --rr-start 2 --camera '0 1 5 0 0 0 0 1 0 40' --env sky.hdr --env-rotation -90 "
        "--exposure -1.5 --tonemap agx --view albedo --aov albedo,depth --sampler pcg --scene 1 --brdf "
        "lambert --device llvm --validate --denoise --report r.json --quiet");
    EXPECT_EQ(a.scene, "box.gltf");
    ASSERT_EQ(a.outputs.size(), 3u);
    EXPECT_EQ(a.outputs[0].path, "a.png");
    EXPECT_EQ(a.outputs[1].kind, OutputKind::Exr);
    EXPECT_EQ(a.outputs[2].kind, OutputKind::Hdr);
    EXPECT_EQ(a.samples, 8u);
    EXPECT_EQ(a.sampleOffset, 16u);
    EXPECT_EQ(a.environment, "sky.hdr");
    EXPECT_EQ(DisplayOf(a).exposureEv, -1.5f);
    EXPECT_EQ(DisplayOf(a).tonemapOperator, TonemapOperator::AgX);
    ASSERT_TRUE(a.aovs);
    EXPECT_EQ(a.aovs->named, (AovSet{Aov::Albedo, Aov::Depth}));
    EXPECT_FALSE(a.aovs->isAll);
    EXPECT_EQ(a.device, "llvm");
    EXPECT_TRUE(a.isValidating && a.isQuiet && a.denoise == true);
    EXPECT_EQ(a.report, "r.json");

    const PictureSettings settings = SettingsFrom(a.given);
    EXPECT_EQ(settings.size, (Extent2D{64, 32}));
    EXPECT_EQ(settings.paths.seed, 7u);
    EXPECT_EQ(settings.paths.biases.maxDepth, 5u);
    EXPECT_EQ(settings.paths.roulette.start, 2u);
    EXPECT_EQ(settings.camera, "0 1 5 0 0 0 0 1 0 40");
    EXPECT_EQ(settings.environmentRotation, -90.0f);
    EXPECT_EQ(settings.view, View::Albedo);
    EXPECT_EQ(settings.paths.sampler, SamplerKind::Pcg);
    EXPECT_EQ(settings.scene, "1");
}

TEST(Arguments, DenoisingIsOfPngAndExr) {
    ExpectUsage("render box.gltf --denoise -o a.hdr", "--denoise");
    EXPECT_EQ(ParseRender("box.gltf --denoise -o a.hdr -o a.png").denoise, true);
    EXPECT_EQ(ParseRender("box.gltf --no-denoise").denoise, false);
    ExpectUsage("render box.gltf --denoise --no-denoise", "--no-denoise");
    EXPECT_TRUE(ParseRender("box.gltf --denoise").denoise.has_value());
    EXPECT_EQ(ParseRender("box.gltf --denoise --denoiser regression").denoiser, FileDenoiser::Regression);
    ExpectUsage("render box.gltf --denoiser regression", "--denoise");
    ExpectUsage("render box.gltf --denoise --denoiser median", "median", "network", "regression", "oidn");
    ExpectUsage("render box.gltf --denoise --denoiser oidn", "raygraph denoise");
}

TEST(Arguments, WhatIsNotGivenStaysOpen) {
    const RenderArguments a = ParseRender("box.gltf");
    EXPECT_TRUE(a.outputs.empty() && a.given.empty() && a.environment.empty() && a.resume.empty());
    EXPECT_FALSE(a.samples || a.seconds || a.sampleOffset || a.aovs || a.denoise);
    EXPECT_EQ(DisplayOf(a), passes::TonemapSettings{});
}

TEST(Arguments, EveryTonemapAndSamplerNameIsTheOperatorOfThatName) {
    const std::pair<const char*, TonemapOperator> kOperators[] = {
        {"raw", TonemapOperator::Linear},        {"srgb", TonemapOperator::Srgb},
        {"reinhard", TonemapOperator::Reinhard}, {"aces", TonemapOperator::Aces},
        {"agx", TonemapOperator::AgX},           {"neutral", TonemapOperator::Neutral}};
    for (const auto& [name, value] : kOperators)
        EXPECT_EQ(ParseRender(std::string("a.gltf --tonemap ") + name).tonemap, value) << name;
    const std::pair<const char*, SamplerKind> kSamplers[] = {
        {"sobol", SamplerKind::Sobol}, {"pcg", SamplerKind::Pcg}, {"tea", SamplerKind::Tea}};
    for (const auto& [name, value] : kSamplers)
        EXPECT_EQ(SettingsFrom(ParseRender(std::string("a.gltf --sampler ") + name).given).paths.sampler,
                  value)
            << name;
}

TEST(Arguments, ASceneAloneIsEdited) {
    const EditArguments a = std::get<EditArguments>(Parse("box.GLB --camera 1"));
    EXPECT_EQ(a.scene, "box.GLB");
    EXPECT_EQ(a.given.at("camera"), "1");
    EXPECT_EQ(std::get<EditArguments>(Parse("a/edit.gltf")).scene, "a/edit.gltf");
    ExpectUsage("box.obj", "there is no command \"box.obj\"");
}

TEST(Arguments, DefaultsFollowTheOutputs) {
    const auto plan = [](const std::string& line) {
        RenderArguments arguments = ParseRender("a.gltf " + line);
        arguments.outputs = PicturesOf(arguments);
        return PlanJob(arguments, {});
    };
    for (const char* shown : {"", "-o a.png", "-o a.jpg -o b.jpeg"}) {
        const RenderJob job = plan(shown);
        EXPECT_TRUE(job.isDenoised) << shown;
        EXPECT_EQ(job.error, RenderArguments::kDenoisedError);
        EXPECT_EQ(job.samplesWanted, RenderArguments::kMostDenoisedSamples);
        EXPECT_EQ(job.settings.size, (Extent2D{1280, 720}));
    }
    for (const char* exact :
         {"-o a.exr", "-o a.png -o a.exr", "--no-denoise", "--adaptive on", "--devices all"}) {
        const RenderJob job = plan(exact);
        EXPECT_FALSE(job.isDenoised) << exact;
        EXPECT_EQ(job.error, RenderArguments::kCleanError);
        EXPECT_EQ(job.samplesWanted, RenderArguments::kMostSamples);
    }
    for (const char* other : {"--view raster", "-o a.exr --shard 0/1"}) {
        EXPECT_FALSE(plan(other).error) << other;
        EXPECT_EQ(plan(other).samplesWanted, RenderArguments::kDefaultSamples) << other;
    }
    EXPECT_FALSE(plan("--spp 7").isDenoised);
    EXPECT_FALSE(plan("--spp 7").error);
    EXPECT_EQ(plan("--spp 7").samplesWanted, 7u);
    EXPECT_FALSE(plan("--time 7").samplesWanted);
    EXPECT_FALSE(plan("--error 0.5").samplesWanted);
    EXPECT_EQ(plan("--error 0.5").error, 0.5);
    EXPECT_EQ(plan("--view depth").samplesWanted, 1u);
    test::ExpectError(
        ErrorKind::Usage, [&] { plan("--transparent on -o a.jpg"); }, "a .jpg has no alpha");
}

TEST(Arguments, AnOutputDoesNotSwallowTheScene) {
    EXPECT_EQ(ParseRender("-o a.png box.gltf").scene, "box.gltf");
}

TEST(Arguments, MistakesAreUsageErrorsThatNameTheOption) {
    ExpectUsage("", "command");
    ExpectUsage("paint", "paint");
    ExpectUsage("render", "FILE");
    ExpectUsage("render a.gltf b.gltf", "b.gltf");
    ExpectUsage("render a.gltf --bogus", "--bogus");
    ExpectUsage("render a.gltf --nee no", "--nee", "off");
    ExpectUsage("render a.gltf --size", "--size");
    ExpectUsage("render a.gltf --size 64", "--size", "\"64\"");
    ExpectUsage("render a.gltf --size 64x64 --size 32x32", "--size");
    ExpectUsage("render a.gltf --crop 1,2,3", "--crop", "X,Y,W,H");
    ExpectUsage("render a.gltf --spp 0", "--spp");
    ExpectUsage("render a.gltf --spp -4", "--spp");
    ExpectUsage("render a.gltf --spp 4 --time 1", "--spp", "--time");
    ExpectUsage("render a.gltf --time -1", "--time");
    ExpectUsage("render a.gltf -o a.tif", "-o", "a.tif", ".png, .jpg, .exr or .hdr");
    ExpectUsage("render a.gltf -o a", "-o", ".png, .jpg, .exr or .hdr");
    ExpectUsage("render a.gltf --tonemap linear", "--tonemap", ".exr", "srgb", "raw");
    ExpectUsage("render a.gltf --background mauve", "--background", "gray", "#rrggbb");
    ExpectUsage("render a.gltf --tonemap filmic", "--tonemap", "neutral");
    ExpectUsage("render a.gltf --view cubist", "--view", "raster");
    ExpectUsage("render a.gltf --brdf phong", "--brdf", "lambert");
    ExpectUsage("render a.gltf --light-sampler tree", "--light-sampler", "bvh");
    ExpectUsage("render a.gltf --rr constant:2", "--rr", "\"2\"");
    ExpectUsage("render a.gltf --error 0", "--error");
    ExpectUsage("render a.gltf --aperture -1", "--aperture");
    ExpectUsage("render a.gltf --aov albedo,,N", "--aov");
    ExpectUsage("render a.gltf --aov uv", "--aov", "albedo");
    ExpectUsage("render a.gltf --light-group lamp", "--light-group", "NAME=PATTERN");
    ExpectUsage("render a.gltf --light-group a=b --light-group a=c", "--light-group", "two");
    ExpectUsage("render a.gltf --background 1,1", "--background");
    ExpectUsage("render a.gltf --background 1,1,1 --env a.hdr", "--background", "--env");
    ExpectUsage("render a.gltf --background 1,1,1 --env-rotation 90", "--env-rotation", "--background");
    ExpectUsage("render a.gltf --background 1,1,1 --env-tint 1,1,0", "--env-tint", "--background");
    ExpectUsage("render a.gltf -o a.exr --exposure 1", "--exposure", ".png");
    ExpectUsage("render a.gltf -o a.exr --white-point auto", "--white-point", ".png");
    ExpectUsage("render a.gltf --white-point 500", "--white-point", "1000");
    ExpectUsage("render a.gltf --transparent yes", "--transparent", "off");
    ExpectUsage("render a.gltf --exr-type half", "--exr-type", ".exr");
    ExpectUsage("render a.gltf -o a.exr --exr-type double", "--exr-type", "half");
    ExpectUsage("render a.gltf --settings-from a.exr --resume a.exr", "--settings-from", "--resume");
    ExpectUsage("render a.gltf --resume a.exr --tonemap agx", "--tonemap", ".png");
    ExpectUsage("render a.gltf --camera '0 1 5 0 0'", "--camera", "0 1 5 0 0");
    ExpectUsage("render a.gltf --camera '0 1 5 0 1 5 0 1 0 40'", "--camera", "differ");
    ExpectUsage("render a.gltf --max-depth -1", "--max-depth");
    ExpectUsage("bench a.gltf --spp 4", "--spp");
    ExpectUsage("bench a.gltf --tolerance 0.1", "--tolerance", "--compare");
    ExpectUsage("bench a.gltf --background 1,1,1 --env-tint 1,1,0", "--env-tint", "--background");
    ExpectUsage("info --devices --scene 1", "--scene", "--devices");
    ExpectUsage("info", "--devices");
    ExpectUsage("info --devices --extensions", "--devices or --extensions");
    ExpectUsage("info --extensions --scene 1", "--scene", "--extensions");
    ExpectUsage("info a.gltf --devices", "--devices");
    ExpectUsage("merge -o c.exr", "FILES");
    ExpectUsage("merge a.exr b.exr", "-o");
    ExpectUsage("merge a.exr b.exr -o c.png", "c.png");
    ExpectUsage("denoise -o c.png", "FILE.exr");
    ExpectUsage("denoise a.exr", "-o");
    for (const std::string command : {"denoise a.exr", "compare a.exr b.exr"})
        for (const std::string file : {"b.hdr", "b.jpg"})
            ExpectUsage(command + " -o " + file, "-o: \"" + file + "\" does not end in .png or .exr");
    ExpectUsage("denoise a.exr -o .", "-o: \".\" is a folder; name a file that ends in .png or .exr");
    ExpectUsage("denoise a.exr -o b.exr --exposure 1", "--exposure is of a .png");
    ExpectUsage("denoise a.exr -o b.png --white-point auto", "--white-point auto");
}

TEST(Arguments, ExplainTakesAPixelAndItsSamples) {
    const auto a = std::get<ExplainArguments>(
        Parse("explain box.gltf --pixel 3,4 --brightest 2 --spp 9 --sample-offset 5 --size 8x8 --json"));
    EXPECT_EQ(a.request.pixel, glm::uvec2(3, 4));
    EXPECT_EQ(a.request.brightest, 2u);
    EXPECT_EQ(a.request.sampleCount, 9u);
    EXPECT_EQ(a.request.firstSample, 5u);
    EXPECT_FALSE(a.request.sample);
    EXPECT_TRUE(a.isJson);
    EXPECT_EQ(std::get<ExplainArguments>(Parse("explain box.gltf --pixel 0,0 --sample 7")).request.sample,
              7u);
    ExpectUsage("explain box.gltf", "--pixel");
    ExpectUsage("explain box.gltf --pixel 3", "--pixel", "X,Y");
    ExpectUsage("explain box.gltf --pixel 3,4 --sample 1 --brightest 2", "--sample", "--brightest");
    ExpectUsage("explain box.gltf --pixel 3,4 --view albedo", "--view");
}

TEST(Arguments, GraphRunIsACommandWithinGraph) {
    const auto run = std::get<GraphRunArguments>(
        Parse("graph run blur.json -o out --frames 8 --plan --time --validate --device 1"));
    EXPECT_EQ(run.description, "blur.json");
    EXPECT_EQ(run.folder, "out");
    EXPECT_EQ(run.frames, 8u);
    EXPECT_TRUE(run.showsPlan && run.showsTimes && run.isValidating && !run.isDot);
    EXPECT_EQ(run.device, "1");
    EXPECT_TRUE(std::get<GraphRunArguments>(Parse("graph run blur.json --dot")).isDot);
    EXPECT_FALSE(std::get<GraphRunArguments>(Parse("graph run blur.json")).frames);
    EXPECT_EQ(std::get<GraphArguments>(Parse("graph ./run")).scene, "./run");
    ExpectUsage("graph", "a scene", "graph --help");
    ExpectUsage("graph run", "FILE.json", "graph run --help");
    ExpectUsage("graph run blur.json --frames 0", "--frames");
    ExpectUsage("graph run blur.json --dot --plan", "--dot", "--plan");
    ExpectUsage("graph run blur.json --dot --time", "--dot", "--time");
    ExpectUsage("graph run blur.json --frame 2", "did you mean --frames?", "graph run --help");
    const std::string help = std::get<ShowText>(Parse("graph --help")).text;
    EXPECT_NE(help.find("\nCommands:\n  run "), std::string::npos) << help;
}

TEST(Arguments, HelpNamesEveryOptionAndTheExitCodes) {
    const std::string help = std::get<ShowText>(Parse("render --help-all")).text;
    for (const PictureSetting& setting : PictureSettingTable())
        EXPECT_NE(help.find(std::string("--") + setting.name + " " + setting.operand), std::string::npos)
            << setting.name;
    EXPECT_NE(help.find("--resume FILE.exr"), std::string::npos) << help;
    for (const Aov aov : kAovs) EXPECT_NE(help.find(Name(aov)), std::string::npos) << Name(aov);
    const std::string overview = std::get<ShowText>(Parse("--help")).text;
    for (const char* text :
         {"render", "edit", "bench", "info", "graph", "explain", "merge", "denoise", "completion"})
        EXPECT_NE(overview.find(text), std::string::npos) << text;
    for (const auto& [code, text] : kExitCodes)
        EXPECT_NE(overview.find(Text("\n  {:<24}  {}\n", static_cast<int>(code), text)), std::string::npos)
            << text;
    EXPECT_EQ(std::get<ShowText>(Parse("--version")).text,
              std::string("raygraph ") + RAYGRAPH_VERSION + "\n");
}

TEST(Arguments, HelpGroupsOptionsAndLeavesOutThoseForStudy) {
    const std::string all = std::get<ShowText>(Parse("render --help-all")).text;
    const std::string help = std::get<ShowText>(Parse("render --help")).text;
    for (const char* group :
         {"Output:", "Sampling:", "Camera:", "Light:", "Scene:", "Biases:", "Devices:", "Messages:"}) {
        EXPECT_NE(help.find(std::string("\n") + group), std::string::npos) << group << "\n" << help;
        EXPECT_NE(all.find(std::string("\n") + group), std::string::npos) << group;
    }
    EXPECT_EQ(help.find("\nStudy:"), std::string::npos);
    EXPECT_NE(all.find("\nStudy:"), std::string::npos);
    const std::string first = help.substr(help.find("\nOptions:"));
    const std::string ungrouped = first.substr(0, first.find("\n\n"));
    EXPECT_EQ(std::ranges::count(ungrouped, '\n'), 3)
        << "only --help and --help-all are in no group:" << ungrouped;
    for (const char* option :
         {"--brdf", "--distribution", "--masking", "--fresnel", "--mis", "--sampler", "--rr "}) {
        EXPECT_EQ(help.find(option), std::string::npos) << option;
        EXPECT_NE(all.find(option), std::string::npos) << option;
    }
}

TEST(Arguments, HelpNamesTheViewsAndNoOthers) {
    const std::string help =
        std::regex_replace(std::get<ShowText>(Parse("render --help")).text, std::regex("\\s+"), " ");
    std::smatch match;
    ASSERT_TRUE(std::regex_search(help, match, std::regex("What the picture shows: (.*?) --")));
    std::istringstream list(std::regex_replace(match.str(1), std::regex("\\([^)]*\\)|\\bor\\b|,"), " "));
    const std::set<std::string> named{std::istream_iterator<std::string>(list), {}};
    std::set<std::string> views;
    for (size_t i = 0; i < passes::kViewCount; ++i) {
        const std::string name = passes::Name(static_cast<View>(i));
        EXPECT_EQ(std::get<RenderArguments>(Parse("render a.gltf --view " + name)).given.at("view"), name);
        views.insert(name);
    }
    EXPECT_EQ(named, views);
}

TEST(Arguments, HelpListsWhatAnOptionTakesWithItsDefault) {
    const std::string help =
        std::regex_replace(std::get<ShowText>(Parse("render --help-all")).text, std::regex("\\s+"), " ");
    for (const char* text :
         {"sobol (Owen-scrambled; default), pcg or tea",
          "uniform, power or bvh (by its possible contribution; default)",
          "srgb (no curve), reinhard, aces, agx or neutral (default)", "balance, power (default) or off",
          "throughput (default), constant:P (each bounce survives with P), frame:P",
          "emission, direct, indirect, or by its first scattering: diffuse, specular, transmission;"})
        EXPECT_NE(help.find(text), std::string::npos) << text << "\n" << help;
}

// The help of a setting is generated from its default, so that no text can contradict it.
TEST(PictureSettings, HelpSaysTheDefault) {
    const SettingTexts defaults = Texts(PictureSettings{});
    for (const PictureSetting& setting : PictureSettingTable()) {
        const std::string help = setting.HelpWith({});
        EXPECT_EQ(help.find("{}"), std::string::npos) << setting.name;
        EXPECT_NE(help.find(defaults.at(setting.name)), std::string::npos) << setting.name << ": " << help;
    }
}

// Unlike a render, a benchmark limits its paths; it has frames, rounds and tolerance of its own.
TEST(Arguments, HelpSaysTheDefaultsOfItsOwnCommand) {
    const auto expect = [](const char* command, std::initializer_list<std::string> texts) {
        const std::string help =
            std::regex_replace(std::get<ShowText>(Parse(command)).text, std::regex("\\s+"), " ");
        for (const std::string& text : texts)
            EXPECT_NE(help.find(text), std::string::npos) << text << "\n" << help;
    };
    expect("render --help", {"or none. Default: none", "Samples a pixel; with --resume",
                             "first sample (0):", "Exposure of a .png in stops (0)"});
    expect("bench --help",
           {"or none. Default: 16", "in a round (8)", "over all of them (5)", "may rise (0.05)"});
    EXPECT_EQ(SettingsFrom({}, BenchDefaults()).paths.biases.maxDepth, 16u);
    EXPECT_EQ(SettingsFrom({{"max-depth", "none"}}, BenchDefaults()).paths.biases.maxDepth,
              passes::kNoDepthLimit);
}

TEST(Arguments, GroupsOfLightsAreGivenOneByOne) {
    const auto a = std::get<RenderArguments>(
        Parse("render a.gltf --light-group key=lamp*,bulb --light-group fill=window"));
    EXPECT_EQ(a.given.at("light-group"), "key=lamp*,bulb;fill=window");
}

TEST(Arguments, DenoiseTakesEveryOption) {
    const auto a =
        std::get<DenoiseArguments>(Parse("denoise a.exr -o b.png -o c.exr --denoiser oidn --exposure 1 "
                                         "--tonemap aces --white-point 3000 --device llvm "
                                         "--validate --quiet"));
    EXPECT_EQ(a.input, "a.exr");
    ASSERT_EQ(a.outputs.size(), 2u);
    EXPECT_EQ(a.outputs[0].kind, OutputKind::Png);
    EXPECT_EQ(a.outputs[1].path, "c.exr");
    EXPECT_EQ(a.denoiser, FileDenoiser::Oidn);
    EXPECT_EQ(DisplayOf(a).exposureEv, 1.0f);
    EXPECT_EQ(DisplayOf(a).tonemapOperator, TonemapOperator::Aces);
    EXPECT_EQ(a.whitePoint->kelvin, 3000.0);
    EXPECT_TRUE(a.device == "llvm" && a.isValidating && a.isQuiet);
}

TEST(Arguments, AllChannelsAreThoseThatOthersDoNotRepeat) {
    AovRequest all = ParseAovs("all");
    EXPECT_FALSE(AovsFor(all, {}).Has(Aov::Denoising));
    EXPECT_TRUE(AovsFor(ParseAovs("all,denoising"), {}).Has(Aov::Denoising));
    PictureSettings adaptive, raster;
    adaptive.isAdaptive = true;
    raster.view = View::Raster;
    for (const PictureSettings& settings : {adaptive, raster})
        test::ExpectError(
            ErrorKind::Usage, [&] { AovsFor(ParseAovs("denoising"), settings); }, "--aov denoising");
}

TEST(Arguments, MergeTakesAnyNumberOfRenders) {
    const auto a = std::get<MergeArguments>(Parse("merge a.exr b.exr c.exr -o d.exr"));
    EXPECT_EQ(a.inputs.size(), 3u);
    EXPECT_EQ(a.output, "d.exr");
    // Only one task of a job array may have had samples
    EXPECT_EQ(std::get<MergeArguments>(Parse("merge a.exr -o d.exr")).inputs.size(), 1u);
}

TEST(PictureSettings, TextsReadBackAsTheSameSettings) {
    PictureSettings settings;
    settings.size = {77, 5};
    settings.view = View::Depth;
    settings.camera = "Camera.001";
    settings.scene = "Second";
    settings.variant = "red";
    settings.at = 0.1;
    settings.clips = "walk:0.5,2";
    settings.shutter = session::Shutter{-0.0125, 0.1};
    settings.crop = passes::Region{3, 1, 70, 4};
    settings.paths.isEnvironmentHidden = true;
    settings.isAdaptive = true;
    settings.hasGround = true;
    settings.paths.seed = 4294967295u;
    settings.paths.sampler = SamplerKind::Tea;
    settings.raster.shadows = passes::RasterShadows::Maps;
    settings.paths.biases = {.maxDepth = 0,
                             .clampIndirect = 2.5f,
                             .regularize = 0.25f,
                             .shadowTerminator = true,
                             .textureLod = -0.5f};
    settings.paths.scattering = {BrdfModel::Lafortune, MicrofacetModel::Phong, MaskingModel::Separable,
                                 FresnelModel::Lazanyi, MultiscatterKind::Walk};
    settings.paths.lights = {false, LightSampler::Power, MisHeuristic::Balance};
    settings.aperture = 0.125f;
    settings.focusDistance = 3.5f;
    settings.paths.roulette = {Roulette::Frame, 11, 0.75f};
    settings.environmentRotation = 0.1f;
    settings.environmentTint = {0.5f, 1.0f, 2.0f};
    settings.background = {0.1f, 0.2f, 0.3f};
    settings.light = DefaultLight::None;
    settings.textureBudget = uint64_t{3} << 20;
    settings.pointsAndLines = {scene::ParseRoundRadius("0.01"), scene::ParseRoundRadius("0.2%")};
    settings.lightGroups = {{"key", {"lamp*", "bulb"}}, {"fill", {"window"}}};
    const SettingTexts texts = Texts(settings);
    EXPECT_EQ(Texts(SettingsFrom(texts)), texts);
    EXPECT_EQ(FirstDifference(texts, texts), "");
    for (const PictureSetting& setting : PictureSettingTable()) {
        SettingTexts other = texts;
        other.erase(setting.name);  // its default
        if (setting.name == kLightSetting) other[setting.name] = "studio";
        EXPECT_EQ(FirstDifference(texts, other).find(setting.name), 0u) << setting.name;
    }
}

TEST(PictureSettings, DefaultsAreThoseOfThePasses) {
    const PictureSettings settings;
    const passes::TraceSettings trace;
    EXPECT_EQ(settings.paths.roulette.start, trace.roulette.start);
    EXPECT_EQ(settings.paths.roulette.kind, trace.roulette.kind);
    EXPECT_EQ(settings.paths.seed, trace.seed);
    EXPECT_EQ(settings.paths.sampler, trace.sampler);
    EXPECT_EQ(settings.paths.biases, trace.biases);
    EXPECT_EQ(trace.biases.maxDepth, passes::kNoDepthLimit);
    EXPECT_EQ(settings.raster.shadows, passes::RasterSettings{}.shadows);
    // The help must say so, too
    for (const PictureSetting& setting : PictureSettingTable()) {
        std::string shown(1, '(');
        shown += setting.text(settings);
        shown += ')';
        const std::string_view name = setting.name;
        if (name == "rr-start" || name == "size" || name == "seed") {
            EXPECT_NE(setting.HelpWith({}).find(shown), std::string::npos) << name;
        }
    }
}

TEST(PictureSettings, AWrongTextNamesItsSetting) {
    try {
        SettingsFrom({{"seed", "x"}});
        ADD_FAILURE() << "nothing was thrown";
    } catch (const SettingError& error) {
        EXPECT_EQ(error.Kind(), ErrorKind::Usage);
        EXPECT_TRUE(std::string(error.what()).starts_with("seed: \"x\"")) << error.what();
    }
}

}  // namespace
TEST(Arguments, EditOpensEmptyOrASceneOrPlaysAScript) {
    EXPECT_TRUE(std::get<EditArguments>(Parse("edit")).scene.empty());
    const auto edit = std::get<EditArguments>(
        Parse("edit a.gltf --headless-script b.txt --device llvm --validate --texture-budget 64M"));
    EXPECT_EQ(edit.scene, "a.gltf");
    EXPECT_EQ(edit.script, "b.txt");
    EXPECT_EQ(edit.device, "llvm");
    EXPECT_EQ(SettingsFrom(edit.given).textureBudget, uint64_t{64} << 20);
    EXPECT_TRUE(edit.isValidating);
}

}  // namespace raygraph::cli::arguments_test

namespace raygraph::cli::suggestion_test {
namespace {

TEST(Suggestion, CountsWhatIsWrong) {
    EXPECT_EQ(EditDistance("", ""), 0u);
    EXPECT_EQ(EditDistance("size", "size"), 0u);
    EXPECT_EQ(EditDistance("siez", "size"), 1u) << "two letters that changed places";
    EXPECT_EQ(EditDistance("sze", "size"), 1u);
    EXPECT_EQ(EditDistance("sizee", "size"), 1u);
    EXPECT_EQ(EditDistance("sixe", "size"), 1u);
    EXPECT_EQ(EditDistance("", "size"), 4u);
    EXPECT_EQ(EditDistance("kitten", "sitting"), 3u);
    EXPECT_EQ(EditDistance("sitting", "kitten"), 3u);
}

TEST(Suggestion, IsTheNearestThatIsNear) {
    const std::vector<std::string> words{"--sampler", "--sample-offset", "--spp", "--nee", "-o"};
    EXPECT_EQ(Suggestion("--smapler", words), "--sampler");
    EXPECT_EQ(Suggestion("-spp", words), "--spp");
    EXPECT_EQ(Suggestion("--sampleoffset", words), "--sample-offset");
    EXPECT_EQ(Suggestion("--smaplre", words), "--sampler") << "two of seven letters";
    EXPECT_EQ(Suggestion("--sampling", words), std::nullopt) << "three of them";
    EXPECT_EQ(Suggestion("--exposure", words), std::nullopt);
    EXPECT_EQ(Suggestion("-x", words), std::nullopt) << "all of -o would be wrong";
    EXPECT_EQ(Suggestion("--", words), std::nullopt);
    EXPECT_EQ(Suggestion(std::string(1 << 20, 'x'), words), std::nullopt);
}

void ExpectMessage(const std::string& line, const std::string& message) {
    const std::vector<std::string> words = test::Words("raygraph " + line);
    std::vector<const char*> pointers;
    for (const std::string& word : words) pointers.push_back(word.c_str());
    const Error error =
        testing::ErrorOf([&] { ParseArguments(static_cast<int>(pointers.size()), pointers.data()); });
    EXPECT_EQ(error.Kind(), ErrorKind::Usage) << line;
    EXPECT_EQ(std::string(error.what()), message);
}

TEST(Suggestion, StandsInTheMessage) {
    ExpectMessage("rendr a.gltf",
                  "there is no command \"rendr\"; did you mean render? (see raygraph --help)");
    ExpectMessage("paint a.gltf", "there is no command \"paint\" (see raygraph --help)");
    ExpectMessage("render a.gltf --siez 64x64",
                  "render has no option --siez; did you mean --size? (see raygraph render --help)");
    ExpectMessage("render --siez=64x64 a.gltf",
                  "render has no option --siez; did you mean --size? (see raygraph render --help)");
    ExpectMessage("render --hlep",
                  "render has no option --hlep; did you mean --help? (see raygraph render --help)");
    ExpectMessage("info --device",
                  "info has no option --device; did you mean --devices? (see raygraph info --help)");
    ExpectMessage("bench a.gltf --outputs x", "bench has no option --outputs (see raygraph bench --help)");
    ExpectMessage("--verson", "there is no option --verson; did you mean --version? (see raygraph --help)");
    ExpectMessage("render a.gltf b.gltf",
                  "The following argument was not expected: b.gltf (see raygraph render --help)");
    ExpectMessage("render a.gltf '--x\ny'", "render has no option --x?y (see raygraph render --help)");
}

TEST(OptionText, SaysWhichFilesAnOptionTakes) {
    using Endings = std::vector<std::string>;
    EXPECT_EQ((OptionText{.operand = "FILE.exr", .help = "of .png"}.Extensions()), Endings{".exr"});
    EXPECT_EQ((OptionText{.operand = "FILE", .help = "Environment map, .hdr or .exr"}.Extensions()),
              (Endings{".hdr", ".exr"}));
    EXPECT_EQ((OptionText{.operand = "FILE", .help = "A script; see docs/editor.md"}.Extensions()),
              Endings{});
    EXPECT_EQ((OptionText{.operand = "LIST", .help = "Channels of an .exr"}.Extensions()), Endings{});
    EXPECT_FALSE((OptionText{.operand = "LIST"}.TakesFile()));
    EXPECT_TRUE((OptionText{.operand = "FOLDER"}.TakesFolder()));
}

TEST(OptionText, IsBriefWithItsFirstClause) {
    EXPECT_EQ((OptionText{.help = "Samples a pixel (64); with --resume with more"}.Brief()),
              "Samples a pixel (64)");
    EXPECT_EQ((OptionText{.help = "Bias: end paths"}.Brief()), "Bias: end paths");
    EXPECT_EQ((OptionText{.help = "Random numbers: a or b", .choices = {"a", "b"}}.Brief()),
              "Random numbers");
    const std::string longHelp =
        "A help that goes on and on without any end of a clause, as no help should ever do, but some may";
    const std::string brief = OptionText{.help = longHelp}.Brief();
    EXPECT_LE(brief.size(), 76u);
    EXPECT_TRUE(brief.ends_with("...")) << brief;
}

}  // namespace
}  // namespace raygraph::cli::suggestion_test

namespace raygraph::cli::device_list_test {
namespace {

using Indices = std::vector<uint32_t>;

rhi::DeviceReport Device(uint32_t index, const char* name, rhi::DeviceType type, const char* driver = "d 1") {
    rhi::DeviceReport device;
    device.index = index;
    device.name = name;
    device.type = type;
    device.driver = driver;
    return device;
}

// Returns two equal GPUs, a different one, a slow one that is first, and one that lacks a requirement.
std::vector<rhi::DeviceReport> Devices() {
    std::vector<rhi::DeviceReport> devices{
        Device(0, "cpu", rhi::DeviceType::Cpu), Device(1, "gpu", rhi::DeviceType::Discrete),
        Device(2, "gpu", rhi::DeviceType::Discrete, "d 2"), Device(3, "gpu", rhi::DeviceType::Discrete),
        Device(4, "gpu", rhi::DeviceType::Discrete)};
    devices[3].refusals = {"lacks rays"};
    return devices;
}

TEST(DeviceList, EveryRefusalIsShown) {
    std::vector<rhi::DeviceReport> devices(2);
    devices[0].name = "fast";
    devices[0].apiVersion = (1u << 22) | (4u << 12) | 7u;
    devices[1].index = 1;
    devices[1].name = "old";
    devices[1].refusals = {"lacks this", "lacks that"};
    const std::string text = DescribeDevices(devices);
    for (const char* part :
         {"0  fast", "Vulkan 1.4", "suitable  yes", "1  old", "suitable  no", "- lacks this", "- lacks that"})
        EXPECT_NE(text.find(part), std::string::npos) << text << "lacks " << part;
    EXPECT_NE(DescribeDevices({}).find("no Vulkan devices"), std::string::npos);
}

TEST(DeviceList, ListIsAllOrIndices) {
    for (const char* list : {"all", "0", "0,0", "3,1,12"}) EXPECT_EQ(ValidatedDevices(list), list);
    for (const char* list : {"", "x", "0,", ",0", "0, 1", "-1", "1.5", "all,0", "All", "4294967296"})
        EXPECT_THROW(ValidatedDevices(list), Error) << list;
}

TEST(DeviceList, AllAreThoseLikeTheBest) {
    EXPECT_EQ(IndicesOf("all", Devices()), (Indices{1, 4})) << "neither another driver nor another kind";
    EXPECT_EQ(IndicesOf("all", {Devices()[0]}), (Indices{0}));
    test::ExpectError(
        ErrorKind::NoDevice, [] { IndicesOf("all", {Devices()[3]}); }, "lacks rays");
    test::ExpectError(
        ErrorKind::NoDevice, [] { IndicesOf("all", {}); }, "the loader finds none");
}

TEST(DeviceList, IndicesAreTakenAsTheyAreNamed) {
    EXPECT_EQ(IndicesOf("4,0,4", Devices()), (Indices{4, 0, 4}));
    test::ExpectError(
        ErrorKind::NoDevice, [] { IndicesOf("1,3", Devices()); }, "'3'", "lacks rays");
    test::ExpectError(
        ErrorKind::NoDevice, [] { IndicesOf("5", Devices()); }, "'5'");
}

TEST(DeviceList, ProcessesShareTheDevicesOfTheirComputer) {
    const Indices devices{5, 6, 7};
    EXPECT_EQ(ShareOf(devices, 0, 1), devices);
    EXPECT_EQ(ShareOf(devices, 0, 2), (Indices{5, 7}));
    EXPECT_EQ(ShareOf(devices, 1, 2), (Indices{6}));
    EXPECT_EQ(ShareOf(devices, 2, 3), (Indices{7}));
    for (uint32_t process = 0; process < 5; ++process)  // no process is without a device
        EXPECT_EQ(ShareOf(devices, process, 5), (Indices{devices[process % 3]}));
}

}  // namespace
}  // namespace raygraph::cli::device_list_test

// Tests that the exit status of each kind of Error is the documented one.
namespace raygraph::cli::exit_code_test {
namespace {

TEST(ExitStatus, OfEachKindOfError) {
    const auto status = [](ErrorKind kind) { return static_cast<int>(ExitCodeFor(kind)); };
    EXPECT_EQ(status(ErrorKind::Io), 1);
    EXPECT_EQ(status(ErrorKind::Vulkan), 1);
    EXPECT_EQ(status(ErrorKind::Usage), 2);
    EXPECT_EQ(status(ErrorKind::NoDevice), 3);
    EXPECT_EQ(status(ErrorKind::BadInput), 4);
    EXPECT_EQ(status(ErrorKind::DeviceLost), 5);
    EXPECT_EQ(status(ErrorKind::OutOfMemory), 5);
}

}  // namespace
}  // namespace raygraph::cli::exit_code_test
