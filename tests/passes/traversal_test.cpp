#include <gtest/gtest.h>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "renderer/bvh/facet_scene.h"
#include "renderer/bvh/traversal.h"
#include "renderer/bvh/wide_scene.h"
#include "renderer/graph/readback_values.h"
#include "tests/support/error_of.h"
#include "tests/support/exact_trace.h"
#include "tests/support/same_image.h"
#include "tests/support/scene_render.h"
#include "tests/support/triangle_soup.h"
#include "tests/support/two_levels.h"
#include "tests/support/vulkan_test.h"

// Both ways of tracing a buffer of rays, the driver's and the wide trees', against all triangles one after the
// other in double precision; and which is taken on a device.
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
    constexpr const char* kName = "speed of software traversal over the driver's, 1";
    const Traversal chosen = FasterTraversal(Device());
    if (Device().Info().type == rhi::DeviceType::Cpu) {
        EXPECT_EQ(chosen, Traversal::Software);
        EXPECT_EQ(Device().Measured(kName), std::nullopt);
        return;
    }
    const std::optional<double> measured = Device().Measured(kName);
    ASSERT_TRUE(measured);
    EXPECT_NEAR(MeasureSoftwareSpeed(Device()), *measured, 0.2 * *measured);
    // A stored speed is believed, and decides
    for (const double speed : {0.5, 1.05, 1.2, 3.0}) {
        Device().StoreMeasurement(kName, speed);
        EXPECT_EQ(FasterTraversal(Device()), speed > 1.1 ? Traversal::Software : Traversal::Driver);
    }
    Device().StoreMeasurement(kName, *measured);
}

}  // namespace
}  // namespace raygraph::testing::traversal_test

// Trace by the scene's own trees: sees what the driver sees, after every change of the scene.
namespace raygraph::testing::software_traversal_test {

using passes::TraceSettings;

namespace {

scene::Material SingleSided(const glm::vec3& albedo) {
    scene::Material material = Lambert(albedo, 0.2f * albedo);
    material.isDoubleSided = false;
    return material;
}

scene::Material WithAlpha(scene::AlphaMode mode, float alpha) {
    scene::Material material = Lambert({0.2f, 0.9f, 0.4f});
    material.baseColorFactor.a = alpha;
    material.alphaMode = mode;
    return material;
}

scene::Material Pane(const glm::vec3& tint) {
    scene::Material material;
    material.baseColorFactor = glm::vec4(tint, 1.0f);
    material.metallicFactor = 0.0f;
    material.roughnessFactor = 0.0f;
    material.transmissionFactor = 1.0f;
    return material;
}

glm::mat4x3 Placed(const glm::vec3& at, const glm::vec3& scale) {
    return {glm::vec3(scale.x, 0, 0), glm::vec3(0, scale.y, 0), glm::vec3(0, 0, scale.z), at};
}

// By trees of two levels and of one.
class SoftwareTraversal : public VulkanTest, public ::testing::WithParamInterface<uint32_t> {
  protected:
    // Above a floor: what is mirrored, stretched, culled and seen through in part.
    static scene::SceneData Things() {
        scene::SceneData data =
            SceneOf({QuadMesh(4.0f, 0), BoxMesh(0.3f, 1), SphereMesh(0.4f, 12, 2), QuadMesh(0.5f, 3),
                     QuadMesh(0.6f, 4), QuadMesh(0.4f, 5), BoxMesh(0.25f, 1)},
                    {Lambert(glm::vec3(0.6f)), SingleSided({0.8f, 0.3f, 0.2f}), Lambert({0.3f, 0.4f, 0.9f}),
                     WithAlpha(scene::AlphaMode::Blend, 0.4f), Pane({0.9f, 0.5f, 0.7f}),
                     WithAlpha(scene::AlphaMode::Mask, 0.3f)},
                    {glm::mat4x3(1.0f), Placed({-1, 0.5f, 0.4f}, {1, 1, -1}),
                     Placed({0.4f, 0.3f, 0.5f}, {1, 0.6f, 1.4f}), Placed({-0.3f, -0.8f, 1.0f}, {1, 1, 1}),
                     Placed({0.9f, -0.6f, 0.8f}, {-1, 1, 1}), Placed({0.2f, 1.1f, 0.7f}, {1, 1, 1}),
                     Placed({1.2f, 0.9f, 0.3f}, {-1, -1, -1})});
        scene::Light sun;
        sun.type = scene::LightType::Directional;
        sun.intensity = 2.0f;
        data.lights = {sun};
        return data;
    }
    // Things without glass and alpha compile sooner.
    static scene::SceneData PlainThings() {
        return SceneOf({QuadMesh(4.0f, 0), SphereMesh(0.4f, 12, 1)},
                       {Lambert(glm::vec3(0.6f), glm::vec3(0.1f)), Lambert({0.3f, 0.4f, 0.9f})},
                       {glm::mat4x3(1.0f), Placed({0.4f, 0.3f, 0.5f}, {1, 0.6f, -1.4f})});
    }
    static TraceSettings View(Traversal traversal) {
        TraceSettings settings = LookAt({0.5f, -2.0f, 4.0f}, {0, 0, 0.3f}, 0.8f, 48);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.biases.maxDepth = 6;
        settings.traversal = traversal;
        return settings;
    }
    FloatImage Traced(Traversal traversal, uint32_t sample = 0) {
        TraceSettings settings = View(traversal);
        settings.sampleIndex = sample;
        return render.TraceOnce(settings);
    }
    bool HasOneLevel() {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        render.renderer.Execute();
        return ids.hasOneWideLevel;
    }
    // Hits differ in the last bits, so that here and there a path takes another turn.
    void ExpectAlike(const char* what, bool mayHaveOneLevel = true) {
        SCOPED_TRACE(what);
        EXPECT_EQ(HasOneLevel(), mayHaveOneLevel && GetParam() == 1);
        size_t unlike = 0;
        double sum = 0.0, sumOfOwn = 0.0;
        for (uint32_t sample = 0; sample < 4; ++sample) {
            const FloatImage own = Traced(Traversal::Software, sample),
                             driver = Traced(Traversal::Driver, sample);
            ASSERT_EQ(own.values.size(), driver.values.size());
            for (size_t i = 0; i < own.values.size(); ++i) {
                const glm::vec4 difference = glm::abs(own.values[i] - driver.values[i]);
                unlike += std::max({difference.x, difference.y, difference.z}) > 1e-3f;
                sum += double{driver.values[i].y};
                sumOfOwn += double{own.values[i].y};
            }
        }
        EXPECT_LT(unlike, 4 * 48 * 48 / 1000) << "the smallest thing covers more";
        EXPECT_GT(sum, 0.0);
        EXPECT_NEAR(sumOfOwn, sum, 0.002 * sum);
        EXPECT_EQ(render.scene.Statistics().noWideBvhReason, "");
    }

