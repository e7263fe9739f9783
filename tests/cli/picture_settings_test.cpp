// Tests that every field that a picture depends on is recorded, so that different pictures are never mixed.
#include <gtest/gtest.h>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "base/error.h"
#include "editor/cli/aov_request.h"
#include "editor/cli/outputs.h"
#include "editor/cli/report.h"
#include "editor/cli/scene_text.h"
#include "editor/session/file/sample_ranges.h"
#include "editor/session/settings/bias.h"
#include "editor/session/settings/light_groups.h"
#include "editor/session/settings/light_settings.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/picture_settings.h"
#include "editor/session/settings/setting_table.h"
#include "tests/cli/cli_test.h"
#include "tests/support/option_rows.h"

namespace raygraph::session::picture_settings_test {
namespace {

struct Row {
    const char* setting;
    void (*change)(PictureSettings&);
};

// Returns settings in which every field has an effect: some matter only if another has a certain value.
PictureSettings Plain() {
    PictureSettings settings;
    settings.crop = passes::Region{0, 0, 8, 8};
    settings.at = 1.0;
    settings.shutter = Shutter{0.0, 0.5};
    settings.paths.roulette.kind = Roulette::Constant;
    settings.background = {0.0f, 0.0f, 0.0f};
    settings.light = DefaultLight::None;
    settings.lightGroups = {{"key", {"lamp"}}};
    return settings;
}

const Row kRows[] = {
    {"size", [](PictureSettings& s) { s.size.width = 64; }},
    {"size", [](PictureSettings& s) { s.size.height = 64; }},
    {"crop", [](PictureSettings& s) { s.crop->x = 1; }},
    {"crop", [](PictureSettings& s) { s.crop->y = 1; }},
    {"crop", [](PictureSettings& s) { s.crop->width = 7; }},
    {"crop", [](PictureSettings& s) { s.crop->height = 7; }},
    {"crop", [](PictureSettings& s) { s.crop.reset(); }},
    {"view", [](PictureSettings& s) { s.view = View::Depth; }},
    {"camera", [](PictureSettings& s) { s.camera = "Eye"; }},
    {"scene", [](PictureSettings& s) { s.scene = "Second"; }},
    {"variant", [](PictureSettings& s) { s.variant = "red"; }},
    {"at", [](PictureSettings& s) { s.at = std::nextafter(1.0, 2.0); }},
    {"at", [](PictureSettings& s) { s.at.reset(); }},
    {"clips", [](PictureSettings& s) { s.clips = "walk"; }},
    {"shutter", [](PictureSettings& s) { s.shutter->open = 0.25; }},
    {"shutter", [](PictureSettings& s) { s.shutter->close = 0.25; }},
    {"shutter", [](PictureSettings& s) { s.shutter.reset(); }},
    {"points", [](PictureSettings& s) { s.pointsAndLines.points = scene::ParseRoundRadius("0.1"); }},
    {"points", [](PictureSettings& s) { s.pointsAndLines.points = scene::ParseRoundRadius("0.1%"); }},
    {"lines", [](PictureSettings& s) { s.pointsAndLines.lines = scene::ParseRoundRadius("0.1"); }},
    {"aperture", [](PictureSettings& s) { s.aperture = 0.1f; }},
    {"focus", [](PictureSettings& s) { s.focusDistance = 0.1f; }},
    {"sampler", [](PictureSettings& s) { s.paths.sampler = SamplerKind::Tea; }},
    {"seed", [](PictureSettings& s) { s.paths.seed = 4294967295u; }},
    {"brdf", [](PictureSettings& s) { s.paths.scattering.brdf = BrdfModel::Lambert; }},
    {"distribution", [](PictureSettings& s) { s.paths.scattering.distribution = MicrofacetModel::Phong; }},
    {"masking", [](PictureSettings& s) { s.paths.scattering.masking = MaskingModel::Separable; }},
    {"fresnel", [](PictureSettings& s) { s.paths.scattering.fresnel = FresnelModel::Lazanyi; }},
    {"multiscatter", [](PictureSettings& s) { s.paths.scattering.multiscatter = MultiscatterKind::Off; }},
    {"nee", [](PictureSettings& s) { s.paths.lights.isOn = false; }},
    {"light-sampler", [](PictureSettings& s) { s.paths.lights.sampler = LightSampler::Uniform; }},
    {"mis", [](PictureSettings& s) { s.paths.lights.mis = MisHeuristic::Off; }},
    {"rr", [](PictureSettings& s) { s.paths.roulette.kind = Roulette::Frame; }},
    {"rr-start", [](PictureSettings& s) { s.paths.roulette.start = 17; }},
    {"rr", [](PictureSettings& s) { s.paths.roulette.survival = 0.25f; }},
    {"max-depth", [](PictureSettings& s) { s.paths.biases.maxDepth = 0; }},
    {"clamp-indirect", [](PictureSettings& s) { s.paths.biases.clampIndirect = 1.0f; }},
    {"regularize", [](PictureSettings& s) { s.paths.biases.regularize = 0.1f; }},
    {"shadow-terminator", [](PictureSettings& s) { s.paths.biases.shadowTerminator = true; }},
    {"texture-lod", [](PictureSettings& s) { s.paths.biases.textureLod = 0.0f; }},
    {"transparent", [](PictureSettings& s) { s.paths.isEnvironmentHidden = true; }},
    {"shadows", [](PictureSettings& s) { s.raster.shadows = passes::RasterShadows::Maps; }},
    {"env-rotation", [](PictureSettings& s) { s.environmentRotation = 0.1f; }},
    {"env-tint", [](PictureSettings& s) { s.environmentTint[0] = 0.5f; }},
    {"env-tint", [](PictureSettings& s) { s.environmentTint[1] = 0.5f; }},
    {"env-tint", [](PictureSettings& s) { s.environmentTint[2] = 0.5f; }},
    {"background", [](PictureSettings& s) { (*s.background)[0] = 0.5f; }},
    {"background", [](PictureSettings& s) { (*s.background)[1] = 0.5f; }},
    {"background", [](PictureSettings& s) { (*s.background)[2] = 0.5f; }},
    {"background", [](PictureSettings& s) { s.background.reset(); }},
    {"ground", [](PictureSettings& s) { s.hasGround = true; }},
    {"light", [](PictureSettings& s) { s.light = DefaultLight::Studio; }},
    {"adaptive", [](PictureSettings& s) { s.isAdaptive = true; }},
    {"texture-budget", [](PictureSettings& s) { s.textureBudget = 1u << 20; }},
    {"light-group", [](PictureSettings& s) { s.lightGroups[0].name = "fill"; }},
    {"light-group", [](PictureSettings& s) { s.lightGroups[0].patterns = {"bulb"}; }},
};

// One other value stands for all of an enumeration; the parser's tests show that each has a text.
template <typename Enum>
int Number(Enum value) {
    return static_cast<int>(value);
}

auto FieldsOf(PictureSettings& settings) {
    auto& [size, crop, view, camera, scene, variant, at, clips, shutter, pointsAndLines, aperture,
           focusDistance, paths, raster, environmentRotation, environmentTint, background, hasGround, light,
           isAdaptive, textureBudget, lightGroups] = settings;
    auto& [points, lines] = pointsAndLines;
    auto& [sampler, seed, scattering, lights, roulette, biases, isEnvironmentHidden] = paths;
    auto& [brdf, distribution, masking, fresnel, multiscatter] = scattering;
    auto& [isOn, lightSampler, mis] = lights;
    auto& [kind, start, survival] = roulette;
    auto& [maxDepth, clampIndirect, regularize, shadowTerminator, textureLod] = biases;
    // No option changes these, so they are not recorded
    auto& [shadows, shadowAtlasSize, hasOcclusion, hasTransmission, hasTextureLevels] = raster;
    return std::tuple(size, crop, Number(view), camera, scene, variant, at, clips, shutter, points, lines,
                      aperture, focusDistance, Number(sampler), seed, Number(brdf), Number(distribution),
                      Number(masking), Number(fresnel), Number(multiscatter), isOn, Number(lightSampler),
                      Number(mis), Number(kind), start, survival, maxDepth, clampIndirect, regularize,
                      shadowTerminator, textureLod, isEnvironmentHidden, Number(shadows), environmentRotation,
                      environmentTint, background, hasGround, Number(light), isAdaptive, textureBudget,
                      lightGroups);
}

TEST(PictureSettings, EveryFieldIsInTheTexts) {
    auto rows = testing::OptionRowsOf<PictureSettings>([](PictureSettings& s) { return FieldsOf(s); });
    const SettingTexts plain = Texts(Plain());
    std::set<std::string> changed;
    for (const Row& row : kRows) {
        SCOPED_TRACE(row.setting);
        PictureSettings settings = Plain();
        row.change(settings);
        rows.Add(row.setting, Plain(), settings);
        changed.insert(row.setting);
        const SettingTexts texts = Texts(settings);
        EXPECT_EQ(FirstDifference(plain, texts).find(std::string(row.setting) + ": "), 0u);
        SettingTexts others = texts;
        others[row.setting] = plain.at(row.setting);
        EXPECT_EQ(others, plain) << "another setting has changed";
        EXPECT_EQ(FieldsOf(settings), [&] {
            PictureSettings read = SettingsFrom(texts);
            return FieldsOf(read);
        }());
    }
    rows.ExpectComplete();
    for (const PictureSetting& setting : PictureSettingTable())
        EXPECT_TRUE(changed.contains(setting.name)) << setting.name << " has no row";
}

}  // namespace
}  // namespace raygraph::session::picture_settings_test

