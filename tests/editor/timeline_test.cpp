// Tests which animations are played, and at what time.
#include "editor/app/timeline.h"

#include <gtest/gtest.h>

#include "tests/editor/moving_scene.h"

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
