#include <gmock/gmock.h>

#include "rhi/transfer.h"
#include "tests/graph/graph_test.h"
#include "tests/rhi/fake_loader.h"
#include "tests/rhi/gate.h"
#include "tests/support/error_of.h"

// Frames on a device: results, memory, persistence, culling, readback, timings.
namespace raygraph::frame_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr Extent2D kExtent{37, 19};

std::string Numbered(int i) {
    return std::string("t").append(std::to_string(i));
}

class Frame : public GraphTest {};

TEST_F(Frame, ChainOfPasses_GivesTheirProduct) {
    m_renderer.BeginFrame();
    const TextureId a = Fill(m_renderer, "a", kExtent, 3.0f);
    const TextureId c = Scale(m_renderer, "c", Scale(m_renderer, "b", a, 2.0f), 5.0f);
    const Readback readback = m_renderer.ReadBack(c);
    m_renderer.Execute();
    EXPECT_TRUE(IsRamp(Read(readback), 3.0f, 10.0f));
}

TEST_F(Frame, SharedMemory_KeepsTexelsRightFrameAfterFrame) {
    for (int frame = 0; frame < 6; ++frame) {
        const auto value = static_cast<float>(frame);
        m_renderer.BeginFrame();
        TextureId texture = Fill(m_renderer, "t0", kExtent, value);
        for (int i = 1; i < 8; ++i) texture = Scale(m_renderer, Numbered(i), texture, 2.0f);
        const Readback readback = m_renderer.ReadBack(texture);
        m_renderer.Execute();
        EXPECT_THAT(m_renderer.DescribePlan(), HasSubstr("saved by sharing"));
        EXPECT_TRUE(IsRamp(Read(readback), value, 128.0f)) << "frame " << frame;
    }
}

// A texture and a buffer take turns in one block.
TEST_F(Frame, BufferAndTextureInOneBlock_KeepTheirContents) {
    m_renderer.AddShader("test/sum.comp", CompileText("test/sum.comp", R"(
layout(local_size_x = 1) in;
layout(binding = 0, r32f) uniform readonly image2D source;
layout(binding = 1, std430) writeonly buffer Rows { float rows[]; };
void main() {
    float sum = 0.0;
    for (int x = 0; x < imageSize(source).x; ++x) sum += imageLoad(source, ivec2(x, gl_GlobalInvocationID.x)).r;
    rows[gl_GlobalInvocationID.x] = sum;
})"));
    m_renderer.AddShader("test/spread.comp", CompileText("test/spread.comp", R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, std430) readonly buffer Rows { float rows[]; };
layout(binding = 1, r32f) uniform writeonly image2D target;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(texel, imageSize(target)))) imageStore(target, texel, vec4(rows[texel.y]));
})"));
    for (int frame = 0; frame < 3; ++frame) {
        m_renderer.BeginFrame();
        const TextureId source = Fill(m_renderer, "source", kExtent, 1.0f);
        BufferId rows = m_renderer.CreateBuffer("rows", {.size = kExtent.height * sizeof(float)});
        m_renderer.AddPass(
            "Sum", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/sum.comp");
                pass.Reads("source", source);
                rows = pass.Writes("Rows", rows);
            },
            [](CommandList& commands) { commands.Dispatch(kExtent.height); });
        TextureId spread =
            m_renderer.CreateTexture("spread", {.extent = kExtent, .format = Format::R32Float});
        m_renderer.AddPass(
            "Spread", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/spread.comp");
                pass.Reads("Rows", rows);
                spread = pass.Writes("target", spread);
            },
            [](CommandList& commands) { commands.DispatchOver(kExtent); });
        const Readback readback = m_renderer.ReadBack(spread);
        m_renderer.Execute();
        const testing::Texels texels = Read(readback);
        const float n = kExtent.width;
        for (uint32_t y = 0; y < kExtent.height; ++y)
            EXPECT_EQ(texels.At(3, y)[0],
                      n * (1.0f + 100.0f * static_cast<float>(y)) + n * (n - 1.0f) / 2.0f);
    }
}

