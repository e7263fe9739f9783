// Parts of textures that a pass cannot have: each is refused with one line that names the texture, what was asked
// and what there is.
#include "renderer/graph/pass_declaration.h"
#include "tests/graph/graph_maker.h"
#include "tests/support/error_of.h"

namespace raygraph::subresource_misuse_test {
namespace {

TEST(SubresourceMisuse, PartThatTheTextureDoesNotHave) {
    GraphMaker graph;
    const TextureId chain = graph.Chain("chain", 5);
    graph.AddPass("Blur", PassKind::Compute);
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Use(chain, Access::StorageWrite, Level(5)); }),
              R"(pass "Blur" writes "chain": level 5, there are 5)");
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Use(chain, Access::StorageWrite, Levels(3, 4)); }),
              R"(pass "Blur" writes "chain": levels 3-6, there are 5)");
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Use(chain, Access::StorageWrite, Subresource(0, 2)); }),
              R"(pass "Blur" writes "chain": layer 2, there is 1)");
}

TEST(SubresourceMisuse, ReadingAndWritingOneLevelInOnePass) {
    GraphMaker graph;
    TextureId chain = graph.Fill("Make", graph.Chain("chain", 4, 2));
    graph.AddPass("Blur", PassKind::Compute);
    graph.Use(chain, Access::StorageRead, Levels(0, 2));
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Use(chain, Access::StorageWrite, Levels(1, 2)); }),
        R"(pass "Blur" uses "chain" level 1 both as storage read and as storage write: a pass that reads what it writes updates it)");
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Use(chain, Access::Sampled, Subresource(0, 1)); }),
        R"(pass "Blur" uses "chain" level 0 layer 1 both as storage read and as sampled: a pass sees a texture in one way only)");
    chain = graph.Use(chain, Access::StorageWrite, Level(3));
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Use(chain, Access::StorageWrite, Layer(1)); }),
        R"(pass "Blur" uses "chain" levels 0-1 layer 1 both as storage read and as storage write: a pass that reads what it writes updates it)");
}

TEST(SubresourceMisuse, LevelThatNothingWrote) {
    GraphMaker graph;
    TextureId chain = graph.Chain("chain", 4, 2);
    graph.AddPass("First", PassKind::Compute);
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Use(chain, Access::Sampled, Level(2)); }),
        R"(pass "First" reads "chain" level 2, a transient texture that nothing has written in this frame)");
    chain = graph.Fill("Make", chain, Levels(0, 2));
    chain = graph.Fill("More", chain, Subresource(2, 0));
    graph.AddPass("Blur", PassKind::Compute);
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Use(chain, Access::Sampled, Levels(1, 2)); }),
        R"(pass "Blur" reads "chain" levels 1-2, a transient texture whose level 2 layer 1 nothing has )"
        "written in this frame");
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Use(chain, Access::StorageUpdate); }),
              R"(pass "Blur" updates "chain", a transient texture whose level 3 layer 0 nothing has written )"
              "in this frame");
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Present(chain); }),
              R"(Present shows "chain", a transient texture whose level 3 layer 0 nothing has written in )"
              "this frame");
    graph.Use(chain, Access::Sampled, Levels(0, 2));
    graph.Use(chain, Access::StorageRead, Subresource(2, 0));
}

TEST(SubresourceMisuse, LevelOfAnImportWithoutContents) {
    GraphMaker graph;
    TextureId host = graph.Chain("host", 2, 1, 0, Origin::Imported);
    host = graph.Fill("Make", host, Level(0));
    graph.AddPass("Blur", PassKind::Compute);
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Use(host, Access::Sampled); }),
              R"(pass "Blur" reads "host", imported in the layout Undefined: its level 1 has no contents )"
              "until it is written");
}

TEST(SubresourceMisuse, IdFromBeforeAWriteOfAnotherLevel_IsStaleToo) {
    GraphMaker graph;
    const TextureId before = graph.Fill("Make", graph.Chain("chain", 2), Level(0));
    std::ignore = graph.Fill("More", before, Level(1));
    graph.AddPass("Blur", PassKind::Compute);
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Use(before, Access::Sampled, Level(0)); }),
              R"(pass "Blur" reads "chain" as it was before pass "More" wrote it: use the id that the write )"
              "returned");
}

