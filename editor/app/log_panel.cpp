// Lists the newest messages of the program, filtered by level, category and text.
#include <imgui.h>

#include <algorithm>
#include <array>
#include <vector>

#include "editor/app/log_history.h"
#include "editor/app/panels.h"

namespace raygraph::editor {

namespace {

ImVec4 ColorOf(LogLevel level) {
    switch (level) {
        case LogLevel::Error:
            return {0.94f, 0.39f, 0.36f, 1.0f};
        case LogLevel::Warning:
            return {0.91f, 0.70f, 0.28f, 1.0f};
        case LogLevel::Info:
            return {0.55f, 0.72f, 0.88f, 1.0f};
        default:
            return {0.50f, 0.50f, 0.52f, 1.0f};
    }
}

// Chooses the level: messages of this level and of more severe ones are shown.
void LevelChoice(LogFilter& filter) {
    ImGui::SetNextItemWidth(96.0f);
    if (!ImGui::BeginCombo("##level", Name(filter.minLevel))) return;
    for (int i = 0; i < static_cast<int>(LogLevel::Off); ++i) {
        const auto level = static_cast<LogLevel>(i);
        if (ImGui::Selectable(Name(level), level == filter.minLevel)) filter.minLevel = level;
    }
    ImGui::EndCombo();
}

void CategoryChoice(LogFilter& filter) {
    ImGui::SetNextItemWidth(118.0f);
    if (!ImGui::BeginCombo("##category", filter.category.empty() ? "all" : filter.category.c_str())) return;
    if (ImGui::Selectable("all", filter.category.empty())) filter.category.clear();
    for (const std::string_view category : kLogCategories) {
        const std::string name(category);
        if (ImGui::Selectable(name.c_str(), name == filter.category)) filter.category = name;
    }
    ImGui::EndCombo();
}

void TextField(LogFilter& filter, float width) {
    std::array<char, 128> text{};
    filter.text.copy(text.data(), text.size() - 1);
    ImGui::SetNextItemWidth(width);
    if (ImGui::InputTextWithHint("##text", "text", text.data(), text.size())) filter.text = text.data();
}

void Rows(const std::vector<const LogEntry*>& shown, bool isNew) {
    constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg;
    if (!ImGui::BeginTable("messages", 4, kFlags)) return;
    ImGui::TableSetupColumn("time", ImGuiTableColumnFlags_WidthFixed, 60.0f);
    ImGui::TableSetupColumn("level", ImGuiTableColumnFlags_WidthFixed, 56.0f);
    ImGui::TableSetupColumn("category", ImGuiTableColumnFlags_WidthFixed, 72.0f);
    ImGui::TableSetupColumn("text", ImGuiTableColumnFlags_WidthStretch);
    // Keep the position of a user who has scrolled up
    const bool wasAtEnd = ImGui::GetScrollY() >= ImGui::GetScrollMaxY();
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(shown.size()));
    while (clipper.Step())
        for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
            const LogEntry& entry = *shown[static_cast<size_t>(i)];
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            ImGui::TextDisabled("%s", entry.time.c_str());
            ImGui::TableNextColumn();
            ImGui::TextColored(ColorOf(entry.level), "%s", Name(entry.level));
            ImGui::TableNextColumn();
            ImGui::TextDisabled("%s", entry.category.c_str());
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(entry.text.c_str());
            if (!ImGui::IsItemHovered() ||
                ImGui::CalcTextSize(entry.text.c_str()).x < ImGui::GetContentRegionAvail().x)
                continue;
            ImGui::BeginTooltip();
            ImGui::PushTextWrapPos(640.0f);
            ImGui::TextUnformatted(entry.text.c_str());
            ImGui::PopTextWrapPos();
            ImGui::EndTooltip();
        }
    if (wasAtEnd && isNew) ImGui::SetScrollHereY(1.0f);
    ImGui::EndTable();
}

}  // namespace

void LogPanel(Workspace& work) {
    LogFilter& filter = work.logFilter;
    LevelChoice(filter);
    ImGui::SameLine();
    CategoryChoice(filter);
    ImGui::SameLine();
    // Align the buttons with the right edge
    const float gap = ImGui::GetStyle().ItemSpacing.x, padding = 2.0f * ImGui::GetStyle().FramePadding.x;
    const float buttons =
        ImGui::CalcTextSize("Copy").x + ImGui::CalcTextSize("Clear").x + 2.0f * padding + gap;
    TextField(filter, std::max(ImGui::GetContentRegionAvail().x - buttons - gap, 60.0f));
    ImGui::SameLine();
    if (ImGui::Button("Copy")) ImGui::SetClipboardText(work.log->Text(filter).c_str());
    ImGui::SameLine();
    if (ImGui::Button("Clear")) work.log->Clear();
    const uint64_t revision = work.log->Revision();
    work.log->Read([&](const std::deque<LogEntry>& entries) {
        std::vector<const LogEntry*> shown;
        for (const LogEntry& entry : entries)
            if (filter.Accepts(entry)) shown.push_back(&entry);
        Rows(shown, revision != work.shownLogRevision);
    });
    work.shownLogRevision = revision;
}

}  // namespace raygraph::editor
