// Tests top-level structures: build, update, and instances as the device reads them.
#include "rhi/tlas.h"

#include <gtest/gtest.h>

#include "rhi/device.h"
#include "tests/rhi/trace_test.h"
#include "tests/support/error_of.h"

namespace raygraph::rhi::tlas_test {
namespace {

class TlasTest : public TraceTest {
  protected:
    std::shared_ptr<Blas> m_quad = Build(Describe(Quad(0, 0)));
};

TEST_F(TlasTest, UpdateMovesAHit) {
    Tlas tlas = BuildTlas({Instance(*m_quad, 0), Instance(*m_quad, 10)});
    const RayTracingPipeline& pipeline = PlainPipeline();
    const std::vector<TestRay> rays{
        {.origin = {0, 0.1f, -4}}, {.origin = {5, 0.1f, -4}}, {.origin = {10, 0.1f, -4}}};
    auto codes = [&] {
        std::vector<uint32_t> out;
        for (const TestResult& result : Trace(pipeline, tlas, rays)) out.push_back(result.code);
        return out;
    };
    EXPECT_EQ(codes(), (std::vector<uint32_t>{1, 2, 1}));
    const VkDeviceAddress address = tlas.Address();
    const Buffer moved = Instances({Instance(*m_quad, 5), Instance(*m_quad, 10)});
    Run([&](CommandList& commands) { tlas.Update(commands, moved, 2); });
    EXPECT_EQ(codes(), (std::vector<uint32_t>{2, 1, 1}));
    EXPECT_EQ(tlas.Address(), address);

    const Buffer fewer = Instances({Instance(*m_quad, 0)});
    Run([&](CommandList& commands) { tlas.Build(commands, fewer, 1); });  // within the capacity
    EXPECT_EQ(tlas.InstanceCount(), 1u);
    EXPECT_EQ(codes(), (std::vector<uint32_t>{1, 2, 2}));
}

TEST_F(TlasTest, BuildAndUpdateInOneListAreOrdered) {
    const Buffer first = Instances({Instance(*m_quad, 0)});
    const Buffer second = Instances({Instance(*m_quad, 5)});
    Tlas tlas(Device(), {.name = "moving", .capacity = 1});
    Run([&](CommandList& commands) {
        tlas.Build(commands, first, 1);
        tlas.Update(commands, second, 1);
    });
    EXPECT_EQ(Trace(PlainPipeline(), tlas, {{.origin = {5, 0.1f, -4}}})[0].code, 1u);
}

TEST_F(TlasTest, DroppedList_TakesItsBuildsBack) {
    const Buffer one = Instances({Instance(*m_quad, 0)});
    const Buffer two = Instances({Instance(*m_quad, 0), Instance(*m_quad, 5)});
    Tlas tlas(Device(), {.name = "dropped", .capacity = 2});
    {
        CommandList commands = Device().BeginCommands("dropped");
        tlas.Build(commands, two, 2);
        tlas.Update(commands, two, 2);
    }
    EXPECT_EQ(tlas.InstanceCount(), 0u);
    CommandList commands = Device().BeginCommands("update");
    EXPECT_EQ(testing::ErrorTextOf([&] { tlas.Update(commands, two, 2); }),
              "TLAS 'dropped': update before its first build");
    tlas.Build(commands, one, 1);
    Device().WaitFor(Device().Submit(std::move(commands)));
    EXPECT_EQ(tlas.InstanceCount(), 1u);
    EXPECT_EQ(Trace(PlainPipeline(), tlas, {{.origin = {0, 0.1f, -4}}})[0].code, 1u);
}

TEST_F(TlasTest, TransformIsRowMajorObjectToWorld) {
    TlasInstance instance = Instance(*m_quad);
    // x' = 2 z + 3, y' = y, z' = x: the quad turns into the plane x = 3 and faces along x.
    instance.objectToWorld = {0, 0, 2, 3, 0, 1, 0, 0, 1, 0, 0, 0};
    const std::vector<TestResult> results =
        Trace(PlainPipeline(), BuildTlas({instance}), {{.origin = {0, 0.1f, 0.5f}, .direction = {1, 0, 0}}});
    EXPECT_EQ(results[0].code, 1u);
    EXPECT_FLOAT_EQ(results[0].distance, 3.0f);
}

TEST_F(TlasTest, NoInstancesMeansThatEveryRayMisses) {
    for (const TestResult& result : Trace(PlainPipeline(), BuildTlas({}), RayGrid(4)))
        EXPECT_EQ(result.code, 2u);
}

TEST_F(TlasTest, MaskZeroAndInactiveInstancesAreNeverHit) {
    TlasInstance masked = Instance(*m_quad, 0);
    masked.mask = 0;
    TlasInstance inactive = Instance(*m_quad, 4);
    inactive.blas = 0;
    const std::vector<TestResult> results =
        Trace(PlainPipeline(), BuildTlas({masked, inactive, Instance(*m_quad, 8)}),
              {{.origin = {0, 0.1f, -4}}, {.origin = {4, 0.1f, -4}}, {.origin = {8, 0.1f, -4}}});
    EXPECT_EQ(results[0].code, 2u);
    EXPECT_EQ(results[1].code, 2u);
    EXPECT_EQ(results[2].code, 1u);
}

TEST_F(TlasTest, FrontFaceIsCounterClockwiseUnlessFlippedAndMirroringKeepsIt) {
    const ShaderStage hit = Compile("facing.rchit", R"(
        void main() { payload.code = gl_HitKindEXT == gl_HitKindFrontFacingTriangleEXT ? 5 : 6; })");
    HitGroupSet set(kRayTypeCount);
    set[RayType::Radiance].closestHit = hit;
    const RayTracingPipeline pipeline =
        CreateRayTracingPipeline(Device(), {.name = "facing", .rayGen = {RayGen(), {}}, .hitSets = {set}});
    // Seen from -z along +z with y up, +x is to the left: (-1,-1), (-1,1), (1,1) turn counter-clockwise.
    const TlasInstance plain = Instance(*m_quad, 0);
    TlasInstance flipped = Instance(*m_quad, 4);
    flipped.isFacingFlipped = true;
    TlasInstance mirrored = Instance(*m_quad, 8);
    mirrored.objectToWorld[0] = -1.0f;
    std::vector<TestRay> rays;
    for (float x : {0.0f, 4.0f, 8.0f})
        for (float side : {-1.0f, 1.0f})
            rays.push_back({.origin = {x, 0.1f, 4 * side}, .direction = {0, 0, -side}});
    std::vector<uint32_t> codes;
    for (const TestResult& result : Trace(pipeline, BuildTlas({plain, flipped, mirrored}), rays))
        codes.push_back(result.code);
    EXPECT_EQ(codes, (std::vector<uint32_t>{5, 6, 6, 5, 5, 6}));
}

TEST_F(TlasTest, CullingFollowsTheFacingWhereItIsNotDisabled) {
    const ShaderStage rayGen = Compile("cull.rgen", R"(
        void main() {
            Ray ray = rays[gl_LaunchIDEXT.x];
            payload = Payload(~0u, ~0u, ~0u, -1.0);
            traceRayEXT(tlas, gl_RayFlagsCullBackFacingTrianglesEXT, 0xff, 0, 0, 0, ray.origin, 0.0,
                        ray.direction, 1e9, 0);
            results[gl_LaunchIDEXT.x] = payload;
        })");
    HitGroupSet set(kRayTypeCount);
    set[RayType::Radiance].closestHit = ClosestHit("cull", 1);
    const RayTracingPipeline pipeline =
        CreateRayTracingPipeline(Device(), {.name = "cull", .rayGen = {rayGen, {}}, .hitSets = {set}});
    TlasInstance culled = Instance(*m_quad, 0);
    culled.isCullingDisabled = false;
    const std::vector<TestResult> results = Trace(pipeline, BuildTlas({culled, Instance(*m_quad, 4)}),
                                                  {{.origin = {0, 0.1f, -4}},
                                                   {.origin = {0, 0.1f, 4}, .direction = {0, 0, -1}},
                                                   {.origin = {4, 0.1f, 4}, .direction = {0, 0, -1}}});
    EXPECT_EQ(results[0].code, 1u) << "front";
    EXPECT_EQ(results[1].code, kUntouched) << "back";
    EXPECT_EQ(results[2].code, 1u) << "back, culling disabled";
}

TEST_F(TlasTest, MisuseIsRefusedByName) {
    Tlas tlas(Device(), {.name = "small", .capacity = 2});
    Tlas rigid(Device(), {.name = "rigid", .capacity = 2, .allowsUpdate = false});
    const Buffer three = Instances({Instance(*m_quad), Instance(*m_quad), Instance(*m_quad)});
    const Buffer one = Instances({Instance(*m_quad)});
    Run([&](CommandList& commands) {
        EXPECT_EQ(testing::ErrorTextOf([&] { tlas.Build(commands, three, 3); }),
                  "TLAS 'small': 3 instances exceed its capacity of 2");
        EXPECT_EQ(testing::ErrorTextOf([&] { tlas.Build(commands, one, 2); }),
                  "TLAS 'small': 2 instances exceed buffer 'instances' of 64 bytes");
        EXPECT_EQ(testing::ErrorTextOf([&] { tlas.Update(commands, three, 2); }),
                  "TLAS 'small': update before its first build");
        tlas.Build(commands, three, 2);
        EXPECT_EQ(testing::ErrorTextOf([&] { tlas.Update(commands, three, 1); }),
                  "TLAS 'small': update with 1 instances, built with 2");
        rigid.Build(commands, three, 2);
        EXPECT_EQ(testing::ErrorTextOf([&] { rigid.Update(commands, three, 2); }),
                  "TLAS 'rigid': update, but it was made without allowsUpdate");
    });
}

TEST_F(TlasTest, InstanceFieldsBeyond24BitsAreRefusedWithTheirPlace) {
    std::vector<std::byte> target(2 * kTlasInstanceBytes);
    std::vector<TlasInstance> instances(2);
    instances[1].customIndex = 0xffffff;
    EXPECT_EQ(testing::ErrorTextOf([&] { WriteInstances(instances, target); }), "accepted");
    instances[1].customIndex = 0x1000000;
    EXPECT_EQ(testing::ErrorTextOf([&] { WriteInstances(instances, target); }),
              "TLAS instance 1: customIndex 16777216 or hitRecord 0 exceeds 24 bits");
    instances[1].customIndex = 0;
    instances[1].hitRecord = 0x1000000;
    EXPECT_EQ(testing::ErrorTextOf([&] { WriteInstances(instances, target); }),
              "TLAS instance 1: customIndex 0 or hitRecord 16777216 exceeds 24 bits");
    instances[1].hitRecord = 0;
    target.pop_back();
    EXPECT_EQ(testing::ErrorTextOf([&] { WriteInstances(instances, target); }),
              "2 TLAS instances do not fit 127 bytes");
}

}  // namespace
}  // namespace raygraph::rhi::tlas_test
