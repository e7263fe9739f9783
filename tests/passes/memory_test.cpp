#include <limits>
#include <new>
#include <numeric>
#include <stdexcept>

#include "base/error.h"
#include "renderer/gpu_scene/deform/deform_set.h"
#include "renderer/gpu_scene/instances/draw_table.h"
#include "renderer/graph/pass_harness.h"
#include "rhi/device.h"
#include "rhi/texture_table.h"
#include "tests/rhi/fake_loader.h"
#include "tests/support/error_of.h"
#include "tests/support/failing_memory.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

// Exhausted host memory: an Error, and everything as before.
namespace raygraph::testing::out_of_memory_test {
namespace {

// The Error that `action` throws while allocations of more than `bytes` fail.
template <typename Action>
std::string MessageOf(size_t bytes, Action&& action) {
    return ErrorTextOf(
        [&] {
            const FailingMemory failing(bytes);
            action();
        },
        ErrorKind::OutOfMemory);
}

TEST(OutOfMemory, LeavesAsAnErrorThatNamesWhatWasAskedFor) {
    EXPECT_EQ(MessageOf(1000, [] { WithMemoryErrors("scene.gltf", [] { return std::vector<int>(1000); }); }),
              "scene.gltf: host memory is exhausted");
    EXPECT_EQ(MessageOf(1000,
                        [] {
                            WithMemoryErrors("scene.gltf", [] {
                                return std::vector<int>(std::vector<int>().max_size() + 1);
                            });
                        }),
              "scene.gltf: asks for more memory than a process can have");
}

// Without layers, which allocate on the same thread and do not expect to fail.
class OutOfMemoryTest : public ::testing::Test {
  protected:
    std::vector<int> kept;  // so that no compiler takes the allocation away
    std::unique_ptr<rhi::Device> device = rhi::Device::Create({.savePipelineCache = false});
    SceneRender render{*device};
    const passes::TraceSettings settings = LookAt({0, 0, 3}, {0, 0, 0}, 0.8f, 8);
};

TEST_F(OutOfMemoryTest, SetScene_LeavesTheSceneThatWasThere) {
    render.scene.SetScene(SceneOf({BoxMesh(0.5f)}, {Lambert(glm::vec3(0.5f), glm::vec3(1.0f))}));
    const FloatImage before = render.TraceOnce(settings);
    scene::SceneData large = SceneOf({SphereMesh(0.5f, 64)}, {Lambert(glm::vec3(0.5f), glm::vec3(3.0f))});
    EXPECT_EQ(MessageOf(16384, [&] { render.scene.SetScene(std::move(large)); }),
              "SetScene: host memory is exhausted");
    EXPECT_EQ(render.TraceOnce(settings).values, before.values);
    render.scene.SetScene(SceneOf({BoxMesh(0.5f)}, {Lambert(glm::vec3(0.5f), glm::vec3(2.0f))}));
    EXPECT_EQ(render.TraceOnce(settings).At(4, 4).x, 2.0f * before.At(4, 4).x);
}

// The names of lights are what is large here. The scene is so far off that its origin is elsewhere.
TEST_F(OutOfMemoryTest, SetScene_LeavesTheSceneThatWasThere_WhicheverAllocationFails) {
    render.scene.SetScene(SceneOf({BoxMesh(0.5f)}, {Lambert(glm::vec3(0.5f), glm::vec3(1.0f))}));
    const FloatImage before = render.TraceOnce(settings);
    size_t failureCount = 0;
    bool isSet = false;
    while (!isSet && failureCount < 20) {
        scene::SceneData far = SceneOf({BoxMesh(0.5f)}, {Lambert(glm::vec3(0.5f), glm::vec3(3.0f))},
                                       {Translation({5000, 0, 0})});
        far.lights.push_back({.name = std::string(200000, 'x')});
        try {
            const FailingMemory failing(100000, failureCount);
            render.scene.SetScene(std::move(far));
            isSet = true;
        } catch (const Error& error) {
            EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory);
            ++failureCount;
        }
        const FloatImage after = render.TraceOnce(settings);
        ASSERT_EQ(after.values == before.values, !isSet) << failureCount;
    }
    EXPECT_TRUE(isSet);
    EXPECT_GE(failureCount, 2u);
}

// A draw that is not a group's own would be culled and drawn as another, or freed while it is taken.
TEST_F(OutOfMemoryTest, NumbersOfDraws_StayAsTheyWere_WhicheverAllocationFails) {
    constexpr uint32_t kFew = 100, kMany = 1000;
    SceneGeometry geometry(*device);
    InstanceSet instances(*device, geometry, {});
    const auto add = [&](uint32_t group) {
        geometry.groups.emplace_back().triangleCount = 1;
        geometry.meshes.push_back({.firstGroup = group, .groupCount = 1});
        instances.AddMesh(group);
    };
    for (uint32_t group = 0; group < kFew; ++group) add(group);
    DrawTable draws(*device, geometry, instances);
    for (uint32_t group = kFew; group < kMany; ++group) {
        add(group);
        draws.Add(geometry.groups.back());
    }
    const auto numbers = [&] {
        std::vector<uint32_t> all;
        for (const GroupResources& group : geometry.groups) all.push_back(group.record.draw);
        return all;
    };
    const std::vector<uint32_t> before = numbers();
    EXPECT_EQ(before[kFew - 1], kFew - 1);
    EXPECT_EQ(before[kFew], gpu::kNotDrawn) << "there is room";
    size_t failureCount = 0;
    bool isNumbered = false;
    while (!isNumbered && failureCount < 50) {
        try {
            const FailingMemory failing(4000, failureCount);
            draws.Refresh(geometry, instances);
            isNumbered = true;
        } catch (const std::bad_alloc&) {
            ++failureCount;
            ASSERT_EQ(numbers(), before) << failureCount;
        }
    }
    EXPECT_GE(failureCount, 2u);
    std::vector<uint32_t> expected(kMany);
    std::iota(expected.begin(), expected.end(), 0u);
    EXPECT_EQ(numbers(), expected);
}

TEST_F(OutOfMemoryTest, Frame_IsDropped) {
    Renderer& renderer = render.renderer;
    const auto declare = [&](bool inSetup, bool inExecute) {
        renderer.BeginFrame();
        renderer.AddPass(
            "Allocates", PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.KeepAlive();
                if (inSetup) std::vector<int>(1000).swap(kept);
            },
            [this, inExecute](CommandList&) {
                if (inExecute) std::vector<int>(1000).swap(kept);
            });
        renderer.Execute();
    };
    // A frame keeps its memory for the one after the next, so that only the vector is as large as this.
    for (int frame = 0; frame < 3; ++frame) declare(false, false);
    EXPECT_EQ(MessageOf(3000, [&] { declare(true, false); }),
              R"(AddPass "Allocates": host memory is exhausted)");
    EXPECT_EQ(MessageOf(3000, [&] { declare(false, true); }), "Execute: host memory is exhausted");
    EXPECT_NO_THROW(declare(true, true));
}

}  // namespace
}  // namespace raygraph::testing::out_of_memory_test

