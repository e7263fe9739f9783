#include <gtest/gtest.h>
#include <algorithm>
#include <cstring>
#include <numeric>
#include <string>
#include <type_traits>

#include "renderer/gpu_scene/deform/deform_set.h"
#include "renderer/gpu_scene/geometry/mesh_packing.h"
#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/host_objects.h"
#include "renderer/gpu_scene/instances/group_kinds.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "renderer/gpu_scene/lights/environment.h"
#include "renderer/gpu_scene/materials/scene_materials.h"
#include "renderer/gpu_scene/record_table.h"
#include "renderer/graph/readback_values.h"
#include "renderer/scene/model/scene_fields.h"
#include "rhi/blas_builder.h"
#include "rhi/transfer.h"
#include "tests/rhi/gate.h"
#include "tests/support/error_of.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

// Tables on the device of which few, many or all records change: always what the host has.
namespace raygraph::testing::record_table_test {
namespace {

constexpr uint32_t kCount = 1000;
using Record = std::array<uint32_t, 6>;

// A table of items with two records each, in another order than theirs, and what should be in it.
class RecordTableTest : public VulkanTest {
  protected:
    RecordTableTest() : records(kCount), places(kCount) {
        table.SetCount(kCount);
        for (uint32_t i = 0; i < kCount; ++i) {
            places[i] = i * 37 % kCount;
            Change(i);
        }
    }
    void Change(uint32_t record) {
        for (uint32_t word = 0; word < 6; ++word) records[record][word] = 0x01000193u * ++m_last + word;
        if (std::ranges::count(changed, record / 2) > 0) return;
        changed.push_back(record / 2);
    }
    // So many items.
    void ChangeSome(uint32_t count) {
        for (uint32_t i = 0; i < count; ++i)
            for (uint32_t k = 0; k < 2; ++k) Change(2 * ((i * 611 + 7) % (kCount / 2)) + k);
    }
    BufferId Declare() {
        return table.DeclareUpload(renderer, table.Import(renderer),
                                   {.prepare = [this] { ++prepared; },
                                    .changed = 2 * changed.size(),
                                    .write =
                                        [this](bool writesAll, RecordTable::Writer& writer) {
                                            for (uint32_t i = 0; writesAll && i < kCount / 2; ++i)
                                                Write(i, writer);
                                            for (size_t i = 0; !writesAll && i < changed.size(); ++i)
                                                Write(changed[i], writer);
                                        },
                                    .done = [this] { changed.clear(); }});
    }
    void Write(uint32_t item, RecordTable::Writer& writer) {
        for (const uint32_t record : {2 * item, 2 * item + 1}) {
            ++written;
            const std::span<std::byte> target = writer.At(places[record]);
            ASSERT_EQ(target.size(), sizeof(Record));
            std::memcpy(target.data(), &records[record], sizeof(Record));
        }
    }
    // Returns what the device has after a frame, by record.
    std::vector<Record> Frame() {
        prepared = written = 0;
        renderer.BeginFrame();
        const Readback readback = renderer.ReadBack(Declare());
        renderer.Execute();
        const auto inPlace = WaitForValues<Record>(readback);
        std::vector<Record> values(kCount);
        for (uint32_t i = 0; i < kCount; ++i) values[i] = inPlace.at(places[i]);
        return values;
    }
    bool IsScattered() const { return renderer.DescribePlan().find("scattered") != std::string::npos; }

    RendererLease lent{Device()};
    Renderer& renderer = *lent;
    RecordTable table{Device(),
                      {.name = "records",
                       .passName = "UploadRecords",
                       .recordBytes = sizeof(Record),
                       .capacity = kCount,
                       .usage = rhi::BufferUsage::CopySource}};
    std::vector<Record> records;
    std::vector<uint32_t> places;
    std::vector<uint32_t> changed;  // items
    uint32_t prepared = 0, written = 0;

