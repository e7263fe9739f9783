// Textures of several levels and layers on a device: mip chains made by passes, layers drawn one by one, cube
// maps, histories of levels, imports; and what is refused when a pass declares it.
#include <gmock/gmock.h>

#include "rhi/readback.h"
#include "tests/graph/graph_test.h"
#include "tests/support/error_of.h"

namespace raygraph::subresource_frame_test {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::Texels;

// The mean of up to 2x2 texels of the finer level; sums of few small whole numbers are exact.
constexpr std::string_view kHalveImage = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) uniform readonly image2D finer;
layout(binding = 1, r32f) uniform writeonly image2D coarser;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(coarser)))) return;
    ivec2 last = imageSize(finer) - 1;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) sum += imageLoad(finer, min(2 * texel + ivec2(i & 1, i >> 1), last));
    imageStore(coarser, texel, 0.25 * sum);
})";
// The same through a sampler: another layout for the level that is read.
constexpr std::string_view kHalveSampled = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D finer;
layout(binding = 1, r32f) uniform writeonly image2D coarser;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(coarser)))) return;
    ivec2 last = textureSize(finer, 0) - 1;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) sum += texelFetch(finer, min(2 * texel + ivec2(i & 1, i >> 1), last), 0);
    imageStore(coarser, texel, 0.25 * sum);
})";
// The first texel of every level of a view.
constexpr std::string_view kFirstOfLevels = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D chain;
layout(binding = 1, r32f) uniform writeonly image2D firsts;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (texel.y == 0 && texel.x < min(textureQueryLevels(chain), imageSize(firsts).x))
        imageStore(firsts, texel, texelFetch(chain, ivec2(0), texel.x));
})";
constexpr std::string_view kAddLayers = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2DArray layers;
layout(binding = 1, r32f) uniform writeonly image2D sum;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(sum)))) return;
    vec4 all = vec4(0.0);
    for (int layer = 0; layer < textureSize(layers, 0).z; ++layer)
        all = 10.0 * all + texelFetch(layers, ivec3(texel, layer), 0);
    imageStore(sum, texel, all);
})";
constexpr std::string_view kNumberLayers = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) uniform writeonly image2DArray layers;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(layers).xy))) return;
    for (int layer = 0; layer < imageSize(layers).z; ++layer)
        imageStore(layers, ivec3(texel, layer), vec4(float(layer + 1)));
})";
constexpr std::string_view kLookAround = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform samplerCube sky;
layout(binding = 1, r32f) uniform writeonly image2D seen;
void main() {
    const vec3 axes[3] = {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (texel.y != 0 || texel.x >= 6) return;
    imageStore(seen, texel, textureLod(sky, (1.0 - 2.0 * float(texel.x & 1)) * axes[texel.x / 2], 0.0));
})";

class SubresourceFrames : public GraphTest {
  protected:
    SubresourceFrames() { AddShaders(m_renderer); }

