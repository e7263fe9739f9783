#include <gmock/gmock.h>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "base/text.h"
#include "rhi/command_list.h"
#include "rhi/device.h"
#include "rhi/transfer.h"
#include "tests/rhi/fake_loader.h"
#include "tests/rhi/gate.h"
#include "tests/rhi/host_device.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

// Tests devices: choice, refusals, loss.
namespace raygraph::testing::device_test {
namespace {

using rhi::BufferUsage;
using rhi::DeviceDesc;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

DeviceDesc Quiet() {
    DeviceDesc desc;
    desc.savePipelineCache = false;
    return desc;
}

class SetEnvironment {
  public:
    SetEnvironment(const char* name, const char* value) : m_name(name) {
        if (const char* old = std::getenv(name)) m_old = old;
        setenv(name, value, 1);
    }
    ~SetEnvironment() {
        if (m_old)
            setenv(m_name, m_old->c_str(), 1);
        else
            unsetenv(m_name);
    }
    SetEnvironment(const SetEnvironment&) = delete;
    SetEnvironment& operator=(const SetEnvironment&) = delete;

  private:
    const char* m_name;
    std::optional<std::string> m_old;
};

// Fills a buffer with `value` and reads it back.
std::vector<uint32_t> FillAndRead(rhi::Device& device, uint32_t value) {
    const rhi::Buffer buffer = device.CreateBuffer(
        {.name = "filled", .size = 64, .usage = BufferUsage::CopySource | BufferUsage::CopyDestination});
    rhi::CommandList commands = device.BeginCommands("fill");
    commands.Fill(buffer, value);
    device.Submit(std::move(commands));
    return As<uint32_t>(rhi::ReadBuffer(device, buffer));
}

using DeviceTest = VulkanTest;

TEST_F(DeviceTest, Info_MeetsTheRequirements) {
    const rhi::DeviceInfo& info = Device().Info();
    EXPECT_FALSE(info.name.empty());
    EXPECT_FALSE(info.driver.empty());
    EXPECT_GE(info.apiVersion, VK_API_VERSION_1_3);
    EXPECT_GE(info.maxPushDescriptors, rhi::kMaxBoundResources);
    EXPECT_GE(info.maxPushConstantBytes, 128u);
    EXPECT_EQ(info.shaderGroupHandleSize, 32u);  // fixed by the specification
    EXPECT_EQ(info.shaderGroupBaseAlignment % info.shaderGroupHandleAlignment, 0u);
    EXPECT_GE(info.maxRayRecursionDepth, 1u);
    EXPECT_GT(info.scratchAlignment, 0u);
    EXPECT_GT(info.maxBufferBytes, 0u);
    EXPECT_EQ(info.isLavapipe, info.driver.find("llvmpipe") != std::string::npos);
}

TEST_F(DeviceTest, Enumerate_ListsTheDeviceInUseWithoutRefusals) {
    const std::vector<rhi::DeviceReport> reports = rhi::Device::Enumerate();
    ASSERT_FALSE(reports.empty());
    bool isFound = false;
    for (size_t i = 0; i < reports.size(); ++i) {
        EXPECT_EQ(reports[i].index, i);
        if (reports[i].name == Device().Info().name && reports[i].driver == Device().Info().driver) {
            isFound = true;
            EXPECT_THAT(reports[i].refusals, ::testing::IsEmpty());
            EXPECT_EQ(reports[i].type, Device().Info().type);
        }
    }
    EXPECT_TRUE(isFound);
}

TEST_F(DeviceTest, Select_TakesIndexOrPartOfTheNameInAnyCase) {
    DeviceDesc desc = Quiet();
    std::string name = Device().Info().name;
    for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    desc.select = name.substr(1, 6);
    EXPECT_EQ(rhi::Device::Create(desc)->Info().name, Device().Info().name);
    for (const rhi::DeviceReport& report : rhi::Device::Enumerate()) {
        if (!report.refusals.empty()) continue;
        desc.select = std::to_string(report.index);
        EXPECT_EQ(rhi::Device::Create(desc)->Info().name, report.name);
    }
}

TEST_F(DeviceTest, Select_UnknownNameListsWhatThereIs) {
    DeviceDesc desc = Quiet();
    desc.select = "no such device";
    const Error error = ErrorOf([&] { rhi::Device::Create(desc); });
    EXPECT_EQ(error.Kind(), ErrorKind::NoDevice);
    EXPECT_THAT(error.what(), AllOf(HasSubstr("'no such device'"), HasSubstr(Device().Info().name),
                                    HasSubstr("was not asked for")));
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
}

TEST_F(DeviceTest, TwoDevices_WorkSideBySide) {
    MessageLog log;
    DeviceDesc desc = Quiet();
    desc.validation = true;
    desc.log = log.Listener();
    const std::unique_ptr<rhi::Device> other = rhi::Device::Create(desc);
    EXPECT_NE(other->Handle(), Device().Handle());
    EXPECT_EQ(FillAndRead(*other, 0xABCD1234), std::vector<uint32_t>(16, 0xABCD1234));
    EXPECT_EQ(FillAndRead(Device(), 0x12345678), std::vector<uint32_t>(16, 0x12345678));
    EXPECT_EQ(log.Text(), "");
}

TEST_F(DeviceTest, Check_NamesWhatFailedAndPicksTheKind) {
    EXPECT_NO_THROW(Device().Check(VK_SUCCESS, "x"));
    EXPECT_NO_THROW(Device().Check(VK_INCOMPLETE, "x"));
    const Error memory = ErrorOf([] { Device().Check(VK_ERROR_OUT_OF_DEVICE_MEMORY, "buffer 'b'"); });
    EXPECT_EQ(memory.Kind(), ErrorKind::OutOfMemory);
    EXPECT_STREQ(memory.what(), "buffer 'b': VK_ERROR_OUT_OF_DEVICE_MEMORY");
    EXPECT_EQ(memory.Result(), VK_ERROR_OUT_OF_DEVICE_MEMORY);
    const Error other = ErrorOf([] { Device().Check(VK_ERROR_FEATURE_NOT_PRESENT, "x"); });
    EXPECT_EQ(other.Kind(), ErrorKind::Vulkan);
}

// ---- Refusals: the system's devices, made worse.

struct RefusalTest : ::testing::Test {
    Error CreateError() {
        DeviceDesc desc = Quiet();
        desc.getInstanceProcAddr = loader.Entry();
        return ErrorOf([&] { rhi::Device::Create(desc); });
    }
    FakeLoader loader;
};

TEST_F(RefusalTest, MissingExtension_IsNamed) {
    loader.Tell().hiddenExtension = VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME;
    const Error error = CreateError();
    EXPECT_EQ(error.Kind(), ErrorKind::NoDevice);
    EXPECT_THAT(error.what(), HasSubstr("lacks VK_KHR_ray_tracing_pipeline"));
    for (const rhi::DeviceReport& report : rhi::Device::Enumerate(loader.Entry()))
        EXPECT_THAT(report.refusals, Contains("lacks VK_KHR_ray_tracing_pipeline")) << report.name;
}

TEST_F(RefusalTest, MissingFeature_IsNamed) {
    loader.Tell().hasNoScalarBlockLayout = true;
    EXPECT_THAT(CreateError().what(), HasSubstr("lacks the feature scalarBlockLayout"));
}

TEST_F(RefusalTest, LowLimit_IsNamedWithBothNumbers) {
    loader.Tell().maxPushDescriptors = 8;
    EXPECT_THAT(CreateError().what(), HasSubstr("maxPushDescriptors is 8, needs 32"));
}

TEST_F(RefusalTest, MissingFormatFeature_IsNamed) {
    loader.Tell().hasNoFloatFilter = true;
    EXPECT_THAT(CreateError().what(), HasSubstr("lacks linear filtering of rgba32f"));
}

TEST_F(RefusalTest, OldVulkan_IsNamed) {
    loader.Tell().apiVersion = VK_API_VERSION_1_2;
    EXPECT_THAT(CreateError().what(), HasSubstr("has Vulkan 1.2, needs 1.3"));
}

TEST_F(RefusalTest, HiddenOptionalExtension_TurnsTheCapabilityOff) {
    DeviceDesc desc = Quiet();
    desc.getInstanceProcAddr = loader.Entry();
    const bool isThere = rhi::Device::Create(desc)->Info().optional.rayQuery;
    loader.Tell().hiddenExtension = VK_KHR_RAY_QUERY_EXTENSION_NAME;
    EXPECT_FALSE(rhi::Device::Create(desc)->Info().optional.rayQuery);
    if (!isThere) GTEST_SKIP() << "the device has no ray queries anyway";
}

TEST(NoDriverTest, Create_SaysThatThereIsNoDriver) {
    const SetEnvironment files("VK_DRIVER_FILES", "/nonexistent.json");
    const SetEnvironment older("VK_ICD_FILENAMES", "/nonexistent.json");
    EXPECT_TRUE(rhi::Device::Enumerate().empty());
    const Error error = ErrorOf([] { rhi::Device::Create(Quiet()); });
    EXPECT_EQ(error.Kind(), ErrorKind::NoDevice);
    EXPECT_THAT(error.what(), HasSubstr("no Vulkan driver is installed"));
}

TEST(CommandPoolTest, ResetThatFails_LosesNoPool) {
    FakeLoader loader;
    MessageLog log;
    DeviceDesc desc = Quiet();
    desc.getInstanceProcAddr = loader.Entry();
    desc.validation = true;
    desc.log = log.Listener();
    std::unique_ptr<rhi::Device> device = rhi::Device::Create(desc);
    device->WaitFor(device->Submit(device->BeginCommands("first")));
    loader.Tell().resetPoolResult = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    EXPECT_THAT(ErrorOf([&] { device->BeginCommands("second"); }).what(), HasSubstr("vkResetCommandPool"));
    loader.Tell().resetPoolResult = VK_SUCCESS;
    device->WaitFor(device->Submit(device->BeginCommands("third")));
    device.reset();
    EXPECT_EQ(log.Text(), "") << "the layers tell of objects that are left";
}

// ---- Loss of the device, as the driver would report it.

struct DeviceLostTest : ::testing::Test {
    DeviceLostTest() {
        DeviceDesc desc = Quiet();
        desc.getInstanceProcAddr = loader.Entry();
        desc.log = log.Listener();
        device = rhi::Device::Create(desc);
        report = device->AddLastPassReport([] { return std::string("last pass reached: Trace"); });
    }
    FakeLoader loader;
    MessageLog log;
    std::unique_ptr<rhi::Device> device;
    std::shared_ptr<const void> report;
};

TEST_F(DeviceLostTest, Submit_NamesTheLastPass) {
    rhi::CommandList commands = device->BeginCommands("frame");
    loader.Tell().submitResult = VK_ERROR_DEVICE_LOST;
    const Error error = ErrorOf([&] { device->Submit(std::move(commands)); });
    EXPECT_EQ(error.Kind(), ErrorKind::DeviceLost);
    EXPECT_EQ(error.Result(), VK_ERROR_DEVICE_LOST);
    EXPECT_STREQ(error.what(), "vkQueueSubmit2: VK_ERROR_DEVICE_LOST; last pass reached: Trace");
    EXPECT_EQ(device->LastSubmittedValue(), 0u);
}

TEST_F(DeviceLostTest, WaitFor_NamesTheLastPass) {
    const rhi::Submission value = device->Submit(device->BeginCommands("frame"));
    loader.Tell().waitResult = VK_ERROR_DEVICE_LOST;
    const Error error = ErrorOf([&] { device->WaitFor(value); });
    EXPECT_EQ(error.Kind(), ErrorKind::DeviceLost);
    EXPECT_THAT(error.what(), HasSubstr("last pass reached: Trace"));
}

TEST_F(DeviceLostTest, EveryReporterIsHeardUntilItGoes) {
    std::shared_ptr<const void> other = device->AddLastPassReport([] { return std::string("of another"); });
    const std::shared_ptr<const void> idle = device->AddLastPassReport([] { return std::string(); });
    const auto message = [&] {
        return std::string(ErrorOf([&] { device->Check(VK_ERROR_DEVICE_LOST, "x"); }).what());
    };
    EXPECT_EQ(message(), "x: VK_ERROR_DEVICE_LOST; last pass reached: Trace; of another");
    report.reset();
    EXPECT_EQ(message(), "x: VK_ERROR_DEVICE_LOST; of another");
    other.reset();
    EXPECT_EQ(message(), "x: VK_ERROR_DEVICE_LOST; no pass is known");
}

TEST_F(DeviceLostTest, DestroyingTheDeviceAfterwards_FreesEverything) {
    rhi::Buffer buffer = device->CreateBuffer({.name = "left", .size = 4096});
    device->Submit(device->BeginCommands("frame"));
    loader.Tell().waitResult = VK_ERROR_DEVICE_LOST;
    EXPECT_THROW(device->WaitIdle(), Error);
    EXPECT_GE(device->Memory().usedBytes, 4096u);
    buffer = {};
    device.reset();
    EXPECT_EQ(log.Text(), "") << "a device says so when memory is left";
}

// ---- Devices that hang.

// A device whose queue is blocked until the test releases it.
struct HangTest : ::testing::Test {
    explicit HangTest(std::chrono::milliseconds limit = std::chrono::milliseconds(50)) {
        rhi::DeviceDesc desc{.name = "hanging", .hangLimit = limit, .savePipelineCache = false};
        desc.log = log.Listener();
        device = rhi::Device::Create(desc);
        report = device->AddLastPassReport([] { return std::string("last pass reached: Trace"); });
    }
    rhi::Submission SubmitAfter(const Gate& gate) {
        const rhi::SemaphoreUse wait = gate.At(1);
        return device->Submit(device->BeginCommands("waits"), {&wait, 1});
    }
    MessageLog log;
    std::unique_ptr<rhi::Device> device;
    std::shared_ptr<const void> report;
};

TEST_F(HangTest, WaitBeyondTheLimit_IsALostDeviceThatNamesTheLastPass) {
    const rhi::Submission before = device->Submit(device->BeginCommands("runs"));
    device->WaitFor(before);
    {
        Gate gate(*device);
        const rhi::Submission value = SubmitAfter(gate);
        const Error error = ErrorOf([&] { device->WaitFor(value); });
        EXPECT_EQ(error.Kind(), ErrorKind::DeviceLost);
        EXPECT_STREQ(error.what(),
                     "the device hangs: waiting for submission 2, none after 1 has completed for "
                     "50 ms; last pass reached: Trace");
        EXPECT_EQ(ErrorOf([&] { device->WaitIdle(); }).Kind(), ErrorKind::DeviceLost);
        gate.Open();
        while (device->CompletedValue() < value.value) std::this_thread::yield();
    }
    device.reset();
    EXPECT_EQ(log.Text(), "") << "it went on, so that everything is freed";
}

// A long queue is no hang, as long as some work completes.
struct SlowQueueTest : HangTest {
    SlowQueueTest() : HangTest(std::chrono::milliseconds(400)) {}
};

TEST_F(SlowQueueTest, SubmissionsThatCompleteOneByOne_AreWaitedFor) {
    std::vector<std::unique_ptr<Gate>> gates;
    rhi::Submission last;
    for (int i = 0; i < 5; ++i) last = SubmitAfter(*gates.emplace_back(std::make_unique<Gate>(*device)));
    std::jthread opener([&] {
        for (const auto& gate : gates) {
            std::this_thread::sleep_for(std::chrono::milliseconds(120));
            gate->Open();
        }
    });
    EXPECT_NO_THROW(device->WaitFor(last)) << "600 ms in steps of 120 ms, with a limit of 400 ms";
    opener.join();
}

// A semaphore that was given up as hung is used again once it has been signaled.
TEST_F(SlowQueueTest, DeviceThatGoesOnAfterAll_IsWaitedForAsBefore) {
    Gate first(*device), second(*device);
    const rhi::Submission held = SubmitAfter(first);
    EXPECT_EQ(ErrorOf([&] { device->WaitFor(held); }).Kind(), ErrorKind::DeviceLost);
    first.Open();
    while (device->CompletedValue() < held.value) std::this_thread::yield();
    const rhi::Submission last = SubmitAfter(second);
    std::jthread opener([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        second.Open();
    });
    EXPECT_NO_THROW(device->WaitFor(last));
}

#ifndef __SANITIZE_ADDRESS__  // the remaining allocations are leaked on purpose
// The work of this device waits for a signal that comes after the device was destroyed.
struct NeverTest : SlowQueueTest {
    NeverTest() : vk(device->Vk()), handle(device->Handle()), timeline(device->Timeline()) {
        VkSemaphoreTypeCreateInfo type{};
        type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
        type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
        const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
        EXPECT_EQ(vk.vkCreateSemaphore(handle, &info, nullptr, &never.semaphore), VK_SUCCESS);
        value = device->Submit(device->BeginCommands("waits"), {&never, 1});
    }
    // Lets the rest of the work finish before the process ends, where a driver may wait for it forever.
    ~NeverTest() override {
        const VkSemaphoreSignalInfo signal{VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO, nullptr, never.semaphore,
                                           1};
        EXPECT_EQ(vk.vkSignalSemaphore(handle, &signal), VK_SUCCESS);
        const VkSemaphoreWaitInfo wait{
            VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO, nullptr, 0, 1, &timeline, &value.value};
        EXPECT_EQ(vk.vkWaitSemaphores(handle, &wait, UINT64_MAX), VK_SUCCESS) << "nothing of it was freed";
    }

