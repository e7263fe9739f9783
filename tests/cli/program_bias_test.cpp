// Tests the light that biases removed from a render, as the program measures it. It needs a device.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_bias_test {
namespace {

using session::Bias;
using session::RenderFile;
using session::Texels;
using test::RunProgram;
using test::SceneFile;

struct BiasRender {
    RenderFile file;
    nlohmann::json report;
    std::string summary;
};

class ProgramBias : public ::testing::Test {
  protected:
    BiasRender Render(const char* scene, const std::string& options) {
        const test::ProgramResult result = RunProgram(
            m_folder,
            Text("render @{} --size 16x16 --brdf lambert -o a.exr --report a.json {}", scene, options));
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        std::ifstream file(m_folder / "a.json");
        return {session::ReadRenderFile(m_folder / "a.exr"), nlohmann::json::parse(file), result.output};
    }

    const test::TemporaryFolder m_folder;
};

const Texels& Removed(const BiasRender& render, Bias bias) {
    return render.file.removed[static_cast<size_t>(bias)];
}

double MeanOfColor(const Texels& texels) {
    double sum = 0.0;
    for (size_t i = 0; i < texels.size(); ++i)
        if (i % 4 != 3) sum += texels[i];
    return sum / (0.75 * static_cast<double>(texels.size()));
}

bool HasPass(const BiasRender& render, const char* name) {
    return std::ranges::any_of(render.report.at("passes"),
                               [&](const auto& pass) { return pass.at("name") == name; });
}

TEST_F(ProgramBias, MaxDepthInAClosedBoxRemovesWhatBouncedMoreOften) {
    // The radiance is 1 + a + a^2 + ... = 1 / (1 - a); depth 1 leaves 1 + a
    const BiasRender render =
        Render("closed_box_a50.gltf", "--max-depth 1 --spp 250 --aov removed_max_depth");
    const nlohmann::json& removed = render.report.at("removed").at("max_depth");
    EXPECT_EQ(removed.at("samples"), 16);
    const double error = removed.at("standard_error"), luminance = removed.at("luminance");
    EXPECT_GT(error, 0.0);
    EXPECT_LT(error, 0.03);
    EXPECT_NEAR(luminance, 0.5, 4.0 * error);
    EXPECT_NEAR(removed.at("share"), 0.25, 4.0 * removed.at("share_standard_error").get<double>());
    EXPECT_NEAR(MeanOfColor(Removed(render, Bias::MaxDepth)), luminance, 1e-5);
    EXPECT_NEAR(MeanOfColor(render.file.radiance), 1.5, 0.01);
    EXPECT_NE(render.summary.find("--max-depth removed 2"), std::string::npos) << render.summary;
}

TEST_F(ProgramBias, OneSampleAndWhatItLostIsTheUnbiasedSample) {
    const BiasRender unbiased = Render("cornell.gltf", "--spp 1");
    const auto expectWhole = [&](const char* option, const char* value, Bias bias) {
        const std::string aov = std::string("removed_") + Name(bias);
        const BiasRender render = Render("cornell.gltf", Text("--spp 1 {} {} --aov {}", option, value, aov));
        EXPECT_GT(MeanOfColor(Removed(render, bias)), 0.001) << option;
        for (size_t i = 0; i < unbiased.file.radiance.size(); ++i) {
            if (i % 4 == 3) continue;
            const float whole = render.file.radiance[i] + Removed(render, bias)[i];
            ASSERT_NEAR(whole, unbiased.file.radiance[i], 1e-5f * std::max(1.0f, whole)) << option << i;
        }
    };
    expectWhole("--clamp-indirect", "0.2", Bias::ClampIndirect);
    expectWhole("--max-depth", "2", Bias::MaxDepth);
}

TEST_F(ProgramBias, ClampedPictureAndWhatWasClampedIsTheUnclampedWithinNoise) {
    const BiasRender unclamped = Render("cornell.gltf", "--spp 192"),
                     clamped = Render("cornell.gltf", "--spp 192 --clamp-indirect 0.2");
    const nlohmann::json& removed = clamped.report.at("removed").at("clamp_indirect");
    const auto luminance = [](const BiasRender& render) {
        const nlohmann::json& mean = render.report.at("image").at("mean");
        return 0.2126 * mean.at(0).get<double>() + 0.7152 * mean.at(1).get<double>() +
               0.0722 * mean.at(2).get<double>();
    };
    const double error = removed.at("standard_error");
    EXPECT_GT(removed.at("luminance").get<double>(), 5.0 * error);
    EXPECT_NEAR(luminance(clamped) + removed.at("luminance").get<double>(), luminance(unclamped),
                4.0 * error);
}

TEST_F(ProgramBias, NothingIsTracedTwiceWithoutABias) {
    const BiasRender plain = Render("cornell.gltf", "--spp 2");
    EXPECT_FALSE(HasPass(plain, "Subtract"));
    EXPECT_TRUE(plain.report.at("removed").empty());
    EXPECT_EQ(plain.summary.find("removed"), std::string::npos) << plain.summary;
    EXPECT_TRUE(HasPass(Render("cornell.gltf", "--spp 2 --max-depth 9"), "Subtract"));
}

TEST_F(ProgramBias, ResumedMeasuresWhatAnUninterruptedRenderDoes) {
    const auto render = [&](int count) {
        return Render("cornell.gltf", Text("--max-depth 2 --clamp-indirect 0.5 --aov all --spp {}", count));
    };
    const BiasRender whole = render(40);
    for (const int first : {20, 33}) {  // the added samples are with and without second traces
        render(first);
        const test::ProgramResult result =
            RunProgram(m_folder, "render @cornell.gltf --resume a.exr --spp 40");
        ASSERT_EQ(result.exitCode, 0) << result.messages;
        const RenderFile resumed = session::ReadRenderFile(m_folder / "a.exr");
        EXPECT_EQ(resumed.removedSamples, 3u);
        EXPECT_EQ(resumed.removed, whole.file.removed) << first;
        EXPECT_EQ(resumed.removedVariance, whole.file.removedVariance) << first;
        EXPECT_EQ(resumed.radiance, whole.file.radiance) << first;
    }
}

// The file stores one bias only, so it cannot be resumed with another one on.
TEST_F(ProgramBias, ResumedCountsForTheBiasThatItsFileHolds) {
    const auto render = [&](int count) {
        return Render("cornell.gltf",
                      Text("--max-depth 2 --clamp-indirect 0.5 --aov removed_max_depth --spp {}", count));
    };
    const BiasRender whole = render(40);
    EXPECT_EQ(whole.report.at("removed").at("clamp_indirect").at("samples"), 3);
    render(20);
    const test::ProgramResult result =
        RunProgram(m_folder, "render @cornell.gltf --resume a.exr --spp 40 --report resumed.json");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    const RenderFile resumed = session::ReadRenderFile(m_folder / "a.exr");
    EXPECT_EQ(resumed.removedSamples, 3u);
    EXPECT_EQ(resumed.removed, whole.file.removed);
    EXPECT_EQ(resumed.removedVariance, whole.file.removedVariance);
    std::ifstream file(m_folder / "resumed.json");
    const nlohmann::json removed = nlohmann::json::parse(file).at("removed");
    EXPECT_EQ(removed.at("max_depth"), whole.report.at("removed").at("max_depth"));
    EXPECT_FALSE(removed.contains("clamp_indirect")) << "of a part of the samples";
}

// A small sphere and a sky are both near the largest float, so that their sum is infinite.
TEST_F(ProgramBias, InfiniteSamplesAreBlackAndReported) {
    std::ifstream file(SceneFile("furnace_sphere.gltf"));
    nlohmann::json scene = nlohmann::json::parse(file);
    for (nlohmann::json& node : scene.at("nodes"))
        if (node.contains("mesh")) node["scale"] = {0.02, 0.02, 0.02};
    for (nlohmann::json& material : scene.at("materials")) {
        material["pbrMetallicRoughness"] = {{"metallicFactor", 0.0}};
        material["emissiveFactor"] = {1, 1, 1};
        material["extensions"] = {{"KHR_materials_emissive_strength", {{"emissiveStrength", 1e38}}}};
    }
    scene["extensionsUsed"] = {"KHR_materials_emissive_strength"};
    std::ofstream(m_folder / "bright.gltf") << scene;
    const test::ProgramResult result =
        RunProgram(m_folder,
                   "render bright.gltf -o bright.hdr --report bright.json --size 8x8 --spp 3 --brdf lambert "
                   "--nee off --background 3e38,3e38,3e38 --camera '0 0 1  0 0 0  0 1 0  1'");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_NE(result.messages.find("192 samples were infinite or NaN"), std::string::npos) << result.messages;
    std::ifstream reported(m_folder / "bright.json");
    const nlohmann::json image = nlohmann::json::parse(reported).at("image");
    EXPECT_EQ(image.at("nonfinite_samples"), 8 * 8 * 3);
    EXPECT_EQ(image.at("mean"), nlohmann::json({0.0, 0.0, 0.0}));
    // Each sample is counted once, also where lists of pixels do not fill their rows
    for (const char* form : {"loop", "wavefront"}) {
        const test::ProgramResult adaptive = RunProgram(
            m_folder, std::string("render bright.gltf -o bright.hdr --report bright.json --size 7x5 --spp "
                                  "128 --adaptive on --brdf lambert --nee off --background 3e38,3e38,3e38 "
                                  "--camera '0 0 1  0 0 0  0 1 0  1' --integrator-form ") +
                          form);
        ASSERT_EQ(adaptive.exitCode, 0) << adaptive.messages;
        std::ifstream again(m_folder / "bright.json");
        EXPECT_EQ(nlohmann::json::parse(again).at("image").at("nonfinite_samples"), 7 * 5 * 128) << form;
    }
}

}  // namespace
}  // namespace raygraph::program_bias_test
