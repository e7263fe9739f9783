// Which levels of textures go to the device, and how theirs are made: plans, without a device.
#include "renderer/gpu_scene/materials/texture_plan.h"

#include <gmock/gmock.h>

#include "renderer/gpu_scene/materials/texture_uses.h"

namespace raygraph::testing::texture_plan_test {

namespace {

using scene::Material;
using ::testing::ElementsAre;

constexpr uint64_t kMiB = uint64_t{1} << 20;

std::vector<TextureSizes> Textures(std::initializer_list<rhi::Extent2D> extents, bool makesMipLevels) {
    std::vector<TextureSizes> sizes;
    for (const rhi::Extent2D extent : extents) sizes.push_back(PlainTextureSizes(extent, makesMipLevels));
    return sizes;
}

std::vector<uint64_t> Bytes(const TextureSizes& sizes) {
    std::vector<uint64_t> bytes;
    for (const TextureChoice& choice : sizes.choices) bytes.push_back(choice.bytes);
    return bytes;
}
std::vector<uint32_t> FirstLevels(const TexturePlan& plan) {
    std::vector<uint32_t> levels;
    for (const TextureChoice& choice : plan.choices) levels.push_back(choice.firstLevel);
    return levels;
}

scene::TextureRef Ref(int32_t texture) {
    return {.texture = texture};
}

std::vector<TextureUse> UsesOf(const std::vector<Material>& materials, size_t textureCount) {
    scene::SceneData scene;
    scene.materials = materials;
    scene.textures.resize(textureCount);
    return TextureUses(scene);
}

Material RoughAndBent() {
    Material material;
    material.metallicRoughnessTexture = Ref(0);
    material.normalTexture = Ref(1);
    material.normalScale = 0.5f;
    material.roughnessFactor = 0.75f;
    return material;
}

}  // namespace

TEST(TexturePlan, SizesAreThoseOfTheLevelsThatAreLeft) {
    EXPECT_THAT(Bytes(PlainTextureSizes({5, 2}, false)), ElementsAre(40, 8, 4));
    EXPECT_THAT(Bytes(PlainTextureSizes({5, 2}, true)), ElementsAre(52, 12, 4));
}

TEST(TexturePlan, WhatFitsStaysWhole) {
    const auto textures = Textures({{512, 512}, {1024, 1024}}, false);
    const TexturePlan plan = PlanTextures(textures, 5 * kMiB);
    EXPECT_THAT(FirstLevels(plan), ElementsAre(0, 0));
    EXPECT_EQ(plan.bytes, 5 * kMiB);
    EXPECT_EQ(ReductionText(textures, plan, 5 * kMiB), "");
}

// 4 + 4 + 1 + 4: the first of the large ones goes first, and none a second time before the others had to.
TEST(TexturePlan, TheLargestLoseLevelsFirst) {
    const auto textures = Textures({{1024, 1024}, {1024, 1024}, {512, 512}, {1024, 1024}}, false);
    EXPECT_THAT(FirstLevels(PlanTextures(textures, 13 * kMiB - 1)), ElementsAre(1, 0, 0, 0));
    EXPECT_THAT(FirstLevels(PlanTextures(textures, 9 * kMiB)), ElementsAre(1, 1, 0, 0));
    const TexturePlan plan = PlanTextures(textures, 7 * kMiB / 2);
    EXPECT_THAT(FirstLevels(plan), ElementsAre(2, 1, 0, 1));
    EXPECT_EQ(plan.bytes, 13 * kMiB / 4);
    EXPECT_EQ(ReductionText(textures, plan, 7 * kMiB / 2),
              "3 of 4 textures are smaller on the device, to fit 3.2 MiB into a budget of 3.5 MiB: "
              "2 of 1024x1024 texels are 512x512, 1 of 1024x1024 texels is 256x256");
}

TEST(TexturePlan, NothingIsSmallerThanATexel) {
    const auto textures = Textures({{4, 1}, {1, 1}}, true);
    const TexturePlan plan = PlanTextures(textures, 1);
    EXPECT_THAT(FirstLevels(plan), ElementsAre(2, 0));
    EXPECT_EQ(plan.bytes, 8u);
}

// BC7 of 16 bytes a block: 8x8, 4x4 and no more in the file. One of 2x2 texels of four bytes takes as much as
// a block, and the plain texel less.
TEST(TexturePlan, BlocksShrinkAsFarAsTheirFileHasLevels) {
    const uint64_t levelBytes[] = {64, 16};
    EXPECT_THAT(
        BlockTextureSizes({8, 8}, levelBytes, false).choices,
        ElementsAre(TextureChoice{0, 64, true}, TextureChoice{1, 16, true}, TextureChoice{3, 4, false}));
    EXPECT_THAT(
        BlockTextureSizes({8, 8}, levelBytes, true).choices,
        ElementsAre(TextureChoice{0, 80, true}, TextureChoice{1, 16, true}, TextureChoice{3, 4, false}));
    EXPECT_THAT(
        BlockTextureSizes({8, 8}, std::span(levelBytes).first(1), true).choices,
        ElementsAre(TextureChoice{0, 64, true}, TextureChoice{2, 20, false}, TextureChoice{3, 4, false}));
}

TEST(TextureUses, FollowTheMaterials) {
    Material leaf, plain, bent = RoughAndBent();
    leaf.alphaMode = scene::AlphaMode::Mask;
    leaf.baseColorTexture = Ref(2);
    plain.baseColorTexture = Ref(3);
    scene::SceneData scene;
    scene.materials = {bent, leaf, plain};
    scene.textures.resize(4);
    scene.textures[2].colorSpace = scene.textures[3].colorSpace = scene::ColorSpace::Srgb;
    std::vector<TextureUse> uses = TextureUses(scene);
    EXPECT_EQ(uses[0].content, TexelContent::Data);
    EXPECT_EQ(uses[1].content, TexelContent::Normals);
    EXPECT_EQ(uses[2].content, TexelContent::TransparentColor);
    EXPECT_EQ(uses[3].content, TexelContent::Color);
    ASSERT_TRUE(uses[0].normals);
    EXPECT_EQ(*uses[0].normals, (PairedNormals{1, 0.5f, 0.75f}));
    // Shown opaque elsewhere, or emitted: all texels count
    scene.materials[2].baseColorTexture = Ref(2);
    EXPECT_EQ(TextureUses(scene)[2].content, TexelContent::Color);
    scene.materials[2].baseColorTexture = {};
    scene.materials[2].emissiveTexture = Ref(2);
    EXPECT_EQ(TextureUses(scene)[2].content, TexelContent::Color);
}

TEST(TextureUses, RoughnessIsWidenedOnlyByNormalsThatAllItsMaterialsShare) {
    const Material bent = RoughAndBent();
    Material same = bent, other = bent, flat = bent, moved = bent, smooth = bent;
    same.metallicFactor = 0.0f;
    other.normalScale = 1.0f;
    flat.normalTexture = {};
    moved.normalTexture.transform.offset.x = 0.5f;
    smooth.roughnessFactor = 0.0f;
    EXPECT_TRUE(UsesOf({bent, same}, 2)[0].normals);
    EXPECT_FALSE(UsesOf({bent, other}, 2)[0].normals);
    EXPECT_FALSE(UsesOf({bent, flat}, 2)[0].normals);
    EXPECT_FALSE(UsesOf({flat, bent}, 2)[0].normals);
    EXPECT_FALSE(UsesOf({moved}, 2)[0].normals);
    EXPECT_FALSE(UsesOf({smooth}, 2)[0].normals);
    // Beside a roughness there is often an occlusion, which it does not disturb; a film's thickness is green
    Material occluded = bent, film = bent;
    occluded.occlusionTexture = Ref(0);
    film.iridescenceThicknessTexture = Ref(0);
    EXPECT_TRUE(UsesOf({occluded}, 2)[0].normals);
    EXPECT_FALSE(UsesOf({film}, 2)[0].normals);
}

TEST(TextureUses, NormalsThatAreReadAsSomethingElseTooAreData) {
    Material bent = RoughAndBent();
    bent.specularTexture = Ref(1);
    const std::vector<TextureUse> uses = UsesOf({bent}, 2);
    EXPECT_EQ(uses[1].content, TexelContent::Data);
    EXPECT_FALSE(uses[0].normals);
}

TEST(TextureUses, CoatsHaveNormalsOfTheirOwn) {
    Material coated;
    coated.clearcoatRoughnessTexture = Ref(0);
    coated.clearcoatNormalTexture = Ref(1);
    coated.clearcoatRoughnessFactor = 0.5f;
    coated.normalTexture = Ref(2);
    const std::vector<TextureUse> uses = UsesOf({coated}, 3);
    ASSERT_TRUE(uses[0].normals);
    EXPECT_EQ(*uses[0].normals, (PairedNormals{1, 1.0f, 0.5f}));
}

}  // namespace raygraph::testing::texture_plan_test
