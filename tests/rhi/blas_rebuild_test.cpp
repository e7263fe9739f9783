// Tests deforming structures: in-place rebuilds, compaction, and the memory that these take.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "rhi/blas_builder.h"
#include "rhi/device.h"
#include "tests/rhi/fake_loader.h"
#include "tests/rhi/trace_test.h"
#include "tests/support/error_of.h"

namespace raygraph::rhi::blas_rebuild_test {
namespace {

class BlasRebuild : public TraceTest {
  protected:
    std::vector<TestResult> Hits(const std::shared_ptr<Blas>& blas) {
        return Trace(PlainPipeline(), BuildTlas({Instance(*blas)}), RayGrid(64));
    }
};

// Has one triangle many times, on a device whose builds need more scratch memory than updates.
class RefitScratch : public ::testing::Test {
  protected:
    static constexpr uint64_t kBuildScratch = 1u << 20;

    RefitScratch() {
        loader.Tell().buildScratchBytes = kBuildScratch;
        DeviceDesc desc;
        desc.getInstanceProcAddr = loader.Entry();
        desc.savePipelineCache = false;
        device = Device::Create(desc);
        vertices = Upload("vertices", std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0});
        indices = Upload("indices", std::vector<uint32_t>{0, 1, 2});
    }
    template <typename T>
    Buffer Upload(const char* name, const std::vector<T>& data) {
        Buffer buffer = device->CreateBuffer({.name = name,
                                              .size = data.size() * sizeof(T),
                                              .usage = BufferUsage::BuildInput,
                                              .memory = MemoryKind::Upload});
        std::ranges::copy(std::as_bytes(std::span(data)), buffer.Mapped().begin());
        return buffer;
    }
    std::vector<std::shared_ptr<Blas>> AddTriangles(BlasBuilder& builder, uint32_t count) {
        const BlasDesc desc{.name = "triangle",
                            .kind = BlasKind::Deforming,
                            .triangles = {{.vertices = vertices.Address(),
                                           .vertexCount = 3,
                                           .indices = indices.Address(),
                                           .triangleCount = 1}}};
        std::vector<std::shared_ptr<Blas>> blases;
        for (uint32_t i = 0; i < count; ++i) blases.push_back(builder.Add(desc));
        Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
        loader.Tell().builds.clear();
        return blases;
    }
    void Run(const std::function<void(CommandList&)>& record) {
        CommandList commands = device->BeginCommands("test");
        record(commands);
        device->WaitFor(device->Submit(std::move(commands)));
    }
    uint64_t UsedBytes() {
        device->WaitIdle();
        device->CollectGarbage();
        return device->Memory().usedBytes;
    }

