// Tests the rows of the hierarchy.
#include "editor/app/scene_panels.h"

#include <gtest/gtest.h>

#include <string>

namespace raygraph::editor::hierarchy_test {

namespace {

std::string RowsOf(const Hierarchy& hierarchy) {
    std::string rows;
    for (const Hierarchy::Row& row : hierarchy.Rows())
        rows += std::string(row.depth, '-') + std::to_string(row.node) + ' ';
    return rows;
}

}  // namespace

TEST(Hierarchy, ShowsWhatIsOpen) {
    Hierarchy hierarchy({{2, 3}, {}, {4}, {}, {}}, {0, 1});
    EXPECT_EQ(RowsOf(hierarchy), "0 1 ");
    hierarchy.SetOpen(0, true);
    EXPECT_EQ(RowsOf(hierarchy), "0 -2 -3 1 ");
    hierarchy.SetOpen(2, true);
    EXPECT_EQ(RowsOf(hierarchy), "0 -2 --4 -3 1 ");
    hierarchy.SetOpen(0, false);
    EXPECT_EQ(RowsOf(hierarchy), "0 1 ");
    EXPECT_EQ(hierarchy.Reveal(4), 2u) << "what was picked is shown";
    EXPECT_EQ(RowsOf(hierarchy), "0 -2 --4 -3 1 ");
}

TEST(Hierarchy, OneRootIsOpenAndADeepChainNeedsNoStack) {
    std::vector<std::vector<uint32_t>> chain(200'000);
    for (uint32_t i = 0; i + 1 < chain.size(); ++i) chain[i] = {i + 1};
    Hierarchy hierarchy(chain, {0});
    EXPECT_EQ(RowsOf(hierarchy), "0 -1 ");
    EXPECT_EQ(hierarchy.Reveal(199'999), 199'999u);
    EXPECT_EQ(Hierarchy().Rows().size(), 0u);
}

}  // namespace raygraph::editor::hierarchy_test
