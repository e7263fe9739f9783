// Tests that the integrator gives the numbers of the device when it is compiled as C++: path by path, over
// pictures of scenes with all that paths meet.
#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <utility>

#include "editor/session/settings/bias.h"
#include "tests/explain/cpu_paths.h"
#include "tests/support/reference_assets.h"
#include "tests/support/source_file.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

namespace {

struct CpuScene {
    const char* name;
    void (*change)(session::PictureSettings&) = [](session::PictureSettings&) {};
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

class CpuPaths : public VulkanTest, public ::testing::WithParamInterface<CpuScene> {
  protected:
    void Compare(const std::filesystem::path& file) {
        session::PictureSettings settings;
        settings.size = {32, 32};
        GetParam().change(settings);
        session::SceneInput input = session::LoadInput(file, session::InputOptionsFor(settings));
        const ComparedPaths compared = ComparePaths(Device(), std::move(input), settings, 3);
        std::cout << compared << '\n';
        ExpectSamePaths(compared);
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

INSTANTIATE_TEST_SUITE_P(
    Scenes, CpuPaths,
    ::testing::Values(CpuScene{"cornell", HasLens}, CpuScene{"terrace"}, CpuScene{"scattering_grid"},
                      CpuScene{"layers_grid"}, CpuScene{"films_grid"}, CpuScene{"meshes_grid"},
                      CpuScene{"many_lights"}, CpuScene{"instanced_field"},
                      CpuScene{"points_and_lines", HasRoundPrimitives}, CpuScene{"checker_floor", HasLevels},
                      CpuScene{"texture_formats_grid"}, CpuScene{"texture_coordinates_grid"},
                      CpuScene{"nested_dielectrics"}, CpuScene{"diffuse_transmission_grid"}),
    NameOfScene);

TEST_P(KnownCpuPaths, OfKnownScene_AreThoseOfTheDevice) {
    RAYGRAPH_SKIP_WITHOUT_ASSET_SCENES();
    Compare(*test::ReferenceAssets() / "scenes" / "known" / (std::string(GetParam().name) + ".glb"));
}

INSTANTIATE_TEST_SUITE_P(Scenes, KnownCpuPaths,
                         ::testing::Values(CpuScene{"Fox", Moves}, CpuScene{"AnimatedMorphCube", Moves},
                                           CpuScene{"AlphaBlendModeTest"}, CpuScene{"AnisotropyStrengthTest"},
                                           CpuScene{"DispersionTest"}, CpuScene{"SheenCloth"},
                                           CpuScene{"TextureSettingsTest"},
                                           CpuScene{"WaterBottle", HasLevels}),
                         NameOfScene);

}  // namespace raygraph::testing
