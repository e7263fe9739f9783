// Tests the positions in the drawing of a plan.
#include "editor/app/graph_panel.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "renderer/graph/compile.h"

namespace raygraph::editor::graph_layout_test {

namespace {

// The plan is Draw -> a -> Blur -> b -> Show, a pass that nothing needs, and one that updates a persistent
// resource.
class GraphLayoutTest : public ::testing::Test {
  protected:
    GraphLayoutTest() {
        graph.Begin(1);
        const auto texture = [&](const char* name, Origin origin = Origin::Transient) {
            return graph.Add<ResourceKind::Texture>(
                {.name = name, .origin = origin, .extent = {8, 8}, .format = rhi::Format::Rgba8Unorm});
        };
        TextureId a = texture("a"), unused = texture("unused"), b = texture("b");
        TextureId kept = texture("kept", Origin::Persistent);
        const BufferId table = graph.Add<ResourceKind::Buffer>(
            {.name = "table", .origin = Origin::Imported, .bytes = 64, .version = 1});
        graph.AddPass("Draw", PassKind::Compute);
        std::ignore = graph.Use(table, Access::StorageRead);
        a = graph.Use(a, Access::StorageWrite);
        graph.AddPass("Waste", PassKind::Compute);
        std::ignore = graph.Use(a, Access::Sampled);
        unused = graph.Use(unused, Access::StorageWrite);
        graph.AddPass("Blur", PassKind::Compute);
        std::ignore = graph.Use(a, Access::Sampled);
        b = graph.Use(b, Access::StorageWrite);
        graph.AddPass("Keep", PassKind::Compute);
        std::ignore = graph.Use(b, Access::Sampled);
        kept = graph.Use(kept, Access::StorageWrite);
        graph.AddPass("Mend", PassKind::Compute);
        kept = graph.Use(kept, Access::StorageUpdate);
        graph.Present(kept);
        plan = Compile(graph);
    }
    const GraphLane& LaneOf(const GraphLayout& layout, const std::string& name) const {
        return *std::ranges::find_if(
            layout.lanes, [&](const GraphLane& lane) { return graph.resources[lane.resource].name == name; });
    }
    std::string BoxNames(const GraphLayout& layout) const {
        std::string names;
        for (const GraphBox& box : layout.boxes)
            names +=
                (box.isCulled ? "(" + graph.passes[box.pass].name + ")" : graph.passes[box.pass].name) + " ";
        return names;
    }

    FrameGraph graph;
    Plan plan;
};

}  // namespace

TEST_F(GraphLayoutTest, BoxesAreInOrderWithCulledOnesWhereTheyWereDeclared) {
    EXPECT_EQ(BoxNames(LayOut(graph, plan, true)), "Draw (Waste) Blur Keep Mend ");
    const GraphLayout executed = LayOut(graph, plan, false);
    EXPECT_EQ(BoxNames(executed), "Draw Blur Keep Mend ");
    for (size_t i = 1; i < executed.boxes.size(); ++i)
        EXPECT_GT(executed.boxes[i].x, executed.boxes[i - 1].x + GraphLayout::kBoxWidth);
    EXPECT_GE(executed.size.x, executed.boxes.back().x + GraphLayout::kBoxWidth);
}

TEST_F(GraphLayoutTest, MarksSayWhoReadsWritesAndWaits) {
    const GraphLayout layout = LayOut(graph, plan, true);
    const GraphLane& a = LaneOf(layout, "a");
    ASSERT_EQ(a.marks.size(), 3u);
    EXPECT_TRUE(a.marks[0].isWritten && !a.marks[0].isRead);
    EXPECT_TRUE(a.marks[1].isRead && a.marks[1].barriers.empty()) << "culled: it waits for nothing";
    ASSERT_EQ(a.marks[2].barriers.size(), 1u);
    EXPECT_EQ(plan.barriers[a.marks[2].barriers[0]].resource, a.resource);
    const GraphLane& kept = LaneOf(layout, "kept");
    ASSERT_EQ(kept.marks.size(), 2u);
    EXPECT_TRUE(kept.marks[1].isRead && kept.marks[1].isWritten) << "an update is both";
    EXPECT_EQ(kept.marks[1].box, 4u);
}

TEST_F(GraphLayoutTest, LanesOfOneRowDoNotTouch) {
    const GraphLayout layout = LayOut(graph, plan, true);
    for (const GraphLane& one : layout.lanes)
        for (const GraphLane& other : layout.lanes) {
            if (&one == &other || one.row != other.row) continue;
            const bool isBefore =
                layout.CenterOf(one.marks.back().box) < layout.CenterOf(other.marks.front().box);
            const bool isAfter =
                layout.CenterOf(other.marks.back().box) < layout.CenterOf(one.marks.front().box);
            EXPECT_TRUE(isBefore || isAfter);
        }
    const auto isMade = [](const GraphLane& lane) {
        return std::ranges::any_of(lane.marks, [](const GraphMark& mark) { return mark.isWritten; });
    };
    EXPECT_TRUE(std::ranges::is_partitioned(layout.lanes, isMade)) << "what is only read lies below";
    EXPECT_FALSE(isMade(layout.lanes.back()));
    EXPECT_LT(layout.rowCount, layout.lanes.size()) << "a and kept follow each other";
    const GraphLayout nothing = LayOut({}, {}, true);
    EXPECT_TRUE(nothing.boxes.empty() && nothing.lanes.empty());
}

}  // namespace raygraph::editor::graph_layout_test