// A scene that does not fit the device, or is invalid, is refused, and the open one stays as it is.
namespace raygraph::testing::scene_memory_test {

namespace {

constexpr uint32_t kMiss = 0xFFFFFFFFu;

// Which instance each of two pixels sees, looking down on x = -1 and 1.
std::array<uint32_t, 2> Seen(SceneRender& render) {
    scene::CameraView view = scene::CameraView::LookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = 2.0f;
    view.aspect = 2.0f;
    passes::TraceSettings settings;
    settings.extent = {2, 1};
    settings.camera = ToRecord(view);
    const SceneRender::Hits hits = render.PrimaryHits(settings);
    return {hits.ids[0].x, hits.ids[1].x};
}

scene::SceneData Sphere(float x, uint32_t rings) {
    return SceneOf({SphereMesh(0.4f, rings)}, {Lambert(glm::vec3(0.5f))}, {Translation({x, 0, 0})});
}

class SceneMemoryTest : public VulkanTest {
  protected:
    // At the end of a test that failed, too.
    ~SceneMemoryTest() override { Device().LimitMemory(0); }
    void LeaveMemory(uint64_t bytes) {
        Device().WaitIdle();
        Device().LimitMemory(Device().Memory().usedBytes + bytes);
    }

    SceneRender render{Device()};
};

class RefusedSceneTest : public VulkanTest {
  protected:
    RefusedSceneTest() { render.scene.SetScene(Sphere(-1.0f, 4)); }
    template <typename Call>
    std::string Message(Call&& call) {
        const Error error = ErrorOf(call);
        EXPECT_EQ(error.Kind(), ErrorKind::Usage);
        EXPECT_EQ(Seen(render), (std::array<uint32_t, 2>{0, kMiss}));
        return error.what();
    }

