#include <gmock/gmock.h>
#include <cmath>
#include <nlohmann/json.hpp>

#include "renderer/graph/pass_harness.h"
#include "rhi/blas_builder.h"
#include "rhi/texture_table.h"
#include "rhi/tlas.h"
#include "rhi/transfer.h"
#include "tests/graph/graph_test.h"
#include "tests/support/error_of.h"

// The plan of hand-made frames, as text: order, culling, barriers, lifetimes.
namespace raygraph::plan_test {
namespace {

TEST(Plan, ThreePassFrame_ReadsAsWritten) {
    GraphMaker graph;
    const TlasId tlas = graph.Imported<ResourceKind::Tlas>("sceneTlas");
    const TextureId accumulated = graph.Persistent("accumulated");
    TextureId radiance = graph.Texture("radiance", 2);
    graph.AddPass("Trace", PassKind::RayTracing);
    graph.Use(tlas, Access::TraceStructure);
    radiance = graph.Use(radiance, Access::StorageWrite);
    graph.AddPass("Accumulate", PassKind::Compute);
    graph.Use(radiance, Access::StorageRead);
    const TextureId mean = graph.Use(accumulated, Access::StorageUpdate);
    TextureId shown = graph.Texture("display", 1);
    graph.AddPass("Tonemap", PassKind::Compute);
    graph.Use(mean, Access::StorageRead);
    shown = graph.Use(shown, Access::StorageWrite);
    graph.Present(shown);

    EXPECT_EQ(graph.Text(), R"(3 passes, 6 barriers, 2 MiB of transient memory (1 MiB saved by sharing)

1 Trace (ray tracing)
    reads   sceneTlas v0 (traced)
    writes  radiance v1 (storage write)
    waits   radiance: first use -> RayTracingShader write, Undefined -> General

2 Accumulate (compute)
    reads   radiance v1 (storage read)
    updates accumulated v1 (storage update)
    waits   radiance: RayTracingShader write -> ComputeShader read, General
    waits   accumulated: first use -> ComputeShader read+write, Undefined -> General

3 Tonemap (compute)
    reads   accumulated v1 (storage read)
    writes  display v1 (storage write)
    waits   accumulated: ComputeShader write -> ComputeShader read, General
    waits   display: memory of radiance, ComputeShader done -> ComputeShader write, Undefined -> General

end
    shows   display v1
    waits   display: ComputeShader write -> FragmentShader read, General -> ShaderReadOnly

resources
    sceneTlas    TLAS                        imported    pass 1
    accumulated  texture 64x64 rgba32f       persistent  passes 2-3
    radiance     texture 64x64 rgba32f       transient   passes 1-2
    display      texture 64x64 rgba32f       transient   passes 3-end

memory
    block 0, 2 MiB: radiance, then display
)");
}

TEST(Plan, EmptyFrame_HasNoPassAndNoBarrier) {
    const GraphMaker graph;
    EXPECT_EQ(graph.Text(), "0 passes, 0 barriers\n");
}

TEST(Plan, Order_IsThatOfDeclaration) {
    GraphMaker graph;
    const TextureId a = graph.Pass("A", {}, graph.Texture("a"));
    const TextureId b = graph.Pass("B", {}, graph.Texture("b"));
    graph.Present(graph.Pass("C", {b, a}, graph.Texture("c")));
    EXPECT_EQ(graph.Order(), "A B C");
}

TEST(Culling, PassThatLeadsNowhere_IsCulledWithItsInputs) {
    GraphMaker graph;
    const TextureId color = graph.Pass("RasterView", {}, graph.Texture("color"));
    [[maybe_unused]] const TextureId sharp = graph.Pass("Sharpen", {color}, graph.Texture("sharp"));
    graph.Present(graph.Pass("Trace", {}, graph.Texture("radiance")));
    const std::string text = graph.Text();
    EXPECT_EQ(graph.Order(), "Trace");
    EXPECT_NE(text.find("culled\n"
                        "    RasterView (compute): only culled Sharpen needs it\n"
                        "    Sharpen (compute): nothing needs sharp\n"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("color     texture 64x64 rgba32f       transient   unused\n"), std::string::npos)
        << text;
}

TEST(Culling, PassWithoutWrites_IsCulledUnlessKeptAlive) {
    GraphMaker graph;
    graph.AddPass("Count", PassKind::Compute);
    EXPECT_EQ(graph.Order(), "");
    EXPECT_NE(graph.Text().find("Count (compute): it writes nothing"), std::string::npos);
    graph.passes[0].keepAlive = true;
    EXPECT_EQ(graph.Order(), "Count");
}

TEST(Culling, KeepAlivePass_KeepsWhatItReads) {
    GraphMaker graph;
    const TextureId a = graph.Pass("Make", {}, graph.Texture("a"));
    graph.AddPass("Look", PassKind::Compute);
    graph.Use(a, Access::StorageRead);
    graph.passes[1].keepAlive = true;
    EXPECT_EQ(graph.Order(), "Make Look");
}

TEST(Culling, OverwrittenContents_DoNotKeepTheirPass) {
    GraphMaker graph;
    TextureId a = graph.Pass("First", {}, graph.Texture("a"));
    a = graph.Pass("Second", {}, a);
    graph.Present(a);
    EXPECT_EQ(graph.Order(), "Second");
}

TEST(Culling, UpdatedContents_KeepTheirPass) {
    GraphMaker graph;
    TextureId a = graph.Pass("First", {}, graph.Texture("a"));
    graph.AddPass("Second", PassKind::Compute);
    a = graph.Use(a, Access::StorageUpdate);
    graph.Present(a);
    EXPECT_EQ(graph.Order(), "First Second");
}

TEST(Culling, CopiesIntoPartsOfABuffer_AreAllKept) {
    GraphMaker graph;
    BufferId records = graph.Buffer("records");
    graph.AddPass("Upload head", PassKind::Transfer);
    records = graph.Use(records, Access::CopyWrite);
    graph.AddPass("Upload tail", PassKind::Transfer);
    records = graph.Use(records, Access::CopyWrite);
    graph.ReadOnHost(records);
    EXPECT_EQ(graph.Order(), "Upload head Upload tail");
}

TEST(Culling, ToggledView_StopsItsAccumulation) {
    const auto order = [](bool isPathTraced) {
        GraphMaker graph;
        const TextureId radiance = graph.Pass("Trace", {}, graph.Texture("radiance"));
        graph.AddPass("Accumulate", PassKind::Compute);
        graph.Use(radiance, Access::StorageRead);
        const TextureId mean = graph.Use(graph.Persistent("mean"), Access::StorageUpdate);
        const TextureId raster = graph.Pass("Raster", {}, graph.Texture("raster"));
        graph.Present(isPathTraced ? mean : raster);
        return graph.Order();
    };
    EXPECT_EQ(order(true), "Trace Accumulate");
    EXPECT_EQ(order(false), "Raster");
}

TEST(Culling, HistoryWrittenForTheNextFrame_IsKeptWhileItIsRead) {
    const auto order = [](bool isShown) {
        GraphMaker graph;
        const TextureId history = graph.Persistent("history");
        const TextureId blended = graph.Pass("Blend", {history}, graph.Texture("blended"));
        [[maybe_unused]] const TextureId next = graph.Pass("Keep history", {blended}, history);
        const TextureId other = graph.Pass("Other", {}, graph.Texture("other"));
        graph.Present(isShown ? blended : other);
        return graph.Order();
    };
    EXPECT_EQ(order(true), "Blend Keep history");
    EXPECT_EQ(order(false), "Other");
}

TEST(Culling, AlwaysPersistentResource_KeepsItsWriter) {
    GraphMaker graph;
    [[maybe_unused]] const TextureId map =
        graph.Pass("Light map", {}, graph.Persistent("lightMap", {}, Persistence::Always));
    EXPECT_EQ(graph.Order(), "Light map");
}

TEST(Culling, ExportedAndHostReadResources_KeepTheirWriters) {
    GraphMaker graph;
    const TextureId host = graph.Imported<ResourceKind::Texture>("host");
    graph.Export(graph.Pass("Fill", {}, host), VK_IMAGE_LAYOUT_GENERAL);
    BufferId histogram = graph.Buffer("histogram");
    graph.AddPass("Count", PassKind::Compute);
    histogram = graph.Use(histogram, Access::StorageWrite);
    graph.ReadOnHost(histogram);
    EXPECT_EQ(graph.Order(), "Fill Count");
    EXPECT_NE(graph.Text().find("waits   histogram: ComputeShader write -> Host read\n"), std::string::npos);
}

TEST(Plan, CulledPass_LeavesNoBarrierBehind) {
    GraphMaker graph;
    const TextureId shared = graph.Pass("Make", {}, graph.Texture("shared"));
    [[maybe_unused]] const TextureId unused =
        graph.Pass("Unused", {shared}, graph.Texture("unused"), PassKind::RayTracing);
    graph.Present(graph.Pass("Use", {shared}, graph.Texture("used")));
    EXPECT_EQ(graph.Text().find("RayTracingShader"), std::string::npos) << graph.Text();
}

TEST(PlanDot, ShowsPassesVersionsAndRoots) {
    GraphMaker graph;
    const TextureId a = graph.Pass("Make", {}, graph.Texture("a"));
    [[maybe_unused]] const TextureId b = graph.Pass("Un\"used", {a}, graph.Texture("b"));
    graph.Present(a);
    EXPECT_EQ(DescribePlanDot(graph, Compile(graph)), R"(digraph frame {
    rankdir=LR;
    node [fontname="sans-serif"];
    p0 [shape=box, style=solid, label="1 Make\ncompute"];
    p1 [shape=box, style=dashed, label="culled Un\"used\ncompute"];
    r0v1 [shape=ellipse, style=solid, label="a v1"];
    p0 -> r0v1;
    r0v1 -> p1 [style=dashed];
    r1v1 [shape=ellipse, style=solid, label="b v1"];
    p1 -> r1v1 [style=dashed];
    root0 [shape=plaintext, label="shown"];
    r0v1 -> root0;
}
)");
}

TEST(PlanJson, HasWhatAScriptNeedsToDrawThePlan) {
    GraphMaker graph;
    const TextureId a = graph.Pass("Make", {}, graph.Texture("a", 2));
    [[maybe_unused]] const TextureId b =
        graph.Pass("Un\"used", {a}, graph.Texture("b"), PassKind::RayTracing);
    const TextureId c = graph.Pass("Use", {a}, graph.Texture("c", 2));
    const TextureId d = graph.Pass("Again", {c}, graph.Texture("d", 1));
    graph.Present(d);
    const nlohmann::json plan = nlohmann::json::parse(DescribePlanJson(graph, Compile(graph)));
    std::vector<std::string> order;
    for (const nlohmann::json& pass : plan.at("passes")) order.push_back(pass.at("name"));
    EXPECT_EQ(order, (std::vector<std::string>{"Make", "Use", "Again"}));
    const nlohmann::json& use = plan["passes"][1];
    EXPECT_EQ(use.at("kind"), "compute");
    EXPECT_EQ(
        use.at("reads"),
        nlohmann::json::parse(R"([{"resource": 0, "name": "a", "version": 1, "access": "storage read"}])"));
    EXPECT_EQ(
        use.at("writes"),
        nlohmann::json::parse(R"([{"resource": 2, "name": "c", "version": 1, "access": "storage write"}])"));
    EXPECT_EQ(use.at("barriers")[0], nlohmann::json::parse(R"({"resource": 0, "name": "a",
        "from": {"stages": ["ComputeShader"], "access": "write", "layout": "General"},
        "to": {"stages": ["ComputeShader"], "access": "read", "layout": "General"}})"));
    EXPECT_EQ(plan.at("culled")[0].at("name"), "Un\"used");
    EXPECT_EQ(plan["culled"][0].at("why"), "nothing needs b");
    EXPECT_EQ(plan.at("end").at("roots")[0],
              nlohmann::json::parse(R"({"resource": 3, "name": "d", "version": 1, "kind": "presented"})"));

    const nlohmann::json& resources = plan.at("resources");
    ASSERT_EQ(resources.size(), 4u);
    EXPECT_EQ(resources[1], nlohmann::json::parse(R"({"name": "b", "kind": "texture", "origin": "transient",
        "width": 64, "height": 64, "format": "rgba32f", "levels": 1, "layers": 1,
        "first_pass": null, "last_pass": null, "block": null})"));
    EXPECT_EQ(resources[2].at("first_pass"), 1);
    EXPECT_EQ(resources[2].at("last_pass"), 2);
    EXPECT_EQ(resources[3].at("last_pass"), 3) << "shown: until the end";
    // d takes over the memory of a
    EXPECT_EQ(plan.at("memory").at("bytes"), 4 << 20);
    EXPECT_EQ(plan["memory"].at("bytes_without_sharing"), 5 << 20);
    ASSERT_EQ(plan["memory"].at("blocks").size(), 2u);
    EXPECT_EQ(plan["memory"]["blocks"][resources[0].at("block").get<size_t>()],
              nlohmann::json::parse(R"({"bytes": 2097152, "resources": [0, 3]})"));
    EXPECT_EQ(plan["passes"][2]["barriers"][1].value("memory_of", -1), 0) << plan["passes"][2]["barriers"];
}

TEST(PlanJson, NamesThePartOfATexture) {
    GraphMaker graph;
    TextureId chain = graph.Chain("chain", 2);
    for (const uint32_t level : {0u, 1u}) {
        graph.AddPass("Fill", PassKind::Compute);
        chain = graph.Use(chain, Access::StorageWrite, Level(level));
    }
    graph.Present(chain);
    const nlohmann::json plan = nlohmann::json::parse(DescribePlanJson(graph, Compile(graph)));
    EXPECT_EQ(plan.at("passes")[1].at("writes")[0], nlohmann::json::parse(R"({"resource": 0, "name": "chain",
        "first_level": 1, "levels": 1, "first_layer": 0, "layers": 1,
        "version": 2, "access": "storage write"})"));
}

}  // namespace
}  // namespace raygraph::plan_test

