#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <thread>
#include <tuple>

#include "rhi/blas_builder.h"
#include "rhi/command_list.h"
#include "rhi/device.h"
#include "rhi/resources.h"
#include "rhi/retire_queue.h"
#include "rhi/transfer.h"
#include "tests/rhi/fake_loader.h"
#include "tests/rhi/gate.h"
#include "tests/support/error_of.h"
#include "tests/support/padded_structures.h"
#include "tests/support/vulkan_test.h"

// Tests buffers, textures, samplers, memory blocks: their contract, and refusals by name.
namespace raygraph::testing::resources_test {
namespace {

using rhi::BufferUsage;
using rhi::Format;
using rhi::MemoryKind;
using rhi::TextureUsage;
using ::testing::AllOf;
using ::testing::HasSubstr;

using ResourcesTest = VulkanTest;

constexpr BufferUsage kCopies = BufferUsage::CopySource | BufferUsage::CopyDestination;
constexpr TextureUsage kTextureCopies = TextureUsage::CopySource | TextureUsage::CopyDestination;

TEST_F(ResourcesTest, Buffer_HasAnAlignedAddressAndItsSize) {
    for (const uint64_t size : {1, 7, 256, 100001}) {
        const rhi::Buffer buffer = Device().CreateBuffer({.name = "b", .size = size});
        EXPECT_EQ(buffer.Size(), size);
        EXPECT_NE(buffer.Address(), 0u);
        EXPECT_EQ(buffer.Address() % Device().Info().scratchAlignment, 0u);
        EXPECT_TRUE(buffer.Mapped().empty()) << "Device memory is not mapped";
    }
    const rhi::Buffer table = Device().CreateBuffer({.size = 96, .usage = BufferUsage::ShaderBindingTable});
    EXPECT_EQ(table.Address() % Device().Info().shaderGroupBaseAlignment, 0u);
}

TEST_F(ResourcesTest, UploadBuffer_IsMappedAndSeenByTheDevice) {
    const rhi::Buffer source =
        Device().CreateBuffer({.size = 16, .usage = BufferUsage::CopySource, .memory = MemoryKind::Upload});
    const std::vector<uint32_t> values{5, 6, 7, 8};
    ASSERT_EQ(source.Mapped().size(), 16u);
    std::memcpy(source.Mapped().data(), values.data(), 16);
    EXPECT_EQ(As<uint32_t>(rhi::ReadBuffer(Device(), source)), values);
}

TEST_F(ResourcesTest, EmptyRequests_AreRefusedWithTheName) {
    const Error buffer = ErrorOf([] { Device().CreateBuffer({.name = "materials", .size = 0}); });
    EXPECT_EQ(buffer.Kind(), ErrorKind::Usage);
    EXPECT_STREQ(buffer.what(), "buffer 'materials' (0 bytes): its size is zero");
    const Error texture = ErrorOf([] { Device().CreateTexture({.name = "radiance", .extent = {0, 4}}); });
    EXPECT_EQ(texture.Kind(), ErrorKind::Usage);
    EXPECT_STREQ(texture.what(), "texture 'radiance' (0x4 rgba8): its extent is empty");
    EXPECT_THAT(ErrorOf([] { Device().CreateMemoryBlock("aliased", {}); }).what(), HasSubstr("'aliased'"));
    EXPECT_THAT(ErrorOf([] { Device().RequirementsOf(rhi::BufferDesc{.name = "b"}); }).what(),
                HasSubstr("'b'"));
}

TEST_F(ResourcesTest, BadTextureRequests_AreRefusedBeforeTheDriverSeesThem) {
    const auto text = [](const rhi::TextureDesc& desc) {
        return std::string(ErrorOf([&] { Device().CreateTexture(desc); }).what());
    };
    EXPECT_THAT(text({.name = "t", .extent = {4, 4}, .mipLevels = 4}),
                HasSubstr("4 mip levels, possible are 1 to 3"));
    EXPECT_THAT(text({.name = "t", .extent = {4, 4}, .mipLevels = 0}), HasSubstr("0 mip levels"));
    EXPECT_THAT(text({.name = "t", .extent = {4, 4}, .format = Format::Undefined}), HasSubstr("no format"));
    EXPECT_THAT(text({.name = "t", .extent = {4, 4}, .usage = TextureUsage::None}), HasSubstr("no usage"));
    EXPECT_THAT(text({.name = "t", .extent = {1u << 20, 1}}), HasSubstr("the device's largest texture is"));
    EXPECT_THAT(
        text({.name = "t", .extent = {4, 4}, .format = Format::D32Float, .usage = TextureUsage::ColorTarget}),
        AllOf(HasSubstr("'t' (4x4 d32f)"), HasSubstr("no such format for this usage")));
}

TEST_F(ResourcesTest, BufferLargerThanTheDeviceTakes_IsOutOfMemory) {
    const Error error = ErrorOf([] { Device().CreateBuffer({.name = "huge", .size = ~uint64_t{0}}); });
    EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory);
    EXPECT_THAT(error.what(), HasSubstr("'huge'"));
}

TEST_F(ResourcesTest, Moving_LeavesTheSourceEmptyAndFreesOnce) {
    Device().WaitIdle();
    const uint64_t before = Device().Memory().usedBytes;
    {
        rhi::Buffer first = Device().CreateBuffer({.name = "first", .size = 4096});
        const VkBuffer handle = first.Handle();
        rhi::Buffer second = std::move(first);
        EXPECT_FALSE(first);  // NOLINT(bugprone-use-after-move): the contract says it is empty
        EXPECT_EQ(second.Handle(), handle);
        EXPECT_EQ(second.Desc().name, "first");
        second = Device().CreateBuffer({.name = "other", .size = 4096});
        EXPECT_NE(second.Handle(), VK_NULL_HANDLE);
    }
    EXPECT_EQ(Device().Memory().usedBytes, before);
}

TEST_F(ResourcesTest, MemoryStatistics_CountLiveResourcesAndThePeak) {
    Device().WaitIdle();
    const rhi::MemoryStatistics before = Device().Memory();
    rhi::Buffer buffer = Device().CreateBuffer({.size = 1 << 20});
    rhi::Texture texture = Device().CreateTexture({.extent = {256, 256}, .format = Format::Rgba32Float});
    const rhi::MemoryStatistics during = Device().Memory();
    EXPECT_GE(during.usedBytes, before.usedBytes + (1 << 20) + 256 * 256 * 16);
    EXPECT_GE(during.peakBytes, during.usedBytes);
    buffer = {};
    texture = {};
    EXPECT_EQ(Device().Memory().usedBytes, before.usedBytes);
    EXPECT_GE(Device().Memory().peakBytes, during.peakBytes);
}

TEST_F(ResourcesTest, MemoryBlock_IsSharedByResourcesOneAfterTheOther) {
    const rhi::TextureDesc textureDesc{.name = "transient texture",
                                       .extent = {16, 16},
                                       .format = Format::R32Uint,
                                       .usage = kTextureCopies | TextureUsage::Sampled};
    const rhi::BufferDesc bufferDesc{.name = "transient buffer", .size = 512, .usage = kCopies};
    const rhi::MemoryRequirements a = Device().RequirementsOf(textureDesc);
    const rhi::MemoryRequirements b = Device().RequirementsOf(bufferDesc);
    const uint64_t used = Device().Memory().usedBytes;
    const rhi::MemoryBlock block = Device().CreateMemoryBlock(
        "shared",
        {std::max(a.size, b.size), std::max(a.alignment, b.alignment), a.memoryTypeBits & b.memoryTypeBits});
    const uint64_t blockBytes = Device().Memory().usedBytes - used;
    EXPECT_GE(blockBytes, std::max(a.size, b.size));
    const rhi::Texture texture = Device().CreateTexture(textureDesc, block);
    const rhi::Buffer buffer = Device().CreateBuffer(bufferDesc, block);
    EXPECT_EQ(Device().Memory().usedBytes, used + blockBytes)
        << "what is in a block takes no memory of its own";

    rhi::Uploader uploader(Device());
    std::vector<uint32_t> texels(256);
    for (uint32_t i = 0; i < 256; ++i) texels[i] = i * 3;
    uploader.UploadTexture(texture, BytesOf(texels));
    uploader.Flush();
    EXPECT_EQ(As<uint32_t>(rhi::ReadTexture(Device(), texture, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)),
              texels);
    rhi::CommandList commands = Device().BeginCommands("buffer's turn");
    commands.FullBarrier();
    commands.Fill(buffer, 77);
    Device().Submit(std::move(commands));
    EXPECT_EQ(As<uint32_t>(rhi::ReadBuffer(Device(), buffer)), std::vector<uint32_t>(128, 77));
}

TEST_F(ResourcesTest, MemoryBlock_TooSmallOrWrongIsRefusedWithBothSizes) {
    const rhi::BufferDesc small{.name = "small", .size = 256, .usage = kCopies};
    const rhi::BufferDesc large{.name = "large", .size = 1 << 20, .usage = kCopies};
    const rhi::MemoryBlock block = Device().CreateMemoryBlock("block", Device().RequirementsOf(small));
    EXPECT_NO_THROW(Device().CreateBuffer(small, block));
    EXPECT_THAT(
        ErrorOf([&] { Device().CreateBuffer(large, block); }).what(),
        AllOf(HasSubstr("'large'"), HasSubstr("1048576 bytes"), HasSubstr("its memory block has 256")));
    rhi::BufferDesc mapped = small;
    mapped.memory = MemoryKind::Upload;
    EXPECT_EQ(ErrorOf([&] { Device().CreateBuffer(mapped, block); }).Kind(), ErrorKind::Usage);
}

TEST_F(ResourcesTest, Sampler_IsMadeForEveryDescription) {
    for (const rhi::Filter filter : {rhi::Filter::Nearest, rhi::Filter::Linear})
        for (const rhi::AddressMode mode :
             {rhi::AddressMode::Repeat, rhi::AddressMode::MirroredRepeat, rhi::AddressMode::ClampToEdge})
            EXPECT_TRUE(Device().CreateSampler({.name = "s",
                                                .magFilter = filter,
                                                .minFilter = filter,
                                                .mipFilter = filter,
                                                .addressU = mode,
                                                .addressV = mode}));
}

TEST_F(ResourcesTest, Sampler_TakesAsMuchAnisotropyAsThereIs) {
    if (Device().Info().optional.samplerAnisotropy)
        EXPECT_GE(Device().Info().maxAnisotropy, 2.0f);
    else
        EXPECT_EQ(Device().Info().maxAnisotropy, 1.0f);
    for (const float anisotropy : {1.0f, 2.0f, 1000.0f})
        EXPECT_TRUE(Device().CreateSampler({.name = "s", .maxAnisotropy = anisotropy}));
    for (const float wrong : {0.0f, std::numeric_limits<float>::quiet_NaN()}) {
        const Error error = ErrorOf([&] { Device().CreateSampler({.name = "s", .maxAnisotropy = wrong}); });
        EXPECT_EQ(error.Kind(), ErrorKind::Usage);
        EXPECT_THAT(error.what(),
                    AllOf(HasSubstr("'s'"), HasSubstr("maxAnisotropy"), HasSubstr("at least 1")));
    }
}

TEST(FormatTest, TablesAgree) {
    for (uint32_t i = 1; i < rhi::kFormatCount; ++i) {
        const auto format = static_cast<Format>(i);
        EXPECT_EQ(rhi::FormatFromVk(rhi::ToVk(format)), format) << rhi::Name(format);
        EXPECT_GT(rhi::TexelBytes(format), 0u);
    }
    EXPECT_EQ(rhi::FormatFromVk(VK_FORMAT_BC6H_SFLOAT_BLOCK), Format::Undefined);
}

TEST(FormatTest, BlocksCoverTheTexels) {
    EXPECT_EQ(rhi::BlockCounts(Format::Bc7Unorm, {5, 4}), (rhi::Extent2D{2, 1}));
    EXPECT_EQ(rhi::BlockCounts(Format::Rgba8Unorm, {5, 4}), (rhi::Extent2D{5, 4}));
    EXPECT_EQ(rhi::ImageBytes(Format::Bc7Unorm, {5, 4}), 32u);
    EXPECT_EQ(rhi::ImageBytes(Format::Bc1Srgb, {1, 1}), 8u);
    EXPECT_EQ(rhi::ImageBytes(Format::Rgba8Unorm, {5, 4}), 80u);
}

TEST(FormatTest, MipsHalveDownToOne) {
    EXPECT_EQ(rhi::FullMipCount({1, 1}), 1u);
    EXPECT_EQ(rhi::FullMipCount({5, 3}), 3u);
    EXPECT_EQ(rhi::FullMipCount({256, 1}), 9u);
    EXPECT_EQ(rhi::MipExtent({5, 3}, 1), (rhi::Extent2D{2, 1}));
    EXPECT_EQ(rhi::MipExtent({5, 3}, 2), (rhi::Extent2D{1, 1}));
}

}  // namespace
}  // namespace raygraph::testing::resources_test