    static void AddShaders(Renderer& renderer) {
        AddTestShaders(renderer);
        for (const auto& [name, text] : {std::pair("test/halve_image.comp", kHalveImage),
                                         {"test/halve_sampled.comp", kHalveSampled},
                                         {"test/first_of_levels.comp", kFirstOfLevels},
                                         {"test/add_layers.comp", kAddLayers},
                                         {"test/number_layers.comp", kNumberLayers},
                                         {"test/look_around.comp", kLookAround}})
            renderer.AddShader(name, CompileText(name, text));
        renderer.AddShader("test/all.vert", CompileText("test/all.vert", R"(
void main() { gl_Position = vec4(gl_VertexIndex == 1 ? 3 : -1, gl_VertexIndex == 2 ? 3 : -1, 0.25, 1); })"));
        renderer.AddShader("test/value.frag", CompileText("test/value.frag", R"(
layout(location = 0) out vec4 color;
layout(push_constant, std430) uniform Constants { float value; } constants;
void main() { color = vec4(constants.value); })"));
    }

    // Level by level, each from the one before.
    static TextureId MakeMips(Renderer& renderer, TextureId chain, bool isSampled) {
        const GraphTextureDesc desc = renderer.Desc(chain);
        for (uint32_t level = 1; level < desc.levels; ++level) {
            const Extent2D extent = rhi::MipExtent(desc.extent, level);
            renderer.AddPass(
                "Level " + std::to_string(level), PassKind::Compute,
                [&](PassBuilder& pass) {
                    pass.Compute(isSampled ? "test/halve_sampled.comp" : "test/halve_image.comp");
                    if (isSampled)
                        pass.Reads("finer", chain, Level(level - 1), rhi::SamplerDesc{});
                    else
                        pass.Reads("finer", chain, Level(level - 1));
                    chain = pass.Writes("coarser", chain, Level(level));
                },
                [extent](CommandList& commands) { commands.DispatchOver(extent); });
        }
        return chain;
    }
    static TextureId FillLevel(Renderer& renderer, TextureId chain, const Subresources& part, float value) {
        const Extent2D extent = rhi::MipExtent(renderer.Desc(chain).extent, part.level);
        renderer.AddPass(
            "Fill", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/fill.comp");
                chain = pass.Writes("target", chain, part);
                pass.Constants(value);
            },
            [extent](CommandList& commands) { commands.DispatchOver(extent); });
        return chain;
    }
    // A pass of one shader that reads a texture through a sampler and writes a new one.
    TextureId Through(const char* shader, const char* source, TextureId texture, const Subresources& part,
                      const char* target, Extent2D extent) {
        TextureId made = m_renderer.CreateTexture(target, {.extent = extent, .format = Format::R32Float});
        m_renderer.AddPass(
            shader, PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute(shader);
                pass.Reads(source, texture, part, rhi::SamplerDesc{.magFilter = rhi::Filter::Nearest});
                made = pass.Writes(target, made);
            },
            [extent](CommandList& commands) { commands.DispatchOver(extent); });
        return made;
    }
    static std::vector<float> Halved(const std::vector<float>& finer, Extent2D from, Extent2D to) {
        std::vector<float> coarser;
        for (uint32_t y = 0; y < to.height; ++y)
            for (uint32_t x = 0; x < to.width; ++x) {
                float sum = 0.0f;
                for (uint32_t i = 0; i < 4; ++i)
                    sum += finer[std::min(2 * y + (i >> 1), from.height - 1) * from.width +
                                 std::min(2 * x + (i & 1), from.width - 1)];
                coarser.push_back(0.25f * sum);
            }
        return coarser;
    }
    static float First(const Readback& readback) { return Read(readback).At(0, 0)[0]; }
};

TEST_F(SubresourceFrames, MipChain_IsTheBoxFilterOfEachLevelExactly) {
    for (const bool isSampled : {false, true})
        for (const Extent2D extent : {Extent2D{16, 16}, Extent2D{37, 10}}) {
            testing::PassHarness harness(Device());
            AddShaders(harness.Graph());
            const std::vector<Texels> levels = harness.RunAll([&](testing::PassHarness& h) {
                const TextureId chain = h.Graph().CreateTexture(
                    "chain",
                    {.extent = extent, .format = Format::R32Float, .levels = rhi::FullMipCount(extent)});
                return MakeMips(h.Graph(), FillLevel(h.Graph(), chain, Level(0), 7.0f), isSampled);
            });
            ASSERT_EQ(levels.size(), rhi::FullMipCount(extent));
            EXPECT_TRUE(IsRamp(levels[0], 7.0f));
            for (uint32_t level = 1; level < levels.size(); ++level) {
                EXPECT_EQ(levels[level].extent, rhi::MipExtent(extent, level));
                EXPECT_EQ(levels[level].values,
                          Halved(levels[level - 1].values, levels[level - 1].extent, levels[level].extent))
                    << "level " << level;
            }
            EXPECT_EQ(levels.back().extent, (Extent2D{1, 1}));
        }
}

TEST_F(SubresourceFrames, WholeChain_IsSampledLevelByLevel_AndARangeFromItsFirst) {
    m_renderer.BeginFrame();
    TextureId chain =
        m_renderer.CreateTexture("chain", {.extent = {8, 8}, .format = Format::R32Float, .levels = 4});
    for (uint32_t level = 0; level < 4; ++level)
        chain = FillLevel(m_renderer, chain, Level(level), static_cast<float>(10 + level));
    const Readback all =
        m_renderer.ReadBack(Through("test/first_of_levels.comp", "chain", chain, {}, "firsts", {4, 1}));
    const Readback two = m_renderer.ReadBack(
        Through("test/first_of_levels.comp", "chain", chain, rhi::Levels(1, 2), "firsts", {2, 1}));
    m_renderer.Execute();
    EXPECT_THAT(Read(all).values, ElementsAre(10, 11, 12, 13));
    EXPECT_THAT(Read(two).values, ElementsAre(11, 12));
}

