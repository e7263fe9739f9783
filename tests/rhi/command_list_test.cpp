// Command lists: each function does what its Vulkan command does, and misuse is refused before Vulkan
// sees it.
#include "rhi/command_list.h"

#include <gmock/gmock.h>

#include "rhi/compute_pipeline.h"
#include "rhi/device.h"
#include "rhi/readback.h"
#include "rhi/shader_compiler.h"
#include "rhi/upload.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::command_list_test {
namespace {

using rhi::BoundResource;
using rhi::BufferUsage;
using rhi::CommandList;
using rhi::Extent2D;
using rhi::Format;
using rhi::TextureUsage;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr BufferUsage kCopies = BufferUsage::CopySource | BufferUsage::CopyDestination;
constexpr TextureUsage kTextureCopies = TextureUsage::CopySource | TextureUsage::CopyDestination;
constexpr VkImageLayout kSource = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
constexpr VkImageLayout kTarget = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;

class CommandListTest : public VulkanTest {
  protected:
    // Adds 1 to each covered texel's count and writes `value + x + 1000 * y` to the image.
    static rhi::ComputePipeline CountingPipeline() {
        rhi::GlslSource source;
        source.name = "count.comp";
        source.text = R"(#version 460
layout(local_size_x = 8, local_size_y = 4) in;
layout(set = 0, binding = 0, r32ui) uniform uimage2D image;
layout(set = 0, binding = 1) buffer Counts { uint counts[]; };
layout(push_constant) uniform Constants { uvec2 extent; uint value; };
void main() {
    uvec2 p = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(p, extent))) return;
    atomicAdd(counts[p.y * extent.x + p.x], 1u);
    imageStore(image, ivec2(p), uvec4(value + p.x + 1000u * p.y));
})";
        const std::vector<uint32_t> words = rhi::CompileGlsl(source);
        rhi::ComputePipelineDesc desc;
        desc.name = "count";
        desc.shader = {source.name, words};
        return rhi::CreateComputePipeline(Device(), desc);
    }
};

TEST_F(CommandListTest, FillAndCopy_ReachTheirRangesOnly) {
    const rhi::Buffer a = Device().CreateBuffer({.name = "a", .size = 64, .usage = kCopies});
    const rhi::Buffer b = Device().CreateBuffer({.name = "b", .size = 64, .usage = kCopies});
    CommandList commands = Device().BeginCommands("copies");
    commands.Fill(a, 1);
    commands.Fill(b, 2);
    commands.FullBarrier();
    commands.CopyBuffer(a, 8, b, 16, 24);
    Device().Submit(std::move(commands));
    std::vector<uint32_t> expected(16, 2);
    std::fill_n(expected.begin() + 4, 6, 1);
    EXPECT_EQ(As<uint32_t>(rhi::ReadBuffer(Device(), b)), expected);
}

TEST_F(CommandListTest, CopyBeyondTheEnd_IsRefusedWithBothBuffers) {
    const rhi::Buffer a = Device().CreateBuffer({.name = "small", .size = 16, .usage = kCopies});
    const rhi::Buffer b = Device().CreateBuffer({.name = "large", .size = 64, .usage = kCopies});
    CommandList commands = Device().BeginCommands("copies");
    EXPECT_THAT(ErrorOf([&] { commands.CopyBuffer(a, 8, b, 0, 16); }).what(),
                AllOf(HasSubstr("'small' (16 bytes) at 8"), HasSubstr("'large'")));
    EXPECT_EQ(ErrorOf([&] { commands.CopyBuffer(b, 0, a, ~uint64_t{0} - 3, 8); }).Kind(), ErrorKind::Usage);
}

