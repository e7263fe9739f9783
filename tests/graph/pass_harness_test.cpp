// The harness itself: texels in and out of every format, one pass alone, state from run to run.
#include "renderer/graph/pass_harness.h"

#include <gmock/gmock.h>

#include <cmath>

#include "tests/graph/graph_test.h"

namespace raygraph::testing::pass_harness_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Texels, EveryFormat_KeepsWhatItCanHold) {
    for (uint32_t f = 1; f < rhi::kFormatCount; ++f) {
        const auto format = static_cast<rhi::Format>(f);
        if (rhi::BlockSide(format) > 1) {
            EXPECT_EQ(ChannelCount(format), 0u) << rhi::Name(format);
            continue;
        }
        std::vector<float> values(size_t{6} * ChannelCount(format));
        for (size_t i = 0; i < values.size(); ++i) values[i] = i % 3 == 0 ? 1.0f : 0.0f;
        const Extent2D extent{3, 2};
        const std::vector<std::byte> bytes = EncodeTexels(values, extent, format);
        EXPECT_EQ(bytes.size(), 6 * rhi::TexelBytes(format));
        EXPECT_EQ(DecodeTexels(bytes, extent, format).values, values) << rhi::Name(format);
    }
}

TEST(Texels, Halves_RoundToNearestEven) {
    const auto roundTrip = [](float value) {
        return DecodeTexels(EncodeTexels(std::span(&value, 1), {1, 1}, rhi::Format::R16Float), {1, 1},
                            rhi::Format::R16Float)
            .values[0];
    };
    for (const float exact : {0.0f, 1.0f, -2.5f, 65504.0f, 0x1p-14f, 0x1p-24f, 0x3ffp-24f, 1.0009765625f})
        EXPECT_EQ(roundTrip(exact), exact);
    EXPECT_EQ(roundTrip(1.0f + 0x1p-11f), 1.0f) << "half way: to even";
    EXPECT_EQ(roundTrip(1.0f + 0x3p-11f), 1.0f + 0x2p-10f) << "half way: to even";
    EXPECT_EQ(roundTrip(2047.6f), 2048.0f) << "carries into the exponent";
    EXPECT_EQ(roundTrip(0x1p-26f), 0.0f);
    EXPECT_TRUE(std::isinf(roundTrip(70000.0f)));
    EXPECT_TRUE(std::isnan(roundTrip(NAN)));
    EXPECT_TRUE(std::signbit(roundTrip(-0.0f)));
}

TEST(Texels, SizesThatDisagree_AreRefused) {
    EXPECT_THROW(EncodeTexels(std::vector<float>(3), {2, 2}, rhi::Format::R32Float), Error);
    EXPECT_THROW(DecodeTexels(std::vector<std::byte>(3), {2, 2}, rhi::Format::R32Float), Error);
    const Texels texels{.extent = {2, 2}, .channelCount = 1, .values = std::vector<float>(4)};
    EXPECT_THROW(std::ignore = texels.At(2, 0), Error);
}

class Harness : public GraphTest {};

TEST_F(Harness, OnePassAlone_FromValuesToTexels) {
    PassHarness harness(Device());
    AddTestShaders(harness.Graph());
    const Texels texels = harness.Run([](PassHarness& h) {
        const TextureId source = h.Texture("source", {2, 2}, Format::R32Float, {1, 2, 3, 4});
        return Scale(h.Graph(), "scaled", source, 10.0f);
    });
    EXPECT_THAT(texels.values, ElementsAre(10, 20, 30, 40));
    EXPECT_THAT(harness.Plan(), HasSubstr("Scale scaled (compute)"));
}

TEST_F(Harness, SingleTexel_FillsTheTexture) {
    PassHarness harness(Device());
    const Texels texels = harness.Run([](PassHarness& h) {
        return h.Texture("gray", {3, 1}, Format::Rgba8Unorm, {1, 0, 1, 0});
    });
    EXPECT_THAT(texels.values, ElementsAre(1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0));
}

TEST_F(Harness, Buffers_GoInAndOut) {
    PassHarness harness(Device());
    const std::vector<uint32_t> words{1, 2, 3};
    EXPECT_EQ(harness.RunBuffer<uint32_t>([&](PassHarness& h) { return h.Buffer("words", words); }), words);
}

TEST_F(Harness, PersistentTextures_GoOnFromRunToRun) {
    PassHarness harness(Device());
    AddTestShaders(harness.Graph());
    Texels texels;
    for (int run = 0; run < 3; ++run)
        texels = harness.Run([](PassHarness& h) {
            return AddTo(h.Graph(), "sum", h.Texture("one", {2, 1}, Format::R32Float, {1, 2}));
        });
    EXPECT_THAT(texels.values, ElementsAre(3, 6));
}

TEST_F(Harness, RunAfterAnError_StartsClean) {
    PassHarness harness(Device());
    EXPECT_THROW(harness.Run([](PassHarness&) { return TextureId{}; }), Error);
    EXPECT_THAT(harness.Run([](PassHarness& h) {
                           return h.Texture("a", {1, 1}, Format::R32Float, {4});
                       })
                    .values,
                ElementsAre(4));
}

}  // namespace
}  // namespace raygraph::testing::pass_harness_test
