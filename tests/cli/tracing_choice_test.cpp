// Which form of the integrator and which traversal a session takes where it may choose, and what is remembered.
#include "editor/session/tracing_choice.h"

#include <fstream>

#include "editor/session/form_text.h"
#include "editor/session/session.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::session {

namespace {

using passes::IntegratorForm;
using test::ExpectError;
using test::TextOf;

std::string Found(const ChoiceMemory& memory, std::string_view key) {
    return memory.Find(key).value_or("none");
}

class TracingChoiceTest : public testing::VulkanTest {
  protected:
    static SceneInput Cornell() { return LoadInput(test::SceneFile("cornell.gltf")); }
    static PictureSettings Small(const char* form = "auto") {
        return SettingsFrom({{"size", "16x8"}, {"integrator-form", form}});
    }
    static RenderFile Render(const SessionDesc& desc, uint32_t samples) {
        Session session(Device(), Cornell(), desc);
        session.Run({.samples = samples});
        return std::move(session.Result()).render;
    }
    static std::string FormOf(const RenderFile& render) {
        return render.settings.at(std::string(kFormSetting));
    }

    test::TemporaryFolder folder;
};

}  // namespace

TEST_F(TracingChoiceTest, TheMemoryKeepsTheLastChoiceOfEachKey) {
    const std::filesystem::path file = folder.Path() / "new" / "tracing.txt";
    const ChoiceMemory memory(file);
    EXPECT_EQ(Found(memory, "a"), "none");
    memory.Remember("a", "own wavefront:4");
    memory.Remember("b", "driver loop");
    memory.Remember("a", "own wavefront:8");
    EXPECT_EQ(Found(memory, "a"), "own wavefront:8");
    EXPECT_EQ(Found(ChoiceMemory(file), "b"), "driver loop");
    EXPECT_EQ(TextOf(file), "b\tdriver loop\na\town wavefront:8\n");
}

TEST_F(TracingChoiceTest, LinesWithoutAKeyAndATextAreNone) {
    const std::filesystem::path file = folder.Path() / "tracing.txt";
    std::ofstream(file) << "a\n\td\tx\n\ne\ty\n";
    const ChoiceMemory memory(file);
    for (const char* key : {"a", "d"}) EXPECT_EQ(Found(memory, key), "none") << key;
    EXPECT_EQ(Found(memory, "e"), "y");
}

TEST_F(TracingChoiceTest, WithoutAPlaceNothingIsRemembered) {
    std::ofstream(folder.Path() / "file") << "x";
    for (const std::filesystem::path& file :
         {std::filesystem::path(), folder.Path() / "file" / "tracing.txt"}) {
        const ChoiceMemory memory(file);
        memory.Remember("a", "x");
        EXPECT_EQ(Found(memory, "a"), "none");
    }
}

TEST_F(TracingChoiceTest, TextsAreReadAsTheyAreWritten) {
    for (const char* text : {"own wavefront:8", "driver loop", "auto auto"})
        EXPECT_EQ(TracingText(ParseTracing(text)), text);
    for (const char* text : {"", "own", "loop", "own spiral", "own wavefront:0", "own  loop"})
        EXPECT_THROW(std::ignore = ParseTracing(text), Error) << text;
}

TEST_F(TracingChoiceTest, EveryChoiceIsMeasured) {
    SceneInput input = Cornell();
    DeviceScene scene(Device(), input, Small());
    const std::array choices{ParseTracing("driver loop"), ParseTracing("own wavefront:2")};
    const std::vector<TracingTime> times = MeasureTracing(scene, choices);
    ASSERT_EQ(times.size(), choices.size());
    for (size_t i = 0; i < choices.size(); ++i) {
        EXPECT_EQ(times[i].choice, choices[i]);
        EXPECT_GT(times[i].msPerSample, 0.0);
    }
}

