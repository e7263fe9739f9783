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
    uint32_t pass = 0;  // index into FrameGraph::passes
    bool isCulled = false;
    float x = 0.0f;  // left edge
};

// Marks that a pass uses a resource.
struct GraphMark {
    size_t box = 0;
    bool isRead = false, isWritten = false;
    std::vector<uint32_t> barriers;  // indices into Plan::barriers: the pass waits for these
};

struct GraphLane {
    uint32_t resource = 0;  // index into FrameGraph::resources
    size_t row = 0;
    std::vector<GraphMark> marks;  // in the order of the boxes
};

struct GraphLayout {
    static constexpr float kBoxWidth = 118.0f, kBoxGap = 14.0f, kBoxHeight = 40.0f, kRowHeight = 17.0f;
    static constexpr float kLetter = 7.0f;  // approximate width of a letter

    std::vector<GraphBox> boxes;  // in order of execution; culled ones in order of declaration
    std::vector<GraphLane> lanes;
    size_t rowCount = 0;
    glm::vec2 size{0.0f};

    float CenterOf(size_t box) const { return boxes[box].x + 0.5f * kBoxWidth; }
    static float RowCenter(size_t row) { return kBoxHeight + kRowHeight * (static_cast<float>(row) + 1.2f); }
};

// Places resources that passes write above those that they only read. Lanes of resources whose lifetimes do
// not overlap share a row if there is room for their names.
GraphLayout LayOut(const FrameGraph& graph, const Plan& plan, bool withCulled);

}  // namespace raygraph::editor
