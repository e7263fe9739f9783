// Tests which memory resources use, what is reported of it, and what happens when it is exhausted.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <tuple>

#include "rhi/blas_builder.h"
#include "rhi/command_list.h"
#include "rhi/upload.h"
#include "tests/rhi/fake_loader.h"
#include "tests/support/error_of.h"
#include "tests/support/padded_structures.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::memory_test {
namespace {

using rhi::BufferUsage;
using rhi::MemoryKind;
using testing::ErrorOf;
using testing::FakeLoader;
using testing::PaddedStructures;

// The device has memory of its own beside the host's, unlike the CPU driver.
class SeparateMemoryTest : public ::testing::Test {
  protected:
    SeparateMemoryTest() {
        loader.Tell().hasSeparateMemory = true;
        rhi::DeviceDesc desc;
        desc.getInstanceProcAddr = loader.Entry();
        desc.log = log.Listener();
        desc.savePipelineCache = false;
        device = rhi::Device::Create(desc);
    }
    uint64_t Taken(testing::FakeMemoryType type) { return loader.Tell().takenBytes.at(type); }

    FakeLoader loader;
    testing::MessageLog log;
    std::unique_ptr<rhi::Device> device;
};

TEST_F(SeparateMemoryTest, WhatIsUploadedWaitsInTheHostsMemory) {
    const rhi::Buffer target =
        device->CreateBuffer({.name = "target", .size = 4096, .usage = BufferUsage::CopyDestination});
    EXPECT_GT(Taken(testing::kDeviceMemory), 0u);
    rhi::Uploader uploader(*device);
    uploader.UploadBuffer(target, 0, std::vector<std::byte>(4096));
    device->WaitFor(uploader.Flush());
    EXPECT_GT(Taken(testing::kHostMemory), 0u);
    EXPECT_EQ(Taken(testing::kMappedDeviceMemory), 0u) << "little of it can be mapped";

    const rhi::Buffer readback = device->CreateBuffer({.name = "readback",
                                                       .size = 4096,
                                                       .usage = BufferUsage::CopyDestination,
                                                       .memory = MemoryKind::Readback});
    EXPECT_GT(Taken(testing::kCachedHostMemory), 0u);
    const rhi::Buffer uniforms = device->CreateBuffer(
        {.name = "uniforms", .size = 4096, .usage = BufferUsage::Uniform, .memory = MemoryKind::Upload});
    EXPECT_GT(Taken(testing::kMappedDeviceMemory), 0u) << "shaders read these where they are";
}

TEST_F(SeparateMemoryTest, FullDeviceMemoryIsToldAndCounted) {
    loader.Tell().deviceBytesLeft = 0;
    {
        const rhi::Buffer first = device->CreateBuffer({.name = "first", .size = 1u << 20});
        const rhi::Texture second = device->CreateTexture({.name = "second", .extent = {256, 256}});
        const rhi::MemoryBlock third =
            device->CreateMemoryBlock("third", {.size = 4096, .alignment = 256, .memoryTypeBits = 0xF});
        EXPECT_GE(device->Memory().fallbackBytes, (1u << 20) + 4u * 256 * 256 + 4096);
        EXPECT_EQ(device->Memory().fallbackBytes, device->Memory().usedBytes);
        const rhi::Buffer staging = device->CreateBuffer(
            {.name = "staging", .size = 64, .usage = BufferUsage::CopySource, .memory = MemoryKind::Upload});
        EXPECT_LT(device->Memory().fallbackBytes, device->Memory().usedBytes) << "it belongs there";
    }
    EXPECT_EQ(device->Memory().fallbackBytes, 0u);
    EXPECT_EQ(
        log.Text(),
        "device memory is full: buffer 'first' (1048576 bytes) lies in the memory of the host, which is "
        "slow\n")
        << "once";
}

TEST_F(SeparateMemoryTest, OutOfMemoryNamesWhatThereIs) {
    loader.Tell().deviceBytesLeft = 0;
    loader.Tell().hostBytesLeft = 0;
    const Error error = ErrorOf([&] { std::ignore = device->CreateBuffer({.name = "b", .size = 64}); });
    EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory);
    EXPECT_EQ(error.what(),
              std::string("buffer 'b' (64 bytes) (device memory: 1 MiB of 48 MiB in use, 1 MiB of 6 MiB in "
                          "use): VK_ERROR_OUT_OF_DEVICE_MEMORY"));
}

