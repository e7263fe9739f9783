#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <array>

#include "rhi/command_list.h"
#include "rhi/device.h"
#include "rhi/pipeline.h"
#include "rhi/shader_compiler.h"
#include "rhi/texture_table.h"
#include "rhi/transfer.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

// Tests bindless textures: every slot holds something, and changes only when no frame can be reading it.
namespace raygraph::rhi::texture_table_test {
namespace {

constexpr uint32_t kCapacity = 8;

class TextureTableTest : public testing::VulkanTest {
  protected:
    TextureTableTest() {
        m_words = CompileGlsl({.name = "sample.comp",
                               .text = R"(#version 460
            #extension GL_EXT_nonuniform_qualifier : require
            layout(local_size_x = 8) in;
            layout(set = 1, binding = 0) uniform sampler2D textures[];
            layout(set = 0, binding = 0) writeonly buffer Colors { vec4 colors[]; };
            void main() {
                uint i = gl_GlobalInvocationID.x;
                colors[i] = textureLod(textures[nonuniformEXT(i)], vec2(0.5), 0.0);
            })",
                               .stage = {},
                               .includeRoot = {}});
        m_pipeline = CreateComputePipeline(Device(), {.name = "sample", .shader = {"sample.comp", m_words}});
        m_sampler = Device().CreateSampler({.name = "nearest"});
        m_default = Solid(1, 0, 1);
        m_table = std::make_unique<TextureTable>(Device(), kCapacity, m_default, m_sampler);
    }

    Texture Solid(uint8_t r, uint8_t g, uint8_t b) {
        Texture texture =
            Device().CreateTexture({.name = "solid", .extent = {2, 2}, .format = Format::Rgba8Unorm});
        std::vector<std::byte> texels;
        for (int i = 0; i < 4; ++i)
            for (uint8_t c : {r, g, b, uint8_t{1}}) texels.push_back(static_cast<std::byte>(c * 255));
        Uploader uploader(Device());
        uploader.UploadTexture(texture, texels);
        uploader.Flush();
        return texture;
    }

    // Returns red, green and blue of every slot, as "rgb" with 0 and 1.
    std::vector<std::string> Slots() {
        const Buffer colors =
            Device().CreateBuffer({.name = "colors",
                                   .size = kCapacity * 16,
                                   .usage = BufferUsage::Storage | BufferUsage::CopySource});
        CommandList commands = Device().BeginCommands("sample");
        RecordSampling(commands, colors);
        Device().WaitFor(Device().Submit(std::move(commands)));
        return Names(colors);
    }

    void RecordSampling(CommandList& commands, const Buffer& colors) {
        commands.Bind(m_pipeline);
        const BoundResource resource{
            .binding = 0, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .buffer = &colors};
        commands.BindResources({&resource, 1});
        commands.BindTextures(*m_table);
        commands.Dispatch(1);
    }

    std::vector<std::string> Names(const Buffer& colors) {
        const std::vector<std::byte> bytes = ReadBuffer(Device(), colors);
        const std::vector<float> values = testing::As<float>(bytes);
        std::vector<std::string> names;
        for (size_t i = 0; i < values.size(); i += 4) {
            names.emplace_back();
            for (size_t c = 0; c < 3; ++c) names.back() += values[i + c] > 0.5f ? '1' : '0';
        }
        return names;
    }

