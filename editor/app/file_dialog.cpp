#include "editor/app/file_dialog.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <optional>
#include <system_error>
#include <utility>

#include "base/files.h"
#include "base/text.h"

namespace raygraph::editor {

namespace fs = std::filesystem;

namespace {

const ImVec2 kListSize{620.0f, 260.0f};  // points

std::string Lower(std::string text) {
    std::ranges::transform(text, text.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

std::string SizeText(uintmax_t bytes) {
    if (bytes < 1024) return Text("{} B", bytes);
    const auto kib = static_cast<double>(bytes) / 1024.0;
    return kib < 1024.0 ? Text("{:.0f} KiB", kib) : Text("{:.1f} MiB", kib / 1024.0);
}

// Completes the path of an ImGui text field when Tab is pressed.
int Complete(ImGuiInputTextCallbackData* field) {
    const std::string text(field->Buf, static_cast<size_t>(field->BufTextLen));
    const std::string folder = *static_cast<const std::string*>(field->UserData);
    const bool isRelative = !text.starts_with('/') && !text.starts_with('~');
    const std::string completed =
        isRelative ? CompletedPath(folder + "/" + text).substr(folder.size() + 1) : CompletedPath(text);
    if (completed == text) return 0;
    field->DeleteChars(0, field->BufTextLen);
    field->InsertChars(0, completed.c_str());
    return 0;
}

}  // namespace

std::vector<FolderEntry> ListFolder(const fs::path& folder, std::span<const std::string_view> extensions) {
    std::vector<FolderEntry> entries;
    std::error_code error;
    fs::directory_iterator end, each(folder, fs::directory_options::skip_permission_denied, error);
    for (; !error && each != end; each.increment(error)) {
        std::error_code ignored;
        FolderEntry entry{each->path().filename().string(), each->is_directory(ignored)};
        if (entry.name.starts_with('.')) continue;
        const std::string extension = LowerExtension(each->path());
        if (!entry.isFolder && !extensions.empty() && std::ranges::count(extensions, extension) == 0)
            continue;
        if (!entry.isFolder) {
            entry.bytes = each->file_size(ignored);
            if (ignored) entry.bytes = 0;
        }
        entries.push_back(std::move(entry));
    }
    std::ranges::sort(entries, [](const FolderEntry& a, const FolderEntry& b) {
        return std::pair(!a.isFolder, Lower(a.name)) < std::pair(!b.isFolder, Lower(b.name));
    });
    return entries;
}

fs::path ExpandHome(std::string_view text) {
    const char* home = std::getenv("HOME");
    if (!home || !text.starts_with('~') || (text.size() > 1 && text[1] != '/')) return text;
    return home + std::string(text.substr(1));
}

std::string CompletedPath(std::string_view text) {
    const size_t slash = text.rfind('/');
    const std::string_view folder = slash == text.npos ? "" : text.substr(0, slash + 1);
    const std::string_view start = text.substr(folder.size());
    std::optional<std::string> common;
    for (const FolderEntry& entry : ListFolder(folder.empty() ? fs::path(".") : ExpandHome(folder), {})) {
        if (!entry.name.starts_with(start)) continue;
        const std::string name = entry.name + (entry.isFolder ? "/" : "");
        if (!common) {
            common = name;
            continue;
        }
        const auto differs = std::ranges::mismatch(*common, name).in1;
        common->erase(differs, common->end());
    }
    return std::string(folder) + (common ? *common : std::string(start));
}

void FileDialog::Ask(FileQuestion question, Use use) {
    m_question = std::move(question);
    m_use = std::move(use);
    m_why.clear();
    m_desktop.reset();
    const fs::path suggestion = m_question.suggestion;
    if (m_allowsDesktop && os::FindProgram("zenity")) {
        StartDesktop(suggestion);
        return;
    }
    m_isRequested = true;
    Enter(suggestion.has_parent_path() ? suggestion.parent_path() : fs::path("."));
    const std::string text = suggestion.filename().string();
    m_path[text.copy(m_path, sizeof m_path - 1)] = '\0';
}

void FileDialog::StartDesktop(const fs::path& suggestion) {
    std::vector<std::string> command{"zenity", "--file-selection", "--title=" + m_question.title,
                                     "--filename=" + suggestion.string()};
    if (m_question.purpose == FileQuestion::For::Writing) {
        command.emplace_back("--save");
        command.emplace_back("--confirm-overwrite");
    }
    std::string patterns;
    for (const std::string_view extension : m_question.extensions) patterns += Text(" *{}", extension);
    command.push_back("--file-filter=" + m_question.hint + " |" + patterns);
    command.emplace_back("--file-filter=All files | *");
    m_desktop = std::make_unique<os::ChildProcess>(command);
}

void FileDialog::Enter(const fs::path& folder) {
    std::error_code error;
    const fs::path whole = fs::weakly_canonical(folder, error);
    m_folder = error ? folder : whole;
    m_entries = ListFolder(m_folder, m_showsAll ? std::vector<std::string_view>() : m_question.extensions);
    m_focusesName = true;
}

void FileDialog::Answer(const fs::path& path) {
    // `use` may ask again, so it is taken out first
    const Use use = std::exchange(m_use, nullptr);
    m_why = use(path);
    if (m_why.empty()) return;
    if (!m_use) m_use = use;
    m_focusesName = true;  // Enter has taken the focus from the field
}

void FileDialog::Draw(std::span<const fs::path> recent) {
    if (!m_use) return;
    if (!m_desktop) {
        DrawList(recent);
        return;
    }
    if (m_desktop->IsRunning()) return;
    std::optional<std::string> answer = std::exchange(m_desktop, nullptr)->Output();
    while (answer && answer->ends_with('\n')) answer->pop_back();
    if (!answer || answer->empty()) {
        m_use = nullptr;  // cancelled
        return;
    }
    Answer(*answer);
    if (m_use && !m_desktop) StartDesktop(*answer);
}

void FileDialog::DrawList(std::span<const fs::path> recent) {
    if (std::exchange(m_isRequested, false)) ImGui::OpenPopup(m_question.title.c_str());
    if (!ImGui::BeginPopupModal(m_question.title.c_str(), nullptr, ImGuiWindowFlags_AlwaysAutoResize)) {
        m_use = nullptr;
        return;
    }
    ImGui::TextUnformatted(m_question.hint.c_str());
    std::optional<fs::path> entered, chosen;
    if (ImGui::Button("Up")) entered = m_folder.parent_path();
    ImGui::SameLine();
    if (ImGui::Button("Home")) entered = ExpandHome("~");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(200.0f);
    if (ImGui::BeginCombo("##recent", "Recent folders")) {
        std::vector<fs::path> folders;
        for (const fs::path& file : recent)
            if (std::ranges::count(folders, file.parent_path()) == 0) folders.push_back(file.parent_path());
        for (const fs::path& folder : folders)
            if (ImGui::Selectable(folder.c_str())) entered = folder;
        ImGui::EndCombo();
    }
    ImGui::SameLine();
    if (ImGui::Checkbox("all files", &m_showsAll)) entered = m_folder;
    ImGui::TextDisabled("%s", m_folder.c_str());
    if (ImGui::BeginTable("files", 2, ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg, kListSize)) {
        ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthStretch);
        ImGui::TableSetupColumn("size", ImGuiTableColumnFlags_WidthFixed);
        for (const FolderEntry& entry : m_entries) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            const std::string label = entry.name + (entry.isFolder ? "/" : "");
            if (ImGui::Selectable(label.c_str(), entry.name == m_path,
                                  ImGuiSelectableFlags_SpanAllColumns |
                                      ImGuiSelectableFlags_AllowDoubleClick |
                                      ImGuiSelectableFlags_DontClosePopups)) {
                if (entry.isFolder) {
                    if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) entered = m_folder / entry.name;
                } else {
                    m_path[entry.name.copy(m_path, sizeof m_path - 1)] = '\0';
                    if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) chosen = m_folder / entry.name;
                }
            }
            ImGui::TableNextColumn();
            ImGui::TextDisabled("%s", entry.isFolder ? "" : SizeText(entry.bytes).c_str());
        }
        ImGui::EndTable();
    }
    ImGui::SetNextItemWidth(kListSize.x);
    if (std::exchange(m_focusesName, false)) ImGui::SetKeyboardFocusHere();
    std::string folder = m_folder.string();
    const bool isEntered =
        ImGui::InputText("##path", m_path, sizeof m_path,
                         ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll |
                             ImGuiInputTextFlags_CallbackCompletion,
                         Complete, &folder);
    const fs::path typed = m_folder / ExpandHome(m_path);
    std::error_code error;
    const bool isFolder = fs::is_directory(typed, error);
    const bool isThere = !isFolder && fs::exists(typed, error);
    const bool isWriting = m_question.purpose == FileQuestion::For::Writing;
    if (!m_why.empty())
        ImGui::TextColored({0.95f, 0.35f, 0.3f, 1.0f}, "%s", m_why.c_str());
    else
        ImGui::TextDisabled("%s", isWriting && isThere ? "It is there already, and is replaced." : "");
    const bool isConfirmed = ImGui::Button(isWriting ? "Save" : "Open");
    ImGui::SameLine();
    const bool isCancelled =
        ImGui::Button("Cancel") || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape));
    if ((isConfirmed || isEntered) && m_path[0] != '\0') {
        if (isFolder) {
            entered = typed;
            m_path[0] = '\0';
        } else {
            chosen = typed;
        }
    }
    if (isCancelled) m_use = nullptr;
    if (entered) Enter(*entered);
    if (chosen) Answer(*chosen);
    // Another question has its own popup
    if (!m_use || m_isRequested) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
}

}  // namespace raygraph::editor
