#include <gtest/gtest.h>
#include <array>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "passes/scene_bindings.h"
#include "renderer/graph/readback_values.h"
#include "rhi/blas_builder.h"
#include "rhi/command_list.h"
#include "rhi/shader_compiler.h"
#include "rhi/tlas.h"
#include "rhi/transfer.h"
#include "tests/passes/cell_scenes.h"
#include "tests/support/error_of.h"
#include "tests/support/scene_render.h"
#include "tests/support/source_file.h"
#include "tests/support/vulkan_test.h"

// Passes of a host that trace the scene: ray types, hit groups, masks and a TLAS of its own.
namespace raygraph::testing::host_rays_test {
namespace {

// The host's names for its ray types, of which each shader has the same.
constexpr RayType kPicking = RayType::Host0, kAudio = RayType::Host5;
constexpr const char* kHostRayTypes = R"(
#include "shared/ray_types.h"
const uint kRayTypePicking = kRayTypeHost0;
const uint kRayTypeAudio = kRayTypeHost5;
)";

struct Answer {
    uint32_t code = 0;  // of the shader that ran; 0: none
    uint32_t instance = 0;
    float distance = 0.0f;
};
constexpr uint32_t kMissed = 1;
constexpr uint32_t kCellCount = 8, kMaskCount = 256;
constexpr float kSurface = 4.7f;  // distance of the boxes' and spheres' tops from where rays start

std::string Head(const char* payload) {
    return std::string(R"(#version 460
#extension GL_GOOGLE_include_directive : require
#include "scene/extensions.glsl"
#include "scene/bindings.glsl")") +
           kHostRayTypes +
           "struct Answer { uint code; uint instance; float distance; };\nlayout(location = 0) " + payload +
           " Answer answer;\n";
}

// One ray down each cell with each mask: invocation (cell, mask).
constexpr const char* kRayGen = R"(
layout(set = 0, binding = 16, scalar) writeonly buffer Answers { Answer at[]; } answers;
layout(push_constant, scalar) uniform Constants { uint rayType; uint flags; } constants;
void main() {
    uint type = constants.rayType;
    vec3 origin = vec3(float(gl_LaunchIDEXT.x) + 0.5, 0.5, 5.0);
    answer = Answer(0u, 0u, -1.0);
    traceRayEXT(sceneTlas, constants.flags, gl_LaunchIDEXT.y, type, 0u, type, origin, 0.0, vec3(0.0, 0.0, -1.0),
                100.0, 0);
    answers.at[gl_LaunchIDEXT.y * gl_LaunchSizeEXT.x + gl_LaunchIDEXT.x] = answer;
})";

// The nearer of what both structures have.
constexpr const char* kBothRayGen = R"(
layout(set = 0, binding = 16, scalar) writeonly buffer Answers { Answer at[]; } answers;
layout(set = 0, binding = 17) uniform accelerationStructureEXT hostTlas;
Answer Down(accelerationStructureEXT tlas, vec3 origin) {
    answer = Answer(0u, 0u, -1.0);
    traceRayEXT(tlas, 0u, 0xFFu, kRayTypePicking, 0u, kRayTypePicking, origin, 0.0, vec3(0.0, 0.0, -1.0), 100.0, 0);
    return answer;
}
void main() {
    vec3 origin = vec3(float(gl_LaunchIDEXT.x) + 0.5, 0.5, 5.0);
    Answer ours = Down(sceneTlas, origin);
    Answer theirs = Down(hostTlas, origin);
    bool isOurs = ours.distance >= 0.0 && (theirs.distance < 0.0 || ours.distance < theirs.distance);
    answers.at[gl_LaunchIDEXT.x] = isOurs ? ours : theirs;
})";