TEST_F(SubresourceFrames, LayersDrawnOneByOne_AreReadTogetherAndApart) {
    m_renderer.BeginFrame();
    TextureId layers = m_renderer.CreateTexture(
        "layers", {.extent = {8, 4}, .format = Format::R32Float, .levels = 2, .layers = 3});
    TextureId depths =
        m_renderer.CreateTexture("depths", {.extent = {4, 2}, .format = Format::D32Float, .layers = 3});
    // Level 1 is as large as the depths.
    for (uint32_t layer = 0; layer < 3; ++layer)
        m_renderer.AddPass(
            "Draw", PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("test/all.vert").Fragment("test/value.frag");
                pass.Constants(static_cast<float>(layer + 1));
                layers = pass.ColorTarget(0, layers, Subresource(1, layer));
                depths = pass.DepthTarget(depths, Layer(layer), {.value = layer == 1 ? 0.125f : 1.0f});
            },
            [](CommandList& commands) { commands.Draw(3); });
    const Readback sum =
        m_renderer.ReadBack(Through("test/add_layers.comp", "layers", layers, Level(1), "sum", {4, 2}));
    std::vector<Readback> apart, depthOf;
    for (uint32_t layer = 0; layer < 3; ++layer) {
        apart.push_back(m_renderer.ReadBack(layers, 1, layer));
        depthOf.push_back(m_renderer.ReadBack(depths, 0, layer));
    }
    m_renderer.Execute();
    // The depth of layer 1 is nearer than what is drawn there.
    EXPECT_THAT(Read(sum).values, Each(103));
    const std::array drawn{1.0f, 0.0f, 3.0f}, depth{0.25f, 0.125f, 0.25f};
    for (size_t layer = 0; layer < 3; ++layer) {
        EXPECT_EQ(Read(apart[layer]).extent, (Extent2D{4, 2}));
        EXPECT_THAT(Read(apart[layer]).values, Each(drawn[layer])) << layer;
        EXPECT_THAT(Read(depthOf[layer]).values, Each(depth[layer])) << layer;
    }
}

TEST_F(SubresourceFrames, CubeMap_HasItsFacesAroundIt) {
    m_renderer.BeginFrame();
    TextureId sky =
        m_renderer.CreateTexture("sky", {.extent = {4, 4}, .format = Format::R32Float, .layers = 6});
    m_renderer.AddPass(
        "Number", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("test/number_layers.comp");
            sky = pass.Writes("layers", sky);
        },
        [](CommandList& commands) {
            commands.DispatchOver({4, 4});
        });
    const Readback seen =
        m_renderer.ReadBack(Through("test/look_around.comp", "sky", sky, {}, "seen", {6, 1}));
    m_renderer.Execute();
    EXPECT_THAT(Read(seen).values, ElementsAre(1, 2, 3, 4, 5, 6)) << "+x -x +y -y +z -z";
}

