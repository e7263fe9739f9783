// Draws the hierarchy: a row for each node that is open or found, with its icon and an eye.
#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "editor/app/actions.h"
#include "editor/app/hierarchy.h"
#include "editor/app/node_icons.h"
#include "editor/app/panels.h"

namespace raygraph::editor {

namespace {

constexpr float kIndent = 14.0f, kSymbol = 18.0f, kEye = 22.0f;  // points: widths of a row's parts
constexpr float kMostIndent = 0.5f;                              // of the panel's width

float RowHeight() {
    return ImGui::GetTextLineHeight() + 5.0f;
}

// Draws a field in place of the row's name. Enter or a click elsewhere gives the node that name, Escape none.
void NameField(Workspace& work, float width) {
    NameDraft& draft = *work.nameDraft;
    if (std::exchange(draft.isNew, false)) ImGui::SetKeyboardFocusHere();
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding,
                        {2.0f, 0.5f * (RowHeight() - ImGui::GetTextLineHeight())});
    ImGui::SetNextItemWidth(width);
    ImGui::InputText("##name", draft.text.data(), draft.text.size(), ImGuiInputTextFlags_AutoSelectAll);
    ImGui::PopStyleVar();
    if (!ImGui::IsItemDeactivated()) return;
    const NameDraft taken = *std::exchange(work.nameDraft, std::nullopt);
    if (taken.text != taken.initial) work.Rename(taken.node, taken.text.data());
}

void NodeMenu(Workspace& work, uint32_t node) {
    if (!ImGui::BeginPopupContextItem()) return;
    if (!work.IsSelected(node)) work.Select(node);
    const auto item = [&](Action action) {
        return ImGui::MenuItem(Row(action).label, MenuKey(work.keys.TextOf(action)).c_str());
    };
    if (item(Action::Frame)) work.FrameSelection();
    if (item(Action::Hide)) work.ToggleVisibility();
    ImGui::Separator();
    if (item(Action::Rename)) work.StartRename();
    if (item(Action::Duplicate)) work.DuplicateSelection();
    if (work.document.Scene().nodes[node].parent != scene::kNone && ImGui::MenuItem("Make a root"))
        work.Reparent(node, std::nullopt);
    if (item(Action::Delete)) work.DeleteSelection();
    ImGui::EndPopup();
}

constexpr const char* kNodePayload = "node";

void DragSource(const Workspace& work, uint32_t node) {
    if (!ImGui::BeginDragDropSource()) return;
    ImGui::SetDragDropPayload(kNodePayload, &node, sizeof(node));
    const size_t count = work.IsSelected(node) ? work.selectedNodes.size() : 1;
    ImGui::TextUnformatted((count > 1 ? Text("{} nodes", count) : work.document.NameOf(node)).c_str());
    ImGui::EndDragDropSource();
}

// Moves a row that is dropped on the last item below `parent`; nullopt: to the top of the hierarchy.
void DropTarget(Workspace& work, std::optional<uint32_t> parent) {
    if (!ImGui::BeginDragDropTarget()) return;
    if (const ImGuiPayload* const payload = ImGui::AcceptDragDropPayload(kNodePayload))
        work.Reparent(*static_cast<const uint32_t*>(payload->Data), parent);
    ImGui::EndDragDropTarget();
}

// Selects by a press on the row, the last item. A press on one of several selected rows may begin a drag of
// them all: it selects that row alone once the button is released where it was pressed.
void ClickRow(Workspace& work, uint32_t node) {
    const ImGuiIO& io = ImGui::GetIO();
    if (ImGui::IsItemClicked()) {
        work.pressedRow.reset();
        if (io.KeyShift)
            work.SelectRange(node, io.KeyCtrl);
        else if (io.KeyCtrl)
            work.ToggleSelected(node);
        else if (!work.IsSelected(node))
            work.Select(node);
        else if (work.selectedNodes.size() > 1)
            work.pressedRow = node;
        if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left) && !io.KeyShift && !io.KeyCtrl)
            work.FrameSelection();
    }
    if (ImGui::IsItemDeactivated() && work.pressedRow == node) {
        work.pressedRow.reset();
        if (!ImGui::IsMouseDragPastThreshold(ImGuiMouseButton_Left)) work.Select(node);
    }
}