// A row of cells, seen from above, with a thing in each but the last two.
class HostRays : public VulkanTest {
  protected:
    HostRays() {
        scene::SceneData scene =
            SceneOf({BoxMesh(0.3f), BoxWithLeaf(), RoundSphere(0.3f)},
                    {Lambert(glm::vec3(0.5f), glm::vec3(0.1f)), Lambert(glm::vec3(0.8f))});
        scene.materials[1].alphaMode = scene::AlphaMode::Mask;
        scene.instances.clear();
        for (const uint32_t mesh : {0u, 0u, 1u, 2u, 2u, 0u}) {
            const auto index = static_cast<uint32_t>(scene.instances.size());
            isRound.push_back(mesh == 2);
            hostMask.push_back(kMaskHost);
            cellOf.push_back(index);
            scene.instances.push_back({.mesh = mesh, .objectToWorld = Translation(CellCenter(index, 100))});
        }
        render.scene.SetScene(std::move(scene));
        const auto add = [&](const std::string& name, const std::string& text) {
            render.renderer.AddShader(
                name,
                rhi::CompileGlsl({.name = name, .text = text, .includeRoot = test::SourceFile("shaders")}));
        };
        add("host/down.rgen", Head("rayPayloadEXT") + kRayGen);
        add("host/both.rgen", Head("rayPayloadEXT") + kBothRayGen);
        add("host/nothing.rmiss",
            Head("rayPayloadInEXT") + "void main() { answer.code = " + std::to_string(kMissed) + "u; }");
        for (const auto& [name, code] : std::initializer_list<std::pair<std::string, uint32_t>>{
                 {"picked", 10}, {"chosen", 13}, {"last", 25}, {"heard", 33}})
            add("host/" + name + ".rchit",
                Head("rayPayloadInEXT") + "void main() { answer = Answer(" + std::to_string(code) +
                    "u, instances.at[gl_InstanceCustomIndexEXT].instance, gl_HitTEXT); }");
        add("host/own.rchit",
            Head("rayPayloadInEXT") +
                "void main() { answer = Answer(50u, gl_InstanceCustomIndexEXT, gl_HitTEXT); }");
        add("host/pass.rahit", Head("rayPayloadInEXT") + "void main() { ignoreIntersectionEXT; }");
    }

    // By mask, then by cell. `setsAnyHit`: hit set 3 lets picking rays pass.
    std::vector<Answer> Ask(RayType rayType = kPicking, bool setsAnyHit = false) {
        Renderer& renderer = render.renderer;
        renderer.BeginFrame();
        const SceneIds scene = render.scene.Declare(renderer);
        BufferId answers =
            renderer.CreateBuffer("answers", {.size = kCellCount * kMaskCount * sizeof(Answer)});
        renderer.AddPass(
            "Ask", PassKind::RayTracing,
            [&](PassBuilder& pass) {
                pass.RayGen("host/down.rgen");
                pass.Miss(kPicking, "host/nothing.rmiss").Miss(kAudio, "host/nothing.rmiss");
                passes::BindHits(pass, scene, kPicking, {.closestHit = "host/picked.rchit"});
                passes::BindHits(pass, scene, kAudio, {.closestHit = "host/heard.rchit"}, 3);
                pass.Reads("sceneTlas", scene.tlas);
                pass.ReadsByAddress(scene.blases);  // the TLAS references them

                // Round primitives read these, and the hit shaders the instances
                passes::BindGeometry(pass, scene);
                passes::BindMaterials(pass, scene);
                passes::BindHits(
                    pass, scene, kPicking,
                    {.closestHit = "host/chosen.rchit", .anyHit = setsAnyHit ? "host/pass.rahit" : ""}, 3);
                passes::BindHits(pass, scene, kPicking, {.closestHit = "host/last.rchit"},
                                 kHitSetNumbers - 1);
                answers = pass.Writes("answers", answers);
                const uint32_t kNoOpaque = 2;  // gl_RayFlagsNoOpaqueEXT
                pass.Constants(std::array{static_cast<uint32_t>(rayType), setsAnyHit ? kNoOpaque : 0u});
            },
            [](CommandList& commands) {
                commands.TraceRays({kCellCount, kMaskCount});
            });
        const Readback readback = renderer.ReadBack(answers);
        renderer.Execute();
        return WaitForValues<Answer>(readback);
    }
    // The codes that rays with all bits find, by cell.
    std::vector<uint32_t> Codes(RayType rayType = kPicking, bool setsAnyHit = false) {
        const std::vector<Answer> answers = Ask(rayType, setsAnyHit);
        std::vector<uint32_t> codes;
        for (const Answer& answer : std::span(answers).last(kCellCount)) codes.push_back(answer.code);
        return codes;
    }
    // Rays with any mask meet the instances that share a bit, and no others.
    void ExpectMasks() {
        const std::vector<Answer> answers = Ask();
        for (uint32_t mask = 0; mask < kMaskCount; ++mask) {
            std::vector<uint32_t> expected(kCellCount, kMiss), seen;
            for (uint32_t i = 0; i < cellOf.size(); ++i) {
                const uint32_t bits = (isRound[i] ? kMaskRound : kMaskTriangles) | hostMask[i];
                if (render.scene.IsVisible(i) && (bits & mask) != 0) expected[cellOf[i]] = i;
            }
            for (uint32_t cell = 0; cell < kCellCount; ++cell) {
                const Answer& answer = answers[mask * kCellCount + cell];
                seen.push_back(answer.code == kMissed ? kMiss : answer.instance);
                if (answer.code != kMissed) {
                    ASSERT_NEAR(answer.distance, kSurface, 1e-5f);
                }
            }
            ASSERT_EQ(seen, expected) << "mask " << mask;
        }
    }
    void SetMask(uint32_t instance, uint8_t mask) {
        render.scene.SetHostMask(instance, mask);
        hostMask[instance] = mask;
    }
    void Move(uint32_t instance, uint32_t cell) {
        render.scene.SetTransform(instance, Translation(CellCenter(cell, 100)));
        cellOf[instance] = cell;
    }
    // After compaction, which rebuilds the TLAS, a change updates it.
    void Settle() {
        for (int frame = 0; frame < 8; ++frame) Ask();
        ASSERT_TRUE(render.scene.IsSettled());
    }
    TlasWork LastWork() { return render.scene.Statistics().lastTlasWork; }