    const rhi::DeviceFunctions vk;
    const VkDevice handle;
    const VkSemaphore timeline;
    rhi::SemaphoreUse never{.value = 1};
    rhi::Submission value;
};

TEST_F(NeverTest, DestroyingIt_LeavesItAsItIs) {
    device.reset();
    EXPECT_EQ(log.Text(), "device 'hanging' hangs: nothing of it is freed\n");
}

TEST_F(NeverTest, DestroyingOneThatIsKnownToHang_TakesNoWait) {
    EXPECT_EQ(ErrorOf([&] { device->WaitFor(value); }).Kind(), ErrorKind::DeviceLost);
    const auto start = std::chrono::steady_clock::now();
    device.reset();
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(300)) << "the limit is 400";
    EXPECT_EQ(log.Text(), "device 'hanging' hangs: nothing of it is freed\n");
}
#endif

TEST(HangLimit, IsOffOnACpuDevice) {
    const std::unique_ptr<rhi::Device> device = rhi::Device::Create({.savePipelineCache = false});
    const std::chrono::milliseconds expected =
        device->Info().type == rhi::DeviceType::Cpu ? std::chrono::milliseconds(0) : rhi::kDefaultHangLimit;
    EXPECT_EQ(device->HangLimit(), expected);
    EXPECT_EQ(
        rhi::Device::Create({.hangLimit = std::chrono::seconds(7), .savePipelineCache = false})->HangLimit(),
        std::chrono::seconds(7));
}

}  // namespace
}  // namespace raygraph::testing::device_test

