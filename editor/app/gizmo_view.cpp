#include "editor/app/gizmo_view.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "editor/app/actions.h"
#include "renderer/scene/geometry/transforms.h"

namespace raygraph::editor {

namespace {

constexpr float kReach = 6.0f;  // points: distance at which a line is hit
constexpr ImU32 kAxisColors[] = {IM_COL32(230, 70, 80, 255), IM_COL32(120, 190, 50, 255),
                                 IM_COL32(70, 130, 240, 255), IM_COL32(215, 215, 220, 255)};
constexpr ImU32 kHot = IM_COL32(255, 190, 60, 255);
constexpr ImU32 kChosen =
    IM_COL32(150, 88, 28, 255);  // color of the chosen button, readable over any picture
constexpr ImU32 kShadow = IM_COL32(0, 0, 0, 110);

bool IsEmpty(glm::vec2 size) {
    return !(size.x > 0.0f && size.y > 0.0f);
}

void DrawTip(ImDrawList& list, GizmoTool tool, ImVec2 from, ImVec2 to, ImU32 color) {
    if (tool == GizmoTool::Scale) {
        list.AddRectFilled({to.x - 4.5f, to.y - 4.5f}, {to.x + 4.5f, to.y + 4.5f}, color);
        return;
    }
    const glm::vec2 way(to.x - from.x, to.y - from.y);
    const float length = glm::length(way);
    if (length < 1.0f) return;
    const glm::vec2 along = way / length, across(-along.y, along.x);
    const auto at = [&](float ahead, float aside) {
        const glm::vec2 place = glm::vec2(to.x, to.y) + ahead * along + aside * across;
        return ImVec2(place.x, place.y);
    };
    list.AddTriangleFilled(at(9.0f, 0.0f), at(-3.0f, 5.0f), at(-3.0f, -5.0f), color);
}

void DrawShape(ImDrawList& list, const GizmoShape& shape, GizmoTool tool, ImVec2 corner, bool isHot) {
    std::vector<ImVec2> places;
    glm::vec2 last(1e9f);
    for (const glm::vec2& place : shape.places) {
        // A ring seen edge-on turns back on itself: segments of length 0 would have spikes there
        if (!shape.isArea && glm::length(place - last) < 1.0f) continue;
        last = place;
        places.emplace_back(corner.x + place.x, corner.y + place.y);
    }
    if (places.size() < 2) return;
    const ImU32 color = isHot ? kHot : kAxisColors[AxisOf(shape.handle)];
    const auto count = static_cast<int>(places.size());
    if (shape.isArea) {
        const ImU32 faint = (color & 0x00FFFFFFu) | (isHot ? 0xA0000000u : 0x60000000u);
        list.AddConvexPolyFilled(places.data(), count, faint);
        list.AddPolyline(places.data(), count, color, ImDrawFlags_Closed, 1.0f);
        return;
    }
    const float width = tool == GizmoTool::Rotate ? 2.0f : 2.5f;
    list.AddPolyline(places.data(), count, kShadow, 0, width + 2.0f);
    list.AddPolyline(places.data(), count, color, 0, width);
    if (tool != GizmoTool::Rotate) DrawTip(list, tool, places.front(), places.back(), color);
}

// Returns the node that gives the handles their axes: the active one, unless joints place it.
std::optional<uint32_t> FrameNode(const Workspace& work) {
    for (auto node = work.selectedNodes.rbegin(); node != work.selectedNodes.rend(); ++node)
        if (!work.document.IsPlacedBySkin(*node)) return *node;
    return std::nullopt;
}

}  // namespace

// Returns the frame of the selection; nothing if joints place it, or if two views are side by side.
std::optional<GizmoFrame> GizmoView::FrameOfSelection(const Workspace& work, const PictureMap& map) const {
    const std::optional<uint32_t> node = FrameNode(work);
    if (!node || work.view.Show().view == viewport::View::SideBySide) return std::nullopt;
    const glm::mat4x3& nodeToWorld = work.document.WorldTransform(*node);
    std::optional<glm::vec3> pivot;
    if (m_drag && m_drag->selection == work.selectedNodes)
        // A rotation may move the middle of the bounds, so the drag keeps its pivot
        pivot = nodeToWorld * glm::vec4(m_drag->pivot, 1.0f);
    else if (work.pivot == GizmoPivot::Middle)
        pivot = work.SelectionBounds().Center();
    return FrameOf(nodeToWorld, work.tool, work.toolSpace, map, pivot);
}

bool GizmoView::Cancel(Workspace& work) {
    if (!m_drag) return false;
    if (work.document.EditCount() > m_drag->editsBefore) work.Undo();
    m_drag.reset();
    return true;
}

void GizmoView::Update(Workspace& work, const FrameInput& input, glm::vec2 mouse, glm::vec2 size,
                       bool mayTake) {
    m_over.reset();
    if (m_drag && (work.selectedNodes != m_drag->selection || !input.IsDown(MouseButton::Left))) {
        work.document.Settle();
        m_drag.reset();
    }
    if (IsEmpty(size)) return;
    const PictureMap map(work.camera.View(), size);
    if (m_drag) {
        m_over = m_drag->drag.Handle();
        const glm::mat4 change = m_drag->drag.Change(map.RayAt(mouse), input.isControl);
        std::vector<Edit> edits;
        bool isEdit = false;
        for (const Dragged& dragged : m_drag->nodes) {
            std::optional<glm::mat4x3> local = ApplyToLocal(change, dragged.parentToWorld, dragged.local);
            if (!local) return;
            local = WithoutRounding(m_drag->tool, dragged.isAboutOrigin, dragged.local, *local);
            isEdit |= *local != work.document.LocalTransform(dragged.node);
            edits.push_back(TransformEdit{dragged.node, *local});
        }
        if (isEdit) work.Apply(edits);
        return;
    }
    if (!mayTake) return;
    const std::optional<GizmoFrame> frame = FrameOfSelection(work, map);
    if (!frame) return;
    m_over = HandleAt(ShapesOf(*frame, work.tool, map), mouse, kReach);
    if (!m_over || !input.IsDown(MouseButton::Left)) return;
    const std::optional<scene::PlacedTransform> solid =
        scene::WithThickness({work.document.WorldTransform(*FrameNode(work))}, {});
    if (!solid) return;
    const glm::mat4 nodeToWorld(solid->matrix);
    work.document.Settle();
    m_drag = Held{.drag = GizmoDrag(work.tool, *m_over, *frame, map, map.RayAt(mouse)),
                  .selection = work.selectedNodes,
                  .nodes = {},
                  .pivot = glm::vec3(glm::inverse(nodeToWorld) * glm::vec4(frame->origin, 1.0f)),
                  .tool = work.tool,
                  .editsBefore = work.document.EditCount()};
    for (const uint32_t node : work.document.Tops(work.selectedNodes))
        if (!work.document.IsPlacedBySkin(node))
            m_drag->nodes.push_back(
                {.node = node,
                 .parentToWorld = work.document.ParentTransform(node),
                 .local = work.document.LocalTransform(node),
                 .isAboutOrigin = frame->origin == work.document.WorldTransform(node)[3]});
}

void GizmoView::Draw(const Workspace& work, ImVec2 corner, glm::vec2 size) const {
    if (IsEmpty(size)) return;
    const PictureMap map(work.camera.View(), size);
    const std::optional<GizmoFrame> frame = FrameOfSelection(work, map);
    if (!frame) return;
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.PushClipRect(corner, {corner.x + size.x, corner.y + size.y}, true);
    for (const GizmoShape& shape : ShapesOf(*frame, work.tool, map)) {
        if (m_drag && shape.handle != m_drag->drag.Handle()) continue;
        DrawShape(list, shape, work.tool, corner, m_over == shape.handle);
    }
    list.PopClipRect();
}

void GizmoButtons(Workspace& work) {
    const auto button = [&](const char* label, Action action) {
        const std::string keys = work.keys.TextOf(action);
        return ImGui::Button((label + (keys.empty() ? "" : " (" + keys + ")")).c_str());
    };
    constexpr std::pair<GizmoTool, Action> kTools[] = {{GizmoTool::Move, Action::Move},
                                                       {GizmoTool::Rotate, Action::Rotate},
                                                       {GizmoTool::Scale, Action::Scale}};
    for (const auto& [tool, action] : kTools) {
        const bool isOn = work.tool == tool;
        if (isOn) ImGui::PushStyleColor(ImGuiCol_Button, kChosen);
        if (button(Row(action).label, action)) work.tool = tool;
        if (isOn) ImGui::PopStyleColor();
        ImGui::SameLine();
    }
    if (button(work.toolSpace == GizmoSpace::World ? "World" : "Local", Action::Space))
        work.toolSpace = work.toolSpace == GizmoSpace::World ? GizmoSpace::Local : GizmoSpace::World;
    ImGui::SameLine();
    if (button(work.pivot == GizmoPivot::Middle ? "Middle" : "Origin", Action::Pivot))
        work.pivot = work.pivot == GizmoPivot::Middle ? GizmoPivot::Origin : GizmoPivot::Middle;
}

}  // namespace raygraph::editor
