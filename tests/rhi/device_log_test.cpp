// Tests what a device logs to DeviceDesc::log.
#include <gmock/gmock.h>

#include <atomic>
#include <fstream>
#include <stdexcept>

#include "base/text.h"
#include "rhi/command_list.h"
#include "rhi/device.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::device_log_test {
namespace {

using rhi::BufferUsage;
using rhi::DeviceDesc;
using ::testing::AllOf;
using ::testing::HasSubstr;

class DeviceLogTest : public VulkanTest {};

DeviceDesc Desc(raygraph::Log log, bool isValidating) {
    return {.name = "told", .validation = isValidating, .log = std::move(log), .savePipelineCache = false};
}

// Triggers core validation: makes a buffer without a size, past our own check.
void MakeWrongBuffer(const rhi::Device& device) {
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    VkBuffer wrong = VK_NULL_HANDLE;
    if (device.Vk().vkCreateBuffer(device.Handle(), &info, nullptr, &wrong) == VK_SUCCESS)
        device.Vk().vkDestroyBuffer(device.Handle(), wrong, nullptr);
}

TEST_F(DeviceLogTest, CoreAndSynchronizationValidationReachIt) {
    MessageLog log;
    const std::unique_ptr<rhi::Device> device = rhi::Device::Create(Desc(log.Listener(), true));
    MakeWrongBuffer(*device);
    EXPECT_EQ(device->ValidationMessageCount(), 1u);
    ASSERT_EQ(log.Count(), 1u);
    EXPECT_EQ(log.All()[0].category, "validation");
    EXPECT_EQ(log.All()[0].level, LogLevel::Error);
    EXPECT_THAT(log.All()[0].text, HasSubstr("VUID-VkBufferCreateInfo-size-00912"));
    // Triggers synchronization validation: two writes without a barrier between them.
    const rhi::Buffer buffer =
        device->CreateBuffer({.name = "raced", .size = 64, .usage = BufferUsage::CopyDestination});
    rhi::CommandList commands = device->BeginCommands("race");
    commands.Fill(buffer, 1);
    commands.Fill(buffer, 2);
    device->Submit(std::move(commands));
    device->WaitIdle();
    ASSERT_GE(log.Count(), 2u);
    EXPECT_THAT(log.All()[1].text, HasSubstr("SYNC-HAZARD-WRITE-AFTER-WRITE"));
    EXPECT_THAT(log.All()[1].text, HasSubstr("raced")) << "objects carry their names";
    EXPECT_EQ(device->ValidationMessageCount(), log.Count());
}

TEST_F(DeviceLogTest, ValidationMessagesAreCountedAlsoIfNobodyListens) {
    const std::unique_ptr<rhi::Device> device = rhi::Device::Create(Desc({}, true));
    MakeWrongBuffer(*device);
    EXPECT_EQ(device->ValidationMessageCount(), 1u);
}

// The callback is called under Vulkan calls, in destructors and where nothing may be thrown.
TEST_F(DeviceLogTest, CallbackThatThrowsEndsNothing) {
    std::atomic<uint32_t> calls = 0;
    const raygraph::Log throwing(
        [&](const LogMessage&) {
            ++calls;
            throw std::runtime_error("the host is at its end");
        },
        LogLevel::Debug);
    std::unique_ptr<rhi::Device> device = rhi::Device::Create(Desc(throwing, true));
    EXPECT_GE(calls, 1u) << "what the device is";
    calls = 0;
    MakeWrongBuffer(*device);
    EXPECT_EQ(calls, 1u);
    EXPECT_EQ(device->ValidationMessageCount(), 1u);
    const rhi::Buffer buffer =
        device->CreateBuffer({.name = "raced", .size = 64, .usage = BufferUsage::CopyDestination});
    rhi::CommandList commands = device->BeginCommands("race");
    commands.Fill(buffer, 1);
    commands.Fill(buffer, 2);
    // OnSubmitted and OnDropped run where nothing may be thrown
    commands.OnSubmitted([&] { Say(throwing, LogLevel::Info, log_category::kGraph, "submitted"); });
    device->Submit(std::move(commands));
    device->WaitIdle();
    EXPECT_GE(calls, 3u) << "the hazard and the outcome";
}

TEST_F(DeviceLogTest, CallbackThatThrowsIsNoTroubleForADestructor) {
    const test::TemporaryFolder folder;
    std::ofstream(folder.Path() / "file") << "no folder for a cache";
    std::string heard;
    const raygraph::Log throwing(
        [&](const LogMessage& message) {
            heard = message.text;
            throw std::runtime_error("the host is at its end");
        },
        LogLevel::Warning);
    DeviceDesc desc = Desc(throwing, true);
    desc.savePipelineCache = true;
    desc.cacheDirectory = folder.Path() / "file";
    std::unique_ptr<rhi::Device> device = rhi::Device::Create(desc);
    heard.clear();
    device.reset();
    EXPECT_THAT(heard, HasSubstr("pipeline cache is not saved"));
}

TEST_F(DeviceLogTest, WhatTheDeviceIsAndLacksReachesWhoListensForIt) {
    MessageLog all, some;
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create(Desc(all.Listener(LogLevel::Debug), false));
    ASSERT_GE(all.Count(), 1u);
    EXPECT_EQ(all.All()[0].level, LogLevel::Info);
    EXPECT_EQ(all.All()[0].category, "device");
    EXPECT_THAT(all.All()[0].text, AllOf(HasSubstr("device 'told'"), HasSubstr(device->Info().name)));
    EXPECT_EQ(device->ValidationMessageCount(), 0u) << "our own are none";
    EXPECT_EQ(all.Text().find("opacity micromaps") == std::string::npos,
              device->Info().optional.opacityMicromap);
    rhi::Device::Create(Desc(some.Listener(LogLevel::Warning), false));
    EXPECT_EQ(some.Text(), "");
}

}  // namespace
}  // namespace raygraph::testing::device_log_test
