// A viewport's picture in images of a host.
#include "base/error.h"
#include "editor/viewport/vulkan_interop.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::host_image_test {

using viewport::HostImage;

namespace {

class HostImageTest : public VulkanTest {
  protected:
    static constexpr Extent2D kSize{24, 16};

    // Shows frames in an image that a host made, leaves it in the layout of its own reads, and reads it.
    std::vector<uint8_t> ShownIn(ViewedScene& viewed, rhi::Format format, uint32_t frames) {
        const bool isCopied = format == rhi::Format::Rgba8Unorm || format == rhi::Format::Rgba8Srgb;
        const rhi::Texture image = Device().CreateTexture(
            {.name = "host's own",
             .extent = kSize,
             .format = format,
             .usage = rhi::TextureUsage::CopySource |
                      (isCopied ? rhi::TextureUsage::CopyDestination : rhi::TextureUsage::ColorTarget)});
        HostImage target(Device(), {.image = image.Image(),
                                    .extent = kSize,
                                    .format = format,
                                    .layoutAfter = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL});
        const rhi::Buffer buffer = Device().CreateBuffer({.name = "host's copy",
                                                          .size = 4 * kSize.width * kSize.height,
                                                          .usage = rhi::BufferUsage::CopyDestination,
                                                          .memory = rhi::MemoryKind::Readback});
        for (uint32_t i = 0; i < frames; ++i) {
            viewed.renderer.BeginFrame();
            target.Show(viewed.renderer, viewed.viewport.Declare());
            viewed.renderer.Execute();
            rhi::CommandList commands = Device().BeginCommands("host");
            commands.CopyToBuffer(image, buffer);
            commands.Transition(image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_GENERAL);
            Device().WaitFor(Device().Submit(std::move(commands)));
            target.Return(VK_IMAGE_LAYOUT_GENERAL);
        }
        Device().WaitIdle();
        std::vector<uint8_t> bytes(buffer.Size());
        std::memcpy(bytes.data(), buffer.Mapped().data(), bytes.size());
        return bytes;
    }
};

}  // namespace

TEST_F(HostImageTest, EveryFormatOfAScreen_ShowsThePicture) {
    ViewedScene viewed(Device(), kSize);
    viewed.viewport.SetBudget({.maxSamples = 1});
    const std::vector<uint8_t> expected = viewed.Picture();
    EXPECT_EQ(ShownIn(viewed, rhi::Format::Rgba8Unorm, 3), expected);
    EXPECT_EQ(ShownIn(viewed, rhi::Format::Rgba8Srgb, 3), expected);
    for (const rhi::Format format : {rhi::Format::Bgra8Unorm, rhi::Format::Bgra8Srgb}) {
        const std::vector<uint8_t> shown = ShownIn(viewed, format, 3);
        int greatest = 0;
        for (size_t i = 0; i < shown.size(); i += 4)
            for (size_t c = 0; c < 3; ++c)
                greatest = std::max(greatest, std::abs(int(shown[i + 2 - c]) - int(expected[i + c])));
        // Decoded and encoded again, a code may round to its neighbor
        EXPECT_LE(greatest, format == rhi::Format::Bgra8Unorm ? 0 : 1) << rhi::Name(format);
    }
}

TEST_F(HostImageTest, Semaphores_OrderTheHostsWorkAroundTheFrame) {
    VkSemaphoreTypeCreateInfo type{};
    type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
    type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
    VkSemaphore semaphore = VK_NULL_HANDLE;
    ASSERT_EQ(Device().Vk().vkCreateSemaphore(Device().Handle(), &info, nullptr, &semaphore), VK_SUCCESS);
    {
        const rhi::Texture image = Device().CreateTexture({.name = "host's own", .extent = kSize});
        ViewedScene viewed(Device(), kSize);
        HostImage target(Device(), {.image = image.Image(), .extent = kSize});
        viewed.renderer.BeginFrame();
        target.Show(viewed.renderer, viewed.viewport.Declare(),
                    {.wait = {{semaphore, 1}}, .signal = {{semaphore, 2}}});
        const uint64_t frame = viewed.renderer.Execute();
        EXPECT_LT(Device().CompletedValue(), frame);
        const VkSemaphoreSignalInfo signal{VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO, nullptr, semaphore, 1};
        ASSERT_EQ(Device().Vk().vkSignalSemaphore(Device().Handle(), &signal), VK_SUCCESS);
        Device().WaitFor(frame);
        uint64_t value = 0;
        ASSERT_EQ(Device().Vk().vkGetSemaphoreCounterValue(Device().Handle(), semaphore, &value), VK_SUCCESS);
        EXPECT_EQ(value, 2u);
        Device().WaitIdle();
    }
    Device().Vk().vkDestroySemaphore(Device().Handle(), semaphore, nullptr);
}

TEST_F(HostImageTest, WhatCannotBeShown_IsRefused) {
    EXPECT_THROW(HostImage(Device(), {.extent = kSize}), Error);
    const rhi::Texture image = Device().CreateTexture({.name = "host's own", .extent = kSize});
    EXPECT_THROW(HostImage(Device(), {.image = image.Image(), .extent = {0, 4}}), Error);
    EXPECT_THROW(
        HostImage(Device(), {.image = image.Image(), .extent = kSize, .format = rhi::Format::D32Float}),
        Error);
    ViewedScene viewed(Device(), {8, 8});
    HostImage target(Device(), {.image = image.Image(), .extent = kSize});
    viewed.renderer.BeginFrame();
    const TextureId shown = viewed.viewport.Declare();
    EXPECT_THROW(target.Show(viewed.renderer, shown), Error);
}

}  // namespace raygraph::testing::host_image_test
