#include "editor/app/unsaved_dialog.h"

#include <imgui.h>
#include <algorithm>
#include <optional>
#include <utility>

namespace raygraph::editor {

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
