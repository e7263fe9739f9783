// Tests that events are processed while the device is busy.
#include "editor/app/edit.h"
#include "tests/editor/editor_test.h"

namespace raygraph::editor::busy_test {

TEST(FrameInput, WhatComesLaterIsAddedAndWhatWasHeldHasHappened) {
    FrameInput input;
    input.extent = {10, 20};
    input.seconds = 0.5f;
    input.wheel = 1.0f;
    input.buttons[0] = true;
    input.keys[static_cast<size_t>(Key::A)] = true;
    input.pressed = {Key::A};
    input.isControl = true;
    input.text = U"a";
    input.dropped = {"a.gltf"};
    input.isClosing = true;
    FrameInput later;
    later.extent = {30, 40};
    later.scale = 2.0f;
    later.seconds = 0.25f;
    later.mouse = {3, 4};
    later.wheel = 2.0f;
    later.buttons[1] = true;
    later.keys[static_cast<size_t>(Key::B)] = true;
    later.pressed = {Key::B};
    later.isShift = later.isAlt = true;
    later.text = U"b";
    later.dropped = {"b.gltf"};
    input.Append(std::move(later));
    EXPECT_EQ(input.extent, (rhi::Extent2D{30, 40}));
    EXPECT_EQ(input.scale, 2.0f);
    EXPECT_EQ(input.seconds, 0.75f);
    EXPECT_EQ(input.mouse, glm::vec2(3, 4));
    EXPECT_EQ(input.wheel, 3.0f);
    EXPECT_EQ(input.buttons, (std::array{true, true, false}));
    EXPECT_TRUE(input.IsDown(Key::A) && input.IsDown(Key::B));
    EXPECT_EQ(input.pressed, (std::vector{Key::A, Key::B}));
    EXPECT_TRUE(input.isControl && input.isShift && input.isAlt);
    EXPECT_EQ(input.text, U"ab");
    EXPECT_EQ(input.dropped, (std::vector<std::filesystem::path>{"a.gltf", "b.gltf"}));
    EXPECT_TRUE(input.isClosing);
}

class BusyTest : public EditorTest {
  protected:
    void ShowPreviews() {
        viewport::BudgetSettings budget = editor.Work().view.Budget();
        budget.whilePreparing = viewport::PreparingView::Preview;
        editor.Work().view.SetBudget(budget);
    }
};

// F1 opens the help, and the window's button ends the editor: both arrive while no frame can begin.
TEST_F(BusyTest, EventsAreTakenUntilAFrameCanBegin) {
    class BusyScreen final : public Screen {
      public:
        std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) override {
            ++frames;
            EXPECT_TRUE(isReady);
            isReady = false;
            return m_picture.Begin(renderer, extent);
        }
        void End(Renderer& renderer, TextureId drawn) override { m_picture.End(renderer, drawn); }
        bool IsReady(const Renderer&) override { return isReady = ++m_asked % 6 == 0; }

        int frames = 0;
        bool isReady = true;

      private:
        PictureScreen m_picture;
        int m_asked = 0;
    } busy;
    int polls = 0;
    const auto poll = [&](double) {
        FrameInput input;
        input.extent = {320, 200};
        ++polls;
        if (polls == 4) input.pressed = {Key::F1};
        input.isClosing = polls == 16;
        return input;
    };
    EXPECT_FALSE(editor.Work().panels.help);
    RunFrames(editor, busy, {.poll = poll, .setTitle = [](const std::string&) {}});
    EXPECT_TRUE(editor.Work().panels.help);
    EXPECT_EQ(busy.frames, 4);  // one frame for the first poll, and six polls before each other one
    EXPECT_EQ(polls, 19);
}

// The panels are drawn meanwhile, and the picture that is saved is the first frame that has one.
TEST_F(BusyTest, PanelsAreDrawnWhilePipelinesAreMade) {
    class WindowLike final : public Screen {
      public:
        std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) override {
            return m_picture.Begin(renderer, extent);
        }
        void End(Renderer& renderer, TextureId drawn) override {
            ++withoutPicture;
            m_picture.End(renderer, drawn);
        }
        bool TryEnd(Renderer& renderer, TextureId drawn) override {
            renderer.Present(drawn);
            if (!renderer.PreparePipelines()) return false;
            ++whole;
            renderer.Execute();
            return true;
        }

        int withoutPicture = 0, whole = 0;

      private:
        PictureScreen m_picture;
    } window;
    FrameInput input;
    input.extent = {320, 200};
    editor.SaveWindow(folder / "window.png");
    for (int frame = 0; frame < 100'000 && editor.SavedCount() == 0; ++frame) {
        EXPECT_EQ(editor.FrameError(), "");
        ASSERT_TRUE(editor.Frame(input, window));
        EXPECT_EQ(window.whole + window.withoutPicture, frame + 1);
        if (window.whole == 0) {
            EXPECT_TRUE(editor.IsBusy()) << "saved without a picture";
        }
    }
    EXPECT_GT(window.withoutPicture, 0);
    EXPECT_TRUE(std::filesystem::exists(folder / "window.png"));
}

// While the path tracer's pipeline is made, a preview is shown, which the user does not want to save.
TEST_F(BusyTest, PicturesAreSavedOfSamplesAndNotOfAPreview) {
    ShowPreviews();
    FrameInput input;
    input.extent = {320, 200};
    editor.SavePicture(folder / "picture.png");
    ASSERT_TRUE(editor.Frame(input, screen));
    EXPECT_TRUE(editor.IsPreparing());
    for (int frame = 0; frame < 100'000 && editor.SavedCount() == 0; ++frame) {
        EXPECT_EQ(editor.FrameError(), "");
        ASSERT_TRUE(editor.Frame(input, screen));
        if (editor.IsPreparing()) {
            EXPECT_EQ(editor.SavedCount(), 0u);
        }
    }
    EXPECT_FALSE(editor.IsPreparing());
    EXPECT_TRUE(std::filesystem::exists(folder / "picture.png"));
}

// Frames copy the scene to the device, so they must not be throttled like those of a preview, which leave a
// CPU device to the compiler.
TEST_F(BusyTest, FramesThatCopyAScene_AreNotHeldBackByAPreview) {
    ShowPreviews();
    FrameInput input;
    input.extent = {320, 200};
    // The path tracer's pipeline is being made for the empty scene
    for (int frame = 0; frame < 1000 && !editor.Work().view.Progress().isPreview; ++frame)
        ASSERT_TRUE(editor.Frame(input, screen));
    ASSERT_TRUE(editor.IsPreparing());
    editor.Open(test::SourceFile("scenes/texture_formats_grid.gltf"));
    int copying = 0;
    while (editor.Work().IsLoading()) {
        ASSERT_TRUE(editor.Frame(input, screen));
        if (!editor.Work().IsLoading() || editor.Work().loader.IsLoading()) continue;
        ++copying;
        EXPECT_FALSE(editor.IsPreparing());
    }
    EXPECT_GT(copying, 0);
}

}  // namespace raygraph::editor::busy_test