TEST_F(SeparateMemoryTest, HeapsHaveTheDriversBudget) {
    ASSERT_TRUE(device->Info().optional.memoryBudget);
    const std::vector<rhi::MemoryHeap> heaps = device->MemoryHeaps();
    ASSERT_EQ(heaps.size(), 3u);
    EXPECT_TRUE(heaps[0].isDeviceLocal);
    EXPECT_FALSE(heaps[1].isDeviceLocal);
    EXPECT_EQ(heaps[0].sizeBytes, testing::kFakeDeviceHeapBytes);
    EXPECT_EQ(heaps[0].budgetBytes, testing::kFakeDeviceBudgetBytes);
    EXPECT_EQ(heaps[0].usedBytes, 1u << 20);
}

TEST_F(SeparateMemoryTest, HeapsAreAskedForEachTime) {
    EXPECT_EQ(device->MemoryHeaps().at(0).usedBytes, 1u << 20);
    loader.Tell().heapUsage = 20u << 20;  // of another process
    EXPECT_EQ(device->MemoryHeaps().at(0).usedBytes, 20u << 20);
}

// A compacted copy in host memory would replace a structure in device memory for good.
TEST_F(SeparateMemoryTest, AccelerationStructuresAreInTheDevicesOwnMemoryOrWaitForIt) {
    const auto upload = [&](const char* name, const auto& values) {
        rhi::Buffer buffer = device->CreateBuffer({.name = name,
                                                   .size = sizeof(values),
                                                   .usage = BufferUsage::BuildInput,
                                                   .memory = MemoryKind::Upload});
        std::memcpy(buffer.Mapped().data(), &values, sizeof(values));
        return buffer;
    };
    const rhi::Buffer vertices = upload("vertices", std::array<float, 9>{0, 0, 0, 1, 0, 0, 0, 1, 0});
    const rhi::Buffer indices = upload("indices", std::array<uint32_t, 3>{0, 1, 2});
    const rhi::BlasDesc desc{.name = "triangle",
                             .triangles = {{.vertices = vertices.Address(),
                                            .vertexCount = 3,
                                            .indices = indices.Address(),
                                            .triangleCount = 1}}};
    const PaddedStructures padded(*device);
    rhi::BlasBuilder builder(*device, {.name = "builder"});
    const std::shared_ptr<rhi::Blas> blas = builder.Add(desc);
    rhi::CommandList commands = device->BeginCommands("build");
    builder.RecordBuilds(commands);
    device->WaitFor(device->Submit(std::move(commands)));

    loader.Tell().deviceBytesLeft = 0;
    std::vector<rhi::Buffer> rest;  // takes what the allocator has left
    for (uint64_t bytes = 1u << 20; bytes >= 256; bytes /= 2) {
        while (device->Memory().fallbackBytes == 0) rest.push_back(device->CreateBuffer({.size = bytes}));
        rest.pop_back();
    }
    ASSERT_EQ(device->Memory().fallbackBytes, 0u);
    for (uint32_t i = 0; i < 2 * rhi::BlasBuilder::kRetryPolls; ++i) EXPECT_FALSE(builder.Poll());
    EXPECT_EQ(builder.Statistics().pending, 1u);
    const std::shared_ptr<rhi::Blas> another = builder.Add(desc);
    EXPECT_EQ(ErrorOf([&] { builder.Reserve(); }).Kind(), ErrorKind::OutOfMemory);
    EXPECT_EQ(device->Memory().fallbackBytes, 0u);

    loader.Tell().deviceBytesLeft = ~uint64_t{0};
    bool hasWork = false;
    for (uint32_t i = 0; i < rhi::BlasBuilder::kRetryPolls && !hasWork; ++i) hasWork = builder.Poll();
    EXPECT_TRUE(hasWork);
    EXPECT_NO_THROW(builder.Reserve());
    EXPECT_EQ(device->Memory().fallbackBytes, 0u);
}