// Acceleration structures in the graph: built by passes, traced by passes, replaced while frames are in
// flight.
namespace raygraph::structure_test {
namespace {

using ::testing::HasSubstr;

constexpr Extent2D kExtent{16, 8};

// One triangle in front of the left half of the picture; hits give 1, misses 0.
class Structures : public GraphTest {
  protected:
    Structures() : m_builder(Device()), m_tlas(Device(), {.name = "tlas", .capacity = 1}) {
        m_renderer.AddShader("test/hits.rgen", CompileText("test/hits.rgen", R"(
#extension GL_EXT_ray_tracing : require
layout(binding = 0) uniform accelerationStructureEXT sceneTlas;
layout(binding = 1, r32f) uniform writeonly image2D result;
layout(location = 0) rayPayloadEXT float hit;
void main() {
    vec2 pixel = (vec2(gl_LaunchIDEXT.xy) + 0.5) / vec2(gl_LaunchSizeEXT.xy);
    hit = -1.0;
    traceRayEXT(sceneTlas, gl_RayFlagsOpaqueEXT, 0xff, 0, 2, 0, vec3(pixel, 1.0), 0.0, vec3(0.0, 0.0, -1.0), 10.0, 0);
    imageStore(result, ivec2(gl_LaunchIDEXT.xy), vec4(hit));
})"));
        const std::string payload =
            "#extension GL_EXT_ray_tracing : require\nlayout(location = 0) rayPayloadInEXT float hit;\n";
        m_renderer.AddShader("test/hit.rchit",
                             CompileText("test/hit.rchit", payload + "void main() { hit = 1.0; }"));
        m_renderer.AddShader("test/miss.rmiss",
                             CompileText("test/miss.rmiss", payload + "void main() { hit = 0.0; }"));

        const std::vector<float> positions{-1, -3, 0, 0.5f, -3, 0, 0.5f, 9, 0};
        const std::vector<uint32_t> indices{0, 1, 2};
        m_geometry = Device().CreateBuffer(
            {.name = "geometry",
             .size = 48,
             .usage = rhi::BufferUsage::BuildInput | rhi::BufferUsage::CopyDestination});
        rhi::Uploader uploader(Device());
        uploader.UploadBuffer(m_geometry, 0, testing::BytesOf(positions));
        uploader.UploadBuffer(m_geometry, 36, testing::BytesOf(indices));
        uploader.Flush();
        rhi::BlasDesc desc;
        desc.triangles.push_back({.vertices = m_geometry.Address(),
                                  .vertexCount = 3,
                                  .indices = m_geometry.Address() + 36,
                                  .triangleCount = 1});
        m_blas = m_builder.Add(desc);
    }

    // One frame: builds what is asked for and traces.
    Readback Frame(bool buildsBlas, bool buildsTlas, float offset) {
        m_renderer.BeginFrame();
        BlasSetId blases = m_renderer.ImportBlasSet("blases", m_blasState);
        TlasId tlas = m_renderer.Import("tlas", m_tlas, m_tlasState);
        const BufferId instances = m_renderer.CreateBuffer(
            "instances", {.size = rhi::kTlasInstanceBytes, .memory = rhi::MemoryKind::Upload});
        if (buildsBlas)
            m_renderer.AddPass(
                "Build BLAS", PassKind::AccelerationStructure,
                [&](PassBuilder& pass) { blases = pass.Builds(blases); },
                [this](CommandList& commands) { m_builder.RecordBuilds(commands); });
        if (buildsTlas)
            m_renderer.AddPass(
                "Build TLAS", PassKind::AccelerationStructure,
                [&](PassBuilder& pass) {
                    pass.BuildsFrom(blases);
                    pass.BuildsFrom(instances);
                    tlas = pass.Builds(tlas);
                },
                [this, instances, offset](CommandList& commands, const PassResources& resources) {
                    rhi::TlasInstance instance;
                    instance.objectToWorld[3] = offset;
                    instance.blas = m_blas->Address();
                    rhi::WriteInstances(std::span(&instance, 1), resources.Buffer(instances).Mapped());
                    m_tlas.Build(commands, resources.Buffer(instances), 1);
                });
        TextureId result =
            m_renderer.CreateTexture("result", {.extent = kExtent, .format = Format::R32Float});
        m_renderer.AddPass(
            "Trace", PassKind::RayTracing,
            [&](PassBuilder& pass) {
                pass.RayGen("test/hits.rgen").Miss(RayType::Radiance, "test/miss.rmiss");
                pass.HitGroup(RayType::Radiance, {.closestHit = "test/hit.rchit"});
                pass.Reads("sceneTlas", tlas);
                pass.ReadsByAddress(blases);
                result = pass.Writes("result", result);
            },
            [](CommandList& commands) { commands.TraceRays(kExtent); });
        const Readback readback = m_renderer.ReadBack(result);
        m_renderer.Execute();
        return readback;
    }
    static float Sum(const Readback& readback) {
        float sum = 0.0f;
        for (const float value : Read(readback).values) sum += value;
        return sum;
    }

    rhi::BlasBuilder m_builder;
    rhi::Tlas m_tlas;
    rhi::Buffer m_geometry;
    std::shared_ptr<rhi::Blas> m_blas;
    ResourceState m_blasState, m_tlasState;
};

TEST_F(Structures, BuiltAndTracedInOneFrame_AreHitWhereTheyAre) {
    const testing::Texels texels = Read(Frame(true, true, 0.0f));
    EXPECT_EQ(texels.At(0, 0)[0], 1.0f);
    EXPECT_EQ(texels.At(kExtent.width / 2 - 1, 4)[0], 1.0f);
    EXPECT_EQ(texels.At(kExtent.width / 2, 4)[0], 0.0f);
    const std::string plan = m_renderer.DescribePlan();
    EXPECT_THAT(plan, HasSubstr("tlas: StructureBuild write -> RayTracingShader read\n"));
    EXPECT_THAT(plan, HasSubstr("blases: StructureBuild write -> StructureBuild read\n"));
}

TEST_F(Structures, HostsTlas_IsTracedAndStaysTheHosts) {
    Frame(true, true, 0.0f);
    rhi::Tlas owner = std::exchange(m_tlas, Device().WrapTlas("the host's", m_tlas.Handle()));
    EXPECT_EQ(m_tlas.Handle(), owner.Handle());
    EXPECT_EQ(m_tlas.Address(), owner.Address());
    EXPECT_GT(Sum(Frame(false, false, 0.0f)), 0.0f);

    const rhi::Buffer instances =
        Device().CreateBuffer({.name = "i", .size = 64, .usage = rhi::BufferUsage::BuildInput});
    rhi::CommandList commands = Device().BeginCommands("build");
    EXPECT_EQ(testing::ErrorTextOf([&] { m_tlas.Build(commands, instances, 0); }),
              "TLAS 'the host's': it is the host's to build");
    m_tlas = {};
    m_tlas = std::move(owner);
    EXPECT_GT(Sum(Frame(false, false, 0.0f)), 0.0f) << "it is still there";
}

TEST_F(Structures, NextFrame_NeedsNoBarrierToTraceThemAgain) {
    Frame(true, true, 0.0f);
    Frame(false, false, 0.0f);
    EXPECT_THAT(m_renderer.DescribePlan(), ::testing::Not(HasSubstr("waits   tlas")));
}

TEST_F(Structures, RebuiltWhileFramesAreInFlight_HitWhereTheyWereThen) {
    Frame(true, true, 0.0f);
    std::vector<Readback> frames;
    for (int i = 0; i < 6; ++i) frames.push_back(Frame(false, true, i % 2 == 0 ? 0.5f : 0.0f));
    for (size_t i = 0; i < frames.size(); ++i) {
        const testing::Texels texels = Read(frames[i]);
        EXPECT_EQ(texels.At(kExtent.width - 1, 4)[0], i % 2 == 0 ? 1.0f : 0.0f) << "frame " << i;
    }
}

TEST_F(Structures, RecursionBeyondTheDevice_NamesBoth) {
    const rhi::DeviceInfo& device = Device().Info();
    const auto message = [&](PassKind kind, uint32_t depth) {
        m_renderer.BeginFrame();
        return testing::ErrorTextOf([&] {
            m_renderer.AddPass(
                "Deep", kind,
                [&](PassBuilder& pass) {
                    if (kind == PassKind::Compute)
                        pass.Compute("test/fill.comp");
                    else
                        pass.RayGen("test/hits.rgen");
                    pass.MaxRecursion(depth);
                },
                [](CommandList&) {});
        });
    };
    const uint32_t most = device.maxRayRecursionDepth;
    EXPECT_EQ(message(PassKind::RayTracing, most + 1), "pass \"Deep\" asks for a ray recursion of " +
                                                           std::to_string(most + 1) + "; the device " +
                                                           device.name + " allows " + std::to_string(most));
    EXPECT_EQ(message(PassKind::RayTracing, 0),
              "pass \"Deep\" asks for a ray recursion of 0; ray generation itself traces at 1");
    EXPECT_THAT(message(PassKind::RayTracing, most), HasSubstr("does not bind what its shaders use"))
        << "the limit itself is not refused";
    if (most > 1) {
        EXPECT_EQ(message(PassKind::Compute, 2),
                  "pass \"Deep\" is of kind compute and cannot have a ray recursion (MaxRecursion)");
    }
}

TEST_F(Structures, BindlessTextures_AreSampledThroughSetOne) {
    m_renderer.AddShader("test/bindless.comp", CompileText("test/bindless.comp", R"(
#extension GL_EXT_nonuniform_qualifier : enable
layout(local_size_x = 1) in;
layout(set = 1, binding = 0) uniform sampler2D textures[];
layout(binding = 0, r32f) uniform writeonly image2D target;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(target, texel, textureLod(textures[nonuniformEXT(texel.x)], vec2(0.5), 0.0));
})"));
    rhi::Uploader uploader(Device());
    const rhi::Sampler sampler = Device().CreateSampler({});
    const auto make = [&](float value) {
        rhi::Texture texture =
            Device().CreateTexture({.name = "value", .extent = {1, 1}, .format = Format::R32Float});
        uploader.UploadTexture(texture, testing::BytesOf(std::vector<float>{value}));
        return texture;
    };
    const rhi::Texture standIn = make(-1.0f);
    const rhi::Texture first = make(3.0f);
    const rhi::Texture second = make(5.0f);
    uploader.Flush();
    rhi::TextureTable table(Device(), 4, standIn, sampler);
    const uint32_t slots[] = {table.Add(first, sampler), table.Add(second, sampler)};

    m_renderer.BeginFrame();
    TextureId target = m_renderer.CreateTexture("target", {.extent = {4, 1}, .format = Format::R32Float});
    m_renderer.AddPass(
        "Look up", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("test/bindless.comp");
            pass.Uses(m_renderer.Import("textures", table));
            target = pass.Writes("target", target);
        },
        [](CommandList& commands) {
            commands.DispatchOver({4, 1});
        });
    const Readback readback = m_renderer.ReadBack(target);
    m_renderer.Execute();
    const testing::Texels texels = Read(readback);
    EXPECT_EQ(texels.At(slots[0], 0)[0], 3.0f);
    EXPECT_EQ(texels.At(slots[1], 0)[0], 5.0f);
    EXPECT_EQ(texels.At(3, 0)[0], -1.0f);
}

}  // namespace
}  // namespace raygraph::structure_test

