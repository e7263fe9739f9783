// Frames with passes on a compute queue, executed. Where the machine has one queue family, both queues are the
// main one, and the batches of a frame are submitted one after the other.
#include <gmock/gmock.h>

#include "rhi/transfer.h"
#include "tests/graph/graph_test.h"
#include "tests/rhi/gate.h"
#include "tests/rhi/host_device.h"

namespace raygraph::async_compute_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr Extent2D kExtent{32, 16};

struct AsyncCompute : ::testing::Test {
    AsyncCompute() {
        device = rhi::Device::Adopt(host.DescWithQueues());
        renderer.emplace(*device);
        AddShaders(*renderer);
    }
    ~AsyncCompute() override {
        renderer.reset();
        device->WaitQueueIdle();
        device.reset();
        EXPECT_EQ(host.ValidationText(), "");
    }
    static void AddShaders(Renderer& renderer) {
        renderer.AddShader("test/fill.comp", CompileText("test/fill.comp", kFillShader));
        renderer.AddShader("test/scale.comp", CompileText("test/scale.comp", kScaleShader));
        renderer.AddShader("test/add.comp", CompileText("test/add.comp", kAddShader));
    }
    // target = factor * source, on the compute queue if it is asked for.
    TextureId Scale(std::string_view name, TextureId source, TextureId target, float factor, bool isAsync) {
        renderer->AddPass(
            name, PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/scale.comp");
                pass.Reads("source", source);
                target = pass.Writes("target", target);
                pass.Constants(factor);
                if (isAsync) pass.AsyncCompute();
            },
            [](CommandList& commands) { commands.DispatchOver(kExtent); });
        return target;
    }
    TextureId Fill(TextureId target, float value, bool isAsync) {
        renderer->AddPass(
            "Fill", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/fill.comp");
                target = pass.Writes("target", target);
                pass.Constants(value);
                if (isAsync) pass.AsyncCompute();
            },
            [](CommandList& commands) { commands.DispatchOver(kExtent); });
        return target;
    }
    TextureId AddTo(TextureId sum, TextureId source, bool isAsync) {
        const uint32_t isFirst = renderer->IsFresh(sum) ? 1 : 0;
        renderer->AddPass(
            "Add", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/add.comp");
                pass.Reads("source", source);
                sum = pass.Updates("sum", sum);
                pass.Constants(isFirst);
                if (isAsync) pass.AsyncCompute();
            },
            [](CommandList& commands) { commands.DispatchOver(kExtent); });
        return sum;
    }
    TextureId Transient(std::string_view name) {
        return renderer->CreateTexture(name, {.extent = kExtent, .format = Format::R32Float});
    }
    static float At(const Readback& readback, uint32_t x, uint32_t y) {
        readback.Wait();
        return testing::DecodeTexels(readback.Bytes(), readback.Extent(), readback.Format()).At(x, y)[0];
    }

    testing::HostDevice host;
    std::unique_ptr<rhi::Device> device;
    std::optional<Renderer> renderer;
};

// Two chains beside each other, with a sum that stays: ten frames in flight one after the other.
TEST_F(AsyncCompute, Frames_HaveTheTexelsOfOneQueue) {
    for (const bool isAsync : {false, true}) {
        Readback readback;
        constexpr int kFrames = 10;
        for (int frame = 0; frame < kFrames; ++frame) {
            renderer->BeginFrame();
            const TextureId source = Fill(Transient("source"), static_cast<float>(frame), false);
            const TextureId doubled = Scale("Double", source, Transient("doubled"), 2.0f, isAsync);
            const TextureId halved = Scale("Halve", source, Transient("halved"), 0.5f, false);
            TextureId sum = renderer->Persist(isAsync ? "asynchronous" : "plain",
                                              {.extent = kExtent, .format = Format::R32Float});
            // Every other frame, the sum itself is another queue's.
            sum = AddTo(sum, doubled, isAsync && frame % 2 == 1);
            sum = AddTo(sum, halved, false);
            readback = renderer->ReadBack(sum);
            renderer->Execute();
            const std::string plan = renderer->DescribePlan();
            EXPECT_EQ(plan.find("on the compute queue") != std::string::npos, isAsync) << plan;
        }
        // Each frame adds 2.5 * (frame + x + 100 y).
        EXPECT_EQ(At(readback, 3, 2), 2.5f * (45.0f + 10.0f * 203.0f));
    }
}

TEST_F(AsyncCompute, EveryPass_HasATime) {
    if (device->Info().timestampValidBits == 0) GTEST_SKIP() << "the device has no timestamps";
    renderer->BeginFrame();
    const TextureId source = Fill(Transient("source"), 1.0f, false);
    const TextureId scaled = Scale("Beside", source, Transient("scaled"), 2.0f, true);
    renderer->Present(Scale("After", scaled, Transient("shown"), 2.0f, false));
    device->WaitFor(renderer->Execute());
    const std::vector<FrameTiming> timings = renderer->TakeTimings();
    ASSERT_EQ(timings.size(), 1u);
    ASSERT_EQ(timings.front().passes.size(), 3u);
    for (const PassTiming& pass : timings.front().passes) {
        EXPECT_GT(pass.gpuMs, 0.0) << pass.name;
        EXPECT_LT(pass.gpuMs, 1000.0) << pass.name;
    }
}

