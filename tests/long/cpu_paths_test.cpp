// Tests that the integrator gives the numbers of the device when it is compiled as C++: path by path, over
// pictures of scenes with all that paths meet.
#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "editor/session/settings/bias.h"
#include "tests/explain/cpu_paths.h"
#include "tests/support/reference_assets.h"
#include "tests/support/source_file.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

namespace {

template <typename T>
void NoChange(T&) {}

struct CpuScene {
    const char* name;
    void (*change)(session::PictureSettings&) = NoChange;
    void (*changeInput)(session::SceneInput&) = NoChange;
    double mostApart = kMostPathsApart;
};

void HasLens(session::PictureSettings& settings) {
    settings.aperture = 0.02f;
    settings.paths.sampler = SamplerKind::Pcg;
    settings.paths.lights.mis = MisHeuristic::Balance;
}

void HasLevels(session::PictureSettings& settings) {
    settings.paths.biases.textureLod = 0.0f;
}

void HasRoundPrimitives(session::PictureSettings& settings) {
    settings.pointsAndLines.points = settings.pointsAndLines.lines = scene::ParseRoundRadius("0.02");
}

void Moves(session::PictureSettings& settings) {
    settings.at = 0.4;
    settings.clips = "0";
    settings.shutter = session::Shutter{.open = 0.0, .close = 0.1};
}

// A lobe that is 20 degrees wide and twice as bright along x, for all point lights; and a map with a sun.
void HasProfileAndMap(session::SceneInput& input) {
    scene::SceneData& data = input.data;
    const auto profile = static_cast<uint32_t>(data.profiles.size());
    data.profiles.push_back(
        {.name = "lobe",
         .vertical = {0.0f, 0.35f, 1.2f, 3.14159265f},
         .horizontal = {0.0f, 1.57079633f, 3.14159265f, 4.71238898f, 6.28318531f},
         .candela = {900, 700, 20, 0, 900, 350, 10, 0, 900, 700, 20, 0, 900, 350, 10, 0, 900, 700, 20, 0}});
    for (scene::Light& light : data.lights) {
        if (light.type != scene::LightType::Point) continue;
        light.profile = profile;
        light.intensity = 0.02f;
    }
    image::ImageF map{.width = 16, .height = 8, .rgba = std::vector<float>(16 * 8 * 4, 0.2f)};
    for (size_t c = 0; c < 3; ++c) map.rgba[(2 * 16 + 5) * 4 + c] = 60.0f;
    session::SetEnvironment(input, std::move(map), "sun.exr");
}

// Devices weight texels by 8 bits and may round the sum to the texels' bits (lavapipe does), which turns a
// normal by half a degree. Without a filter, a difference is a mistake.
void HasNoFilter(session::SceneInput& input) {
    for (scene::Texture& texture : input.data.textures)
        texture.sampler.magFilter = texture.sampler.minFilter = texture.sampler.mipFilter =
            scene::FilterMode::Nearest;
}

class CpuPaths : public VulkanTest, public ::testing::WithParamInterface<CpuScene> {
  protected:
    void Compare(const std::filesystem::path& file) {
        session::PictureSettings settings;
        settings.size = {32, 32};
        GetParam().change(settings);
        session::SceneInput input = session::LoadInput(file, session::InputOptionsFor(settings));
        GetParam().changeInput(input);
        const ComparedPaths compared = ComparePaths(Device(), std::move(input), settings, 3);
        std::cout << compared << '\n';
        ExpectSamePaths(compared, GetParam().mostApart);
    }
};
class KnownCpuPaths : public CpuPaths {};

std::string NameOfScene(const ::testing::TestParamInfo<CpuScene>& scene) {
    return scene.param.name;
}

}  // namespace

TEST_P(CpuPaths, OfOwnScene_AreThoseOfTheDevice) {
    Compare(test::SourceFile("scenes") / (std::string(GetParam().name) + ".gltf"));
}

// Mirrors of 2 cm turn a rounding by 1e-5 into another path within three bounces.
constexpr double kMostPathsApartAtSmallMirrors = 0.03;

INSTANTIATE_TEST_SUITE_P(
    Scenes, CpuPaths,
    ::testing::Values(CpuScene{"cornell", HasLens}, CpuScene{"terrace", NoChange, HasProfileAndMap},
                      CpuScene{"scattering_grid"}, CpuScene{"layers_grid"}, CpuScene{"films_grid"},
                      CpuScene{"meshes_grid"}, CpuScene{"many_lights"}, CpuScene{"instanced_field"},
                      CpuScene{"points_and_lines", HasRoundPrimitives, NoChange,
                               kMostPathsApartAtSmallMirrors},
                      CpuScene{"checker_floor", HasLevels}, CpuScene{"texture_formats_grid"},
                      CpuScene{"texture_coordinates_grid"}, CpuScene{"nested_dielectrics"},
                      CpuScene{"diffuse_transmission_grid"}),
    NameOfScene);

TEST_P(KnownCpuPaths, OfKnownScene_AreThoseOfTheDevice) {
    RAYGRAPH_SKIP_WITHOUT_ASSET_SCENES();
    Compare(*test::ReferenceAssets() / "scenes" / "known" / (std::string(GetParam().name) + ".glb"));
}

INSTANTIATE_TEST_SUITE_P(Scenes, KnownCpuPaths,
                         ::testing::Values(CpuScene{"Fox", Moves}, CpuScene{"AnimatedMorphCube", Moves},
                                           CpuScene{"AlphaBlendModeTest", NoChange, HasNoFilter},
                                           CpuScene{"AnisotropyStrengthTest"}, CpuScene{"DispersionTest"},
                                           CpuScene{"SheenCloth", NoChange, HasNoFilter},
                                           CpuScene{"TextureSettingsTest"},
                                           CpuScene{"WaterBottle", HasLevels, HasNoFilter}),
                         NameOfScene);

}  // namespace raygraph::testing