    std::vector<uint32_t> m_words;
    ComputePipeline m_pipeline;
    Sampler m_sampler;
    Texture m_default;
    std::unique_ptr<TextureTable> m_table;
};

TEST_F(TextureTableTest, SlotsThatWereNeverGivenOutHoldTheDefault) {
    EXPECT_TRUE(m_pipeline.UsesTextureTable());
    EXPECT_EQ(Slots(), std::vector<std::string>(kCapacity, "101"));
    EXPECT_EQ(m_table->Capacity(), kCapacity);
    EXPECT_EQ(m_table->Count(), 0u);
}

TEST_F(TextureTableTest, AddedTexturesAreSeenInTheirSlots) {
    const Texture red = Solid(1, 0, 0);
    const Texture green = Solid(0, 1, 0);
    const uint32_t redSlot = m_table->Add(red, m_sampler);
    const uint32_t greenSlot = m_table->Add(green, m_sampler);
    EXPECT_NE(redSlot, greenSlot);
    EXPECT_EQ(m_table->Count(), 2u);
    std::vector<std::string> expected(kCapacity, "101");
    expected[redSlot] = "100";
    expected[greenSlot] = "010";
    EXPECT_EQ(Slots(), expected);
}

TEST_F(TextureTableTest, RemovedTextureMayBeDestroyedAndItsSlotGoesBackToTheDefault) {
    uint32_t slot = 0;
    {
        const Texture red = Solid(1, 0, 0);
        slot = m_table->Add(red, m_sampler);
        EXPECT_EQ(Slots()[slot], "100");
        m_table->Remove(slot);
    }
    EXPECT_EQ(Slots()[slot], "101");
    EXPECT_EQ(m_table->Count(), 0u);
}

TEST_F(TextureTableTest, SlotIsNotGivenOutAgainWhileAListThatMayReadItIsOpen) {
    const Texture red = Solid(1, 0, 0);
    const Texture green = Solid(0, 1, 0);
    const Buffer colors = Device().CreateBuffer(
        {.name = "colors", .size = kCapacity * 16, .usage = BufferUsage::Storage | BufferUsage::CopySource});
    const uint32_t redSlot = m_table->Add(red, m_sampler);

    CommandList commands = Device().BeginCommands("frame");
    RecordSampling(commands, colors);
    m_table->Remove(redSlot);
    const uint32_t greenSlot =
        m_table->Add(green, m_sampler);  // update after bind, for a slot that was free before
    EXPECT_NE(greenSlot, redSlot);
    Device().WaitFor(Device().Submit(std::move(commands)));
    EXPECT_EQ(Names(colors)[redSlot], "100") << "the frame saw what it was recorded with";
    EXPECT_EQ(Slots()[redSlot], "101");
    EXPECT_EQ(Slots()[greenSlot], "010");
}

TEST_F(TextureTableTest, FullTableAndWrongSlotsAreRefused) {
    const Texture red = Solid(1, 0, 0);
    std::vector<uint32_t> slots;
    for (uint32_t i = 0; i < kCapacity; ++i) slots.push_back(m_table->Add(red, m_sampler));
    EXPECT_EQ(testing::ErrorTextOf([&] { (void)m_table->Add(red, m_sampler); }),
              "texture table: all 8 slots are taken, no room for 'solid'");
    m_table->Remove(slots[3]);
    EXPECT_EQ(testing::ErrorTextOf([&] { m_table->Remove(slots[3]); }),
              "texture table: slot 3 holds no texture");
    EXPECT_EQ(testing::ErrorTextOf([&] { m_table->Remove(kCapacity); }),
              "texture table: slot 8 holds no texture");
    Device().WaitIdle();
    Device().CollectGarbage();
    EXPECT_EQ(testing::ErrorTextOf([&] { slots[3] = m_table->Add(red, m_sampler); }), "accepted");
    EXPECT_EQ(slots[3], 3u);
    EXPECT_EQ(testing::ErrorTextOf([&] { TextureTable(Device(), 0, m_default, m_sampler); }),
              "texture table: capacity is 0, 1 to 65536 are possible");
}

TEST_F(TextureTableTest, LargestTableCanBeMade) {
    const TextureTable large(Device(), kMaxTextureTableSlots, m_default, m_sampler);
    EXPECT_EQ(large.Capacity(), kMaxTextureTableSlots);
}

}  // namespace
}  // namespace raygraph::rhi::texture_table_test

