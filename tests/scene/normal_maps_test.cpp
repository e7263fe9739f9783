// Normal maps that are stored with two channels.
#include <gtest/gtest.h>

#include "tests/scene/gltf_document.h"

namespace raygraph::test::normal_maps_test {
namespace {

using Texels = std::vector<uint8_t>;

// Returns the imported texels of an image of two texels that a material uses in this way.
Texels Imported(const Texels& texels, const Json& material) {
    GltfDocument document;
    document.Add("images", {{"uri", DataUri(MakePngOf(2, 1, texels))}});
    document.Add("textures", {{"source", 0}});
    document.AddTriangle()["material"] = document.AddMaterial(material);
    return Load(document).images.at(0).rgba;
}

const Texels kTwoChannels{128, 128, 0, 255, 204, 76, 0, 255};
const Json kTexture{{"index", 0}};

TEST(NormalMaps, ThirdChannelIsMadeWhereThereIsNone) {
    // (0, 0) points up: 255; (0.6, -0.404): z = sqrt(1 - 0.36 - 0.1631) = 0.6905 is 216 of 255
    const Texels complete{128, 128, 255, 255, 204, 76, 216, 255};
    EXPECT_EQ(Imported(kTwoChannels, {{"normalTexture", kTexture}}), complete);
    const Json coat{{"extensions", {{"KHR_materials_clearcoat", {{"clearcoatNormalTexture", kTexture}}}}}};
    EXPECT_EQ(Imported(kTwoChannels, coat), complete);
}

TEST(NormalMaps, OthersStayAsTheyAre) {
    EXPECT_EQ(Imported(kTwoChannels, {{"emissiveTexture", kTexture}}), kTwoChannels);
    EXPECT_EQ(Imported(kTwoChannels, {{"normalTexture", kTexture}, {"occlusionTexture", kTexture}}),
              kTwoChannels);
    const Texels threeChannels{128, 128, 0, 255, 204, 76, 1, 255};
    EXPECT_EQ(Imported(threeChannels, {{"normalTexture", kTexture}}), threeChannels);
    // Longer than a unit: it lies in the surface
    EXPECT_EQ(Imported({255, 255, 0, 255, 128, 128, 0, 255}, {{"normalTexture", kTexture}}),
              (Texels{255, 255, 128, 255, 128, 128, 255, 255}));
}

}  // namespace
}  // namespace raygraph::test::normal_maps_test
