// Tests animations in the editor: they are visible, and they stop.
#include <gtest/gtest.h>
#include <fstream>
#include <iterator>

#include "editor/app/timeline.h"
#include "editor/session/file/content_hash.h"
#include "editor/session/session.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/editor/editor_test.h"
#include "tests/editor/moving_scene.h"
#include "tests/support/error_of.h"

namespace raygraph::editor::animation_test {

namespace {

class EditorAnimationTest : public EditorTest {
  protected:
    EditorAnimationTest() {
        editor.Work().UseLight(DefaultLight::Auto);  // the studio is its only light
        std::ofstream(file) << moving::Document().Text();
    }

    static constexpr const char* kSize = "size 320x220\n";
    std::string Open() const { return kSize + ("view raster\nopen " + file.string()) + "\nwait\nbudget 0\n"; }
    // Returns what the view shows after these commands.
    std::string Picture(const std::string& commands) {
        const std::filesystem::path picture = folder.Path() / "picture.png";
        Play(kSize + commands + "picture " + picture.string() + "\n");
        std::ifstream stream(picture, std::ios::binary);
        return {std::istreambuf_iterator<char>(stream), {}};
    }

    std::filesystem::path file = folder.Path() / "moving.gltf";
};

}  // namespace

TEST_F(EditorAnimationTest, IsSeenInBothViewsAndReturnsToTheRestPose) {
    for (const std::string view : {"raster", "path-traced"}) {
        SCOPED_TRACE(view);
        Play(Open() + "view " + view + "\nexpect time rest\nclips bend\ntime 0.25\n");
        // Each begins with another pose, which restarts accumulation
        const auto pose = [&](const std::string& commands) { return Picture(commands + "\nsamples 2\n"); };
        const std::string rest = pose("stop"), slid = pose("clips slide\ntime 0.5");
        EXPECT_NE(slid, rest);
        EXPECT_EQ(pose("stop"), rest);
        EXPECT_EQ(pose("time 0.5"), slid);
        const std::string bent = pose("clips bend\ntime 1.5"), faded = pose("clips fade\ntime 1");
        EXPECT_NE(bent, rest);
        EXPECT_NE(faded, rest);
        EXPECT_EQ(pose("stop"), rest);
        Play(std::string(kSize) + "clips slide\nplay 0.5\nexpect time 0.500\nexpect playing no\n");
    }
}

TEST_F(EditorAnimationTest, KeysPlayPauseAndStop) {
    Play(Open() + "key space\nexpect playing yes\nframes 29\nkey space\nexpect playing no\n");
    const double seconds = editor.Work().timeline.Seconds();
    EXPECT_GT(seconds, 0.4);
    EXPECT_LT(seconds, 0.6);
    EXPECT_NEAR(editor.Work().document.WorldTransform(moving::Slider)[3].x, 2.0 * seconds, 1e-6);
    Play(std::string(kSize) + "frames 5\nkey shift+space\nexpect time rest\nframes 1\n");
    EXPECT_EQ(editor.Work().document.WorldTransform(moving::Slider)[3].x, 0.25f);
    const Workspace& work = editor.Work();
    EXPECT_TRUE(work.panels.timeline);
    Play(std::string(kSize) + "key K\nframes 1\n");
    EXPECT_FALSE(work.panels.timeline);
}

TEST_F(EditorAnimationTest, PausedPoseIsTracedOnAndCostsNothing) {
    Play(Open() + "view path-traced\nclips bend\ntime 1\nsamples 1\n");
    const Workspace& work = editor.Work();
    const uint32_t resets = work.view.ResetCount(passes::ResetCause::Transform);
    const SceneRevisions revisions = work.gpu.Revisions();
    const uint64_t deformations = work.gpu.Statistics().deformations;
    Play(std::string(kSize) + "samples 4\nexpect samples-above 3\n");
    EXPECT_EQ(work.view.ResetCount(passes::ResetCause::Transform), resets);
    EXPECT_EQ(work.gpu.Revisions(), revisions);
    EXPECT_EQ(work.gpu.Statistics().deformations, deformations);
    Play(std::string(kSize) + "play 0.1\n");
    EXPECT_GT(work.view.ResetCount(passes::ResetCause::Transform), resets);
    EXPECT_GT(work.gpu.Statistics().deformations, deformations);
}

TEST_F(EditorAnimationTest, ViewFollowsItsCameraUntilItIsMoved) {
    Play(Open() + "clips pan\n");
    const CameraController& camera = editor.Work().camera;
    EXPECT_EQ(camera.View().eye.x, 0.0);
    Play(std::string(kSize) + "time 0.5\n");
    EXPECT_EQ(camera.View().eye.x, 0.5);
    Play(std::string(kSize) + "mouse 160 80\nframes 2\nwheel 1\n");
    const glm::dvec3 eye = camera.View().eye;
    Play(std::string(kSize) + "time 1\n");
    EXPECT_EQ(camera.View().eye, eye);
    Play(std::string(kSize) + "key home\n");
    EXPECT_EQ(camera.View().eye.x, 1.0);
}

TEST_F(EditorAnimationTest, HandlesOfAJointBendTheMeshWhileTimeStandsStill) {
    Play("size 640x420\nview raster\nopen " + file.string() + "\nwait\n");
    Workspace& work = editor.Work();
    FrameInput input;
    input.extent = {640, 420};
    const auto frame = [&] {
        editor.Frame(input, screen);
        return work.timeline.Seconds();
    };
    work.Select(moving::SecondJoint);
    work.timeline.Play();
    const double first = frame();
    EXPECT_GT(frame(), first);
    const Extent2D size = work.view.Size();
    const PictureMap map(work.camera.View(), {size.width, size.height});
    const GizmoFrame handles =
        *FrameOf(work.document.WorldTransform(moving::SecondJoint), GizmoTool::Move, GizmoSpace::World, map);
    input.mouse = *map.PlaceOf(handles.origin + glm::vec3(0, 0.8f * handles.size, 0)) +
                  glm::vec2(editor.PictureOrigin());
    frame();
    const scene::Bounds before = work.document.BoundsOf(moving::Skinned);
    const uint64_t deformations = work.gpu.Statistics().deformations;
    input.buttons[static_cast<size_t>(MouseButton::Left)] = true;
    const double held = frame();
    input.mouse.y -= 40.0f;
    EXPECT_EQ(frame(), held);
    EXPECT_EQ(frame(), held);
    EXPECT_EQ(work.document.EditCount(), 1u);
    EXPECT_GT(work.document.BoundsOf(moving::Skinned).max.y, before.max.y);
    EXPECT_GT(work.gpu.Statistics().deformations, deformations);
    input.buttons = {};
    frame();
    EXPECT_GT(frame(), held);
    work.Undo();
    EXPECT_EQ(work.document.BoundsOf(moving::Skinned).max, before.max);
}

TEST_F(EditorAnimationTest, ExrNamesTheClipsAndTheTimeOfItsPose) {
    const std::filesystem::path picture = folder.Path() / "picture.exr";
    const auto save = [&](const std::string& commands) {
        Play(kSize + commands + "samples 1\npicture " + picture.string() + "\nexpect message sample\n");
        return session::ReadRenderFile(picture);
    };
    const std::string hash = session::HashOf(scene::LoadGltf(file));
    session::RenderFile saved = save(Open());
    EXPECT_EQ(session::SettingsFrom(saved.settings).at, std::nullopt);
    EXPECT_EQ(saved.settings.at("clips"), "");
    EXPECT_EQ(saved.sceneHash, hash) << "of the file, which has animations";
    saved = save("clips slide:0.5,bend\ntime 0.75\n");
    EXPECT_EQ(session::SettingsFrom(saved.settings).at, 0.75);
    EXPECT_EQ(saved.settings.at("clips"), "slide:0.5,bend");
    EXPECT_EQ(saved.sceneHash, hash) << "whatever the pose";
    EXPECT_EQ(save("clips all\n").settings.at("clips"), "all");
    // During playback, time is held for the picture
    editor.Work().timeline.Play();
    saved = save("frames 3\n");
    editor.Work().timeline.Pause();
    EXPECT_TRUE(session::SettingsFrom(saved.settings).at);
    EXPECT_EQ(session::SettingsFrom(save("stop\n").settings).at, std::nullopt);
}

TEST_F(EditorAnimationTest, CommandsNeedAnimationsOfThatName) {
    const auto failure = [&](const std::string& text) {
        return std::string(testing::ErrorOf([&] { Play(text); }).what());
    };
    Play("size 320x220\nview raster\n");
    EXPECT_NE(failure(Open() + "clips walk\n").find("there is no animation \"walk\""), std::string::npos);
    EXPECT_NE(failure(OpenCornell() + "time 1\n").find("the scene has no animations"), std::string::npos);
    EXPECT_NE(failure("play 1\n").find("the scene has no animations"), std::string::npos);
    Play("size 640x400\nkey space\nexpect playing no\nexpect time rest\n");
}

}  // namespace raygraph::editor::animation_test

