// What the user did since the last frame, wherever it comes from: a window, or a script.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "rhi/format.h"

namespace raygraph::editor {

// Name of a key in scripts and in the help.
#define RAYGRAPH_KEYS(X)                                                                                     \
    X(A)                                                                                                     \
    X(B)                                                                                                     \
    X(C) X(D) X(E) X(F) X(G) X(H) X(I) X(J) X(K) X(L) X(M) X(N) X(O) X(P) X(Q) X(R) X(S) X(T) X(U) X(V) X(W) \
        X(X) X(Y) X(Z) X(Digit0) X(Digit1) X(Digit2) X(Digit3) X(Digit4) X(Digit5) X(Digit6) X(Digit7)       \
            X(Digit8) X(Digit9) X(F1) X(F2) X(F3) X(F4) X(F5) X(F6) X(F7) X(F8) X(F9) X(F10) X(F11) X(F12)   \
                X(Tab) X(Space) X(Enter) X(Escape) X(Backspace) X(Delete) X(Home) X(End) X(Left) X(Right)    \
                    X(Up) X(Down) X(PageUp) X(PageDown)

#define RAYGRAPH_DECLARE_KEY(name) name,
enum class Key : uint8_t { RAYGRAPH_KEYS(RAYGRAPH_DECLARE_KEY) Count };
#undef RAYGRAPH_DECLARE_KEY
inline constexpr size_t kKeyCount = static_cast<size_t>(Key::Count);
const char* Name(Key key);
// Error{Usage} for a name that no key has; case does not matter.
Key KeyFromName(std::string_view name);

enum class MouseButton : uint8_t { Left, Right, Middle };
inline constexpr size_t kMouseButtonCount = 3;

struct FrameInput {
    rhi::Extent2D extent;          // pixels of the window; empty: minimized
    float scale = 1.0f;            // pixels to a point of the user interface
    float seconds = 1.0f / 60.0f;  // since the last frame
    glm::vec2 mouse{-1e6f};        // pixels from the upper left corner; far outside: not there
    float wheel = 0.0f;            // notches, away from the user positive
    std::array<bool, kMouseButtonCount> buttons{};  // held
    std::array<bool, kKeyCount> keys{};             // held
    std::vector<Key> pressed;                       // went down
    bool isControl = false, isShift = false, isAlt = false;
    std::u32string text;
    std::vector<std::filesystem::path> dropped;
    bool isClosing = false;

    bool IsDown(Key key) const { return keys[static_cast<size_t>(key)]; }
    bool IsDown(MouseButton button) const { return buttons[static_cast<size_t>(button)]; }
};

}  // namespace raygraph::editor
