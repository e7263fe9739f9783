// Tests the sums of a render as one process sends them to another.
#include "editor/session/file/render_file_impl.h"

#include <algorithm>

#include "tests/cli/cli_test.h"

namespace raygraph::session::render_sums_test {
namespace {

TEST(RenderSums, AllOfThemAreEachOnce) {
    RenderSums sums;
    sums.lightGroups.resize(2);
    const std::vector<passes::ExactSums*> all = AllOf(sums);
    const auto count = [&](const passes::ExactSums* one) { return std::ranges::count(all, one); };
    EXPECT_EQ(count(&sums.radiance), 1);
    for (const Aov aov : kAovs) {
        const passes::ExactSums* ofAov = SumsOf(sums, aov);
        EXPECT_TRUE(ofAov == nullptr || count(ofAov) == 1) << Name(aov);
    }
    for (const passes::ExactSums& group : sums.lightGroups) EXPECT_EQ(count(&group), 1);
    EXPECT_EQ(all.size(), 3 + sums.parts.size() + sums.removed.size() + 2);
}

}  // namespace
}  // namespace raygraph::session::render_sums_test
