// Tests that the records of paths are exact (tests/explain/explain_test.cpp) in all scenes, each of which is
// a program to compile: those of the sources, and those of the reference assets.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "tests/explain/exact_records.h"
#include "tests/support/reference_assets.h"
#include "tests/support/source_file.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

namespace {

class ExactRecords : public VulkanTest {
  protected:
    void ExpectInAll(const std::filesystem::path& folder) {
        std::vector<std::filesystem::path> scenes;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
            if (entry.path().extension() == ".gltf" || entry.path().extension() == ".glb")
                scenes.push_back(entry.path());
        std::ranges::sort(scenes);
        RecordedPaths all;
        for (const std::filesystem::path& scene : scenes) {
            SCOPED_TRACE(scene.string());
            const RecordedPaths found = ExpectExactRecords(Device(), scene, 3);
            all.paths += found.paths;
            all.vertices += found.vertices;
            all.lit += found.lit;
        }
        RecordProperty("scenes", static_cast<int>(scenes.size()));
        RecordProperty("paths", static_cast<int>(all.paths));
        EXPECT_GT(all.paths, 0u);
        EXPECT_GT(all.vertices, 2 * all.paths) << "paths are too short to prove anything";
        EXPECT_GT(2 * all.lit, all.paths) << "pictures are too dark to prove anything";
    }
};

}  // namespace

TEST_F(ExactRecords, OfOwnScenes_SumToTheSamples) {
    ExpectInAll(test::SourceFile("scenes"));
}

TEST_F(ExactRecords, OfKnownScenes_SumToTheSamples) {
    RAYGRAPH_SKIP_WITHOUT_ASSET_SCENES();
    ExpectInAll(*test::ReferenceAssets() / "scenes" / "known");
}

}  // namespace raygraph::testing