  private:
    uint32_t m_last = 0;
};

}  // namespace

TEST_F(RecordTableTest, FewManyAndAllAreWhatTheHostHas) {
    EXPECT_EQ(Frame(), records) << "all at first";
    EXPECT_EQ(written, kCount);
    for (const uint32_t count : {1u, 5u, 16u, 17u, 63u, 64u, 65u, 200u, 250u, 251u, 499u, 500u}) {
        SCOPED_TRACE(count);
        ChangeSome(count);
        EXPECT_EQ(Frame(), records);
        EXPECT_EQ(prepared, 1u);
        EXPECT_EQ(written, count > 250 ? kCount : 2 * count);
        EXPECT_EQ(IsScattered(), count > 16 && count <= 250);
    }
    EXPECT_EQ(Frame(), records);
    EXPECT_EQ(prepared, 0u) << "nothing has changed";
}

TEST_F(RecordTableTest, WhatIsChangedTwiceIsWrittenOnce) {
    Frame();
    for (int i = 0; i < 3; ++i) ChangeSome(40);
    EXPECT_EQ(Frame(), records);
    EXPECT_EQ(written, 80u);
}

TEST_F(RecordTableTest, DroppedAndCulledChangesStayDue) {
    Frame();
    for (const uint32_t count : {3u, 100u, 400u}) {
        SCOPED_TRACE(count);
        ChangeSome(count);
        renderer.BeginFrame();
        (void)Declare();
        renderer.DropFrame();
        renderer.BeginFrame();
        (void)Declare();
        renderer.Execute();  // leads to no root
        EXPECT_FALSE(changed.empty());
        Change(500);
        EXPECT_EQ(Frame(), records);
        EXPECT_TRUE(changed.empty());
    }
}

// More workgroups than every device dispatches at once.
TEST_F(RecordTableTest, MoreThanOneDispatchScattersAreCopied) {
    constexpr uint32_t kMany = 65'536 * 128;
    RecordTable large(Device(), {.name = "words",
                                 .passName = "UploadWords",
                                 .recordBytes = 4,
                                 .capacity = 2 * kMany,
                                 .usage = rhi::BufferUsage::CopySource});
    large.SetCount(2 * kMany);
    for (const uint32_t due : {0u, kMany}) {
        renderer.BeginFrame();
        const BufferId words =
            large.DeclareUpload(renderer, large.Import(renderer),
                                {.changed = due, .write = [&](bool writesAll, RecordTable::Writer& writer) {
                                     for (uint32_t i = 0; i < (writesAll ? 2 * kMany : kMany); ++i) {
                                         const uint32_t value = i + due;
                                         std::memcpy(writer.At(i).data(), &value, 4);
                                     }
                                 }});
        const Readback readback = renderer.ReadBack(words);
        renderer.Execute();
        const auto values = WaitForValues<uint32_t>(readback);
        EXPECT_EQ(values.front(), due);
        EXPECT_EQ(values[kMany - 1], kMany - 1 + due);
    }
}

// Without layers, as what waits for a gate.
TEST(FrameStagingTest, MemoryIsUsedAgainOnceTheDeviceHasReadIt) {
    const std::unique_ptr<rhi::Device> device = rhi::Device::Create({.savePipelineCache = false});
    FrameStaging staging(*device, "staging");
    const std::byte* const first = staging.Take(1000).Mapped().data();
    EXPECT_EQ(staging.Take(500).Mapped().data(), first) << "its frame was dropped";
    Gate gate(*device);
    const rhi::SemaphoreUse wait = gate.At(1);
    const rhi::Submission busy = device->Submit(device->BeginCommands("reads it"), {&wait, 1});
    staging.MarkSubmitted();
    const std::byte* const second = staging.Take(1000).Mapped().data();
    EXPECT_NE(second, first);
    EXPECT_EQ(staging.Take(1000).Mapped().data(), second);
    gate.Open();
    device->WaitFor(busy);
    EXPECT_EQ(staging.Take(1000).Mapped().data(), first);
    EXPECT_GE(staging.Take(5000).Size(), 5000u);
}

}  // namespace raygraph::testing::record_table_test

