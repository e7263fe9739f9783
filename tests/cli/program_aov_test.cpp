// Tests the parts of the light as the program renders and stores them. It needs a device.
#include <cmath>

#include "base/text.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_aov_test {
namespace {

using session::Aov;
using session::RenderFile;
using session::Texels;
using test::RunProgram;
using test::SumOf;

RenderFile Render(const test::TemporaryFolder& folder, const char* output, const std::string& options) {
    const test::ProgramResult result =
        RunProgram(folder, Text("render @cornell.gltf --size 24x24 -o {} {}", output, options));
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    return session::ReadRenderFile(folder / output);
}

// Expects that R, G and B of every pixel are the sums of the parts, relative to the brighter one.
void ExpectSum(const RenderFile& render, const std::vector<Aov>& parts) {
    for (size_t i = 0; i < render.radiance.size(); ++i) {
        if (i % 4 == 3) continue;
        double sum = 0.0;
        for (const Aov part : parts) sum += MeanOf(render, part)->at(i);
        ASSERT_NEAR(sum, render.radiance[i], 1e-5 * std::max(1e-3, sum)) << "texel " << i;
    }
}

TEST(ProgramAov, PartsOfTheLightSumToTheBeautyTwiceAndLeaveIt) {
    const test::TemporaryFolder folder;
    const RenderFile split =
        Render(folder, "split.exr", "--spp 4 --aov emission,direct,indirect,diffuse,specular,transmission");
    ExpectSum(split, {Aov::Emission, Aov::Direct, Aov::Indirect});
    ExpectSum(split, {Aov::Emission, Aov::Diffuse, Aov::Specular, Aov::Transmission});
    for (const Aov part : {Aov::Emission, Aov::Direct, Aov::Indirect, Aov::Diffuse})
        EXPECT_GT(SumOf(*MeanOf(split, part)), 0.0) << Name(part);
    EXPECT_EQ(SumOf(*MeanOf(split, Aov::Transmission)), 0.0);  // no glass in the box

    const RenderFile plain = Render(folder, "plain.exr", "--spp 4");
    if (plain.driver.find("llvmpipe") != std::string::npos) {
        EXPECT_EQ(split.radiance, plain.radiance);
        EXPECT_EQ(split.variance, plain.variance);
    } else {  // another driver may round differently in the longer shader
        size_t same = 0;
        for (size_t i = 0; i < plain.radiance.size(); ++i)
            same += std::abs(split.radiance[i] - plain.radiance[i]) <= 1e-5f * plain.radiance[i] + 1e-7f;
        EXPECT_GE(same, plain.radiance.size() * 99 / 100) << "of " << plain.radiance.size();
    }
    EXPECT_TRUE(AovsOf(plain).IsEmpty());
}

TEST(ProgramAov, MergedPartsAreThoseOfOneRun) {
    const test::TemporaryFolder folder;
    const auto render = [&](int count, int first, const char* output) {
        return Render(folder, output,
                      Text("--spp {} --sample-offset {} --aov emission,direct,indirect", count, first));
    };
    render(5, 0, "a.exr");
    render(3, 5, "b.exr");
    const RenderFile whole = render(8, 0, "whole.exr");
    ASSERT_EQ(RunProgram(folder, "merge a.exr b.exr -o m.exr").exitCode, 0);
    const RenderFile merged = session::ReadRenderFile(folder / "m.exr");
    ExpectSum(merged, {Aov::Emission, Aov::Direct, Aov::Indirect});
    for (const Aov part : {Aov::Emission, Aov::Direct, Aov::Indirect})
        EXPECT_EQ(*MeanOf(merged, part), *MeanOf(whole, part)) << Name(part);
}

}  // namespace
}  // namespace raygraph::program_aov_test
