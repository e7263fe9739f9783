// Both ways of tracing a buffer of rays, the driver's and the wide trees', against all triangles one after the
// other in double precision; and which is taken on a device.
#include "renderer/bvh/traversal.h"

#include "renderer/bvh/traversal_scene.h"
#include "renderer/graph/readback_values.h"
#include "tests/support/exact_trace.h"
#include "tests/support/triangle_soup.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::traversal_test {
namespace {

class TraversalTest : public VulkanTest {
  protected:
    TraversalTest() {
        for (uint32_t i = 0; i < m_rays.size(); i += 2) m_rays[i].tMax = 1.0f;
        m_buffer = UploadRecords(Device(), "rays", std::as_bytes(std::span(m_rays)), m_state);
        for (const gpu::BenchRay& ray : m_rays) m_exact.push_back(TraceExactly(m_scene, ray));
    }

    template <typename Declare>
    std::vector<gpu::WideHit> Run(Declare&& declare) {
        m_renderer.BeginFrame();
        const Readback hits = m_renderer.ReadBack(declare(m_renderer.Import("rays", m_buffer, m_state)));
        m_renderer.Execute();
        return WaitForValues<gpu::WideHit>(hits);
    }
    uint32_t RayCount() const { return static_cast<uint32_t>(m_rays.size()); }

    // Hits as they are exactly, but for rays that are in doubt, of which there are few.
    void Check(const std::vector<gpu::WideHit>& hits) {
        ASSERT_EQ(hits.size(), m_exact.size());
        uint32_t checked = 0, hitCount = 0;
        for (size_t i = 0; i < hits.size(); ++i) {
            const ExactHit& exact = m_exact[i];
            if (exact.isAmbiguous) continue;
            ++checked;
            ASSERT_EQ(hits[i].t >= 0.0f, exact.t >= 0.0) << i;
            if (exact.t < 0.0) continue;
            ++hitCount;
            ASSERT_EQ(hits[i].instance, exact.instance) << i;
            ASSERT_EQ(hits[i].primitive, exact.primitive) << i;
            EXPECT_NEAR(double{hits[i].t}, exact.t, 1e-4 * exact.t);
            EXPECT_LT(glm::length(PointOf(hits[i]) - (m_rays[i].origin + hits[i].t * m_rays[i].direction)),
                      1e-4f);
        }
        EXPECT_GT(checked, RayCount() * 9 / 10);
        EXPECT_GT(hitCount, RayCount() / 8);
        EXPECT_LT(hitCount, checked);
    }

    // By the barycentrics.
    glm::vec3 PointOf(const gpu::WideHit& hit) const {
        const BvhInstance& instance = m_scene.instances[hit.instance];
        const BvhMesh& mesh = m_scene.meshes[instance.mesh];
        const auto corner = [&](uint32_t i) { return mesh.positions[mesh.indices[3 * hit.primitive + i]]; };
        const glm::vec2 b = hit.barycentrics;
        return instance.objectToWorld *
               glm::vec4((1.0f - b.x - b.y) * corner(0) + b.x * corner(1) + b.y * corner(2), 1.0f);
    }

    const BvhScene m_scene = InstancedTriangleSoup();
    std::vector<gpu::BenchRay> m_rays = RandomRays(2000, 21);
    std::vector<ExactHit> m_exact;
    ResourceState m_state;
    rhi::Buffer m_buffer;
    Renderer m_renderer{Device()};
};

TEST_F(TraversalTest, TheDriverFindsWhatIsThere) {
    DriverScene driver(Device(), m_scene);
    Check(Run([&](BufferId rays) {
        return TraceByDriver(m_renderer, driver.Declare(m_renderer), rays, RayCount());
    }));
}

TEST_F(TraversalTest, WideTreesFindTheSameInOneLevelAndInTwo) {
    for (const bool hasOneLevel : {false, true}) {
        SCOPED_TRACE(hasOneLevel);
        WideDeviceScene wide(Device(), hasOneLevel ? BuildOneLevel(m_scene) : BuildWideScene(m_scene));
        Check(Run([&](BufferId rays) {
            return TraceBySoftware(m_renderer, wide.Declare(m_renderer), rays, RayCount(), hasOneLevel);
        }));
    }
}

TEST_F(TraversalTest, TheFasterOneIsMeasuredOnceAndNotAtAllOnACpu) {
    constexpr const char* kName = "speed of own traversal over the driver's, 1";
    const Traversal chosen = FasterTraversal(Device());
    if (Device().Info().type == rhi::DeviceType::Cpu) {
        EXPECT_EQ(chosen, Traversal::Own);
        EXPECT_EQ(Device().Measured(kName), std::nullopt);
        EXPECT_GT(MeasureSoftwareSpeed(Device()), 0.0);
        return;
    }
    const std::optional<double> measured = Device().Measured(kName);
    ASSERT_TRUE(measured);
    EXPECT_NEAR(MeasureSoftwareSpeed(Device()), *measured, 0.2 * *measured);
    // What is remembered is believed, and decides
    for (const double speed : {0.5, 1.05, 1.2, 3.0}) {
        Device().StoreMeasurement(kName, speed);
        EXPECT_EQ(FasterTraversal(Device()), speed > 1.1 ? Traversal::Own : Traversal::Driver);
    }
    Device().StoreMeasurement(kName, *measured);
}

}  // namespace
}  // namespace raygraph::testing::traversal_test