// Tests textures with levels and layers: limits, views, and commands on one level of one layer.
namespace raygraph::testing::subresources_test {
namespace {

using rhi::CommandList;
using rhi::Format;
using rhi::ImageShape;
using rhi::Layer;
using rhi::Layers;
using rhi::Level;
using rhi::Subresource;
using rhi::TextureUsage;
using ::testing::Each;
using ::testing::HasSubstr;

constexpr TextureUsage kCopies = TextureUsage::CopySource | TextureUsage::CopyDestination;
constexpr VkImageLayout kSource = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
constexpr VkImageLayout kTarget = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;

class SubresourcesTest : public VulkanTest {
  protected:
    // Makes 8x8 texels with four levels.
    static rhi::Texture Make(uint32_t layers, TextureUsage usage = kCopies | TextureUsage::Sampled) {
        return Device().CreateTexture({.name = "faces",
                                       .extent = {8, 8},
                                       .format = Format::R32Float,
                                       .usage = usage,
                                       .mipLevels = 4,
                                       .layers = layers});
    }
};

TEST_F(SubresourcesTest, LayersBeyondTheDevices_AreRefused) {
    const uint32_t most = Device().Info().maxTextureLayers;
    EXPECT_EQ(std::string(ErrorOf([&] { Make(most + 1); }).what()),
              "texture 'faces' (8x8 r32f): " + std::to_string(most + 1) + " layers, possible are 1 to " +
                  std::to_string(most));
    EXPECT_THAT(ErrorOf([] { Make(0); }).what(), HasSubstr("0 layers"));
}

TEST_F(SubresourcesTest, ViewOfAPart_IsMadeOnce) {
    const rhi::Texture texture = Make(6);
    const VkImageView level = texture.View(Level(1), ImageShape::Array);
    EXPECT_NE(level, VK_NULL_HANDLE);
    EXPECT_EQ(texture.View(Level(1), ImageShape::Array), level);
    EXPECT_EQ(texture.View({.level = 1, .levelCount = 1}, ImageShape::Array), level);
    EXPECT_NE(texture.View(Level(2), ImageShape::Array), level);
    const VkImageView cube = texture.View(Level(1), ImageShape::Cube);
    EXPECT_NE(cube, level);
    EXPECT_EQ(texture.View(Layers(0, 6), ImageShape::Array), texture.View()) << "all of it";
    EXPECT_EQ(texture.View(Level(1), ImageShape::Cube), cube);
}

TEST_F(SubresourcesTest, ViewsMoveWithTheTexture) {
    rhi::Texture texture = Make(2);
    const VkImageView view = texture.View(Layer(1), ImageShape::Plain);
    const rhi::Texture moved = std::move(texture);
    EXPECT_EQ(moved.View(Layer(1), ImageShape::Plain), view);
}

TEST_F(SubresourcesTest, ViewThatTheTextureDoesNotHave_IsRefused) {
    const rhi::Texture texture = Make(6);
    const auto text = [&](const rhi::Subresources& part, ImageShape shape) {
        return std::string(ErrorOf([&] { std::ignore = texture.View(part, shape); }).what());
    };
    EXPECT_EQ(text(Level(4), ImageShape::Array),
              "texture 'faces' (8x8 r32f): a view as array of 2D images: level 4, there are 4");
    EXPECT_EQ(text(Layers(5, 2), ImageShape::Array),
              "texture 'faces' (8x8 r32f): a view as array of 2D images: layers 5-6, there are 6");
    EXPECT_EQ(text(Level(0), ImageShape::Plain),
              "texture 'faces' (8x8 r32f): a view as 2D image: 6 layers, it takes 1");
    EXPECT_EQ(text(Layers(0, 5), ImageShape::Cube),
              "texture 'faces' (8x8 r32f): a view as cube map: 5 layers of 8x8, it takes 6 square ones");
}

TEST_F(SubresourcesTest, ClearsAndCopies_ReachTheirLevelOfTheirLayerAlone) {
    const rhi::Texture source = Make(3), target = Make(3);
    const rhi::Buffer buffer = Device().CreateBuffer(
        {.name = "b", .size = 64, .usage = rhi::BufferUsage::CopySource | rhi::BufferUsage::CopyDestination});
    CommandList commands = Device().BeginCommands("parts");
    commands.Transition(source, VK_IMAGE_LAYOUT_UNDEFINED, kTarget);
    commands.Transition(target, VK_IMAGE_LAYOUT_UNDEFINED, kTarget);
    commands.Clear(source, {1.0f, 0.0f, 0.0f, 0.0f});
    commands.Clear(target, {2.0f, 0.0f, 0.0f, 0.0f});
    commands.FullBarrier();
    commands.Clear(source, {3.0f, 0.0f, 0.0f, 0.0f}, Subresource(1, 2));
    commands.Transition(source, kTarget, kSource);
    // Copies the 4x4 level 1 of layer 2 to that of layer 0, and through a buffer to level 1 of layer 1.
    commands.CopyTexture(source, {.level = 1, .layer = 2}, target, {.level = 1, .layer = 0});
    commands.CopyToBuffer(source, buffer, 0, 1, 2);
    commands.FullBarrier();
    commands.CopyToTexture(buffer, 0, target, 1, 1);
    Device().Submit(std::move(commands));
    for (uint32_t layer = 0; layer < 3; ++layer)
        for (uint32_t level = 0; level < 4; ++level) {
            const std::vector<float> of =
                As<float>(rhi::ReadTexture(Device(), target, kTarget, level, layer));
            EXPECT_EQ(of.size(), size_t{8u >> level} * (8u >> level));
            EXPECT_THAT(of, Each(level == 1 && layer < 2 ? 3.0f : 2.0f)) << level << ' ' << layer;
            EXPECT_THAT(As<float>(rhi::ReadTexture(Device(), source, kSource, level, layer)),
                        Each(level == 1 && layer == 2 ? 3.0f : 1.0f))
                << level << ' ' << layer;
        }
}

TEST_F(SubresourcesTest, CommandsBeyondTheTexture_AreRefused) {
    const rhi::Texture texture = Make(2);
    const rhi::Buffer buffer = Device().CreateBuffer({.name = "b", .size = 256});
    CommandList commands = Device().BeginCommands("parts");
    const auto text = [&](auto&& run) { return std::string(ErrorOf(run).what()); };
    EXPECT_THAT(text([&] { commands.CopyToBuffer(texture, buffer, 0, 0, 2); }), HasSubstr("layer 2 of 2"));
    EXPECT_THAT(text([&] { commands.CopyToTexture(buffer, 0, texture, 40); }),
                HasSubstr("mip level 40 of 4"));
    EXPECT_EQ(text([&] { commands.CopyTexture(texture, {.layer = 2}, texture, {.layer = 1}); }),
              "CopyTexture: from 'faces' (8x8 r32f) to 'faces' (8x8 r32f): layer 2 of 2 of 'faces'");
    EXPECT_EQ(text([&] { commands.CopyTexture(texture, {.level = 1}, texture, {.level = 2}); }),
              "CopyTexture: 'faces' (8x8 r32f) does not fit 'faces' (8x8 r32f): level 1 is 4x4, level 2 is "
              "2x2");
    EXPECT_EQ(text([&] {
                  commands.Clear(texture, {0, 0, 0, 0}, Level(4));
              }),
              "Clear: 'faces' (8x8 r32f): level 4, there are 4");
    EXPECT_THAT(text([&] { rhi::ReadTexture(Device(), texture, kSource, 0, 2); }),
                HasSubstr("layer 2, it has 2"));
}

TEST_F(SubresourcesTest, TexturesOfSeveralLayers_AreNoBindlessOnesAndNotUploaded) {
    const rhi::Texture one = Make(1), texture = Make(2);
    const rhi::Sampler sampler = Device().CreateSampler({});
    rhi::TextureTable table(Device(), 4, one, sampler);
    EXPECT_EQ(std::string(ErrorOf([&] { std::ignore = table.Add(texture, sampler); }).what()),
              "texture table: 'faces' has 2 layers, its shaders see one");
    rhi::Uploader uploader(Device());
    const std::vector<std::byte> bytes(256);
    const std::array<std::span<const std::byte>, 1> levels{std::span(bytes)};
    EXPECT_THAT(ErrorOf([&] { uploader.UploadTexture(texture, levels); }).what(),
                HasSubstr("it has 2 layers, an upload is for one"));
}

}  // namespace
}  // namespace raygraph::testing::subresources_test