// Tests which animations are played, and at what time.
namespace raygraph::editor::timeline_test {

namespace {

using States = std::vector<scene::ClipState>;

// The scene has clips of 1 s, 2 s, 1 s and 1 s.
class TimelineTest : public ::testing::Test {
  protected:
    States Shown() const { return {timeline.Shown().begin(), timeline.Shown().end()}; }

    Timeline timeline{test::Load(moving::Document())};
};

}  // namespace

TEST_F(TimelineTest, BeginsAtRestWithItsFirstClipOn) {
    EXPECT_TRUE(timeline.IsAtRest());
    EXPECT_EQ(Shown(), States());
    EXPECT_EQ(timeline.ClipsLabel(), "slide");
    timeline.Advance(0.5);
    EXPECT_EQ(Shown(), States()) << "it does not play";
    timeline.Play();
    EXPECT_EQ(Shown(), (States{{0, 0.0}}));
    timeline.Advance(0.25);
    EXPECT_EQ(Shown(), (States{{0, 0.25}}));
}

TEST_F(TimelineTest, StopGoesBackToRestAndPauseDoesNot) {
    timeline.Play();
    timeline.Advance(0.5);
    timeline.Toggle();
    timeline.Advance(0.25);
    EXPECT_EQ(Shown(), (States{{0, 0.5}}));
    EXPECT_FALSE(timeline.IsPlaying());
    timeline.Stop();
    EXPECT_TRUE(timeline.IsAtRest());
    EXPECT_EQ(Shown(), States());
    timeline.Play();
    EXPECT_EQ(Shown(), (States{{0, 0.0}})) << "from the start";
}

TEST_F(TimelineTest, LoopsForwardsAndBackwards) {
    timeline.Play();
    timeline.Advance(2.25);
    EXPECT_DOUBLE_EQ(timeline.Seconds(), 0.25);
    timeline.speed = -0.5f;
    timeline.Advance(1.0);
    EXPECT_DOUBLE_EQ(timeline.Seconds(), 0.75);
    EXPECT_TRUE(timeline.IsPlaying());
}

TEST_F(TimelineTest, WithoutLoopingItEndsAtTheLastKeyAndStartsAnew) {
    timeline.isLooping = false;
    timeline.speed = 2.0f;
    timeline.Play();
    timeline.Advance(0.75);
    EXPECT_EQ(timeline.Seconds(), 1.0);
    EXPECT_FALSE(timeline.IsPlaying());
    timeline.Play();
    EXPECT_EQ(timeline.Seconds(), 0.0);
    timeline.Pause();
    timeline.speed = -1.0f;
    timeline.Play();
    EXPECT_EQ(timeline.Seconds(), 1.0) << "backwards from the end";
    timeline.Advance(0.25);
    EXPECT_EQ(timeline.Seconds(), 0.75);
    timeline.Advance(1.0);
    EXPECT_EQ(timeline.Seconds(), 0.0);
    EXPECT_FALSE(timeline.IsPlaying());
}

TEST_F(TimelineTest, SeekingShowsThatTimeWithinTheLength) {
    timeline.Seek(0.5);
    EXPECT_EQ(Shown(), (States{{0, 0.5}}));
    EXPECT_FALSE(timeline.IsPlaying());
    timeline.Seek(7.0);
    EXPECT_EQ(timeline.Seconds(), 1.0);
    timeline.Seek(-1.0);
    EXPECT_EQ(timeline.Seconds(), 0.0);
    timeline.Seek(NAN);
    EXPECT_EQ(timeline.Seconds(), 0.0);
    timeline.Play();
    timeline.Seek(0.75);
    EXPECT_TRUE(timeline.IsPlaying());
}

TEST_F(TimelineTest, ClipsThatAreOnAreAtOneTimeAsLongAsTheLongest) {
    timeline.ChooseAll();
    EXPECT_EQ(timeline.ClipsLabel(), "all");
    EXPECT_EQ(timeline.Length(), 2.0);
    timeline.Seek(1.5);
    EXPECT_EQ(Shown(), (States{{0, 1.5}, {1, 1.5}, {2, 1.5}, {3, 1.5}}));
    timeline.SetOn(moving::Bend, false);
    EXPECT_EQ(timeline.Length(), 1.0);
    EXPECT_EQ(timeline.Seconds(), 1.0) << "there is no later time";
    timeline.ChooseOnly(moving::Pan);
    EXPECT_EQ(timeline.ClipsLabel(), "pan");
    EXPECT_EQ(Shown(), (States{{2, 1.0}}));
    timeline.SetOn(moving::Pan, false);
    EXPECT_EQ(timeline.ClipsLabel(), "none");
    EXPECT_EQ(Shown(), States());
    timeline.Play();
    timeline.Advance(1.0);
    EXPECT_EQ(timeline.Seconds(), 0.0);
}

TEST_F(TimelineTest, WeightsBlendAndClipsWithoutAreNotShown) {
    timeline.Choose(States{{0, 0.0, 0.25f}, {2, 0.0, 0.5f}});
    timeline.Seek(0.5);
    EXPECT_EQ(Shown(), (States{{0, 0.5, 0.25f}, {2, 0.5, 0.5f}}));
    EXPECT_EQ(timeline.ClipsLabel(), "slide 0.25, pan 0.50");
    timeline.SetWeight(0, 0.0f);
    timeline.SetWeight(2, 3.0f);
    EXPECT_EQ(Shown(), (States{{2, 0.5, 1.0f}}));
    timeline.ChooseOnly(0);
    EXPECT_EQ(Shown(), (States{{0, 0.5, 1.0f}})) << "whole, if it is alone";
}

TEST(Timeline, OfASceneWithoutAnimationsStaysAtRest) {
    Timeline timeline;
    timeline.Play();
    timeline.Seek(1.0);
    timeline.Advance(1.0);
    EXPECT_TRUE(timeline.IsEmpty());
    EXPECT_TRUE(timeline.IsAtRest());
    EXPECT_FALSE(timeline.IsPlaying());
    EXPECT_TRUE(timeline.Shown().empty());
}

}  // namespace raygraph::editor::timeline_test
