// The user's input since the last frame, and CameraController, which navigates by it: it orbits around a
// pivot, pans, dollies towards the pivot, or flies. Pure.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/model/camera_view.h"
#include "rhi/format.h"

namespace raygraph::editor {

class CameraController {
  public:
    // Starts from a camera; the pivot lies `distance` meters ahead of it.
    void Set(const scene::CameraView& view, float distance);
    const scene::CameraView& View() const { return m_view; }
    glm::dvec3 Pivot() const { return m_view.eye + glm::dvec3(m_distance * m_view.forward); }
    float Distance() const { return m_distance; }

    // Orbits about the pivot by radians to the right and up; +y stays up. It stops short of looking straight
    // along y.
    void Orbit(glm::vec2 angles);
    // Turns the view by radians to the right and up; the eye stays.
    void Turn(glm::vec2 angles);
    // Moves by fractions of the picture's height, so that the point under the cursor follows it.
    void Pan(glm::vec2 shares);
    // Each notch of the wheel takes 15 % off the distance to the pivot. An orthographic view narrows.
    void Dolly(float notches);
    // Moves the eye and the pivot by meters along right, up and forward.
    void Fly(glm::vec3 meters);
    // Frames all of `bounds`, keeping the direction of the view. An empty box counts as one meter about
    // its middle.
    void Frame(const scene::Bounds& bounds);

  private:
    void Face(glm::vec3 forward);
    scene::CameraView m_view;
    float m_distance = 1.0f;
};

// --- FrameInput: the input since the last frame, from a window or a script ---

// Scripts use these names.
// clang-format off
#define RAYGRAPH_KEYS(KEY)                                                                        \
    KEY(A) KEY(B) KEY(C) KEY(D) KEY(E) KEY(F) KEY(G) KEY(H) KEY(I) KEY(J) KEY(K) KEY(L) KEY(M)    \
    KEY(N) KEY(O) KEY(P) KEY(Q) KEY(R) KEY(S) KEY(T) KEY(U) KEY(V) KEY(W) KEY(X) KEY(Y) KEY(Z)    \
    KEY(Digit0) KEY(Digit1) KEY(Digit2) KEY(Digit3) KEY(Digit4) KEY(Digit5) KEY(Digit6)           \
    KEY(Digit7) KEY(Digit8) KEY(Digit9) KEY(F1) KEY(F2) KEY(F3) KEY(F4) KEY(F5) KEY(F6) KEY(F7)   \
    KEY(F8) KEY(F9) KEY(F10) KEY(F11) KEY(F12) KEY(Tab) KEY(Space) KEY(Enter) KEY(Escape)         \
    KEY(Backspace) KEY(Delete) KEY(Home) KEY(End) KEY(Left) KEY(Right) KEY(Up) KEY(Down)          \
    KEY(PageUp) KEY(PageDown)
// clang-format on

#define RAYGRAPH_DECLARE_KEY(name) name,
enum class Key : uint8_t { RAYGRAPH_KEYS(RAYGRAPH_DECLARE_KEY) Count };
#undef RAYGRAPH_DECLARE_KEY
inline constexpr size_t kKeyCount = static_cast<size_t>(Key::Count);
const char* Name(Key key);
// Compares names without case.
bool IsSameName(std::string_view a, std::string_view b);
// Returns the key of a name, in any case. Throws Error{Usage} for an unknown name.
Key KeyFromName(std::string_view name);

enum class MouseButton : uint8_t { Left, Right, Middle };
inline constexpr size_t kMouseButtonCount = 3;

struct FrameInput {
    rhi::Extent2D extent;          // of the window, in pixels; empty: minimized
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