// A material as the device reads it: each number from the field that it is named after.
namespace raygraph::material_records_test {
namespace {

using scene::Material;

// Numbers that no two fields share.
Material WithDistinctNumbers() {
    Material material;
    float number = 0.0f;
    scene::ForEachMaterialField([&](const auto& field) {
        using Value = typename std::decay_t<decltype(field)>::Value;
        number += 1.0f / 256.0f;
        if constexpr (std::is_same_v<Value, float>)
            material.*field.member = number;
        else if constexpr (std::is_same_v<Value, glm::vec3>)
            material.*field.member = {number, number + 1.0f, number + 2.0f};
        else if constexpr (std::is_same_v<Value, glm::vec4>)
            material.*field.member = {number, number + 1.0f, number + 2.0f, number + 3.0f};
    });
    material.priority = 5;
    return material;
}

TEST(MaterialRecords, HaveEachNumberFromItsField) {
    const Material material = WithDistinctNumbers();
    const gpu::MaterialRecord record = ToRecord(material, {});
    EXPECT_EQ(record.baseColor, material.baseColorFactor);
    EXPECT_EQ(record.emission, material.emissiveFactor * material.emissiveStrength);
    EXPECT_EQ(record.metallic, material.metallicFactor);
    EXPECT_EQ(record.roughness, material.roughnessFactor);
    EXPECT_EQ(record.normalScale, material.normalScale);
    EXPECT_EQ(record.alphaCutoff, material.alphaCutoff);
    EXPECT_EQ(record.ior, material.ior);
    EXPECT_EQ(record.specular, material.specularFactor);
    EXPECT_EQ(record.specularColor, material.specularColorFactor);
    EXPECT_EQ(record.transmission, material.transmissionFactor);
    EXPECT_EQ(record.thickness, material.thicknessFactor);
    EXPECT_EQ(record.extinction, material.Extinction());
    EXPECT_EQ(record.scattering, material.Scattering());
    EXPECT_EQ(record.scatterAnisotropy, material.scatterMeanCosine) << "strength is not 0";
    Material without = material;
    without.scatterStrengthFactor = 0.0f;
    EXPECT_EQ(ToRecord(without, {}).scatterAnisotropy, material.scatterAnisotropy);
    EXPECT_EQ(record.priority, 5u);
    EXPECT_EQ(record.clearcoat, material.clearcoatFactor);
    EXPECT_EQ(record.clearcoatRoughness, material.clearcoatRoughnessFactor);
    EXPECT_EQ(record.clearcoatNormalScale, material.clearcoatNormalScale);
    EXPECT_EQ(record.sheenColor, material.sheenColorFactor);
    EXPECT_EQ(record.sheenRoughness, material.sheenRoughnessFactor);
    EXPECT_EQ(record.anisotropy, material.anisotropyStrength);
    EXPECT_EQ(record.anisotropyRotation, material.anisotropyRotation);
    EXPECT_EQ(record.iridescence, material.iridescenceFactor);
    EXPECT_EQ(record.iridescenceIor, material.iridescenceIor);
    EXPECT_EQ(record.iridescenceThickness.x, material.iridescenceThicknessMinimum);
    EXPECT_EQ(record.iridescenceThickness.y, material.iridescenceThicknessMaximum);
    EXPECT_EQ(record.dispersion, material.dispersion);
    EXPECT_EQ(record.diffuseTransmission, material.diffuseTransmissionFactor);
    EXPECT_EQ(record.diffuseTransmissionColor, material.diffuseTransmissionColorFactor);
    EXPECT_EQ(record.retroreflection, material.retroreflectionFactor);
    EXPECT_EQ(record.scatterStrength, 0.0f) << "it bounds a medium";
}

TEST(MaterialRecords, SheetsScatterByOneExtension) {
    Material material = WithDistinctNumbers();
    material.thicknessFactor = 0.0f;
    const gpu::MaterialRecord sheet = ToRecord(material, {});
    EXPECT_EQ(sheet.scatterStrength, material.scatterStrengthFactor);
    EXPECT_EQ(sheet.diffuseTransmission, 0.0f);
    material.transmissionFactor = 0.0f;
    const gpu::MaterialRecord leaf = ToRecord(material, {});
    EXPECT_EQ(leaf.scatterStrength, 0.0f) << "there is nothing to scatter";
    EXPECT_EQ(leaf.diffuseTransmission, material.diffuseTransmissionFactor);
}

TEST(MaterialRecords, UnlitOnesHaveNoCoatAndNoEmission) {
    Material material = WithDistinctNumbers();
    material.isUnlit = true;
    const gpu::MaterialRecord record = ToRecord(material, {});
    EXPECT_EQ(record.clearcoat, 0.0f);
    EXPECT_EQ(record.emission, glm::vec3(0.0f));
    EXPECT_NE(record.flags & gpu::kMaterialUnlit, 0u);
}

TEST(MaterialRecords, HaveATransformOfEachTexture) {
    Material material;
    float turn = 0.0f;
    scene::ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), scene::TextureRef Material::*>)
            material.*field.member = {.texture = 0, .texCoord = 0, .transform = {.rotation = turn += 0.125f}};
    });
    const gpu::MaterialRecord record = ToRecord(material, {});
