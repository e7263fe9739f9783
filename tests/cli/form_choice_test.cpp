// Which form of the integrator a session takes where it may choose, and what is remembered of it.
#include "editor/session/form_choice.h"

#include <fstream>
#include <sstream>

#include "editor/session/form_text.h"
#include "editor/session/session.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::session {

namespace {

using passes::IntegratorForm;
using test::ExpectError;

std::string TextOf(const std::filesystem::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}

std::string Found(const FormMemory& memory, std::string_view key) {
    const auto form = memory.Find(key);
    return form ? FormText(*form) : "none";
}

class FormChoiceTest : public testing::VulkanTest {
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

TEST_F(FormChoiceTest, TheMemoryKeepsTheLastChoiceOfEachKey) {
    const std::filesystem::path file = folder.Path() / "new" / "forms.txt";
    const FormMemory memory(file);
    EXPECT_EQ(Found(memory, "a"), "none");
    memory.Remember("a", ParseForm("wavefront:4"));
    memory.Remember("b", ParseForm("loop"));
    memory.Remember("a", ParseForm("wavefront:8"));
    EXPECT_EQ(Found(memory, "a"), "wavefront:8");
    EXPECT_EQ(Found(FormMemory(file), "b"), "loop");
    EXPECT_EQ(TextOf(file), "b\tloop\na\twavefront:8\n");
}

TEST_F(FormChoiceTest, LinesThatAreNoChoiceAreNone) {
    const std::filesystem::path file = folder.Path() / "forms.txt";
    std::ofstream(file) << "a\nb\tspiral\nc\twavefront:0\n\td\tloop\n\ne\tloop\n";
    const FormMemory memory(file);
    for (const char* key : {"a", "b", "c", "d", ""}) EXPECT_EQ(Found(memory, key), "none") << key;
    EXPECT_EQ(Found(memory, "e"), "loop");
}

TEST_F(FormChoiceTest, WithoutAPlaceNothingIsRemembered) {
    std::ofstream(folder.Path() / "file") << "x";
    for (const std::filesystem::path& file :
         {std::filesystem::path(), folder.Path() / "file" / "forms.txt"}) {
        const FormMemory memory(file);
        memory.Remember("a", ParseForm("loop"));
        EXPECT_EQ(Found(memory, "a"), "none");
    }
}

TEST_F(FormChoiceTest, EveryFormIsMeasured) {
    SceneInput input = Cornell();
    DeviceScene scene(Device(), input, Small());
    const std::array forms{ParseForm("loop"), ParseForm("wavefront:2")};
    const std::vector<FormTime> times = MeasureForms(scene, forms);
    ASSERT_EQ(times.size(), forms.size());
    for (size_t i = 0; i < forms.size(); ++i) {
        EXPECT_EQ(times[i].form, forms[i]);
        EXPECT_GT(times[i].msPerSample, 0.0);
    }
}

TEST_F(FormChoiceTest, AChoiceIsMeasuredOnceAndNotAtAllOnACpu) {
    const std::filesystem::path file = folder.Path() / "forms.txt";
    SceneInput input = Cornell();
    DeviceScene scene(Device(), input, Small());
    const passes::FormSettings form = ChooseForm(scene, FormMemory(file));
    if (Device().Info().type == rhi::DeviceType::Cpu) {
        EXPECT_EQ(form.kind, IntegratorForm::Loop);
        EXPECT_FALSE(std::filesystem::exists(file));
        return;
    }
    const std::string text = TextOf(file);
    ASSERT_NE(text.find('\t'), std::string::npos) << text;
    EXPECT_EQ(text.substr(text.find('\t') + 1), FormText(form) + "\n");
    // What is written there is believed
    std::ofstream(file) << text.substr(0, text.find('\t')) << "\twavefront:63\n";
    EXPECT_EQ(FormText(ChooseForm(scene, FormMemory(file))), "wavefront:63");
}

TEST_F(FormChoiceTest, ARenderRecordsItsFormAndKeepsItWhenItGoesOn) {
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
TEST_F(FormChoiceTest, EachPictureOfASeriesKeepsItsForm) {
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