TEST_F(CommandListTest, CopiesOfTextures_ThatDoNotFitAreRefusedWithBothSides) {
    const auto texture = [&](const char* name, Extent2D extent, Format format, uint32_t mipLevels = 1) {
        return Device().CreateTexture({.name = name,
                                       .extent = extent,
                                       .format = format,
                                       .usage = kTextureCopies,
                                       .mipLevels = mipLevels});
    };
    const rhi::Texture target = texture("target", {4, 4}, Format::Rgba32Float, 2);
    const rhi::Texture bytes = texture("bytes", {4, 4}, Format::R8Unorm);
    const rhi::Buffer buffer = Device().CreateBuffer({.name = "b", .size = 256, .usage = kCopies});
    const rhi::Buffer small = Device().CreateBuffer({.name = "small", .size = 255, .usage = kCopies});
    CommandList commands = Device().BeginCommands("copies");
    const auto message = [&](auto&& copy) {
        const Error error = ErrorOf(copy);
        EXPECT_EQ(error.Kind(), ErrorKind::Usage);
        return std::string(error.what());
    };
    EXPECT_EQ(
        message([&] { commands.CopyToTexture(small, 0, target); }),
        "CopyToTexture: buffer 'small' (255 bytes) and texture 'target' (4x4 rgba32f): 256 bytes at 0 do "
        "not fit");
    EXPECT_THAT(message([&] { commands.CopyToTexture(buffer, 16, target); }),
                HasSubstr("256 bytes at 16 do not fit"));
    EXPECT_EQ(
        message([&] { commands.CopyToBuffer(target, small); }),
        "CopyToBuffer: buffer 'small' (255 bytes) and texture 'target' (4x4 rgba32f): 256 bytes at 0 do "
        "not fit");
    EXPECT_THAT(message([&] { commands.CopyToBuffer(target, buffer, ~uint64_t{0} - 15, 1); }),
                HasSubstr("64 bytes at 18446744073709551600 do not fit"));
    EXPECT_THAT(message([&] { commands.CopyToBuffer(target, buffer, 0, 2); }), HasSubstr("mip level 2 of 2"));
    EXPECT_THAT(message([&] { commands.CopyToTexture(buffer, 8, target, 1); }),
                HasSubstr("offset 8 is not a multiple of 16"));
    EXPECT_THAT(message([&] { commands.CopyToBuffer(bytes, buffer, 2); }),
                HasSubstr("offset 2 is not a multiple of 4"));
    EXPECT_THAT(message([&] { commands.CopyRowsToTexture(buffer, 0, target, 0, 3, 2); }),
                HasSubstr("2 rows from 3 on, there are 4"));
    EXPECT_EQ(message([&] { commands.CopyTexture(bytes, target); }),
              "CopyTexture: 'bytes' (4x4 r8) does not fit 'target' (4x4 rgba32f)");
    EXPECT_EQ(message([&] {
                  commands.CopyTexture(texture("wide", {5, 4}, Format::Rgba32Float), target);
              }),
              "CopyTexture: 'wide' (5x4 rgba32f) does not fit 'target' (4x4 rgba32f)");
}

TEST_F(CommandListTest, ClearCopyTexture_AndBack) {
    const rhi::TextureDesc desc{
        .name = "t", .extent = {5, 3}, .format = Format::Rgba32Float, .usage = kTextureCopies};
    const rhi::Texture a = Device().CreateTexture(desc);
    const rhi::Texture b = Device().CreateTexture(desc);
    CommandList commands = Device().BeginCommands("textures");
    commands.Transition(a, VK_IMAGE_LAYOUT_UNDEFINED, kTarget);
    commands.Transition(b, VK_IMAGE_LAYOUT_UNDEFINED, kTarget);
    commands.Clear(a, {1.0f, 2.0f, 3.0f, 4.0f});
    commands.Transition(a, kTarget, kSource);
    commands.CopyTexture(a, b);
    Device().Submit(std::move(commands));
    const std::vector<float> texels = As<float>(rhi::ReadTexture(Device(), b, kTarget));
    ASSERT_EQ(texels.size(), 60u);
    for (size_t i = 0; i < texels.size(); ++i) EXPECT_EQ(texels[i], static_cast<float>(i % 4 + 1));
}