    // An empty scene has nothing of which to make two levels.
    void SetScene(scene::SceneData&& data) {
        render.scene.SetScene(std::move(data));
        if (GetParam() == 2) ForceTwoLevelTree(render);
    }

    SceneRender render{Device(), {.traversal = Traversal::Software}};
};
INSTANTIATE_TEST_SUITE_P(Levels, SoftwareTraversal, ::testing::Values(1u, 2u));

}  // namespace

TEST_P(SoftwareTraversal, FollowsEveryChange) {
    SetScene(Things());
    ExpectAlike("as it is set");
    render.scene.SetTransform(2, Placed({-0.6f, 0.2f, 0.9f}, {0.5f, 1, 1}));
    ExpectAlike("moved");
    render.scene.SetVisible(1, false);
    ExpectAlike("hidden");
    render.scene.SetVisible(1, true);
    ExpectAlike("shown");
    // From culled to not, from opaque to alpha-tested and to a wall, and back
    for (const scene::Material& material :
         {Lambert(glm::vec3(0.7f)), WithAlpha(scene::AlphaMode::Blend, 0.5f), Pane(glm::vec3(0.8f)),
          SingleSided({0.8f, 0.3f, 0.2f})}) {
        render.scene.SetMaterial(1, material);
        ExpectAlike("another material");
    }
    const uint32_t mesh = render.scene.AddMesh(SphereMesh(0.35f, 10, 0));
    const uint32_t added = render.scene.AddInstance(mesh, {Placed({-1.4f, -0.6f, 0.6f}, {1, 1, 1})});
    ExpectAlike("with another mesh");
    render.scene.RemoveInstance(3);
    render.scene.RemoveInstance(added);
    render.scene.RemoveMesh(mesh);
    ExpectAlike("without some");
    render.scene.SetViewpoint({5000.0, 0.0, 0.0});
    ExpectAlike("from another origin");
    SetScene(Things());
    ExpectAlike("set again");
}

TEST_P(SoftwareTraversal, AnEmptySceneIsBlackAndRoundPrimitivesAreTheDrivers) {
    render.scene.SetScene({});
    EXPECT_EQ(Traced(Traversal::Software).Mean(), Traced(Traversal::Driver).Mean());
    scene::SceneData data = PlainThings();
    data.meshes.push_back(RoundSphere(0.3f, 1, {0, 0, 1}));
    data.instances.push_back(
        {.mesh = static_cast<uint32_t>(data.meshes.size() - 1), .objectToWorld = glm::mat4x3(1.0f)});
    const uint32_t round = static_cast<uint32_t>(data.instances.size() - 1);
    SetScene(std::move(data));
    EXPECT_NE(render.scene.Statistics().noWideBvhReason, "");
    EXPECT_EQ(Traced(Traversal::Software).values, Traced(Traversal::Driver).values) << "by the driver";
    render.scene.SetVisible(round, false);
    if (GetParam() == 2) ForceTwoLevelTree(render);
    ExpectAlike("without what is round");
}

TEST_P(SoftwareTraversal, TheWavefrontSeesWhatTheLoopSees) {
    SetScene(PlainThings());
    TraceSettings settings = View(Traversal::Software);
    settings.form = passes::IntegratorForm::Loop;
    const FloatImage loop = render.TraceOnce(settings);
    settings.form = passes::IntegratorForm::Wavefront;
    const FloatImage wavefront = render.TraceOnce(settings);
    size_t unlike = 0;
    for (size_t i = 0; i < loop.values.size(); ++i) unlike += loop.values[i] != wavefront.values[i];
    EXPECT_LT(unlike, Device().Info().type == rhi::DeviceType::Cpu ? 1u : loop.values.size() / 50);
}

// A ball that goes through a crowd, step by step: boxes follow, and the tree is built again when it has become
// bad, on another thread.
TEST_P(SoftwareTraversal, ATreeThatMotionHasMadeWorseIsBuiltAgain) {
    scene::SceneData data = PlainThings();
    data.meshes.push_back(BoxMesh(0.05f, 1));
    for (uint32_t i = 0; i < 60; ++i)
        data.instances.push_back(
            {.mesh = 2,
             .objectToWorld =
                 Placed({0.2f * float(i % 8) - 0.8f, 0.2f * float(i / 8) - 0.8f, 0.6f}, glm::vec3(1))});
    const auto count = static_cast<uint32_t>(data.instances.size());
    SetScene(std::move(data));
    ExpectAlike("as it is set");
    for (int step = 0; step < 12; ++step) {
        // All of them, each its own way
        for (uint32_t i = 1; i < count; ++i) {
            const float angle = 2.1f * float(i) + 0.7f * float(step);
            render.scene.SetTransform(
                i,
                Placed({1.2f * std::cos(angle), 1.2f * std::sin(angle), 0.1f * float(i % 9)}, glm::vec3(1)));
        }
        Traced(Traversal::Software);
    }
    ExpectAlike("moved");
    for (int frame = 0; frame < 50; ++frame) Traced(Traversal::Software);
    ExpectAlike("at rest");
}

// Rays in the space of the mesh would overflow. In the scene's space all is near.
TEST_P(SoftwareTraversal, AMeshThatReachesTooFarIsPlacedOrTheDrivers) {
    // A sky would light the far mesh, and show that float rounds the points where rays leave it to 1e6 m.
    render.scene.SetEnvironment({});
    scene::SceneData data = PlainThings();
    data.meshes.push_back(BoxMesh(2e18f, 1));
    data.instances.push_back({.mesh = 2, .objectToWorld = Placed({1e13f, 1e13f, 0.0f}, glm::vec3(1e-6f))});
    SetScene(std::move(data));
    if (GetParam() == 1) return ExpectAlike("in one level");
    EXPECT_EQ(Traced(Traversal::Software).values, Traced(Traversal::Driver).values);
    EXPECT_EQ(render.scene.Statistics().noWideBvhReason, "a mesh reaches too far for a tree");
}

// A tree over all of their triangles would take too long to build.
TEST_P(SoftwareTraversal, ManyTrianglesAreInTwoLevels) {
    scene::SceneData data = PlainThings();
    data.meshes.push_back(SphereMesh(0.1f, 64, 1));
    const uint64_t each = data.meshes.back().primitives[0].TriangleCount();
    for (uint64_t placed = 0; placed <= kMaxLevelTriangles; placed += each) {
        const float x = 4e-6f * static_cast<float>(placed) - 1.0f;
        data.instances.push_back({.mesh = 2, .objectToWorld = Placed({x, 0.6f, 0.4f}, {1, 1, 1})});
    }
    const auto count = static_cast<uint32_t>(data.instances.size());
    SetScene(std::move(data));
    ExpectAlike("too many", false);
    // They stay so: their tables are there
    for (uint32_t i = 8; i < count; ++i) render.scene.RemoveInstance(i);
    ExpectAlike("few", false);
}

// Nobody reads the driver's structures then, and none are built.
TEST_P(SoftwareTraversal, BuildsNothingForTheDriver) {
    SetScene(PlainThings());
    Traced(Traversal::Software);
    Traced(Traversal::Auto);
    EXPECT_EQ(render.scene.Statistics().blasBuilds, 0u);
    EXPECT_EQ(render.scene.Statistics().tlasRebuilds, 0u);
    Traced(Traversal::Driver);
    EXPECT_GT(render.scene.Statistics().blasBuilds, 0u);
    EXPECT_GT(render.scene.Statistics().tlasRebuilds, 0u);
}

}  // namespace raygraph::testing::software_traversal_test