#define RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space) \
    EXPECT_EQ(record.name##Transform, material.name##Texture.transform.Matrix());
#include "shaders/shared/material_list.h"
}

}  // namespace
}  // namespace raygraph::material_records_test

// The features that materials need are found when something has changed, and only then.
namespace raygraph::testing::scene_materials_test {
namespace {

scene::Material Metal() {
    scene::Material metal;
    metal.metallicFactor = metal.roughnessFactor = 1.0f;
    return metal;
}

scene::Material Glass() {
    scene::Material glass = Metal();
    glass.metallicFactor = 0.0f;
    glass.transmissionFactor = 1.0f;
    return glass;
}

class SceneMaterialsTest : public VulkanTest {
  protected:
    rhi::Uploader uploader{Device()};
    rhi::BlasBuilder builder{Device()};
    std::shared_ptr<const rhi::Texture> white =
        std::make_shared<rhi::Texture>(WhiteTexture(Device(), uploader));
    rhi::Sampler sampler = Device().CreateSampler({.name = "sampler"});
    SceneMaterials materials{Device(), *white, sampler, 1.0f};
    SceneGeometry geometry{Device()};
    Renderer renderer{Device()};

    uint32_t AddMesh(GroupPart&& part) {
        std::vector<GroupResources> mesh(1);
        mesh.front().parts.push_back(std::move(part));
        mesh.front().records.emplace_back();
        return geometry.AddMesh(std::move(mesh), materials);
    }
    TraceFeatures Declare() {
        renderer.BeginFrame();
        SceneIds ids;
        materials.Declare(renderer, ids, geometry);
        renderer.Execute();
        return ids.features;
    }
    // A frame after a change finds the features; the one after it finds nothing again.
    void ExpectChanged(const char* what, TraceFeatures features) {
        const uint64_t before = materials.FeatureUpdates();
        EXPECT_EQ(Declare(), features) << what;
        EXPECT_EQ(Declare(), features) << what;
        EXPECT_EQ(materials.FeatureUpdates(), before + 1) << what;
    }
};

TEST_F(SceneMaterialsTest, FeaturesAreFoundAfterEachKindOfChangeAlone) {
    ExpectChanged("nothing is there", {});
    const std::vector<scene::Material> added{Metal(), Glass()};
    const std::vector<uint32_t> numbers = materials.Add(added, {});
    EXPECT_EQ(Declare(), TraceFeatures{}) << "no mesh uses them";
    EXPECT_EQ(materials.FeatureUpdates(), 1u);

    const uint32_t mesh = AddMesh({.material = numbers[0]});
    ExpectChanged("a mesh has come", kTraceMetals);
    const uint32_t painted =
        AddMesh({.material = numbers[0],
                 .variants = {{.material = numbers[0]}, {.variant = 0, .material = numbers[1]}}});
    ExpectChanged("another one has come", kTraceMetals);
    EXPECT_EQ(materials.PartCount(numbers[0]), 2u);
    EXPECT_EQ(materials.PartCount(numbers[1]), 1u) << "of a variant that is not shown";

    ChangeVariant(geometry, materials, builder, 0);
    ExpectChanged("a variant is shown", kTraceMetals | kTraceGlass);
    const gpu::MaterialRecord record = ToRecord(Glass(), materials.Records()[numbers[0]]);
    SceneMaterials::ChangedRecord changed{numbers[0], record};
    ChangeMaterials(geometry, materials, builder, {&changed, 1});
    ExpectChanged("a material was edited", kTraceGlass);

    const SceneTexture texture{std::make_shared<SceneImage>(SceneImage{.hostTexture = white}), {}};
    const uint32_t number = materials.AddTextures({&texture, 1}).front();
    ExpectChanged("a texture has come", kTraceGlass | kTraceTextures);
    materials.RemoveTexture(number);
    ExpectChanged("a texture has gone", kTraceGlass);

    geometry.RemoveMesh(mesh, materials);
    ExpectChanged("a mesh has gone", kTraceGlass);
    geometry.RemoveMesh(painted, materials);
    ExpectChanged("all have gone", {});
    EXPECT_EQ(materials.PartCount(numbers[0]), 0u);
}

}  // namespace
}  // namespace raygraph::testing::scene_materials_test