TEST_F(SubresourceFrames, TransfersOfParts_ClearAndCopyThemAlone) {
    m_renderer.BeginFrame();
    TextureId chain = m_renderer.CreateTexture(
        "chain", {.extent = {8, 8}, .format = Format::R32Float, .levels = 2, .layers = 2});
    m_renderer.AddPass(
        "Clear", PassKind::Transfer, [&](PassBuilder& pass) { chain = pass.CopiesTo(chain); },
        [chain](CommandList& commands, const PassResources& resources) {
            commands.Clear(resources.Texture(chain), {1.0f, 0.0f, 0.0f, 0.0f});
        });
    m_renderer.AddPass(
        "Clear one", PassKind::Transfer,
        [&](PassBuilder& pass) { chain = pass.CopiesTo(chain, Subresource(1, 0)); },
        [chain](CommandList& commands, const PassResources& resources) {
            commands.Clear(resources.Texture(chain), {2.0f, 0.0f, 0.0f, 0.0f}, Subresource(1, 0));
        });
    // From one layer to the other of the same texture, in one pass.
    m_renderer.AddPass(
        "Copy", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(chain, Subresource(1, 0));
            chain = pass.CopiesTo(chain, Subresource(1, 1));
        },
        [chain](CommandList& commands, const PassResources& resources) {
            const rhi::Texture& texture = resources.Texture(chain);
            commands.CopyTexture(texture, {.level = 1, .layer = 0}, texture, {.level = 1, .layer = 1});
        });
    std::vector<Readback> all;
    for (uint32_t layer = 0; layer < 2; ++layer)
        for (uint32_t level = 0; level < 2; ++level) all.push_back(m_renderer.ReadBack(chain, level, layer));
    m_renderer.Execute();
    EXPECT_THAT(Read(all[0]).values, Each(1));
    EXPECT_THAT(Read(all[1]).values, Each(2));
    EXPECT_THAT(Read(all[2]).values, Each(1));
    EXPECT_THAT(Read(all[3]).values, Each(2));
}

TEST_F(SubresourceFrames, PersistentLevels_AreWrittenAndReadInDifferentFrames) {
    const GraphTextureDesc desc{.extent = {8, 8}, .format = Format::R32Float, .levels = 3};
    std::vector<float> firsts;
    for (uint32_t frame = 0; frame < 4; ++frame) {
        m_renderer.BeginFrame();
        TextureId chain = m_renderer.Persist("chain", desc);
        for (uint32_t level = 0; level < 3; ++level)
            EXPECT_EQ(m_renderer.IsFresh(chain, Level(level)), level >= frame) << frame << ' ' << level;
        EXPECT_EQ(m_renderer.IsFresh(chain), frame < 3);
        // Frame 0 fills level 0, frame 1 makes level 1 of it, frame 2 level 2; frame 3 only looks.
        const uint32_t level = std::min(frame, 2u);
        if (frame == 0) {
            chain = FillLevel(m_renderer, chain, Level(0), 1.0f);
        } else if (frame < 3) {
            const Extent2D extent = rhi::MipExtent(desc.extent, level);
            m_renderer.AddPass(
                "Next level", PassKind::Compute,
                [&](PassBuilder& pass) {
                    pass.Compute("test/halve_sampled.comp");
                    pass.Reads("finer", chain, Level(level - 1), rhi::SamplerDesc{});
                    chain = pass.Writes("coarser", chain, Level(level));
                },
                [extent](CommandList& commands) { commands.DispatchOver(extent); });
        }
        if (frame < 3) {
            EXPECT_FALSE(m_renderer.IsFresh(chain, Level(level))) << "this frame writes it";
        }
        const Readback readback = m_renderer.ReadBack(chain, level);
        m_renderer.Execute();
        firsts.push_back(First(readback));
    }
    // 1 + x + 100 y over 1, 2x2, 4x4 texels
    EXPECT_THAT(firsts, ElementsAre(1.0f, 51.5f, 152.5f, 152.5f));
}

TEST_F(SubresourceFrames, ImportOfALevel_LeavesAllInOneLayoutForItsOwner) {
    const rhi::Texture host = Device().CreateTexture(
        {.name = "host",
         .extent = {8, 8},
         .format = Format::R32Float,
         .usage = rhi::TextureUsage::Storage | rhi::TextureUsage::Sampled | rhi::TextureUsage::CopySource,
         .mipLevels = 3});
    ResourceState state;
    for (int frame = 0; frame < 3; ++frame) {
        m_renderer.BeginFrame();
        const TextureId chain = m_renderer.Import("host", host, state);
        EXPECT_EQ(m_renderer.Desc(chain).levels, 3u);
        const TextureId made = MakeMips(
            m_renderer, FillLevel(m_renderer, chain, Level(0), static_cast<float>(frame)), frame != 1);
        const Readback last = m_renderer.ReadBack(made, 2);
        m_renderer.Execute();
        EXPECT_EQ(First(last), 151.5f + static_cast<float>(frame));
        for (uint32_t level = 0; level < 3; ++level)
            EXPECT_EQ(testing::As<float>(rhi::ReadTexture(Device(), host, state.layout, level)).size(),
                      size_t{8u >> level} * (8u >> level));
    }
}