// Round primitives on the device: hits against closed forms, pictures against triangle meshes and furnaces.
namespace raygraph::testing::trace_capsules_test {

using passes::TraceSettings;

namespace {

// From x = -1 to 1, of radius 0.5.
scene::Mesh Capsule(uint32_t material = 0) {
    return RoundMesh({{-1, 0, 0}, {1, 0, 0}}, {0, 1}, {0.5f}, material);
}

// With back faces and gloss, of glTF's model.
scene::Material Gloss() {
    scene::Material material;
    material.baseColorFactor = {0.8f, 0.5f, 0.3f, 1.0f};
    material.metallicFactor = 0.0f;
    material.roughnessFactor = 0.4f;
    return material;
}

scene::Material Glass(float thickness, const glm::vec3& tint = glm::vec3(1.0f)) {
    scene::Material material;
    material.baseColorFactor = glm::vec4(tint, 1.0f);
    material.metallicFactor = 0.0f;
    material.roughnessFactor = 0.0f;
    material.transmissionFactor = 1.0f;
    material.thicknessFactor = thickness;
    return material;
}

class TraceCapsules : public VulkanTest {
  protected:
    // The means of both agree to `tolerance`, with noise that could have shown a failure.
    void ExpectSameMean(const RenderedImage& a, const RenderedImage& b, double tolerance) {
        for (int channel = 0; channel < 3; ++channel) {
            const double error = a.StandardErrorOfMean()[channel] + b.StandardErrorOfMean()[channel];
            EXPECT_NEAR(a.mean.Mean()[channel], b.mean.Mean()[channel],
                        tolerance * b.mean.Mean()[channel] + 4.0 * error)
                << "channel " << channel;
            EXPECT_LT(4.0 * error, tolerance * b.mean.Mean()[channel]) << "too noisy to prove anything";
        }
    }
    void ExpectMean(const RenderedImage& image, double expected, double tolerance) {
        for (int channel = 0; channel < 3; ++channel) {
            EXPECT_NEAR(image.mean.Mean()[channel], expected, tolerance * expected) << "channel " << channel;
            EXPECT_LT(3.0 * image.StandardErrorOfMean()[channel], tolerance * expected) << "too noisy";
        }
    }
    // Positions are on the surface f = 0 of the world, and normals along its gradient.
    template <typename Value, typename Gradient>
    void ExpectHitsOn(const TraceSettings& settings, Value&& value, Gradient&& gradient, double share) {
        const SceneRender::Hits hits = render.PrimaryHits(settings);
        size_t hitCount = 0;
        for (size_t i = 0; i < hits.ids.size(); ++i) {
            if (hits.ids[i].x == 0xFFFFFFFFu) continue;
            ++hitCount;
            const glm::dvec3 position(hits.position.values[i]), normal(hits.normal.values[i]);
            ASSERT_LT(std::abs(value(position)), 2e-6) << i;
            ASSERT_GT(glm::dot(normal, glm::normalize(gradient(position))), 1.0 - 1e-6) << i;
        }
        EXPECT_NEAR(double(hitCount) / double(hits.ids.size()), share, 0.01);
    }

