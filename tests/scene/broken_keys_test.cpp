// Keys of animations that cannot be used: an error of an animation that plays, if pictures show what they move.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "renderer/scene/animation/pose.h"
#include "tests/scene/gltf_document.h"
#include "tests/scene/motion_document.h"

namespace raygraph::test::broken_keys_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// A triangle at node 0, and beside it a node of the scene that places nothing, with an animation of each of the
// paths, whose keys are broken as said.
GltfDocument WithBrokenKeys(bool areTimes, const std::vector<Json>& targets) {
    GltfDocument document;
    document.AddTriangle();
    document.AddNode({{"name", "empty"}});
    const std::vector<float> times{0, areTimes ? kInfinity : 1}, values{0, 0, 0, areTimes ? 1 : kNan, 0, 0};
    for (const Json& target : targets) Animate(document, target, times, values, 3);
    return document;
}

Json Translation(size_t node) {
    return {{"node", node}, {"path", "translation"}};
}

// Returns the message of the error with which playing the animation ends.
std::string Played(const scene::SceneData& scene, uint32_t animation) {
    const std::array clips{scene::ClipState{.animation = animation, .seconds = 0.5}};
    try {
        scene::RequirePlayable(scene, clips);
        scene::PoseEvaluator evaluator(scene);
        evaluator.Evaluate(scene, clips);
    } catch (const Error& error) {
        EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
        return error.what();
    }
    return "played";
}

TEST(BrokenKeys, RefuseTheAnimationThatPlays) {
    for (const bool areTimes : {true, false}) {
        const scene::SceneData scene = Load(WithBrokenKeys(areTimes, {Translation(0), Translation(0)}));
        const std::string stream = areTimes ? "input" : "output";
        const std::string line = "scene.gltf: animations[0].samplers[0]." + stream + ": accessors[" +
                                 std::to_string(areTimes ? 2 : 3) + "] element 1 is not finite";
        EXPECT_THAT(scene.warnings, ElementsAre(line + "; the animation cannot be played (and 1 more)"));
        ASSERT_EQ(scene.animations.size(), 2u);
        EXPECT_TRUE(scene.animations[0].channels.empty());
        EXPECT_EQ(scene.animations[0].duration, 0.0f);
        EXPECT_EQ(Played(scene, 0), line);
        EXPECT_THAT(Played(scene, 1), HasSubstr("animations[1]"));
        const std::array silent{scene::ClipState{.animation = 0, .weight = 0.0f}};
        EXPECT_NO_THROW(scene::RequirePlayable(scene, silent)) << "without a weight it does not play";
    }
}

TEST(BrokenKeys, OfWhatNoPictureShows_LeaveTheirChannelsOut) {
    for (const bool areTimes : {true, false}) {
        const scene::SceneData scene = Load(WithBrokenKeys(areTimes, {Translation(1)}));
        ASSERT_EQ(scene.warnings.size(), 1u);
        EXPECT_THAT(scene.warnings[0], HasSubstr("element 1 is not finite; its channels are left out"));
        EXPECT_EQ(Played(scene, 0), "played");
    }
    // A camera, a mesh and a joint below a node are shown, a mesh outside of the scene is not
    const auto played = [](auto&& change) {
        GltfDocument document = WithBrokenKeys(true, {Translation(1)});
        change(document);
        return Played(Load(document), 0);
    };
    const Json camera{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}};
    EXPECT_NE(played([&](GltfDocument& document) {
                  document.json["nodes"][1]["camera"] = document.Add("cameras", camera);
              }),
              "played");
    EXPECT_NE(played([](GltfDocument& document) {
                  document.json["nodes"][1]["children"] = {document.Add("nodes", {{"mesh", 0}})};
              }),
              "played");
    EXPECT_EQ(played([](GltfDocument& document) {
                  document.json["scenes"][0]["nodes"] = {0};
                  document.json["nodes"][1]["mesh"] = 0;
              }),
              "played");
    GltfDocument skinned = SkinnedTriangle();
    Animate(skinned, Translation(1), {0, kInfinity}, {0, 0, 0, 1, 0, 0}, 3);
    EXPECT_NE(Played(Load(skinned), 0), "played");
}

// One sampler of two channels, of which one moves what is shown.
TEST(BrokenKeys, ThatChannelsShare_AreWarnedOfOnce) {
    GltfDocument document = WithBrokenKeys(false, {Translation(1)});
    document.json["animations"][0]["channels"].push_back({{"sampler", 0}, {"target", Translation(0)}});
    const scene::SceneData scene = Load(document);
    EXPECT_THAT(scene.warnings,
                ElementsAre(HasSubstr("element 1 is not finite; the animation cannot be played")));
    EXPECT_THAT(scene.warnings[0], ::testing::Not(HasSubstr("more")));
}

TEST(BrokenKeys, MaterialsThatNoPrimitiveHasMayHaveBrokenKeys) {
    for (const size_t material : {0, 1}) {
        GltfDocument document =
            WithBrokenKeys(true, {Pointer("/materials/" + std::to_string(material) + "/emissiveFactor")});
        document.json["extensionsUsed"] = {"KHR_animation_pointer"};
        document.json["meshes"][0]["primitives"][0]["material"] = document.AddMaterial(Json::object());
        document.AddMaterial(Json::object());
        EXPECT_EQ(Played(Load(document), 0) == "played", material == 1);
    }
}

}  // namespace
}  // namespace raygraph::test::broken_keys_test