namespace raygraph::session::parse_test {

using test::ExpectError;

TEST(Parse, CountIsDigitsAloneAndInRange) {
    EXPECT_EQ(ParseCount("0"), 0u);
    EXPECT_EQ(ParseCount("4294967295"), 4294967295u);
    for (const char* text : {"", " 1", "1 ", "+1", "-1", "1.0", "0x10", "1e3", "4294967296", "64spp"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseCount(text); }, std::string("\"") + text + "\"", "whole number");
    ExpectError(
        ErrorKind::Usage, [] { ParseCount("0", 1, 8); }, "from 1 to 8");
    ExpectError(
        ErrorKind::Usage, [] { ParseCount("9", 1, 8); }, "from 1 to 8");
}

// Such texts may also come from stored renders.
TEST(Parse, RefusalsQuoteTheTextWithoutControlCharacters) {
    for (const auto& parse : {std::function<void()>([] { ParseCount("\x1b[31m"); }),
                              std::function<void()>([] { ParseSampleRanges("0-\x1b[31m"); }),
                              std::function<void()>([] { ParseLightGroups("a\x1b[31m=b"); })}) {
        try {
            parse();
            ADD_FAILURE() << "is read";
        } catch (const Error& error) {
            EXPECT_EQ(std::string(error.what()).find('\x1b'), std::string::npos) << error.what();
        }
    }
}

TEST(Parse, NumberIsFiniteWholeTextAndInRange) {
    EXPECT_EQ(ParseNumber("-1.5"), -1.5);
    EXPECT_EQ(ParseNumber("2e3"), 2000.0);
    for (const char* text : {"", "nan", "inf", "-inf", "1,5", "1.5x", " 1", "1e999"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseNumber(text); }, "is not a number");
    ExpectError(
        ErrorKind::Usage, [] { ParseNumber("-0.1", 0.0); }, "at least 0");
    ExpectError(
        ErrorKind::Usage, [] { ParseNumber("101", -100.0, 100.0); }, "from -100 to 100");
}

TEST(Parse, SizeIsTwoSidesOfAtLeastOnePixel) {
    EXPECT_EQ(ParseSize("640x360"), (Extent2D{640, 360}));
    EXPECT_EQ(ParseSize("1x16384"), (Extent2D{1, 16384}));
    for (const char* text : {"", "x", "640", "640x", "x360", "640X360", "640x360x1", "0x10", "10x0",
                             "640*360", "16385x1", "-1x2", "99999999999x1"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseSize(text); }, "640x360");
}

TEST(Parse, BudgetIsASizeInMemoryOrAutomatic) {
    EXPECT_EQ(ParseBudget("auto"), 0u);
    EXPECT_EQ(ParseBudget("1"), 1u);
    EXPECT_EQ(ParseBudget("64K"), 65536u);
    EXPECT_EQ(ParseBudget("512M"), uint64_t{512} << 20);
    EXPECT_EQ(ParseBudget("1.5G"), uint64_t{1536} << 20);
    for (const char* text :
         {"", "0", "K", "0.5", "-1M", "1T", "1m", "1MB", "2e15", "1048577G", "nan", "Auto"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseBudget(text); }, "is not auto or a size like 512M or 1.5G");
    for (const uint64_t bytes : {0ull, 1ull, 1000ull, 1024ull, 1536ull << 20, 3ull << 30, (3ull << 30) + 1})
        EXPECT_EQ(ParseBudget(BudgetText(bytes)), bytes);
    EXPECT_EQ(BudgetText(uint64_t{1536} << 20), "1536M");
    EXPECT_EQ(BudgetText(0), "auto");
}

TEST(Parse, RadianceIsThreeNumbersThatAreNotNegative) {
    EXPECT_EQ(ParseRadiance("0,0.5,2e1"), (std::array<float, 3>{0.0f, 0.5f, 20.0f}));
    EXPECT_EQ(ParseColor("0,0.5,2e1"), (std::array<float, 3>{0.0f, 0.5f, 20.0f}));
    EXPECT_EQ(ParseColor("0.25"), (std::array<float, 3>{0.25f, 0.25f, 0.25f}));
    EXPECT_EQ(ParseColor("white"), (std::array<float, 3>{1.0f, 1.0f, 1.0f}));
    EXPECT_EQ(ParseColor("#FF0000"), ParseColor("red"));
    const std::array<float, 3> mixed = ParseColor("#0a80ff");
    EXPECT_NEAR(mixed[0], 10.0f / 255 / 12.92f, 1e-6f);
    EXPECT_NEAR(mixed[1], 0.21586f, 1e-5f);
    EXPECT_EQ(mixed[2], 1.0f);
    for (const char* text : {"", "-1", "#12345", "#12345g", "#1234567", "1,2", "mauve"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseColor(text); }, "#rrggbb");
    for (const char* text :
         {"", "1", "1,2", "1,2,3,4", "1,,3", "1,2,", "a,b,c", "-1,0,0", "nan,0,0", "1 2 3", "1e39,0,0"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseRadiance(text); }, "three numbers");
}

TEST(Parse, ListHasNoEmptyParts) {
    EXPECT_EQ(ParseList("a,bc"), (std::vector<std::string_view>{"a", "bc"}));
    for (const char* text : {"", ",", "a,", ",a", "a,,b"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseList(text); }, "list");
}

TEST(Parse, ChoiceNamesWhatThereIs) {
    EXPECT_EQ(ParseChoice("pcg", {"sobol", "pcg", "tea"}), 1u);
    ExpectError(
        ErrorKind::Usage,
        [] {
            ParseChoice("Sobol", {"sobol", "pcg", "tea"});
        },
        "\"Sobol\"", "one of sobol, pcg or tea");
}

TEST(Parse, TextOfANumberReadsBackAsTheSameNumber) {
    for (const float value : {0.0f, -1.5f, 0.1f, 1.0f / 3.0f, 3.4e38f, 1.17549435e-38f})
        EXPECT_EQ(static_cast<float>(ParseNumber(ToText(value))), value);
    EXPECT_EQ(ParseSize(ToText(Extent2D{12, 7})), (Extent2D{12, 7}));
    const std::array<float, 3> radiance{0.1f, 7.0f, 1e-20f};
    EXPECT_EQ(ParseRadiance(ToText(radiance)), radiance);
}

}  // namespace raygraph::session::parse_test