    SceneRender render{Device()};
};

}  // namespace

TEST_F(TraceCapsules, Trace_SpheresAndCapsulesAreHitOnTheirSurfaces) {
    render.scene.SetScene(SceneOf({RoundSphere(1.0f)}, {Lambert(glm::vec3(0.5f))}));
    const TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 0.7f, 64);
    const double edge = 1.0 / std::sqrt(15.0) / std::tan(0.35);  // of half the picture
    ExpectHitsOn(
        settings, [](const glm::dvec3& p) { return glm::length(p) - 1.0; },
        [](const glm::dvec3& p) { return p; }, M_PI * edge * edge / 4.0);

    render.scene.SetScene(SceneOf({Capsule()}, {Lambert(glm::vec3(0.5f))}));
    const auto axis = [](const glm::dvec3& p) { return glm::dvec3(glm::clamp(p.x, -1.0, 1.0), 0, 0); };
    TraceSettings parallel = LookAt({0, 0, 4}, {0, 0, 0}, 0.7f, 128);
    parallel.camera.orthographic = 1;
    parallel.camera.right = {2, 0, 0};
    parallel.camera.up = {0, 2, 0};
    parallel.camera.zFar = 10.0f;
    ExpectHitsOn(
        parallel, [&](const glm::dvec3& p) { return glm::length(p - axis(p)) - 0.5; },
        [&](const glm::dvec3& p) { return p - axis(p); }, (2.0 + M_PI * 0.25) / 16.0);
}

