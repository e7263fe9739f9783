// Mistakes in declaring a frame: each throws Error{Usage} with one line that names the pass, the resource and
// the reason.
#include "tests/graph/graph_maker.h"
#include "tests/support/error_of.h"

namespace raygraph::misuse_test {
namespace {

TEST(Misuse, StaleId_NamesThePassThatWroteSince) {
    GraphMaker graph;
    const TextureId before = graph.Pass("First", {}, graph.Texture("radiance"));
    [[maybe_unused]] const TextureId after = graph.Pass("Second", {}, before);
    graph.AddPass("Blur", PassKind::Compute);
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Use(before, Access::StorageRead); }),
        R"(pass "Blur" reads "radiance" as it was before pass "Second" wrote it: use the id that the write returned)");
}

TEST(Misuse, WritingAVersionTwice_IsStaleToo) {
    GraphMaker graph;
    const TextureId target = graph.Texture("radiance");
    [[maybe_unused]] const TextureId first = graph.Pass("First", {}, target);
    EXPECT_EQ(
        testing::ErrorTextOf([&] { return graph.Pass("Second", {}, target); }),
        R"(pass "Second" writes "radiance" as it was before pass "First" wrote it: use the id that the write returned)");
}

TEST(Misuse, EmptyId) {
    GraphMaker graph;
    graph.AddPass("Blur", PassKind::Compute);
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Use(TextureId{}, Access::StorageRead); }),
              R"(pass "Blur" reads an empty texture id, which names no resource)");
}

TEST(Misuse, IdOfAnEarlierFrame) {
    GraphMaker graph;
    const TextureId old = graph.Texture("radiance");
    graph.Begin(4);
    [[maybe_unused]] const TextureId fresh = graph.Texture("radiance");
    graph.AddPass("Blur", PassKind::Compute);
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Use(old, Access::StorageWrite); }),
        R"(pass "Blur" writes a texture id of an earlier frame (3 before this one): ids last for one frame)");
}

TEST(Misuse, IdOfAnotherGraph) {
    GraphMaker other;
    [[maybe_unused]] const TextureId first = other.Texture("a");
    const TextureId second = other.Texture("b");
    GraphMaker graph;
    [[maybe_unused]] const TextureId mine = graph.Texture("c");
    graph.AddPass("Blur", PassKind::Compute);
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Use(second, Access::StorageWrite); }),
        R"(pass "Blur" writes a texture id that this frame did not give out: it is of another Renderer)");
}

TEST(Misuse, TransientThatNothingWrote) {
    GraphMaker graph;
    const TextureId empty = graph.Texture("radiance");
    graph.AddPass("Blur", PassKind::Compute);
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Use(empty, Access::StorageRead); }),
              R"(pass "Blur" reads "radiance", a transient texture that nothing has written in this frame)");
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Use(empty, Access::StorageUpdate); }),
        R"(pass "Blur" updates "radiance", a transient texture that nothing has written in this frame)");
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Present(empty); }),
              R"(Present shows "radiance", a transient texture that nothing has written in this frame)");
}

TEST(Misuse, ImportWithoutContents) {
    GraphMaker graph;
    const TextureId host = graph.Imported<ResourceKind::Texture>("host");
    graph.AddPass("Blur", PassKind::Compute);
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Use(host, Access::Sampled); }),
        R"(pass "Blur" reads "host", imported in the layout Undefined: it has no contents until it is written)");
}

TEST(Misuse, AccessThatThePassKindCannotDo) {
    GraphMaker graph;
    const TextureId target = graph.Texture("radiance");
    graph.AddPass("Upload", PassKind::Transfer);
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Use(target, Access::StorageWrite); }),
              R"(pass "Upload" uses "radiance" as storage write, which a pass of kind transfer cannot do)");
    graph.AddPass("Trace", PassKind::RayTracing);
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Use(target, Access::ColorWrite); }),
              R"(pass "Trace" uses "radiance" as color target, which a pass of kind ray tracing cannot do)");
}

TEST(Misuse, ReadingAndWritingInOnePass) {
    GraphMaker graph;
    const TextureId made = graph.Pass("Make", {}, graph.Texture("radiance"));
    graph.AddPass("Blur", PassKind::Compute);
    graph.Use(made, Access::StorageRead);
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Use(made, Access::StorageWrite); }),
        R"(pass "Blur" uses "radiance" both as storage read and as storage write: a pass that reads what it writes updates it)");
}

