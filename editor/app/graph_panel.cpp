// Draws the plan of the last frame.
#include <imgui.h>

#include <algorithm>
#include <map>
#include <string>

#include "base/text.h"
#include "editor/app/graph_layout.h"
#include "editor/app/panels.h"
#include "renderer/graph/plan_text.h"

namespace raygraph::editor {

namespace {

constexpr ImU32 kText = IM_COL32(225, 225, 230, 255), kTranslucentText = IM_COL32(128, 128, 134, 255);
constexpr ImU32 kTimeText = IM_COL32(190, 190, 196, 255);
constexpr ImU32 kBarrierRing = IM_COL32(240, 160, 60, 255);
constexpr ImU32 kWhite = IM_COL32(255, 255, 255, 255);

ImU32 ColorOf(PassKind kind) {
    switch (kind) {
        case PassKind::RayTracing:
            return IM_COL32(122, 78, 36, 255);
        case PassKind::Compute:
            return IM_COL32(44, 76, 112, 255);
        case PassKind::Raster:
            return IM_COL32(52, 96, 62, 255);
        case PassKind::Transfer:
            return IM_COL32(84, 84, 92, 255);
        case PassKind::AccelerationStructure:
            return IM_COL32(104, 58, 96, 255);
    }
    return kTranslucentText;
}

ImU32 ColorOf(Origin origin) {
    switch (origin) {
        case Origin::Transient:
            return IM_COL32(110, 150, 200, 255);
        case Origin::Persistent:
            return IM_COL32(200, 170, 90, 255);
        case Origin::Imported:
            return IM_COL32(120, 180, 120, 255);
    }
    return kTranslucentText;
}

ImU32 Translucent(ImU32 color) {
    return (color & 0x00FFFFFFu) | 0x50000000u;
}

// Returns the time of each executed pass by its box; passes of one name are matched in their order.
std::map<uint32_t, double> TimesOf(const FrameGraph& graph, const Plan& plan, const FrameTiming& timing) {
    std::multimap<std::string, double, std::less<>> left;
    for (const PassTiming& pass : timing.passes) left.emplace(pass.name, pass.gpuMs);
    std::map<uint32_t, double> times;
    for (const PlannedPass& planned : plan.passes) {
        const auto found = left.find(graph.passes[planned.pass].name);
        if (found == left.end()) continue;
        times[planned.pass] = found->second;
        left.erase(found);
    }
    return times;
}

// Draws into the current ImGui window.
class Drawing {
  public:
    Drawing(const FrameGraph& graph, const Plan& plan, const FrameTiming& timing, bool withCulled)
        : m_graph(graph),
          m_plan(plan),
          m_layout(LayOut(graph, plan, withCulled)),
          m_times(TimesOf(graph, plan, timing)),
          m_list(*ImGui::GetWindowDrawList()),
          m_origin(ImGui::GetCursorScreenPos()) {}

    void Draw() {
        ImGui::Dummy({m_layout.size.x + 8.0f, m_layout.size.y});
        m_isHovered = ImGui::IsWindowHovered();
        FindHovered();
        for (const GraphLane& lane : m_layout.lanes) DrawLane(lane);
        for (size_t i = 0; i < m_layout.boxes.size(); ++i) DrawBox(i);
        if (m_hoveredMark)
            MarkTooltip();
        else if (m_hoveredBox < m_layout.boxes.size())
            BoxTooltip(m_layout.boxes[m_hoveredBox]);
        else if (m_hoveredLane)
            LaneTooltip(*m_hoveredLane);
    }

  private:
    ImVec2 At(float x, float y) const { return {m_origin.x + x, m_origin.y + y}; }
    bool IsMouseIn(ImVec2 from, ImVec2 to) const {
        return m_isHovered && ImGui::IsMouseHoveringRect(from, to);
    }

