#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <chrono>
#include <thread>
#include <tuple>

#include "rhi/command_list.h"
#include "rhi/device.h"
#include "rhi/functions.h"
#include "rhi/pipeline.h"
#include "rhi/shader_compiler.h"
#include "rhi/timestamps.h"
#include "rhi/transfer.h"
#include "tests/rhi/gate.h"
#include "tests/support/error_of.h"
#include "tests/support/failing_vulkan.h"
#include "tests/support/vulkan_test.h"

// Command lists: each function does what its Vulkan command does, and misuse is refused before Vulkan
// sees it.
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

TEST_F(CommandListTest, DispatchOver_CoversEveryTexelOnceInWhateverPortions) {
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
        constexpr uint32_t kParts = 5;  // more than some extents have workgroups
        for (uint32_t part = 0; part < kParts; part += 2) {
            commands.SetPortion({.first = part, .end = std::min(part + 2, kParts), .of = kParts});
            commands.DispatchOver(extent);
        }
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

// Tests the timeline: submissions, waiting, command lists, deferred destruction.
namespace raygraph::testing::timeline_test {
namespace {

using rhi::BufferUsage;
using rhi::SemaphoreUse;
using ::testing::HasSubstr;

using TimelineTest = VulkanTest;

TEST_F(TimelineTest, SubmissionsCountUp) {
    const rhi::Submission first = Device().Submit(Device().BeginCommands("a"));
    const rhi::Submission second = Device().Submit(Device().BeginCommands("b"));
    EXPECT_EQ(second.value, first.value + 1);
    EXPECT_EQ(Device().LastSubmittedValue(), second.value);
    Device().WaitFor(second);
    EXPECT_EQ(Device().CompletedValue(), second.value);
}

TEST_F(TimelineTest, OutcomeOfAList_IsTold) {
    std::string told;
    const auto note = [&](rhi::CommandList& commands, const std::string& name) {
        commands.OnSubmitted([&told, name] { told += name + " runs, "; });
        commands.OnDropped([&told, name] { told += name + " is undone, "; });
    };
    rhi::CommandList submitted = Device().BeginCommands("submitted");
    note(submitted, "a");
    note(submitted, "b");
    EXPECT_EQ(told, "") << "not before it is known";
    Device().Submit(std::move(submitted));
    EXPECT_EQ(told, "a runs, b runs, ");
    told.clear();
    {
        rhi::CommandList dropped = Device().BeginCommands("dropped");
        note(dropped, "a");
        note(dropped, "b");
        const rhi::CommandList moved = std::move(dropped);
    }
    EXPECT_EQ(told, "b is undone, a is undone, ") << "backwards, and once";
}

TEST_F(TimelineTest, WaitingForTheFuture_IsRefused) {
    const uint64_t next = Device().LastSubmittedValue() + 1;
    EXPECT_EQ(ErrorOf([&] { Device().WaitFor({next}); }).Kind(), ErrorKind::Usage);
}

TEST_F(TimelineTest, SubmitWaitsForAndSignalsSemaphores) {
    Gate before(Device()), after(Device());
    const SemaphoreUse wait = before.At(1), signal = after.At(5);
    const rhi::Submission value = Device().Submit(Device().BeginCommands("gated"), {&wait, 1}, {&signal, 1});
    EXPECT_LT(Device().CompletedValue(), value.value);
    EXPECT_EQ(after.Value(), 0u);
    before.Open();
    Device().WaitFor(value);
    EXPECT_EQ(after.Value(), 5u);
}

TEST_F(TimelineTest, EmptyOrForeignList_IsRefused) {
    EXPECT_EQ(ErrorOf([] { Device().Submit(rhi::CommandList()); }).Kind(), ErrorKind::Usage);
    const std::unique_ptr<rhi::Device> other = rhi::Device::Create({.savePipelineCache = false});
    EXPECT_EQ(ErrorOf([&] { Device().Submit(other->BeginCommands("other")); }).Kind(), ErrorKind::Usage);
}

TEST_F(TimelineTest, CommandBuffersAreRecycledOnceCompleted) {
    Device().WaitIdle();
    Gate gate(Device());
    const SemaphoreUse wait = gate.At(1);
    rhi::CommandList list = Device().BeginCommands("pending");
    const VkCommandBuffer pending = list.Handle();
    Device().Submit(std::move(list), {&wait, 1});
    EXPECT_NE(Device().BeginCommands("meanwhile").Handle(), pending);
    gate.Open();
    Device().WaitIdle();
    // All buffers are free now: as many lists as there are buffers reuse the one
    std::vector<rhi::CommandList> lists;
    bool isFound = false;
    for (int i = 0; i < 64 && !isFound; ++i) {
        lists.push_back(Device().BeginCommands("again"));
        isFound = lists.back().Handle() == pending;
    }
    EXPECT_TRUE(isFound);
}

TEST_F(TimelineTest, BufferDestroyedWhilePending_IsFreedOnlyWhenItsWorkIsDone) {
    Device().WaitIdle();
    const uint64_t used = Device().Memory().usedBytes;
    Gate gate(Device());
    const SemaphoreUse wait = gate.At(1);
    rhi::Buffer buffer = Device().CreateBuffer(
        {.name = "short-lived", .size = 1 << 16, .usage = BufferUsage::CopyDestination});
    const uint64_t with = Device().Memory().usedBytes;
    ASSERT_GT(with, used);
    rhi::CommandList commands = Device().BeginCommands("uses the buffer");
    commands.Fill(buffer, 1);
    const rhi::Submission value = Device().Submit(std::move(commands), {&wait, 1});
    buffer = {};
    Device().CollectGarbage();
    EXPECT_EQ(Device().Memory().usedBytes, with) << "the fill has not run yet";
    gate.Open();
    Device().WaitFor(value);
    EXPECT_EQ(Device().Memory().usedBytes, used);
}

TEST_F(TimelineTest, BufferDestroyedWhileItsListIsRecorded_IsFreedAfterThatList) {
    Device().WaitIdle();
    const uint64_t used = Device().Memory().usedBytes;
    rhi::Submission value;
    {
        rhi::CommandList commands = Device().BeginCommands("uses the buffer");
        {
            const rhi::Buffer buffer =
                Device().CreateBuffer({.size = 1 << 16, .usage = BufferUsage::CopyDestination});
            commands.Fill(buffer, 1);
        }
        // Other work completes in between: it says nothing about the list.
        Device().WaitFor(Device().Submit(Device().BeginCommands("other")));
        EXPECT_GT(Device().Memory().usedBytes, used);
        value = Device().Submit(std::move(commands));
    }
    Device().WaitFor(value);
    EXPECT_EQ(Device().Memory().usedBytes, used);
}

TEST_F(TimelineTest, DroppedList_FreesWhatItMentioned) {
    Device().WaitIdle();
    const uint64_t used = Device().Memory().usedBytes;
    {
        rhi::CommandList commands = Device().BeginCommands("dropped");
        const rhi::Buffer buffer =
            Device().CreateBuffer({.size = 4096, .usage = BufferUsage::CopyDestination});
        commands.Fill(buffer, 1);
    }
    EXPECT_EQ(Device().Memory().usedBytes, used) << "no submission is needed for it";
}

TEST_F(TimelineTest, ThreadsSubmitAndDestroyAtTheSameTime) {
    constexpr int kThreads = 4, kRounds = 25;
    Device().WaitIdle();
    const uint64_t used = Device().Memory().usedBytes;
    const uint64_t first = Device().LastSubmittedValue();
    std::vector<std::thread> threads;
    std::atomic<int> wrong{0};
    for (int t = 0; t < kThreads; ++t)
        threads.emplace_back([t, &wrong] {
            for (int i = 0; i < kRounds; ++i) {
                const rhi::Buffer buffer = Device().CreateBuffer(
                    {.size = 256, .usage = BufferUsage::CopySource | BufferUsage::CopyDestination});
                rhi::CommandList commands = Device().BeginCommands("thread");
                const auto value = static_cast<uint32_t>(t * 1000 + i);
                commands.Fill(buffer, value);
                Device().Submit(std::move(commands));
                if (As<uint32_t>(rhi::ReadBuffer(Device(), buffer)) != std::vector<uint32_t>(64, value))
                    ++wrong;
            }
        });
    for (std::thread& thread : threads) thread.join();
    Device().WaitIdle();
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(Device().LastSubmittedValue(), first + 2 * kThreads * kRounds);
    EXPECT_EQ(Device().Memory().usedBytes, used);
}

}  // namespace
}  // namespace raygraph::testing::timeline_test

// Tests GPU timestamps: in order, in nanoseconds, without waiting.
namespace raygraph::testing::timestamps_test {
namespace {

using rhi::BufferUsage;

struct TimestampsTest : VulkanTest {
    // Runs a frame of `count` fills with a timestamp around each.
    uint64_t Frame(uint32_t count) {
        rhi::CommandList commands = Device().BeginCommands("timed");
        pool.BeginFrame(commands);
        EXPECT_EQ(pool.Write(commands), 0u);
        for (uint32_t i = 0; i < count; ++i) {
            commands.FullBarrier();
            commands.Fill(target, i);
            EXPECT_EQ(pool.Write(commands), i + 1);
        }
        const uint64_t value = Device().Submit(std::move(commands)).value;
        pool.EndFrame(value);
        return value;
    }
    rhi::TimestampPool pool{Device(), "times", 16};
    rhi::Buffer target = Device().CreateBuffer({.size = 8 << 20, .usage = BufferUsage::CopyDestination});
};

TEST_F(TimestampsTest, AreMonotoneAndNoLongerThanTheWallTime) {
    const auto start = std::chrono::steady_clock::now();
    const uint64_t value = Frame(8);
    Device().WaitFor({value});
    const double wall =
        std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
    const rhi::TimestampFrame* const frame = pool.Poll();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->submitted, value);
    ASSERT_EQ(frame->nanoseconds.size(), 9u);
    EXPECT_EQ(frame->nanoseconds[0], 0.0);
    for (size_t i = 1; i < 9; ++i) EXPECT_GE(frame->nanoseconds[i], frame->nanoseconds[i - 1]);
    EXPECT_GT(frame->nanoseconds.back(), 0.0) << "64 MiB are not written in no time";
    EXPECT_LE(frame->nanoseconds.back(), wall);
    EXPECT_FALSE(pool.Poll());
}

TEST_F(TimestampsTest, EveryFrameIsReturnedOnceInOrder) {
    std::vector<uint64_t> submitted, returned;
    for (uint32_t i = 0; i < 10; ++i) {
        submitted.push_back(Frame(i % 3));
        while (const rhi::TimestampFrame* const frame = pool.Poll()) {
            EXPECT_EQ(frame->nanoseconds.size(), returned.size() % 3 + 1);
            returned.push_back(frame->submitted);
        }
        Device().WaitFor({submitted.back()});
    }
    while (const rhi::TimestampFrame* const frame = pool.Poll()) returned.push_back(frame->submitted);
    EXPECT_EQ(returned, submitted);
    EXPECT_EQ(pool.LostFrameCount(), 0u);
}

TEST_F(TimestampsTest, UnreadFrames_AreLostAndCounted) {
    const uint32_t ranges = Device().FramesInFlight() + 1;
    for (uint32_t i = 0; i < ranges + 2; ++i) Frame(1);
    Device().WaitIdle();
    EXPECT_EQ(pool.LostFrameCount(), 2u);
    uint32_t count = 0;
    while (pool.Poll()) ++count;
    EXPECT_EQ(count, ranges);
}

TEST_F(TimestampsTest, MoreThanThereIsRoomFor_AreLeftOut) {
    rhi::TimestampPool small(Device(), "small", 2);
    rhi::CommandList commands = Device().BeginCommands("timed");
    EXPECT_FALSE(small.Write(commands)) << "outside of a frame";
    small.BeginFrame(commands);
    EXPECT_TRUE(small.Write(commands));
    EXPECT_TRUE(small.Write(commands));
    EXPECT_FALSE(small.Write(commands));
    small.EndFrame(Device().Submit(std::move(commands)).value);
    Device().WaitIdle();
    EXPECT_EQ(small.Poll()->nanoseconds.size(), 2u);
}

TEST_F(TimestampsTest, FrameThatWasNeverSubmitted_IsGivenUp) {
    {
        rhi::CommandList dropped = Device().BeginCommands("dropped");
        pool.BeginFrame(dropped);
        pool.Write(dropped);
    }
    const uint64_t value = Frame(1);
    Device().WaitFor({value});
    const rhi::TimestampFrame* const frame = pool.Poll();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->submitted, value);
    EXPECT_EQ(pool.LostFrameCount(), 0u);
}

TEST_F(TimestampsTest, EmptyPool_IsRefused) {
    EXPECT_EQ(ErrorOf([] { rhi::TimestampPool(Device(), "none", 0); }).Kind(), ErrorKind::Usage);
}

}  // namespace
}  // namespace raygraph::testing::timestamps_test