void DrawRow(const Workspace& work, uint32_t node, ImVec2 corner, float left, float right, bool isHovered) {
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const float height = RowHeight(), middle = corner.y + 0.5f * height;
    const auto fill = [&](ImGuiCol color, float strength) {
        list.AddRectFilled(corner, {right, corner.y + height}, ImGui::GetColorU32(color, strength));
    };
    if (work.IsSelected(node))
        fill(ImGuiCol_HeaderActive, work.selectedNode == node ? 1.0f : 0.5f);
    else if (isHovered)
        fill(ImGuiCol_HeaderHovered, 0.5f);
    const ImU32 color =
        ImGui::GetColorU32(work.document.IsVisible(node) ? ImGuiCol_Text : ImGuiCol_TextDisabled);
    const float top = corner.y + 0.5f * (height - ImGui::GetFontSize());
    if (work.hierarchy.HasRowsBelow(node))
        ImGui::RenderArrow(&list, {left, top}, color,
                           work.hierarchy.IsOpen(node) ? ImGuiDir_Down : ImGuiDir_Right, 0.8f);
    DrawNodeIcon(list, work.document.KindOf(node), {left + 1.5f * kSymbol, middle}, color);
    if (work.nameDraft && work.nameDraft->node == node) return;
    const std::string name = work.document.NameOf(node);
    const ImVec2 size = ImGui::CalcTextSize(name.c_str());
    const float from = left + 2.0f * kSymbol + 2.0f, to = right - kEye;
    if (to <= from) return;
    ImGui::PushStyleColor(ImGuiCol_Text, color);
    ImGui::RenderTextEllipsis(&list, {from, top}, {to, corner.y + height}, to, to, name.c_str(),
                              name.c_str() + name.size(), &size);
    ImGui::PopStyleColor();
}

// Draws the eye at the end of the row; a click hides the node, or shows it.
void Eye(Workspace& work, uint32_t node, ImVec2 corner) {
    ImGui::SetCursorScreenPos(corner);
    const bool isClicked = ImGui::InvisibleButton("eye", {kEye, RowHeight()});
    const bool isVisible = work.document.Scene().nodes[node].isVisible;
    const ImU32 color = ImGui::GetColorU32(ImGui::IsItemHovered() ? ImGuiCol_Text : ImGuiCol_TextDisabled);
    DrawEye(*ImGui::GetWindowDrawList(), isVisible, {corner.x + 0.5f * kEye, corner.y + 0.5f * RowHeight()},
            color);
    if (!isClicked) return;
    work.Apply(VisibilityEdit{node, !isVisible});
    work.document.Settle();
}

void NodeRow(Workspace& work, const Hierarchy::Row& row) {
    const uint32_t node = row.node;
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x, right = corner.x + width;
    const float left = corner.x + std::min(kIndent * static_cast<float>(row.depth), kMostIndent * width);
    ImGui::PushID(static_cast<int>(node));
    if (work.nameDraft && work.nameDraft->node == node) {
        DrawRow(work, node, corner, left, right, false);
        const float from = left + 2.0f * kSymbol;
        ImGui::SetCursorScreenPos({from, corner.y});
        NameField(work, std::max(right - kEye - from, 1.0f));
    } else {
        ImGui::InvisibleButton("row", {std::max(width - kEye, 1.0f), RowHeight()});
        DrawRow(work, node, corner, left, right, ImGui::IsItemHovered());
        const float x = ImGui::GetIO().MousePos.x;
        if (work.hierarchy.HasRowsBelow(node) && x >= left && x < left + kSymbol) {
            if (ImGui::IsItemClicked()) work.hierarchy.SetOpen(node, !work.hierarchy.IsOpen(node));
        } else {
            ClickRow(work, node);
        }
        DragSource(work, node);
        DropTarget(work, node);
        NodeMenu(work, node);
    }
    Eye(work, node, {right - kEye, corner.y});
    ImGui::PopID();
}

// Chooses which variant is shown, if the scene has some.
void VariantField(Workspace& work) {
    const scene::SceneData& scene = work.document.Scene();
    if (scene.variants.empty()) return;
    const auto label = [&](uint32_t variant) {
        if (variant == scene::kNone) return std::string("no variant");
        return scene.variants[variant].empty() ? Text("variant {}", variant) : scene.variants[variant];
    };
    ImGui::SetNextItemWidth(-1.0f);
    if (!ImGui::BeginCombo("##variant", label(scene.variant).c_str())) return;
    const auto choice = [&](uint32_t variant) {
        ImGui::PushID(static_cast<int>(variant));  // names may be equal
        if (ImGui::Selectable(label(variant).c_str(), variant == scene.variant)) work.ShowVariant(variant);
        ImGui::PopID();
    };
    choice(scene::kNone);
    for (uint32_t variant = 0; variant < scene.variants.size(); ++variant) choice(variant);
    ImGui::EndCombo();
}