// The harness itself: texels in and out of every format, one pass alone, state from run to run.
namespace raygraph::testing::pass_harness_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Texels, EveryFormat_KeepsWhatItCanHold) {
    for (uint32_t f = 1; f < rhi::kFormatCount; ++f) {
        const auto format = static_cast<rhi::Format>(f);
        if (rhi::BlockSide(format) > 1) {
            EXPECT_EQ(ChannelCount(format), 0u) << rhi::Name(format);
            continue;
        }
        std::vector<float> values(size_t{6} * ChannelCount(format));
        for (size_t i = 0; i < values.size(); ++i) values[i] = i % 3 == 0 ? 1.0f : 0.0f;
        const Extent2D extent{3, 2};
        const std::vector<std::byte> bytes = EncodeTexels(values, extent, format);
        EXPECT_EQ(bytes.size(), 6 * rhi::TexelBytes(format));
        EXPECT_EQ(DecodeTexels(bytes, extent, format).values, values) << rhi::Name(format);
    }
}

TEST(Texels, Halves_RoundToNearestEven) {
    const auto roundTrip = [](float value) {
        return DecodeTexels(EncodeTexels(std::span(&value, 1), {1, 1}, rhi::Format::R16Float), {1, 1},
                            rhi::Format::R16Float)
            .values[0];
    };
    for (const float exact : {0.0f, 1.0f, -2.5f, 65504.0f, 0x1p-14f, 0x1p-24f, 0x3ffp-24f, 1.0009765625f})
        EXPECT_EQ(roundTrip(exact), exact);
    EXPECT_EQ(roundTrip(1.0f + 0x1p-11f), 1.0f) << "half way: to even";
    EXPECT_EQ(roundTrip(1.0f + 0x3p-11f), 1.0f + 0x2p-10f) << "half way: to even";
    EXPECT_EQ(roundTrip(2047.6f), 2048.0f) << "carries into the exponent";
    EXPECT_EQ(roundTrip(0x1p-26f), 0.0f);
    EXPECT_TRUE(std::isinf(roundTrip(70000.0f)));
    EXPECT_TRUE(std::isnan(roundTrip(NAN)));
    EXPECT_TRUE(std::signbit(roundTrip(-0.0f)));
}

