#include "editor/app/path_dialog.h"

#include <imgui.h>

#include <system_error>
#include <utility>

namespace raygraph::editor {

void PathDialog::Ask(std::string title, std::string hint, For purpose,
                     const std::filesystem::path& suggestion,
                     std::function<void(const std::filesystem::path&)> use) {
    m_title = std::move(title);
    m_hint = std::move(hint);
    m_purpose = purpose;
    m_use = std::move(use);
    m_isAsked = true;
    const std::string text = suggestion.string();
    m_path[text.copy(m_path, sizeof m_path - 1)] = '\0';
}

void PathDialog::Draw() {
    if (m_title.empty()) return;
    if (std::exchange(m_isAsked, false)) ImGui::OpenPopup(m_title.c_str());
    if (!ImGui::BeginPopupModal(m_title.c_str(), nullptr, ImGuiWindowFlags_AlwaysAutoResize)) return;
    ImGui::TextUnformatted(m_hint.c_str());
    ImGui::SetNextItemWidth(480.0f);
    if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
    const bool isEntered =
        ImGui::InputText("##path", m_path, sizeof m_path, ImGuiInputTextFlags_EnterReturnsTrue);
    std::error_code error;
    const bool isThere = m_path[0] != '\0' && std::filesystem::exists(m_path, error);
    if (m_purpose == For::Writing)
        ImGui::TextDisabled("%s", isThere ? "It is there already, and is replaced." : "");
    const bool isConfirmed = ImGui::Button(m_purpose == For::Reading ? "Open" : "Save");
    ImGui::SameLine();
    const bool isCancelled =
        ImGui::Button("Cancel") || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape));
    if ((isConfirmed || isEntered) && m_path[0] != '\0') {
        ImGui::CloseCurrentPopup();
        m_use(m_path);
    } else if (isCancelled) {
        ImGui::CloseCurrentPopup();
    }
    ImGui::EndPopup();
}

}  // namespace raygraph::editor
