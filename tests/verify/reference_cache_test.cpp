// References that are stored, and which state of the shaders they are of.
#include <gtest/gtest.h>

#include "base/text.h"
#include "editor/session/session.h"
#include "editor/session/verify/verify.h"
#include "renderer/graph/shader_library.h"
#include "shaders/embedded.h"
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

}  // namespace raygraph::reference_cache_test