TEST_F(AsyncCompute, LostDevice_NamesThePassesOfBothQueues) {
    renderer->BeginFrame();
    const TextureId filled = Fill(Transient("filled"), 1.0f, true);
    renderer->Present(Scale("After", filled, Transient("shown"), 2.0f, false));
    renderer->Execute();
    device->WaitIdle();
    EXPECT_THAT(
        testing::ErrorTextOf([&] { device->Check(VK_ERROR_DEVICE_LOST, "x"); }, ErrorKind::DeviceLost),
        HasSubstr(R"(the last passes reached were pass "After" (2 of 2) and, on the compute queue, )"
                  R"(pass "Fill" (1 of 2) of frame 1)"));
}

// A frame for the host's command buffer is for one queue, whatever its passes ask for.
TEST_F(AsyncCompute, Record_UsesOneQueue) {
    const rhi::DeviceFunctions& vk = host.Functions();
    VkCommandPoolCreateInfo poolInfo{};
    poolInfo.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    poolInfo.queueFamilyIndex = device->QueueFamily();
    VkCommandPool pool = VK_NULL_HANDLE;
    ASSERT_EQ(vk.vkCreateCommandPool(host.Handle(), &poolInfo, nullptr, &pool), VK_SUCCESS);
    VkCommandBufferAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    allocate.commandPool = pool;
    allocate.commandBufferCount = 1;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    ASSERT_EQ(vk.vkAllocateCommandBuffers(host.Handle(), &allocate, &commands), VK_SUCCESS);
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    ASSERT_EQ(vk.vkBeginCommandBuffer(commands, &begin), VK_SUCCESS);

    renderer->BeginFrame();
    const TextureId source = Fill(Transient("source"), 1.0f, true);
    const Readback readback = renderer->ReadBack(Scale("Scale", source, Transient("scaled"), 2.0f, false));
    const rhi::Submission recorded = renderer->Record(commands);
    EXPECT_THAT(renderer->DescribePlan(), Not(HasSubstr("batch")));

    ASSERT_EQ(vk.vkEndCommandBuffer(commands), VK_SUCCESS);
    VkCommandBufferSubmitInfo buffer{};
    buffer.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO;
    buffer.commandBuffer = commands;
    VkSubmitInfo2 batch{};
    batch.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2;
    batch.commandBufferInfoCount = 1;
    batch.pCommandBufferInfos = &buffer;
    const VkQueue queue = host.Desc().queue;
    ASSERT_EQ(vk.vkQueueSubmit2(queue, 1, &batch, VK_NULL_HANDLE), VK_SUCCESS);
    ASSERT_EQ(vk.vkQueueWaitIdle(queue), VK_SUCCESS);
    device->Complete(recorded);
    EXPECT_EQ(At(readback, 3, 2), 2.0f * 204.0f);
    vk.vkDestroyCommandPool(host.Handle(), pool, nullptr);

    // The next frame may use both again.
    renderer->BeginFrame();
    renderer->Present(Fill(Transient("other"), 1.0f, true));
    renderer->Execute();
    EXPECT_THAT(renderer->DescribePlan(), HasSubstr("on the compute queue"));
}

// An image of a host belongs to one family at a time, unless the host says that it is shared.
TEST_F(AsyncCompute, ImageOfAHost_ComesBack) {
    const rhi::Texture owner =
        device->CreateTexture({.name = "host",
                               .extent = kExtent,
                               .format = Format::R32Float,
                               .usage = rhi::TextureUsage::Storage | rhi::TextureUsage::CopySource});
    const rhi::Texture image = device->WrapTexture(owner.Desc(), owner.Image());
    ResourceState state;
    Readback readback;
    for (int frame = 0; frame < 4; ++frame) {
        renderer->BeginFrame();
        TextureId target = renderer->Import("host", image, state);
        target = frame == 0 ? Fill(target, 1.0f, false) : target;
        const TextureId copy = Scale("Copy", target, Transient("copy"), 1.0f, true);
        target = Scale("Back", copy, target, 2.0f, frame % 2 == 0);
        renderer->Export(target, VK_IMAGE_LAYOUT_GENERAL);
        readback = renderer->ReadBack(target);
        renderer->Execute();
    }
    EXPECT_EQ(At(readback, 3, 2), 16.0f * 204.0f);
}

// The host's semaphore is waited for once, by all of the frame.
TEST_F(AsyncCompute, SemaphoreOfTheHost_HoldsBothQueues) {
    const rhi::DeviceFunctions& vk = host.Functions();
    VkSemaphoreTypeCreateInfo type{};
    type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
    type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    const VkSemaphoreCreateInfo create{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
    VkSemaphore after = VK_NULL_HANDLE;
    ASSERT_EQ(vk.vkCreateSemaphore(host.Handle(), &create, nullptr, &after), VK_SUCCESS);
    testing::Gate before(*device);
    renderer->BeginFrame();
    renderer->WaitSemaphore(before.At(1));
    renderer->SignalSemaphore({after, 7});
    const Readback readback =
        renderer->ReadBack(Scale("Scale", Fill(Transient("a"), 1.0f, true), Transient("b"), 3.0f, false));
    const rhi::Submission frame = renderer->Execute();
    EXPECT_FALSE(device->HasCompleted(frame));
    EXPECT_EQ(device->CompletedValue(rhi::QueueKind::Compute), 0u);
    before.Open();
    EXPECT_EQ(At(readback, 3, 2), 3.0f * 204.0f);
    uint64_t value = 0;
    ASSERT_EQ(vk.vkGetSemaphoreCounterValue(host.Handle(), after, &value), VK_SUCCESS);
    EXPECT_EQ(value, 7u);
    device->WaitQueueIdle();
    vk.vkDestroySemaphore(host.Handle(), after, nullptr);
}

}  // namespace
}  // namespace raygraph::async_compute_test
