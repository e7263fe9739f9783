#include "editor/cli/arguments.h"

#include <algorithm>
#include <regex>

#include "base/text.h"
#include "editor/cli/exit_code.h"
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
        "lambert --device llvm --validate --report r.json --quiet");
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
    EXPECT_TRUE(a.isValidating && a.isQuiet);
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
}

TEST(Arguments, HelpNamesEveryOptionAndTheExitCodes) {
    const std::string help = std::get<ShowText>(Parse("render --help-all")).text;
    for (const PictureSetting& setting : PictureSettingTable())
        EXPECT_NE(help.find(std::string("--") + setting.name + " " + setting.operand), std::string::npos)
            << setting.name;
    EXPECT_NE(help.find("--resume FILE.exr"), std::string::npos) << help;
    for (const Aov aov : kAovs) EXPECT_NE(help.find(Name(aov)), std::string::npos) << Name(aov);
    const std::string overview = std::get<ShowText>(Parse("--help")).text;
    for (const char* text : {"render", "edit", "bench", "info", "graph", "merge", "completion"})
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

TEST(Arguments, HelpNamesEveryView) {
    const std::string help = std::get<ShowText>(Parse("render --help")).text;
    for (size_t i = 0; i < passes::kViewCount; ++i) {
        const std::string name = passes::Name(static_cast<View>(i));
        EXPECT_EQ(std::get<RenderArguments>(Parse("render a.gltf --view " + name)).given.at("view"), name);
        EXPECT_NE(help.find(name), std::string::npos) << name;
    }
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