// A sphere in object space becomes the ellipsoid of its transform: surface, normals, and as seen in a mirror.
TEST_F(TraceCapsules, Trace_UnevenAndMirroringTransformsMakeEllipsoids) {
    for (const float mirror : {1.0f, -1.0f}) {
        const glm::mat4x3 transform{
            {mirror * 0.5f, 0.2f, 0}, {0, 1.2f, 0}, {0.1f, 0, 0.8f}, {0.3f, -0.2f, 0.1f}};
        render.scene.SetScene(SceneOf({RoundSphere(1.0f)}, {Lambert(glm::vec3(0.5f))}, {transform}));
        const glm::dmat3 inverse = glm::inverse(glm::dmat3(glm::mat3(transform)));
        const auto inObject = [&](const glm::dvec3& p) { return inverse * (p - glm::dvec3(transform[3])); };
        const SceneRender::Hits hits = render.PrimaryHits(LookAt({0, 0, 6}, {0, 0, 0}, 0.6f, 64));
        size_t hitCount = 0;
        for (size_t i = 0; i < hits.ids.size(); ++i) {
            if (hits.ids[i].x == 0xFFFFFFFFu) continue;
            ++hitCount;
            const glm::dvec3 p = inObject(glm::dvec3(hits.position.values[i]));
            ASSERT_NEAR(glm::length(p), 1.0, 3e-6);
            const glm::dvec3 normal = glm::normalize(glm::transpose(inverse) * p);
            ASSERT_GT(glm::dot(normal, glm::dvec3(hits.normal.values[i])), 1.0 - 1e-6);
        }
        EXPECT_GT(hitCount, 500u);
    }
}

TEST_F(TraceCapsules, Trace_APictureOfSpheresIsThatOfTheirMeshes) {
    render.scene.SetEnvironmentMap(EveningSky());
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings settings = LookAt({0, 1, 4}, {0, 0, 0}, 0.8f, 64);
    settings.scattering.brdf = BrdfModel::Gltf;
    const std::vector<glm::mat4x3> places{Translation({-1, 0, 0}), Translation({1, 0, 0}),
                                          Translation({0, -3, 0})};
    const auto scene = [&](const scene::Mesh& ball) {
        scene::Mesh floor = QuadMesh(3.0f, 1);
        for (glm::vec3& p : floor.primitives[0].positions) p = {p.x, 2.0f, -p.y};
        floor.primitives[0].normals.assign(floor.primitives[0].positions.size(), {0, 1, 0});
        floor.primitives[0].bounds = {{-3, 2, -3}, {3, 2, 3}};
        return SceneOf({ball, ball, floor}, {Gloss(), Lambert(glm::vec3(0.6f))}, places);
    };
    render.scene.SetScene(scene(SphereMesh(0.9f, 256)));
    const RenderedImage mesh = render.Render(settings, 160);
    render.scene.SetScene(scene(RoundSphere(0.9f)));
    const RenderedImage round = render.Render(settings, 160);
    ExpectSameMean(round, mesh, 0.01);
    ExpectSameImage(round, mesh, "spheres", PixelErrors::Independent);
}

TEST_F(TraceCapsules, Trace_WhiteCapsulesAndGlassVanishInUnitEnvironment) {
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings settings = LookAt({0, 1, 4}, {0, 0, 0}, 0.7f, 32);
    render.scene.SetScene(SceneOf({Capsule(), RoundSphere(0.4f)}, {Lambert(glm::vec3(1.0f))},
                                  {glm::mat4x3(1.0f), Translation({0.0f, 0.8f, 0.2f})}));
    ExpectMean(render.Render(settings, 64), 1.0, 0.003);
    // Light that goes in comes out: each ray that starts inside leaves
    settings.scattering.brdf = BrdfModel::Gltf;
    for (const float thickness : {0.0f, 1.0f}) {
        render.scene.SetScene(SceneOf({Capsule(), RoundSphere(0.4f)}, {Glass(thickness)},
                                      {glm::mat4x3(1.0f), Translation({0.0f, 1.0f, 0.2f})}));
        ExpectMean(render.Render(settings, 64), 1.0, 0.003);
    }
}

// Beer's law along a chord of a glass sphere of index 1, which refracts nothing.
TEST_F(TraceCapsules, Trace_AMediumInASphereAbsorbsAlongItsChord) {
    scene::Material glass = Glass(1.0f);
    glass.ior = 1.0f;
    glass.attenuationColor = glm::vec3(0.5f);
    glass.attenuationDistance = 2.0f;
    render.scene.SetScene(SceneOf({RoundSphere(1.5f)}, {glass}));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings settings = LookAt({0, 0, 9}, {0, 0, 0}, 1e-3f, 8);
    settings.scattering.brdf = BrdfModel::Gltf;
    ExpectMean(render.Render(settings, 4), std::pow(0.5, 3.0 / 2.0), 0.002);
}

// The shadow of a line on a floor, under the sun: black within its radius, full light outside.
TEST_F(TraceCapsules, Trace_ALineCastsTheShadowOfItsRadius) {
    scene::SceneData scene =
        SceneOf({QuadMesh(4.0f, 0), RoundMesh({{0, -9, 1}, {0, 9, 1}}, {0, 1}, {0.25f}, 1)},
                {Lambert(glm::vec3(0.5f)), Lambert(glm::vec3(0.0f))});
    scene::Light sun;  // along -z
    sun.type = scene::LightType::Directional;
    sun.intensity = 2.0f;
    scene.lights = {sun};
    render.scene.SetScene(std::move(scene));
    for (const auto& [x, expected] :
         {std::pair{0.0f, 0.0}, {0.24f, 0.0}, {-0.24f, 0.0}, {0.26f, 1.0}, {-0.26f, 1.0}}) {
        TraceSettings settings = LookAt({x, 0, 0.5f}, {x, 0, 0}, 1e-3f, 8);
        settings.biases.maxDepth = 1;
        EXPECT_NEAR(render.Render(settings, 4).mean.Mean().y, expected * 0.5 * 2.0 / M_PI, 1e-4) << x;
    }
}