TEST_F(TracingChoiceTest, AChoiceIsMeasuredOnceAndNotAtAllOnACpu) {
    const std::filesystem::path file = folder.Path() / "tracing.txt";
    SceneInput input = Cornell();
    DeviceScene scene(Device(), input, Small());
    const TracingChoice chosen = ChooseTracing(scene, {}, ChoiceMemory(file));
    if (Device().Info().type == rhi::DeviceType::Cpu) {
        EXPECT_EQ(TracingText(chosen), "own loop");
        EXPECT_FALSE(std::filesystem::exists(file));
        return;
    }
    const std::string text = TextOf(file);
    const size_t tab = text.find('\t');
    ASSERT_NE(tab, std::string::npos) << text;
    EXPECT_EQ(text.substr(tab + 1), TracingText(chosen) + "\n");
    // What is written there is believed, if it is a choice
    std::ofstream(file) << text.substr(0, tab) << "\tdriver wavefront:63\n";
    EXPECT_EQ(TracingText(ChooseTracing(scene, {}, ChoiceMemory(file))), "driver wavefront:63");
    std::ofstream(file) << text.substr(0, tab) << "\tauto loop\n";
    EXPECT_NE(ChooseTracing(scene, {}, ChoiceMemory(file)).traversal, passes::Traversal::Auto);
}

TEST_F(TracingChoiceTest, WhatIsWantedStays) {
    SceneInput input = Cornell();
    DeviceScene scene(Device(), input, Small());
    const TracingChoice own = ChooseTracing(scene, ParseTracing("own wavefront:3"), ChoiceMemory({}));
    EXPECT_EQ(TracingText(own), "own wavefront:3");
    if (Device().Info().type == rhi::DeviceType::Cpu) {
        EXPECT_EQ(TracingText(ChooseTracing(scene, ParseTracing("driver auto"), ChoiceMemory({}))),
                  "driver loop");
        EXPECT_EQ(TracingText(ChooseTracing(scene, ParseTracing("auto wavefront:2"), ChoiceMemory({}))),
                  "own wavefront:2");
    }
    PictureSettings settings = Small();
    settings.traversal = passes::Traversal::Driver;
    SceneInput again = Cornell();
    DeviceScene without(Device(), again, settings);
    EXPECT_EQ(TracingText(ChooseTracing(without, ParseTracing("own loop"), ChoiceMemory({}))), "driver loop");
}

TEST_F(TracingChoiceTest, ARenderRecordsItsFormAndKeepsItWhenItGoesOn) {
    const RenderFile chosen = Render({.settings = Small()}, 2);
    EXPECT_NE(FormOf(chosen), "auto");

    const ResumedRender begun{.path = "begun.exr", .render = Render({.settings = Small("wavefront:2")}, 2)};
    EXPECT_EQ(FormOf(Render(Resuming(begun), 3)), "wavefront:2");
    SessionDesc open = Resuming(begun);
    open.settings.paths.form = {};
    EXPECT_EQ(FormOf(Render(open, 3)), "wavefront:2");
    open.settings.paths.form = ParseForm("loop");
    ExpectError(
        ErrorKind::BadInput, [&] { const Session session(Device(), Cornell(), open); },
        "integrator-form: wavefront:2 against loop");

    // As files are from before there were other forms
    ResumedRender old{.path = "old.exr", .render = Render({.settings = Small("loop")}, 2)};
    old.render.settings.erase(std::string(kFormSetting));
    EXPECT_EQ(FormOf(Render(Resuming(old), 3)), "loop");
}

// As of an animation that was stopped in one of its frames, on another device.
TEST_F(TracingChoiceTest, EachPictureOfASeriesKeepsItsForm) {
    const ResumedRender second{.path = "second.exr", .render = Render({.settings = Small("wavefront:2")}, 2)};
    Session session(Device(), Cornell(), {.settings = Small()});
    session.Run({.samples = 1});
    const std::string chosen = FormOf(session.Result().render);
    session.StartPicture({.resumed = &second});
    session.Run({.samples = 3});
    EXPECT_EQ(FormOf(session.Result().render), "wavefront:2");
    session.StartPicture({});
    session.Run({.samples = 1});
    EXPECT_EQ(FormOf(session.Result().render), chosen);
}

TEST(FormSetting, OneThatWasLeftOpenIsAnyForm) {
    EXPECT_EQ(FirstDifference({{"integrator-form", "auto"}}, {{"integrator-form", "wavefront:3"}}), "");
    EXPECT_EQ(FirstDifference({{"integrator-form", "loop"}}, {}), "");
    EXPECT_EQ(FirstDifference({{"integrator-form", "loop"}}, {{"integrator-form", "wavefront:3"}}),
              "integrator-form: loop against wavefront:3");
}

}  // namespace raygraph::session
