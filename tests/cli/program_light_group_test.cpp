// Tests light groups as the program renders and stores them. It needs a device.
#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "renderer/image/exr.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_light_group_test {
namespace {

using session::RenderFile;
using session::Texels;
using test::RunProgram;
using test::SumOf;

RenderFile Render(const test::TemporaryFolder& folder, const char* output, const std::string& options) {
    const test::ProgramResult result =
        RunProgram(folder, Text("render --size 20x12 -o {} {}", output, options));
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    return session::ReadRenderFile(folder / output);
}

void ExpectGroupsSumToTheBeauty(const RenderFile& render) {
    for (size_t i = 0; i < render.radiance.size(); ++i) {
        if (i % 4 == 3) continue;
        double sum = 0.0;
        for (const Texels& group : render.lightGroups) sum += group.at(i);
        ASSERT_NEAR(sum, render.radiance[i], 1e-5 * std::max(1e-3, sum)) << "texel " << i;
    }
}

TEST(ProgramLightGroup, GroupsSumToTheBeautyAndLeaveItsBits) {
    const test::TemporaryFolder folder;
    const std::string light = "@many_lights.gltf --spp 3 --background 0.02,0.03,0.05";
    const RenderFile render =
        Render(folder, "a.exr", light + " --light-group 'low=light [0-3]' --light-group shards=shards");
    ASSERT_EQ(render.lightGroups.size(), 4u);  // the rest, the points and the environment are groups, too
    for (const Texels& group : render.lightGroups) EXPECT_GT(SumOf(group), 0.0);
    ExpectGroupsSumToTheBeauty(render);
    const RenderFile plain = Render(folder, "b.exr", light);
    EXPECT_EQ(render.radiance, plain.radiance);
    EXPECT_EQ(render.variance, plain.variance);
    EXPECT_TRUE(plain.lightGroups.empty());
}

TEST(ProgramLightGroup, TheOnlyLampHasAllTheLight) {
    const test::TemporaryFolder folder;
    const RenderFile render = Render(folder, "a.exr", "@cornell.gltf --spp 4 --light-group lamp=la*");
    ASSERT_EQ(render.lightGroups.size(), 3u);
    EXPECT_EQ(SumOf(render.lightGroups[0]), 0.0);
    EXPECT_EQ(SumOf(render.lightGroups[1]), 0.0);
    EXPECT_GT(SumOf(render.lightGroups[2]), 0.0);
    for (size_t i = 0; i < render.radiance.size(); ++i) {
        if (i % 4 != 3) {
            EXPECT_EQ(render.lightGroups[2][i], render.radiance[i]) << i;
        }
    }
    EXPECT_NE(image::ReadExr(folder / "a.exr").FloatChannel("light.lamp.R"), nullptr);
}

TEST(ProgramLightGroup, AGroupThatFitsNothingIsRefusedByTheNameOfItsOption) {
    const test::TemporaryFolder folder;
    const test::ProgramResult result =
        RunProgram(folder, "render @cornell.gltf --size 8x8 -o a.exr --light-group lamp=candle");
    EXPECT_EQ(result.exitCode, 2);
    EXPECT_EQ(result.messages,
              "raygraph: --light-group lamp=candle: no material, light or node of the scene is called so\n");
}

TEST(ProgramLightGroup, ResumedAndMergedAreThoseOfOneRun) {
    const test::TemporaryFolder folder;
    const auto render = [&](int first, int count, const char* name) {
        return Render(folder, name,
                      Text("@cornell.gltf --sample-offset {} --spp {} --light-group lamp=la* --background "
                           "1,2,3 --max-depth 3 --aov all",
                           first, count));
    };
    const RenderFile whole = render(0, 7, "whole.exr");
    ExpectGroupsSumToTheBeauty(whole);
    EXPECT_FALSE(AovsOf(whole).IsEmpty());
    render(0, 4, "a.exr");
    render(4, 3, "b.exr");
    ASSERT_EQ(RunProgram(folder, "merge a.exr b.exr -o m.exr").exitCode, 0);
    const RenderFile merged = session::ReadRenderFile(folder / "m.exr");
    ASSERT_EQ(merged.lightGroups.size(), 3u);
    EXPECT_EQ(merged.lightGroups, whole.lightGroups);

    const test::ProgramResult resumed = RunProgram(folder, "render @cornell.gltf --resume a.exr --spp 7");
    ASSERT_EQ(resumed.exitCode, 0) << resumed.messages;
    EXPECT_EQ(session::ReadRenderFile(folder / "a.exr").lightGroups, whole.lightGroups);
}

}  // namespace
}  // namespace raygraph::program_light_group_test
