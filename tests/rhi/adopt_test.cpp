// Tests that a host's device is checked, used through the host's allocator and queue lock, and left as it
// was.
#include <gmock/gmock.h>

#include "rhi/command_list.h"
#include "rhi/readback.h"
#include "rhi/upload.h"
#include "tests/rhi/host_device.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

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
    EXPECT_EQ(first->Submit(first->BeginCommands("a")), 1u);
    EXPECT_EQ(second->Submit(second->BeginCommands("b")), 1u) << "each has a timeline of its own";
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
