// Devices with several queues, and with an allocator of the host's. Where the machine has one queue family, the
// host gives its one queue three times: each still has a timeline of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <chrono>
#include <memory>
#include <mutex>
#include <numeric>
#include <thread>
#include <vector>

#include "rhi/command_list.h"
#include "rhi/device.h"
#include "rhi/transfer.h"
#include "tests/rhi/fake_loader.h"
#include "tests/rhi/gate.h"
#include "tests/rhi/host_device.h"
#include "tests/support/error_of.h"

namespace raygraph::testing::queues_test {
namespace {

using rhi::BufferUsage;
using rhi::QueueKind;
using rhi::Submission;
using rhi::TextureUsage;
using ::testing::HasSubstr;

constexpr BufferUsage kCopies = BufferUsage::CopySource | BufferUsage::CopyDestination;

std::vector<std::byte> Ramp(size_t count) {
    std::vector<std::byte> bytes(count);
    for (size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(i * 7 + i / 251);
    return bytes;
}

struct QueuesTest : ::testing::Test {
    QueuesTest() {
        rhi::AdoptedDeviceDesc desc = host.DescWithQueues();
        desc.getInstanceProcAddr = loader.Entry();
        device = rhi::Device::Adopt(desc);
    }
    ~QueuesTest() override {
        host.Functions().vkQueueWaitIdle(host.Desc().queue);  // as Gate does
        device.reset();
        EXPECT_EQ(host.ValidationText(), "");
    }
    Submission Run(QueueKind queue) { return device->Submit(device->BeginCommands("empty", queue)); }
    // Returns the value of that queue's timeline for which the last submission waits; 0 for none.
    uint64_t WaitsFor(QueueKind queue) {
        for (const VkSemaphoreSubmitInfo& wait : loader.Tell().submitWaits.back())
            if (wait.semaphore == device->Timeline(queue)) return wait.value;
        return 0;
    }

    FakeLoader loader;
    HostDevice host;
    std::unique_ptr<rhi::Device> device;
};

TEST_F(QueuesTest, EveryQueueCountsItsOwnSubmissions) {
    Run(QueueKind::Main);
    const Submission first = Run(QueueKind::Main);
    const Submission other = Run(QueueKind::Compute);
    EXPECT_EQ(first, (Submission{2, QueueKind::Main}));
    EXPECT_EQ(other, (Submission{1, QueueKind::Compute}));
    device->WaitFor(other);
    EXPECT_EQ(device->CompletedValue(QueueKind::Compute), 1u);
    EXPECT_TRUE(device->HasCompleted(other));
    EXPECT_EQ(device->LastSubmittedValue(QueueKind::Transfer), 0u);
    device->WaitIdle();
    EXPECT_TRUE(device->HasCompleted(first));
    EXPECT_THAT(ErrorOf([&] {
                    device->WaitFor({3, QueueKind::Compute});
                }).what(),
                HasSubstr("the last submission is 1"));
}

TEST_F(QueuesTest, WorkOfOneQueue_CanWaitForAnother) {
    Gate gate(*device);
    const rhi::SemaphoreUse opened = gate.At(1);
    const Submission held = device->Submit(device->BeginCommands("held", QueueKind::Compute), {&opened, 1});
    const rhi::SemaphoreUse after = device->After(held);
    const Submission next = device->Submit(device->BeginCommands("next"), {&after, 1});
    EXPECT_FALSE(device->HasCompleted(next));
    gate.Open();
    device->WaitFor(next);
    EXPECT_TRUE(device->HasCompleted(held));
}

// The main queue completes nothing for longer than the limit, but the compute queue goes on. Validation layers
// would wait for the gates on a thread of their own, and report a timeout.
TEST(Queues, ProgressOfAnotherQueue_IsNoHang) {
    const HostDevice host(false);
    rhi::AdoptedDeviceDesc desc = host.DescWithQueues();
    desc.hangLimit = std::chrono::milliseconds(400);
    const std::unique_ptr<rhi::Device> slow = rhi::Device::Adopt(desc);
    std::vector<std::unique_ptr<Gate>> gates;
    Submission last;
    for (int i = 0; i < 5; ++i) {
        const rhi::SemaphoreUse opened = gates.emplace_back(std::make_unique<Gate>(*slow))->At(1);
        last = slow->Submit(slow->BeginCommands("step", QueueKind::Compute), {&opened, 1});
    }
    const rhi::SemaphoreUse after = slow->After(last);
    const Submission held = slow->Submit(slow->BeginCommands("held"), {&after, 1});
    const std::jthread opener([&] {
        for (const auto& gate : gates) {
            std::this_thread::sleep_for(std::chrono::milliseconds(120));
            gate->Open();
        }
    });
    EXPECT_NO_THROW(slow->WaitFor(held)) << "600 ms in steps of 120 ms, with a limit of 400 ms";
}

// The pool of a list that was dropped is one of that list's family.
TEST_F(QueuesTest, DroppedList_LeavesItsPoolToItsQueue) {
    VkCommandBuffer dropped = VK_NULL_HANDLE;
    {
        const rhi::CommandList list = device->BeginCommands("dropped", QueueKind::Compute);
        dropped = list.Handle();
    }
    const rhi::CommandList onMain = device->BeginCommands("main");
    EXPECT_NE(onMain.Handle(), dropped);
    EXPECT_EQ(device->BeginCommands("compute", QueueKind::Compute).Handle(), dropped);
}

// A program that uses no queue but the main one must not have to know of uploads on another.
TEST_F(QueuesTest, LaterWork_WaitsForTransfersOnce) {
    Run(QueueKind::Transfer);
    const Submission transfer = Run(QueueKind::Transfer);
    Run(QueueKind::Main);
    EXPECT_EQ(WaitsFor(QueueKind::Transfer), transfer.value);
    Run(QueueKind::Main);
    EXPECT_EQ(WaitsFor(QueueKind::Transfer), 0u) << "the queue has waited";
    Run(QueueKind::Compute);
    EXPECT_EQ(WaitsFor(QueueKind::Transfer), transfer.value) << "this one has not";
    Run(QueueKind::Transfer);
    EXPECT_EQ(WaitsFor(QueueKind::Transfer), 0u);
    device->JoinTransfers();
    EXPECT_EQ(WaitsFor(QueueKind::Transfer), transfer.value + 1);
    const uint64_t submitted = device->LastSubmittedValue();
    device->JoinTransfers();
    EXPECT_EQ(device->LastSubmittedValue(), submitted) << "there is nothing to wait for";
}

TEST_F(QueuesTest, Object_LivesUntilEveryQueueHasPassedIt) {
    const uint64_t used = device->Memory().usedBytes;
    Gate gate(*device);
    const rhi::SemaphoreUse opened = gate.At(1);
    Submission held;
    {
        const rhi::Buffer buffer = device->CreateBuffer({.name = "b", .size = 1 << 16, .usage = kCopies});
        rhi::CommandList commands = device->BeginCommands("fills", QueueKind::Compute);
        commands.Fill(buffer, 1);
        held = device->Submit(std::move(commands), {&opened, 1});
    }
    device->CollectGarbage();
    EXPECT_GT(device->Memory().usedBytes, used);
    gate.Open();
    device->WaitFor(held);
    EXPECT_EQ(device->Memory().usedBytes, used);
}

TEST_F(QueuesTest, UploadOnTheTransferQueue_ArrivesBeforeLaterWork) {
    rhi::Uploader uploader(*device, {.queue = QueueKind::Transfer, .stagingBytes = 256 << 10});
    const std::vector<std::byte> bytes = Ramp(700'000);  // more than the ring
    const rhi::Buffer buffer = device->CreateBuffer({.name = "b", .size = bytes.size(), .usage = kCopies});
    uploader.UploadBuffer(buffer, 0, bytes);
    const Submission arrived = uploader.Flush();
    EXPECT_EQ(arrived.queue, QueueKind::Transfer);
    EXPECT_EQ(rhi::ReadBuffer(*device, buffer), bytes);
}

TEST_F(QueuesTest, MipLevelsOfATransfer_AreMadeByTheMainQueue) {
    rhi::Uploader uploader(*device, {.queue = QueueKind::Transfer});
    const rhi::TextureDesc desc{
        .name = "t",
        .extent = {16, 8},
        .usage = TextureUsage::Sampled | TextureUsage::CopyDestination | TextureUsage::CopySource,
        .mipLevels = 3};
    const rhi::Texture texture = device->CreateTexture(desc), other = device->CreateTexture(desc);
    EXPECT_EQ(texture.IsShared(), device->QueueFamilies().size() > 1);
    const std::vector<std::byte> level0 = Ramp(16 * 8 * 4);
    uploader.UploadTexture(texture, level0);
    EXPECT_EQ(uploader.Flush().queue, QueueKind::Main);
    rhi::Uploader onMain(*device);
    onMain.UploadTexture(other, level0);
    onMain.Flush();
    for (uint32_t level = 0; level < 3; ++level)
        EXPECT_EQ(rhi::ReadTexture(*device, texture, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, level),
                  rhi::ReadTexture(*device, other, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, level))
            << level;
}

TEST_F(QueuesTest, FamilyThatDoesNotSuit_IsRefused) {
    rhi::AdoptedDeviceDesc desc = host.DescWithQueues();
    desc.computeQueue.family = 1000;
    EXPECT_THAT(ErrorOf([&] { rhi::Device::Adopt(desc); }).what(),
                HasSubstr("queue family 1000 does not exist"));
}

TEST(OneQueue, OtherQueues_AreMissing) {
    HostDevice host;
    const std::unique_ptr<rhi::Device> device = rhi::Device::Adopt(host.Desc());
    EXPECT_TRUE(device->HasQueue(QueueKind::Main));
    EXPECT_FALSE(device->HasQueue(QueueKind::Compute));
    EXPECT_EQ(ErrorOf([&] { device->BeginCommands("none", QueueKind::Compute); }).Kind(), ErrorKind::Usage);
    rhi::Uploader uploader(*device, {.queue = QueueKind::Transfer});
    const rhi::Buffer buffer = device->CreateBuffer({.name = "b", .size = 1000, .usage = kCopies});
    uploader.UploadBuffer(buffer, 0, Ramp(1000));
    EXPECT_EQ(uploader.Flush().queue, QueueKind::Main);
    EXPECT_EQ(rhi::ReadBuffer(*device, buffer), Ramp(1000));
}

// --- An allocator of the host's ---

// Gives every resource a piece of its own allocation, at an offset, as an allocator of blocks does.
class HostAllocator final : public rhi::MemoryAllocator {
  public:
    explicit HostAllocator(const HostDevice& host)
        : m_vk(host.Functions()),
          m_map(reinterpret_cast<PFN_vkMapMemory>(
              host.InstanceFunctions().vkGetDeviceProcAddr(host.Handle(), "vkMapMemory"))),
          m_device(host.Handle()) {
        VkPhysicalDeviceMemoryProperties2 properties{
            VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_PROPERTIES_2, nullptr, {}};
        host.InstanceFunctions().vkGetPhysicalDeviceMemoryProperties2(host.PhysicalDevice(), &properties);
        m_properties = properties.memoryProperties;
    }

    VkResult CreateBuffer(const VkBufferCreateInfo& info, const rhi::MemoryRequest& request, VkBuffer& buffer,
                          rhi::MemoryAllocation& memory) override {
        VkResult result = m_vk.vkCreateBuffer(m_device, &info, nullptr, &buffer);
        if (result != VK_SUCCESS) return result;
        const VkDeviceBufferMemoryRequirements ask{VK_STRUCTURE_TYPE_DEVICE_BUFFER_MEMORY_REQUIREMENTS,
                                                   nullptr, &info};
        VkMemoryRequirements2 needed{VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2, nullptr, {}};
        m_vk.vkGetDeviceBufferMemoryRequirements(m_device, &ask, &needed);
        result = Allocate(needed.memoryRequirements, request, memory);
        if (result != VK_SUCCESS) {
            m_vk.vkDestroyBuffer(m_device, buffer, nullptr);
            buffer = VK_NULL_HANDLE;
            return result;
        }
        const VkBindBufferMemoryInfo bind{VK_STRUCTURE_TYPE_BIND_BUFFER_MEMORY_INFO, nullptr, buffer,
                                          memory.memory, memory.offset};
        return m_vk.vkBindBufferMemory2(m_device, 1, &bind);
    }

    VkResult CreateImage(const VkImageCreateInfo& info, const rhi::MemoryRequest& request, VkImage& image,
                         rhi::MemoryAllocation& memory) override {
        VkResult result = m_vk.vkCreateImage(m_device, &info, nullptr, &image);
        if (result != VK_SUCCESS) return result;
        VkDeviceImageMemoryRequirements ask{};
        ask.sType = VK_STRUCTURE_TYPE_DEVICE_IMAGE_MEMORY_REQUIREMENTS;
        ask.pCreateInfo = &info;
        VkMemoryRequirements2 needed{VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2, nullptr, {}};
        m_vk.vkGetDeviceImageMemoryRequirements(m_device, &ask, &needed);
        result = Allocate(needed.memoryRequirements, request, memory);
        if (result != VK_SUCCESS) {
            m_vk.vkDestroyImage(m_device, image, nullptr);
            image = VK_NULL_HANDLE;
            return result;
        }
        const VkBindImageMemoryInfo bind{VK_STRUCTURE_TYPE_BIND_IMAGE_MEMORY_INFO, nullptr, image,
                                         memory.memory, memory.offset};
        return m_vk.vkBindImageMemory2(m_device, 1, &bind);
    }

    VkResult Allocate(const VkMemoryRequirements& requirements, const rhi::MemoryRequest& request,
                      rhi::MemoryAllocation& memory) override {
        const std::lock_guard lock(m_mutex);
        if (m_live == limit) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
        const VkMemoryPropertyFlags needed =
            request.kind == rhi::MemoryKind::Device
                ? (request.mustBeDeviceLocal ? VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT : 0)
                : VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
        memory.memoryType = 0;
        while ((requirements.memoryTypeBits >> memory.memoryType & 1) == 0 ||
               (m_properties.memoryTypes[memory.memoryType].propertyFlags & needed) != needed)
            ++memory.memoryType;
        memory.offset = std::lcm(requirements.alignment, request.alignment);
        memory.size = requirements.size;
        VkMemoryAllocateFlagsInfo flags{};
        flags.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO;
        flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
        const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags,
                                        memory.offset + memory.size, memory.memoryType};
        const VkResult result = m_vk.vkAllocateMemory(m_device, &info, nullptr, &memory.memory);
        if (result != VK_SUCCESS) return result;
        if (request.kind != rhi::MemoryKind::Device) {
            void* mapped = nullptr;
            m_map(m_device, memory.memory, memory.offset, memory.size, 0, &mapped);
            memory.mapped = static_cast<std::byte*>(mapped);
        }
        memory.handle = this;
        ++m_live;
        ++total;
        return VK_SUCCESS;
    }

    void Free(const rhi::MemoryAllocation& memory) noexcept override {
        const std::lock_guard lock(m_mutex);
        EXPECT_EQ(memory.handle, this);
        m_vk.vkFreeMemory(m_device, memory.memory, nullptr);
        --m_live;
    }

    int Live() const { return m_live; }
    int limit = -1;  // allocations that may exist at once; -1: any number
    int total = 0;

  private:
    const rhi::DeviceFunctions& m_vk;
    PFN_vkMapMemory m_map;
    VkDevice m_device;
    VkPhysicalDeviceMemoryProperties m_properties{};
    std::mutex m_mutex;
    int m_live = 0;
};

struct HostAllocatorTest : ::testing::Test {
    HostAllocatorTest() {
        rhi::AdoptedDeviceDesc desc = host.Desc();
        desc.memoryAllocator = &allocator;
        device = rhi::Device::Adopt(desc);
    }
    ~HostAllocatorTest() override {
        device.reset();
        EXPECT_EQ(allocator.Live(), 0) << "all is freed with the device";
        EXPECT_EQ(host.ValidationText(), "");
    }
    HostDevice host;
    HostAllocator allocator{host};
    std::unique_ptr<rhi::Device> device;
};

TEST_F(HostAllocatorTest, AllMemory_ComesFromIt) {
    const std::vector<std::byte> bytes = Ramp(4096);
    const rhi::Buffer buffer = device->CreateBuffer({.name = "b", .size = bytes.size(), .usage = kCopies});
    const rhi::Texture texture = device->CreateTexture(
        {.name = "t",
         .extent = {32, 32},
         .usage = TextureUsage::Sampled | TextureUsage::CopySource | TextureUsage::CopyDestination});
    EXPECT_EQ(allocator.Live(), 2);
    rhi::Uploader uploader(*device);
    uploader.UploadBuffer(buffer, 0, bytes);
    uploader.UploadTexture(texture, bytes);
    uploader.Flush();
    EXPECT_EQ(rhi::ReadBuffer(*device, buffer), bytes);
    EXPECT_EQ(rhi::ReadTexture(*device, texture, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL), bytes);
    EXPECT_GT(device->Memory().usedBytes, 2 * bytes.size());
}

// Two resources of a block lie at the offset that the allocator gave, not at the start of its memory.
TEST_F(HostAllocatorTest, Block_IsSharedAtItsOffset) {
    const rhi::BufferDesc desc{.name = "b", .size = 4096, .usage = kCopies};
    const rhi::MemoryBlock block = device->CreateMemoryBlock("block", device->RequirementsOf(desc));
    const rhi::Buffer first = device->CreateBuffer(desc, block), second = device->CreateBuffer(desc, block);
    EXPECT_EQ(allocator.total, 1);
    rhi::Uploader uploader(*device);
    uploader.UploadBuffer(first, 0, Ramp(4096));
    uploader.Flush();
    EXPECT_EQ(rhi::ReadBuffer(*device, second), Ramp(4096));
}

TEST_F(HostAllocatorTest, Refusal_IsAnErrorWithTheName) {
    allocator.limit = 0;
    const auto make = [&] {
        std::ignore = device->CreateBuffer({.name = "big", .size = 16, .usage = kCopies});
    };
    const Error error = ErrorOf(make);
    EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory);
    EXPECT_THAT(error.what(), HasSubstr("buffer 'big' (16 bytes)"));
    EXPECT_EQ(device->Memory().usedBytes, 0u);
    allocator.limit = -1;
    EXPECT_NO_THROW(make());
}

}  // namespace
}  // namespace raygraph::testing::queues_test