void ShowAllRows(Workspace& work) {
    work.FilterHierarchy("");
    work.nodeToReveal = work.selectedNode;
}

// Finds nodes by a part of their names; Escape ends that.
void SearchField(Workspace& work) {
    std::array<char, 256> text{};
    const std::string& before = work.HierarchyFilter();
    std::copy_n(before.begin(), std::min(before.size(), text.size() - 1), text.begin());
    ImGui::SetNextItemWidth(-1.0f);
    if (ImGui::InputTextWithHint("##search", "search by name", text.data(), text.size()))
        work.FilterHierarchy(text.data());
    if (ImGui::IsItemDeactivated() && ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape)))
        ShowAllRows(work);
}

}  // namespace

void HierarchyPanel(Workspace& work) {
    work.isHierarchyFocused = ImGui::IsWindowFocused(ImGuiFocusedFlags_ChildWindows);
    if (work.document.File().empty()) {
        ImGui::TextDisabled("No scene is open.");
        ImGui::TextWrapped("Drop a .gltf or .glb file here, or use File > Open.");
        return;
    }
    VariantField(work);
    SearchField(work);
    ImGui::BeginChild("nodes");
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {0.0f, 0.0f});
    const float height = RowHeight();
    if (work.nodeToReveal) {
        const size_t row = work.hierarchy.Reveal(*std::exchange(work.nodeToReveal, std::nullopt));
        const float place = static_cast<float>(row) * height, shown = ImGui::GetWindowHeight();
        if (row < work.hierarchy.Rows().size() &&
            (place < ImGui::GetScrollY() || place + height > ImGui::GetScrollY() + shown))
            ImGui::SetScrollY(std::max(place - 0.5f * shown, 0.0f));
    }
    // Opening a row changes the list from the next frame on
    const std::vector<Hierarchy::Row>& rows = work.hierarchy.Rows();
    if (rows.empty() && work.hierarchy.IsFiltered()) ImGui::TextDisabled("no name has this");
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(rows.size()), height);
    while (clipper.Step())
        for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i)
            NodeRow(work, rows[static_cast<size_t>(i)]);
    // The place below the rows stands for the top of the hierarchy
    const ImVec2 rest = ImGui::GetContentRegionAvail();
    ImGui::InvisibleButton("top",
                           {std::max(rest.x, 1.0f), std::max(rest.y, 1.5f * ImGui::GetTextLineHeight())});
    DropTarget(work, std::nullopt);
    ImGui::PopStyleVar();
    ImGui::EndChild();
}

bool HierarchyKey(Workspace& work, const KeyPress& press) {
    if (!work.isHierarchyFocused || press.isControl) return false;
    if (press.key == Key::Escape && !work.HierarchyFilter().empty()) {
        ShowAllRows(work);
        return true;
    }
    Hierarchy& hierarchy = work.hierarchy;
    const std::vector<Hierarchy::Row>& rows = hierarchy.Rows();
    const auto active =
        std::ranges::find_if(rows, [&](const Hierarchy::Row& row) { return row.node == work.selectedNode; });
    const bool isActive = active != rows.end();
    if (rows.empty() || (!isActive && (press.key == Key::Left || press.key == Key::Right))) return false;
    uint32_t to = 0;
    switch (press.key) {
        case Key::Up:
            to = isActive ? (active - (active != rows.begin()))->node : rows.back().node;
            break;
        case Key::Down:
            to = isActive && active + 1 != rows.end() ? (active + 1)->node
                 : isActive                           ? active->node
                                                      : rows.front().node;
            break;
        case Key::Home:
            to = rows.front().node;
            break;
        case Key::End:
            to = rows.back().node;
            break;
        case Key::Left:
            if (hierarchy.HasRowsBelow(active->node) && hierarchy.IsOpen(active->node) &&
                !hierarchy.IsFiltered()) {
                hierarchy.SetOpen(active->node, false);
                return true;
            }
            to = hierarchy.Parent(active->node).value_or(active->node);
            break;
        case Key::Right:
            if (!hierarchy.HasRowsBelow(active->node)) return true;
            if (!hierarchy.IsOpen(active->node)) {
                hierarchy.SetOpen(active->node, true);
                return true;
            }
            to = (active + 1)->node;
            break;
        default:
            return false;
    }
    if (press.isShift)
        work.SelectRange(to, false);
    else
        work.Select(to);
    work.nodeToReveal = to;
    return true;
}

}  // namespace raygraph::editor