// What a shader says to a part under the name "image" of a binding that it declares.
std::string BindingRefusal(const GraphMaker& maker, TextureId texture, const Subresources& part,
                           rhi::BindingKind kind, rhi::ImageShape shape) {
    GraphMaker graph = maker;
    graph.AddPass("Look", PassKind::Compute);
    rhi::BindingInfo info;
    info.name = "image";
    info.kind = kind;
    info.shape = shape;
    info.firstShader = "look.comp";
    rhi::ShaderInterface interface;
    interface.bindings.push_back(info);
    const rhi::Sampler sampler;
    const bool isSampled = kind == rhi::BindingKind::SampledImage;
    PassDeclaration pass;
    pass.Clear(PassKind::Compute);
    return testing::ErrorTextOf([&] {
        AddBinding(graph, pass, "image", texture, BindVerb::Reads,
                   isSampled ? Access::Sampled : Access::StorageRead, isSampled ? &sampler : nullptr, part);
        ResolveBindings(graph, pass, &interface);
    });
}

TEST(SubresourceMisuse, ViewThatTheShaderCannotHave) {
    using enum rhi::ImageShape;
    using enum rhi::BindingKind;
    GraphMaker graph;
    const TextureId faces = graph.Fill("Make", graph.Chain("faces", 3, 6));
    const auto refusal = [&](const Subresources& part, rhi::BindingKind kind, rhi::ImageShape shape) {
        return BindingRefusal(graph, faces, part, kind, shape);
    };
    EXPECT_EQ(refusal({}, StorageImage, Array),
              R"(pass "Look" binds "image" to 3 levels of "faces": a storage image is one, as in Level(0))");
    EXPECT_EQ(
        refusal(Level(0), StorageImage, Plain),
        R"(pass "Look" binds "image" to 6 layers of "faces": in look.comp it is a 2D image, of one layer, as in Layer(0))");
    EXPECT_EQ(
        refusal(Layers(1, 2), SampledImage, Plain),
        R"(pass "Look" binds "image" to 2 layers of "faces": in look.comp it is a 2D image, of one layer, as in Layer(0))");
    EXPECT_EQ(
        refusal(Layer(0), SampledImage, Cube),
        R"(pass "Look" binds "image" to 1 layer of 64x64 of "faces": in look.comp it is a cube map, of six square layers)");
    EXPECT_EQ(refusal({}, SampledImage, Cube), "accepted");
    EXPECT_EQ(refusal(Level(2), StorageImage, Array), "accepted");
    EXPECT_EQ(refusal(Layer(5), SampledImage, Plain), "accepted") << "all levels of one layer";
    EXPECT_EQ(refusal(Subresource(1, 5), StorageImage, Plain), "accepted");

    graph.resources[faces.resource].extent = {64, 32};
    EXPECT_EQ(
        refusal({}, SampledImage, Cube),
        R"(pass "Look" binds "image" to 6 layers of 64x32 of "faces": in look.comp it is a cube map, of six square layers)");
}

TEST(SubresourceMisuse, TargetOfSeveralLayersOrOfAnotherSize) {
    GraphMaker graph;
    const TextureId faces = graph.Fill("Make", graph.Chain("faces", 3, 6));
    const auto refusal = [&](const std::vector<Subresources>& targets) {
        PassDeclaration pass;
        pass.Clear(PassKind::Raster);
        graph.AddPass("Draw", PassKind::Raster);
        for (const Subresources& part : targets)
            pass.colors.push_back({.index = static_cast<uint32_t>(pass.colors.size()),
                                   .resource = faces.resource,
                                   .load = {},
                                   .part = rhi::Resolved(part, 3, 6)});
        return testing::ErrorTextOf([&] { ResolveTargets(graph, pass); });
    };
    EXPECT_EQ(
        refusal({Level(1)}),
        R"(pass "Draw" draws to 6 layers of "faces": a target is one level of one layer, as in Subresource(0, 0))");
    EXPECT_EQ(
        refusal({Layer(1)}),
        R"(pass "Draw" draws to 3 levels of "faces": a target is one level of one layer, as in Subresource(0, 0))");
    EXPECT_EQ(refusal({Subresource(1, 2), Subresource(2, 2)}),
              R"(pass "Draw" draws to "faces" of 32x32 and to "faces" of 16x16)");
    EXPECT_EQ(refusal({Subresource(1, 2), Subresource(1, 3)}), "accepted");
}

}  // namespace
}  // namespace raygraph::subresource_misuse_test
