// Tests which actions keys are bound to, and that each has help.
#include "editor/app/actions.h"

#include <gtest/gtest.h>

namespace raygraph::editor::actions_test {

TEST(Actions, ShiftTellsApartWhereItCounts) {
    EXPECT_EQ(ActionOf({Key::S, true, false}), Action::SavePicture);
    EXPECT_EQ(ActionOf({Key::S, true, true}), Action::SaveScene);
    EXPECT_EQ(ActionOf({Key::Z, true, true}), Action::Redo);
    EXPECT_EQ(ActionOf({Key::Z, true, false}), Action::Undo);
    EXPECT_EQ(ActionOf({Key::Y, true, true}), Action::Redo) << "Shift is of no account here";
    EXPECT_EQ(ActionOf({Key::R, false, true}), Action::Raster);
    EXPECT_EQ(ActionOf({Key::Z, false, false}), Action::Move) << "without Ctrl";
    EXPECT_EQ(ActionOf({Key::R, true, false}), std::nullopt);
    EXPECT_EQ(ActionOf({Key::B, false, false}), std::nullopt);
}

TEST(Actions, EachIsInAMenuOrHasAKeyAndKeysHaveHelp) {
    for (const ActionRow& row : Actions()) {
        EXPECT_TRUE(row.menu != Menu::None || row.keys[0]) << static_cast<int>(row.action);
        EXPECT_EQ(row.keys[0].has_value(), *row.help != 0) << static_cast<int>(row.action);
        EXPECT_TRUE(row.menu == Menu::None || *row.label != 0) << static_cast<int>(row.action);
    }
}

}  // namespace raygraph::editor::actions_test
