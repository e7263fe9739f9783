// A picture made in tiles has the bits of one made whole.
#include "passes/tiles.h"

#include "base/error.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::tiles_test {

using passes::Region;
using passes::TileCursor;

TEST(TileCursorTest, Tiles_CoverEveryPixelOnceWhateverTheirSize) {
    for (const Extent2D picture : {Extent2D{1, 1}, {7, 1}, {1, 40}, {37, 29}, {64, 64}})
        for (const uint64_t step : {1ull, 5ull, 36ull, 37ull, 100ull, 1000000ull}) {
            std::vector<int> seen(size_t{picture.width} * picture.height);
            TileCursor cursor;
            uint64_t pixels = step, done = 0;
            bool isLast = false;
            while (!isLast) {
                const Region tile = cursor.Next(picture, pixels);
                ASSERT_FALSE(tile.IsEmpty());
                ASSERT_LE(tile.x + tile.width, picture.width);
                ASSERT_LE(tile.y + tile.height, picture.height);
                ASSERT_TRUE(cursor.IsNext(picture, tile));
                for (uint32_t y = tile.y; y < tile.y + tile.height; ++y)
                    for (uint32_t x = tile.x; x < tile.x + tile.width; ++x) {
                        EXPECT_FALSE(cursor.Has(x, y));
                        seen[size_t{y} * picture.width + x]++;
                    }
                isLast = cursor.Advance(picture, tile);
                done += tile.PixelCount();
                if (!isLast) {
                    EXPECT_EQ(cursor.PixelCount(picture), done);
                    EXPECT_TRUE(cursor.Has(tile.x, tile.y));
                }
                pixels = pixels * 3 % 97 + step;  // from tile to tile, another size
            }
            EXPECT_TRUE(cursor.IsAtStart());
            EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), std::ssize(seen));
        }
}

TEST(TileCursorTest, Tiles_HoldAboutAsManyPixelsAsAskedFor) {
    const Extent2D picture{1920, 1080};
    TileCursor cursor;
    EXPECT_EQ(cursor.Next(picture, 5000).PixelCount(), 3840u);
    const Region part = cursor.Next(picture, 500);
    EXPECT_EQ(part.PixelCount(), 496u);
    cursor.Advance(picture, part);
    EXPECT_LE(cursor.Next(picture, 1 << 20).PixelCount(), 8u * 1920u);
    EXPECT_FALSE(cursor.IsNext(picture, {0, 0, 1920, 1080}));
}

namespace {

class Tiles : public VulkanTest {
  protected:
    Tiles() { render.scene.SetScene(Boxes()); }

    static passes::TraceSettings Settings() {
        passes::TraceSettings settings = LookAt({-0.8f, 0.1f, 0.3f}, {1.0f, -0.5f, 0.0f}, 1.2f, 1);
        settings.extent = kPicture;
        return settings;
    }
    struct Means {
        FloatImage mean, variance;
    };
    // Two samples, in tiles of about so many pixels.
    Means TwoSamples(uint64_t pixels) {
        passes::Accumulation accumulation("tiles");
        Readback mean;
        while (accumulation.SampleCount() < 2) {
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            // Two tiles a frame: the second begins where the first ends
            passes::AccumulatedIds taken;
            for (int i = 0; i < 2; ++i) {
                const passes::Accumulation::Progress at = accumulation.Declared();
                if (at.sampleCount == 2) break;
                passes::TraceSettings settings = Settings();
                settings.sampleIndex = at.sampleCount;
                settings.region = at.cursor.Next(kPicture, pixels);
                const TextureId tile = passes::Trace(render.renderer, ids, settings).radiance;
                taken = passes::AccumulateTile(render.renderer, tile, kPicture, settings.region, accumulation,
                                               true);
            }
            mean = render.renderer.ReadBack(taken.mean);
            render.renderer.Execute();
        }
        render.renderer.BeginFrame();
        const Readback variance =
            render.renderer.ReadBack(passes::Resolve(render.renderer, accumulation, kPicture, true).variance);
        render.renderer.Execute();
        return {ToFloatImage(mean), ToFloatImage(variance)};
    }

    static constexpr Extent2D kPicture{29, 19};
    SceneRender render{Device()};
};

}  // namespace

TEST_F(Tiles, SamplesInTiles_HaveTheBitsOfWholeOnes) {
    const Means whole = TwoSamples(1 << 20), rows = TwoSamples(100), parts = TwoSamples(20);
    EXPECT_EQ(rows.mean.values, whole.mean.values);
    EXPECT_EQ(rows.variance.values, whole.variance.values);
    EXPECT_EQ(parts.mean.values, whole.mean.values);
    EXPECT_EQ(parts.variance.values, whole.variance.values);
    EXPECT_GT(whole.variance.Mean().x, 0.0);
}

TEST_F(Tiles, PrimaryHitsOfARegion_AreThoseOfThePicture) {
    const SceneRender::Hits whole = render.PrimaryHits(Settings());
    passes::TraceSettings settings = Settings();
    settings.region = {11, 7, 3, 2};
    const SceneRender::Hits part = render.PrimaryHits(settings);
    ASSERT_EQ(part.ids.size(), 6u);
    for (uint32_t y = 0; y < 2; ++y)
        for (uint32_t x = 0; x < 3; ++x) {
            EXPECT_EQ(part.ids[y * 3 + x], whole.ids[(y + 7) * kPicture.width + x + 11]);
            EXPECT_EQ(part.position.At(x, y), whole.position.At(x + 11, y + 7));
        }
}

TEST_F(Tiles, WhatDoesNotFit_IsRefused) {
    passes::TraceSettings settings = Settings();
    settings.region = {20, 0, 10, 1};
    EXPECT_THROW(render.TraceOnce(settings), Error);

    passes::Accumulation accumulation("tiles");
    render.renderer.BeginFrame();
    const TextureId tile = render.renderer.CreateTexture("tile", {{29, 4}, Format::Rgba32Float});
    // Not what comes first, and not of the region's size
    EXPECT_THROW(
        std::ignore = passes::AccumulateTile(render.renderer, tile, kPicture, {0, 4, 29, 4}, accumulation),
        Error);
    EXPECT_THROW(
        std::ignore = passes::AccumulateTile(render.renderer, tile, kPicture, {0, 0, 29, 3}, accumulation),
        Error);
}

}  // namespace raygraph::testing::tiles_test
