// A dropped frame still serves the semaphores of the host: what the host has signaled is waited for, and what
// it waits for is signaled.
#include <gmock/gmock.h>

#include <stdexcept>

#include "tests/graph/graph_test.h"
#include "tests/rhi/fake_loader.h"
#include "tests/rhi/gate.h"
#include "tests/support/error_of.h"

namespace raygraph::dropped_semaphores_test {
namespace {

constexpr Extent2D kExtent{16, 16};

// A binary semaphore of the host.
class BinarySemaphore {
  public:
    explicit BinarySemaphore(rhi::Device& device) : m_device(device) {
        const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, nullptr, 0};
        device.Check(device.Vk().vkCreateSemaphore(device.Handle(), &info, nullptr, &m_semaphore), "binary");
    }
    ~BinarySemaphore() { m_device.Vk().vkDestroySemaphore(m_device.Handle(), m_semaphore, nullptr); }
    BinarySemaphore(const BinarySemaphore&) = delete;
    BinarySemaphore& operator=(const BinarySemaphore&) = delete;
    rhi::SemaphoreUse Use() const { return {m_semaphore, 0}; }

  private:
    rhi::Device& m_device;
    VkSemaphore m_semaphore = VK_NULL_HANDLE;
};

// A host that signals `before` ahead of each frame and waits for `after` behind it.
struct Host {
    explicit Host(rhi::Device& d) : device(d), before(d), after(d), progress(d) {}
    ~Host() { device.WaitIdle(); }

    void Signal() {
        const rhi::SemaphoreUse signal = before.Use();
        device.Submit(device.BeginCommands("host, before"), {}, {&signal, 1});
    }
    void Declare(Renderer& renderer) {
        renderer.WaitSemaphore(before.Use());
        renderer.SignalSemaphore(after.Use());
        renderer.SignalSemaphore(progress.At(++frames));
    }
    // Submits work that waits for `after`, if the frame has signaled it.
    ::testing::AssertionResult GoesOn() {
        const uint64_t value = frames;
        const VkSemaphore semaphore = progress.At(value).semaphore;
        const VkSemaphoreWaitInfo wait{
            VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO, nullptr, 0, 1, &semaphore, &value};
        if (device.Vk().vkWaitSemaphores(device.Handle(), &wait, 2'000'000'000ull) != VK_SUCCESS)
            return ::testing::AssertionFailure() << "the frame signals nothing";
        const rhi::SemaphoreUse use = after.Use();
        device.Submit(device.BeginCommands("host, after"), {&use, 1});
        device.WaitIdle();
        return ::testing::AssertionSuccess();
    }

    rhi::Device& device;
    BinarySemaphore before, after;
    testing::Gate progress;  // counts the frames
    uint64_t frames = 0;
};

class DroppedSemaphores : public GraphTest {
  protected:
    enum class Where { Nowhere, Setup, Execute };

    static void DeclareFrame(Renderer& renderer, Where throwing) {
        renderer.Present(Fill(renderer, "a", kExtent, 1.0f));
        renderer.AddPass(
            "May throw", PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.KeepAlive();
                if (throwing == Where::Setup) throw std::runtime_error("setup");
            },
            [throwing](CommandList&) {
                if (throwing == Where::Execute) throw std::runtime_error("execute");
            });
    }
    void Frame(Where throwing) {
        m_renderer.BeginFrame();
        m_host.Declare(m_renderer);
        DeclareFrame(m_renderer, throwing);
        m_renderer.Execute();
    }

    Host m_host{Device()};
};

TEST_F(DroppedSemaphores, AreForwardedWhenRecordingFails) {
    for (const Where where : {Where::Execute, Where::Execute, Where::Nowhere}) {
        m_host.Signal();
        if (where == Where::Execute)
            EXPECT_THROW(Frame(where), std::runtime_error);
        else
            Frame(where);
        ASSERT_TRUE(m_host.GoesOn());
    }
}

TEST_F(DroppedSemaphores, AreForwardedByDropFrameAfterAnErrorInASetup) {
    m_host.Signal();
    EXPECT_THROW(Frame(Where::Setup), std::runtime_error);
    m_renderer.DropFrame();
    ASSERT_TRUE(m_host.GoesOn());
    m_renderer.DropFrame();  // has nothing left to signal
    m_host.Signal();
    Frame(Where::Nowhere);
    ASSERT_TRUE(m_host.GoesOn());
}

TEST_F(DroppedSemaphores, AreForwardedByTheNextBeginFrame) {
    m_host.Signal();
    EXPECT_THROW(Frame(Where::Setup), std::runtime_error);
    m_renderer.BeginFrame();
    ASSERT_TRUE(m_host.GoesOn());
    m_renderer.DropFrame();
}

TEST_F(DroppedSemaphores, AreForwardedByTheRenderersEnd) {
    m_host.Signal();
    {
        Renderer other(Device());
        AddTestShaders(other);
        other.BeginFrame();
        m_host.Declare(other);
    }
    ASSERT_TRUE(m_host.GoesOn());
}

TEST_F(DroppedSemaphores, AreLeftAloneWhereAskedFor) {
    m_host.Signal();
    m_renderer.BeginFrame();
    m_renderer.WaitSemaphore(m_host.before.Use(), DropPolicy::LeaveAlone);
    m_renderer.SignalSemaphore(m_host.progress.At(1), DropPolicy::LeaveAlone);
    m_renderer.DropFrame();
    Device().WaitIdle();
    EXPECT_EQ(m_host.progress.Value(), 0u);
    Frame(Where::Nowhere);  // `before` is still there to be waited for
    ASSERT_TRUE(m_host.GoesOn());
}

// The host has not signaled yet: Vulkan allows no wait for it.
TEST_F(DroppedSemaphores, AreLeftAloneByADropThatIsToldSo) {
    m_renderer.BeginFrame();
    m_host.Declare(m_renderer);
    m_renderer.DropFrame(DropPolicy::LeaveAlone);
    Device().WaitIdle();
    EXPECT_EQ(m_host.progress.Value(), 0u);
    m_host.Signal();
    Frame(Where::Nowhere);
    ASSERT_TRUE(m_host.GoesOn());
}

TEST(DroppedSemaphoresOfAFailedSubmission, AreForwarded) {
    testing::FakeLoader loader;
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create({.savePipelineCache = false, .getInstanceProcAddr = loader.Entry()});
    Renderer renderer(*device);
    Host host(*device);
    host.Signal();
    renderer.BeginFrame();
    host.Declare(renderer);
    renderer.AddPass(
        "Nothing", PassKind::Transfer, [](PassBuilder& pass) { pass.KeepAlive(); }, [](CommandList&) {});
    loader.Tell().nextSubmitResult = VK_ERROR_OUT_OF_HOST_MEMORY;
    EXPECT_EQ(testing::ErrorOf([&] { renderer.Execute(); }).Kind(), ErrorKind::OutOfMemory);
    EXPECT_TRUE(host.GoesOn());
}

}  // namespace
}  // namespace raygraph::dropped_semaphores_test
