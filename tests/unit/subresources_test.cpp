// Tests parts of textures: what they resolve to, what is missing, how they are written.
#include "rhi/subresources.h"

#include <gtest/gtest.h>

namespace raygraph::rhi::subresources_test {
namespace {

TEST(Subresources, Default_IsAllOfTheTexture) {
    EXPECT_EQ(Resolved({}, 5, 6), (Subresources{.level = 0, .levelCount = 5, .layer = 0, .layerCount = 6}));
    EXPECT_EQ(PartText(Resolved({}, 5, 6), 5, 6), "");
}

TEST(Subresources, LevelsAreThoseOfAllLayers_LayersThoseOfAllLevels) {
    EXPECT_EQ(Resolved(Level(2), 5, 6),
              (Subresources{.level = 2, .levelCount = 1, .layer = 0, .layerCount = 6}));
    EXPECT_EQ(Resolved(Layers(1, 3), 5, 6),
              (Subresources{.level = 0, .levelCount = 5, .layer = 1, .layerCount = 3}));
    EXPECT_EQ(Resolved({.level = 3}, 5, 6).levelCount, 2u) << "the rest from the third on";
}

TEST(Subresources, Text_NamesWhatIsNotAll) {
    const auto text = [](const Subresources& part) { return PartText(Resolved(part, 5, 6), 5, 6); };
    EXPECT_EQ(text(Level(2)), " level 2");
    EXPECT_EQ(text(Levels(1, 3)), " levels 1-3");
    EXPECT_EQ(text(Layers(2, 2)), " layers 2-3");
    EXPECT_EQ(text(Subresource(4, 1)), " level 4 layer 1");
    EXPECT_EQ(PartText(Resolved(Level(0), 1, 1), 1, 1), "") << "there is no other";
}

TEST(Subresources, WhatIsNotThere_IsNamedWithWhatIs) {
    const auto missing = [](const Subresources& part) { return DescribeMissing(Resolved(part, 5, 1), 5, 1); };
    EXPECT_EQ(missing(Level(4)), "");
    EXPECT_EQ(missing({}), "");
    EXPECT_EQ(missing(Level(5)), "level 5, there are 5");
    EXPECT_EQ(missing({.level = 7}), "level 7, there are 5");
    EXPECT_EQ(missing(Levels(3, 3)), "levels 3-5, there are 5");
    EXPECT_EQ(missing(Levels(1, ~0u - 1)).substr(0, 9), "levels 1-") << "no overflow";
    EXPECT_EQ(missing(Layer(1)), "layer 1, there is 1");
    EXPECT_EQ(missing(Levels(0, 0)), "no level");
}

TEST(Subresources, PartsOverlap_WhereTheyShareALevelOfALayer) {
    const auto overlap = [](const Subresources& a, const Subresources& b) {
        const bool found = Overlap(Resolved(a, 5, 6), Resolved(b, 5, 6));
        EXPECT_EQ(found, Overlap(Resolved(b, 5, 6), Resolved(a, 5, 6)));
        return found;
    };
    EXPECT_TRUE(overlap({}, Subresource(4, 5)));
    EXPECT_TRUE(overlap(Level(2), Layer(3)));
    EXPECT_FALSE(overlap(Level(2), Levels(3, 2)));
    EXPECT_FALSE(overlap(Layers(0, 3), Layer(3)));
    EXPECT_FALSE(overlap(Subresource(1, 1), Subresource(1, 2)));
}

}  // namespace
}  // namespace raygraph::rhi::subresources_test
