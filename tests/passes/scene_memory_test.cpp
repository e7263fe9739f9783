// A scene that does not fit the device, or is invalid, is refused, and the open one stays as it is.
#include <limits>

#include "rhi/texture_table.h"
#include "tests/rhi/fake_loader.h"
#include "tests/support/error_of.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

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

// What shaders read has at most 4 KiB on this device.
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

// What is in flight still uses the old scene when the empty one comes.
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