    SceneRender render{Device()};
};

// Buffers that shaders read have at most 4 KiB on this device.
class SceneLimitTest : public ::testing::Test {
  protected:
    SceneLimitTest() {
        loader.Tell().maxStorageBufferRange = 4096;
        rhi::DeviceDesc desc;
        desc.getInstanceProcAddr = loader.Entry();
        desc.savePipelineCache = false;
        device = rhi::Device::Create(desc);
    }
    // Rays that would measure which traversal is faster do not fit.
    static inline const GpuSceneDesc kDriver{.traversal = Traversal::Driver};

    static std::string Message(GpuScene& scene, scene::SceneData&& data, ErrorKind kind) {
        const Error error = ErrorOf([&] { scene.SetScene(std::move(data)); });
        EXPECT_EQ(error.Kind(), kind) << error.what();
        EXPECT_EQ(scene.Statistics().instanceCount, 0u);
        return error.what();
    }

    FakeLoader loader;
    std::unique_ptr<rhi::Device> device;
};

scene::ImageData Texel() {
    return {.name = "texel", .width = 1, .height = 1, .rgba = {255, 255, 255, 255}};
}

}  // namespace

// Its structures need most: a scene that has been set can be drawn by frames that take next to nothing.
TEST_F(SceneMemoryTest, SetScene_TakesWhatItsStructuresNeedOrLeavesTheOldScene) {
    render.scene.SetScene(Sphere(-1.0f, 4));
    const std::array<uint32_t, 2> oldScene{0, kMiss}, newScene{kMiss, 0};
    ASSERT_EQ(Seen(render), oldScene);
    constexpr uint64_t kStep = 512u << 10;
    constexpr uint64_t kOfFrames = 64u << 10;
    uint32_t failureCount = 0;
    for (bool isSet = false; !isSet && failureCount < 64;) {
        LeaveMemory(failureCount * kStep);
        try {
            render.scene.SetScene(Sphere(1.0f, 64));
            isSet = true;
        } catch (const Error& error) {
            EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory);
            ++failureCount;
        }
        LeaveMemory(kOfFrames);
        ASSERT_EQ(Seen(render), isSet ? newScene : oldScene) << failureCount;
        Device().LimitMemory(0);
    }
    EXPECT_GE(failureCount, 2u);
    for (int frame = 0; frame < 8; ++frame) EXPECT_EQ(Seen(render), newScene);
}

// Frames in flight still use the old scene when the empty one comes.
TEST_F(SceneMemoryTest, EmptyScene_MakesRoomForOneThatDidNotFitBesideTheOld) {
    constexpr uint64_t kStep = 512u << 10;
    const rhi::Buffer large = Device().CreateBuffer(
        {.name = "large", .size = 16u << 20, .usage = rhi::BufferUsage::CopyDestination});
    uint32_t failureCount = 0;
    bool hasRoom = false;  // after the last failure: that with most memory
    for (bool fitsBeside = false; !fitsBeside && failureCount < 64;) {
        render.scene.SetScene({});
        render.scene.SetScene(Sphere(-1.0f, 64));
        ASSERT_EQ(Seen(render), (std::array<uint32_t, 2>{0, kMiss}));
        LeaveMemory(failureCount * kStep + (64u << 10));
        try {
            render.scene.SetScene(Sphere(1.0f, 64));
            fitsBeside = true;
        } catch (const Error&) {
            ++failureCount;
            rhi::CommandList fills = Device().BeginCommands("in flight");
            for (uint32_t i = 0; i < 64; ++i) {
                fills.FullBarrier();
                fills.Fill(large, i);
            }
            Device().Submit(std::move(fills));
            render.scene.SetScene({});
            hasRoom = true;
            try {
                render.scene.SetScene(Sphere(1.0f, 64));
            } catch (const Error&) {
                hasRoom = false;
            }
        }
        Device().LimitMemory(0);
    }
    EXPECT_GE(failureCount, 2u);
    EXPECT_TRUE(hasRoom);
}

