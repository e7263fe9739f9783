// Fixture for tests that trace a handful of rays and read back what each of them found.
#pragma once

#include <cstring>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rhi/blas_builder.h"
#include "rhi/command_list.h"
#include "rhi/pipeline.h"
#include "rhi/tlas.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::rhi {

// The ray types of these tests have the names kRayTypeRadiance and kRayTypeShadow in GLSL.
enum RayType : uint32_t { Radiance, Shadow };
inline constexpr uint32_t kRayTypeCount = 2;

// Has the layout that the ray-generation shader below reads (scalar).
struct TestRay {
    std::array<float, 3> origin{};
    RayType type = RayType::Radiance;
    std::array<float, 3> direction{0, 0, 1};
    uint32_t value = 0;  // free for a test's own ray-generation shader
};

// Holds the payload when the ray was done; untouched components are kUntouched.
struct TestResult {
    uint32_t code = 0;
    uint32_t instance = 0;
    uint32_t primitive = 0;
    float distance = 0;

    bool operator==(const TestResult&) const = default;
};

inline constexpr uint32_t kUntouched = 0xffffffffu;

struct TestMesh {
    std::vector<std::array<float, 3>> vertices;
    std::vector<uint32_t> indices;
};

// Makes two triangles facing -z that cover [x - size, x + size] x [-size, size] at depth z.
TestMesh Quad(float x, float z, float size = 1.0f);
// Makes a surface of 2 * side * side triangles over [-1, 1]^2 with waves in z around 0.
TestMesh Waves(uint32_t side, float amplitude = 0.2f);

class TraceTest : public testing::VulkanTest {
  public:
    static void TearDownTestSuite();

  protected:
    // Compiles GLSL below a common head: #version, ray tracing, includes, ray types,
    //     struct Payload { uint code, instance, primitive; float distance; };
    // and `payload`, of ray generation, hits and misses. Ray generation also has `tlas` at binding 0, `rays` at
    // 1 and `results` at 2.
    ShaderStage Compile(const std::string& name, const std::string& body);
    // Traces rays[i] by its type and writes the payload to results[i].
    ShaderStage RayGen();
    // Returns a shader that sets the payload's code.
    ShaderStage Miss(const std::string& name, uint32_t code);
    // Returns a shader that sets code, instance (custom index), primitive and distance.
    ShaderStage ClosestHit(const std::string& name, uint32_t code);

    template <typename T>
    Buffer Upload(const std::string& name, const std::vector<T>& data, BufferUsage usage) {
        Buffer buffer = Device().CreateBuffer(
            {.name = name, .size = data.size() * sizeof(T), .usage = usage, .memory = MemoryKind::Upload});
        std::memcpy(buffer.Mapped().data(), data.data(), data.size() * sizeof(T));
        return buffer;
    }
    // Describes a BLAS over buffers that live as long as the test.
    TriangleGeometry Geometry(const TestMesh& mesh, bool isOpaque = true);
    BlasDesc Describe(const TestMesh& mesh, BlasKind kind = BlasKind::Static, bool isOpaque = true);

    // Records, submits and waits.
    void Run(const std::function<void(CommandList&)>& record);
    std::shared_ptr<Blas> Build(const BlasDesc& desc);
    Tlas BuildTlas(const std::vector<TlasInstance>& instances, bool allowsUpdate = true);
    Buffer Instances(const std::vector<TlasInstance>& instances);
    static TlasInstance Instance(const Blas& blas, float x = 0.0f, float z = 0.0f);

    std::vector<TestResult> Trace(const RayTracingPipeline& pipeline, const Tlas& tlas,
                                  const std::vector<TestRay>& rays);
    // Returns a pipeline whose radiance and shadow rays set code 1 (hit) or 2 (miss).
    const RayTracingPipeline& PlainPipeline();  // made once per suite
    // Returns side * side radiance rays along +z over [-1.1, 1.1]^2, from z = -4.
    static std::vector<TestRay> RayGrid(uint32_t side);

  private:
    std::deque<std::vector<uint32_t>> m_words;
    std::deque<Buffer> m_buffers;
    BlasBuilder& Builder();
    static std::unique_ptr<RayTracingPipeline> s_plain;
    std::unique_ptr<BlasBuilder> m_builder;
};

}  // namespace raygraph::rhi