// Tests what a device logs to DeviceDesc::log.
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
    commands.OnSubmitted([&] { WriteLog(throwing, LogLevel::Info, log_category::kGraph, "submitted"); });
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

// Tests that a host's device is checked, used through the host's allocator and queue lock, and left as it
// was.
namespace raygraph::testing::adopt_test {
namespace {

using rhi::BufferUsage;
using ::testing::HasSubstr;

struct AdoptTest : ::testing::Test {
    ~AdoptTest() override { EXPECT_EQ(host.ValidationText(), ""); }
    HostDevice host;
};

TEST_F(AdoptTest, WorkRunsOnTheHostsDevice) {
    const std::unique_ptr<rhi::Device> device = rhi::Device::Adopt(host.Desc());
    EXPECT_EQ(device->Handle(), host.Handle());
    const rhi::Buffer buffer = device->CreateBuffer(
        {.name = "b", .size = 16, .usage = BufferUsage::CopySource | BufferUsage::CopyDestination});
    rhi::Uploader uploader(*device);
    const std::vector<uint32_t> values{1, 2, 3, 4};
    uploader.UploadBuffer(buffer, 0, BytesOf(values));
    uploader.Flush();
    EXPECT_EQ(As<uint32_t>(rhi::ReadBuffer(*device, buffer)), values);
}

TEST_F(AdoptTest, AllocationCallbacks_AreUsedAndBalanced) {
    CountingAllocator allocator;
    rhi::AdoptedDeviceDesc desc = host.Desc();
    desc.allocationCallbacks = allocator.Callbacks();
    {
        const std::unique_ptr<rhi::Device> device = rhi::Device::Adopt(desc);
        const rhi::Buffer buffer = device->CreateBuffer({.name = "b", .size = 1024});
        const rhi::Texture texture = device->CreateTexture({.name = "t", .extent = {8, 8}});
        const rhi::Sampler sampler = device->CreateSampler({});
        device->Submit(device->BeginCommands("empty"));
        EXPECT_GT(allocator.Live(), 0);
    }
    EXPECT_GT(allocator.Total(), 0);
    EXPECT_EQ(allocator.Live(), 0);
}

TEST_F(AdoptTest, QueueLock_IsHeldAroundEverySubmission) {
    int locks = 0;
    bool isHeld = false;
    rhi::AdoptedDeviceDesc desc = host.Desc();
    desc.lockQueue = [&] {
        EXPECT_FALSE(isHeld);
        isHeld = true;
        ++locks;
    };
    desc.unlockQueue = [&] {
        EXPECT_TRUE(isHeld);
        isHeld = false;
    };
    const std::unique_ptr<rhi::Device> device = rhi::Device::Adopt(desc);
    for (int i = 0; i < 3; ++i) device->Submit(device->BeginCommands("frame"));
    device->WaitIdle();
    EXPECT_EQ(locks, 3);
    EXPECT_FALSE(isHeld);
}

TEST_F(AdoptTest, DestroyingTheDevice_LeavesTheHostsObjects) {
    rhi::Device::Adopt(host.Desc());
    VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, nullptr, 0};
    VkSemaphore semaphore = VK_NULL_HANDLE;
    ASSERT_EQ(host.Functions().vkCreateSemaphore(host.Handle(), &info, nullptr, &semaphore), VK_SUCCESS);
    host.Functions().vkDestroySemaphore(host.Handle(), semaphore, nullptr);
    EXPECT_NE(rhi::Device::Adopt(host.Desc()), nullptr) << "it can be adopted again";
}

TEST_F(AdoptTest, TwoAdoptersOfOneDevice_ShareTheQueueUnderItsLock) {
    std::mutex queue;
    rhi::AdoptedDeviceDesc desc = host.Desc();
    desc.lockQueue = [&] { queue.lock(); };
    desc.unlockQueue = [&] { queue.unlock(); };
    const std::unique_ptr<rhi::Device> first = rhi::Device::Adopt(desc);
    const std::unique_ptr<rhi::Device> second = rhi::Device::Adopt(desc);
    EXPECT_EQ(first->Submit(first->BeginCommands("a")).value, 1u);
    EXPECT_EQ(second->Submit(second->BeginCommands("b")).value, 1u) << "each has a timeline of its own";
    first->WaitIdle();
    second->WaitIdle();
}

TEST_F(AdoptTest, WrappedImage_StaysTheHosts) {
    VkImageCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = VK_FORMAT_R32_SFLOAT;
    info.extent = {4, 2, 1};
    info.mipLevels = 1;
    info.arrayLayers = 1;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.usage =
        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    const rhi::DeviceFunctions& vk = host.Functions();
    VkImage image = VK_NULL_HANDLE;
    ASSERT_EQ(vk.vkCreateImage(host.Handle(), &info, nullptr, &image), VK_SUCCESS);
    const VkImageMemoryRequirementsInfo2 ask{VK_STRUCTURE_TYPE_IMAGE_MEMORY_REQUIREMENTS_INFO_2, nullptr,
                                             image};
    VkMemoryRequirements2 needs{VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2, nullptr, {}};
    vk.vkGetImageMemoryRequirements2(host.Handle(), &ask, &needs);
    const VkMemoryAllocateInfo allocate{
        VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.memoryRequirements.size,
        static_cast<uint32_t>(std::countr_zero(needs.memoryRequirements.memoryTypeBits))};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    ASSERT_EQ(vk.vkAllocateMemory(host.Handle(), &allocate, nullptr, &memory), VK_SUCCESS);
    const VkBindImageMemoryInfo bind{VK_STRUCTURE_TYPE_BIND_IMAGE_MEMORY_INFO, nullptr, image, memory, 0};
    ASSERT_EQ(vk.vkBindImageMemory2(host.Handle(), 1, &bind), VK_SUCCESS);
    {
        const std::unique_ptr<rhi::Device> device = rhi::Device::Adopt(host.Desc());
        const rhi::TextureDesc desc{.name = "host image",
                                    .extent = {4, 2},
                                    .format = rhi::Format::R32Float,
                                    .usage = rhi::TextureUsage::Sampled | rhi::TextureUsage::CopySource |
                                             rhi::TextureUsage::CopyDestination};
        const rhi::Texture texture = device->WrapTexture(desc, image);
        EXPECT_FALSE(texture.OwnsImage());
        EXPECT_EQ(device->Memory().usedBytes, 0u);
        rhi::Uploader uploader(*device);
        const std::vector<float> texels{0, 1, 2, 3, 4, 5, 6, 7};
        uploader.UploadTexture(texture, BytesOf(texels));
        uploader.Flush();
        EXPECT_EQ(As<float>(rhi::ReadTexture(*device, texture, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)),
                  texels);
    }
    // The host still owns the image: the layers would report a second destruction.
    vk.vkDestroyImage(host.Handle(), image, nullptr);
    vk.vkFreeMemory(host.Handle(), memory, nullptr);
}

TEST_F(AdoptTest, WrappedBuffer_StaysTheHosts) {
    const rhi::DeviceFunctions& vk = host.Functions();
    const auto bindBuffer = reinterpret_cast<PFN_vkBindBufferMemory2>(
        host.InstanceFunctions().vkGetDeviceProcAddr(host.Handle(), "vkBindBufferMemory2"));
    const auto make = [&](VkBufferUsageFlags usage, VkMemoryAllocateFlags flags) {
        VkBufferCreateInfo info{};
        info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
        info.size = 16;
        info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT | usage;
        VkBuffer buffer = VK_NULL_HANDLE;
        EXPECT_EQ(vk.vkCreateBuffer(host.Handle(), &info, nullptr, &buffer), VK_SUCCESS);
        const VkDeviceBufferMemoryRequirements ask{VK_STRUCTURE_TYPE_DEVICE_BUFFER_MEMORY_REQUIREMENTS,
                                                   nullptr, &info};
        VkMemoryRequirements2 needs{VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2, nullptr, {}};
        vk.vkGetDeviceBufferMemoryRequirements(host.Handle(), &ask, &needs);
        const VkMemoryAllocateFlagsInfo how{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO, nullptr, flags, 0};
        const VkMemoryAllocateInfo allocate{
            VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &how, needs.memoryRequirements.size,
            static_cast<uint32_t>(std::countr_zero(needs.memoryRequirements.memoryTypeBits))};
        VkDeviceMemory memory = VK_NULL_HANDLE;
        EXPECT_EQ(vk.vkAllocateMemory(host.Handle(), &allocate, nullptr, &memory), VK_SUCCESS);
        const VkBindBufferMemoryInfo bind{VK_STRUCTURE_TYPE_BIND_BUFFER_MEMORY_INFO, nullptr, buffer, memory,
                                          0};
        EXPECT_EQ(bindBuffer(host.Handle(), 1, &bind), VK_SUCCESS);
        return std::pair(buffer, memory);
    };
    // The layers would report an address query for the buffer without one.
    const auto plain = make(0, 0);
    const auto addressed =
        make(VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
             VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT);
    {
        const std::unique_ptr<rhi::Device> device = rhi::Device::Adopt(host.Desc());
        const rhi::BufferDesc desc{.name = "host buffer",
                                   .size = 16,
                                   .usage = BufferUsage::CopySource | BufferUsage::CopyDestination};
        const rhi::Buffer buffer = device->WrapBuffer(desc, plain.first);
        EXPECT_FALSE(buffer.OwnsBuffer());
        EXPECT_TRUE(buffer.Mapped().empty());
        EXPECT_EQ(device->Memory().usedBytes, 0u);
        rhi::Uploader uploader(*device);
        const std::vector<uint32_t> values{1, 2, 3, 4};
        uploader.UploadBuffer(buffer, 0, BytesOf(values));
        uploader.Flush();
        EXPECT_EQ(As<uint32_t>(rhi::ReadBuffer(*device, buffer)), values);
        EXPECT_NE(device->WrapBuffer({.name = "addressed", .size = 16}, addressed.first).Address(), 0u);

        EXPECT_THAT(ErrorOf([&] { std::ignore = device->WrapBuffer(desc, VK_NULL_HANDLE); }).what(),
                    HasSubstr("the host's buffer is null"));
        rhi::BufferDesc mapped = desc;
        mapped.memory = rhi::MemoryKind::Upload;
        EXPECT_EQ(ErrorOf([&] { std::ignore = device->WrapBuffer(mapped, plain.first); }).Kind(),
                  ErrorKind::Usage);
    }
    // The host still owns them: the layers would report a second destruction.
    for (const auto& [buffer, memory] : {plain, addressed}) {
        vk.vkDestroyBuffer(host.Handle(), buffer, nullptr);
        vk.vkFreeMemory(host.Handle(), memory, nullptr);
    }
}

// ---- What a host may forget.

TEST_F(AdoptTest, ExtensionNotEnabled_IsNamed) {
    rhi::AdoptedDeviceDesc desc = host.Desc();
    std::erase(desc.enabledExtensions, VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME);
    const Error error = ErrorOf([&] { rhi::Device::Adopt(desc); });
    EXPECT_EQ(error.Kind(), ErrorKind::NoDevice);
    EXPECT_THAT(error.what(), HasSubstr("'the host' cannot be used: VK_KHR_push_descriptor is not enabled"));
}

TEST_F(AdoptTest, OptionalExtensionNotEnabled_TurnsTheCapabilityOff) {
    rhi::AdoptedDeviceDesc desc = host.Desc();
    std::erase(desc.enabledExtensions, VK_KHR_RAY_QUERY_EXTENSION_NAME);
    std::erase(desc.enabledExtensions, VK_KHR_SHADER_CLOCK_EXTENSION_NAME);
    const rhi::OptionalFeatures optional = rhi::Device::Adopt(desc)->Info().optional;
    EXPECT_FALSE(optional.rayQuery);
    EXPECT_FALSE(optional.shaderClock);
    EXPECT_EQ(rhi::Device::Adopt(host.Desc())->Info().optional.rayQuery,
              rhi::OptionalFeaturesOf(desc.physicalDevice, desc.getInstanceProcAddr, desc.instance).rayQuery);
}

// No extension tells about features of core Vulkan.
TEST_F(AdoptTest, OptionalFeatureNotEnabled_TurnsTheCapabilityOff) {
    rhi::AdoptedDeviceDesc desc = host.Desc();
    const rhi::OptionalFeatures has =
        rhi::OptionalFeaturesOf(desc.physicalDevice, desc.getInstanceProcAddr, desc.instance);
    EXPECT_EQ(rhi::Device::Adopt(desc)->Info().optional.bufferInt64Atomics, has.bufferInt64Atomics);
    desc.enabledFeatures = has;
    desc.enabledFeatures.bufferInt64Atomics = false;
    desc.enabledFeatures.wireframe = false;
    const rhi::OptionalFeatures optional = rhi::Device::Adopt(desc)->Info().optional;
    EXPECT_FALSE(optional.bufferInt64Atomics);
    EXPECT_FALSE(optional.wireframe);
    EXPECT_EQ(optional.multiDrawIndirect, has.multiDrawIndirect) << "what is enabled stays";
}

// Core Vulkan does not tell what a device was made with: a feature that a host does not list may be off.
TEST_F(AdoptTest, HostThatListsNothing_HasNoOptionalFeature) {
    rhi::AdoptedDeviceDesc desc;
    const rhi::AdoptedDeviceDesc full = host.Desc();
    desc.instance = full.instance;
    desc.physicalDevice = full.physicalDevice;
    desc.device = full.device;
    desc.queue = full.queue;
    desc.queueFamily = full.queueFamily;
    desc.getInstanceProcAddr = full.getInstanceProcAddr;
    desc.enabledExtensions = full.enabledExtensions;
    rhi::OptionalFeatures optional = rhi::Device::Adopt(desc)->Info().optional;
    optional.memoryBudget = false;  // is no feature: its extension is listed
    EXPECT_EQ(optional, rhi::OptionalFeatures{});
    EXPECT_NE(rhi::Device::Adopt(full)->Info().optional, rhi::OptionalFeatures{});
}

TEST_F(AdoptTest, OptionalFeatureSaidToBeEnabled_IsOffWhereItsExtensionIs) {
    rhi::AdoptedDeviceDesc desc = host.Desc();
    std::erase(desc.enabledExtensions, VK_KHR_RAY_QUERY_EXTENSION_NAME);
    desc.enabledFeatures = rhi::OptionalFeatures{.rayQuery = true};
    EXPECT_FALSE(rhi::Device::Adopt(desc)->Info().optional.rayQuery);
}

TEST_F(AdoptTest, NullHandle_IsNamed) {
    rhi::AdoptedDeviceDesc desc = host.Desc();
    desc.queue = VK_NULL_HANDLE;
    const Error error = ErrorOf([&] { rhi::Device::Adopt(desc); });
    EXPECT_EQ(error.Kind(), ErrorKind::Usage);
    EXPECT_STREQ(error.what(), "adopted device 'the host': queue is null");
}

TEST_F(AdoptTest, LockWithoutUnlock_IsRefused) {
    rhi::AdoptedDeviceDesc desc = host.Desc();
    desc.lockQueue = [] {};
    EXPECT_EQ(ErrorOf([&] { rhi::Device::Adopt(desc); }).Kind(), ErrorKind::Usage);
}

TEST_F(AdoptTest, QueueFamilyThatDoesNotExist_IsRefused) {
    rhi::AdoptedDeviceDesc desc = host.Desc();
    desc.queueFamily = 1000;
    EXPECT_THAT(ErrorOf([&] { rhi::Device::Adopt(desc); }).what(),
                HasSubstr("queue family 1000 does not exist"));
}

}  // namespace
}  // namespace raygraph::testing::adopt_test
