// Tests that every field that a picture depends on is recorded, so that different pictures are never mixed.
#include "editor/session/settings/picture_settings.h"

#include <cmath>
#include <set>
#include <string>
#include <tuple>

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
           focusDistance, paths, raster, environmentRotation, environmentTint, background, light, isAdaptive,
           textureBudget, lightGroups] = settings;
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
                      environmentTint, background, Number(light), isAdaptive, textureBudget, lightGroups);
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
