// Meshes and textures that a host has on the device: they are seen without a copy, and follow what the host
// makes of them.
#include "renderer/gpu_scene/host_objects.h"

#include "rhi/blas_builder.h"
#include "rhi/upload.h"
#include "tests/support/error_of.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::host_objects_test {
namespace {

constexpr uint32_t kMiss = 0xFFFFFFFFu;

// Two triangles as the host has them: in one buffer, indices last.
struct Square {
    std::array<glm::vec3, 4> positions;
    std::array<glm::vec3, 4> normals;
    std::array<glm::vec2, 4> uv;
    std::array<uint32_t, 6> indices{0, 1, 2, 0, 2, 3};

    explicit Square(float x) {
        positions = {glm::vec3(x - 0.4f, -0.4f, 0), glm::vec3(x + 0.4f, -0.4f, 0),
                     glm::vec3(x + 0.4f, 0.4f, 0), glm::vec3(x - 0.4f, 0.4f, 0)};
        normals.fill(glm::normalize(glm::vec3(0.3f, 0.0f, 1.0f)));
        uv = {glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0), glm::vec2(0, 0)};
    }
    scene::Bounds Bounds() const {
        scene::Bounds bounds;
        for (const glm::vec3& position : positions) bounds.Extend(position);
        return bounds;
    }
};

// Pixels at x = -1.5, -0.5, 0.5 and 1.5, seen from above.
class HostObjects : public VulkanTest {
  protected:
    HostObjects() {
        render.scene.SetScene(
            SceneOf({QuadMesh(0.4f)}, {Lambert(glm::vec3(0.5f))}, {Translation({-1.5f, 0, 0})}));
        buffer = Device().CreateBuffer({.name = "of the host",
                                        .size = sizeof(Square),
                                        .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::BuildInput |
                                                 rhi::BufferUsage::CopyDestination});
        Write(Square(-0.5f));
    }
    void Write(const Square& square) {
        uploader.UploadBuffer(buffer, 0, std::as_bytes(std::span(&square, 1)));
        uploader.Flush();
    }
    HostMesh Mesh(uint32_t material = 0) const {
        return {.name = "square",
                .vertexCount = 4,
                .triangleCount = 2,
                .positions = {&buffer, offsetof(Square, positions)},
                .indices = {&buffer, offsetof(Square, indices)},
                .normals = {&buffer, offsetof(Square, normals)},
                .uv0 = {&buffer, offsetof(Square, uv)},
                .material = material,
                .bounds = Square(-0.5f).Bounds()};
    }
    SceneRender::Hits Hits() {
        scene::CameraView view = scene::CameraView::LookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
        view.projection = scene::Projection::Orthographic;
        view.height = 1.0f;
        view.aspect = 4.0f;
        passes::TraceSettings settings;
        settings.extent = {4, 1};
        settings.camera = ToRecord(view);
        return render.PrimaryHits(settings);
    }
    std::array<uint32_t, 4> Seen() {
        const SceneRender::Hits hits = Hits();
        return {hits.ids[0].x, hits.ids[1].x, hits.ids[2].x, hits.ids[3].x};
    }

    SceneRender render{Device()};
    rhi::Uploader uploader{Device()};
    rhi::Buffer buffer;
};

using Cells = std::array<uint32_t, 4>;

}  // namespace

TEST_F(HostObjects, VerticesAreSeenWhereTheHostHasThem) {
    const uint64_t bytes = render.scene.Statistics().geometryBytes;
    const uint32_t mesh = render.scene.AddMesh(Mesh());
    const uint32_t instance = render.scene.AddInstance(mesh, scene::PlacedTransform{});
    const SceneRender::Hits hits = Hits();
    EXPECT_EQ(hits.ids[1].x, instance);
    EXPECT_NEAR(glm::vec3(hits.normal.values[1]).x, Square(0).normals[0].x, 1e-3f);
    EXPECT_EQ(render.scene.Statistics().geometryBytes, bytes) << "nothing is copied";
    const uint32_t second = render.scene.AddInstance(mesh, scene::PlacedTransform{Translation({2.0f, 0, 0})});
    EXPECT_EQ(Seen(), (Cells{0, instance, kMiss, second}));
    render.scene.RemoveInstance(instance);
    render.scene.RemoveInstance(second);
    render.scene.RemoveMesh(mesh);
    EXPECT_EQ(Seen(), (Cells{0, kMiss, kMiss, kMiss}));
}

TEST_F(HostObjects, ChangedVerticesAreFollowed) {
    for (const bool isDeforming : {false, true}) {
        SCOPED_TRACE(isDeforming);
        Write(Square(-0.5f));
        HostMesh described = Mesh();
        described.isDeforming = isDeforming;
        const uint32_t mesh = render.scene.AddMesh(described);
        const uint32_t instance = render.scene.AddInstance(mesh, scene::PlacedTransform{});
        EXPECT_EQ(Seen(), (Cells{0, instance, kMiss, kMiss}));
        const GpuSceneStatistics before = render.scene.Statistics();
        for (const float x : {0.5f, 1.5f, -0.5f, 1.5f}) {
            Write(Square(x));
            render.scene.MarkChanged(mesh, Square(x).Bounds());
            Cells expected{0, kMiss, kMiss, kMiss};
            expected[static_cast<size_t>(x + 2.0f)] = instance;
            EXPECT_EQ(Seen(), expected) << x;
        }
        const GpuSceneStatistics after = render.scene.Statistics();
        EXPECT_EQ(after.blasRebuilds - before.blasRebuilds, isDeforming ? 4u : 0u);
        EXPECT_EQ(after.blasBuilds - before.blasBuilds, isDeforming ? 0u : 4u);
        render.scene.RemoveInstance(instance);
        render.scene.RemoveMesh(mesh);
    }
}

