// FrameInput is the user's input since the last frame, from a window or a script. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "rhi/format.h"

namespace raygraph::editor {

// Scripts use these names.
// clang-format off
#define RAYGRAPH_KEYS(KEY)                                                                        \
    KEY(A) KEY(B) KEY(C) KEY(D) KEY(E) KEY(F) KEY(G) KEY(H) KEY(I) KEY(J) KEY(K) KEY(L) KEY(M)    \
    KEY(N) KEY(O) KEY(P) KEY(Q) KEY(R) KEY(S) KEY(T) KEY(U) KEY(V) KEY(W) KEY(X) KEY(Y) KEY(Z)    \
    KEY(Digit0) KEY(Digit1) KEY(Digit2) KEY(Digit3) KEY(Digit4) KEY(Digit5) KEY(Digit6)           \
    KEY(Digit7) KEY(Digit8) KEY(Digit9) KEY(F1) KEY(F2) KEY(F3) KEY(F4) KEY(F5) KEY(F6) KEY(F7)   \
    KEY(F8) KEY(F9) KEY(F10) KEY(F11) KEY(F12) KEY(Tab) KEY(Space) KEY(Enter) KEY(Escape)         \
    KEY(Backspace) KEY(Delete) KEY(Home) KEY(End) KEY(Left) KEY(Right) KEY(Up) KEY(Down)          \
    KEY(PageUp) KEY(PageDown) KEY(Period)
// clang-format on

#define RAYGRAPH_DECLARE_KEY(name) name,
enum class Key : uint8_t { RAYGRAPH_KEYS(RAYGRAPH_DECLARE_KEY) Count };
#undef RAYGRAPH_DECLARE_KEY
inline constexpr size_t kKeyCount = static_cast<size_t>(Key::Count);
const char* Name(Key key);  // of a digit's key: "1"
// Compares names without case.
bool IsSameName(std::string_view a, std::string_view b);
// Returns whether the text has the part, without regard to the case of ASCII letters.
bool HasPart(std::string_view text, std::string_view part);
// Returns the key of a name, in any case. Throws Error{Usage} for an unknown name.
Key KeyFromName(std::string_view name);

enum class MouseButton : uint8_t { Left, Right, Middle };
inline constexpr size_t kMouseButtonCount = 3;

struct FrameInput {
    rhi::Extent2D extent;          // size of the window, in pixels; empty: minimized
    float scale = 1.0f;            // pixels per point of the user interface
    float seconds = 1.0f / 60.0f;  // time since the last frame
    glm::vec2 mouse{-1e6f};        // pixels from the upper left corner; far outside: no pointer
    float wheel = 0.0f;            // notches; positive: away from the user
    std::array<bool, kMouseButtonCount> buttons{};  // held
    std::array<bool, kKeyCount> keys{};             // held
    std::vector<Key> pressed;                       // keys that went down
    bool isControl = false, isShift = false, isAlt = false;
    std::u32string text;
    std::vector<std::filesystem::path> dropped;
    bool isClosing = false;

    // Appends the input that followed before a frame was drawn.
    void Append(FrameInput&& later);
    // Returns whether the user does anything beyond `before`, the input of the last frame.
    bool IsActiveSince(const FrameInput& before) const;
    bool IsDown(Key key) const { return keys[static_cast<size_t>(key)]; }
    bool IsDown(MouseButton button) const { return buttons[static_cast<size_t>(button)]; }
};

}  // namespace raygraph::editor
