// References that are stored: which state of scene, settings and shaders they are of, and what a program that
// is asked to end leaves.
#include <gmock/gmock.h>
#include <sys/types.h>

#include <csignal>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "editor/session/session.h"
#include "editor/session/verify/verify.h"
#include "renderer/graph/shader_library.h"
#include "renderer/image/image.h"
#include "shaders/embedded.h"
#include "tests/cli/program_runner.h"
#include "tests/support/own_cache.h"
#include "tests/support/source_file.h"
#include "tests/support/text_files.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::reference_cache_test {

namespace {

using session::Picture;
using session::PictureSettings;
using session::Verify;
using test::TemporaryFolder;

class ReferenceCache : public testing::VulkanTest {};

}  // namespace

TEST(HashOfShaders, DependsOnEveryShader) {
    const std::span<const EmbeddedShader> embedded = EmbeddedShaders();
    ASSERT_FALSE(embedded.empty());
    EXPECT_EQ(HashOf(embedded), HashOfEmbeddedShaders());
    for (const size_t i : {size_t{0}, embedded.size() - 1}) {
        std::vector<EmbeddedShader> shaders(embedded.begin(), embedded.end());
        std::vector<std::byte> changed(shaders[i].compressed.begin(), shaders[i].compressed.end());
        changed.back() ^= std::byte{1};
        shaders[i].compressed = changed;
        EXPECT_NE(HashOf(shaders), HashOfEmbeddedShaders());
    }
    EXPECT_NE(HashOf(embedded.subspan(1)), HashOfEmbeddedShaders());
}

TEST_F(ReferenceCache, OfOtherShaders_IsNotRead) {
    const TemporaryFolder folder;
    Picture picture{.name = "black", .size = {16, 16}};
    picture.radiance.assign(4 * session::PixelCount(picture.size), 0.0f);
    const auto newSamples = [&] {
        PictureSettings settings{.size = picture.size};
        Verify verify(Device(), session::LoadInput(test::SourceFile("scenes/cornell.gltf")),
                      {.settings = settings, .minSamples = 2, .maxSamples = 2, .cache = folder.Path()});
        const uint64_t rendered = verify.Check(picture).newSamples;
        const std::string name = Text("{}-{:016x}.exr", verify.Key(), HashOfEmbeddedShaders());
        EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
        // The next one finds it as that of a program with other shaders
        if (rendered == 0)
            std::filesystem::rename(
                folder / name, folder / Text("{}-{:016x}.exr", verify.Key(), HashOfEmbeddedShaders() + 1));
        return rendered;
    };
    EXPECT_EQ(newSamples(), 2u);
    EXPECT_EQ(newSamples(), 0u);
    EXPECT_EQ(newSamples(), 2u);
    EXPECT_EQ(test::FileCount(folder.Path()), 2u);
}

// The lights of the terrace and their nodes have no names; the picture is black, or no picture at all.
TEST_F(ReferenceCache, LightsWithoutNames_AreExaminedOneByOne) {
    Picture picture{.name = "black", .size = {16, 16}};
    picture.radiance.assign(4 * session::PixelCount(picture.size), 0.0f);
    Verify verify(Device(), session::LoadInput(test::SourceFile("scenes/terrace.gltf")),
                  {.settings = {.size = picture.size}, .minSamples = 2, .maxSamples = 2});
    std::vector<std::string> groups;
    for (const session::PartFit& part : verify.Check(picture).diagnosis.parts)
        if (part.kind == "light group") groups.push_back(part.name);
    EXPECT_THAT(groups, ::testing::IsSupersetOf({"directional_light_0", "spot_light_1", "point_light_2"}));
    picture.radiance.assign(picture.radiance.size(), std::numeric_limits<float>::quiet_NaN());
    const session::VerifyResult result = verify.Check(picture);
    EXPECT_FALSE(result.verdict.isRight);
    EXPECT_TRUE(result.diagnosis.hypotheses.empty()) << result.diagnosis.hypotheses.front().text;
}

// The picture is so large that its reference takes much longer than a signal.
TEST(ProgramVerify, SignalsEndIt_AndWhatIsFinishedIsStored) {
    const TemporaryFolder folder;
    const test::OwnCache cache(folder / "cache");
    const std::filesystem::path references = folder / "cache/raygraph/references";
    image::WriteHdr(folder / "black.hdr", {128, 96, std::vector<float>(size_t{4} * 128 * 96, 0.0f)});
    uint64_t before = 0;
    for (const int signal : {SIGTERM, SIGINT}) {
        bool isSent = false;
        const test::ProgramResult stopped =
            test::RunProgramOnTerminal(folder, "verify @cornell.gltf black.hdr --json report.json",
                                       [&](pid_t process, const std::string& shown) {
                                           if (isSent || shown.find("/64 samples") == std::string::npos)
                                               return;
                                           isSent = kill(process, signal) == 0;
                                       });
        EXPECT_TRUE(isSent) << stopped.output;
        EXPECT_EQ(stopped.exitCode, 75) << stopped.output;
        EXPECT_EQ(stopped.output.find("NOT RIGHT"), std::string::npos) << stopped.output;
        EXPECT_NE(stopped.output.find("stopped before the picture was judged"), std::string::npos)
            << stopped.output;
        const nlohmann::json report = nlohmann::json::parse(test::TextOf(folder / "report.json"));
        EXPECT_FALSE(report.at("right").get<bool>());
        EXPECT_EQ(report.at("errors").size(), 1u) << report.dump(1);
        // Nothing else is beside it, and the second run went on from the first one's
        ASSERT_EQ(test::FileCount(references), 1u);
        const uint64_t samples = session::SampleCount(
            session::ReadRenderFile(std::filesystem::directory_iterator(references)->path()).samples);
        EXPECT_GT(samples, before);
        EXPECT_LT(samples, 64u);
        before = samples;
    }
    // Limits that all pictures meet: nothing is rendered to find what is off
    const test::ProgramResult judged = test::RunProgram(
        folder,
        "verify @cornell.gltf black.hdr --spp 2 --json report.json --tolerance 1e6 --energy 1e6 "
        "--parts 1e6 --flip 1 --ssim 2");
    EXPECT_EQ(judged.exitCode, 0) << judged.output << judged.messages;
    const nlohmann::json report = nlohmann::json::parse(test::TextOf(folder / "report.json"));
    EXPECT_EQ(report.at("pictures").at(0).at("reference_samples"), before);
    EXPECT_EQ(report["pictures"][0].at("new_samples"), 0);
}

}  // namespace raygraph::reference_cache_test
