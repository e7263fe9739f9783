#include <gmock/gmock.h>

#include "tests/graph/graph_test.h"

// Frames with passes that may run on the compute queue, planned as text.
namespace raygraph::queue_plan_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr uint32_t kMainFamily = 0, kComputeFamily = 2;

struct TwoQueues : GraphMaker {
    TwoQueues() {
        queueFamily = kMainFamily;
        computeFamily = kComputeFamily;
    }
    // A pass of GraphMaker, for the compute queue.
    TextureId Beside(std::string_view name, std::initializer_list<TextureId> reads, TextureId target) {
        const TextureId written = Pass(name, reads, target);
        passes.back().queue = rhi::QueueKind::Compute;
        return written;
    }
    // The batches alone: "main: A B; compute: C after 1; main: D after 2".
    std::string Batches() const {
        const Plan plan = Compile(*this);
        std::string text;
        for (const PlannedBatch& batch : plan.batches) {
            text += text.empty() ? "" : "; ";
            text += batch.queue == rhi::QueueKind::Compute ? "compute:" : "main:";
            for (uint32_t p = batch.firstPass; p < batch.firstPass + batch.passCount; ++p)
                text.append(" ").append(passes[plan.passes[p].pass].name);
            if (batch.waitsFor != kNone) text += " after " + std::to_string(batch.waitsFor + 1);
        }
        return text;
    }
};

// Two chains from one source: one is blurred beside the other and joined at the end.
struct Diamond : TwoQueues {
    Diamond() {
        const TextureId source = Pass("Source", {}, Texture("source", 1));
        const TextureId blurred = Beside("Blur", {source}, Texture("blurred", 1));
        const TextureId lit = Pass("Light", {source}, Texture("lit", 1));
        const TextureId toned = Pass("Tone", {lit}, Texture("toned", 1));
        Present(Pass("Join", {toned, blurred}, Texture("joined", 1)));
    }
};

TEST(QueuePlan, PassesOfBothQueues_AreBatchesThatWaitForWhatTheyRead) {
    EXPECT_EQ(Diamond().Batches(),
              "main:; main: Source; compute: Blur after 2; main: Light Tone; main: Join after 3");
}

TEST(QueuePlan, DeviceWithOneQueue_HasOneBatch) {
    Diamond graph;
    graph.computeFamily = VK_QUEUE_FAMILY_IGNORED;
    EXPECT_EQ(graph.Batches(), "main: Source Blur Light Tone Join");
    for (GraphPass& pass : graph.passes) pass.queue = rhi::QueueKind::Main;
    const std::string plain = graph.Text();
    Diamond other;
    for (GraphPass& pass : other.passes) pass.queue = rhi::QueueKind::Main;
    EXPECT_EQ(other.Text(), plain) << "a queue that nothing uses changes nothing";
}

TEST(QueuePlan, Frame_ReadsAsWritten) {
    EXPECT_EQ(Diamond().Text(), R"(5 passes, 9 barriers, 4 MiB of transient memory (1 MiB saved by sharing)

batch 1 on the main queue

batch 2 on the main queue

1 Source (compute)
    writes  source v1 (storage write)
    waits   source: first use -> ComputeShader write, Undefined -> General

batch 3 on the compute queue, after batch 2

2 Blur (compute)
    reads   source v1 (storage read)
    writes  blurred v1 (storage write)
    waits   blurred: ComputeShader done -> ComputeShader write, Undefined -> General

batch 4 on the main queue

3 Light (compute)
    reads   source v1 (storage read)
    writes  lit v1 (storage write)
    waits   source: ComputeShader write -> ComputeShader read, General
    waits   lit: first use -> ComputeShader write, Undefined -> General

4 Tone (compute)
    reads   lit v1 (storage read)
    writes  toned v1 (storage write)
    waits   lit: ComputeShader write -> ComputeShader read, General
    waits   toned: first use -> ComputeShader write, Undefined -> General

batch 5 on the main queue, after batch 3

5 Join (compute)
    reads   toned v1 (storage read)
    reads   blurred v1 (storage read)
    writes  joined v1 (storage write)
    waits   toned: ComputeShader write -> ComputeShader read, General
    waits   joined: memory of lit, ComputeShader done -> ComputeShader write, Undefined -> General

end
    shows   joined v1
    waits   joined: ComputeShader write -> FragmentShader read, General -> ShaderReadOnly

resources
    source   texture 64x64 rgba32f       transient   passes 1-3
    blurred  texture 64x64 rgba32f       transient   passes 2-5
    lit      texture 64x64 rgba32f       transient   passes 3-4
    toned    texture 64x64 rgba32f       transient   passes 4-5
    joined   texture 64x64 rgba32f       transient   passes 5-end

memory
    block 0, 1 MiB: source
    block 1, 1 MiB: blurred
    block 2, 1 MiB: lit, then joined
    block 3, 1 MiB: toned
)");
}