TEST_F(SceneMemoryTest, DataThatDidNotFitIsSpentAndRefused) {
    render.scene.SetScene(Sphere(-1.0f, 4));
    LeaveMemory(0);
    scene::SceneData data = Sphere(1.0f, 64);
    EXPECT_EQ(ErrorOf([&] { render.scene.SetScene(std::move(data)); }).Kind(), ErrorKind::OutOfMemory);
    Device().LimitMemory(0);
    EXPECT_STREQ(ErrorOf([&] { render.scene.SetScene(std::move(data)); }).what(),
                 "GpuScene: SetScene: instances[0]: mesh is 0, there are 0");
    EXPECT_EQ(Seen(render), (std::array<uint32_t, 2>{0, kMiss}));
}

// Rays come to look at its alpha, which needs another structure.
TEST_F(SceneMemoryTest, SetMaterial_TakesWhatItsStructuresNeedOrChangesNothing) {
    const std::array<uint32_t, 2> there{0, kMiss}, gone{kMiss, kMiss};
    render.scene.SetScene(Sphere(-1.0f, 64));
    for (int frame = 0; frame < 8; ++frame) ASSERT_EQ(Seen(render), there);
    scene::Material clear = Lambert(glm::vec3(0.5f));
    clear.alphaMode = scene::AlphaMode::Mask;
    clear.baseColorFactor.a = 0.0f;
    const SceneRevisions before = render.scene.Revisions();
    LeaveMemory(64u << 10);
    for (int attempt = 0; attempt < 2; ++attempt) {
        EXPECT_EQ(ErrorOf([&] { render.scene.SetMaterial(0, clear); }).Kind(), ErrorKind::OutOfMemory);
        EXPECT_EQ(render.scene.Revisions(), before);
        EXPECT_EQ(Seen(render), there);
    }
    Device().LimitMemory(0);
    render.scene.SetMaterial(0, clear);
    LeaveMemory(64u << 10);
    EXPECT_EQ(Seen(render), gone);
}

// The other texture is clear, so that a structure is needed whose rays look at alpha.
TEST_F(SceneMemoryTest, SwapTextures_TakesWhatItsStructuresNeedOrChangesNothing) {
    const std::array<uint32_t, 2> there{0, kMiss}, gone{kMiss, kMiss};
    scene::SceneData scene = Sphere(-1.0f, 64);
    scene.materials[0].alphaMode = scene::AlphaMode::Mask;
    scene.materials[0].baseColorTexture.texture = 0;
    scene.meshes[0].primitives[0].uv0.assign(scene.meshes[0].primitives[0].positions.size(), glm::vec2(0.5f));
    for (const uint8_t alpha : {uint8_t{255}, uint8_t{0}})
        scene.images.push_back({.name = "", .width = 1, .height = 1, .rgba = {9, 9, 9, alpha}});
    scene.textures = {{.name = "", .image = 0}, {.name = "", .image = 1}};
    render.scene.SetScene(std::move(scene));
    for (int frame = 0; frame < 8; ++frame) ASSERT_EQ(Seen(render), there);
    const std::vector<uint32_t> a{0}, b{1};
    const SceneRevisions before = render.scene.Revisions();
    LeaveMemory(64u << 10);
    for (int attempt = 0; attempt < 2; ++attempt) {
        EXPECT_EQ(ErrorOf([&] { render.scene.SwapTextures(a, b); }).Kind(), ErrorKind::OutOfMemory);
        EXPECT_EQ(render.scene.Revisions(), before);
        EXPECT_EQ(Seen(render), there);
    }
    Device().LimitMemory(0);
    render.scene.SwapTextures(a, b);
    LeaveMemory(64u << 10);
    EXPECT_EQ(Seen(render), gone);
}