    void FindHovered() {
        m_hoveredBox = m_layout.boxes.size();
        for (size_t i = 0; i < m_layout.boxes.size(); ++i) {
            const float x = m_layout.boxes[i].x;
            if (IsMouseIn(At(x, 0.0f), At(x + GraphLayout::kBoxWidth, GraphLayout::kBoxHeight)))
                m_hoveredBox = i;
        }
        for (const GraphLane& lane : m_layout.lanes) {
            const float y = GraphLayout::RowCenter(lane.row), half = 0.5f * GraphLayout::kRowHeight;
            const float from = m_layout.CenterOf(lane.marks.front().box) - 6.0f;
            const float to = m_layout.CenterOf(lane.marks.back().box) + 6.0f;
            const float name =
                static_cast<float>(m_graph.resources[lane.resource].name.size()) * GraphLayout::kLetter +
                14.0f;
            if (IsMouseIn(At(from, y - half), At(std::max(to, from + name), y + half))) m_hoveredLane = &lane;
            for (const GraphMark& mark : lane.marks) {
                const float x = m_layout.CenterOf(mark.box);
                if (IsMouseIn(At(x - 7.0f, y - half), At(x + 7.0f, y + half))) m_hoveredMark = &mark;
            }
        }
    }

    bool IsUsedBy(const GraphLane& lane, size_t box) const {
        return std::ranges::any_of(lane.marks, [&](const GraphMark& mark) { return mark.box == box; });
    }

    void DrawLane(const GraphLane& lane) {
        const GraphResource& resource = m_graph.resources[lane.resource];
        const bool isBoxHovered = m_hoveredBox < m_layout.boxes.size();
        const bool isDim = (isBoxHovered && !IsUsedBy(lane, m_hoveredBox)) ||
                           (m_hoveredLane && !isBoxHovered && m_hoveredLane != &lane);
        const bool isUsed = std::ranges::any_of(
            lane.marks, [&](const GraphMark& mark) { return !m_layout.boxes[mark.box].isCulled; });
        ImU32 color = ColorOf(resource.origin);
        if (isDim || !isUsed) color = Translucent(color);
        const float y = GraphLayout::RowCenter(lane.row);
        const float from = m_layout.CenterOf(lane.marks.front().box);
        const float to = m_layout.CenterOf(lane.marks.back().box);
        m_list.AddLine(At(from, y), At(std::max(to, from + 6.0f), y), color,
                       m_hoveredLane == &lane ? 3.0f : 1.5f);
        m_list.AddText(At(from + 10.0f, y - 15.0f), isDim || !isUsed ? kTranslucentText : kText,
                       resource.name.data());
        for (const GraphMark& mark : lane.marks) {
            const ImVec2 center = At(m_layout.CenterOf(mark.box), y);
            if (isBoxHovered && mark.box == m_hoveredBox)
                m_list.AddLine(At(m_layout.CenterOf(mark.box), GraphLayout::kBoxHeight), center, color, 1.0f);
            if (mark.isWritten)
                m_list.AddRectFilled({center.x - 4.0f, center.y - 4.0f}, {center.x + 4.0f, center.y + 4.0f},
                                     color);
            if (mark.isRead) {
                m_list.AddCircleFilled(center, mark.isWritten ? 2.0f : 4.0f, mark.isWritten ? kWhite : color);
                if (!mark.isWritten) m_list.AddCircleFilled(center, 2.2f, IM_COL32(28, 28, 32, 255));
            }
            if (!mark.barriers.empty())
                m_list.AddCircle(center, 6.5f, isDim ? Translucent(kBarrierRing) : kBarrierRing, 0, 1.2f);
        }
    }

