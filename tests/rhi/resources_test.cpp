// Tests buffers, textures, samplers, memory blocks: their contract, and refusals by name.
#include "rhi/resources.h"

#include <gmock/gmock.h>

#include <cstring>

#include "rhi/command_list.h"
#include "rhi/readback.h"
#include "rhi/upload.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

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