TEST_F(Frame, PersistentTexture_AccumulatesWhileFramesAreInFlight) {
    ASSERT_GE(Device().FramesInFlight(), 2u);
    constexpr int kFrames = 20;
    Readback readback;
    for (int frame = 0; frame < kFrames; ++frame) {
        m_renderer.BeginFrame();
        const TextureId sum = AddTo(m_renderer, "sum", Fill(m_renderer, "one", kExtent, 1.0f));
        m_renderer.Present(sum);
        if (frame == kFrames - 1) readback = m_renderer.ReadBack(sum);
        m_renderer.Execute();  // nothing waits in between
    }
    EXPECT_TRUE(IsRamp(Read(readback), 1.0f, kFrames));
}

TEST_F(Frame, PersistentTexture_StartsAnewWithAnotherExtent) {
    for (const Extent2D extent : {kExtent, kExtent, Extent2D{5, 5}}) {
        m_renderer.BeginFrame();
        m_renderer.Present(AddTo(m_renderer, "sum", Fill(m_renderer, "one", extent, 1.0f)));
        m_renderer.Execute();
    }
    m_renderer.BeginFrame();
    const Readback readback =
        m_renderer.ReadBack(AddTo(m_renderer, "sum", Fill(m_renderer, "one", {5, 5}, 1.0f)));
    m_renderer.Execute();
    EXPECT_TRUE(IsRamp(Read(readback), 1.0f, 2.0f));
}

TEST_F(Frame, IsFresh_UntilASubmittedFrameWrote) {
    const GraphTextureDesc desc{.extent = kExtent, .format = Format::R32Float};
    m_renderer.BeginFrame();
    EXPECT_TRUE(m_renderer.IsFresh(m_renderer.Persist("sum", desc)));
    m_renderer.Execute();  // nothing wrote it

    m_renderer.BeginFrame();
    TextureId sum = m_renderer.Persist("sum", desc);
    EXPECT_TRUE(m_renderer.IsFresh(sum));
    sum = FillInto(m_renderer, "Fill", sum, 1.0f);
    EXPECT_FALSE(m_renderer.IsFresh(sum)) << "a pass of this frame has written it";
    m_renderer.Execute();  // culled: nothing needs it

    m_renderer.BeginFrame();
    sum = m_renderer.Persist("sum", desc);
    EXPECT_TRUE(m_renderer.IsFresh(sum));
    m_renderer.Present(FillInto(m_renderer, "Fill", sum, 1.0f));
    m_renderer.Execute();

    m_renderer.BeginFrame();
    EXPECT_FALSE(m_renderer.IsFresh(m_renderer.Persist("sum", desc)));
    m_renderer.Execute();
    m_renderer.Release("sum");
    m_renderer.BeginFrame();
    EXPECT_TRUE(m_renderer.IsFresh(m_renderer.Persist("sum", desc)));
    m_renderer.Execute();
}

TEST_F(Frame, IsFresh_OutsideOfAFrameIsRefused) {
    m_renderer.BeginFrame();
    const TextureId sum = m_renderer.Persist("sum", {.extent = kExtent, .format = Format::R32Float});
    m_renderer.Execute();
    m_renderer.Release("sum");
    EXPECT_THROW(std::ignore = m_renderer.IsFresh(sum), Error) << "what it asks about may be gone";
}

TEST_F(Frame, PausedView_ShowsWhatAnEarlierFrameLeft) {
    const GraphTextureDesc desc{.extent = kExtent, .format = Format::R32Float};
    m_renderer.BeginFrame();
    const Readback before =
        m_renderer.ReadBack(AddTo(m_renderer, "sum", Fill(m_renderer, "one", kExtent, 1.0f)));
    m_renderer.Execute();
    for (int frame = 0; frame < 2; ++frame) {
        m_renderer.BeginFrame();
        m_renderer.Present(m_renderer.Persist("sum", desc));
        m_renderer.Execute();
        EXPECT_EQ(m_renderer.DescribePlan().find("-> ShaderReadOnly") != std::string::npos, frame == 0)
            << m_renderer.DescribePlan();
    }
    m_renderer.BeginFrame();
    const Readback after =
        m_renderer.ReadBack(AddTo(m_renderer, "sum", Fill(m_renderer, "one", kExtent, 1.0f)));
    m_renderer.Execute();
    EXPECT_TRUE(IsRamp(Read(before), 1.0f));
    EXPECT_TRUE(IsRamp(Read(after), 1.0f, 2.0f));
}

