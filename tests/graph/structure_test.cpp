// Acceleration structures in the graph: built by passes, traced by passes, replaced while frames are in
// flight.
#include <gmock/gmock.h>

#include "rhi/blas_builder.h"
#include "rhi/texture_table.h"
#include "rhi/tlas.h"
#include "rhi/upload.h"
#include "tests/graph/graph_test.h"
#include "tests/support/error_of.h"

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
