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
    EXPECT_TRUE(a.isValidating && a.isQuiet && a.isDenoised);
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
    EXPECT_TRUE(ParseRender("box.gltf --denoise -o a.hdr -o a.png").isDenoised);
    EXPECT_TRUE(ParseRender("box.gltf --denoise").isDenoised);
    EXPECT_EQ(ParseRender("box.gltf --denoise --denoiser regression").denoiser, FileDenoiser::Regression);
    ExpectUsage("render box.gltf --denoiser regression", "--denoise");
    ExpectUsage("render box.gltf --denoise --denoiser median", "median", "network", "regression", "oidn");
    ExpectUsage("render box.gltf --denoise --denoiser oidn", "raygraph denoise");
}

TEST(Arguments, WhatIsNotGivenStaysOpen) {
    const RenderArguments a = ParseRender("box.gltf");
    EXPECT_TRUE(a.outputs.empty() && a.given.empty() && a.environment.empty() && a.resume.empty());
    EXPECT_FALSE(a.samples || a.seconds || a.sampleOffset || a.aovs);
    EXPECT_EQ(DisplayOf(a), passes::TonemapSettings{});
}

TEST(Arguments, EveryTonemapAndSamplerNameIsTheOperatorOfThatName) {
    const std::pair<const char*, TonemapOperator> kOperators[] = {
        {"linear", TonemapOperator::Linear},     {"srgb", TonemapOperator::Srgb},
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
    ExpectUsage("render a.gltf -o a.jpg", "-o", "a.jpg", ".png, .exr or .hdr");
    ExpectUsage("render a.gltf -o a", "-o", ".png, .exr or .hdr");
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
          "linear, srgb, reinhard, aces, agx or neutral (default)", "balance, power (default) or off",
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
    expect("render --help", {"or none. Default: none", "Samples a pixel (64);",
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
    EXPECT_EQ((OptionText{.help = "Samples a pixel (64); with more"}.Brief()), "Samples a pixel (64)");
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

// Tests --frames: times, numbers and names.
namespace raygraph::cli::frame_range_test {
namespace {

using test::ExpectError;

TEST(FrameRange, TimesFromTheFirstToTheLast) {
    const FrameRange range = ParseFrames("0.5:2:0.25");
    ASSERT_EQ(range.Count(), 7u);
    EXPECT_EQ(range.TimeOf(0), 0.5);
    EXPECT_EQ(range.TimeOf(6), 2.0);
    EXPECT_EQ(ParseFrames("0:1:0.1").Count(), 11u) << "ten tenths are one, but for rounding";
    EXPECT_EQ(ParseFrames("0:1:0.3").Count(), 4u);
    EXPECT_EQ(ParseFrames("2:2:1").Count(), 1u);
    EXPECT_EQ(ParseFrames("-1:1:1").Count(), 3u);
}

TEST(FrameRange, PartsOfASequenceHaveItsNumbers) {
    const FrameRange whole = ParseFrames("0:9.96:0.04"), part = ParseFrames("4:5.96:0.04");
    for (uint32_t i = 0; i < part.Count(); ++i) {
        EXPECT_EQ(part.NumberOf(i), 100 + i);
        EXPECT_EQ(part.TimeOf(i), whole.TimeOf(100 + i));
    }
}

TEST(FrameRange, WhatIsNoneIsRefused) {
    for (const char* text :
         {"", "1", "0:1", "0:1:", "a:1:1", "0:1:0", "0:1:-1", "1:0:1", "0:1:1:1", "0:1e6:1e-3", "0:nan:1"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseFrames(text); }, "");
    ExpectError(
        ErrorKind::Usage, [] { ParseFrames("2:1:0.5"); }, "\"2:1:0.5\" ends before it begins");
    ExpectError(
        ErrorKind::Usage, [] { ParseFrames("0:1000:0.001"); }, "has more than 100000 frames");
}

TEST(FrameRange, NamesHaveThePlaceOfANumber) {
    EXPECT_TRUE(HasNumberPlaceholder("a/b.####.exr"));
    EXPECT_TRUE(HasNumberPlaceholder("#.png"));
    EXPECT_FALSE(HasNumberPlaceholder("a/b.exr"));
    EXPECT_FALSE(HasNumberPlaceholder("a##/b.exr")) << "in the folder's name";
    EXPECT_FALSE(HasNumberPlaceholder("a#b#.exr"));
    EXPECT_EQ(Numbered("a/b.####.exr", 7), "a/b.0007.exr");
    EXPECT_EQ(Numbered("####.exr", 12345), "12345.exr");
    EXPECT_EQ(Numbered("x##/#", 3), "x##/3");
    EXPECT_EQ(Numbered("", 3), "") << "no file stays none";
    EXPECT_EQ(Numbered("a.####.exr", -2), "a.-002.exr");
}

}  // namespace
}  // namespace raygraph::cli::frame_range_test

namespace raygraph::cli::picture_list_test {
namespace {

TEST(PictureList, NamesHaveNumberAndCameraInTheirPlaces) {
    EXPECT_EQ(Named("a/#b/{camera}.##.{camera}.exr", {7, "top"}), "a/#b/top.07.top.exr");
    EXPECT_EQ(Named("{camera}.exr", {{}, "top"}), "top.exr");
    EXPECT_EQ(Named("{camera}/x.##.exr", {7, {}}), "{camera}/x.07.exr") << "only in the last part";
    EXPECT_EQ(Named("{camera}.##.exr", {}), "{camera}.##.exr");
    EXPECT_EQ(Named("{camera}.exr", {{}, "{camera}"}), "{camera}.exr") << "what is put in is no place";
    EXPECT_TRUE(HasCameraPlaceholder("a/x{camera}y.exr"));
    EXPECT_FALSE(HasCameraPlaceholder("{camera}/x.exr"));
    EXPECT_FALSE(HasCameraPlaceholder("{Camera}.exr"));
}

TEST(PictureList, CameraInANameIsANameOrANumber) {
    EXPECT_EQ(CameraFileName("top-left_2", 5), "top-left_2");
    EXPECT_EQ(CameraFileName("3", 5), "3");
    EXPECT_EQ(CameraFileName("../a/b.c", 5), "___a_b_c") << "leaves no folder";
    EXPECT_EQ(CameraFileName("{camera}#", 5), "_camera__");
    EXPECT_EQ(CameraFileName("0 1 3.2 0 1 0 0 1 0 30", 5), "5");
    EXPECT_EQ(CameraFileName("0,1,3.2,0,1,0,0,1,0,30", 5), "5");
    EXPECT_EQ(CameraFileName("", 5), "5");
}

TEST(PictureList, OfNeitherFramesNorCamerasThereIsOnePicture) {
    const auto pictures = PicturesToRender({});
    ASSERT_EQ(pictures.size(), 1u);
    EXPECT_FALSE(pictures[0].at || pictures[0].camera || pictures[0].name.number || pictures[0].name.camera);
    EXPECT_EQ(pictures[0].label, "");
}

TEST(PictureList, FrameByFrameAndInEachCameraByCamera) {
    RenderArguments arguments;
    arguments.frames = FrameRange{1.0, 1.5, 0.5};
    arguments.cameras = {"top", "0 1 5 0 0 0 0 1 0 40"};
    arguments.outputs = {ParseOutput("{camera}.#.exr"), ParseOutput("{camera}.#.png")};
    arguments.resume = "{camera}.#.exr";
    const auto pictures = PicturesToRender(arguments);
    ASSERT_EQ(pictures.size(), 4u);
    EXPECT_EQ(pictures[1].label, "frame 1 of 2, camera 2 of 2");
    EXPECT_EQ(pictures[2].label, "frame 2 of 2, camera 1 of 2");
    EXPECT_EQ(pictures[1].at, 1.0);
    EXPECT_EQ(pictures[2].at, 1.5);
    EXPECT_EQ(pictures[2].camera, "top");
    EXPECT_EQ(pictures[3].camera, arguments.cameras[1]) << "as given, not as in names";
    EXPECT_EQ(Named("{camera}.#", pictures[3].name), "1.3");

    const CommandFiles files = FilesOf(arguments);
    EXPECT_EQ(files.outputs,
              (std::vector<std::filesystem::path>{"top.2.exr", "top.2.png", "1.2.exr", "1.2.png", "top.3.exr",
                                                  "top.3.png", "1.3.exr", "1.3.png"}));
    EXPECT_EQ(files.updated.size(), 4u);

    arguments.cameras.clear();
    EXPECT_EQ(PicturesToRender(arguments)[1].label, "frame 2 of 2");
    arguments.frames.reset();
    arguments.cameras = {"0", "1"};
    EXPECT_EQ(PicturesToRender(arguments)[1].label, "camera 2 of 2");
}

}  // namespace
}  // namespace raygraph::cli::picture_list_test

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

// Tests --shard: the parts by text and by the variables of launchers.
namespace raygraph::cli::shard_test {

// Prints failed comparisons.
void PrintTo(const Shard& shard, std::ostream* out) {
    *out << shard.index << "/" << shard.count;
}

namespace {

using test::ExpectError;
using Environment = std::map<std::string, std::string>;

Shard Auto(const Environment& environment) {
    return ParseShard("auto", [&](const char* name) {
        const auto variable = environment.find(name);
        return variable == environment.end() ? nullptr : variable->second.c_str();
    });
}

// Returns the variables that Slurm 22.05 sets for `--array=first-last:step`.
Environment ArrayTask(int id, int first, int last, int step, int count) {
    return {{"SLURM_JOB_ID", "9"},
            {"SLURM_PROCID", "0"},
            {"SLURM_ARRAY_JOB_ID", "8"},
            {"SLURM_ARRAY_TASK_ID", std::to_string(id)},
            {"SLURM_ARRAY_TASK_MIN", std::to_string(first)},
            {"SLURM_ARRAY_TASK_MAX", std::to_string(last)},
            {"SLURM_ARRAY_TASK_STEP", std::to_string(step)},
            {"SLURM_ARRAY_TASK_COUNT", std::to_string(count)}};
}

Environment With(Environment environment, const Environment& more) {
    for (const auto& [name, value] : more) environment[name] = value;
    return environment;
}

Environment Step(int process, int count) {
    return {{"SLURM_JOB_ID", "9"},
            {"SLURM_STEP_ID", "0"},
            {"SLURM_PROCID", std::to_string(process)},
            {"SLURM_NTASKS", std::to_string(count)}};
}

void ExpectNoShard(const Environment& environment, const std::string& text) {
    ExpectError(
        ErrorKind::Usage, [&] { Auto(environment); }, "auto: ", text);
}

TEST(Shard, PartsAreDisjointInOrderAndHaveAll) {
    for (const uint32_t total : {0u, 1u, 2u, 10u, 64u, 1000u, 4294967295u})
        for (const uint32_t count : {1u, 2u, 3u, 7u, 64u, 1001u}) {
            uint32_t end = 0;
            for (uint32_t index = 0; index < count; ++index) {
                const ShardPart part = PartOf({index, count}, total);
                EXPECT_EQ(part.begin, end) << index << "/" << count << " of " << total;
                EXPECT_EQ(part.begin, uint64_t{total} * index / count);
                EXPECT_GE(part.end - part.begin, total / count);
                EXPECT_LE(part.end - part.begin, total / count + (total % count != 0));
                end = part.end;
            }
            EXPECT_EQ(end, total) << count;
        }
    constexpr uint32_t kMost = std::numeric_limits<uint32_t>::max();
    EXPECT_EQ(PartOf({kMost - 1, kMost}, kMost).begin, kMost - 1) << "without overflow";
}

TEST(Shard, IsGivenByIndexAndCount) {
    EXPECT_EQ(ParseShard("0/1"), (Shard{0, 1}));
    EXPECT_EQ(ParseShard("15/16"), (Shard{15, 16}));
    for (const char* text : {"", "1", "/", "1/", "/2", "a/2", "1/b", "-1/2", "1/2/3", "1 /2", "AUTO", "0/0"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseShard(text); }, "");
    ExpectError(
        ErrorKind::Usage, [] { ParseShard("16/16"); }, "numbered from 0 to 15");
    ExpectError(
        ErrorKind::Usage, [] { ParseShard("half"); }, "\"half\" is neither I/N nor auto");
}

TEST(Shard, TaskOfAJobArray) {
    EXPECT_EQ(Auto(ArrayTask(0, 0, 15, 1, 16)), (Shard{0, 16}));
    EXPECT_EQ(Auto(ArrayTask(15, 0, 15, 1, 16)), (Shard{15, 16}));
    EXPECT_EQ(Auto(ArrayTask(1, 1, 4, 1, 4)), (Shard{0, 4})) << "indices may begin with 1";
    EXPECT_EQ(Auto(ArrayTask(40, 10, 40, 10, 4)), (Shard{3, 4})) << "and lie apart";
    EXPECT_EQ(Auto(ArrayTask(7, 7, 7, 1, 1)), (Shard{0, 1}));
    // The job script is one process, however many tasks of srun its job has room for
    EXPECT_EQ(Auto(With(ArrayTask(2, 0, 2, 1, 3), {{"SLURM_NTASKS", "4"}})), (Shard{2, 3}));
}

TEST(Shard, ProcessOfSrunOrMpirun) {
    EXPECT_EQ(Auto(Step(3, 4)), (Shard{3, 4}));
    EXPECT_EQ(Auto({{"OMPI_COMM_WORLD_RANK", "1"}, {"OMPI_COMM_WORLD_SIZE", "2"}}), (Shard{1, 2}));
    // mpirun starts the processes of a Slurm job through one step with a task on each node
    EXPECT_EQ(Auto(With(Step(1, 2), {{"OMPI_COMM_WORLD_RANK", "5"}, {"OMPI_COMM_WORLD_SIZE", "8"}})),
              (Shard{5, 8}));
}

TEST(Shard, ProcessesInATaskOfAnArrayDivideItsPart) {
    for (int task = 0; task < 3; ++task)
        for (int process = 0; process < 4; ++process) {
            const Shard expected{static_cast<uint32_t>(4 * task + process), 12};
            EXPECT_EQ(Auto(With(ArrayTask(5 + task, 5, 7, 1, 3), Step(process, 4))), expected);
            EXPECT_EQ(
                Auto(With(ArrayTask(task, 0, 2, 1, 3), {{"OMPI_COMM_WORLD_RANK", std::to_string(process)},
                                                        {"OMPI_COMM_WORLD_SIZE", "4"}})),
                expected);
        }
    ExpectNoShard(With(ArrayTask(0, 0, 65535, 1, 65536), Step(0, 65536)), "65536 times 65536");
}

TEST(Shard, VariablesThatAreMissingOrMalformedAreNamed) {
    ExpectNoShard({}, "SLURM_ARRAY_TASK_ID, SLURM_PROCID and OMPI_COMM_WORLD_RANK");
    ExpectNoShard({{"SLURM_JOB_ID", "9"}, {"SLURM_PROCID", "0"}, {"SLURM_NTASKS", "4"}},
                  "SLURM_ARRAY_TASK_ID is not set, and neither is SLURM_STEP_ID");
    for (const char* name : {"COUNT", "MIN", "MAX", "STEP"}) {
        Environment environment = ArrayTask(0, 0, 15, 1, 16);
        const std::string variable = std::string("SLURM_ARRAY_TASK_") + name;
        environment.erase(variable);
        ExpectNoShard(environment, variable + " is not set");
        environment[variable] = "4x";
        ExpectNoShard(environment, variable + ": \"4x\"");
    }
    ExpectNoShard(With(ArrayTask(0, 0, 1, 1, 2), {{"SLURM_ARRAY_TASK_ID", ""}}), "SLURM_ARRAY_TASK_ID: \"\"");
    ExpectNoShard(With(ArrayTask(0, 0, 1, 1, 2), {{"SLURM_ARRAY_TASK_STEP", "0"}}),
                  "SLURM_ARRAY_TASK_STEP: ");
    ExpectNoShard({{"OMPI_COMM_WORLD_RANK", "1"}}, "OMPI_COMM_WORLD_SIZE is not set");
    ExpectNoShard({{"OMPI_COMM_WORLD_SIZE", "1"}}, "OMPI_COMM_WORLD_RANK is not set");
    ExpectNoShard({{"OMPI_COMM_WORLD_RANK", "2"}, {"OMPI_COMM_WORLD_SIZE", "2"}}, "2 is not below");
    ExpectNoShard({{"SLURM_STEP_ID", "0"}, {"SLURM_PROCID", "1"}}, "SLURM_NTASKS is not set");
    ExpectNoShard({{"SLURM_STEP_ID", "0"}, {"SLURM_NTASKS", "2"}}, "SLURM_PROCID is not set");
}

// The variables of `--array=1,3,7`, and of a range with some tasks repeated, do not determine the part.
TEST(Shard, AnArrayThatIsNoRangeIsRefused) {
    ExpectNoShard(ArrayTask(3, 1, 7, 1, 3), "not the tasks of one range");
    ExpectNoShard(ArrayTask(3, 0, 4, 2, 3), "not the tasks of one range");
    ExpectNoShard(ArrayTask(5, 0, 4, 1, 5), "not the tasks of one range");
    ExpectNoShard(ArrayTask(0, 1, 4, 1, 4), "not the tasks of one range");
}

TEST(Shard, FramesOfAPartHaveTheirTimesAndNumbers) {
    const FrameRange whole = ParseFrames("4:5.96:0.04");
    ASSERT_EQ(whole.Count(), 50u);
    uint32_t done = 0;
    for (const uint32_t index : {0u, 1u, 2u}) {
        const FrameRange part = PartOf(Shard{index, 3}, whole);
        for (uint32_t i = 0; i < part.Count(); ++i, ++done) {
            EXPECT_EQ(part.TimeOf(i), whole.TimeOf(done));
            EXPECT_EQ(part.NumberOf(i), whole.NumberOf(done));
        }
    }
    EXPECT_EQ(done, 50u);
    EXPECT_EQ(PartOf(Shard{0, 2}, ParseFrames("1:1:1")).Count(), 0u);
    EXPECT_EQ(PartOf(Shard{1, 2}, ParseFrames("1:1:1")).Count(), 1u);
}

}  // namespace
}  // namespace raygraph::cli::shard_test

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