TEST_F(Frame, ChangedDescription_TakesEffectWhenTheFrameIsSubmitted) {
    const GraphTextureDesc small{.extent = {4, 4}, .format = Format::R32Float};
    const auto isFresh = [&](const GraphTextureDesc& desc) {
        return m_renderer.IsFresh(m_renderer.Persist("sum", desc));
    };
    const GraphTextureDesc desc{.extent = kExtent, .format = Format::R32Float};
    m_renderer.BeginFrame();
    m_renderer.Present(FillInto(m_renderer, "Fill", m_renderer.Persist("sum", desc), 1.0f));
    m_renderer.Execute();
    m_renderer.BeginFrame();
    EXPECT_TRUE(isFresh(small));
    m_renderer.DropFrame();
    m_renderer.BeginFrame();
    EXPECT_FALSE(isFresh(desc));
    m_renderer.DropFrame();
    m_renderer.BeginFrame();
    EXPECT_TRUE(isFresh(small));
    m_renderer.Execute();
    m_renderer.BeginFrame();
    EXPECT_TRUE(isFresh(desc));
}

TEST_F(Frame, ToggledView_CostsNothingAndKeepsItsSum) {
    PassId adding{};
    const auto frame = [&](bool isSumShown) {
        m_renderer.BeginFrame();
        const TextureId sum = AddTo(m_renderer, "sum", Fill(m_renderer, "one", kExtent, 1.0f));
        adding = {1};
        const TextureId other = Fill(m_renderer, "other", kExtent, 0.0f);
        m_renderer.Present(isSumShown ? sum : other);
        const Readback readback = m_renderer.ReadBack(isSumShown ? sum : other);
        m_renderer.Execute();
        return readback;
    };
    frame(true);
    EXPECT_TRUE(m_renderer.WasExecuted(adding));
    frame(false);
    EXPECT_FALSE(m_renderer.WasExecuted(adding));
    EXPECT_THAT(m_renderer.DescribePlan(),
                HasSubstr("Fill one (compute): only culled Add to sum needs it\n"));
    frame(false);
    EXPECT_TRUE(IsRamp(Read(frame(true)), 1.0f, 2.0f)) << "two frames showed the sum";
}

TEST_F(Frame, CulledPass_MakesNoPipeline) {
    m_renderer.BeginFrame();
    std::ignore = Fill(m_renderer, "unseen", kExtent, 0.0f);
    m_renderer.Execute();
    EXPECT_EQ(m_renderer.PipelineCount(), 0u);
    for (int frame = 0; frame < 3; ++frame) {
        m_renderer.BeginFrame();
        m_renderer.Present(Fill(m_renderer, "seen", kExtent, 0.0f));
        m_renderer.Execute();
    }
    EXPECT_EQ(m_renderer.PipelineCount(), 1u);
    EXPECT_GT(m_renderer.PipelineCreationMs(), 0.0);
}

TEST_F(Frame, PlanOfARealFrame_SaysWhatRan) {
    for (int frame = 0; frame < 2; ++frame) {
        m_renderer.BeginFrame();
        const TextureId sum = AddTo(m_renderer, "sum", Fill(m_renderer, "one", kExtent, 1.0f));
        m_renderer.Present(Scale(m_renderer, "shown", sum, 0.5f));
        m_renderer.Execute();
    }
    std::string plan = m_renderer.DescribePlan();
    plan = plan.substr(plan.find('\n') + 1);  // sizes of memory are the driver's
    plan = plan.substr(0, plan.find("memory\n    block"));
    EXPECT_EQ(plan, R"(
1 Fill one (compute)
    writes  one v1 (storage write)
    waits   one: memory of the last frame, FragmentShader|ComputeShader write -> ComputeShader write, Undefined -> General

2 Add to sum (compute)
    reads   one v1 (storage read)
    updates sum v1 (storage update)
    waits   one: ComputeShader write -> ComputeShader read, General
    waits   sum: ComputeShader done -> ComputeShader read+write, General

3 Scale shown (compute)
    reads   sum v1 (storage read)
    writes  shown v1 (storage write)
    waits   sum: ComputeShader write -> ComputeShader read, General
    waits   shown: memory of one, ComputeShader done -> ComputeShader write, Undefined -> General

end
    shows   shown v1
    waits   shown: ComputeShader write -> FragmentShader read, General -> ShaderReadOnly

resources
    one    texture 37x19 r32f          transient   passes 1-2
    sum    texture 37x19 r32f          persistent  passes 2-3
    shown  texture 37x19 r32f          transient   passes 3-end

)");
    EXPECT_THAT(m_renderer.DescribePlanDot(), HasSubstr("label=\"2 Add to sum\\ncompute\""));
}