// Meshes and textures that a host has on the device: they are seen without a copy, and follow what the host
// makes of them.
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

// Any-hit shaders run where alpha can be below one, and nowhere else.
namespace raygraph::testing::alpha_bounds_test {

namespace {

constexpr auto kMask = scene::AlphaMode::Mask, kBlend = scene::AlphaMode::Blend,
               kOpaque = scene::AlphaMode::Opaque;

class AlphaBounds : public VulkanTest {
  protected:
    // Whether rays are tested for alpha on a square whose alpha is the product of these; in its texture and
    // among its vertices there are others of alpha 1.
    bool IsTested(scene::AlphaMode mode, float factor, float vertexAlpha, uint8_t texelAlpha) {
        scene::Material material = Lambert(glm::vec3(0.5f));
        material.alphaMode = mode;
        material.alphaCutoff = 0.5f;
        material.baseColorFactor.a = factor;
        material.baseColorTexture.texture = 0;
        scene::Mesh mesh = QuadMesh(0.5f);
        mesh.primitives[0].uv0 = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
        mesh.primitives[0].colors.assign(4, glm::vec4(0.5f, 1.0f, 0.25f, 1.0f));
        mesh.primitives[0].colors[2].a = vertexAlpha;
        scene::SceneData scene = SceneOf({mesh}, {material});
        scene.images = {{.name = "", .width = 2, .height = 1, .rgba = {9, 9, 9, 255, 9, 9, 9, texelAlpha}}};
        scene.textures = {{.name = "", .image = 0}};
        render.scene.SetScene(std::move(scene));
        return HasAlpha();
    }
    bool HasAlpha() {
        render.renderer.BeginFrame();
        const bool hasAlpha = render.scene.Declare(render.renderer).features.Has(kTraceAnyHit);
        render.renderer.Execute();
        return hasAlpha;
    }
    SceneRender render{Device()};
};

}  // namespace

TEST_F(AlphaBounds, OpaqueMaterialsAreNeverTested) {
    EXPECT_FALSE(IsTested(kOpaque, 0.0f, 0.0f, 0));
}

TEST_F(AlphaBounds, ColorsAndTexturesWithoutAlphaAreNotTested) {
    EXPECT_FALSE(IsTested(kBlend, 1.0f, 1.0f, 255));
    EXPECT_FALSE(IsTested(kMask, 1.0f, 1.0f, 255));
    EXPECT_FALSE(IsTested(kMask, 0.6f, 1.0f, 255)) << "above the cutoff everywhere";
    EXPECT_FALSE(IsTested(kMask, 1.0f, 0.9f, 230)) << "and so is the product";
}

TEST_F(AlphaBounds, EachThatMayBeBelowIsTested) {
    EXPECT_TRUE(IsTested(kBlend, 0.99f, 1.0f, 255));
    EXPECT_TRUE(IsTested(kBlend, 1.0f, 0.99f, 255));
    EXPECT_TRUE(IsTested(kBlend, 1.0f, 1.0f, 254));
    EXPECT_TRUE(IsTested(kMask, 0.4f, 1.0f, 255));
    EXPECT_TRUE(IsTested(kMask, 1.0f, 0.4f, 255));
    EXPECT_TRUE(IsTested(kMask, 1.0f, 1.0f, 100));
    EXPECT_TRUE(IsTested(kMask, 1.0f, 0.7f, 170)) << "their product is below the cutoff";
}

// The texture and the colors stay known when the factor is edited.
TEST_F(AlphaBounds, EditsAreSeen) {
    EXPECT_FALSE(IsTested(kBlend, 1.0f, 1.0f, 255));
    scene::Material material = Lambert(glm::vec3(0.5f));
    material.alphaMode = kBlend;
    material.baseColorFactor.a = 0.5f;
    render.scene.SetMaterial(0, material);
    EXPECT_TRUE(HasAlpha());
    material.baseColorFactor.a = 1.0f;
    render.scene.SetMaterial(0, material);
    EXPECT_FALSE(HasAlpha());
}

TEST_F(AlphaBounds, ThoseOfAnExchangedTextureAreSeen) {
    EXPECT_FALSE(IsTested(kBlend, 1.0f, 1.0f, 255));
    scene::SceneData part;
    part.images = {{.name = "", .width = 1, .height = 1, .rgba = {9, 9, 9, 128}}};
    part.textures = {{.name = "", .image = 0}};
    const std::vector<uint32_t> old{0}, clear = render.scene.Add(std::move(part)).textures;
    render.scene.SwapTextures(old, clear);
    EXPECT_TRUE(HasAlpha());
    render.scene.SwapTextures(old, clear);
    EXPECT_FALSE(HasAlpha());
}

TEST_F(AlphaBounds, LowestOfNothingIsOne) {
    EXPECT_EQ(LowestAlpha({}), 1.0f);
    scene::SceneData scene;
    scene.materials.resize(2);
    EXPECT_EQ(LowestTextureAlphas(scene), (std::vector<float>{1.0f, 1.0f}));
}

// Once, where the image was decoded: not when the scene is shown, by when its texels may be gone.
TEST_F(AlphaBounds, WhatIsKnownOfAnImageIsNotComputedAgain) {
    scene::SceneData scene;
    scene.images.push_back({.name = {}, .width = 1, .height = 1, .rgba = {1, 2, 3, 51}, .lowestAlpha = {}});
    scene.textures.resize(1);
    scene.materials.resize(1);
    scene.materials[0].baseColorTexture.texture = 0;
    EXPECT_EQ(LowestTextureAlphas(scene), std::vector<float>{0.2f});
    scene.images[0].lowestAlpha = uint8_t{102};
    EXPECT_EQ(LowestTextureAlphas(scene), std::vector<float>{0.4f});
}

}  // namespace raygraph::testing::alpha_bounds_test