TEST_F(RefusedSceneTest, TransformsThatAreNoPlaceAreRefused) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(Message([&] {
                  render.scene.SetTransform(0, Translation({nan, 0, 0}));
              }),
              "GpuScene: SetTransform: instance 0: its transform is not finite");
    glm::mat4x3 line(1.0f);
    line[1] = line[2] = glm::vec3(0.0f);
    EXPECT_EQ(Message([&] { render.scene.SetTransform(0, line); }),
              "GpuScene: SetTransform: instance 0: its transform is scaled to nothing or to a line");
    scene::SceneData scene = Sphere(1.0f, 4);
    scene.instances[0].objectToWorld = line;
    EXPECT_EQ(Message([&] { render.scene.SetScene(std::move(scene)); }),
              "GpuScene: SetScene: instances[0]: its transform is scaled to nothing or to a line");
}

TEST_F(RefusedSceneTest, IndicesThatPointNowhereAreRefused) {
    scene::SceneData scene = Sphere(1.0f, 4);
    scene.meshes[0].primitives[0].indices[5] = 100000;
    EXPECT_EQ(
        Message([&] { render.scene.SetScene(std::move(scene)); }),
        "GpuScene: SetScene: meshes[0].primitives[0]: indices[5] is 100000, but positions has 45 elements");
    scene::SceneData other = Sphere(1.0f, 4);
    other.instances[0].mesh = 3;
    EXPECT_EQ(Message([&] { render.scene.SetScene(std::move(other)); }),
              "GpuScene: SetScene: instances[0]: mesh is 3, there are 1");
}

TEST_F(RefusedSceneTest, MaterialsAndEnvironmentsThatAreNoLightAreRefused) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(Message([&] { render.scene.SetMaterial(0, Lambert(glm::vec3(nan))); }),
              "GpuScene: SetMaterial: material 0: baseColorFactor is nan, must be 0 to 1");
    EXPECT_EQ(Message([&] { render.scene.SetEnvironment({.radiance = glm::vec3(-1.0f)}); }),
              "GpuScene: SetEnvironment: radiance and rotation must be finite, radiance not negative");
}

TEST_F(SceneLimitTest, MoreLightsThanAShaderCanReadAreRefused) {
    Renderer renderer(*device);
    GpuScene gpu(renderer, kDriver);
    scene::SceneData scene;
    scene.lights.resize(200);
    const uint64_t most = 4096 / sizeof(gpu::LightRecord);
    EXPECT_EQ(Message(gpu, std::move(scene), ErrorKind::OutOfMemory),
              "GpuScene: 200 lights of " + std::to_string(sizeof(gpu::LightRecord)) +
                  " bytes, a shader can read " + std::to_string(most) + " on this device (4096 bytes)");
}

TEST_F(SceneLimitTest, MoreGeometriesAndInstancesThanAShaderCanReadAreRefused) {
    Renderer renderer(*device);
    GpuScene gpu(renderer, kDriver);
    scene::SceneData scene = SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))});
    scene.instances.resize(100, scene.instances[0]);
    EXPECT_NE(Message(gpu, std::move(scene), ErrorKind::OutOfMemory).find("GpuScene: 100 instances of "),
              std::string::npos);
    scene::SceneData split = SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))});
    split.meshes[0].primitives.resize(100, split.meshes[0].primitives[0]);
    EXPECT_NE(Message(gpu, std::move(split), ErrorKind::OutOfMemory).find("GpuScene: 100 geometries of "),
              std::string::npos);
    scene::SceneData painted = SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))});
    painted.materials.resize(100, painted.materials[0]);
    EXPECT_NE(Message(gpu, std::move(painted), ErrorKind::OutOfMemory).find("GpuScene: 100 materials of "),
              std::string::npos);
}