// A pass that runs beside others must not lose its memory to them.
TEST(QueuePlan, TransientOfTheComputeQueue_SharesNoMemory) {
    TwoQueues graph;
    const TextureId a = graph.Beside("A", {}, graph.Texture("a", 4));
    const TextureId b = graph.Beside("B", {a}, graph.Texture("b", 4));
    const TextureId c = graph.Pass("C", {}, graph.Texture("c", 4));
    graph.Present(graph.Pass("D", {b, c}, graph.Texture("d", 4)));
    const Plan plan = Compile(graph);
    EXPECT_EQ(plan.blocks.size(), 4u);
    EXPECT_EQ(graph.Batches(), "main:; compute: A B after 1; main: C; main: D after 2");
}

TEST(QueuePlan, LaterPassOfTheOtherQueue_NeedsNoSecondWait) {
    TwoQueues graph;
    const TextureId a = graph.Beside("A", {}, graph.Texture("a"));
    const TextureId b = graph.Beside("B", {}, graph.Texture("b"));
    const TextureId c = graph.Pass("C", {b}, graph.Texture("c"));
    graph.Present(graph.Pass("D", {a, c}, graph.Texture("d")));
    EXPECT_EQ(graph.Batches(), "main:; compute: A B after 1; main: C D after 2");
}

// An overwrite must wait for readers on the other queue.
TEST(QueuePlan, WriteAfterARead_WaitsForTheReader) {
    TwoQueues graph;
    TextureId a = graph.Pass("A", {}, graph.Persistent("a"));
    const TextureId b = graph.Beside("B", {a}, graph.Texture("b"));
    a = graph.Pass("Again", {}, a);
    graph.Present(graph.Pass("C", {a, b}, graph.Texture("c")));
    EXPECT_EQ(graph.Batches(), "main:; main: A; compute: B after 2; main: Again C after 3");
}

// Both queues read what was there before the frame; nothing orders them.
TEST(QueuePlan, ReadersInOneLayout_RunBesideEachOther) {
    TwoQueues graph;
    const ResourceState before{.layout = VK_IMAGE_LAYOUT_GENERAL};
    const TextureId a = graph.Persistent("a", before);
    const TextureId b = graph.Beside("B", {a}, graph.Texture("b"));
    const TextureId c = graph.Pass("C", {a}, graph.Texture("c"));
    graph.Present(graph.Pass("D", {b, c}, graph.Texture("d")));
    EXPECT_EQ(graph.Batches(), "main:; compute: B after 1; main: C; main: D after 2");
}