TEST_F(Frame, PlanBeforeExecute_IsThatOfTheFrameAtHand) {
    EXPECT_THROW(m_renderer.DescribePlan(), Error);
    m_renderer.BeginFrame();
    m_renderer.Present(Fill(m_renderer, "first", kExtent, 0.0f));
    m_renderer.Compile();
    EXPECT_THAT(m_renderer.DescribePlan(), HasSubstr("1 Fill first"));
    m_renderer.Present(Fill(m_renderer, "second", kExtent, 0.0f));
    m_renderer.Compile();
    EXPECT_THAT(m_renderer.DescribePlan(), HasSubstr("2 Fill second"));
    m_renderer.Execute();
    m_renderer.BeginFrame();
    EXPECT_THAT(m_renderer.DescribePlan(), HasSubstr("2 Fill second"))
        << "the last one until another is compiled";
}

TEST_F(Frame, HundredFramesWithResizes_TakeNoMoreMemoryThanTheLargest) {
    const auto frame = [&](Extent2D extent) {
        m_renderer.BeginFrame();
        TextureId texture = Fill(m_renderer, "t0", extent, 1.0f);
        for (int i = 1; i < 5; ++i) texture = Scale(m_renderer, Numbered(i), texture, 2.0f);
        const Readback readback = m_renderer.ReadBack(texture);
        m_renderer.Execute();
        return readback;
    };
    constexpr Extent2D kLargest{256, 256};
    // How many frames a device has in flight, and so how many buffers are read back at a time, is a matter of
    // timing, unless each is waited for.
    const auto waitedFor = [&] { EXPECT_TRUE(IsRamp(Read(frame(kLargest)), 1.0f, 16.0f)); };
    for (int i = 0; i < 4; ++i) waitedFor();
    Device().WaitIdle();
    const uint64_t settled = Device().Memory().usedBytes;
    for (uint32_t i = 0; i < 100; ++i) {
        const Extent2D extent{16 + 24 * (i % 10), 256 - 12 * (i % 20)};
        const Readback readback = frame(extent);
        if (i % 25 == 24) {
            EXPECT_TRUE(IsRamp(Read(readback), 1.0f, 16.0f));
        }
    }
    for (int i = 0; i < 4; ++i) frame(kLargest);
    Device().WaitIdle();
    Device().CollectGarbage();
    // Readback buffers of other sizes may still be kept for reuse; each is smaller than one texture.
    EXPECT_LE(Device().Memory().usedBytes, settled + (uint64_t{18} << 18));
    for (int i = 0; i < 40; ++i) waitedFor();
    Device().WaitIdle();
    Device().CollectGarbage();
    EXPECT_LE(Device().Memory().usedBytes, settled);
}

TEST_F(Frame, SmallerFrames_GiveTheirMemoryBackAfterAWhile) {
    const auto frame = [&](Extent2D extent) {
        m_renderer.BeginFrame();
        m_renderer.Present(Scale(m_renderer, "b", Fill(m_renderer, "a", extent, 1.0f), 2.0f));
        m_renderer.Execute();
    };
    frame({8, 8});
    Device().WaitIdle();
    const uint64_t small = Device().Memory().usedBytes;
    frame({1024, 1024});
    EXPECT_GE(Device().Memory().usedBytes, (uint64_t{8} << 20));
    for (int i = 0; i < 40; ++i) frame({8, 8});
    Device().WaitIdle();
    Device().CollectGarbage();
    EXPECT_EQ(Device().Memory().usedBytes, small);
}

TEST_F(Frame, Readback_OfABufferAndOfADroppedFrame) {
    m_renderer.BeginFrame();
    const Readback dropped = m_renderer.ReadBack(Fill(m_renderer, "a", kExtent, 1.0f));
    EXPECT_FALSE(dropped.IsReady());
    EXPECT_THROW(dropped.Wait(), Error);
    m_renderer.BeginFrame();
    EXPECT_THROW(dropped.Wait(), Error);
    BufferId buffer = m_renderer.CreateBuffer("words", {.size = 64});
    m_renderer.AddPass(
        "Fill", PassKind::Transfer, [&](PassBuilder& pass) { buffer = pass.CopiesTo(buffer); },
        [buffer](CommandList& commands, const PassResources& resources) {
            commands.Fill(resources.Buffer(buffer), 0x01020304u);
        });
    const Readback readback = m_renderer.ReadBack(buffer);
    m_renderer.Execute();
    readback.Wait();
    ASSERT_TRUE(readback.IsReady());
    EXPECT_EQ(testing::As<uint32_t>(readback.Bytes()), std::vector<uint32_t>(16, 0x01020304u));
}

