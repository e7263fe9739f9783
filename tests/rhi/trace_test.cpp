#include "tests/rhi/trace_test.h"

#include <cmath>

#include "base/text.h"
#include "rhi/device.h"
#include "rhi/shader_compiler.h"
#include "tests/support/source_file.h"

namespace raygraph::rhi {
namespace {

constexpr const char* kHead = R"(#version 460
#extension GL_EXT_ray_tracing : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
const uint kRayTypeRadiance = 0, kRayTypeShadow = 1;
struct Payload { uint code; uint instance; uint primitive; float distance; };
)";

constexpr const char* kRayGenHead = R"(
struct Ray { vec3 origin; uint type; vec3 direction; uint value; };
layout(binding = 0) uniform accelerationStructureEXT tlas;
layout(binding = 1, scalar) readonly buffer Rays { Ray rays[]; };
layout(binding = 2, scalar) writeonly buffer Results { Payload results[]; };
layout(location = 0) rayPayloadEXT Payload payload;
)";
constexpr const char* kHitHead = "layout(location = 0) rayPayloadInEXT Payload payload;\n";

constexpr const char* kRayGen = R"(
void main() {
    Ray ray = rays[gl_LaunchIDEXT.x];
    payload = Payload(~0u, ~0u, ~0u, -1.0);
    traceRayEXT(tlas, gl_RayFlagsNoneEXT, 0xff, ray.type, 0, ray.type, ray.origin, 0.0, ray.direction,
                1e9, 0);
    results[gl_LaunchIDEXT.x] = payload;
}
)";

}  // namespace

TestMesh Quad(float x, float z, float size) {
    return {{{x - size, -size, z}, {x - size, size, z}, {x + size, size, z}, {x + size, -size, z}},
            {0, 1, 2, 0, 2, 3}};
}

TestMesh Waves(uint32_t side, float amplitude) {
    TestMesh mesh;
    for (uint32_t j = 0; j <= side; ++j)
        for (uint32_t i = 0; i <= side; ++i) {
            const float x = 2.0f * static_cast<float>(i) / static_cast<float>(side) - 1.0f;
            const float y = 2.0f * static_cast<float>(j) / static_cast<float>(side) - 1.0f;
            mesh.vertices.push_back({x, y, amplitude * std::sin(7.0f * x) * std::cos(5.0f * y)});
        }
    for (uint32_t j = 0; j < side; ++j)
        for (uint32_t i = 0; i < side; ++i) {
            const uint32_t a = j * (side + 1) + i;
            const uint32_t b = a + side + 1;
            mesh.indices.insert(mesh.indices.end(), {a, b, b + 1, a, b + 1, a + 1});
        }
    return mesh;
}

ShaderStage TraceTest::Compile(const std::string& name, const std::string& body) {
    std::string text = kHead;
    if (name.ends_with(".rgen")) text += kRayGenHead;
    if (name.ends_with(".rmiss") || name.ends_with(".rchit") || name.ends_with(".rahit")) text += kHitHead;
    m_words.push_back(CompileGlsl(
        {.name = name, .text = text + body, .stage = {}, .includeRoot = test::SourceFile("shaders")}));
    return {name, m_words.back()};
}

ShaderStage TraceTest::RayGen() {
    return Compile("trace.rgen", kRayGen);
}

ShaderStage TraceTest::Miss(const std::string& name, uint32_t code) {
    return Compile(name + ".rmiss", Text("void main() {{ payload.code = {}; }}", code));
}

ShaderStage TraceTest::ClosestHit(const std::string& name, uint32_t code) {
    return Compile(
        name + ".rchit",
        Text(
            "void main() {{ payload = Payload({}, gl_InstanceCustomIndexEXT, gl_PrimitiveID, gl_HitTEXT); }}",
            code));
}

TriangleGeometry TraceTest::Geometry(const TestMesh& mesh, bool isOpaque) {
    const Buffer& vertices =
        m_buffers.emplace_back(Upload("vertices", mesh.vertices, BufferUsage::BuildInput));
    const VkDeviceAddress vertexAddress = vertices.Address();
    const Buffer& indices = m_buffers.emplace_back(Upload("indices", mesh.indices, BufferUsage::BuildInput));
    return {.vertices = vertexAddress,
            .vertexStride = 12,
            .vertexCount = static_cast<uint32_t>(mesh.vertices.size()),
            .indices = indices.Address(),
            .triangleCount = static_cast<uint32_t>(mesh.indices.size() / 3),
            .isOpaque = isOpaque};
}

BlasDesc TraceTest::Describe(const TestMesh& mesh, BlasKind kind, bool isOpaque) {
    return {.name = "mesh", .kind = kind, .triangles = {Geometry(mesh, isOpaque)}};
}