// Tests which memory resources use, what is reported of it, and what happens when it is exhausted.
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

// Tests uploads and readbacks: every byte arrives, through bounded staging memory.
namespace raygraph::testing::upload_test {
namespace {

using rhi::BufferUsage;
using rhi::Format;
using rhi::TextureUsage;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr BufferUsage kCopies = BufferUsage::CopySource | BufferUsage::CopyDestination;
constexpr TextureUsage kTextureCopies =
    TextureUsage::Sampled | TextureUsage::CopySource | TextureUsage::CopyDestination;
constexpr VkImageLayout kUploaded = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;

std::vector<std::byte> Noise(size_t size, uint32_t seed) {
    std::minstd_rand random(seed);
    std::vector<std::byte> bytes(size);
    for (std::byte& b : bytes) b = static_cast<std::byte>(random() >> 8);
    return bytes;
}

struct UploadTest : VulkanTest {
    static constexpr uint64_t kStaging = 256 << 10;
    rhi::Uploader uploader{Device(), {.name = "test uploader", .stagingBytes = kStaging, .chunkCount = 4}};
};

TEST_F(UploadTest, Buffer_ArrivesWholeAndAtItsOffset) {
    const rhi::Buffer buffer = Device().CreateBuffer({.name = "b", .size = 1000, .usage = kCopies});
    std::vector<std::byte> expected(1000, std::byte{0});
    uploader.UploadBuffer(buffer, 0, expected);
    const std::vector<std::byte> part = Noise(77, 1);
    uploader.UploadBuffer(buffer, 123, part);
    std::copy(part.begin(), part.end(), expected.begin() + 123);
    const rhi::Submission value = uploader.Flush();
    EXPECT_EQ(rhi::ReadBuffer(Device(), buffer), expected);
    EXPECT_GE(Device().CompletedValue(), value.value);
    EXPECT_EQ(rhi::ReadBuffer(Device(), buffer, 123, 77), part);
}

TEST_F(UploadTest, SeveralTimesTheRing_ArrivesThroughBoundedStagingMemory) {
    const std::vector<std::byte> bytes = Noise(3 * kStaging + 12345, 2);
    const rhi::Buffer buffer =
        Device().CreateBuffer({.name = "large", .size = bytes.size(), .usage = kCopies});
    const uint64_t before = Device().Memory().usedBytes;
    const uint64_t submissions = Device().LastSubmittedValue();
    uploader.UploadBuffer(buffer, 0, bytes);
    uploader.Flush();
    EXPECT_LE(uploader.StagingBytes(), kStaging);
    EXPECT_LE(Device().Memory().usedBytes, before + 2 * kStaging);
    EXPECT_EQ(Device().LastSubmittedValue() - submissions, 13u)
        << "a submission a chunk, so that copies overlap";
    EXPECT_EQ(rhi::ReadBuffer(Device(), buffer), bytes);
}

// The layers are off: version 1.3.239 cannot handle a thread that waits for another one's signal.
TEST(UploaderTest, BusyDevice_TakesTheWholeRingWithoutWaitingAndThenNoMore) {
    constexpr uint64_t kStaging = 256 << 10;
    const std::unique_ptr<rhi::Device> device = rhi::Device::Create({.savePipelineCache = false});
    const std::vector<std::byte> bytes = Noise(2 * kStaging, 3);
    const rhi::Buffer buffer = device->CreateBuffer({.name = "b", .size = bytes.size(), .usage = kCopies});
    rhi::Uploader uploader(*device, {.stagingBytes = kStaging, .chunkCount = 4});
    Gate gate(*device);
    const rhi::SemaphoreUse wait = gate.At(1);
    const rhi::Submission busy = device->Submit(device->BeginCommands("busy"), {&wait, 1});
    uploader.UploadBuffer(buffer, 0, std::span(bytes).first(kStaging));
    EXPECT_LT(device->CompletedValue(), busy.value);
    EXPECT_EQ(uploader.StagingBytes(), kStaging);
    EXPECT_EQ(uploader.WaitCount(), 0u);
    // From here on a call has to wait for a chunk, and gets it once the device goes on.
    std::thread later([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        gate.Open();
    });
    uploader.UploadBuffer(buffer, kStaging, std::span(bytes).last(kStaging));
    later.join();
    uploader.Flush();
    EXPECT_EQ(uploader.StagingBytes(), kStaging);
    EXPECT_EQ(rhi::ReadBuffer(*device, buffer), bytes);
}

TEST_F(UploadTest, ManySmallBatches_ReuseAChunkThatIsDone) {
    const rhi::Buffer buffer = Device().CreateBuffer({.name = "b", .size = 4096, .usage = kCopies});
    for (uint32_t frame = 0; frame < 50; ++frame) {
        const std::vector<std::byte> bytes = Noise(4096, frame);
        uploader.UploadBuffer(buffer, 0, bytes);
        Device().WaitFor(uploader.Flush());
        ASSERT_EQ(rhi::ReadBuffer(Device(), buffer), bytes);
    }
    EXPECT_EQ(uploader.StagingBytes(), kStaging / 4) << "one chunk is enough when nothing is in flight";
    EXPECT_EQ(uploader.WaitCount(), 0u);
}

TEST_F(UploadTest, OverlappingWritesOfOneBatch_TheLastOneWins) {
    const rhi::Buffer buffer = Device().CreateBuffer({.name = "b", .size = 400, .usage = kCopies});
    std::vector<uint32_t> expected(100, 1);
    uploader.UploadBuffer(buffer, 0, BytesOf(expected));
    for (uint32_t i = 0; i < 20; ++i) {  // adjacent, then overlapping from both sides
        const std::vector<uint32_t> part(10, 100 + i);
        const size_t first = i < 10 ? i * 10 : (i - 10) * 9;
        uploader.UploadBuffer(buffer, first * 4, BytesOf(part));
        std::fill_n(expected.begin() + static_cast<std::ptrdiff_t>(first), 10, 100 + i);
    }
    uploader.Flush();
    EXPECT_EQ(As<uint32_t>(rhi::ReadBuffer(Device(), buffer)), expected);
}

TEST_F(UploadTest, FlushWithoutUploads_SubmitsNothing) {
    const uint64_t before = Device().LastSubmittedValue();
    EXPECT_FALSE(uploader.Flush());
    EXPECT_EQ(Device().LastSubmittedValue(), before);
}

TEST_F(UploadTest, NothingIsUploadedWithoutFlush) {
    const rhi::Buffer buffer = Device().CreateBuffer({.name = "b", .size = 64, .usage = kCopies});
    const std::vector<uint32_t> zeros(16, 0);
    uploader.UploadBuffer(buffer, 0, BytesOf(zeros));
    uploader.Flush();
    {
        rhi::Uploader dropped(Device());
        const std::vector<uint32_t> ones(16, 1);
        dropped.UploadBuffer(buffer, 0, BytesOf(ones));
    }
    EXPECT_EQ(As<uint32_t>(rhi::ReadBuffer(Device(), buffer)), zeros);
}

TEST_F(UploadTest, BadRequests_NameTheTargetAndBothSides) {
    const rhi::Buffer buffer = Device().CreateBuffer({.name = "lights", .size = 64, .usage = kCopies});
    const rhi::Buffer noCopy = Device().CreateBuffer({.name = "sealed", .size = 64});
    const std::vector<std::byte> bytes = Noise(64, 1);
    EXPECT_STREQ(ErrorOf([&] { uploader.UploadBuffer(buffer, 1, bytes); }).what(),
                 "upload to buffer 'lights': 64 bytes at 1, it has 64");
    EXPECT_THAT(ErrorOf([&] { uploader.UploadBuffer(noCopy, 0, bytes); }).what(), HasSubstr("'sealed'"));
    const rhi::Texture texture = Device().CreateTexture({.name = "albedo", .extent = {4, 4}, .mipLevels = 3});
    EXPECT_THAT(ErrorOf([&] { uploader.UploadTexture(texture, std::span(bytes).first(60)); }).what(),
                AllOf(HasSubstr("'albedo'"), HasSubstr("mip level 0 has 64 bytes, given are 60")));
    EXPECT_THAT(ErrorOf([&] { uploader.UploadTexture(texture, bytes); }).what(), HasSubstr("CopySource"));
    const rhi::Texture integers = Device().CreateTexture({.name = "ids",
                                                          .extent = {4, 4},
                                                          .format = Format::R32Uint,
                                                          .usage = kTextureCopies,
                                                          .mipLevels = 3});
    EXPECT_THAT(ErrorOf([&] { uploader.UploadTexture(integers, bytes); }).what(),
                HasSubstr("cannot be filtered"));
    EXPECT_EQ(ErrorOf([&] { rhi::Uploader(Device(), {.chunkCount = 1}); }).Kind(), ErrorKind::Usage);
    EXPECT_EQ(ErrorOf([&] { rhi::Uploader(Device(), {.chunkCount = 0}); }).Kind(), ErrorKind::Usage);
    EXPECT_FALSE(uploader.Flush()) << "a refused upload records nothing";
}

class UploadFormatTest : public UploadTest, public ::testing::WithParamInterface<Format> {};

// Odd sizes leave rows unaligned; more than one chunk splits them.
TEST_P(UploadFormatTest, Texels_ArriveBitForBit) {
    if (!Device().CanSample(GetParam()) && rhi::BlockSide(GetParam()) > 1)
        GTEST_SKIP() << "the device lacks textureCompressionBC";
    for (const rhi::Extent2D extent : {rhi::Extent2D{1, 1}, rhi::Extent2D{7, 5}, rhi::Extent2D{321, 413}}) {
        const rhi::Texture texture = Device().CreateTexture(
            {.name = "texture", .extent = extent, .format = GetParam(), .usage = kTextureCopies});
        const size_t size = rhi::ImageBytes(GetParam(), extent);
        std::vector<std::byte> texels = Noise(size, extent.width);
        // No NaNs and no denormals: what a driver may change in a float copy is not the upload's matter.
        if (GetParam() == Format::D32Float) {
            std::vector<float> depths(size / 4);
            for (size_t i = 0; i < depths.size(); ++i) depths[i] = static_cast<float>(i % 1000) / 1000.0f;
            texels.assign(BytesOf(depths).begin(), BytesOf(depths).end());
        }
        uploader.UploadTexture(texture, texels);
        uploader.Flush();
        EXPECT_EQ(rhi::ReadTexture(Device(), texture, kUploaded), texels)
            << extent.width << "x" << extent.height;
    }
}

INSTANTIATE_TEST_SUITE_P(
    AllFormats, UploadFormatTest,
    ::testing::Values(Format::R8Unorm, Format::Rg8Unorm, Format::Rgba8Unorm, Format::Rgba8Srgb,
                      Format::Bgra8Unorm, Format::Bgra8Srgb, Format::Rgba16Unorm, Format::R16Float,
                      Format::Rgba16Float, Format::R32Uint, Format::Rg32Uint, Format::Rgba32Uint,
                      Format::R32Float, Format::Rg32Float, Format::Rgba32Float, Format::D32Float,
                      Format::Bc1Unorm, Format::Bc1Srgb, Format::Bc1AlphaUnorm, Format::Bc1AlphaSrgb,
                      Format::Bc2Unorm, Format::Bc2Srgb, Format::Bc3Unorm, Format::Bc3Srgb, Format::Bc4Unorm,
                      Format::Bc5Unorm, Format::Bc7Unorm, Format::Bc7Srgb),
    [](const auto& test) {
        std::string name = rhi::Name(test.param);
        std::erase(name, '-');
        return name;
    });

TEST_F(UploadTest, GivenMipLevels_ArriveEachAsGiven) {
    const rhi::Texture texture = Device().CreateTexture({.name = "chain",
                                                         .extent = {8, 4},
                                                         .format = Format::R32Float,
                                                         .usage = kTextureCopies,
                                                         .mipLevels = 4});
    std::vector<std::vector<float>> levels{std::vector<float>(32, 1.0f), std::vector<float>(8, 2.0f),
                                           std::vector<float>(2, 3.0f), std::vector<float>(1, 4.0f)};
    std::vector<std::span<const std::byte>> bytes;
    for (const std::vector<float>& level : levels) bytes.push_back(BytesOf(level));
    uploader.UploadTexture(texture, bytes);
    uploader.Flush();
    for (uint32_t level = 0; level < 4; ++level)
        EXPECT_EQ(As<float>(rhi::ReadTexture(Device(), texture, kUploaded, level)), levels[level]) << level;
}

TEST_F(UploadTest, MadeMipLevels_AreTheMeansOfTwoByTwoTexels) {
    const uint32_t size = 16;
    const rhi::Texture texture = Device().CreateTexture({.name = "mips",
                                                         .extent = {size, size},
                                                         .format = Format::Rgba32Float,
                                                         .usage = kTextureCopies,
                                                         .mipLevels = 5});
    std::vector<float> above(size * size * 4);
    for (size_t i = 0; i < above.size(); ++i) above[i] = static_cast<float>((i * 37) % 101) / 8.0f;
    uploader.UploadTexture(texture, BytesOf(above));
    uploader.Flush();
    for (uint32_t level = 1; level < 5; ++level) {
        const uint32_t width = size >> level;
        std::vector<float> means(width * width * 4);
        for (uint32_t y = 0; y < width; ++y)
            for (uint32_t x = 0; x < width; ++x)
                for (uint32_t c = 0; c < 4; ++c) {
                    const auto at = [&](uint32_t dx, uint32_t dy) {
                        return above[((2 * y + dy) * 2 * width + 2 * x + dx) * 4 + c];
                    };
                    means[(y * width + x) * 4 + c] = (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4.0f;
                }
        const std::vector<float> made = As<float>(rhi::ReadTexture(Device(), texture, kUploaded, level));
        ASSERT_EQ(made.size(), means.size());
        // Filter weights have 8 bits on common hardware: an eighth bit's error of the largest value, 12.6.
        for (size_t i = 0; i < means.size(); ++i)
            ASSERT_NEAR(made[i], means[i], 12.6 / 256) << level << ", " << i;
        above = made;
    }
}

TEST_F(UploadTest, MadeMipLevels_OfSrgbTexturesAreMeansOfLight) {
    const rhi::Texture texture = Device().CreateTexture({.name = "checker",
                                                         .extent = {2, 2},
                                                         .format = Format::Rgba8Srgb,
                                                         .usage = kTextureCopies,
                                                         .mipLevels = 2});
    const std::vector<uint8_t> checker{255, 255, 255, 255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255, 255};
    uploader.UploadTexture(texture, BytesOf(checker));
    uploader.Flush();
    const std::vector<uint8_t> mean = As<uint8_t>(rhi::ReadTexture(Device(), texture, kUploaded, 1));
    // Half the light: 1.055 * 0.5^(1/2.4) - 0.055 = 0.7354 = 188 of 255. A mean of codes would be 128.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], 188, 1);
    EXPECT_EQ(mean[3], 255);
}

TEST_F(UploadTest, Readback_IsReadyOnlyAfterItsSubmissionAndNeverWaitsItself) {
    const rhi::Buffer buffer = Device().CreateBuffer({.name = "b", .size = 64, .usage = kCopies});
    rhi::CommandList commands = Device().BeginCommands("produce and read");
    commands.Fill(buffer, 9);
    rhi::Readback readback = rhi::Readback::Record(commands, buffer, 16, 32);
    EXPECT_FALSE(readback.IsReady());
    EXPECT_EQ(ErrorOf([&] { readback.Bytes(); }).Kind(), ErrorKind::Usage);
    EXPECT_EQ(ErrorOf([&] { readback.Wait(); }).Kind(), ErrorKind::Usage);
    readback.SetSubmitted(Device().Submit(std::move(commands)));
    EXPECT_EQ(As<uint32_t>(readback.Wait()), std::vector<uint32_t>(8, 9));
    EXPECT_TRUE(readback.IsReady());
    EXPECT_EQ(As<uint32_t>(readback.Bytes()), std::vector<uint32_t>(8, 9));
}

TEST_F(UploadTest, BadReadbacks_NameTheSource) {
    const rhi::Buffer sealed = Device().CreateBuffer({.name = "sealed", .size = 64});
    EXPECT_THAT(ErrorOf([&] { rhi::ReadBuffer(Device(), sealed); }).what(), HasSubstr("'sealed'"));
    const rhi::Buffer buffer = Device().CreateBuffer({.name = "b", .size = 64, .usage = kCopies});
    EXPECT_THAT(ErrorOf([&] { rhi::ReadBuffer(Device(), buffer, 60, 8); }).what(),
                HasSubstr("8 bytes at 60, it has 64"));
    const rhi::Texture texture =
        Device().CreateTexture({.name = "t", .extent = {4, 4}, .usage = kTextureCopies});
    EXPECT_THAT(ErrorOf([&] { rhi::ReadTexture(Device(), texture, kUploaded, 1); }).what(),
                HasSubstr("mip level 1, it has 1"));
}

}  // namespace
}  // namespace raygraph::testing::upload_test

// Tests when a retired object may be destroyed: the timeline and the lists that are being recorded decide. It
// needs no device.
namespace raygraph::rhi::retire_queue_test {
namespace {

struct RetireQueueTest : ::testing::Test {
    RetireQueue queue;
    std::vector<int> destroyed;
    RetireQueue::Destroy Mark(int id) {
        return [this, id] { destroyed.push_back(id); };
    }
};

using Ids = std::vector<int>;

TEST_F(RetireQueueTest, IdleDevice_DestroysAtOnce) {
    queue.Retire(Mark(1), {0});
    EXPECT_EQ(destroyed, Ids{1});
    EXPECT_EQ(queue.PendingCount(), 0u);
}

TEST_F(RetireQueueTest, SubmittedWork_IsWaitedFor) {
    queue.CloseList(queue.OpenList(), {3});
    queue.Retire(Mark(1), {2});
    queue.Collect({2});
    EXPECT_EQ(destroyed, Ids{});
    queue.Collect({3});
    EXPECT_EQ(destroyed, Ids{1});
}

TEST_F(RetireQueueTest, ListBeingRecorded_IsWaitedForUntilItsOwnSubmissionHasCompleted) {
    const uint64_t list = queue.OpenList();
    queue.Retire(Mark(1), {0});
    queue.Collect({100});
    EXPECT_EQ(destroyed, Ids{}) << "the list may still mention the object";
    queue.CloseList(list, {101});
    queue.Collect({100});
    EXPECT_EQ(destroyed, Ids{});
    queue.Collect({101});
    EXPECT_EQ(destroyed, Ids{1});
}

TEST_F(RetireQueueTest, ListSubmittedFirst_DoesNotStandForOneThatIsStillOpen) {
    const uint64_t early = queue.OpenList();
    const uint64_t late = queue.OpenList();
    queue.Retire(Mark(1), {0});
    queue.CloseList(late, {1});
    queue.Collect({1});
    EXPECT_EQ(destroyed, Ids{}) << "the first list is still being recorded";
    queue.CloseList(early, {2});
    queue.Collect({1});
    EXPECT_EQ(destroyed, Ids{});
    queue.Collect({2});
    EXPECT_EQ(destroyed, Ids{1});
}

TEST_F(RetireQueueTest, ListOpenedLater_IsNotWaitedFor) {
    const uint64_t first = queue.OpenList();
    queue.Retire(Mark(1), {0});
    const uint64_t second = queue.OpenList();
    queue.CloseList(first, {1});
    queue.Collect({1});
    EXPECT_EQ(destroyed, Ids{1});
    queue.CloseList(second, {2});
}

TEST_F(RetireQueueTest, DroppedList_HoldsNothingBack) {
    const uint64_t list = queue.OpenList();
    queue.Retire(Mark(1), {0});
    queue.CloseList(list, {0});
    queue.Collect({0});
    EXPECT_EQ(destroyed, Ids{1});
}

TEST_F(RetireQueueTest, OrderOfRetiring_IsKept) {
    queue.CloseList(queue.OpenList(), {1});
    queue.Retire(Mark(1), {0});
    const uint64_t list = queue.OpenList();
    queue.Retire(Mark(2), {0});
    queue.CloseList(list, {2});
    queue.Retire(Mark(3), {0});
    queue.Collect({2});
    EXPECT_EQ(destroyed, (Ids{1, 2, 3}));
}

// The timeline may have passed queued objects before anybody has collected them.
TEST_F(RetireQueueTest, OrderOfRetiring_IsKeptWithoutACollection) {
    queue.CloseList(queue.OpenList(), {1});
    queue.Retire(Mark(1), {0});
    queue.Retire(Mark(2), {1});
    EXPECT_EQ(destroyed, Ids{});
    queue.Collect({1});
    EXPECT_EQ(destroyed, (Ids{1, 2}));
}

TEST_F(RetireQueueTest, DestroyingMayRetireMore) {
    queue.CloseList(queue.OpenList(), {1});
    queue.Retire([this] { queue.Retire(Mark(1), {1}); }, {0});
    queue.Collect({1});
    EXPECT_EQ(destroyed, Ids{1});
}

TEST_F(RetireQueueTest, CollectAll_RunsWhatIsLeftEvenForOpenLists) {
    queue.OpenList();
    queue.Retire(Mark(1), {0});
    queue.Retire([this] { queue.Retire(Mark(2), {0}); }, {0});
    queue.CollectAll();
    EXPECT_EQ(destroyed, (Ids{1, 2}));
}

// An object may be in use on any queue, and each has a timeline of its own.
TEST_F(RetireQueueTest, WorkOfEveryQueue_IsWaitedFor) {
    queue.CloseList(queue.OpenList(), {5, QueueKind::Main});
    queue.CloseList(queue.OpenList(), {2, QueueKind::Transfer});
    queue.Retire(Mark(1), {5, 0, 1});
    queue.Collect({9, 0, 1});
    EXPECT_EQ(destroyed, Ids{}) << "the transfer queue has not passed it";
    queue.CloseList(queue.OpenList(), {1, QueueKind::Compute});
    queue.Collect({4, 0, 2});
    EXPECT_EQ(destroyed, Ids{}) << "nor has the main one now";
    queue.Collect({5, 0, 2});
    EXPECT_EQ(destroyed, Ids{1}) << "the list of the compute queue is younger";
}

}  // namespace
}  // namespace raygraph::rhi::retire_queue_test