// Each side stops the share alpha of the light, one-sided ones only from outside: the sun on the floor, through
// any-hit of shadow rays, and the floor seen from above, through that of camera rays.
TEST_F(TraceCapsules, Trace_BlendedSpheresPassTheirShareOfEachSide) {
    for (const bool isDoubleSided : {false, true}) {
        scene::Material veil = Lambert(glm::vec3(0.0f));
        veil.alphaMode = scene::AlphaMode::Blend;
        veil.baseColorFactor.a = 0.6f;
        veil.isDoubleSided = isDoubleSided;
        scene::Mesh ball = RoundSphere(0.5f, 1, {0, 0, 2});
        ball.primitives[0].colors = {{1, 1, 1, 0.5f}};  // alpha 0.3 in all
        // Instance 0 is the ball: the number that tells surfaces apart is 0 for its primitive
        scene::SceneData scene = SceneOf({ball, QuadMesh(4.0f, 0)}, {Lambert(glm::vec3(0.5f)), veil});
        scene::Light sun;
        sun.type = scene::LightType::Directional;
        sun.intensity = 2.0f;
        scene.lights = {sun};
        render.scene.SetScene(std::move(scene));
        const double passed = isDoubleSided ? 0.7 * 0.7 : 0.7;
        TraceSettings settings = LookAt({0.2f, 0, 0.5f}, {0.2f, 0, 0}, 1e-3f, 32);
        settings.biases.maxDepth = 1;
        ExpectMean(render.Render(settings, 256), passed * 0.5 * 2.0 / M_PI, 0.01);
        // From above: seen through the ball as well as lit through it
        settings = LookAt({0.2f, 0, 6}, {0.2f, 0, 0}, 1e-3f, 32);
        settings.biases.maxDepth = 1;
        ExpectMean(render.Render(settings, 256), passed * passed * 0.5 * 2.0 / M_PI, 0.015);
    }
}

// A smooth thin wall is a hole for a share of the light, at each of its two sides, with and without other
// surfaces that are tested in the scene.
TEST_F(TraceCapsules, Trace_LightThroughAThinWalledSphereIsThatOfItsTwoWalls) {
    for (const bool hasAlpha : {false, true}) {
        SCOPED_TRACE(hasAlpha ? "with a veil elsewhere" : "alone");
        scene::Material veil = Lambert(glm::vec3(0.0f));
        veil.alphaMode = scene::AlphaMode::Blend;
        veil.baseColorFactor.a = 0.5f;
        scene::SceneData scene = SceneOf(
            {QuadMesh(1.0f, 0), RoundSphere(0.5f, 1, {0, 0, 2}), RoundSphere(0.5f, 2, {9, 0, 2})},
            {Lambert(glm::vec3(0.5f)), Glass(0.0f, {0.8f, 0.5f, 0.3f}), hasAlpha ? veil : Lambert({})});
        scene.materials[0].metallicFactor = 0.0f;
        scene.materials[0].specularFactor = 0.0f;
        scene::Light sun;
        sun.type = scene::LightType::Directional;
        sun.intensity = 2.0f;
        scene.lights = {sun};
        render.scene.SetScene(std::move(scene));
        TraceSettings settings = LookAt({0, 0, 0.5f}, {0, 0, 0}, 1e-3f, 8);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.biases.maxDepth = 1;
        const glm::dvec3 mean = render.Render(settings, 8).mean.Mean();
        const glm::dvec3 tint(0.8, 0.5, 0.3);
        for (int channel = 0; channel < 3; ++channel) {
            const double expected = 0.5 * 2.0 / M_PI * std::pow(0.96 * tint[channel], 2.0);
            EXPECT_NEAR(mean[channel], expected, 0.01 * expected) << channel;
        }
    }
}

