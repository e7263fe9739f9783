#include "editor/app/style.h"

#include <array>

namespace raygraph::editor {

namespace {

ImVec4 Gray(float value, float alpha = 1.0f) {
    return {value, value, value * 1.03f, alpha};
}

struct KeyPair {
    Key from;
    ImGuiKey to;
};
constexpr std::array kKeyPairs{
    KeyPair{Key::Tab, ImGuiKey_Tab},
    KeyPair{Key::Left, ImGuiKey_LeftArrow},
    KeyPair{Key::Right, ImGuiKey_RightArrow},
    KeyPair{Key::Up, ImGuiKey_UpArrow},
    KeyPair{Key::Down, ImGuiKey_DownArrow},
    KeyPair{Key::PageUp, ImGuiKey_PageUp},
    KeyPair{Key::PageDown, ImGuiKey_PageDown},
    KeyPair{Key::Home, ImGuiKey_Home},
    KeyPair{Key::End, ImGuiKey_End},
    KeyPair{Key::Delete, ImGuiKey_Delete},
    KeyPair{Key::Backspace, ImGuiKey_Backspace},
    KeyPair{Key::Space, ImGuiKey_Space},
    KeyPair{Key::Enter, ImGuiKey_Enter},
    KeyPair{Key::Escape, ImGuiKey_Escape},
    KeyPair{Key::A, ImGuiKey_A},
    KeyPair{Key::C, ImGuiKey_C},
    KeyPair{Key::V, ImGuiKey_V},
    KeyPair{Key::X, ImGuiKey_X},
    KeyPair{Key::Y, ImGuiKey_Y},
    KeyPair{Key::Z, ImGuiKey_Z},
};

}  // namespace

void ApplyStyle(ImGuiStyle& style) {
    style = ImGuiStyle();
    ImGui::StyleColorsDark(&style);
    style.WindowPadding = {10.0f, 8.0f};
    style.FramePadding = {7.0f, 4.0f};
    style.ItemSpacing = {7.0f, 5.0f};
    style.ScrollbarSize = 12.0f;
    style.WindowRounding = 0.0f;
    style.FrameRounding = 3.0f;
    style.GrabRounding = 3.0f;
    style.PopupRounding = 4.0f;
    style.WindowBorderSize = 1.0f;
    style.FrameBorderSize = 0.0f;
    const ImVec4 accent{0.91f, 0.56f, 0.20f, 1.0f};
    const ImVec4 faint{accent.x, accent.y, accent.z, 0.35f};
    ImVec4* colors = style.Colors;
    colors[ImGuiCol_Text] = Gray(0.88f);
    colors[ImGuiCol_TextDisabled] = Gray(0.50f);
    colors[ImGuiCol_WindowBg] = Gray(0.125f);
    colors[ImGuiCol_ChildBg] = Gray(0.125f);
    colors[ImGuiCol_PopupBg] = Gray(0.15f, 0.98f);
    colors[ImGuiCol_MenuBarBg] = Gray(0.10f);
    colors[ImGuiCol_Border] = Gray(0.06f);
    colors[ImGuiCol_FrameBg] = Gray(0.19f);
    colors[ImGuiCol_FrameBgHovered] = Gray(0.24f);
    colors[ImGuiCol_FrameBgActive] = Gray(0.28f);
    colors[ImGuiCol_TitleBg] = colors[ImGuiCol_TitleBgActive] = Gray(0.10f);
    colors[ImGuiCol_Header] = Gray(0.22f);
    colors[ImGuiCol_HeaderHovered] = Gray(0.27f);
    colors[ImGuiCol_HeaderActive] = faint;
    colors[ImGuiCol_Button] = Gray(0.22f);
    colors[ImGuiCol_ButtonHovered] = Gray(0.28f);
    colors[ImGuiCol_ButtonActive] = faint;
    colors[ImGuiCol_CheckMark] = colors[ImGuiCol_SliderGrab] = colors[ImGuiCol_SliderGrabActive] = accent;
    colors[ImGuiCol_PlotLines] = colors[ImGuiCol_PlotHistogram] = accent;
    colors[ImGuiCol_Tab] = Gray(0.14f);
    colors[ImGuiCol_TabHovered] = Gray(0.27f);
    colors[ImGuiCol_TabActive] = Gray(0.22f);
    colors[ImGuiCol_ModalWindowDimBg] = Gray(0.0f, 0.55f);
    colors[ImGuiCol_Separator] = Gray(0.22f);
    colors[ImGuiCol_TextSelectedBg] = faint;
}

void FeedKeys(ImGuiIO& io, const FrameInput& input) {
#if IMGUI_VERSION_NUM >= 18700
    for (const KeyPair& pair : kKeyPairs) io.AddKeyEvent(pair.to, input.IsDown(pair.from));
#else
    for (const KeyPair& pair : kKeyPairs) {
        io.KeyMap[pair.to] = static_cast<int>(pair.from);
        io.KeysDown[static_cast<int>(pair.from)] = input.IsDown(pair.from);
    }
#endif
}

}  // namespace raygraph::editor