TEST_F(Frame, Readback_OutlivesItsRendererButHasNoBytes) {
    Readback readback;
    {
        Renderer renderer(Device());
        AddTestShaders(renderer);
        renderer.BeginFrame();
        readback = renderer.ReadBack(Fill(renderer, "a", kExtent, 1.0f));
        renderer.Execute();
    }
    EXPECT_FALSE(readback.IsReady());
    EXPECT_THROW(std::ignore = readback.Bytes(), Error);
}

TEST_F(Frame, UniformData_ReachesItsBlock) {
    m_renderer.AddShader("test/uniform.comp", CompileText("test/uniform.comp", R"(
layout(local_size_x = 1) in;
layout(binding = 0, std140) uniform Values { vec4 factors; uint offset; } values;
layout(binding = 1, std430) writeonly buffer Result { float result[4]; };
void main() { for (int i = 0; i < 4; ++i) result[i] = values.factors[i] + float(values.offset); })"));
    struct Values {
        float factors[4];
        uint32_t offset;
    };
    std::vector<Readback> readbacks;
    for (uint32_t frame = 0; frame < 12; ++frame) {  // in flight, so that frames must not share their data
        m_renderer.BeginFrame();
        for (uint32_t i = 0; i < 3; ++i) {
            BufferId result = m_renderer.CreateBuffer("result", {.size = 16});
            m_renderer.AddPass(
                "Use uniform", PassKind::Compute,
                [&](PassBuilder& pass) {
                    pass.Compute("test/uniform.comp");
                    pass.Uniform("values", Values{{1.0f, 2.0f, 3.0f, 4.0f}, 10 * frame + i});
                    result = pass.Writes("Result", result);
                },
                [](CommandList& commands) { commands.Dispatch(1); });
            readbacks.push_back(m_renderer.ReadBack(result));
        }
        m_renderer.Execute();
    }
    for (size_t i = 0; i < readbacks.size(); ++i) {
        readbacks[i].Wait();
        const auto offset = static_cast<float>(10 * (i / 3) + i % 3);
        EXPECT_EQ(testing::As<float>(readbacks[i].Bytes())[2], 3.0f + offset) << "readback " << i;
    }
}

// A descriptor of the whole buffer would be beyond the limit.
TEST_F(Frame, UniformBlockOfABufferAboveTheLimit_ReadsItsBeginning) {
    const uint64_t size = std::min<uint64_t>(Device().Info().maxUniformBufferBytes + 16, 1u << 24);
    m_renderer.AddShader("test/first.comp", CompileText("test/first.comp", R"(
layout(local_size_x = 1) in;
layout(binding = 0, std140) uniform Values { uvec4 first; } values;
layout(binding = 1, std430) writeonly buffer Result { uint result; };
void main() { result = values.first.y; })"));
    m_renderer.BeginFrame();
    BufferId values = m_renderer.CreateBuffer("values", {.size = size});
    m_renderer.AddPass(
        "Fill", PassKind::Transfer, [&](PassBuilder& pass) { values = pass.CopiesTo(values); },
        [&](CommandList& commands, const PassResources& resources) {
            commands.Fill(resources.Buffer(values), 7);
        });
    BufferId result = m_renderer.CreateBuffer("result", {.size = 4});
    m_renderer.AddPass(
        "First", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("test/first.comp");
            pass.Reads("values", values);
            result = pass.Writes("Result", result);
        },
        [](CommandList& commands) { commands.Dispatch(1); });
    const Readback readback = m_renderer.ReadBack(result);
    m_renderer.Execute();
    readback.Wait();
    EXPECT_EQ(testing::As<uint32_t>(readback.Bytes()), std::vector<uint32_t>{7});
    EXPECT_EQ(Device().ValidationMessageCount(), 0u);
}

}  // namespace
}  // namespace raygraph::frame_test