// The same, where the first reader must change the layout: the second waits for it.
TEST(QueuePlan, ReaderThatChangesTheLayout_IsWaitedFor) {
    TwoQueues graph;
    const ResourceState before{.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const TextureId a = graph.Persistent("a", before);
    const TextureId b = graph.Beside("B", {a}, graph.Texture("b"));
    const TextureId c = graph.Pass("C", {a}, graph.Texture("c"));
    graph.Present(graph.Pass("D", {b, c}, graph.Texture("d")));
    EXPECT_EQ(graph.Batches(), "main:; compute: B after 1; main: C D after 2");
    EXPECT_THAT(graph.Text(),
                HasSubstr("a: ComputeShader done -> ComputeShader read, ShaderReadOnly -> General"));
}

// Who waits for the frame waits for its last batch on the main queue.
TEST(QueuePlan, FrameThatEndsOnTheComputeQueue_IsJoined) {
    TwoQueues graph;
    const TextureId a = graph.Pass("A", {}, graph.Texture("a"));
    graph.Present(graph.Beside("B", {a}, graph.Texture("b")));
    EXPECT_EQ(graph.Batches(), "main:; main: A; compute: B after 2; main: after 3");
    EXPECT_THAT(graph.Text(),
                HasSubstr("shows   b v1\n    waits   b: FragmentShader done -> FragmentShader read, "
                          "General -> ShaderReadOnly"));
}

TEST(QueuePlan, DrawingPass_StaysOnTheMainQueue) {
    TwoQueues graph;
    graph.AddPass("Draw", PassKind::Raster);
    graph.passes.back().queue = rhi::QueueKind::Compute;
    graph.Present(graph.Use(graph.Texture("a"), Access::ColorWrite));
    EXPECT_EQ(graph.Batches(), "main: Draw");
}

// An image for one family at a time is handed over, and back at the end, with equal barriers on both
// sides.
TEST(QueuePlan, ImageThatIsNotShared_ChangesItsOwner) {
    TwoQueues graph;
    const ResourceState before{.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const TextureId a = graph.Imported<ResourceKind::Texture>("a", before);
    graph.resources.back().isShared = false;
    const TextureId b = graph.Beside("B", {a}, graph.Texture("b"));
    graph.Present(graph.Pass("C", {b}, graph.Texture("c")));
    EXPECT_EQ(graph.Text(), R"(2 passes, 7 barriers

batch 1 on the main queue
    hands over a: AllCommands write -> nothing, ShaderReadOnly -> General, queue family 0 -> 2

batch 2 on the compute queue, after batch 1

1 B (compute)
    reads   a v0 (storage read)
    writes  b v1 (storage write)
    waits   a: ComputeShader done -> ComputeShader read, ShaderReadOnly -> General, queue family 0 -> 2
    waits   b: ComputeShader done -> ComputeShader write, Undefined -> General
    hands over a: AllCommands write -> nothing, General, queue family 2 -> 0

batch 3 on the main queue, after batch 2

2 C (compute)
    reads   b v1 (storage read)
    writes  c v1 (storage write)
    waits   c: first use -> ComputeShader write, Undefined -> General

end
    shows   c v1
    waits   a: AllCommands done -> AllCommands read+write, General, queue family 2 -> 0
    waits   c: ComputeShader write -> FragmentShader read, General -> ShaderReadOnly

resources
    a  texture 64x64 rgba8         imported    pass 1
    b  texture 64x64 rgba32f       transient   passes 1-2
    c  texture 64x64 rgba32f       transient   passes 2-end
)");
}

TEST(QueuePlan, ContentsThatNobodyNeeds_AreNotHandedOver) {
    TwoQueues graph;
    TextureId a = graph.Pass("A", {}, graph.Persistent("a"));
    graph.resources.back().isShared = false;
    a = graph.Beside("B", {}, a);
    graph.Present(a);
    const Plan plan = Compile(graph);
    uint32_t transfers = 0;
    for (const PlannedBarrier& barrier : plan.barriers)
        transfers += barrier.srcQueueFamily == kMainFamily ? 1 : 0;
    EXPECT_EQ(transfers, 0u) << graph.Text();
    EXPECT_THAT(graph.Text(), HasSubstr("queue family 2 -> 0")) << "what outlives the frame goes back";
}

TEST(QueuePlan, QueuesOfOneFamily_NeedNoTransfer) {
    TwoQueues graph;
    graph.computeFamily = kMainFamily;
    const TextureId a = graph.Imported<ResourceKind::Texture>("a", {.layout = VK_IMAGE_LAYOUT_GENERAL});
    graph.resources.back().isShared = false;
    graph.Present(graph.Beside("B", {a}, graph.Texture("b")));
    EXPECT_THAT(graph.Text(), Not(HasSubstr("queue family")));
}

}  // namespace
}  // namespace raygraph::queue_plan_test