    testing::FakeLoader loader;
    std::unique_ptr<Device> device;
    Buffer vertices, indices;
};

// Makes two quads, of which the second is NaN unless it is asked for.
TestMesh OneOrTwoQuads(bool hasSecond) {
    TestMesh mesh = Quad(0, 0), second = Quad(3, -1);
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    for (std::array<float, 3>& vertex : second.vertices) {
        if (!hasSecond) vertex[0] = std::numeric_limits<float>::quiet_NaN();
        mesh.vertices.push_back(vertex);
    }
    for (const uint32_t index : second.indices) mesh.indices.push_back(first + index);
    return mesh;
}

// Triangles appear, which no update can do. Where drivers update by a rebuild, the tests of RefitScratch tell
// the two apart.
TEST_F(BlasRebuild, RebuildInPlaceShowsNewTrianglesAndKeepsTheAddress) {
    BlasBuilder builder(Device(), {.name = "deforming"});
    const std::shared_ptr<Blas> blas = builder.Add(Describe(OneOrTwoQuads(false), BlasKind::Deforming));
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    const VkDeviceAddress address = blas->Address();
    const std::vector<TestRay> rays{{.origin = {0.1f, 0.2f, -4}}, {.origin = {3.1f, 0.2f, -4}}};
    std::vector<TestResult> results = Trace(PlainPipeline(), BuildTlas({Instance(*blas)}), rays);
    EXPECT_EQ(results[1].code, 2u);
    const std::vector<BlasBuilder::RefitRequest> requests{
        {blas.get(), Describe(OneOrTwoQuads(true), BlasKind::Deforming), true}};
    Run([&](CommandList& commands) { builder.RecordRefits(commands, requests); });
    results = Trace(PlainPipeline(), BuildTlas({Instance(*blas)}), rays);
    EXPECT_FLOAT_EQ(results[0].distance, 4.0f);
    EXPECT_FLOAT_EQ(results[1].distance, 3.0f);
    EXPECT_EQ(blas->Address(), address);
    EXPECT_EQ(builder.Statistics().rebuildCount, 1u);
    EXPECT_EQ(builder.Statistics().refitCount, 0u);
    {
        CommandList dropped = Device().BeginCommands("dropped");
        builder.RecordRefits(dropped, requests);
    }
    EXPECT_EQ(builder.Statistics().rebuildCount, 1u) << "of submitted lists";
}

TEST_F(RefitScratch, UpdatesOfAllShareABatchAndRebuildsTakeTurnsWithoutMoreMemory) {
    BlasBuilder builder(*device, {.name = "tight", .scratchBudget = kBuildScratch});
    const std::vector<std::shared_ptr<Blas>> blases = AddTriangles(builder, 4);
    std::vector<BlasBuilder::RefitRequest> requests;
    for (const std::shared_ptr<Blas>& blas : blases) requests.push_back({.blas = blas.get()});
    constexpr auto kBuild = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    constexpr auto kUpdate = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    using Batches = std::vector<std::vector<VkBuildAccelerationStructureModeKHR>>;
    device->LimitMemory(UsedBytes());
    Run([&](CommandList& commands) { builder.RecordRefits(commands, requests); });
    EXPECT_EQ(loader.Tell().builds, (Batches{{kUpdate, kUpdate, kUpdate, kUpdate}}));
    loader.Tell().builds.clear();
    for (const size_t i : {0, 1, 3}) requests[i].rebuilds = true;
    Run([&](CommandList& commands) { builder.RecordRefits(commands, requests); });
    EXPECT_EQ(loader.Tell().builds, (Batches{{kBuild}, {kBuild}, {kUpdate}, {kBuild}}));
    EXPECT_EQ(builder.Statistics().rebuildCount, 3u);
    EXPECT_EQ(builder.Statistics().refitCount, 5u);
}

TEST_F(RefitScratch, IsThatOfTheLargestRebuildUntilNoDeformingOneIsLeft) {
    BlasBuilder builder(*device, {.name = "scratch"});
    std::vector<std::shared_ptr<Blas>> blases = AddTriangles(builder, 8);
    const uint64_t built = UsedBytes();
    builder.Trim();
    EXPECT_EQ(UsedBytes(), built) << "they may be refitted";
    blases.clear();
    const uint64_t withScratch = UsedBytes();
    builder.Trim();
    const uint64_t scratch = withScratch - UsedBytes();
    EXPECT_GE(scratch, kBuildScratch);
    EXPECT_LT(scratch, 2 * kBuildScratch);
    blases = AddTriangles(builder, 1);
    const BlasBuilder::RefitRequest request{.blas = blases[0].get(), .desc = {}, .rebuilds = true};
    Run([&](CommandList& commands) { builder.RecordRefits(commands, {&request, 1}); });
    EXPECT_EQ(builder.Statistics().rebuildCount, 1u);
}

// The vertices have moved within the buffer of the build.
TEST_F(BlasRebuild, RefitsWithoutADescriptionReadTheBuffersOfTheBuild) {
    BlasBuilder builder(Device(), {.name = "same buffers"});
    TestMesh mesh = Quad(0, 0);
    BlasDesc desc = Describe(mesh, BlasKind::Deforming);
    const Buffer vertices = Upload("vertices", mesh.vertices, BufferUsage::BuildInput);
    desc.triangles[0].vertices = vertices.Address();
    const std::shared_ptr<Blas> blas = builder.Add(desc);
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    mesh = Quad(0, 2);
    std::memcpy(vertices.Mapped().data(), mesh.vertices.data(),
                mesh.vertices.size() * sizeof(mesh.vertices[0]));
    const BlasBuilder::RefitRequest request{.blas = blas.get()};
    Run([&](CommandList& commands) { builder.RecordRefits(commands, {&request, 1}); });
    EXPECT_FLOAT_EQ(
        Trace(PlainPipeline(), BuildTlas({Instance(*blas)}), {{.origin = {0.1f, 0.2f, -4}}})[0].distance,
        6.0f);
}

}  // namespace
}  // namespace raygraph::rhi::blas_rebuild_test