// The scene's tables have no room for it before the first frame.
TEST_F(HostObjects, VerticesMayChangeBeforeTheFirstFrame) {
    const uint32_t mesh = render.scene.AddMesh(Mesh());
    Write(Square(0.5f));
    render.scene.MarkChanged(mesh, Square(0.5f).Bounds());
    const uint32_t instance = render.scene.AddInstance(mesh, scene::PlacedTransform{});
    EXPECT_EQ(Seen(), (Cells{0, kMiss, instance, kMiss}));
    EXPECT_FALSE(Square(0.5f).Bounds().IsEmpty());
}

TEST_F(HostObjects, ItsOwnStructureIsTraced) {
    rhi::BlasBuilder builder(Device(), {.compacts = false});
    rhi::BlasDesc desc;
    desc.triangles.push_back({.vertices = buffer.Address() + offsetof(Square, positions),
                              .vertexCount = 4,
                              .indices = buffer.Address() + offsetof(Square, indices),
                              .triangleCount = 2});
    const std::shared_ptr<rhi::Blas> blas = builder.Add(desc);
    rhi::CommandList commands = Device().BeginCommands("host");
    builder.RecordBuilds(commands);
    commands.FullBarrier();
    Device().Submit(std::move(commands));

    HostMesh described = Mesh();
    described.blas = blas->Address();
    EXPECT_EQ(Seen(), (Cells{0, kMiss, kMiss, kMiss}));
    const uint32_t built = render.scene.Statistics().blasCount;
    const uint32_t mesh = render.scene.AddMesh(described);
    const uint32_t instance = render.scene.AddInstance(mesh, scene::PlacedTransform{});
    EXPECT_EQ(Seen(), (Cells{0, instance, kMiss, kMiss}));
    EXPECT_EQ(render.scene.Statistics().blasCount, built);
    // Its geometry is opaque, as it was built
    scene::Material clear = Lambert(glm::vec3(0.5f));
    clear.alphaMode = scene::AlphaMode::Blend;
    clear.baseColorFactor.a = 0.0f;
    EXPECT_EQ(ErrorTextOf([&] { render.scene.SetMaterial(0, clear); }),
              "GpuScene: SetMaterial: a host's own BLAS cannot become one that rays test for alpha, or the "
              "other way round");
    EXPECT_EQ(Seen(), (Cells{0, instance, kMiss, kMiss}));
    Device().WaitIdle();
}

TEST_F(HostObjects, ItsTextureIsRead) {
    auto texture = std::make_shared<rhi::Texture>(
        Device().CreateTexture({.name = "of the host", .extent = {2, 1}, .format = rhi::Format::Rgba8Unorm}));
    const std::array<uint8_t, 8> texels{255, 0, 0, 255, 0, 255, 0, 255};
    uploader.UploadTexture(*texture, std::as_bytes(std::span(texels)));
    uploader.Flush();
    const uint32_t number = render.scene.AddTexture(HostTexture{
        .texture = texture, .sampler = {.magFilter = scene::FilterMode::Nearest}, .lowestAlpha = 1.0f});
    scene::Material material = Lambert(glm::vec3(1.0f));
    material.baseColorTexture.texture = static_cast<int32_t>(number);
    const uint32_t mesh = render.scene.AddMesh(Mesh(render.scene.AddMaterial(material)));
    (void)render.scene.AddInstance(mesh, scene::PlacedTransform{Translation({0.15f, 0, 0})});
    (void)render.scene.AddInstance(mesh, scene::PlacedTransform{Translation({0.85f, 0, 0})});
    const SceneRender::Hits hits = Hits();
    EXPECT_EQ(glm::vec3(hits.albedo.values[1]), glm::vec3(1, 0, 0));
    EXPECT_EQ(glm::vec3(hits.albedo.values[2]), glm::vec3(0, 1, 0));
}

TEST_F(HostObjects, WhatIsNotThereIsRefused) {
    HostMesh mesh = Mesh();
    mesh.triangleCount = 3;
    EXPECT_EQ(
        ErrorTextOf([&] { render.scene.AddMesh(mesh); }),
        "GpuScene: AddMesh: 'square': indices of 36 bytes from byte 128 of a buffer of 152, and a multiple "
        "of 4");
    mesh = Mesh();
    mesh.positions.offset = 2;
    EXPECT_TRUE(
        ErrorTextOf([&] { render.scene.AddMesh(mesh); }).starts_with("GpuScene: AddMesh: 'square': po"));
    mesh = Mesh();
    mesh.indices = {};
    EXPECT_EQ(ErrorTextOf([&] { render.scene.AddMesh(mesh); }),
              "GpuScene: AddMesh: 'square' has no triangles");
    mesh = Mesh(4);
    EXPECT_EQ(ErrorTextOf([&] { render.scene.AddMesh(mesh); }),
              "GpuScene: material 4 does not exist; the scene has 1");
    EXPECT_EQ(ErrorTextOf([&] { render.scene.AddTexture(HostTexture{}); }),
              "GpuScene: AddTexture: there is no texture");
    mesh = Mesh();
    mesh.bounds = {};
    EXPECT_EQ(ErrorTextOf([&] { render.scene.AddMesh(mesh); }),
              "GpuScene: AddMesh: the bounds are empty or not finite");
    EXPECT_EQ(ErrorTextOf([&] { render.scene.MarkChanged(0, {}); }),
              "GpuScene: MarkChanged: mesh 0 is not one of the host's");
}

}  // namespace raygraph::testing::host_objects_test