TEST_F(SceneLimitTest, MoreAndLargerTexturesThanTheDeviceHasAreRefused) {
    Renderer renderer(*device);
    GpuScene gpu(renderer, kDriver);
    scene::SceneData scene;
    scene.images = {Texel()};
    scene.textures.resize(rhi::kMaxTextureTableSlots + 1);
    EXPECT_EQ(Message(gpu, std::move(scene), ErrorKind::Usage),
              "GpuScene: 65537 textures, a shader can read 65536");
    const uint32_t side = device->Info().maxTextureExtent + 1;
    scene::SceneData wide;
    wide.images = {{.name = "wide", .width = side, .height = 1, .rgba = std::vector<uint8_t>(4 * side)}};
    wide.textures.resize(1);
    EXPECT_EQ(Message(gpu, std::move(wide), ErrorKind::Usage), "GpuScene: image 'wide' of " +
                                                                   std::to_string(side) +
                                                                   "x1 texels, the device's textures have at "
                                                                   "most " +
                                                                   std::to_string(side - 1) + " a side");
}

TEST_F(SceneLimitTest, SceneMayHaveAsManyTexturesAsAShaderCanRead) {
    Renderer renderer(*device);
    GpuScene gpu(renderer, kDriver);
    for (const size_t count : {size_t{1}, size_t{rhi::kMaxTextureTableSlots}, size_t{2}}) {
        scene::SceneData scene;
        scene.images = {Texel()};
        scene.textures.resize(count);
        EXPECT_NO_THROW(gpu.SetScene(std::move(scene)));
        EXPECT_EQ(gpu.Statistics().textureBytes, 4u) << "all are one image, with one sampler";
    }
}

TEST_F(SceneLimitTest, TexturesShareAnImageUnlessItDiffersOnTheDevice) {
    Renderer renderer(*device);
    GpuScene gpu(renderer, {.textureLevels = true, .traversal = Traversal::Driver});
    const auto bytes = [&](const scene::Texture& other) {
        scene::SceneData scene;
        scene.images = {Texel(), Texel()};
        scene.textures = {{}, other};
        gpu.SetScene(std::move(scene));
        return gpu.Statistics().textureBytes;
    };
    scene::Texture other;
    other.sampler.wrapU = scene::WrapMode::ClampToEdge;
    other.sampler.magFilter = scene::FilterMode::Nearest;
    EXPECT_EQ(bytes(other), 4u) << "another sampler";
    other.image = 1;
    EXPECT_EQ(bytes(other), 8u) << "another image";
    other = {};
    other.colorSpace =
        other.colorSpace == scene::ColorSpace::Srgb ? scene::ColorSpace::Linear : scene::ColorSpace::Srgb;
    EXPECT_EQ(bytes(other), 8u) << "another color space";
    other = {};
    other.sampler.usesMips = !other.sampler.usesMips;
    EXPECT_EQ(bytes(other), 8u) << "another number of levels";
}

}  // namespace raygraph::testing::scene_memory_test

