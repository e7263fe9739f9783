// Tests devices: choice, refusals, loss.
#include "rhi/device.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <thread>

#include "rhi/command_list.h"
#include "rhi/readback.h"
#include "tests/rhi/fake_loader.h"
#include "tests/rhi/gate.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

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
    const uint64_t value = device->Submit(device->BeginCommands("frame"));
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
    uint64_t SubmitAfter(const Gate& gate) {
        const rhi::SemaphoreUse wait = gate.At(1);
        return device->Submit(device->BeginCommands("waits"), {&wait, 1});
    }
    MessageLog log;
    std::unique_ptr<rhi::Device> device;
    std::shared_ptr<const void> report;
};

TEST_F(HangTest, WaitBeyondTheLimit_IsALostDeviceThatNamesTheLastPass) {
    const uint64_t before = device->Submit(device->BeginCommands("runs"));
    device->WaitFor(before);
    {
        Gate gate(*device);
        const uint64_t value = SubmitAfter(gate);
        const Error error = ErrorOf([&] { device->WaitFor(value); });
        EXPECT_EQ(error.Kind(), ErrorKind::DeviceLost);
        EXPECT_STREQ(error.what(),
                     "the device hangs: waiting for submission 2, none after 1 has completed for "
                     "50 ms; last pass reached: Trace");
        EXPECT_EQ(ErrorOf([&] { device->WaitIdle(); }).Kind(), ErrorKind::DeviceLost);
        gate.Open();
        while (device->CompletedValue() < value) std::this_thread::yield();
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
    uint64_t last = 0;
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
    const uint64_t held = SubmitAfter(first);
    EXPECT_EQ(ErrorOf([&] { device->WaitFor(held); }).Kind(), ErrorKind::DeviceLost);
    first.Open();
    while (device->CompletedValue() < held) std::this_thread::yield();
    const uint64_t last = SubmitAfter(second);
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
            VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO, nullptr, 0, 1, &timeline, &value};
        EXPECT_EQ(vk.vkWaitSemaphores(handle, &wait, UINT64_MAX), VK_SUCCESS) << "nothing of it was freed";
    }

    const rhi::DeviceFunctions vk;
    const VkDevice handle;
    const VkSemaphore timeline;
    rhi::SemaphoreUse never{.value = 1};
    uint64_t value = 0;
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