// When frames would wait, and what they say of their times.
namespace raygraph::frame_timing_test {
namespace {

constexpr Extent2D kExtent{37, 19};

class FrameTimingTest : public GraphTest {};

TEST_F(FrameTimingTest, WouldWait_SaysWhenAllFramesInFlightArePending) {
    EXPECT_FALSE(m_renderer.WouldBlock());
    testing::Gate gate(Device());
    for (uint32_t frame = 0; frame < Device().FramesInFlight(); ++frame) {
        EXPECT_FALSE(m_renderer.WouldBlock()) << "before frame " << frame;
        m_renderer.BeginFrame();
        m_renderer.WaitSemaphore(gate.At(1));
        m_renderer.Present(Fill(m_renderer, "a", kExtent, 1.0f));
        m_renderer.Execute();
    }
    EXPECT_TRUE(m_renderer.WouldBlock());
    gate.Open();
    Device().WaitIdle();
    EXPECT_FALSE(m_renderer.WouldBlock());
}

TEST_F(FrameTimingTest, NextPass_IsTheIdInTheTimings) {
    m_renderer.BeginFrame();
    EXPECT_EQ(m_renderer.NextPass().index, 0u);
    Fill(m_renderer, "unused", kExtent, 1.0f);
    const PassId first = m_renderer.NextPass();
    m_renderer.Present(Scale(m_renderer, "b", Fill(m_renderer, "a", kExtent, 1.0f), 2.0f));
    const PassId end = m_renderer.NextPass();
    EXPECT_EQ(first.index, 1u);
    EXPECT_EQ(end.index, 3u);
    m_renderer.Execute();
    Device().WaitIdle();
    const std::vector<FrameTiming> timings = m_renderer.TakeTimings();
    ASSERT_EQ(timings.size(), 1u);
    ASSERT_EQ(timings[0].passes.size(), 2u);
    EXPECT_EQ(timings[0].passes[0].id.index, 1u);
    EXPECT_EQ(timings[0].passes[1].id.index, 2u);
    EXPECT_NE(testing::ErrorTextOf([&] { m_renderer.NextPass(); }), "accepted") << "no frame is open";
}

TEST_F(FrameTimingTest, Timings_ArriveForEveryFrameInOrder) {
    constexpr uint64_t kFrames = 7;
    std::vector<FrameTiming> timings;
    for (uint64_t frame = 0; frame < kFrames; ++frame) {
        m_renderer.BeginFrame();
        m_renderer.Present(Scale(m_renderer, "b", Fill(m_renderer, "a", {512, 512}, 1.0f), 2.0f));
        m_renderer.Execute();
        for (FrameTiming& timing : m_renderer.TakeTimings()) timings.push_back(std::move(timing));
    }
    Device().WaitIdle();
    for (FrameTiming& timing : m_renderer.TakeTimings()) timings.push_back(std::move(timing));
    ASSERT_EQ(timings.size(), kFrames);
    for (uint64_t frame = 0; frame < kFrames; ++frame) {
        EXPECT_EQ(timings[frame].frame, frame + 1);
        ASSERT_EQ(timings[frame].passes.size(), 2u);
        EXPECT_EQ(timings[frame].passes[0].name, "Fill a");
        EXPECT_EQ(timings[frame].passes[1].name, "Scale b");
        for (const PassTiming& pass : timings[frame].passes) {
            EXPECT_GT(pass.gpuMs, 0.0);
            EXPECT_GT(pass.cpuMs, 0.0);
        }
        EXPECT_GT(timings[frame].declareMs, 0.0);
        EXPECT_GT(timings[frame].compileMs, 0.0);
        EXPECT_GT(timings[frame].recordMs, 0.0);
    }
    EXPECT_EQ(m_renderer.Timing().frame, kFrames);
}

}  // namespace
}  // namespace raygraph::frame_timing_test