void TraceTest::Run(const std::function<void(CommandList&)>& record) {
    CommandList commands = Device().BeginCommands("test");
    record(commands);
    Device().WaitFor(Device().Submit(std::move(commands)));
}

BlasBuilder& TraceTest::Builder() {
    if (!m_builder)
        m_builder =
            std::make_unique<BlasBuilder>(Device(), BlasBuilderDesc{.name = "test", .compacts = false});
    return *m_builder;
}

std::shared_ptr<Blas> TraceTest::Build(const BlasDesc& desc) {
    std::shared_ptr<Blas> blas = Builder().Add(desc);
    Run([&](CommandList& commands) { Builder().RecordBuilds(commands); });
    return blas;
}

Buffer TraceTest::Instances(const std::vector<TlasInstance>& instances) {
    Buffer buffer =
        Device().CreateBuffer({.name = "instances",
                               .size = std::max<uint64_t>(1, instances.size()) * kTlasInstanceBytes,
                               .usage = BufferUsage::BuildInput,
                               .memory = MemoryKind::Upload});
    WriteInstances(instances, buffer.Mapped());
    return buffer;
}

Tlas TraceTest::BuildTlas(const std::vector<TlasInstance>& instances, bool allowsUpdate) {
    const uint32_t count = static_cast<uint32_t>(instances.size());
    Tlas tlas(Device(), {.name = "tlas", .capacity = count, .allowsUpdate = allowsUpdate});
    const Buffer buffer = Instances(instances);
    Run([&](CommandList& commands) { tlas.Build(commands, buffer, count); });
    return tlas;
}

TlasInstance TraceTest::Instance(const Blas& blas, float x, float z) {
    TlasInstance instance;
    instance.objectToWorld[3] = x;
    instance.objectToWorld[11] = z;
    instance.blas = blas.Address();
    return instance;
}

std::vector<TestResult> TraceTest::Trace(const RayTracingPipeline& pipeline, const Tlas& tlas,
                                         const std::vector<TestRay>& rays) {
    static_assert(sizeof(TestRay) == 32 && sizeof(TestResult) == 16);
    const Buffer rayBuffer = Upload("rays", rays, BufferUsage::Storage);
    const Buffer results = Device().CreateBuffer({.name = "results",
                                                  .size = rays.size() * sizeof(TestResult),
                                                  .usage = BufferUsage::Storage,
                                                  .memory = MemoryKind::Readback});
    Run([&](CommandList& commands) {
        VkMemoryBarrier2 barrier{};
        barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2;
        barrier.srcStageMask = VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
        barrier.srcAccessMask = VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
        barrier.dstStageMask = VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR;
        barrier.dstAccessMask = VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR;
        commands.Barriers({&barrier, 1}, {});
        commands.Bind(pipeline);
        const BoundResource resources[] = {
            {.binding = 0,
             .type = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR,
             .accelerationStructure = tlas.Handle()},
            {.binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .buffer = &rayBuffer},
            {.binding = 2, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .buffer = &results},
        };
        commands.BindResources(resources);
        commands.TraceRays({static_cast<uint32_t>(rays.size()), 1});
        barrier.srcStageMask = VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR;
        barrier.srcAccessMask = VK_ACCESS_2_SHADER_WRITE_BIT;
        barrier.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
        barrier.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
        commands.Barriers({&barrier, 1}, {});
    });
    std::vector<TestResult> out(rays.size());
    std::memcpy(out.data(), results.Mapped().data(), out.size() * sizeof(TestResult));
    return out;
}

std::unique_ptr<RayTracingPipeline> TraceTest::s_plain;

void TraceTest::TearDownTestSuite() {
    s_plain.reset();
}

const RayTracingPipeline& TraceTest::PlainPipeline() {
    if (s_plain) return *s_plain;
    const ShaderStage miss = Miss("plain", 2);
    const ShaderStage hit = ClosestHit("plain", 1);
    const HitGroupSet set(kRayTypeCount, {.closestHit = hit});
    s_plain = std::make_unique<RayTracingPipeline>(CreateRayTracingPipeline(
        Device(),
        {.name = "plain", .rayGen = {RayGen(), {}}, .miss = {{miss, {}}, {miss, {}}}, .hitSets = {set}}));
    return *s_plain;
}

std::vector<TestRay> TraceTest::RayGrid(uint32_t side) {
    std::vector<TestRay> rays;
    for (uint32_t j = 0; j < side; ++j)
        for (uint32_t i = 0; i < side; ++i) {
            auto at = [&](uint32_t k) {
                return 2.2f * (static_cast<float>(k) + 0.5f) / static_cast<float>(side) - 1.1f;
            };
            rays.push_back({.origin = {at(i), at(j), -4.0f}});
        }
    return rays;
}

}  // namespace raygraph::rhi
