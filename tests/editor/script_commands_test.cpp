// Tests the parser of scripts, without playing them.
#include "editor/app/script.h"

#include <gtest/gtest.h>

#include <string>

#include "base/error.h"

namespace raygraph::editor::script_commands_test {

namespace {

template <typename Command>
Command Only(const std::string& text) {
    const std::vector<ScriptLine> lines = ParseScript(text, "s");
    EXPECT_EQ(lines.size(), 1u) << text;
    return std::get<Command>(lines.at(0).command);
}

std::string Refusal(const std::string& text) {
    try {
        ParseScript(text, "s");
    } catch (const Error& error) {
        EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
        return error.what();
    }
    return "";
}

}  // namespace

TEST(ScriptCommands, AreReadWithTheirNumbersAndTexts) {
    EXPECT_TRUE(ParseScript("", "s").empty());
    const std::vector<ScriptLine> lines = ParseScript("# nothing\n\n  wait   # until then\nclose", "s");
    ASSERT_EQ(lines.size(), 2u);
    EXPECT_EQ(lines[0].number, 3u);
    EXPECT_EQ(lines[0].text, "wait");
    EXPECT_EQ(lines[1].number, 4u);
    EXPECT_EQ(Only<SetSize>("size 640x0").extent, (rhi::Extent2D{640, 0}));
    EXPECT_EQ(Only<MoveMouse>("mouse -3 2.5").place, glm::vec2(-3.0f, 2.5f));
    EXPECT_EQ(Only<DropFile>("open a b.gltf").file, "a b.gltf");
    EXPECT_EQ(Only<TypeText>("text gr\xC3\xBC\xC3\x9F \xF0\x9F\x98\x80").text, U"gr\u00FC\u00DF \U0001F600");
    const PressKey key = Only<PressKey>("key ctrl+shift+z");
    EXPECT_TRUE(key.key == Key::Z && key.isControl && key.isShift);
    const HoldButton drag = Only<HoldButton>("drag middle 3 -4");
    EXPECT_TRUE(drag.button == MouseButton::Middle && drag.isDown && drag.isUp && drag.isDragged);
    EXPECT_EQ(drag.way, glm::vec2(3.0f, -4.0f));
    EXPECT_FALSE(Only<HoldButton>("press left").isUp);
    EXPECT_FALSE(Only<HoldButton>("release left").isDown);
    EXPECT_EQ(Only<Expectation>("expect view side by side").view, viewport::View::SideBySide);
    EXPECT_EQ(Only<Expectation>("expect samples-above 7").number, 7u);
    EXPECT_EQ(Only<PlayFor>("play 0.5").seconds, 0.5);
    EXPECT_EQ(Only<ShowTime>("time 2").seconds, 2.0);
    EXPECT_EQ(Only<ChooseClips>("clips walk:0.3,look left").list, "walk:0.3,look left");
    EXPECT_EQ(Only<Expectation>("expect time 0.250").text, "0.250");
    EXPECT_EQ(Only<Expectation>("expect playing yes").number, 1u);
}

TEST(ScriptCommands, RefusalsNameTheLine) {
    EXPECT_EQ(Refusal("wait\n\nsmile at me\n"), "s:3: smile at me: there is no such command");
    EXPECT_EQ(Refusal("mouse 1"), "s:1: mouse 1: a word is missing");
    EXPECT_EQ(Refusal("text"), "s:1: text: a word is missing");
    EXPECT_EQ(Refusal("click leftmost"), "s:1: click leftmost: there is no mouse button \"leftmost\"");
    EXPECT_EQ(Refusal("key alt+z"), "s:1: key alt+z: there is no modifier \"alt\"");
    EXPECT_EQ(Refusal("expect asking perhaps"),
              "s:1: expect asking perhaps: it is yes or no, not \"perhaps\"");
}

// Otherwise numbers would be cast to types that cannot hold them, or play forever.
TEST(ScriptCommands, NumbersAreFiniteAndInRange) {
    for (const char* line : {"frames 1e30",         "frames -1",       "frames 1.5",
                             "frames nan",          "samples -1",      "samples 1e10",
                             "samples inf",         "mouse nan 0",     "mouse 0 1e30",
                             "drag left inf 0",     "wheel nan",       "size 1e9x1",
                             "size -1x1",           "scale 0",         "scale nan",
                             "budget -1",           "budget inf",      "material base 1 nan 0",
                             "material base 2 0 0", "expect edits -1", "expect samples-below x"})
        EXPECT_NE(Refusal(line), "") << line;
    for (const char* line : {"play -1", "play nan", "play 1e9", "time -1", "time inf"})
        EXPECT_NE(Refusal(line), "") << line;
}

TEST(ScriptCommands, ControlCharactersAndBrokenUtf8AreRefused) {
    for (const char* line : {"text a\x1b[31m", "open \xFF.gltf", "text \xC3", "open a\x7F"}) {
        const std::string refusal = Refusal(line);
        EXPECT_NE(refusal.find("has control characters"), std::string::npos) << refusal;
        EXPECT_EQ(refusal.find_first_of("\x1b\x7f\xff\xc3"), std::string::npos) << "nor has the message";
    }
}

}  // namespace raygraph::editor::script_commands_test
