#include "editor/cli/scene_text.h"
#include "tests/cli/cli_test.h"

namespace raygraph::cli::text_test {
namespace {

TEST(SceneText, NumbersAreGrouped) {
    EXPECT_EQ(GroupDigits(0), "0");
    EXPECT_EQ(GroupDigits(999), "999");
    EXPECT_EQ(GroupDigits(1000), "1,000");
    EXPECT_EQ(GroupDigits(1234567), "1,234,567");
}

TEST(SceneText, ALongListIsCut) {
    scene::SceneData data;
    data.materials.resize(25);
    data.materials[3].name = "red";
    const std::string text = DescribeScene("a.glb", data);
    EXPECT_NE(text.find("3  \"red\""), std::string::npos) << text;
    EXPECT_NE(text.find("... and 5 more"), std::string::npos) << text;
    EXPECT_NE(text.find("bounds      empty"), std::string::npos) << text;
    EXPECT_NE(text.find("cameras     none"), std::string::npos) << text;
}

TEST(SceneText, EnvironmentIsSaidWhereThereIsOne) {
    scene::SceneData data;
    EXPECT_EQ(DescribeScene("a.glb", data).find("environment"), std::string::npos);
    data.environment = {"evening", 256, {1, 1, {1, 1, 1, 1}}};
    const std::string text = DescribeScene("a.glb", data);
    EXPECT_NE(text.find("  environment \"evening\", a cube of 256 x 256; --env or --background replace it\n"),
              std::string::npos)
        << text;
}

TEST(SceneText, LightWithAProfileSaysHowBrightItIs) {
    scene::SceneData data;
    data.profiles.push_back({.vertical = {0.0f, 1.0f}, .horizontal = {0.0f}, .candela = {300.0f, 450.0f}});
    data.lights.push_back({.name = "panel", .intensity = 2.0f, .profile = 0});
    const std::string text = DescribeScene("a.glb", data);
    EXPECT_NE(text.find("0  \"panel\"  profile, at most 900 cd, color 1 1 1\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace raygraph::cli::text_test
