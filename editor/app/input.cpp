#include "editor/app/input.h"

#include <algorithm>
#include <cctype>
#include <iterator>

#include "base/text.h"

namespace raygraph::editor {

namespace {

#define RAYGRAPH_NAME_KEY(name) #name,
constexpr std::array<const char*, kKeyCount> kKeyNames{RAYGRAPH_KEYS(RAYGRAPH_NAME_KEY)};
#undef RAYGRAPH_NAME_KEY

}  // namespace

bool IsSameName(std::string_view a, std::string_view b) {
    return std::ranges::equal(
        a, b, [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

bool HasPart(std::string_view text, std::string_view part) {
    const auto isSame = [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); };
    // std::ranges::search is not used: clang 14 does not compile what it returns
    return part.empty() ||
           std::search(text.begin(), text.end(), part.begin(), part.end(), isSame) != text.end();
}

const char* Name(Key key) {
    const char* name = kKeyNames[static_cast<size_t>(key)];
    return key >= Key::Digit0 && key <= Key::Digit9 ? name + std::string_view("Digit").size() : name;
}

void FrameInput::Append(FrameInput&& later) {
    extent = later.extent;
    scale = later.scale;
    seconds += later.seconds;
    mouse = later.mouse;
    wheel += later.wheel;
    // A press that was shorter than a frame still counts
    for (size_t i = 0; i < buttons.size(); ++i) buttons[i] |= later.buttons[i];
    for (size_t i = 0; i < keys.size(); ++i) keys[i] |= later.keys[i];
    pressed.insert(pressed.end(), later.pressed.begin(), later.pressed.end());
    isControl |= later.isControl;
    isShift |= later.isShift;
    isAlt |= later.isAlt;
    text += later.text;
    dropped.insert(dropped.end(), std::make_move_iterator(later.dropped.begin()),
                   std::make_move_iterator(later.dropped.end()));
    isClosing |= later.isClosing;
}

bool FrameInput::IsActiveSince(const FrameInput& before) const {
    const auto isHeld = [](bool held) { return held; };
    return extent != before.extent || scale != before.scale || mouse != before.mouse || wheel != 0.0f ||
           std::ranges::any_of(buttons, isHeld) || std::ranges::any_of(keys, isHeld) || !pressed.empty() ||
           !text.empty() || !dropped.empty() || isClosing;
}

Key KeyFromName(std::string_view name) {
    for (size_t i = 0; i < kKeyCount; ++i)
        if (IsSameName(Name(static_cast<Key>(i)), name)) return static_cast<Key>(i);
    throw MakeError(ErrorKind::Usage, "there is no key '{}'", name);
}

}  // namespace raygraph::editor