    SceneRender render{Device(), {.traversal = Traversal::Driver}};
    std::vector<bool> isRound;
    std::vector<uint8_t> hostMask;
    std::vector<uint32_t> cellOf;
};

}  // namespace

TEST_F(HostRays, EachInstance_AnswersThroughTheShadersOfItsHitSet) {
    Settle();
    EXPECT_EQ(Codes(), (std::vector<uint32_t>{10, 10, 10, 10, 10, 10, kMissed, kMissed}));
    EXPECT_EQ(Codes(kAudio), (std::vector<uint32_t>{0, 0, 0, kMissed, kMissed, 0, kMissed, kMissed}))
        << "without a group, triangles run nothing and spheres are not hit";
    GpuScene& scene = render.scene;
    scene.SetHitSet(1, 3);                   // a box
    scene.SetHitSet(2, kHitSetNumbers - 1);  // two groups of triangles
    scene.SetHitSet(4, 3);                   // a sphere
    scene.SetHitSet(5, 7);                   // of which the pass knows nothing
    EXPECT_EQ(Codes(), (std::vector<uint32_t>{10, 13, 25, 10, 13, 10, kMissed, kMissed}));
    EXPECT_EQ(LastWork(), TlasWork::Update);
    EXPECT_EQ(Codes(kAudio), (std::vector<uint32_t>{0, 33, 0, kMissed, 33, 0, kMissed, kMissed}));
    EXPECT_EQ(LastWork(), TlasWork::None);
    EXPECT_EQ(Codes(kPicking, true),
              (std::vector<uint32_t>{10, kMissed, 25, 10, kMissed, 10, kMissed, kMissed}));
    scene.SetHitSet(1, 0);
    scene.SetHitSet(3, 3);
    Move(2, 6);
    EXPECT_EQ(Codes(), (std::vector<uint32_t>{10, 10, kMissed, 13, 13, 10, 25, kMissed}));
    EXPECT_EQ(scene.HitSet(3), 3u);
}