TEST_F(CommandListTest, DispatchOver_CoversEveryTexelOnceWhateverTheExtent) {
    const rhi::ComputePipeline pipeline = CountingPipeline();
    for (const Extent2D extent : {Extent2D{1, 1}, Extent2D{8, 4}, Extent2D{9, 5}, Extent2D{50, 33}}) {
        const rhi::Texture image =
            Device().CreateTexture({.name = "image",
                                    .extent = extent,
                                    .format = Format::R32Uint,
                                    .usage = TextureUsage::Storage | TextureUsage::CopySource});
        const size_t count = size_t{extent.width} * extent.height;
        const rhi::Buffer counts = Device().CreateBuffer(
            {.name = "counts", .size = count * 4, .usage = kCopies | BufferUsage::Storage});
        CommandList commands = Device().BeginCommands("count");
        commands.BeginLabel("counting");
        commands.Fill(counts, 0);
        commands.Transition(image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
        commands.FullBarrier();
        commands.Bind(pipeline);
        const std::array resources{
            BoundResource{.binding = 0, .type = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, .texture = &image},
            BoundResource{.binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .buffer = &counts}};
        commands.BindResources(resources);
        const std::vector<uint32_t> constants{extent.width, extent.height, 7};
        commands.PushConstants(BytesOf(constants));
        commands.DispatchOver(extent);
        commands.EndLabel();
        Device().Submit(std::move(commands));
        EXPECT_EQ(As<uint32_t>(rhi::ReadBuffer(Device(), counts)), std::vector<uint32_t>(count, 1));
        const std::vector<uint32_t> texels =
            As<uint32_t>(rhi::ReadTexture(Device(), image, VK_IMAGE_LAYOUT_GENERAL));
        for (uint32_t i = 0; i < count; ++i)
            ASSERT_EQ(texels[i], 7 + i % extent.width + 1000 * (i / extent.width));
    }
}

TEST_F(CommandListTest, EmptyExtent_RecordsNothing) {
    const rhi::ComputePipeline pipeline = CountingPipeline();
    CommandList commands = Device().BeginCommands("nothing");
    commands.Bind(pipeline);
    // The layers would complain about a dispatch without its resources.
    commands.DispatchOver({0, 16});
    commands.Dispatch(1, 0, 1);
    commands.Barriers({}, {});
    Device().WaitFor(Device().Submit(std::move(commands)));
}

TEST_F(CommandListTest, MoreGroupsThanTheDeviceTakes_AreRefused) {
    const rhi::ComputePipeline pipeline = CountingPipeline();
    CommandList commands = Device().BeginCommands("nothing");
    commands.Bind(pipeline);
    const uint32_t max = Device().Info().maxGroupCounts[1];
    ASSERT_GE(max, 65535u) << "Vulkan's minimum";
    ASSERT_LT(max, ~0u);
    EXPECT_THAT(ErrorTextOf([&] { commands.Dispatch(1, max + 1); }),
                ::testing::HasSubstr("1 x " + std::to_string(max + 1) + " x 1 groups, the device takes"));
    Device().WaitFor(Device().Submit(std::move(commands)));
}

TEST_F(CommandListTest, CallsWithoutTheirPipeline_AreRefused) {
    const rhi::ComputePipeline pipeline = CountingPipeline();
    const rhi::Buffer buffer = Device().CreateBuffer({.name = "b", .size = 64});
    CommandList commands = Device().BeginCommands("misuse");
    const BoundResource resource{.binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .buffer = &buffer};
    const std::vector<uint32_t> constants(4, 0);
    EXPECT_STREQ(ErrorOf([&] {
                     commands.BindResources({&resource, 1});
                 }).what(),
                 "BindResources: no pipeline is bound");
    EXPECT_EQ(ErrorOf([&] { commands.PushConstants(BytesOf(constants)); }).Kind(), ErrorKind::Usage);
    EXPECT_EQ(ErrorOf([&] { commands.Draw(3); }).Kind(), ErrorKind::Usage);
    commands.Bind(pipeline);
    EXPECT_STREQ(ErrorOf([&] {
                     commands.TraceRays({1, 1});
                 }).what(),
                 "TraceRays: no ray-tracing pipeline is bound");
    EXPECT_THAT(ErrorOf([&] { commands.PushConstants(BytesOf(constants)); }).what(),
                HasSubstr("16 bytes, pipeline 'count' takes a multiple of 4 up to 12"));
    const BoundResource nothing{.binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER};
    EXPECT_THAT(ErrorOf([&] {
                    commands.BindResources({&nothing, 1});
                }).what(),
                HasSubstr("pipeline 'count', binding 1: nothing is given for it"));
    EXPECT_EQ(ErrorOf([&] { commands.BeginRendering({0, 1}, {}); }).Kind(), ErrorKind::Usage);
}

TEST_F(CommandListTest, Rendering_ClearsItsTargets) {
    const rhi::Texture color =
        Device().CreateTexture({.name = "color",
                                .extent = {4, 4},
                                .format = Format::Rgba32Float,
                                .usage = TextureUsage::ColorTarget | TextureUsage::CopySource});
    const rhi::Texture depth =
        Device().CreateTexture({.name = "depth",
                                .extent = {4, 4},
                                .format = Format::D32Float,
                                .usage = TextureUsage::DepthTarget | TextureUsage::CopySource});
    CommandList commands = Device().BeginCommands("rendering");
    commands.Transition(color, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    commands.Transition(depth, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
    const rhi::ColorTarget colorTarget{.texture = &color, .clearValue = {0.25f, 0.5f, 2.0f, 1.0f}};
    const rhi::DepthTarget depthTarget{.texture = &depth, .clearValue = 0.75f};
    commands.BeginRendering({4, 4}, {&colorTarget, 1}, &depthTarget);
    commands.EndRendering();
    Device().Submit(std::move(commands));
    const std::vector<float> texels =
        As<float>(rhi::ReadTexture(Device(), color, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL));
    ASSERT_EQ(texels.size(), 64u);
    for (size_t i = 0; i < 64; i += 4) {
        EXPECT_EQ(texels[i], 0.25f);
        EXPECT_EQ(texels[i + 2], 2.0f);
    }
    EXPECT_EQ(As<float>(rhi::ReadTexture(Device(), depth, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL)),
              std::vector<float>(16, 0.75f));
}

TEST_F(CommandListTest, MovedFromList_IsEmptyAndTheTargetsOldListIsDropped) {
    CommandList first = Device().BeginCommands("first");
    CommandList second = Device().BeginCommands("second");
    const VkCommandBuffer handle = second.Handle();
    first = std::move(second);
    EXPECT_EQ(first.Handle(), handle);
    EXPECT_EQ(second.Handle(), nullptr);  // NOLINT(bugprone-use-after-move): the contract says it is empty
    Device().WaitFor(Device().Submit(std::move(first)));
}

}  // namespace
}  // namespace raygraph::testing::command_list_test