// A frame that fails while it is recorded leaves nothing behind: the next one shows, and counts, what it
// would have without it.
namespace raygraph::testing::dropped_frame_test {

using passes::Accumulation;
using passes::ResetCause;

namespace {

// A pass after all others that cannot be recorded.
void AddFailingPass(Renderer& renderer) {
    renderer.AddPass(
        "Fails", PassKind::Transfer, [](PassBuilder& pass) { pass.KeepAlive(); },
        [](CommandList&) { throw std::runtime_error("the pass fails"); });
}

// Orthographic, looking down on x = -1, 0, 1.
passes::TraceSettings ThreePixels() {
    scene::CameraView view = scene::CameraView::LookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = 1.0f;
    view.aspect = 3.0f;
    passes::TraceSettings settings;
    settings.extent = {3, 1};
    settings.camera = ToRecord(view);
    return settings;
}

constexpr uint32_t kMiss = 0xFFFFFFFFu;
using Seen3 = std::array<uint32_t, 3>;

Seen3 Seen(SceneRender& render) {
    const SceneRender::Hits hits = render.PrimaryHits(ThreePixels());
    return {hits.ids[0].x, hits.ids[1].x, hits.ids[2].x};
}

// Both scenes get the same edits; one has a failing frame before each good one.
class DroppedSceneFrameTest : public VulkanTest {
  protected:
    static void Fail(SceneRender& render) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.Declare();
        const Readback radiance =
            render.renderer.ReadBack(passes::Trace(render.renderer, ids, ThreePixels()).radiance);
        AddFailingPass(render.renderer);
        EXPECT_THROW(render.renderer.Execute(), std::runtime_error);
    }
    // A good frame of each; returns what both have seen.
    Seen3 Frame() {
        const Seen3 expected = Seen(undisturbed);
        Fail(disturbed);
        EXPECT_EQ(Seen(disturbed), expected);
        ExpectSameStatistics();
        return expected;
    }
    void Settle() {
        for (int frame = 0; frame < 8; ++frame) {
            Seen(undisturbed);
            Seen(disturbed);
        }
        ASSERT_TRUE(undisturbed.scene.IsSettled());
        ASSERT_TRUE(disturbed.scene.IsSettled());
    }
    template <typename Edit>
    void Both(Edit&& edit) {
        edit(undisturbed.scene);
        edit(disturbed.scene);
    }
    void ExpectSameStatistics() {
        const GpuSceneStatistics& expected = undisturbed.scene.Statistics();
        const GpuSceneStatistics& actual = disturbed.scene.Statistics();
        EXPECT_EQ(actual.blasBuilds, expected.blasBuilds);
        EXPECT_EQ(actual.blasCount, expected.blasCount);
        EXPECT_EQ(actual.blasBytesBuilt, expected.blasBytesBuilt);
        EXPECT_EQ(actual.tlasRebuilds, expected.tlasRebuilds);
        EXPECT_EQ(actual.tlasUpdates, expected.tlasUpdates);
        EXPECT_EQ(actual.lastTlasWork, expected.lastTlasWork) << Name(actual.lastTlasWork);
    }
    static scene::SceneData TwoBoxes() {
        return SceneOf({BoxMesh(0.3f), BoxMesh(0.3f)}, {Lambert(glm::vec3(0.5f), glm::vec3(1.0f))},
                       {Translation({-1, 0, 0}), Translation({1, 0, 0})});
    }

    SceneRender undisturbed{Device()};
    SceneRender disturbed{Device()};
};

class DroppedAccumulationTest : public VulkanTest {
  protected:
    static constexpr Extent2D kExtent{2, 1};

    Texels Add(float value, bool withVariance = false, Extent2D extent = kExtent, bool fails = false) {
        return harness.Run([&](PassHarness& h) {
            const TextureId sample = h.Texture("sample", extent, Format::Rgba32Float, {value, 0, 0, 1});
            const passes::AccumulatedIds ids =
                passes::Accumulate(h.Graph(), sample, accumulation, withVariance);
            if (fails) AddFailingPass(h.Graph());
            return ids.mean;
        });
    }
    void FailToAdd(float value, bool withVariance = false, Extent2D extent = kExtent) {
        EXPECT_THROW(Add(value, withVariance, extent, true), std::runtime_error);
    }

    PassHarness harness{Device()};
    Accumulation accumulation{"image"};
};

}  // namespace

TEST_F(DroppedSceneFrameTest, BuildsAreRecordedAgain) {
    Both([](GpuScene& scene) { scene.SetScene(TwoBoxes()); });
    EXPECT_EQ(Frame(), (Seen3{0, kMiss, 1}));
    Settle();
    ExpectSameStatistics();
}

TEST_F(DroppedSceneFrameTest, MovedInstancesStayMoved) {
    Both([](GpuScene& scene) { scene.SetScene(TwoBoxes()); });
    Settle();
    Both([](GpuScene& scene) { scene.SetTransform(1, Translation({0, 0, 0})); });
    EXPECT_EQ(Frame(), (Seen3{0, 1, kMiss}));
    EXPECT_EQ(disturbed.scene.Statistics().lastTlasWork, TlasWork::Update);
}

TEST_F(DroppedSceneFrameTest, HiddenInstancesStayHidden) {
    Both([](GpuScene& scene) { scene.SetScene(TwoBoxes()); });
    Settle();
    Both([](GpuScene& scene) { scene.SetVisible(0, false); });
    EXPECT_EQ(Frame(), (Seen3{kMiss, kMiss, 1}));
}

TEST_F(DroppedSceneFrameTest, LastTlasWorkIsThatOfTheLastSubmittedFrame) {
    Both([](GpuScene& scene) { scene.SetScene(TwoBoxes()); });
    Settle();
    Both([](GpuScene& scene) { scene.SetTransform(1, Translation({0, 0, 0})); });
    EXPECT_EQ(Frame(), (Seen3{0, 1, kMiss}));
    Fail(disturbed);  // would have had nothing to do
    EXPECT_EQ(disturbed.scene.Statistics().lastTlasWork, TlasWork::Update);
}