TEST_F(HostRays, Masks_TellWhatRaysMeetWhateverBecomesOfTheScene) {
    Settle();
    ExpectMasks();
    SetMask(1, 0x04);
    SetMask(2, 0x18);
    SetMask(3, 0x00);
    SetMask(4, 0x04);
    SetMask(5, 0x80);
    ExpectMasks();
    EXPECT_EQ(LastWork(), TlasWork::Update);
    SetMask(5, 0x80);
    ExpectMasks();
    EXPECT_EQ(LastWork(), TlasWork::None) << "nothing has changed";
    Move(5, 7);
    Move(1, 5);
    ExpectMasks();
    EXPECT_EQ(LastWork(), TlasWork::Update);
    GpuScene& scene = render.scene;
    scene.SetVisible(4, false);
    ExpectMasks();
    SetMask(4, 0x40);
    ExpectMasks();
    EXPECT_EQ(LastWork(), TlasWork::None) << "it is invisible";
    scene.SetVisible(4, true);
    ExpectMasks();

    // The groups of the meshes change, and their structures
    scene::Material material = Lambert(glm::vec3(0.5f));
    material.isDoubleSided = !material.isDoubleSided;
    scene.SetMaterial(0, material);
    ExpectMasks();
    EXPECT_EQ(LastWork(), TlasWork::Rebuild);
    scene.RemoveInstance(1);
    const uint32_t added = scene.AddInstance(0, {Translation(CellCenter(1, 100))});
    ASSERT_EQ(added, 1u);
    hostMask[1] = kMaskHost;
    cellOf[1] = 1;
    ExpectMasks();
    EXPECT_EQ(scene.HitSet(1), 0u);

    SetMask(1, 0x08);
    scene.SetHitSet(1, 3);
    scene.SetScene(SceneOf({BoxMesh(0.3f), RoundSphere(0.3f)}, {Lambert(glm::vec3(0.5f))},
                           {Translation(CellCenter(0, 100)), Translation(CellCenter(1, 100))}));
    hostMask.assign(2, kMaskHost);
    isRound = {false, true};
    cellOf = {0, 1};
    ExpectMasks();
    EXPECT_EQ(Codes()[1], 10u);
}

// Each of Raygraph's tables has the groups for whatever hit set, and its rays meet all that is visible.
TEST_F(HostRays, PathTracedPicture_KeepsItsBits) {
    GpuScene& scene = render.scene;
    scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    render.more |= kTraceThinWalls;  // with shadow rays of their own type
    passes::TraceSettings settings = LookAt({3, -3, 4}, {3, 0.5f, 0}, 1.2f, 48);
    settings.traversal = Traversal::Driver;
    Settle();
    const FloatImage before = render.TraceOnce(settings);
    const SceneRevisions revisions = scene.Revisions();
    for (uint32_t i = 0; i < 6; ++i) {
        scene.SetHitSet(i, (3 * i + 1) % kHitSetNumbers);
        scene.SetHostMask(i, i % 2 == 0 ? 0 : 0x10);
    }
    const FloatImage after = render.TraceOnce(settings);
    EXPECT_EQ(LastWork(), TlasWork::Update);
    EXPECT_EQ(before.values, after.values);
    EXPECT_EQ(scene.Revisions(), revisions) << "nothing that accumulates restarts";
    scene.SetVisible(2, false);
    EXPECT_NE(render.TraceOnce(settings).values, before.values);
}

TEST_F(HostRays, WrongValues_ChangeNothing) {
    GpuScene& scene = render.scene;
    const std::vector<uint32_t> beyond{0, 6};
    EXPECT_EQ(ErrorTextOf([&] { scene.SetHostMask(beyond, 0x04); }),
              "GpuScene: instance 6 does not exist; the scene has 6");
    EXPECT_EQ(ErrorTextOf([&] { scene.SetHitSet(beyond, 1); }),
              "GpuScene: instance 6 does not exist; the scene has 6");
    EXPECT_EQ(ErrorTextOf([&] { scene.SetHostMask(0, 0x05); }),
              "GpuScene: SetHostMask: 0x05 has bits that are not the host's, 0xfc");
    EXPECT_EQ(ErrorTextOf([&] { scene.SetHitSet(0, kHitSetNumbers); }),
              "GpuScene: SetHitSet: 16 is beyond the last number, 15");
    EXPECT_EQ(ErrorTextOf([&] { static_cast<void>(scene.HostMask(6)); }),
              "GpuScene: instance 6 does not exist; the scene has 6");
    EXPECT_EQ(scene.HostMask(0), kMaskHost);
    EXPECT_EQ(scene.HitSet(0), 0u);
    ExpectMasks();
    render.renderer.BeginFrame();
    static_cast<void>(scene.Declare(render.renderer));
    EXPECT_EQ(ErrorTextOf([&] { scene.SetHostMask(0, 0x04); }),
              "GpuScene: SetHostMask between Declare and Execute; it comes before Declare or after Execute");
    render.renderer.DropFrame();
}

// A frame that is dropped leaves a change for the next one.
TEST_F(HostRays, DroppedFrame_KeepsTheChangePending) {
    Settle();
    SetMask(0, 0x20);
    render.renderer.BeginFrame();
    static_cast<void>(render.scene.Declare(render.renderer));
    render.renderer.DropFrame();
    ExpectMasks();
    EXPECT_EQ(LastWork(), TlasWork::Update);
}

