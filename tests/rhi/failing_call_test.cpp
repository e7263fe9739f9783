// Tests how each wrapper reports Vulkan calls that fail, one at a time.
#include <gtest/gtest.h>

#include <tuple>

#include "rhi/command_list.h"
#include "rhi/functions.h"
#include "tests/support/error_of.h"
#include "tests/support/failing_vulkan.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::failing_call_test {
namespace {

class FailingCallTest : public ::testing::Test {
  protected:
    FailingCallTest() {
        InjectFailure(std::nullopt);
        UseDedicatedAllocations(true);
        device = Make();
    }
    std::unique_ptr<rhi::Device> Make() {
        return rhi::Device::Create({.validation = true,
                                    .log = log.Listener(),
                                    .savePipelineCache = false,
                                    .getInstanceProcAddr = FailingLoader(system->GetInstanceProcAddr())});
    }
    ~FailingCallTest() override {
        ClearInjectedFailure();
        device.reset();
        EXPECT_EQ(log.Text(), "");
        UseDedicatedAllocations(false);
        InjectFailure(std::nullopt);
    }

    std::shared_ptr<rhi::VulkanLoader> system = rhi::VulkanLoader::Open();
    MessageLog log;
    std::unique_ptr<rhi::Device> device;
};

TEST_F(FailingCallTest, DeviceThatCannotBeMade_LeavesNothing) {
    for (const VkResult result : {VK_ERROR_OUT_OF_HOST_MEMORY, VK_ERROR_DEVICE_LOST}) {
        for (const uint64_t number : {1, 2}) {  // creation of its timeline, and of its pipeline cache
            InjectFailure(InjectedFailure{.number = number, .result = result});
            EXPECT_EQ(ErrorOf([&] { Make(); }).Kind(),
                      result == VK_ERROR_DEVICE_LOST ? ErrorKind::DeviceLost : ErrorKind::OutOfMemory);
        }
        InjectFailure(InjectedFailure{.number = 3, .result = result});
        EXPECT_NO_THROW(Make());
    }
}

TEST_F(FailingCallTest, SubmissionThatHasArrived_IsNoError) {
    rhi::CommandList commands = device->BeginCommands("arrives");
    bool hasArrived = false;
    commands.OnSubmitted([&] { hasArrived = true; });
    // Submit next queries how far the device is.
    InjectFailure(InjectedFailure{.call = FailingCall::Wait});
    uint64_t value = 0;
    EXPECT_NO_THROW(value = device->Submit(std::move(commands)));
    EXPECT_TRUE(HasFailed());
    EXPECT_TRUE(hasArrived);
    EXPECT_EQ(value, device->LastSubmittedValue());
    ClearInjectedFailure();
    device->WaitFor(value);
}

TEST_F(FailingCallTest, SubmissionThatHasNotArrived_LeavesTheTimeline) {
    rhi::CommandList commands = device->BeginCommands("does not arrive");
    bool isDropped = false;
    commands.OnDropped([&] { isDropped = true; });
    InjectFailure(InjectedFailure{.call = FailingCall::Submission});
    EXPECT_EQ(ErrorOf([&] { device->Submit(std::move(commands)); }).Kind(), ErrorKind::OutOfMemory);
    EXPECT_TRUE(isDropped);
    EXPECT_EQ(device->LastSubmittedValue(), 0u);
    EXPECT_EQ(device->Submit(device->BeginCommands("arrives")), 1u);
}

// Fails each call that makes a resource in turn, until none is left.
template <typename Make>
uint32_t FailEach(rhi::Device& device, Make&& make) {
    const uint64_t used = device.Memory().usedBytes;
    for (uint32_t failures = 0;; ++failures) {
        InjectFailure(InjectedFailure{.number = failures + 1, .lasts = true});
        try {
            make();
            ClearInjectedFailure();
            return failures;
        } catch (const Error& error) {
            ClearInjectedFailure();
            EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory) << error.what();
            EXPECT_EQ(device.Memory().usedBytes, used) << RecordedCalls().back();
        }
    }
}

TEST_F(FailingCallTest, ResourcesThatCannotBeMadeLeaveNothing) {
    const rhi::TextureDesc texture{.name = "t", .extent = {4, 4}};
    const rhi::BufferDesc buffer{.name = "b", .size = 256};
    EXPECT_EQ(FailEach(*device, [&] { std::ignore = device->CreateTexture(texture); }), 4u)
        << "image, memory, binding, view";
    EXPECT_EQ(FailEach(*device, [&] { std::ignore = device->CreateBuffer(buffer); }), 3u);
    EXPECT_EQ(FailEach(*device, [&] { std::ignore = device->CreateSampler({.name = "s"}); }), 1u);
    {
        const rhi::MemoryBlock block = device->CreateMemoryBlock("block", device->RequirementsOf(texture));
        EXPECT_EQ(FailEach(*device, [&] { std::ignore = device->CreateTexture(texture, block); }), 3u)
            << "image, binding, view";
    }
    const rhi::MemoryBlock block = device->CreateMemoryBlock("block", device->RequirementsOf(buffer));
    EXPECT_EQ(FailEach(*device, [&] { std::ignore = device->CreateBuffer(buffer, block); }), 2u);
}

// The allocator reports every failure as exhausted memory, including that of a lost device.
TEST_F(FailingCallTest, AllocationOnALostDevice_SaysThatItIsLost) {
    InjectFailure(
        InjectedFailure{.call = FailingCall::Allocation, .result = VK_ERROR_DEVICE_LOST, .lasts = true});
    const Error error = ErrorOf([&] { std::ignore = device->CreateBuffer({.name = "b", .size = 256}); });
    EXPECT_EQ(error.Kind(), ErrorKind::DeviceLost);
    EXPECT_EQ(std::string(error.what()), "buffer 'b' (256 bytes): VK_ERROR_DEVICE_LOST; no pass is known");
    ClearInjectedFailure();
    EXPECT_EQ(ErrorOf([&] { device->WaitIdle(); }).Kind(), ErrorKind::DeviceLost);
}

TEST_F(FailingCallTest, FailuresAreReadFromText) {
    for (const char* text : {"allocation:17:oom", "creation:1:lost", "any:200:oom:on", "wait:3:lost"}) {
        const std::optional<InjectedFailure> failure = ParseFailure(text);
        ASSERT_TRUE(failure) << text;
        EXPECT_EQ(failure->Text(), text);
    }
    for (const char* text : {"", "allocation", "allocation:17", "allocation:0:oom", "allocation:x:oom",
                             "walk:1:oom", "wait:1:off", "wait:1:oom:of"})
        EXPECT_FALSE(ParseFailure(text)) << text;
}

}  // namespace
}  // namespace raygraph::testing::failing_call_test