// Two segments of one primitive: colors run along each, ids count in the file's order, and the emission of a
// round primitive is found by rays.
TEST_F(TraceCapsules, Trace_ColorsRunAlongSegmentsAndIdsAreTheFiles) {
    scene::Mesh lines = RoundMesh({{-1, 0.5f, 0}, {1, 0.5f, 0}, {-1, -0.5f, 0}, {1, -0.5f, 0}}, {2, 3, 0, 1},
                                  {0.2f, 0.2f}, 1);
    lines.primitives[0].colors = {{0, 0, 1, 1}, {1, 0, 1, 1}, {0, 1, 1, 1}, {1, 1, 1, 1}};
    scene::Mesh both = RoundSphere(0.1f, 0, {0, 2, 0});
    both.primitives.push_back(lines.primitives[0]);
    scene::Material unlit = Lambert(glm::vec3(1.0f));
    unlit.isUnlit = true;
    render.scene.SetScene(SceneOf({QuadMesh(0.1f, 0), both}, {Lambert(glm::vec3(0.5f)), unlit},
                                  {Translation({9, 9, 0}), glm::mat4x3(1.0f)}));
    const SceneRender::Hits hits = render.PrimaryHits(LookAt({0, 0, 4}, {0, 0, 0}, 0.7f, 64));
    size_t seen[2] = {};
    for (size_t i = 0; i < hits.ids.size(); ++i) {
        if (hits.ids[i].x == 0xFFFFFFFFu) continue;
        const glm::vec4 position = hits.position.values[i], color = hits.albedo.values[i];
        ASSERT_EQ(hits.ids[i].x, 1u);
        ASSERT_EQ(hits.ids[i].y, 1u);
        ASSERT_EQ(hits.ids[i].z, position.y < 0.0f ? 0u : 1u);
        seen[hits.ids[i].z]++;
        ASSERT_NEAR(color.x, glm::clamp(0.5f + 0.5f * position.x, 0.0f, 1.0f), 1e-5f);
        ASSERT_NEAR(color.y, position.y < 0.0f ? 1.0f : 0.0f, 1e-6f);
    }
    EXPECT_GT(seen[0], 100u);
    EXPECT_GT(seen[1], 100u);
    const FloatImage shines = render.TraceOnce(LookAt({0, -0.5f, 4}, {0, -0.5f, 0}, 1e-3f, 8));
    EXPECT_NEAR(shines.Mean().x, 0.5, 0.01);
    EXPECT_NEAR(shines.Mean().y, 1.0, 1e-5);
}

// An edit that changes how rays treat a round group builds it again, and its other sides follow.
TEST_F(TraceCapsules, Trace_AMaterialThatIsEditedTakesEffect) {
    scene::Material veil = Lambert(glm::vec3(0.5f));
    veil.alphaMode = scene::AlphaMode::Mask;
    render.scene.SetScene(SceneOf({RoundSphere(0.5f)}, {veil}));
    const TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 1e-2f, 4);
    EXPECT_EQ(render.PrimaryHits(settings).ids[0].x, 0u);
    veil.baseColorFactor.a = 0.2f;
    render.scene.SetMaterial(0, veil);
    EXPECT_EQ(render.PrimaryHits(settings).ids[0].x, 0xFFFFFFFFu) << "below the cutoff it is a hole";
    // From inside, back faces are culled where they are one-sided
    veil.baseColorFactor.a = 1.0f;
    veil.isDoubleSided = false;
    render.scene.SetMaterial(0, veil);
    const TraceSettings inside = LookAt({0, 0, 0}, {0, 0, 1}, 1e-2f, 4);
    EXPECT_EQ(render.PrimaryHits(inside).ids[0].x, 0xFFFFFFFFu);
    veil.isDoubleSided = true;
    render.scene.SetMaterial(0, veil);
    EXPECT_EQ(render.PrimaryHits(inside).ids[0].x, 0u);
}

TEST_F(TraceCapsules, Trace_MeshesBesideRoundPrimitivesKeepTheirBits) {
    const auto scene = [](bool hasPoint) {
        scene::SceneData room = RoomWithLamp();
        if (hasPoint) {
            room.meshes.push_back(RoundSphere(0.01f));
            scene::Instance far;
            far.mesh = static_cast<uint32_t>(room.meshes.size() - 1);
            far.objectToWorld = Translation({0, -1000, 0});
            room.instances.push_back(far);
        }
        return room;
    };
    render.scene.SetScene(scene(false));
    const SceneRender::Hits without = render.PrimaryHits(ViewOfRoom(32));
    render.scene.SetScene(scene(true));
    const SceneRender::Hits with = render.PrimaryHits(ViewOfRoom(32));
    EXPECT_EQ(without.ids, with.ids);
    EXPECT_EQ(without.position.values, with.position.values);
}

}  // namespace raygraph::testing::trace_capsules_test

