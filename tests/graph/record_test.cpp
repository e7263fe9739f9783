// Frames that are recorded into a command buffer of the host.
#include <gmock/gmock.h>

#include <deque>
#include <memory>
#include <stdexcept>

#include "tests/graph/graph_test.h"
#include "tests/support/error_of.h"

namespace raygraph::record_test {
namespace {

using ::testing::HasSubstr;

constexpr Extent2D kExtent{37, 19};

// A host with command buffers of its own, which submits them with its own semaphore.
class Host {
  public:
    explicit Host(rhi::Device& device) : m_device(device), m_vk(device.Vk()) {
        VkSemaphoreTypeCreateInfo type{};
        type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
        type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
        const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
        device.Check(m_vk.vkCreateSemaphore(device.Handle(), &info, nullptr, &m_semaphore), "host");
        m_vk.vkGetDeviceQueue(device.Handle(), device.QueueFamily(), 0, &m_queue);
    }
    ~Host() {
        WaitFor(m_value);
        for (const VkCommandPool pool : m_pools) m_vk.vkDestroyCommandPool(m_device.Handle(), pool, nullptr);
        m_vk.vkDestroySemaphore(m_device.Handle(), m_semaphore, nullptr);
    }
    Host(const Host&) = delete;
    Host& operator=(const Host&) = delete;

    VkCommandBuffer Begin() {
        VkCommandPoolCreateInfo poolInfo{};
        poolInfo.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
        poolInfo.queueFamilyIndex = m_device.QueueFamily();
        VkCommandPool& pool = m_pools.emplace_back();
        m_device.Check(m_vk.vkCreateCommandPool(m_device.Handle(), &poolInfo, nullptr, &pool), "host");
        VkCommandBufferAllocateInfo allocate{};
        allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
        allocate.commandPool = pool;
        allocate.commandBufferCount = 1;
        VkCommandBuffer commands = VK_NULL_HANDLE;
        m_device.Check(m_vk.vkAllocateCommandBuffers(m_device.Handle(), &allocate, &commands), "host");
        VkCommandBufferBeginInfo begin{};
        begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
        m_device.Check(m_vk.vkBeginCommandBuffer(commands, &begin), "host");
        return commands;
    }
    // Submits the buffer; returns the value of the host's semaphore at which it has completed.
    uint64_t Submit(VkCommandBuffer commands) {
        m_device.Check(m_vk.vkEndCommandBuffer(commands), "host");
        VkCommandBufferSubmitInfo buffer{};
        buffer.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO;
        buffer.commandBuffer = commands;
        VkSemaphoreSubmitInfo signal{};
        signal.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO;
        signal.semaphore = m_semaphore;
        signal.value = ++m_value;
        signal.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
        VkSubmitInfo2 batch{};
        batch.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2;
        batch.commandBufferInfoCount = 1;
        batch.pCommandBufferInfos = &buffer;
        batch.signalSemaphoreInfoCount = 1;
        batch.pSignalSemaphoreInfos = &signal;
        m_device.Check(m_vk.vkQueueSubmit2(m_queue, 1, &batch, VK_NULL_HANDLE), "host");
        return m_value;
    }
    void WaitFor(uint64_t value) const {
        const VkSemaphoreWaitInfo wait{
            VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO, nullptr, 0, 1, &m_semaphore, &value};
        m_device.Check(m_vk.vkWaitSemaphores(m_device.Handle(), &wait, UINT64_MAX), "host");
    }