TEST_F(HostRays, HostsTlas_IsTracedBesideTheScenes) {
    // Squares of the host: over cells 2 to 4 at z = 2, and under cells 5 and 6 at z = -1
    const std::vector<float> positions{1.9f, -9, 2,  4.9f, -9, 2,  4.9f, 9, 2,  1.9f, 9, 2,
                                       4.9f, -9, -1, 6.9f, -9, -1, 6.9f, 9, -1, 4.9f, 9, -1};
    const std::vector<uint32_t> indices{0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
    const uint64_t positionBytes = positions.size() * sizeof(float);
    const rhi::Buffer geometry =
        Device().CreateBuffer({.name = "the host's geometry",
                               .size = positionBytes + indices.size() * sizeof(uint32_t),
                               .usage = rhi::BufferUsage::BuildInput | rhi::BufferUsage::CopyDestination});
    rhi::Uploader uploader(Device());
    uploader.UploadBuffer(geometry, 0, BytesOf(positions));
    uploader.UploadBuffer(geometry, positionBytes, BytesOf(indices));
    uploader.Flush();
    rhi::BlasBuilder builder(Device());
    const std::shared_ptr<rhi::Blas> blas =
        builder.Add({.name = "the host's",
                     .triangles = {{.vertices = geometry.Address(),
                                    .vertexCount = 8,
                                    .indices = geometry.Address() + positionBytes,
                                    .triangleCount = 4}}});
    const rhi::Buffer instances = Device().CreateBuffer({.name = "the host's instances",
                                                         .size = rhi::kTlasInstanceBytes,
                                                         .usage = rhi::BufferUsage::BuildInput,
                                                         .memory = rhi::MemoryKind::Upload});
    rhi::Tlas owner(Device(), {.name = "the host's", .capacity = 1});
    rhi::CommandList commands = Device().BeginCommands("the host's");
    builder.RecordBuilds(commands);
    rhi::TlasInstance instance{.customIndex = 7, .blas = blas->Address()};
    instance.hitRecord = FirstHitRecord(HitSetOf(1));  // of the pass's groups
    rhi::WriteInstances(std::span(&instance, 1), instances.Mapped());
    owner.Build(commands, instances, 1);
    Device().WaitFor(Device().Submit(std::move(commands)));

    const rhi::Tlas wrapped = Device().WrapTlas("the host's", owner.Handle());
    ResourceState state;
    Renderer& renderer = render.renderer;
    renderer.BeginFrame();
    const SceneIds scene = render.scene.Declare(renderer);
    const TlasId theirs = renderer.Import("the host's", wrapped, state);
    BufferId answers = renderer.CreateBuffer("answers", {.size = kCellCount * sizeof(Answer)});
    renderer.AddPass(
        "Both", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen("host/both.rgen").Miss(kPicking, "host/nothing.rmiss");
            passes::BindHits(pass, scene, kPicking, {.closestHit = "host/picked.rchit"});
            pass.HitGroup(kPicking, {.closestHit = "host/own.rchit"}, HitSetOf(1));  // of the host's TLAS
            pass.Reads("sceneTlas", scene.tlas);
            pass.ReadsByAddress(scene.blases);
            pass.Reads("hostTlas", theirs);
            passes::BindGeometry(pass, scene);
            passes::BindMaterials(pass, scene);
            answers = pass.Writes("answers", answers);
        },
        [](CommandList& recorded) {
            recorded.TraceRays({kCellCount, 1});
        });
    const Readback readback = renderer.ReadBack(answers);
    renderer.Execute();
    const std::vector<Answer> seen = WaitForValues<Answer>(readback);
    const std::vector<Answer> expected{{10, 0, kSurface}, {10, 1, kSurface},  {50, 7, 3.0f},
                                       {50, 7, 3.0f},     {50, 7, 3.0f},      {10, 5, kSurface},
                                       {50, 7, 6.0f},     {kMissed, 0, -1.0f}};
    for (uint32_t cell = 0; cell < kCellCount; ++cell) {
        EXPECT_EQ(seen[cell].code, expected[cell].code) << cell;
        EXPECT_EQ(seen[cell].instance, expected[cell].instance) << cell;
        EXPECT_NEAR(seen[cell].distance, expected[cell].distance, 1e-5f) << cell;
    }
}

}  // namespace raygraph::testing::host_rays_test