// Tests how each wrapper reports Vulkan calls that fail, one at a time.
namespace raygraph::testing::failing_call_test {
namespace {

class FailingCallTest : public ::testing::Test {
  protected:
    FailingCallTest() {
        InjectFailure(std::nullopt);
        UseDedicatedAllocations(true);
        device = Make();
    }
    std::unique_ptr<rhi::Device> Make() {
        return rhi::Device::Create({.validation = true,
                                    .log = log.Listener(),
                                    .savePipelineCache = false,
                                    .getInstanceProcAddr = FailingLoader(system->GetInstanceProcAddr())});
    }
    ~FailingCallTest() override {
        ClearInjectedFailure();
        device.reset();
        EXPECT_EQ(log.Text(), "");
        UseDedicatedAllocations(false);
        InjectFailure(std::nullopt);
    }

    std::shared_ptr<rhi::VulkanLoader> system = rhi::VulkanLoader::Open();
    MessageLog log;
    std::unique_ptr<rhi::Device> device;
};

TEST_F(FailingCallTest, DeviceThatCannotBeMade_LeavesNothing) {
    uint64_t queueCount = 0;
    for (const rhi::QueueKind queue : rhi::kQueueKinds) queueCount += device->HasQueue(queue) ? 1 : 0;
    for (const VkResult result : {VK_ERROR_OUT_OF_HOST_MEMORY, VK_ERROR_DEVICE_LOST}) {
        // Creation of the timelines of its queues, and of its pipeline cache
        for (uint64_t number = 1; number <= queueCount + 1; ++number) {
            InjectFailure(InjectedFailure{.number = number, .result = result});
            EXPECT_EQ(ErrorOf([&] { Make(); }).Kind(),
                      result == VK_ERROR_DEVICE_LOST ? ErrorKind::DeviceLost : ErrorKind::OutOfMemory);
        }
        InjectFailure(InjectedFailure{.number = queueCount + 2, .result = result});
        EXPECT_NO_THROW(Make());
    }
}

TEST_F(FailingCallTest, SubmissionThatHasArrived_IsNoError) {
    rhi::CommandList commands = device->BeginCommands("arrives");
    bool hasArrived = false;
    commands.OnSubmitted([&] { hasArrived = true; });
    // Submit next queries how far the device is.
    InjectFailure(InjectedFailure{.call = FailingCall::Wait});
    rhi::Submission value;
    EXPECT_NO_THROW(value = device->Submit(std::move(commands)));
    EXPECT_TRUE(HasFailed());
    EXPECT_TRUE(hasArrived);
    EXPECT_EQ(value.value, device->LastSubmittedValue());
    ClearInjectedFailure();
    device->WaitFor(value);
}

TEST_F(FailingCallTest, SubmissionThatHasNotArrived_LeavesTheTimeline) {
    rhi::CommandList commands = device->BeginCommands("does not arrive");
    bool isDropped = false;
    commands.OnDropped([&] { isDropped = true; });
    InjectFailure(InjectedFailure{.call = FailingCall::Submission});
    EXPECT_EQ(ErrorOf([&] { device->Submit(std::move(commands)); }).Kind(), ErrorKind::OutOfMemory);
    EXPECT_TRUE(isDropped);
    EXPECT_EQ(device->LastSubmittedValue(), 0u);
    EXPECT_EQ(device->Submit(device->BeginCommands("arrives")).value, 1u);
}

// Fails each call that makes a resource in turn, until none is left.
template <typename Make>
uint32_t FailEach(rhi::Device& device, Make&& make) {
    const uint64_t used = device.Memory().usedBytes;
    for (uint32_t failures = 0;; ++failures) {
        InjectFailure(InjectedFailure{.number = failures + 1, .lasts = true});
        try {
            make();
            ClearInjectedFailure();
            return failures;
        } catch (const Error& error) {
            ClearInjectedFailure();
            EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory) << error.what();
            EXPECT_EQ(device.Memory().usedBytes, used) << RecordedCalls().back();
        }
    }
}

TEST_F(FailingCallTest, ResourcesThatCannotBeMadeLeaveNothing) {
    const rhi::TextureDesc texture{.name = "t", .extent = {4, 4}};
    const rhi::BufferDesc buffer{.name = "b", .size = 256};
    EXPECT_EQ(FailEach(*device, [&] { std::ignore = device->CreateTexture(texture); }), 4u)
        << "image, memory, binding, view";
    EXPECT_EQ(FailEach(*device, [&] { std::ignore = device->CreateBuffer(buffer); }), 3u);
    EXPECT_EQ(FailEach(*device, [&] { std::ignore = device->CreateSampler({.name = "s"}); }), 1u);
    {
        const rhi::MemoryBlock block = device->CreateMemoryBlock("block", device->RequirementsOf(texture));
        EXPECT_EQ(FailEach(*device, [&] { std::ignore = device->CreateTexture(texture, block); }), 3u)
            << "image, binding, view";
    }
    const rhi::MemoryBlock block = device->CreateMemoryBlock("block", device->RequirementsOf(buffer));
    EXPECT_EQ(FailEach(*device, [&] { std::ignore = device->CreateBuffer(buffer, block); }), 2u);
}

// The allocator reports every failure as exhausted memory, including that of a lost device.
TEST_F(FailingCallTest, AllocationOnALostDevice_SaysThatItIsLost) {
    InjectFailure(
        InjectedFailure{.call = FailingCall::Allocation, .result = VK_ERROR_DEVICE_LOST, .lasts = true});
    const Error error = ErrorOf([&] { std::ignore = device->CreateBuffer({.name = "b", .size = 256}); });
    EXPECT_EQ(error.Kind(), ErrorKind::DeviceLost);
    EXPECT_EQ(std::string(error.what()), "buffer 'b' (256 bytes): VK_ERROR_DEVICE_LOST; no pass is known");
    ClearInjectedFailure();
    EXPECT_EQ(ErrorOf([&] { device->WaitIdle(); }).Kind(), ErrorKind::DeviceLost);
}

TEST_F(FailingCallTest, FailuresAreReadFromText) {
    for (const char* text : {"allocation:17:oom", "creation:1:lost", "any:200:oom:on", "wait:3:lost"}) {
        const std::optional<InjectedFailure> failure = ParseFailure(text);
        ASSERT_TRUE(failure) << text;
        EXPECT_EQ(failure->Text(), text);
    }
    for (const char* text : {"", "allocation", "allocation:17", "allocation:0:oom", "allocation:x:oom",
                             "walk:1:oom", "wait:1:off", "wait:1:oom:of"})
        EXPECT_FALSE(ParseFailure(text)) << text;
}

}  // namespace
}  // namespace raygraph::testing::failing_call_test
