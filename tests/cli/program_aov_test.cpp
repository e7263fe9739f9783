// The light in parts, as the program renders and keeps it. A device is needed.
#include <cmath>

#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph {
namespace {

using session::Aov;
using session::RenderFile;
using session::Texels;
using test::RunProgram;
using test::SceneFile;
using test::SumOf;

RenderFile Render(std::vector<std::string> options, const std::string& output) {
    options.insert(options.begin(), {"render", SceneFile("cornell.gltf"), "--size", "24x24", "-o", output});
    const test::ProgramResult result = RunProgram(options);
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    return session::ReadRenderFile(output);
}

// In R, G and B of every pixel, relative to the brighter.
void ExpectSum(const RenderFile& render, const std::vector<Aov>& parts) {
    for (size_t i = 0; i < render.radiance.size(); i++) {
        if (i % 4 == 3) continue;
        double sum = 0.0;
        for (const Aov part : parts) sum += MeanOf(render, part)->at(i);
        ASSERT_NEAR(sum, render.radiance[i], 1e-5 * std::max(1e-3, sum)) << "texel " << i;
    }
}

TEST(ProgramAov, PartsOfTheLightSumToTheBeautyTwiceAndLeaveItsBits) {
    const test::TemporaryFolder folder;
    const RenderFile split =
        Render({"--spp", "4", "--aov", "emission,direct,indirect,diffuse,specular,transmission"},
               folder / "split.exr");
    ExpectSum(split, {Aov::Emission, Aov::Direct, Aov::Indirect});
    ExpectSum(split, {Aov::Emission, Aov::Diffuse, Aov::Specular, Aov::Transmission});
    for (const Aov part : {Aov::Emission, Aov::Direct, Aov::Indirect, Aov::Diffuse})
        EXPECT_GT(SumOf(*MeanOf(split, part)), 0.0) << Name(part);
    EXPECT_EQ(SumOf(*MeanOf(split, Aov::Transmission)), 0.0);  // no glass in the box

    const RenderFile plain = Render({"--spp", "4"}, folder / "plain.exr");
    EXPECT_EQ(split.radiance, plain.radiance);
    EXPECT_EQ(split.variance, plain.variance);
    EXPECT_TRUE(AovsOf(plain).IsEmpty());
}

TEST(ProgramAov, MergedPartsAreThoseOfOneRun) {
    const test::TemporaryFolder folder;
    const auto render = [&](const char* count, const char* first, const std::string& output) {
        return Render({"--spp", count, "--sample-offset", first, "--aov", "emission,direct,indirect"},
                      output);
    };
    render("5", "0", folder / "a.exr");
    render("3", "5", folder / "b.exr");
    const RenderFile whole = render("8", "0", folder / "whole.exr");
    ASSERT_EQ(RunProgram({"merge", folder / "a.exr", folder / "b.exr", "-o", folder / "m.exr"}).exitCode, 0);
    const RenderFile merged = session::ReadRenderFile(folder / "m.exr");
    ExpectSum(merged, {Aov::Emission, Aov::Direct, Aov::Indirect});
    for (const Aov part : {Aov::Emission, Aov::Direct, Aov::Indirect})
        EXPECT_EQ(*MeanOf(merged, part), *MeanOf(whole, part)) << Name(part);
}

}  // namespace
}  // namespace raygraph