// A host's images in and out: layouts, semaphores, states over frames.
namespace raygraph::import_test {
namespace {

using ::testing::HasSubstr;

constexpr Extent2D kExtent{24, 10};

class Import : public GraphTest {
  protected:
    rhi::Texture HostTexture() {
        return Device().CreateTexture({.name = "host",
                                       .extent = kExtent,
                                       .format = Format::R32Float,
                                       .usage = rhi::TextureUsage::Storage | rhi::TextureUsage::Sampled |
                                                rhi::TextureUsage::CopySource |
                                                rhi::TextureUsage::CopyDestination});
    }
    testing::Texels TexelsOf(const rhi::Texture& texture, VkImageLayout layout) {
        return testing::DecodeTexels(rhi::ReadTexture(Device(), texture, layout), kExtent, Format::R32Float);
    }
};

TEST_F(Import, ExportedTexture_IsLeftInTheLayoutAskedFor) {
    const rhi::Texture host = HostTexture();
    ResourceState state;
    for (const VkImageLayout layout :
         {VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_GENERAL,
          VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL}) {
        m_renderer.BeginFrame();
        m_renderer.Export(FillInto(m_renderer, "Fill", m_renderer.Import("host", host, state), 7.0f), layout);
        m_renderer.Execute();
        EXPECT_EQ(state.layout, layout);
        EXPECT_TRUE(IsRamp(TexelsOf(host, layout), 7.0f));
    }
}

TEST_F(Import, PresentedAndTouchedByNoPass_IsReadable) {
    const rhi::Texture host = HostTexture();
    rhi::CommandList commands = Device().BeginCommands("host");
    commands.Transition(host, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    commands.Clear(host, {5.0f, 0.0f, 0.0f, 0.0f});
    Device().Submit(std::move(commands));
    ResourceState state{.writeStages = VK_PIPELINE_STAGE_2_CLEAR_BIT,
                        .writeAccess = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                        .layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
    m_renderer.BeginFrame();
    m_renderer.Present(m_renderer.Import("host", host, state));
    m_renderer.Execute();
    EXPECT_EQ(state.layout, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    EXPECT_EQ(TexelsOf(host, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL).At(3, 2)[0], 5.0f);
}

// The host fills the image in a submission of its own, signals a semaphore, and waits for ours.
TEST_F(Import, Semaphores_OrderTheHostsWorkAroundTheFrame) {
    rhi::Device& device = Device();
    const rhi::Texture host = HostTexture();
    VkSemaphoreTypeCreateInfo type{};
    type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
    type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
    VkSemaphore semaphore = VK_NULL_HANDLE;
    ASSERT_EQ(device.Vk().vkCreateSemaphore(device.Handle(), &info, nullptr, &semaphore), VK_SUCCESS);

    rhi::CommandList commands = device.BeginCommands("host");
    commands.Transition(host, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    commands.Clear(host, {5.0f, 0.0f, 0.0f, 0.0f});
    const rhi::SemaphoreUse hostDone{semaphore, 1};
    device.Submit(std::move(commands), {}, std::span(&hostDone, 1));

    ResourceState state{.layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
    m_renderer.BeginFrame();
    m_renderer.WaitSemaphore(hostDone);
    m_renderer.SignalSemaphore({semaphore, 2});
    const TextureId image = m_renderer.Import("host", host, state);
    const Readback readback = m_renderer.ReadBack(Scale(m_renderer, "scaled", image, 2.0f));
    m_renderer.Export(image, VK_IMAGE_LAYOUT_GENERAL);
    m_renderer.Execute();
    EXPECT_THAT(m_renderer.DescribePlan(),
                HasSubstr("host: AllCommands done -> ComputeShader read, CopyTarget -> General\n"));
    const testing::Texels texels = Read(readback);
    EXPECT_EQ(texels.At(0, 0)[0], 10.0f);
    EXPECT_EQ(texels.At(kExtent.width - 1, kExtent.height - 1)[0], 10.0f);

    const uint64_t value = 2;
    const VkSemaphoreWaitInfo wait{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO, nullptr, 0, 1, &semaphore, &value};
    EXPECT_EQ(device.Vk().vkWaitSemaphores(device.Handle(), &wait, 5'000'000'000ull), VK_SUCCESS);
    device.WaitQueueIdle();
    device.Vk().vkDestroySemaphore(device.Handle(), semaphore, nullptr);
}

TEST_F(Import, SameObjectTwice_IsOneResource) {
    const rhi::Texture host = HostTexture();
    ResourceState state;
    m_renderer.BeginFrame();
    const TextureId first = FillInto(m_renderer, "Fill", m_renderer.Import("host", host, state), 1.0f);
    EXPECT_EQ(m_renderer.Import("host again", host, state), first);
    ResourceState other;
    EXPECT_THROW(m_renderer.Import("host", host, other), Error);
}

TEST_F(Import, StateIsWrittenBackOnlyByExecute) {
    const rhi::Texture host = HostTexture();
    ResourceState state;
    m_renderer.BeginFrame();
    m_renderer.Present(FillInto(m_renderer, "Fill", m_renderer.Import("host", host, state), 1.0f));
    m_renderer.Compile();
    EXPECT_EQ(state, ResourceState{});
    m_renderer.Execute();
    EXPECT_EQ(state.layout, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
}

TEST_F(Import, TextureMadeWithoutTheUsage_IsRefused) {
    const rhi::Texture host = Device().CreateTexture(
        {.name = "host", .extent = kExtent, .format = Format::R32Float, .usage = rhi::TextureUsage::Sampled});
    ResourceState state;
    m_renderer.BeginFrame();
    const TextureId image = m_renderer.Import("host", host, state);
    EXPECT_EQ(testing::ErrorTextOf([&] { std::ignore = FillInto(m_renderer, "Fill", image, 1.0f); }),
              R"(pass "Fill" uses "host" as storage write, but it was made without that usage)");
}

TEST_F(Import, HostsBuffer_IsReadAndKeepsItsState) {
    const rhi::Buffer host =
        Device().CreateBuffer({.name = "host",
                               .size = 64,
                               .usage = rhi::BufferUsage::CopyDestination | rhi::BufferUsage::CopySource});
    ResourceState state;
    for (uint32_t frame = 0; frame < 4; ++frame) {
        m_renderer.BeginFrame();
        BufferId buffer = m_renderer.Import("host", host, state);
        m_renderer.AddPass(
            "Fill", PassKind::Transfer, [&](PassBuilder& pass) { buffer = pass.CopiesTo(buffer); },
            [buffer, frame](CommandList& commands, const PassResources& resources) {
                commands.Fill(resources.Buffer(buffer), frame);
            });
        const Readback readback = m_renderer.ReadBack(buffer);
        m_renderer.Execute();
        readback.Wait();
        EXPECT_EQ(testing::As<uint32_t>(readback.Bytes()), std::vector<uint32_t>(16, frame));
    }
}

// lavapipe has one queue family: what is recorded is what can be seen of it.
TEST(ImportOfAnotherQueueFamily, BufferIsAcquiredAndReleasedByItsOwnBarriers) {
    testing::FakeLoader loader;
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create({.savePipelineCache = false, .getInstanceProcAddr = loader.Entry()});
    const rhi::Buffer owner =
        device->CreateBuffer({.name = "host", .size = 64, .usage = rhi::BufferUsage::CopyDestination});
    rhi::BufferDesc desc = owner.Desc();
    const uint32_t ours = device->QueueFamily(), theirs = ours + 1;
    for (const bool isShared : {false, true}) {
        desc.isShared = isShared;
        const rhi::Buffer host = device->WrapBuffer(desc, owner.Handle());
        EXPECT_EQ(host.IsShared(), isShared);
        ResourceState state{.queueFamily = theirs};
        Renderer renderer(*device);
        for (int frame = 0; frame < 2; ++frame) {
            loader.Tell().bufferBarriers.clear();
            renderer.BeginFrame();
            BufferId buffer = renderer.Import("host", host, state);
            renderer.AddPass(
                "Fill", PassKind::Transfer, [&](PassBuilder& pass) { buffer = pass.CopiesTo(buffer); },
                [buffer](CommandList& commands, const PassResources& resources) {
                    commands.Fill(resources.Buffer(buffer), 7);
                });
            renderer.Export(buffer, theirs);
            renderer.Execute();
            EXPECT_EQ(state.queueFamily, theirs);
            const std::vector<VkBufferMemoryBarrier2>& barriers = loader.Tell().bufferBarriers;
            if (isShared) {
                EXPECT_TRUE(barriers.empty()) << "a concurrent buffer has no owner";
                continue;
            }
            ASSERT_EQ(barriers.size(), 2u);
            for (const VkBufferMemoryBarrier2& barrier : barriers) {
                EXPECT_EQ(barrier.buffer, owner.Handle());
                EXPECT_EQ(barrier.offset, 0u);
                EXPECT_EQ(barrier.size, VK_WHOLE_SIZE);
            }
            EXPECT_EQ(barriers[0].srcQueueFamilyIndex, theirs);
            EXPECT_EQ(barriers[0].dstQueueFamilyIndex, ours);
            EXPECT_EQ(barriers[1].srcQueueFamilyIndex, ours);
            EXPECT_EQ(barriers[1].dstQueueFamilyIndex, theirs);
        }
    }
}

}  // namespace
}  // namespace raygraph::import_test