TEST(MemoryTest, HeapsWithoutTheExtensionAreEstimates) {
    FakeLoader loader;
    loader.Tell().hasSeparateMemory = true;
    loader.Tell().hiddenExtension = VK_EXT_MEMORY_BUDGET_EXTENSION_NAME;
    rhi::DeviceDesc desc;
    desc.getInstanceProcAddr = loader.Entry();
    desc.savePipelineCache = false;
    const std::unique_ptr<rhi::Device> device = rhi::Device::Create(desc);
    EXPECT_FALSE(device->Info().optional.memoryBudget);
    EXPECT_EQ(device->MemoryHeaps().at(0).usedBytes, 0u);
    EXPECT_EQ(device->MemoryHeaps().at(0).budgetBytes, testing::kFakeDeviceHeapBytes * 8 / 10);
    const rhi::Buffer buffer = device->CreateBuffer({.name = "b", .size = 4096});
    EXPECT_GE(device->MemoryHeaps().at(0).usedBytes, 4096u);
}

class MemoryLimitTest : public testing::VulkanTest {};

TEST_F(MemoryLimitTest, WhatWouldExceedItIsRefusedAndNothingElse) {
    const uint64_t used = Device().Memory().usedBytes;
    Device().LimitMemory(used + 4096);
    const rhi::Buffer fits = Device().CreateBuffer({.name = "fits", .size = 4096});
    const Error error = ErrorOf([&] { std::ignore = Device().CreateBuffer({.name = "b", .size = 16}); });
    EXPECT_THROW(std::ignore = Device().CreateTexture({.name = "t", .extent = {1, 1}}), Error);
    EXPECT_THROW(
        std::ignore = Device().CreateMemoryBlock("m", {.size = 16, .alignment = 16, .memoryTypeBits = 1}),
        Error);
    Device().LimitMemory(0);
    EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory);
    const std::string now = std::to_string(used + 4096);
    EXPECT_EQ(error.what(),
              "buffer 'b' (16 bytes): " + now + " of the limit of " + now + " bytes are in use");
    EXPECT_TRUE(Device().CreateBuffer({.name = "b", .size = 16}));
}

// Every buffer that the builds need is refused once; the next call builds what was added.
TEST(BlasAllocationTest, FailedAllocation_LosesNoBuild) {
    FakeLoader loader;
    rhi::DeviceDesc desc;
    desc.getInstanceProcAddr = loader.Entry();
    desc.savePipelineCache = false;
    const std::unique_ptr<rhi::Device> device = rhi::Device::Create(desc);
    const std::vector<float> vertices{0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::vector<uint32_t> indices{0, 1, 2};
    const auto upload = [&](const char* name, std::span<const std::byte> bytes) {
        rhi::Buffer buffer = device->CreateBuffer({.name = name,
                                                   .size = bytes.size(),
                                                   .usage = BufferUsage::BuildInput,
                                                   .memory = MemoryKind::Upload});
        std::copy(bytes.begin(), bytes.end(), buffer.Mapped().begin());
        return buffer;
    };
    const rhi::Buffer vertexBuffer = upload("vertices", testing::BytesOf(vertices));
    const rhi::Buffer indexBuffer = upload("indices", testing::BytesOf(indices));
    const rhi::BlasDesc triangle{.name = "triangle",
                                 .triangles = {{.vertices = vertexBuffer.Address(),
                                                .vertexCount = 3,
                                                .indices = indexBuffer.Address(),
                                                .triangleCount = 1}}};
    int32_t failureCount = 0;
    for (bool hasFailed = true; hasFailed && failureCount < 100;) {
        rhi::BlasBuilder builder(*device, {.name = "builder"});
        const std::array blases{builder.Add(triangle), builder.Add(triangle)};
        loader.Tell().buffersBeforeFailure = failureCount;
        rhi::CommandList commands = device->BeginCommands("builds");
        try {
            builder.RecordBuilds(commands);
            hasFailed = false;
        } catch (const Error& error) {
            EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory);
            EXPECT_FALSE(blases[0]->IsBuilt() || blases[1]->IsBuilt());
            ++failureCount;
        }
        loader.Tell().buffersBeforeFailure = -1;
        if (hasFailed) builder.RecordBuilds(commands);
        device->WaitFor(device->Submit(std::move(commands)));
        EXPECT_EQ(builder.Statistics().buildCount, 2u);
        EXPECT_TRUE(blases[0]->IsBuilt() && blases[1]->IsBuilt());
    }
    EXPECT_GE(failureCount, 3) << "two structures and their scratch memory";
}

}  // namespace
}  // namespace raygraph::memory_test