TEST_F(DroppedSceneFrameTest, ChangedMaterialsStayChanged) {
    Both([](GpuScene& scene) {
        scene.SetScene(SceneOf({QuadMesh(5.0f)}, {Lambert(glm::vec3(0.0f), glm::vec3(1.0f))}));
    });
    Settle();
    Both([](GpuScene& scene) { scene.SetMaterial(0, Lambert(glm::vec3(0.0f), glm::vec3(4.0f))); });
    Fail(disturbed);
    EXPECT_EQ(glm::vec3(disturbed.TraceOnce(ThreePixels()).At(0, 0)), glm::vec3(4.0f));
    EXPECT_EQ(glm::vec3(undisturbed.TraceOnce(ThreePixels()).At(0, 0)), glm::vec3(4.0f));
}

TEST_F(DroppedAccumulationTest, SampleIsNotCounted) {
    Add(2.0f);
    FailToAdd(100.0f);
    EXPECT_EQ(accumulation.SampleCount(), 1u);
    EXPECT_EQ(Add(4.0f).At(0, 0)[0], 3.0f);
    EXPECT_EQ(accumulation.SampleCount(), 2u);
}

TEST_F(DroppedAccumulationTest, FirstVarianceOfADroppedFrameKeepsTheSamples) {
    Add(2.0f);
    FailToAdd(100.0f, true);
    EXPECT_EQ(accumulation.ResetCount(ResetCause::Settings), 0u);
    EXPECT_EQ(Add(4.0f).At(0, 0)[0], 3.0f);
    EXPECT_EQ(accumulation.SampleCount(), 2u);
}

TEST_F(DroppedAccumulationTest, ResizeOfADroppedFrameKeepsTheSamples) {
    Add(2.0f);
    FailToAdd(100.0f, false, {5, 5});
    EXPECT_EQ(accumulation.ResetCount(ResetCause::Resize), 0u);
    EXPECT_EQ(Add(4.0f).At(0, 0)[0], 3.0f);
    EXPECT_EQ(accumulation.SampleCount(), 2u);
}

TEST_F(DroppedAccumulationTest, RestoreOfADroppedFrameRestoresNothing) {
    passes::ExactSums stored = passes::MakeExactSums(2, false);
    for (int n = 0; n < 5; ++n) passes::AddSample(stored, std::vector<float>(8, 9.0f));
    const auto restore = [&](bool fails) {
        harness.Run([&](PassHarness& h) {
            passes::Restore(h.Graph(), accumulation, kExtent, 5, stored);
            if (fails) AddFailingPass(h.Graph());
            return h.Texture("nothing", {1, 1}, Format::R32Float, {0.0f});
        });
    };
    Add(2.0f);
    EXPECT_THROW(restore(true), std::runtime_error);
    EXPECT_EQ(accumulation.SampleCount(), 1u);
    EXPECT_EQ(Add(4.0f).At(0, 0)[0], 3.0f);
    restore(false);
    EXPECT_EQ(accumulation.SampleCount(), 5u);
    EXPECT_EQ(Add(3.0f).At(0, 0)[0], 8.0f);
}

TEST_F(DroppedAccumulationTest, ResetAfterTheDeclarationIsKept) {
    Add(2.0f);
    harness.Run([&](PassHarness& h) {
        const TextureId sample = h.Texture("sample", kExtent, Format::Rgba32Float, {4, 0, 0, 1});
        const passes::AccumulatedIds ids = passes::Accumulate(h.Graph(), sample, accumulation);
        accumulation.Reset(ResetCause::Camera);
        return ids.mean;
    });
    EXPECT_EQ(accumulation.SampleCount(), 0u) << "the frame's sample joined what was given up";
    EXPECT_EQ(Add(7.0f).At(0, 0)[0], 7.0f);
    EXPECT_EQ(accumulation.SampleCount(), 1u);
}

}  // namespace raygraph::testing::dropped_frame_test