namespace raygraph::session::bias_test {
namespace {

passes::TraceSettings AllOn() {
    passes::TraceSettings settings;
    settings.biases = {.maxDepth = 3,
                       .clampIndirect = 2.0f,
                       .regularize = 0.1f,
                       .shadowTerminator = true,
                       .textureLod = 0.0f};
    return settings;
}

TEST(Bias, OnlyWhatWasAskedForIsOn) {
    for (const Bias bias : kBiases) {
        EXPECT_FALSE(IsOn({}, bias)) << Name(bias);
        EXPECT_TRUE(IsOn(AllOn().biases, bias)) << Name(bias);
    }
    EXPECT_TRUE(IsOn({.maxDepth = 0}, Bias::MaxDepth));
}

TEST(Bias, WithoutOneTheOthersStay) {
    for (const Bias off : kBiases)
        for (const Bias bias : kBiases)
            EXPECT_EQ(IsOn(Without(AllOn(), off).biases, bias), bias != off) << Name(off) << Name(bias);
}

TEST(Bias, PathsThatOnlyTheDepthEndsEndByRoulette) {
    passes::TraceSettings settings = AllOn();
    settings.roulette.kind = Roulette::Off;
    EXPECT_EQ(Without(settings, Bias::MaxDepth).roulette.kind, Roulette::Throughput);
    EXPECT_EQ(Without(settings, Bias::ClampIndirect).roulette.kind, Roulette::Off);
    settings.roulette = {.kind = Roulette::Constant, .survival = 0.5f};
    EXPECT_EQ(Without(settings, Bias::MaxDepth).roulette.kind, Roulette::Constant);
    settings.roulette.survival = 1.0f;
    EXPECT_EQ(Without(settings, Bias::MaxDepth).roulette.kind, Roulette::Throughput);
}

TEST(Bias, RemovedLightIsMeasuredAsLuminance) {
    // Two gray pixels, and one red
    const std::vector<float> removed{1, 1, 1, 0, 3, 3, 3, 0, 1, 0, 0, 0};
    const std::vector<float> variance{4, 4, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    const std::vector<float> picture{5, 5, 5, 1, 5, 5, 5, 1, 5, 5, 5, 1};
    const RemovedLight light = MeasureRemoved(removed, variance, 4, picture);
    const double mean = (1.0 + 3.0 + 0.2126) / 3.0;
    EXPECT_NEAR(light.mean, mean, 1e-6);
    ASSERT_TRUE(light.standardError && light.share && light.shareStandardError);
    EXPECT_NEAR(*light.standardError, std::sqrt(4.0 / 4) / 3.0, 1e-6);
    EXPECT_NEAR(*light.share, mean / (5.0 + mean), 1e-6);
    EXPECT_NEAR(*light.shareStandardError, *light.standardError / (5.0 + mean), 1e-6);
    EXPECT_EQ(light.samples, 4u);
}

TEST(Bias, OneSecondTraceHasNoStandardErrorAndDarknessNoShare) {
    const std::vector<float> half(4, 0.5f), black(4, 0.0f);
    EXPECT_FALSE(MeasureRemoved(half, black, 1, half).standardError);
    EXPECT_TRUE(MeasureRemoved(half, black, 1, half).share);
    EXPECT_FALSE(MeasureRemoved(black, black, 8, black).share);
}

TEST(Bias, IsDescribedWithItsShareAndError) {
    EXPECT_EQ(cli::Describe(Bias::MaxDepth, {.share = 0.25, .shareStandardError = 0.003}),
              "--max-depth removed 25 % +- 0.3 % of the light");
    EXPECT_EQ(cli::Describe(Bias::Regularize, {.share = -0.0125}),
              "--regularize removed -1.25 % of the light");
}

TEST(Bias, AovsAreThoseOfTheBiasesThatAreOn) {
    PictureSettings settings;
    settings.paths.biases.maxDepth = 3;
    const AovSet all = cli::AovsFor(cli::ParseAovs("all"), settings);
    EXPECT_TRUE(all.Has(Aov::RemovedMaxDepth) && all.Has(Aov::Emission));
    EXPECT_FALSE(all.Has(Aov::RemovedClampIndirect) || all.Has(Aov::RemovedRegularize));
    test::ExpectError(
        ErrorKind::Usage, [&] { cli::AovsFor(cli::ParseAovs("removed_regularize"), settings); },
        "--aov removed_regularize", "--regularize is off");
}

}  // namespace
}  // namespace raygraph::session::bias_test

// Tests the color of a scene's light against closed forms.
namespace raygraph::session::light_color_test {
namespace {

using std::numbers::pi;

void ExpectColor(const std::optional<glm::dvec3>& color, const glm::dvec3& expected) {
    ASSERT_TRUE(color.has_value());
    for (int c = 0; c < 3; ++c) EXPECT_NEAR((*color)[c], expected[c], 1e-6 * (1.0 + expected[c])) << c;
}

// Makes a square of side 2, scaled by 3, that emits (1, 2, 4) on one side.
SceneInput Square() {
    SceneInput input;
    scene::SceneData& scene = input.data;
    scene.materials.push_back({.emissiveFactor = {0.5f, 1.0f, 2.0f}, .emissiveStrength = 2.0f});
    scene::Primitive& primitive = scene.meshes.emplace_back().primitives.emplace_back();
    primitive.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    primitive.indices = {0, 1, 2, 0, 2, 3};
    primitive.bounds = {{-1, -1, 0}, {1, 1, 0}};
    scene.instances.emplace_back().objectToWorld[0] = {3, 0, 0};
    scene.instances[0].objectToWorld[1] = {0, 3, 0};
    scene.instances[0].objectToWorld[2] = {0, 0, 3};
    scene.bounds = {{-3, -3, 0}, {3, 3, 0}};
    return input;
}
constexpr double kRadius2 = 18.0;  // squared radius of these bounds

TEST(LightColor, OfSurfaces) {
    SceneInput input = Square();
    const double power = pi * 36.0;
    ExpectColor(LightColor(input, {}), power * glm::dvec3(1, 2, 4));
    input.data.materials[0].isDoubleSided = true;
    ExpectColor(LightColor(input, {}), 2.0 * power * glm::dvec3(1, 2, 4));
    // One texture has a white and a black texel, and the image of another is half as bright: the mean is in
    // linear light
    input.data.materials[0].isDoubleSided = false;
    input.data.materials[0].emissiveTexture.texture = 0;
    input.data.textures.push_back({.image = 0, .colorSpace = scene::ColorSpace::Srgb});
    input.data.images.push_back({.width = 2, .height = 1, .rgba = {255, 255, 0, 255, 0, 188, 0, 0}});
    const double half = std::pow((188.0 / 255.0 + 0.055) / 1.055, 2.4);
    EXPECT_NEAR(half, 0.5, 5e-3);
    ExpectColor(LightColor(input, {}), power * glm::dvec3(0.5, 2.0 * (1.0 + half) / 2.0, 0.0));
    input.data.materials[0].isUnlit = true;
    EXPECT_FALSE(LightColor(input, {})) << "a picture, and no lamp";
}

TEST(LightColor, OfRoundPrimitivesThatAreScaled) {
    SceneInput input = Square();
    scene::Primitive& sphere = input.data.meshes[0].primitives[0];
    sphere.positions = {{0, 0, 0}};
    sphere.indices = {0, 0};
    sphere.radii = {0.5f};
    sphere.bounds = {{-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}};
    const PictureSettings dark{.light = DefaultLight::None};
    ExpectColor(LightColor(input, dark), pi * 4.0 * pi * 1.5 * 1.5 * glm::dvec3(1, 2, 4));
    // A sphere flattened to a disc has two sides, with a total area of 2 pi r^2
    input.data.instances[0].objectToWorld[2] = {0, 0, 1e-4f};
    const std::optional<glm::dvec3> disc = LightColor(input, dark);
    ASSERT_TRUE(disc);
    EXPECT_NEAR(disc->x, pi * 2.0 * pi * 1.5 * 1.5, 0.2 * pi * 2.0 * pi * 1.5 * 1.5);
}

TEST(LightColor, WhatIsHiddenDoesNotShine) {
    SceneInput input = Square();
    const PictureSettings dark{.light = DefaultLight::None};
    input.data.nodes.emplace_back().isVisible = false;
    input.data.nodeOrder = {0};
    input.data.instances[0].node = 0;
    scene::Light& light = input.data.lights.emplace_back();
    light.node = 0;
    EXPECT_FALSE(LightColor(input, dark));
    input.data.nodes[0].isVisible = true;
    light.color = {1, 0, 0};
    light.intensity = 2.0f;
    const glm::dvec3 surfaces = pi * 36.0 * glm::dvec3(1, 2, 4);
    ExpectColor(LightColor(input, dark), surfaces + glm::dvec3(8.0 * pi, 0, 0));
    PictureSettings settings;
    settings.paths.lights.isOn = false;  // lights are not rendered then
    ExpectColor(LightColor(input, settings), surfaces);
}

TEST(LightColor, OfPunctualLights) {
    SceneInput input = Square();
    input.data.materials[0].emissiveFactor = glm::vec3(0.0f);
    scene::Light& light = input.data.lights.emplace_back();
    light.color = {1, 2, 3};
    light.intensity = 5.0f;
    light.type = scene::LightType::Directional;
    ExpectColor(LightColor(input, {}), pi * kRadius2 * 5.0 * glm::dvec3(1, 2, 3));
    light.type = scene::LightType::Spot;
    light.innerConeAngle = 0.5f;
    light.outerConeAngle = 0.7f;
    // Integrates over the cosine by the midpoint rule
    const double outer = std::cos(double{0.7f}), scale = 1.0 / (std::cos(double{0.5f}) - outer);
    double integral = 0.0;
    constexpr int kSteps = 200000;
    for (int i = 0; i < kSteps; ++i) {
        const double c = outer + (1.0 - outer) * (i + 0.5) / kSteps;
        const double falloff = std::min((c - outer) * scale, 1.0);
        integral += falloff * falloff * (1.0 - outer) / kSteps;
    }
    ExpectColor(LightColor(input, {}), 2.0 * pi * integral * 5.0 * glm::dvec3(1, 2, 3));
}

TEST(LightColor, OfTheEnvironment) {
    SceneInput input = Square();
    input.data.materials[0].emissiveFactor = glm::vec3(0.0f);
    PictureSettings settings;
    settings.background = {{0.5f, 1.0f, 2.0f}};
    const double share = 4.0 * pi * pi * kRadius2;
    ExpectColor(LightColor(input, settings), share * glm::dvec3(0.5, 1.0, 2.0));
    // A map replaces the background. The middle one of three rows is twice as long as each other: sin 90 and
    // 30 degrees
    input.environment = {1, 3, {0, 0, 0, 1, 4, 2, 0, 1, 0, 8, 0, 1}};
    settings.environmentTint = {1.0f, 0.5f, 1.0f};
    ExpectColor(LightColor(input, settings), share * glm::dvec3(2.0, 0.5 * (1.0 + 2.0), 0.0));
    // The scene's own map
    input.data.environment.map = input.environment;
    input.environment = {};
    ExpectColor(LightColor(input, settings), share * glm::dvec3(0.5, 1.0, 2.0));
    settings.background.reset();
    ExpectColor(LightColor(input, settings), share * glm::dvec3(2.0, 1.5, 0.0));
}

}  // namespace
}  // namespace raygraph::session::light_color_test

namespace raygraph::session::light_groups_test {
namespace {

using test::ExpectError;

constexpr uint32_t kRest = gpu::kLightGroupRest, kFirst = gpu::kLightGroupNamed;

TEST(LightGroups, TextIsReadAndWrittenBack) {
    const std::vector<LightGroupPatterns> groups = ParseLightGroups("key=lamp*,bulb;fill-2=window?");
    ASSERT_EQ(groups.size(), 2u);
    EXPECT_EQ(groups[0].name, "key");
    EXPECT_EQ(groups[0].patterns, (std::vector<std::string>{"lamp*", "bulb"}));
    EXPECT_EQ(ToText(groups), "key=lamp*,bulb;fill-2=window?");
    EXPECT_EQ(LightGroupNames(groups), (std::vector<std::string>{"rest", "environment", "key", "fill-2"}));
    EXPECT_TRUE(ParseLightGroups("").empty());
    EXPECT_TRUE(LightGroupNames({}).empty());
}

TEST(LightGroups, MistakesAreUsageErrors) {
    for (const char* text :
         {"key", "=lamp", "key=", "key=a,,b", "a.b=c", "rest=a", "environment=a", "a=b;a=c"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseLightGroups(text); }, "\"");
    ExpectError(
        ErrorKind::Usage, [] { ParseLightGroups("a=x;b=x;c=x;d=x;e=x;f=x;g=x;h=x;i=x"); }, "9 groups",
        "at most 8");
}

// Node 0 "ceiling" is above node 1 "panel", which places mesh and light; node 2 "floor" places a mesh.
scene::SceneData Scene() {
    scene::SceneData scene;
    scene.nodes = {{.name = "ceiling"}, {.name = "panel", .parent = 0}, {.name = "floor"}};
    scene.instances = {{.node = 1}, {.node = 2}, {}};
    scene.materials = {{.name = "glow"}, {.name = "wood"}};
    scene.lights = {{.name = "spot", .node = 1}, {.name = "sun"}};
    return scene;
}

TEST(LightGroups, NamesOfMaterialsLightsNodesAndThoseAboveFit) {
    const LightGroups groups = MatchLightGroups(ParseLightGroups("a=gl*,s?n;b=ceil*;c=fl[aio]or"), Scene());
    EXPECT_EQ(groups.namedCount, 3u);
    EXPECT_EQ(groups.materials, (std::vector<uint32_t>{kFirst, kRest}));
    EXPECT_EQ(groups.instances, (std::vector<uint32_t>{kFirst + 1, kFirst + 2, kRest}));
    EXPECT_EQ(groups.lights, (std::vector<uint32_t>{kFirst + 1, kFirst}));
}

TEST(LightGroups, TheFirstThatFitsHasTheLight) {
    const LightGroups groups = MatchLightGroups(ParseLightGroups("a=panel;b=ceiling;c=*"), Scene());
    EXPECT_EQ(groups.instances, (std::vector<uint32_t>{kFirst, kFirst + 2, kRest}));
    EXPECT_EQ(groups.lights[0], kFirst);
    EXPECT_EQ(FirstLightGroup(kRest, kFirst + 1), kFirst + 1);
    EXPECT_EQ(FirstLightGroup(kFirst + 1, kFirst), kFirst);
}

TEST(LightGroups, AGroupThatFitsNothingIsNamed) {
    ExpectError(
        ErrorKind::Usage, [] { MatchLightGroups(ParseLightGroups("a=glow;b=candle"), Scene()); },
        "light-group b=candle");
}

}  // namespace
}  // namespace raygraph::session::light_groups_test

namespace raygraph::cli::text_test {
namespace {

TEST(SceneText, NumbersAreGrouped) {
    EXPECT_EQ(GroupDigits(0), "0");
    EXPECT_EQ(GroupDigits(999), "999");
    EXPECT_EQ(GroupDigits(1000), "1,000");
    EXPECT_EQ(GroupDigits(1234567), "1,234,567");
}

TEST(SceneText, ALongListIsCut) {
    scene::SceneData data;
    data.materials.resize(25);
    data.materials[3].name = "red";
    const std::string text = DescribeScene("a.glb", data);
    EXPECT_NE(text.find("3  \"red\""), std::string::npos) << text;
    EXPECT_NE(text.find("... and 5 more"), std::string::npos) << text;
    EXPECT_NE(text.find("bounds      empty"), std::string::npos) << text;
    EXPECT_NE(text.find("cameras     none"), std::string::npos) << text;
}

TEST(SceneText, EnvironmentIsSaidWhereThereIsOne) {
    scene::SceneData data;
    EXPECT_EQ(DescribeScene("a.glb", data).find("environment"), std::string::npos);
    data.environment = {"evening", 256, {1, 1, {1, 1, 1, 1}}};
    const std::string text = DescribeScene("a.glb", data);
    EXPECT_NE(text.find("  environment \"evening\", a cube of 256 x 256; --env or --background replace it\n"),
              std::string::npos)
        << text;
}

TEST(SceneText, LightWithAProfileSaysHowBrightItIs) {
    scene::SceneData data;
    data.profiles.push_back({.vertical = {0.0f, 1.0f}, .horizontal = {0.0f}, .candela = {300.0f, 450.0f}});
    data.lights.push_back({.name = "panel", .intensity = 2.0f, .profile = 0});
    const std::string text = DescribeScene("a.glb", data);
    EXPECT_NE(text.find("0  \"panel\"  profile, at most 900 cd, color 1 1 1\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace raygraph::cli::text_test
