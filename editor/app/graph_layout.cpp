#include "editor/app/graph_layout.h"

#include <algorithm>
#include <map>

namespace raygraph::editor {

namespace {

std::vector<GraphBox> BoxesOf(const Plan& plan, bool withCulled) {
    std::vector<GraphBox> boxes;
    for (const PlannedPass& planned : plan.passes) boxes.push_back({.pass = planned.pass});
    if (withCulled) {
        for (const uint32_t pass : plan.culled) {
            const auto next =
                std::ranges::find_if(boxes, [&](const GraphBox& box) { return box.pass > pass; });
            boxes.insert(next, {.pass = pass, .isCulled = true});
        }
    }
    for (size_t i = 0; i < boxes.size(); ++i)
        boxes[i].x = static_cast<float>(i) * (GraphLayout::kBoxWidth + GraphLayout::kBoxGap);
    return boxes;
}

}  // namespace

GraphLayout LayOut(const FrameGraph& graph, const Plan& plan, bool withCulled) {
    GraphLayout layout;
    layout.boxes = BoxesOf(plan, withCulled);
    std::map<uint32_t, const PlannedPass*> plannedOf;
    for (const PlannedPass& planned : plan.passes) plannedOf[planned.pass] = &planned;

    // Lanes are in the order of their first use
    std::map<uint32_t, size_t> laneOf;
    for (size_t i = 0; i < layout.boxes.size(); ++i) {
        const GraphPass& pass = graph.passes[layout.boxes[i].pass];
        for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u) {
            const ResourceUse& use = graph.uses[u];
            const auto [lane, isNew] = laneOf.try_emplace(use.resource, layout.lanes.size());
            if (isNew) layout.lanes.push_back({.resource = use.resource});
            std::vector<GraphMark>& marks = layout.lanes[lane->second].marks;
            if (marks.empty() || marks.back().box != i) marks.push_back({.box = i});
            const bool isWrite = Writes(use.access);
            marks.back().isWritten |= isWrite;
            marks.back().isRead |= !isWrite || NeedsContents(use.access);
        }
        const auto planned = plannedOf.find(layout.boxes[i].pass);
        if (planned == plannedOf.end()) continue;
        const BarrierRange range = planned->second->barriers;
        for (uint32_t b = range.first; b < range.first + range.count; ++b) {
            const auto lane = laneOf.find(plan.barriers[b].resource);
            if (lane == laneOf.end()) continue;
            std::vector<GraphMark>& marks = layout.lanes[lane->second].marks;
            if (marks.back().box == i) marks.back().barriers.push_back(b);
        }
    }

    const auto isWritten = [](const GraphLane& lane) {
        return std::ranges::any_of(lane.marks, [](const GraphMark& mark) { return mark.isWritten; });
    };
    // std::ranges::stable_partition is not used: clang 14 does not compile what it returns
    std::stable_partition(layout.lanes.begin(), layout.lanes.end(), isWritten);
    std::vector<float> ends;  // right ends of the rows so far
    for (GraphLane& lane : layout.lanes) {
        const float from = layout.CenterOf(lane.marks.front().box);
        const auto letters = static_cast<float>(graph.resources[lane.resource].name.size());
        const float to = std::max(layout.CenterOf(lane.marks.back().box) + 12.0f,
                                  from + 16.0f + letters * GraphLayout::kLetter);
        const auto row = std::ranges::find_if(ends, [&](float end) { return end < from - 12.0f; });
        lane.row = static_cast<size_t>(row - ends.begin());
        if (row == ends.end())
            ends.push_back(to);
        else
            *row = to;
        layout.size.x = std::max(layout.size.x, to);
    }
    layout.rowCount = ends.size();
    if (!layout.boxes.empty())
        layout.size.x = std::max(layout.size.x, layout.boxes.back().x + GraphLayout::kBoxWidth);
    layout.size.y = GraphLayout::RowCenter(layout.rowCount);
    return layout;
}

}  // namespace raygraph::editor
