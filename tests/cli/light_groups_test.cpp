#include "editor/session/settings/light_groups.h"

#include "tests/cli/cli_test.h"

namespace raygraph::session::light_groups_test {
namespace {

using test::ExpectError;

constexpr uint32_t kRest = gpu::kLightGroupRest, kFirst = gpu::kLightGroupNamed;

TEST(LightGroups, TextIsReadAndWrittenBack) {
    const std::vector<LightGroupPatterns> groups = ParseLightGroups("key=lamp*,bulb;fill-2=window?");
    ASSERT_EQ(groups.size(), 2u);
    EXPECT_EQ(groups[0].name, "key");
    EXPECT_EQ(groups[0].patterns, (std::vector<std::string>{"lamp*", "bulb"}));
    EXPECT_EQ(ToText(groups), "key=lamp*,bulb;fill-2=window?");
    EXPECT_EQ(LightGroupNames(groups), (std::vector<std::string>{"rest", "environment", "key", "fill-2"}));
    EXPECT_TRUE(ParseLightGroups("").empty());
    EXPECT_TRUE(LightGroupNames({}).empty());
}

TEST(LightGroups, MistakesAreUsageErrors) {
    for (const char* text :
         {"key", "=lamp", "key=", "key=a,,b", "a.b=c", "rest=a", "environment=a", "a=b;a=c"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseLightGroups(text); }, "\"");
    ExpectError(
        ErrorKind::Usage, [] { ParseLightGroups("a=x;b=x;c=x;d=x;e=x;f=x;g=x;h=x;i=x"); }, "9 groups",
        "at most 8");
}

// Node 0 "ceiling" is above node 1 "panel", which places mesh and light; node 2 "floor" places a mesh.
scene::SceneData Scene() {
    scene::SceneData scene;
    scene.nodes = {{.name = "ceiling"}, {.name = "panel", .parent = 0}, {.name = "floor"}};
    scene.instances = {{.node = 1}, {.node = 2}, {}};
    scene.materials = {{.name = "glow"}, {.name = "wood"}};
    scene.lights = {{.name = "spot", .node = 1}, {.name = "sun"}};
    return scene;
}

TEST(LightGroups, NamesOfMaterialsLightsNodesAndThoseAboveFit) {
    const LightGroups groups = MatchLightGroups(ParseLightGroups("a=gl*,s?n;b=ceil*;c=fl[aio]or"), Scene());
    EXPECT_EQ(groups.namedCount, 3u);
    EXPECT_EQ(groups.materials, (std::vector<uint32_t>{kFirst, kRest}));
    EXPECT_EQ(groups.instances, (std::vector<uint32_t>{kFirst + 1, kFirst + 2, kRest}));
    EXPECT_EQ(groups.lights, (std::vector<uint32_t>{kFirst + 1, kFirst}));
}

TEST(LightGroups, TheFirstThatFitsHasTheLight) {
    const LightGroups groups = MatchLightGroups(ParseLightGroups("a=panel;b=ceiling;c=*"), Scene());
    EXPECT_EQ(groups.instances, (std::vector<uint32_t>{kFirst, kFirst + 2, kRest}));
    EXPECT_EQ(groups.lights[0], kFirst);
    EXPECT_EQ(FirstLightGroup(kRest, kFirst + 1), kFirst + 1);
    EXPECT_EQ(FirstLightGroup(kFirst + 1, kFirst), kFirst);
}

TEST(LightGroups, AGroupThatFitsNothingIsNamed) {
    ExpectError(
        ErrorKind::Usage, [] { MatchLightGroups(ParseLightGroups("a=glow;b=candle"), Scene()); },
        "light-group b=candle");
}

}  // namespace
}  // namespace raygraph::session::light_groups_test
