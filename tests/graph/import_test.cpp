// A host's images in and out: layouts, semaphores, states over frames.
#include <gmock/gmock.h>

#include "rhi/readback.h"
#include "tests/graph/graph_test.h"
#include "tests/rhi/fake_loader.h"
#include "tests/support/error_of.h"

namespace raygraph::import_test {
namespace {

using ::testing::HasSubstr;

constexpr Extent2D kExtent{24, 10};

class Import : public GraphTest {
  protected:
    rhi::Texture HostTexture() {
        return Device().CreateTexture({.name = "host",
                                       .extent = kExtent,
                                       .format = Format::R32Float,
                                       .usage = rhi::TextureUsage::Storage | rhi::TextureUsage::Sampled |
                                                rhi::TextureUsage::CopySource |
                                                rhi::TextureUsage::CopyDestination});
    }
    testing::Texels TexelsOf(const rhi::Texture& texture, VkImageLayout layout) {
        return testing::DecodeTexels(rhi::ReadTexture(Device(), texture, layout), kExtent, Format::R32Float);
    }
};

TEST_F(Import, ExportedTexture_IsLeftInTheLayoutAskedFor) {
    const rhi::Texture host = HostTexture();
    ResourceState state;
    for (const VkImageLayout layout :
         {VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_GENERAL,
          VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL}) {
        m_renderer.BeginFrame();
        m_renderer.Export(FillInto(m_renderer, "Fill", m_renderer.Import("host", host, state), 7.0f), layout);
        m_renderer.Execute();
        EXPECT_EQ(state.layout, layout);
        EXPECT_TRUE(IsRamp(TexelsOf(host, layout), 7.0f));
    }
}

TEST_F(Import, PresentedAndTouchedByNoPass_IsReadable) {
    const rhi::Texture host = HostTexture();
    rhi::CommandList commands = Device().BeginCommands("host");
    commands.Transition(host, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    commands.Clear(host, {5.0f, 0.0f, 0.0f, 0.0f});
    Device().Submit(std::move(commands));
    ResourceState state{.writeStages = VK_PIPELINE_STAGE_2_CLEAR_BIT,
                        .writeAccess = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                        .layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
    m_renderer.BeginFrame();
    m_renderer.Present(m_renderer.Import("host", host, state));
    m_renderer.Execute();
    EXPECT_EQ(state.layout, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    EXPECT_EQ(TexelsOf(host, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL).At(3, 2)[0], 5.0f);
}

// The host fills the image in a submission of its own, signals a semaphore, and waits for ours.
TEST_F(Import, Semaphores_OrderTheHostsWorkAroundTheFrame) {
    rhi::Device& device = Device();
    const rhi::Texture host = HostTexture();
    VkSemaphoreTypeCreateInfo type{};
    type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
    type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
    VkSemaphore semaphore = VK_NULL_HANDLE;
    ASSERT_EQ(device.Vk().vkCreateSemaphore(device.Handle(), &info, nullptr, &semaphore), VK_SUCCESS);

    rhi::CommandList commands = device.BeginCommands("host");
    commands.Transition(host, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    commands.Clear(host, {5.0f, 0.0f, 0.0f, 0.0f});
    const rhi::SemaphoreUse hostDone{semaphore, 1};
    device.Submit(std::move(commands), {}, std::span(&hostDone, 1));

    ResourceState state{.layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
    m_renderer.BeginFrame();
    m_renderer.WaitSemaphore(hostDone);
    m_renderer.SignalSemaphore({semaphore, 2});
    const TextureId image = m_renderer.Import("host", host, state);
    const Readback readback = m_renderer.ReadBack(Scale(m_renderer, "scaled", image, 2.0f));
    m_renderer.Export(image, VK_IMAGE_LAYOUT_GENERAL);
    m_renderer.Execute();
    EXPECT_THAT(m_renderer.DescribePlan(),
                HasSubstr("host: AllCommands done -> ComputeShader read, CopyTarget -> General\n"));
    const testing::Texels texels = Read(readback);
    EXPECT_EQ(texels.At(0, 0)[0], 10.0f);
    EXPECT_EQ(texels.At(kExtent.width - 1, kExtent.height - 1)[0], 10.0f);

    const uint64_t value = 2;
    const VkSemaphoreWaitInfo wait{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO, nullptr, 0, 1, &semaphore, &value};
    EXPECT_EQ(device.Vk().vkWaitSemaphores(device.Handle(), &wait, 5'000'000'000ull), VK_SUCCESS);
    device.WaitIdle();
    device.Vk().vkDestroySemaphore(device.Handle(), semaphore, nullptr);
}

TEST_F(Import, SameObjectTwice_IsOneResource) {
    const rhi::Texture host = HostTexture();
    ResourceState state;
    m_renderer.BeginFrame();
    const TextureId first = FillInto(m_renderer, "Fill", m_renderer.Import("host", host, state), 1.0f);
    EXPECT_EQ(m_renderer.Import("host again", host, state), first);
    ResourceState other;
    EXPECT_THROW(m_renderer.Import("host", host, other), Error);
}

TEST_F(Import, StateIsWrittenBackOnlyByExecute) {
    const rhi::Texture host = HostTexture();
    ResourceState state;
    m_renderer.BeginFrame();
    m_renderer.Present(FillInto(m_renderer, "Fill", m_renderer.Import("host", host, state), 1.0f));
    m_renderer.Compile();
    EXPECT_EQ(state, ResourceState{});
    m_renderer.Execute();
    EXPECT_EQ(state.layout, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
}

TEST_F(Import, TextureMadeWithoutTheUsage_IsRefused) {
    const rhi::Texture host = Device().CreateTexture(
        {.name = "host", .extent = kExtent, .format = Format::R32Float, .usage = rhi::TextureUsage::Sampled});
    ResourceState state;
    m_renderer.BeginFrame();
    const TextureId image = m_renderer.Import("host", host, state);
    EXPECT_EQ(testing::ErrorTextOf([&] { std::ignore = FillInto(m_renderer, "Fill", image, 1.0f); }),
              R"(pass "Fill" uses "host" as storage write, but it was made without that usage)");
}

TEST_F(Import, HostsBuffer_IsReadAndKeepsItsState) {
    const rhi::Buffer host =
        Device().CreateBuffer({.name = "host",
                               .size = 64,
                               .usage = rhi::BufferUsage::CopyDestination | rhi::BufferUsage::CopySource});
    ResourceState state;
    for (uint32_t frame = 0; frame < 4; ++frame) {
        m_renderer.BeginFrame();
        BufferId buffer = m_renderer.Import("host", host, state);
        m_renderer.AddPass(
            "Fill", PassKind::Transfer, [&](PassBuilder& pass) { buffer = pass.CopiesTo(buffer); },
            [buffer, frame](CommandList& commands, const PassResources& resources) {
                commands.Fill(resources.Buffer(buffer), frame);
            });
        const Readback readback = m_renderer.ReadBack(buffer);
        m_renderer.Execute();
        readback.Wait();
        EXPECT_EQ(testing::As<uint32_t>(readback.Bytes()), std::vector<uint32_t>(16, frame));
    }
}

// lavapipe has one queue family: what is recorded is what can be seen of it.
TEST(ImportOfAnotherQueueFamily, BufferIsAcquiredAndReleasedByItsOwnBarriers) {
    testing::FakeLoader loader;
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create({.savePipelineCache = false, .getInstanceProcAddr = loader.Entry()});
    const rhi::Buffer owner =
        device->CreateBuffer({.name = "host", .size = 64, .usage = rhi::BufferUsage::CopyDestination});
    const rhi::Buffer host = device->WrapBuffer(owner.Desc(), owner.Handle());
    const uint32_t ours = device->QueueFamily(), theirs = ours + 1;
    ResourceState state{.queueFamily = theirs};
    {
        Renderer renderer(*device);
        for (int frame = 0; frame < 2; ++frame) {
            loader.Tell().bufferBarriers.clear();
            renderer.BeginFrame();
            BufferId buffer = renderer.Import("host", host, state);
            renderer.AddPass(
                "Fill", PassKind::Transfer, [&](PassBuilder& pass) { buffer = pass.CopiesTo(buffer); },
                [buffer](CommandList& commands, const PassResources& resources) {
                    commands.Fill(resources.Buffer(buffer), 7);
                });
            renderer.Export(buffer, theirs);
            renderer.Execute();
            EXPECT_EQ(state.queueFamily, theirs);
            const std::vector<VkBufferMemoryBarrier2>& barriers = loader.Tell().bufferBarriers;
            ASSERT_EQ(barriers.size(), 2u);
            for (const VkBufferMemoryBarrier2& barrier : barriers) {
                EXPECT_EQ(barrier.buffer, owner.Handle());
                EXPECT_EQ(barrier.offset, 0u);
                EXPECT_EQ(barrier.size, VK_WHOLE_SIZE);
            }
            EXPECT_EQ(barriers[0].srcQueueFamilyIndex, theirs);
            EXPECT_EQ(barriers[0].dstQueueFamilyIndex, ours);
            EXPECT_EQ(barriers[1].srcQueueFamilyIndex, ours);
            EXPECT_EQ(barriers[1].dstQueueFamilyIndex, theirs);
        }
    }
}

}  // namespace
}  // namespace raygraph::import_test