// Transients of other shapes take the memory by turns; the plan shares it, and the texels are right.
TEST_F(SubresourceFrames, ChainsThatShareMemory_HoldTheirOwn) {
    for (int frame = 0; frame < 3; ++frame) {
        m_renderer.BeginFrame();
        std::vector<Readback> lasts;
        for (uint32_t i = 0; i < 3; ++i) {
            TextureId chain = m_renderer.CreateTexture(
                "chain " + std::to_string(i),
                {.extent = {16, 16}, .format = Format::R32Float, .levels = 3 + i % 2});
            chain =
                MakeMips(m_renderer, FillLevel(m_renderer, chain, Level(0), static_cast<float>(i)), i == 1);
            lasts.push_back(m_renderer.ReadBack(chain, 2));
        }
        m_renderer.Execute();
        EXPECT_THAT(m_renderer.DescribePlan(), HasSubstr("chain 1 level 0: memory of chain 0, "));
        for (size_t i = 0; i < 3; ++i) EXPECT_EQ(First(lasts[i]), 151.5f + static_cast<float>(i));
    }
}

TEST_F(SubresourceFrames, Harness_FillsAndReadsAllLevelsOfAllLayers) {
    testing::PassHarness harness(Device());
    const GraphTextureDesc desc{.extent = {2, 1}, .format = Format::R8Unorm, .levels = 2, .layers = 2};
    const std::vector<float> values{0, 1, 1, 1, 0, 0};
    const std::vector<Texels> all =
        harness.RunAll([&](testing::PassHarness& h) { return h.Texture("pairs", desc, values); });
    ASSERT_EQ(all.size(), 4u);
    EXPECT_THAT(all[0].values, ElementsAre(0, 1));
    EXPECT_THAT(all[1].values, ElementsAre(1));
    EXPECT_THAT(all[2].values, ElementsAre(1, 0));
    EXPECT_THAT(all[3].values, ElementsAre(0));
    EXPECT_THAT(testing::ErrorTextOf([&] {
                    harness.RunAll([&](testing::PassHarness& h) {
                        return h.Texture("pairs", desc, std::vector<float>(7));
                    });
                }),
                HasSubstr("2 values for 1x1 r8, which has 1"));
}

TEST_F(SubresourceFrames, LimitsOfATexture_AreNamed) {
    m_renderer.BeginFrame();
    const auto text = [&](const GraphTextureDesc& desc) {
        return testing::ErrorTextOf([&] { m_renderer.CreateTexture("chain", desc); });
    };
    EXPECT_EQ(text({.extent = {20, 4}, .levels = 6}),
              R"(texture "chain": 6 levels; 20x4 texels have 1 to 5)");
    EXPECT_EQ(text({.extent = {20, 4}, .levels = 0}),
              R"(texture "chain": 0 levels; 20x4 texels have 1 to 5)");
    const uint32_t most = Device().Info().maxTextureLayers;
    EXPECT_EQ(text({.extent = {20, 4}, .layers = most + 1}),
              R"(texture "chain": )" + std::to_string(most + 1) + " layers; the device " +
                  Device().Info().name + " has 1 to " + std::to_string(most));
    EXPECT_THAT(testing::ErrorTextOf([&] {
                    m_renderer.Persist("kept", {.extent = {1, 1}, .levels = 2});
                }),
                HasSubstr(R"(texture "kept": 2 levels; 1x1 texels have 1 to 1)"));
    const TextureId chain = m_renderer.CreateTexture("chain", {.extent = {4, 4}, .levels = 2});
    EXPECT_EQ(testing::ErrorTextOf([&] { m_renderer.ReadBack(chain, 2); }),
              R"(ReadBack reads "chain": level 2, there are 2)");
    EXPECT_EQ(testing::ErrorTextOf([&] { m_renderer.ReadBack(chain, 0, 1); }),
              R"(ReadBack reads "chain": layer 1, there is 1)");
    EXPECT_EQ(testing::ErrorTextOf([&] {
                  std::ignore = m_renderer.IsFresh(m_renderer.Persist("kept", {.extent = {4, 4}}), Level(1));
              }),
              R"(IsFresh asks about "kept": level 1, there is 1)");
}

}  // namespace
}  // namespace raygraph::subresource_frame_test
