// Tests bindless textures: every slot holds something, and changes only when no frame can be reading it.
#include "rhi/texture_table.h"

#include <gtest/gtest.h>

#include <array>

#include "rhi/command_list.h"
#include "rhi/compute_pipeline.h"
#include "rhi/device.h"
#include "rhi/readback.h"
#include "rhi/shader_compiler.h"
#include "rhi/upload.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

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