    void DrawBox(size_t index) {
        const GraphBox& box = m_layout.boxes[index];
        const GraphPass& pass = m_graph.passes[box.pass];
        const ImVec2 from = At(box.x, 0.0f), to = At(box.x + GraphLayout::kBoxWidth, GraphLayout::kBoxHeight);
        const ImU32 color = box.isCulled ? IM_COL32(44, 44, 47, 255) : ColorOf(pass.kind);
        m_list.AddRectFilled(from, to, color, 3.0f);
        m_list.AddRect(from, to, m_hoveredBox == index ? kWhite : Translucent(kWhite), 3.0f);
        m_list.PushClipRect(from, {to.x - 3.0f, to.y}, true);
        m_list.AddText({from.x + 6.0f, from.y + 3.0f}, box.isCulled ? kTranslucentText : kText,
                       pass.name.data());
        const auto time = m_times.find(box.pass);
        const std::string text = box.isCulled            ? "culled"
                                 : time == m_times.end() ? "-"
                                                         : Text("{:.3f} ms", time->second);
        m_list.AddText({from.x + 6.0f, from.y + 20.0f}, box.isCulled ? kTranslucentText : kTimeText,
                       text.c_str());
        m_list.PopClipRect();
    }

    void BoxTooltip(const GraphBox& box) const {
        const GraphPass& pass = m_graph.passes[box.pass];
        ImGui::BeginTooltip();
        ImGui::Text("%s (%s)", pass.name.data(), Name(pass.kind));
        if (box.isCulled) ImGui::TextDisabled("culled: %s", CullReason(m_graph, m_plan, box.pass).c_str());
        for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u) {
            const ResourceUse& use = m_graph.uses[u];
            const char* verb = !Writes(use.access)         ? "reads"
                               : NeedsContents(use.access) ? "updates"
                                                           : "writes";
            ImGui::TextDisabled("%s", verb);
            ImGui::SameLine(70.0f);
            ImGui::Text("%s", UseText(m_graph, use).c_str());
        }
        ImGui::EndTooltip();
    }

    void LaneTooltip(const GraphLane& lane) const {
        const GraphResource& resource = m_graph.resources[lane.resource];
        ImGui::BeginTooltip();
        ImGui::Text("%s: %s, %s", resource.name.data(), ResourceText(resource).c_str(),
                    Name(resource.origin));
        const Lifetime& lifetime = m_plan.lifetimes[lane.resource];
        if (lifetime.block != raygraph::kNone)
            ImGui::TextDisabled("in block %u of transient memory", lifetime.block);
        ImGui::EndTooltip();
    }

    void MarkTooltip() const {
        ImGui::BeginTooltip();
        const GraphPass& pass = m_graph.passes[m_layout.boxes[m_hoveredMark->box].pass];
        const char* verb =
            m_hoveredMark->isWritten ? (m_hoveredMark->isRead ? "updates" : "writes") : "reads";
        ImGui::Text("%s %s it", pass.name.data(), verb);
        if (m_hoveredMark->barriers.empty()) ImGui::TextDisabled("without waiting");
        for (const uint32_t barrier : m_hoveredMark->barriers)
            ImGui::Text("waits: %s", BarrierText(m_graph, m_plan.barriers[barrier]).c_str());
        ImGui::EndTooltip();
    }

    const FrameGraph& m_graph;
    const Plan& m_plan;
    GraphLayout m_layout;
    std::map<uint32_t, double> m_times;
    ImDrawList& m_list;
    ImVec2 m_origin;
    bool m_isHovered = false;
    size_t m_hoveredBox = 0;
    const GraphLane* m_hoveredLane = nullptr;
    const GraphMark* m_hoveredMark = nullptr;
};

}  // namespace

void GraphPanel(Workspace& work) {
    if (!work.hasDrawn) return;
    const Renderer::CompiledFrame frame = work.renderer.LastCompiled();
    ImGui::Checkbox("culled", &work.showsCulled);
    ImGui::SameLine();
    ImGui::TextDisabled("%zu passes, %zu culled, %zu barriers, %zu blocks of transient memory",
                        frame.plan.passes.size(), frame.plan.culled.size(), frame.plan.barriers.size(),
                        frame.plan.blocks.size());
    ImGui::BeginChild("plan", {0.0f, 0.0f}, false, ImGuiWindowFlags_HorizontalScrollbar);
    Drawing(frame.graph, frame.plan, work.renderer.Timing(), work.showsCulled).Draw();
    ImGui::EndChild();
}

}  // namespace raygraph::editor