  private:
    rhi::Device& m_device;
    const rhi::DeviceFunctions& m_vk;
    VkQueue m_queue = VK_NULL_HANDLE;
    VkSemaphore m_semaphore = VK_NULL_HANDLE;
    uint64_t m_value = 0;
    std::vector<VkCommandPool> m_pools;
};

class Record : public GraphTest {
  protected:
    // Declares the sum of all frames so far, a persistent texture.
    TextureId DeclareSum() {
        m_renderer.BeginFrame();
        return AddTo(m_renderer, "sum",
                     Scale(m_renderer, "two", Fill(m_renderer, "one", kExtent, 1.0f), 2.0f));
    }
    Host host{Device()};
};

// The host's own commands are around ours, and as many frames are in flight as the device allows.
TEST_F(Record, FramesInFlight_AccumulateAsExecutedOnesDo) {
    constexpr int kFrames = 12;
    struct Pending {
        rhi::Submission ours;
        uint64_t theirs = 0;  // 0 for an executed frame
    };
    const auto complete = [&](const Pending& frame) {
        if (frame.theirs == 0) return;
        host.WaitFor(frame.theirs);
        Device().Complete(frame.ours);
    };
    std::deque<Pending> pending;
    Readback readback;
    const uint64_t messages = Device().ValidationMessageCount();
    for (int frame = 0; frame < kFrames; ++frame) {
        if (pending.size() == Device().FramesInFlight()) {
            complete(pending.front());
            pending.pop_front();
        }
        const TextureId sum = DeclareSum();
        m_renderer.Present(sum);
        if (frame == kFrames - 1) readback = m_renderer.ReadBack(sum);
        if (frame % 3 == 2) {  // executed ones may come between
            pending.push_back({m_renderer.Execute(), 0});
            continue;
        }
        const VkCommandBuffer commands = host.Begin();
        const rhi::Submission ours = m_renderer.Record(commands);
        EXPECT_FALSE(Device().HasCompleted(ours));
        pending.push_back({ours, host.Submit(commands)});
    }
    for (const Pending& frame : pending) complete(frame);
    EXPECT_TRUE(IsRamp(Read(readback), 1.0f, 2.0f * kFrames));
    EXPECT_EQ(Device().ValidationMessageCount(), messages);
}

// A buffer that the host has not completed counts as in flight, whatever was submitted after it.
TEST_F(Record, UntilTheHostCompletesIt_ItsFrameIsInFlight) {
    std::vector<rhi::Submission> values;
    std::vector<VkCommandBuffer> buffers;
    Readback readback;
    for (uint32_t i = 0; i < Device().FramesInFlight(); ++i) {
        EXPECT_FALSE(m_renderer.WouldBlock());
        readback = m_renderer.ReadBack(DeclareSum());
        buffers.push_back(host.Begin());
        values.push_back(m_renderer.Record(buffers.back()));
    }
    auto object = std::make_shared<int>();
    const std::weak_ptr<int> isKept = object;
    Device().Retire([object] {});
    object.reset();
    EXPECT_TRUE(m_renderer.WouldBlock());
    EXPECT_THAT(testing::ErrorTextOf([&] { m_renderer.BeginFrame(); }), HasSubstr("the host"));
    EXPECT_THAT(testing::ErrorTextOf([&] { readback.Wait(); }), HasSubstr("the host"));

    // The host submits them later than others do.
    const rhi::Submission other = Device().Submit(Device().BeginCommands("other"));
    Device().WaitFor(other);
    EXPECT_TRUE(Device().HasCompleted(other));
    EXPECT_LT(Device().CompletedValue(), values.front().value);
    uint64_t theirs = 0;
    for (const VkCommandBuffer commands : buffers) theirs = host.Submit(commands);
    host.WaitFor(theirs);
    EXPECT_FALSE(readback.IsReady()) << "the host has not said so";
    EXPECT_FALSE(isKept.expired());
    EXPECT_TRUE(m_renderer.TakeTimings().empty());
    Device().WaitIdle();
    for (const rhi::Submission& value : values) {
        EXPECT_FALSE(Device().HasCompleted(value));
        EXPECT_FALSE(isKept.expired());
        Device().Complete(value);
        EXPECT_TRUE(Device().HasCompleted(value));
    }
    EXPECT_TRUE(isKept.expired());
    EXPECT_EQ(Device().CompletedValue(), Device().LastSubmittedValue());
    EXPECT_TRUE(IsRamp(Read(readback), 1.0f, 2.0f * static_cast<float>(values.size())));
    EXPECT_EQ(m_renderer.TakeTimings().size(), values.size());
}

TEST_F(Record, TheLastValue_IsReachedWithoutALaterSubmission) {
    m_renderer.Present(DeclareSum());
    const VkCommandBuffer commands = host.Begin();
    const rhi::Submission value = m_renderer.Record(commands);
    host.WaitFor(host.Submit(commands));
    Device().Complete(value);
    EXPECT_EQ(Device().CompletedValue(), value.value);
    Device().WaitFor(value);
    Device().WaitIdle();
    m_renderer.Present(DeclareSum());
    Device().WaitFor(m_renderer.Execute());
    EXPECT_EQ(Device().CompletedValue(), value.value + 1);
}

TEST_F(Record, MistakesOfTheHost_AreNamed) {
    const auto textOf = [](auto&& call) { return testing::ErrorTextOf(call); };
    m_renderer.Present(DeclareSum());
    EXPECT_THAT(textOf([&] { m_renderer.Record(VK_NULL_HANDLE); }), HasSubstr("there is no command buffer"));
    const VkCommandBuffer commands = host.Begin();
    m_renderer.SignalSemaphore({Device().Timeline(), 0}, DropPolicy::LeaveAlone);
    EXPECT_THAT(textOf([&] { m_renderer.Record(commands); }), HasSubstr("semaphores"));
    EXPECT_THAT(textOf([&] { m_renderer.Record(commands); }), HasSubstr("Record"));
    EXPECT_THAT(textOf([&] { Device().Complete({Device().LastSubmittedValue()}); }), HasSubstr("Complete("));
    rhi::CommandList list = Device().RecordInto(commands);
    EXPECT_THAT(textOf([&] { Device().Submit(std::move(list)); }), HasSubstr("HandOver"));
    rhi::CommandList own = Device().BeginCommands("own");
    EXPECT_THAT(textOf([&] { Device().HandOver(std::move(own)); }), HasSubstr("RecordInto"));
    m_renderer.Present(DeclareSum());
    const rhi::Submission value = m_renderer.Record(commands);
    host.WaitFor(host.Submit(commands));
    Device().Complete(value);
    EXPECT_THAT(textOf([&] { Device().Complete(value); }), HasSubstr("no pending buffer"));
}

// The host resets its buffer; the frame has left nothing behind.
TEST_F(Record, AnErrorInAPass_DropsTheFrame) {
    const uint64_t before = Device().LastSubmittedValue();
    const TextureId sum = DeclareSum();
    TextureId target = m_renderer.CreateTexture("target", m_renderer.Desc(sum));
    m_renderer.AddPass(
        "Fail", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("test/scale.comp");
            pass.Reads("source", sum);
            target = pass.Writes("target", target);
            pass.Constants(1.0f);
        },
        [](CommandList&) { throw std::runtime_error("it fails"); });
    m_renderer.Present(target);
    const VkCommandBuffer dropped = host.Begin();
    EXPECT_THROW(m_renderer.Record(dropped), std::runtime_error);
    EXPECT_EQ(Device().LastSubmittedValue(), before);
    const Readback readback = m_renderer.ReadBack(DeclareSum());
    const VkCommandBuffer commands = host.Begin();
    const rhi::Submission value = m_renderer.Record(commands);
    host.WaitFor(host.Submit(commands));
    Device().Complete(value);
    EXPECT_TRUE(IsRamp(Read(readback), 1.0f, 2.0f)) << "the dropped frame has added to the sum";
}

}  // namespace
}  // namespace raygraph::record_test
