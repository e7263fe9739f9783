#include <gtest/gtest.h>
#include <cmath>

#include "base/text.h"
#include "rhi/device.h"
#include "rhi/pipeline.h"
#include "rhi/shader_compiler.h"
#include "tests/rhi/trace_test.h"
#include "tests/support/error_of.h"
#include "tests/support/source_file.h"

// Tests that every ray type, hit set and callable reaches its own shaders with its own record.
namespace raygraph::rhi::ray_tracing_pipeline_test {
namespace {

using RayTracingPipelineTest = TraceTest;

std::vector<std::byte> Record(const std::vector<uint32_t>& words) {
    const auto bytes = std::as_bytes(std::span(words));
    return {bytes.begin(), bytes.end()};
}

TestRay Ray(float x, RayType type) {
    return {.origin = {x, 0.1f, -4.0f}, .type = type};
}

std::vector<uint32_t> Codes(const std::vector<TestResult>& results) {
    std::vector<uint32_t> codes;
    for (const TestResult& result : results) codes.push_back(result.code);
    return codes;
}

TEST_F(RayTracingPipelineTest, EachRayTypeReachesItsOwnMissAndHitOfEachHitSet) {
    std::vector<HitGroupSet> sets(2, HitGroupSet(kRayTypeCount));
    sets[0][RayType::Radiance].closestHit = ClosestHit("set0.radiance", 10);
    sets[0][RayType::Shadow].closestHit = ClosestHit("set0.shadow", 11);
    sets[1][RayType::Radiance].closestHit = ClosestHit("set1.radiance", 20);
    sets[1][RayType::Shadow].closestHit = ClosestHit("set1.shadow", 21);
    const RayTracingPipeline pipeline =
        CreateRayTracingPipeline(Device(), {.name = "types",
                                            .rayGen = {RayGen(), {}},
                                            .miss = {{Miss("radiance", 1), {}}, {Miss("shadow", 2), {}}},
                                            .hitSets = sets});
    EXPECT_GT(pipeline.CreationMs(), 0.0);

    const std::shared_ptr<Blas> blas = Build(Describe(Quad(0, 0)));
    std::vector<TlasInstance> instances{Instance(*blas, 0), Instance(*blas, 10)};
    instances[0].customIndex = 7;
    instances[1].customIndex = 0xfffffe;
    instances[1].hitRecord = kRayTypeCount;
    const Tlas tlas = BuildTlas(instances);
    const std::vector<TestResult> results =
        Trace(pipeline, tlas,
              {Ray(0, RayType::Radiance), Ray(0, RayType::Shadow), Ray(10, RayType::Radiance),
               Ray(10, RayType::Shadow), Ray(5, RayType::Radiance), Ray(5, RayType::Shadow)});
    EXPECT_EQ(Codes(results), (std::vector<uint32_t>{10, 11, 20, 21, 1, 2}));
    EXPECT_EQ(results[0].instance, 7u);
    EXPECT_EQ(results[3].instance, 0xfffffeu);
    EXPECT_FLOAT_EQ(results[0].distance, 4.0f);
}

TEST_F(RayTracingPipelineTest, RecordsCarryTheirOwnDataWhateverItsSize) {
    const ShaderStage hit = Compile("record.rchit", R"(
        layout(shaderRecordEXT, scalar) buffer Record { uint code; uint extra[4]; };
        void main() { payload = Payload(code, extra[3], gl_PrimitiveID, gl_HitTEXT); })");
    const ShaderStage miss = Compile("record.rmiss", R"(
        layout(shaderRecordEXT, scalar) buffer Record { uint code; };
        void main() { payload.code = code; })");
    const ShaderStage rayGen = Compile("record.rgen", R"(
        layout(shaderRecordEXT, scalar) buffer Record { uint scale; uint offset; };
        void main() {
            Ray ray = rays[gl_LaunchIDEXT.x];
            traceRayEXT(tlas, 0, 0xff, ray.type, 0, ray.type, ray.origin, 0.0, ray.direction, 1e9, 0);
            payload.code = payload.code * scale + offset;
            results[gl_LaunchIDEXT.x] = payload;
        })");
    std::vector<HitGroupSet> sets(3, HitGroupSet(kRayTypeCount));
    for (uint32_t set = 0; set < sets.size(); ++set)
        for (RayType type : {RayType::Radiance, RayType::Shadow}) {
            HitGroup& group = sets[set][type];
            group.closestHit = hit;
            const uint32_t code = 100 + 10 * set + static_cast<uint32_t>(type);
            group.recordData = Record({code, 0, 0, 0, code * 2});
        }
    const RayTracingPipeline pipeline = CreateRayTracingPipeline(
        Device(), {.name = "records",
                   .rayGen = {rayGen, Record({1000, 5})},
                   .miss = {{miss, Record({3})}, {miss, Record({4, 0, 0, 0, 0, 0, 0, 0, 0})}},
                   .hitSets = sets});

    const std::shared_ptr<Blas> blas = Build(Describe(Quad(0, 0)));
    std::vector<TlasInstance> instances;
    std::vector<TestRay> rays{Ray(5, RayType::Radiance), Ray(5, RayType::Shadow)};
    std::vector<uint32_t> expected{3005, 4005};
    for (uint32_t set = 0; set < sets.size(); ++set) {
        const float x = 10.0f * static_cast<float>(set);
        instances.push_back(Instance(*blas, x));
        instances.back().hitRecord = set * kRayTypeCount;
        for (RayType type : {RayType::Radiance, RayType::Shadow}) {
            rays.push_back(Ray(x, type));
            expected.push_back((100 + 10 * set + static_cast<uint32_t>(type)) * 1000 + 5);
        }
    }
    const std::vector<TestResult> results = Trace(pipeline, BuildTlas(instances), rays);
    EXPECT_EQ(Codes(results), expected);
    EXPECT_EQ(results[2].instance, 200u) << "the end of the record's data";
    EXPECT_EQ(results[7].instance, 242u);
}

TEST_F(RayTracingPipelineTest, CallablesAreReachedByTheirPlaceWithTheirRecords) {
    const ShaderStage rayGen = Compile("call.rgen", R"(
        layout(location = 1) callableDataEXT uint number;
        void main() {
            Ray ray = rays[gl_LaunchIDEXT.x];
            traceRayEXT(tlas, 0, 0xff, ray.type, 0, ray.type, ray.origin, 0.0, ray.direction, 1e9, 0);
            number = payload.code;
            executeCallableEXT(ray.value, 1);
            payload.code = number;
            results[gl_LaunchIDEXT.x] = payload;
        })");
    const ShaderStage add = Compile("add.rcall", R"(
        layout(shaderRecordEXT, scalar) buffer Record { uint term; };
        layout(location = 1) callableDataInEXT uint number;
        void main() { number += term; })");
    const ShaderStage twice = Compile("twice.rcall", R"(
        layout(location = 1) callableDataInEXT uint number;
        void main() { number *= 2; })");
    const RayTracingPipeline pipeline = CreateRayTracingPipeline(
        Device(), {.name = "callables",
                   .rayGen = {rayGen, {}},
                   .miss = {{Miss("m", 50), {}}, {Miss("m", 60), {}}},
                   .callables = {{add, Record({1})}, {twice, {}}, {add, Record({7, 0, 0})}}});
    std::vector<TestRay> rays(4, Ray(5, RayType::Radiance));
    for (uint32_t i = 0; i < 3; ++i) rays[i].value = i;
    rays[3].value = 1;
    rays[3].type = RayType::Shadow;
    const std::shared_ptr<Blas> blas = Build(Describe(Quad(0, 0)));
    EXPECT_EQ(Codes(Trace(pipeline, BuildTlas({Instance(*blas)}), rays)),
              (std::vector<uint32_t>{51, 100, 57, 120}));
}

TEST_F(RayTracingPipelineTest, GeometriesOfAnInstanceShareItsHitSetOrTakeOneEachByTheStrideOfTheTrace) {
    const ShaderStage rayGen = Compile("stride.rgen", R"(
        void main() {
            Ray ray = rays[gl_LaunchIDEXT.x];
            traceRayEXT(tlas, 0, 0xff, ray.type, ray.value, ray.type, ray.origin, 0.0, ray.direction, 1e9, 0);
            results[gl_LaunchIDEXT.x] = payload;
        })");
    std::vector<HitGroupSet> sets(3, HitGroupSet(kRayTypeCount));
    for (uint32_t set = 0; set < sets.size(); ++set)
        for (RayType type : {RayType::Radiance, RayType::Shadow})
            sets[set][type].closestHit =
                ClosestHit("set" + std::to_string(set), 10 * set + static_cast<uint32_t>(type));
    const RayTracingPipeline pipeline =
        CreateRayTracingPipeline(Device(), {.name = "stride", .rayGen = {rayGen, {}}, .hitSets = sets});
    BlasDesc desc = Describe(Quad(0, 0));
    desc.triangles.push_back(Geometry(Quad(4, 0)));
    const std::shared_ptr<Blas> blas = Build(desc);
    TlasInstance instance = Instance(*blas);
    instance.hitRecord = kRayTypeCount;
    std::vector<TestRay> rays;
    for (uint32_t stride : {0u, kRayTypeCount})
        for (float x : {0.0f, 4.0f})
            for (RayType type : {RayType::Radiance, RayType::Shadow}) {
                rays.push_back(Ray(x, type));
                rays.back().value = stride;
            }
    EXPECT_EQ(Codes(Trace(pipeline, BuildTlas({instance}), rays)),
              (std::vector<uint32_t>{10, 11, 10, 11, 10, 11, 20, 21}));
}

TEST_F(RayTracingPipelineTest, AnyHitRunsForNonOpaqueGeometryAlone) {
    const ShaderStage ignore = Compile("ignore.rahit", R"(
        void main() { if (gl_PrimitiveID < 2) ignoreIntersectionEXT; })");
    HitGroupSet set(kRayTypeCount);
    set[RayType::Radiance] = {.closestHit = ClosestHit("hit", 1), .anyHit = ignore};
    set[RayType::Shadow] = {.closestHit = ClosestHit("hit", 2)};
    const RayTracingPipeline pipeline = CreateRayTracingPipeline(
        Device(),
        {.name = "any hit", .rayGen = {RayGen(), {}}, .miss = {{Miss("m", 9), {}}}, .hitSets = {set}});

    TestMesh mesh = Quad(0, 0);
    const TestMesh behind = Quad(0, 1);
    mesh.vertices.insert(mesh.vertices.end(), behind.vertices.begin(), behind.vertices.end());
    for (uint32_t index : behind.indices) mesh.indices.push_back(index + 4);
    const std::shared_ptr<Blas> cut = Build(Describe(mesh, BlasKind::Static, false));
    const std::shared_ptr<Blas> opaque = Build(Describe(mesh, BlasKind::Static, true));
    const std::vector<TestResult> results =
        Trace(pipeline, BuildTlas({Instance(*cut, 0), Instance(*opaque, 10)}),
              {Ray(0, RayType::Radiance), Ray(0, RayType::Shadow), Ray(10, RayType::Radiance)});
    EXPECT_FLOAT_EQ(results[0].distance, 5.0f) << "any-hit lets the ray through the front";
    EXPECT_GE(results[0].primitive, 2u);
    EXPECT_FLOAT_EQ(results[1].distance, 4.0f) << "the other ray type has no any-hit shader";
    EXPECT_FLOAT_EQ(results[2].distance, 4.0f) << "opaque geometry never runs any-hit";
}

TEST_F(RayTracingPipelineTest, IntersectionShaderDecidesWhereABoxIsHit) {
    const ShaderStage sphere = Compile("sphere.rint", R"(
        layout(shaderRecordEXT, scalar) buffer Record { float radius; };
        hitAttributeEXT vec3 normal;
        void main() {
            vec3 o = gl_ObjectRayOriginEXT - vec3(0.0, 0.0, float(gl_PrimitiveID) * 4.0);
            vec3 d = gl_ObjectRayDirectionEXT;
            float b = dot(o, d);
            float c = dot(o, o) - radius * radius;
            float h = b * b - dot(d, d) * c;
            if (h < 0.0) return;
            float t = (-b - sqrt(h)) / dot(d, d);
            normal = (o + t * d) / radius;
            reportIntersectionEXT(t, 3u);
        })");
    const ShaderStage hit = Compile("sphere.rchit", R"(
        hitAttributeEXT vec3 normal;
        void main() {
            payload = Payload(gl_HitKindEXT, floatBitsToUint(normal.z), gl_PrimitiveID, gl_HitTEXT);
        })");
    HitGroupSet set(kRayTypeCount);
    for (HitGroup& group : set)
        group = {.closestHit = hit, .anyHit = {}, .intersection = sphere, .recordData = {}};
    const float radius = 0.5f;
    for (HitGroup& group : set) group.recordData = Record({std::bit_cast<uint32_t>(radius)});
    const RayTracingPipeline pipeline = CreateRayTracingPipeline(
        Device(),
        {.name = "boxes", .rayGen = {RayGen(), {}}, .miss = {{Miss("m", 9), {}}}, .hitSets = {set}});

    const std::vector<VkAabbPositionsKHR> boxes{{-1, -1, -1, 1, 1, 1}, {-1, -1, 3, 1, 1, 5}};
    const Buffer buffer = Upload("boxes", boxes, BufferUsage::BuildInput);
    const std::shared_ptr<Blas> blas =
        Build({.name = "boxes", .triangles = {}, .aabbs = {{.boxes = buffer.Address(), .boxCount = 2}}});
    const std::vector<TestResult> results =
        Trace(pipeline, BuildTlas({Instance(*blas)}),
              {{.origin = {0, 0, -4}}, {.origin = {0, 0, 2}}, {.origin = {0.8f, 0, -4}}});
    EXPECT_EQ(results[0].code, 3u);
    EXPECT_FLOAT_EQ(results[0].distance, 3.5f);
    EXPECT_EQ(results[0].primitive, 0u);
    EXPECT_FLOAT_EQ(std::bit_cast<float>(results[0].instance), -1.0f) << "hit attribute";
    EXPECT_FLOAT_EQ(results[1].distance, 1.5f);
    EXPECT_EQ(results[1].primitive, 1u);
    EXPECT_EQ(results[2].code, 9u) << "in the box, past the sphere";
}

TEST_F(RayTracingPipelineTest, GroupsWithOneIntersectionShaderHaveAnyHitShadersOfTheirOwn) {
    const ShaderStage box = Compile("box.rint", R"(
        hitAttributeEXT vec3 unused;
        void main() { reportIntersectionEXT(2.0 + float(gl_PrimitiveID), 0u); })");
    const ShaderStage ignoring =
        Compile("ignoring.rahit", "hitAttributeEXT vec3 unused; void main() { ignoreIntersectionEXT; }");
    const ShaderStage second = Compile("second.rahit", R"(
        hitAttributeEXT vec3 unused;
        void main() { if (gl_PrimitiveID == 0) ignoreIntersectionEXT; })");
    const std::vector<VkAabbPositionsKHR> boxes{{-1, -1, -1, 1, 1, 1}, {-1, -1, 3, 1, 1, 5}};
    const Buffer buffer = Upload("boxes", boxes, BufferUsage::BuildInput);
    const std::shared_ptr<Blas> blas =
        Build({.name = "boxes",
               .triangles = {},
               .aabbs = {{.boxes = buffer.Address(), .boxCount = 2, .isOpaque = false}}});
    const auto traced = [&](const ShaderStage& ofRadiance, const ShaderStage& ofShadow) {
        HitGroupSet set(kRayTypeCount);
        set[RayType::Radiance] = {ClosestHit("hit", 1), ofRadiance, box, {}};
        set[RayType::Shadow] = {ClosestHit("hit", 1), ofShadow, box, {}};
        const RayTracingPipeline pipeline =
            CreateRayTracingPipeline(Device(), {.name = "one intersection",
                                                .rayGen = {RayGen(), {}},
                                                .miss = {{Miss("m", 9), {}}, {Miss("m", 9), {}}},
                                                .hitSets = {set}});
        std::vector<uint32_t> seen;
        for (const TestResult& result : Trace(pipeline, BuildTlas({Instance(*blas)}),
                                              {Ray(0, RayType::Radiance), Ray(0, RayType::Shadow)}))
            seen.push_back(result.code == 9 ? 9 : result.primitive);
        return seen;
    };
    EXPECT_EQ(traced({}, ignoring), (std::vector<uint32_t>{0, 9}));
    EXPECT_EQ(traced(ignoring, {}), (std::vector<uint32_t>{9, 0}));
    EXPECT_EQ(traced(second, ignoring), (std::vector<uint32_t>{1, 9}));
    EXPECT_EQ(traced(ignoring, second), (std::vector<uint32_t>{9, 1}));
}

TEST_F(RayTracingPipelineTest, GroupsThatAreNotGivenRunNothing) {
    std::vector<HitGroupSet> sets(1, HitGroupSet(1));
    sets[0][RayType::Radiance].closestHit = ClosestHit("hit", 1);
    const RayTracingPipeline pipeline = CreateRayTracingPipeline(
        Device(),
        {.name = "sparse", .rayGen = {RayGen(), {}}, .miss = {{}, {Miss("shadow", 2), {}}}, .hitSets = sets});
    const std::shared_ptr<Blas> blas = Build(Describe(Quad(0, 0)));
    const Tlas tlas = BuildTlas({Instance(*blas)});
    EXPECT_EQ(Codes(Trace(pipeline, tlas,
                          {Ray(0, RayType::Radiance), Ray(0, RayType::Shadow), Ray(5, RayType::Radiance),
                           Ray(5, RayType::Shadow)})),
              (std::vector<uint32_t>{1, kUntouched, kUntouched, 2}));

    const RayTracingPipeline bare =
        CreateRayTracingPipeline(Device(), {.name = "bare", .rayGen = {RayGen(), {}}, .miss = {{}, {}}});
    EXPECT_EQ(bare.Table().hit.recordCount, kRayTypeCount);
    EXPECT_EQ(Codes(Trace(bare, tlas, {Ray(0, RayType::Radiance), Ray(5, RayType::Shadow)})),
              (std::vector<uint32_t>{kUntouched, kUntouched}));
}

TEST_F(RayTracingPipelineTest, SetsOfTheTable_ShareTheirGroups) {
    const ShaderStage hit = Compile("record.rchit", R"(
        layout(shaderRecordEXT, scalar) buffer Record { uint code; };
        void main() { payload.code = code; })");
    std::vector<HitGroupSet> sets(2, HitGroupSet(kRayTypeCount));
    sets[0][RayType::Radiance] = {.closestHit = hit, .recordData = Record({10})};
    sets[1][RayType::Radiance] = {.closestHit = hit, .recordData = Record({20})};
    sets[1][RayType::Shadow] = {.closestHit = hit, .recordData = Record({21})};
    const std::vector<uint32_t> table{1, 0, 0, 1, 0};
    const RayTracingPipeline pipeline =
        CreateRayTracingPipeline(Device(), {.name = "shared",
                                            .rayGen = {RayGen(), {}},
                                            .miss = {{Miss("m", 9), {}}, {Miss("m", 9), {}}},
                                            .hitSets = sets,
                                            .tableSets = table});
    EXPECT_EQ(pipeline.Table().hit.recordCount, 5 * kRayTypeCount);

    const std::shared_ptr<Blas> blas = Build(Describe(Quad(0, 0)));
    const std::vector<VkAabbPositionsKHR> boxes{{-1, -1, -1, 1, 1, 1}};
    const Buffer buffer = Upload("boxes", boxes, BufferUsage::BuildInput);
    const std::shared_ptr<Blas> boxBlas =
        Build({.name = "boxes", .triangles = {}, .aabbs = {{.boxes = buffer.Address(), .boxCount = 1}}});
    std::vector<TlasInstance> instances;
    std::vector<TestRay> rays;
    std::vector<uint32_t> expected;
    for (uint32_t set = 0; set < table.size(); ++set) {
        const float x = 10.0f * static_cast<float>(set);
        instances.push_back(Instance(*blas, x));
        instances.back().hitRecord = set * kRayTypeCount;
        rays.insert(rays.end(), {Ray(x, RayType::Radiance), Ray(x, RayType::Shadow)});
        expected.insert(expected.end(), {table[set] == 1 ? 20u : 10u, table[set] == 1 ? 21u : kUntouched});
    }
    instances.push_back(Instance(*boxBlas, -10));
    instances.back().hitRecord = kRayTypeCount;
    rays.push_back(Ray(-10, RayType::Shadow));
    expected.push_back(9);
    EXPECT_EQ(Codes(Trace(pipeline, BuildTlas(instances), rays)), expected)
        << "a record without shaders is for triangles and boxes; these are not hit";
}

TEST_F(RayTracingPipelineTest, SpecializationReachesEveryStage) {
    const std::string head =
        "layout(constant_id = 3) const uint kBase = 1;\nlayout(constant_id = 4) const float kScale = 1;\n";
    const ShaderStage hit =
        Compile("special.rchit", head + "void main() { payload.code = kBase + uint(kScale); }");
    const ShaderStage miss = Compile("special.rmiss", head + "void main() { payload.code = kBase * 2; }");
    HitGroupSet set(kRayTypeCount);
    set[RayType::Radiance].closestHit = hit;
    RayTracingPipelineDesc desc{
        .name = "special", .rayGen = {RayGen(), {}}, .miss = {{miss, {}}}, .hitSets = {set}};
    const std::shared_ptr<Blas> blas = Build(Describe(Quad(0, 0)));
    const Tlas tlas = BuildTlas({Instance(*blas)});
    const std::vector<TestRay> rays{Ray(0, RayType::Radiance), Ray(5, RayType::Radiance)};
    EXPECT_EQ(Codes(Trace(CreateRayTracingPipeline(Device(), desc), tlas, rays)),
              (std::vector<uint32_t>{2, 2}));
    desc.specialization = {{3, 40}, {4, std::bit_cast<uint32_t>(6.0f)}};
    EXPECT_EQ(Codes(Trace(CreateRayTracingPipeline(Device(), desc), tlas, rays)),
              (std::vector<uint32_t>{46, 80}));
}

TEST_F(RayTracingPipelineTest, ClosestHitMayTraceWhenRecursionIsAskedFor) {
    if (Device().Info().maxRayRecursionDepth < 2) GTEST_SKIP() << "maxRayRecursionDepth is 1";
    const ShaderStage hit = Compile("again.rchit", R"(
        layout(binding = 0) uniform accelerationStructureEXT tlas;
        layout(location = 1) rayPayloadEXT Payload shadow;
        void main() {
            vec3 p = gl_WorldRayOriginEXT + gl_HitTEXT * gl_WorldRayDirectionEXT;
            shadow.code = 0;
            traceRayEXT(tlas, gl_RayFlagsSkipClosestHitShaderEXT | gl_RayFlagsTerminateOnFirstHitEXT, 0xff,
                        kRayTypeShadow, 0, kRayTypeShadow, p, 0.01, gl_WorldRayDirectionEXT, 1e9, 1);
            payload.code = 10 + shadow.code;
        })");
    const ShaderStage lit = Compile("lit.rmiss", R"(
        void main() { payload.code = 1; })");
    HitGroupSet set(kRayTypeCount);
    set[RayType::Radiance].closestHit = hit;
    const RayTracingPipeline pipeline = CreateRayTracingPipeline(Device(), {.name = "recursive",
                                                                            .rayGen = {RayGen(), {}},
                                                                            .miss = {{}, {lit, {}}},
                                                                            .hitSets = {set},
                                                                            .maxRecursion = 2});
    const std::shared_ptr<Blas> blas = Build(Describe(Quad(0, 0)));
    const Tlas tlas = BuildTlas({Instance(*blas, 0), Instance(*blas, 0, 2), Instance(*blas, 10)});
    EXPECT_EQ(Codes(Trace(pipeline, tlas, {Ray(0, RayType::Radiance), Ray(10, RayType::Radiance)})),
              (std::vector<uint32_t>{10, 11}));
}

TEST_F(RayTracingPipelineTest, WhatCannotBeIsRefusedByName) {
    RayTracingPipelineDesc desc{.name = "wrong", .rayGen = {RayGen(), {}}};
    auto error = [&] {
        return testing::ErrorTextOf([&] { (void)CreateRayTracingPipeline(Device(), desc); });
    };
    ASSERT_EQ(error(), "accepted");

    desc.specialization = {{12, 1}};
    EXPECT_EQ(error(), "wrong: specialization constant 12 is in none of its shaders, which have none");
    desc.specialization.clear();

    desc.rayGen.stage = Miss("m", 1);
    EXPECT_EQ(error(), "wrong: m.rmiss is a miss shader, given as ray generation shader");
    desc.rayGen.stage = {};
    EXPECT_EQ(error(), "wrong: has no ray-generation shader");
    desc.rayGen.stage = RayGen();

    desc.hitSets = {HitGroupSet(kRayTypeCount)};
    desc.hitSets[0][RayType::Shadow].anyHit = ClosestHit("h", 1);
    EXPECT_EQ(error(), "wrong: h.rchit is a closest hit shader, given as any hit shader");
    desc.hitSets[0] = HitGroupSet(kRayTypeCount);

    desc.hitSets[0][RayType::Shadow].closestHit = Compile("clash.rchit", R"(
        layout(binding = 2) uniform sampler2D sky;
        void main() {})");
    EXPECT_EQ(error(),
              "wrong: shaders disagree: trace.rgen has storage buffer 'Results' at binding 2, clash.rchit "
              "has sampled "
              "image 'sky' at binding 2");
    desc.hitSets[0] = HitGroupSet(kRayTypeCount);

    desc.maxRecursion = Device().Info().maxRayRecursionDepth + 1;
    EXPECT_NE(error().find("wrong: maxRecursion"), std::string::npos);
    desc.maxRecursion = 1;

    desc.hitSets[0][RayType::Radiance].recordData.resize(Device().Info().maxShaderGroupStride + 1);
    EXPECT_NE(error().find("wrong: shader binding table: a record of"), std::string::npos) << error();
    desc.hitSets.clear();

    desc.tableSets = {0, 1};
    EXPECT_EQ(error(), "wrong: its table has hit set 1 of 1");
    desc.tableSets.clear();

    desc.callables.resize(1);
    EXPECT_EQ(error(), "wrong: has an empty callable shader");
}

TEST_F(RayTracingPipelineTest, BindingsOfAllStagesAreFoundByName) {
    HitGroupSet set(kRayTypeCount);
    set[RayType::Radiance].closestHit = Compile("bind.rchit", R"(
        layout(binding = 5, scalar) readonly buffer Materials { vec3 colors[]; };
        layout(push_constant) uniform Constants { uint a; uint b; uint c; };
        void main() { payload.distance = colors[b].x; })");
    const RayTracingPipeline pipeline =
        CreateRayTracingPipeline(Device(), {.name = "bind", .rayGen = {RayGen(), {}}, .hitSets = {set}});
    ASSERT_EQ(pipeline.Bindings().size(), 4u);
    const BindingInfo* materials = pipeline.Find("Materials");
    ASSERT_NE(materials, nullptr);
    EXPECT_EQ(materials->binding, 5u);
    EXPECT_EQ(materials->stages, VkShaderStageFlags{VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR});
    EXPECT_EQ(materials->elementBytes, 12u);
    EXPECT_EQ(pipeline.Find("tlas")->kind, BindingKind::AccelerationStructure);
    EXPECT_TRUE(pipeline.Find("Results")->isWritable);
    EXPECT_EQ(pipeline.Find("absent"), nullptr);
    EXPECT_EQ(pipeline.PushConstantBytes(), 12u);
    EXPECT_FALSE(pipeline.UsesTextureTable());
}

}  // namespace
}  // namespace raygraph::rhi::ray_tracing_pipeline_test

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