// Triangles of placed meshes, traced on the host.
namespace raygraph::facet_scene_test {
namespace {

FacetScene FacetsOf(const BvhScene& scene, bool isBackCulled = false) {
    std::vector<std::vector<Facet>> meshes;
    for (const BvhMesh& mesh : scene.meshes) {
        std::vector<Facet>& facets = meshes.emplace_back();
        const auto corner = [&](size_t i) { return mesh.positions[mesh.indices[i]]; };
        for (size_t i = 0; i < mesh.indices.size(); i += 3)
            facets.push_back({corner(i), corner(i + 1), corner(i + 2), isBackCulled});
    }
    return {std::move(meshes), scene.instances};
}

TEST(FacetScene, FindsTheNearestOfAllTriangles) {
    const BvhScene scene = testing::InstancedTriangleSoup();
    const FacetScene facets = FacetsOf(scene);
    uint32_t hits = 0;
    const std::vector<gpu::BenchRay> rays = testing::RandomRays(2000, 7);
    for (const gpu::BenchRay& ray : rays) {
        const ExactHit exact = TraceExactly(scene, ray);
        if (exact.isAmbiguous) continue;
        const std::optional<FacetHit> hit = facets.Trace(ray.origin, ray.direction);
        EXPECT_EQ(facets.IsOccluded(ray.origin, ray.direction, ray.tMax), exact.t >= 0.0);
        ASSERT_EQ(hit.has_value(), exact.t >= 0.0);
        if (!hit) continue;
        ++hits;
        EXPECT_NEAR(double{hit->t}, exact.t, 1e-4 * exact.t);
        EXPECT_EQ(hit->instance, exact.instance);
        EXPECT_EQ(hit->facet, exact.primitive);
        // The normal is perpendicular to the triangle where it is placed, and on the ray's side
        const Facet& facet = facets.FacetsOf(scene.instances[hit->instance].mesh)[hit->facet];
        const glm::mat3 linear(scene.instances[hit->instance].objectToWorld);
        for (const glm::vec3& edge : {facet.p1 - facet.p0, facet.p2 - facet.p0})
            EXPECT_NEAR(glm::dot(hit->normal, glm::normalize(linear * edge)), 0.0f, 1e-3f);
        EXPECT_NEAR(glm::length(hit->normal), 1.0f, 1e-5f);
        EXPECT_LE(glm::dot(hit->normal, ray.direction), 0.0f);
    }
    EXPECT_GT(hits, rays.size() / 4);
    EXPECT_LT(hits, rays.size());
}

TEST(FacetScene, RaysPassThroughCulledBacksAndAMirrorKeepsTheFront) {
    const BvhScene quad{
        {{.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, .indices = {0, 1, 2, 0, 2, 3}}},
        {{}}};
    BvhScene mirrored = quad;
    mirrored.instances[0].objectToWorld = glm::mat4x3(glm::scale(glm::mat4(1.0f), {-2.0f, 1.0f, 1.0f}));
    const glm::vec3 above(0.3f, 0.2f, 1.0f), below(0.3f, 0.2f, -1.0f), up(0.0f, 0.0f, 1.0f);
    for (const BvhScene& scene : {quad, mirrored}) {
        const FacetScene culled = FacetsOf(scene, true);
        EXPECT_TRUE(culled.Trace(above, -up));
        EXPECT_FALSE(culled.Trace(below, up));
        EXPECT_FALSE(culled.IsOccluded(below, up, 10.0f));
        EXPECT_TRUE(FacetsOf(scene).Trace(below, up));
    }
}

TEST(FacetScene, ATestDecidesWhichRaysPassThrough) {
    // Three triangles one behind the other, of which the first two are tested
    std::vector<Facet> facets;
    for (const float z : {2.0f, 1.0f, 0.0f}) facets.push_back({{-1, -1, z}, {3, -1, z}, {-1, 3, z}});
    facets[0].isTested = facets[1].isTested = true;
    const auto isThere = [](uint32_t, uint32_t facet, const glm::vec2& barycentrics) {
        return facet == 1 && barycentrics.x > 0.3f && barycentrics.y < 0.3f;
    };
    const FacetScene scene({facets}, {{}}, 1, isThere);
    const auto hit = [&](float x, float y) { return scene.Trace({x, y, 5}, {0, 0, -1}); };
    ASSERT_TRUE(hit(0.5f, -0.5f));
    EXPECT_EQ(hit(0.5f, -0.5f)->facet, 1u);
    EXPECT_NEAR(hit(0.5f, -0.5f)->barycentrics.x, 0.375f, 1e-6f);
    EXPECT_NEAR(hit(0.5f, -0.5f)->barycentrics.y, 0.125f, 1e-6f);
    ASSERT_TRUE(hit(0.0f, 0.5f));
    EXPECT_EQ(hit(0.0f, 0.5f)->facet, 2u);
    EXPECT_TRUE(scene.IsOccluded({0.5f, -0.5f, 5}, {0, 0, -1}, 4.5f));
    EXPECT_FALSE(scene.IsOccluded({0.0f, 0.5f, 5}, {0, 0, -1}, 4.5f));
    EXPECT_EQ(FacetScene({facets}, {{}}).Trace({0.5f, 0.5f, 5}, {0, 0, -1})->facet, 0u);
}

TEST(FacetScene, WhatHasNoInverseOrNoFacetsIsNotHit) {
    const std::vector<Facet> triangle{{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}};
    const glm::mat4x3 flat(glm::scale(glm::mat4(1.0f), {1.0f, 0.0f, 1.0f}));
    const FacetScene scene({triangle, {}}, {{0, flat}, {1, glm::mat4x3(1.0f)}});
    EXPECT_FALSE(scene.Trace({0, 0, 1}, {0, 0, -1}));
    EXPECT_FALSE(FacetScene({}, {}).Trace({0, 0, 1}, {0, 0, -1}));
}

}  // namespace
}  // namespace raygraph::facet_scene_test