TEST(Misuse, WritingTwiceInOnePass) {
    GraphMaker graph;
    graph.AddPass("Blur", PassKind::Compute);
    const TextureId once = graph.Use(graph.Texture("radiance"), Access::StorageWrite);
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Use(once, Access::StorageWrite); }),
        R"(pass "Blur" uses "radiance" both as storage write and as storage write: a pass writes a resource once)");
}

TEST(Misuse, SamplingAndLoadingInOnePass) {
    GraphMaker graph;
    const TextureId made = graph.Pass("Make", {}, graph.Texture("radiance"));
    graph.AddPass("Blur", PassKind::Compute);
    graph.Use(made, Access::StorageRead);
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Use(made, Access::Sampled); }),
        R"(pass "Blur" uses "radiance" both as storage read and as sampled: a pass sees a texture in one way only)");
}

TEST(Misuse, BuildsMayCombineUsesOfASet) {
    GraphMaker graph;
    BlasSetId blases = graph.Imported<ResourceKind::BlasSet>("blases");
    graph.AddPass("Build", PassKind::AccelerationStructure);
    graph.Use(blases, Access::BuildRead);
    blases = graph.Use(blases, Access::BuildWrite);
    blases = graph.Use(blases, Access::BuildUpdate);
    EXPECT_EQ(blases.version, 2u);
}

TEST(Misuse, ShownTextureThatIsWrittenLater) {
    GraphMaker graph;
    const TextureId made = graph.Pass("Make", {}, graph.Texture("radiance"));
    graph.Present(made);
    [[maybe_unused]] const TextureId later = graph.Pass("Again", {}, made);
    EXPECT_EQ(testing::ErrorTextOf([&] { Compile(graph); }),
              R"("radiance" was presented and written again later in the frame: )"
              "its contents at the end of the frame are not those that were meant");
}

TEST(Misuse, ExportOfWhatWasNotImported) {
    GraphMaker graph;
    const TextureId made = graph.Pass("Make", {}, graph.Texture("radiance"));
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Export(made, VK_IMAGE_LAYOUT_GENERAL); }),
              R"(Export hands back "radiance", a transient texture: only imported ones have an owner)");
    const TextureId host = graph.Imported<ResourceKind::Texture>("host");
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Export(host, VK_IMAGE_LAYOUT_UNDEFINED); }),
              R"(Export hands back "host" in a layout that drops its contents)");
}

TEST(Misuse, ExportOfOneTextureTwice) {
    GraphMaker graph;
    const TextureId host = graph.Pass("Make", {}, graph.Imported<ResourceKind::Texture>("host"));
    graph.Export(host, VK_IMAGE_LAYOUT_GENERAL);
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Export(host, VK_IMAGE_LAYOUT_GENERAL); }),
              R"(Export hands back "host" twice)");
}

TEST(Misuse, FailedUse_LeavesTheGraphAsItWas) {
    GraphMaker graph;
    const TextureId target = graph.Texture("radiance");
    graph.AddPass("Blur", PassKind::Compute);
    EXPECT_NE(testing::ErrorTextOf([&] { graph.Use(target, Access::StorageRead); }), "accepted");
    EXPECT_TRUE(graph.uses.empty());
    EXPECT_EQ(graph.resources[0].version, 0u);
}

TEST(Access, EveryKindOfPass_HasMasksForItsLegalAccesses) {
    for (int kind = 0; kind <= static_cast<int>(PassKind::AccelerationStructure); ++kind) {
        for (int access = 0; access < static_cast<int>(Access::Count); ++access) {
            const auto passKind = static_cast<PassKind>(kind);
            const auto passAccess = static_cast<Access>(access);
            if (!IsLegal(passKind, passAccess)) continue;
            const AccessMasks masks = MasksFor(passKind, passAccess);
            EXPECT_NE(masks.stages, 0u) << Name(passKind) << ' ' << Name(passAccess);
            EXPECT_NE(masks.access, 0u) << Name(passKind) << ' ' << Name(passAccess);
            EXPECT_EQ(Writes(passAccess), (masks.access & kWriteAccesses) != 0)
                << Name(passKind) << ' ' << Name(passAccess);
        }
    }
}

}  // namespace
}  // namespace raygraph::misuse_test
