#include "editor/app/dialogs.h"

#include <imgui.h>
#include <algorithm>
#include <optional>
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
    m_isRequested = true;
    const std::string text = suggestion.string();
    m_path[text.copy(m_path, sizeof m_path - 1)] = '\0';
}

void PathDialog::Draw() {
    if (m_title.empty()) return;
    if (std::exchange(m_isRequested, false)) ImGui::OpenPopup(m_title.c_str());
    if (!ImGui::BeginPopupModal(m_title.c_str(), nullptr, ImGuiWindowFlags_AlwaysAutoResize)) return;
    ImGui::TextUnformatted(m_hint.c_str());
    ImGui::SetNextItemWidth(480.0f);
    if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
    const bool isEntered =
        ImGui::InputText("##path", m_path, sizeof m_path, ImGuiInputTextFlags_EnterReturnsTrue);
    std::error_code error;
    const bool exists = m_path[0] != '\0' && std::filesystem::exists(m_path, error);
    if (m_purpose == For::Writing)
        ImGui::TextDisabled("%s", exists ? "It is there already, and is replaced." : "");
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

void UnsavedDialog::Ask(std::string question, std::function<void(Answer)> use) {
    m_question = std::move(question);
    m_use = std::move(use);
    m_isNew = true;
}

void UnsavedDialog::Draw(const FrameInput& input) {
    constexpr const char* kTitle = "Unsaved edits";
    if (!IsPrompting()) return;
    const bool isNew = std::exchange(m_isNew, false);
    // Reopen the popup if another dialog has closed it
    if (!ImGui::IsPopupOpen(kTitle)) ImGui::OpenPopup(kTitle);
    if (!ImGui::BeginPopupModal(kTitle, nullptr, ImGuiWindowFlags_AlwaysAutoResize)) return;
    ImGui::TextUnformatted(m_question.c_str());
    // Keys of the frame in which the question was asked are not the answer
    const auto isPressed = [&](Key key) { return !isNew && std::ranges::count(input.pressed, key) > 0; };
    std::optional<Answer> answer;
    if (ImGui::Button("Save (S)") || isPressed(Key::S)) answer = Answer::Save;
    ImGui::SameLine();
    if (ImGui::Button("Discard (D)") || isPressed(Key::D)) answer = Answer::Discard;
    ImGui::SameLine();
    if (ImGui::Button("Cancel (Esc)") || isPressed(Key::Escape)) answer = Answer::Cancel;
    if (answer) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
    // `m_use` may ask again, so it is taken out first
    if (answer) std::exchange(m_use, nullptr)(*answer);
}

}  // namespace raygraph::editor
