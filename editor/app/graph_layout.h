// The layout of a frame's plan: passes as boxes in their order, each resource a lane below them,
// from the first pass that uses it to the last. Pure; in points, from the upper left corner of the drawing.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/graph/frame_graph.h"
#include "renderer/graph/plan.h"

namespace raygraph::editor {

struct GraphBox {
    uint32_t pass = 0;  // of FrameGraph::passes
    bool isCulled = false;
    float x = 0.0f;  // of its left edge
};

// A pass and a resource that it uses.
struct GraphMark {
    size_t box = 0;
    bool isRead = false, isWritten = false;
    std::vector<uint32_t> barriers;  // of Plan::barriers: what the pass waits for there
};

struct GraphLane {
    uint32_t resource = 0;  // of FrameGraph::resources
    size_t row = 0;
    std::vector<GraphMark> marks;  // by box
};

struct GraphLayout {
    static constexpr float kBoxWidth = 118.0f, kBoxGap = 14.0f, kBoxHeight = 40.0f, kRowHeight = 17.0f;
    static constexpr float kLetter = 7.0f;  // approximate width of a letter

    std::vector<GraphBox> boxes;  // in order of execution; culled ones where they were declared
    std::vector<GraphLane> lanes;
    size_t rowCount = 0;
    glm::vec2 size{0.0f};

    float CenterOf(size_t box) const { return boxes[box].x + 0.5f * kBoxWidth; }
    static float RowCenter(size_t row) { return kBoxHeight + kRowHeight * (static_cast<float>(row) + 1.2f); }
};

// Resources that passes write come above those that they only read. Lanes of resources that are not in use at
// the same time share a row, as long as their names have room.
GraphLayout LayOut(const FrameGraph& graph, const Plan& plan, bool withCulled);

}  // namespace raygraph::editor
