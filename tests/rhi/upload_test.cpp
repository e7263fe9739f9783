// Tests uploads and readbacks: every byte arrives, through bounded staging memory.
#include "rhi/upload.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <thread>

#include "rhi/device.h"
#include "rhi/readback.h"
#include "tests/rhi/gate.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

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
    const uint64_t value = uploader.Flush();
    EXPECT_EQ(rhi::ReadBuffer(Device(), buffer), expected);
    EXPECT_GE(Device().CompletedValue(), value);
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
    const uint64_t busy = device->Submit(device->BeginCommands("busy"), {&wait, 1});
    uploader.UploadBuffer(buffer, 0, std::span(bytes).first(kStaging));
    EXPECT_LT(device->CompletedValue(), busy);
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
    EXPECT_EQ(uploader.Flush(), 0u);
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
    EXPECT_EQ(uploader.Flush(), 0u) << "a refused upload records nothing";
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