TEST(Texels, SizesThatDisagree_AreRefused) {
    EXPECT_THROW(EncodeTexels(std::vector<float>(3), {2, 2}, rhi::Format::R32Float), Error);
    EXPECT_THROW(DecodeTexels(std::vector<std::byte>(3), {2, 2}, rhi::Format::R32Float), Error);
    const Texels texels{.extent = {2, 2}, .channelCount = 1, .values = std::vector<float>(4)};
    EXPECT_THROW(std::ignore = texels.At(2, 0), Error);
}

class Harness : public GraphTest {};

TEST_F(Harness, OnePassAlone_FromValuesToTexels) {
    PassHarness harness(Device());
    AddTestShaders(harness.Graph());
    const Texels texels = harness.Run([](PassHarness& h) {
        const TextureId source = h.Texture("source", {2, 2}, Format::R32Float, {1, 2, 3, 4});
        return Scale(h.Graph(), "scaled", source, 10.0f);
    });
    EXPECT_THAT(texels.values, ElementsAre(10, 20, 30, 40));
    EXPECT_THAT(harness.Plan(), HasSubstr("Scale scaled (compute)"));
}

TEST_F(Harness, SingleTexel_FillsTheTexture) {
    PassHarness harness(Device());
    const Texels texels = harness.Run([](PassHarness& h) {
        return h.Texture("gray", {3, 1}, Format::Rgba8Unorm, {1, 0, 1, 0});
    });
    EXPECT_THAT(texels.values, ElementsAre(1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0));
}

TEST_F(Harness, Buffers_GoInAndOut) {
    PassHarness harness(Device());
    const std::vector<uint32_t> words{1, 2, 3};
    EXPECT_EQ(harness.RunBuffer<uint32_t>([&](PassHarness& h) { return h.Buffer("words", words); }), words);
}

TEST_F(Harness, PersistentTextures_GoOnFromRunToRun) {
    PassHarness harness(Device());
    AddTestShaders(harness.Graph());
    Texels texels;
    for (int run = 0; run < 3; ++run)
        texels = harness.Run([](PassHarness& h) {
            return AddTo(h.Graph(), "sum", h.Texture("one", {2, 1}, Format::R32Float, {1, 2}));
        });
    EXPECT_THAT(texels.values, ElementsAre(3, 6));
}

TEST_F(Harness, RunAfterAnError_StartsClean) {
    PassHarness harness(Device());
    EXPECT_THROW(harness.Run([](PassHarness&) { return TextureId{}; }), Error);
    EXPECT_THAT(harness.Run([](PassHarness& h) {
                           return h.Texture("a", {1, 1}, Format::R32Float, {4});
                       })
                    .values,
                ElementsAre(4));
}

}  // namespace
}  // namespace raygraph::testing::pass_harness_test
