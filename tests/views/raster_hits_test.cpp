// Tests that the raster view draws what camera rays hit: instance, primitive, normal.
#include <cmath>

#include "passes/raster.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "shaders/shared/draw_records.h"
#include "tests/support/scene_render.h"
#include "tests/support/source_file.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::raster_hits_test {

using passes::FilmPosition;
using passes::Rasterizer;
using passes::TraceSettings;

namespace {

constexpr uint32_t kMiss = 0xFFFFFFFFu;

class RasterHits : public VulkanTest {
  protected:
    // Loads one of our own scenes and looks through its camera.
    TraceSettings Load(const char* name, Extent2D extent) {
        scene::SceneData data = scene::LoadGltf(test::SourceFile("scenes") / name);
        TraceSettings settings;
        settings.extent = extent;
        settings.camera = ToRecord(scene::ChooseView(data, "", float(extent.width) / float(extent.height)));
        render.scene.SetScene(std::move(data));
        return settings;
    }

    SceneRender::Hits Draw(const TraceSettings& settings, Rasterizer rasterizer = Rasterizer::Compute) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, settings, FilmPosition::Center, rasterizer);
        EXPECT_EQ(seen.rasterizer, rasterizer);
        return render.ReadHits(passes::RasterHits(render.renderer, ids, settings, seen));
    }

    // Returns the number of drawn placements, without those outside of the picture.
    uint32_t DrawnPlacements(const TraceSettings& settings) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, settings, FilmPosition::Center);
        const Readback commands = render.renderer.ReadBack(seen.drawCommands);
        render.renderer.Execute();
        commands.Wait();
        uint32_t count = 0;
        for (const gpu::DrawCommand& command : As<gpu::DrawCommand>(commands.Bytes()))
            count += command.instanceCount;
        return count;
    }

    // Compares both views of the scene. At most a fraction `edges` of the pixels may differ, and only if a
    // neighboring pixel of the other view sees the same instance; the others agree in surface, normal, color
    // and position. Returns the fraction of pixels that see a surface.
    double ExpectAgreement(const TraceSettings& settings, double edges) {
        const SceneRender::Hits traced = render.PrimaryHits(settings);
        ExpectAgreement(settings, edges, traced, Draw(settings, Rasterizer::Device), "device");
        return ExpectAgreement(settings, std::min(edges, 1e-4), traced, Draw(settings, Rasterizer::Compute),
                               "compute");
    }
    double ExpectAgreement(const TraceSettings& settings, double edges, const SceneRender::Hits& traced,
                           const SceneRender::Hits& drawn, const char* rasterizer) {
        SCOPED_TRACE(rasterizer);
        const auto width = static_cast<int>(settings.extent.width);
        const auto height = static_cast<int>(settings.extent.height);
        const auto isBeside = [&](const std::vector<glm::uvec4>& ids, int x, int y, uint32_t instance) {
            for (int j = std::max(0, y - 1); j <= std::min(height - 1, y + 1); ++j)
                for (int i = std::max(0, x - 1); i <= std::min(width - 1, x + 1); ++i)
                    if (ids[size_t(j * width + i)].x == instance) return true;
            return false;
        };
        uint32_t surfaces = 0, different = 0, misplaced = 0, bent = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const auto i = size_t(y * width + x);
                surfaces += traced.ids[i].x != kMiss;
                if (traced.ids[i] != drawn.ids[i]) {
                    ++different;
                    misplaced += !isBeside(traced.ids, x, y, drawn.ids[i].x) ||
                                 !isBeside(drawn.ids, x, y, traced.ids[i].x);
                    continue;
                }
                if (traced.ids[i].x == kMiss) continue;
                const float depth = traced.position.values[i].w;
                bent += glm::distance(traced.normal.values[i], drawn.normal.values[i]) > 5e-3f ||
                        glm::distance(traced.albedo.values[i], drawn.albedo.values[i]) > 2e-2f ||
                        glm::distance(traced.position.values[i], drawn.position.values[i]) > 2e-4f * depth;
            }
        const double pixels = double(width) * height;
        EXPECT_LE(different, edges * pixels);
        EXPECT_LE(misplaced, 2e-4 * pixels) << "instances thinner than a pixel may be";
        EXPECT_LE(bent, 1e-3 * pixels);
        RecordProperty(std::string("different by ") + rasterizer,
                       std::to_string(different) + " of " + std::to_string(width * height));
        RecordProperty(std::string("bent by ") + rasterizer, std::to_string(bent));
        return surfaces / pixels;
    }

    SceneRender render{Device()};
};

scene::Material OneSided(const glm::vec3& albedo) {
    scene::Material material = Lambert(albedo);
    material.isDoubleSided = false;
    return material;
}

glm::mat4x3 Placed(const glm::vec3& scale, const glm::vec3& at) {
    return {glm::vec3(scale.x, 0, 0), glm::vec3(0, scale.y, 0), glm::vec3(0, 0, scale.z), at};
}

// Makes a quad whose alpha grows from 0 on its left to 1 on its right, in front of a solid one.
scene::SceneData Veil(scene::AlphaMode mode, bool isDoubleSided) {
    scene::Material veil = OneSided({1.0f, 0.5f, 0.2f});
    veil.alphaMode = mode;
    veil.isDoubleSided = isDoubleSided;
    scene::Mesh mesh = QuadMesh(1.0f, 0);
    for (const glm::vec3& position : mesh.primitives[0].positions)
        mesh.primitives[0].colors.emplace_back(1.0f, 1.0f, 1.0f, 0.5f + 0.5f * position.x);
    return SceneOf({mesh, QuadMesh(1.5f, 1)}, {veil, Lambert(glm::vec3(0.5f))},
                   {glm::mat4x3(1.0f), Translation({0, 0, -1})});
}

}  // namespace

TEST_F(RasterHits, OwnScenesAreSeenAsRaysSeeThem) {
    const struct {
        const char* name;
        double edges;
        double surfaces;  // at least
    } kScenes[] = {{"cornell.gltf", 0.001, 0.6},
                   {"material_row.gltf", 0.005, 0.5},
                   {"texture_orientation.gltf", 0.001, 0.1},
                   {"nested_dielectrics.gltf", 0.005, 0.1},
                   {"closed_box_a50.gltf", 0.001, 0.999},
                   {"many_lights.gltf", 0.005, 0.3}};
    for (const auto& scene : kScenes) {
        SCOPED_TRACE(scene.name);
        EXPECT_GE(ExpectAgreement(Load(scene.name, {160, 120}), scene.edges), scene.surfaces);
    }
}

// Each layer covers the whole picture: they have more tiles of triangles than the list of tiles holds.
TEST_F(RasterHits, ManyLayersOfLargeTrianglesShowTheNearest) {
    constexpr uint32_t kTilesEach = 32;  // of the two triangles of a layer, in a row of tiles
    std::vector<glm::mat4x3> places(gpu::kTileCapacity / kTilesEach + 100);
    for (size_t i = 0; i < places.size(); ++i)
        places[i] = Translation({0, 0, -1.0f - 1e-3f * float(places.size() - i)});
    scene::SceneData scene = SceneOf({QuadMesh(9.0f)}, {OneSided(glm::vec3(0.5f))}, {places[0]});
    scene.instances.resize(places.size(), scene.instances[0]);
    for (size_t i = 1; i < places.size(); ++i) scene.instances[i].objectToWorld = places[i];
    render.scene.SetScene(std::move(scene));
    TraceSettings settings = LookAt({0, 0, 1}, {0, 0, 0}, 0.6f, 64);
    settings.extent = {kTilesEach * gpu::kTileSize, 1};
    for (const glm::uvec4& id : Draw(settings).ids) ASSERT_EQ(id.x, places.size() - 1);
}

TEST_F(RasterHits, APictureThatIsTooLargeForComputeIsDrawnByTheDevice) {
    render.scene.SetScene(SceneOf({BoxMesh(0.4f)}, {OneSided(glm::vec3(0.5f))}));
    TraceSettings settings = LookAt({0, 0, 5}, {0, 0, 0}, 0.2f, 8);
    const uint64_t limit = Device().Info().maxStorageBufferBytes;
    EXPECT_GE(limit, 128u << 20u);
    for (const uint32_t side : {64u, 16384u}) {
        settings.extent = {side, side};
        render.renderer.BeginFrame();
        const passes::RasterVisibility seen = passes::DrawVisibility(
            render.renderer, render.scene.Declare(render.renderer), settings, FilmPosition::Center);
        render.renderer.DropFrame();
        const bool fits = uint64_t{8} * side * side <= limit;
        EXPECT_EQ(seen.rasterizer, fits ? Rasterizer::Compute : Rasterizer::Device) << side;
    }
}

// The camera stands on a floor of two triangles that reach behind it, and then inside a closed box.
TEST_F(RasterHits, TrianglesThatReachBehindTheCameraAreSeenAsRaysSeeThem) {
    scene::Mesh floor = QuadMesh(50.0f);
    render.scene.SetScene(SceneOf({floor, BoxMesh(40.0f), SphereMesh(0.5f, 8)}, {Lambert(glm::vec3(0.5f))},
                                  {glm::mat4x3(1.0f), glm::mat4x3(1.0f), Translation({0.3f, 2.0f, 0.2f})}));
    for (const float angle : {0.0f, 1.0f, 2.2f, 4.0f})
        EXPECT_GE(ExpectAgreement(
                      LookAt({0.1f, 0.0f, 0.4f}, {std::sin(angle), std::cos(angle), 0.3f}, 1.1f, 96), 0.004),
                  0.999);
}

TEST_F(RasterHits, AFieldOfInstancesIsSeenAsRaysSeeIt) {
    const TraceSettings settings = Load("instanced_field.gltf", {320, 240});
    EXPECT_GE(ExpectAgreement(settings, 0.02), 0.3);
    const uint32_t drawn = DrawnPlacements(settings);
    EXPECT_GT(drawn, 0u);
    EXPECT_LE(drawn, render.scene.Statistics().instanceCount);
}

TEST_F(RasterHits, MirroredAndSquashedInstancesKeepTheirSides) {
    for (const bool isDoubleSided : {false, true}) {
        SCOPED_TRACE(isDoubleSided ? "double-sided" : "single-sided");
        scene::Material material = OneSided(glm::vec3(0.7f));
        material.isDoubleSided = isDoubleSided;
        std::vector<scene::Mesh> meshes(5, SphereMesh(0.5f, 8));
        meshes.push_back(QuadMesh(1.0f));  // shows its back
        meshes.push_back(
            QuadMesh(1.0f));  // mirrored along its normal, so that its front is where the back was
        render.scene.SetScene(SceneOf(
            std::move(meshes), {material},
            {Placed({1, 1, 1}, {-2, 0, 0}), Placed({-1, 1, 1}, {-1, 0, 0}), Placed({1, 1, -1}, {0, 0, 0}),
             Placed({-1, -0.4f, 1}, {1, 0, 0}), Placed({-0.3f, -1, -1}, {2, 0, 0}),
             Placed({-1, 1, -1}, {-1.5f, 2, 0}), Placed({1, 1, 1}, {1.5f, 2, 0})}));
        EXPECT_GE(ExpectAgreement(LookAt({0.3f, 0.9f, 6}, {0, 0.7f, 0}, 0.9f, 128), 0.005), 0.1);
    }
}

TEST_F(RasterHits, MaskAndBlendAreThereWhereRaysFindThem) {
    for (const auto mode : {scene::AlphaMode::Mask, scene::AlphaMode::Blend})
        for (const bool isDoubleSided : {false, true}) {
            SCOPED_TRACE(int(mode));
            render.scene.SetScene(Veil(mode, isDoubleSided));
            for (const float side : {1.0f, -1.0f})
                EXPECT_GE(ExpectAgreement(LookAt({0.1f, 0.2f, 4 * side}, {0, 0, 0}, 0.6f, 96), 0.002), 0.2);
        }
}

TEST_F(RasterHits, OrthographicCameraSeesWhatItsRaysHit) {
    render.scene.SetScene(SceneOf({SphereMesh(0.5f, 12), BoxMesh(0.4f)}, {OneSided(glm::vec3(0.5f))},
                                  {Translation({-0.4f, 0, 0}), Translation({0.5f, 0.1f, -1})}));
    scene::CameraView view = scene::CameraView::LookAt({0.4f, 0.5f, 3}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = 2.0f;
    view.zFar = 20.0f;
    TraceSettings settings;
    settings.extent = {96, 96};
    settings.camera = ToRecord(view);
    EXPECT_GE(ExpectAgreement(settings, 0.005), 0.2);
}

TEST_F(RasterHits, MovedAndHiddenInstancesAreDrawnAsTheyAre) {
    render.scene.SetScene(SceneOf({SphereMesh(0.5f, 8), BoxMesh(0.4f)}, {OneSided(glm::vec3(0.5f))},
                                  {Translation({-1, 0, 0}), Translation({1, 0, 0})}));
    const TraceSettings settings = LookAt({0, 0, 5}, {0, 0, 0}, 0.6f, 64);
    const double both = ExpectAgreement(settings, 0.005);
    EXPECT_EQ(DrawnPlacements(settings), 2u);
    render.scene.SetVisible(0, false);
    EXPECT_LT(ExpectAgreement(settings, 0.005), both);
    EXPECT_EQ(DrawnPlacements(settings), 1u);
    render.scene.SetVisible(0, true);
    render.scene.SetTransform(1, Translation({0.2f, 0.1f, 1}));
    ExpectAgreement(settings, 0.005);
    EXPECT_EQ(DrawnPlacements(settings), 2u);
}

TEST_F(RasterHits, PlacementsOutsideOfThePictureAreLeftOut) {
    std::vector<scene::Mesh> meshes(4, BoxMesh(0.4f));
    render.scene.SetScene(SceneOf(
        meshes, {OneSided(glm::vec3(0.5f))},
        {Translation({0, 0, 0}), Translation({9, 0, 0}), Translation({0, -9, 0}), Translation({0, 0, 12})}));
    EXPECT_EQ(DrawnPlacements(LookAt({0, 0, 5}, {0, 0, 0}, 0.6f, 64)), 1u);
    EXPECT_EQ(DrawnPlacements(LookAt({0, 0, 5}, {0, 0, 9}, 0.6f, 64)), 1u) << "the one behind it before";
    EXPECT_EQ(DrawnPlacements(LookAt({0, 0, 40}, {0, 0, 0}, 1.0f, 64)), 4u);
    EXPECT_EQ(DrawnPlacements(LookAt({0, 0, 40}, {0, 0, 90}, 1.0f, 64)), 0u);
}

// The six sides are at six different distances from the origin, so that none can stand for another.
TEST_F(RasterHits, PlacementIsDrawnWhereOneOfItsCornersIsInThePicture) {
    const glm::vec3 low(-7, -3, -1), high(2, 5, 4);
    scene::Mesh box = BoxMesh(1.0f);
    for (glm::vec3& position : box.primitives[0].positions)
        position = glm::mix(low, high, 0.5f * (position + glm::vec3(1.0f)));
    box.primitives[0].bounds = {low, high};
    render.scene.SetScene(SceneOf({box}, {Lambert(glm::vec3(0.5f))}));
    // Tests a narrow picture around x and y that sees what is nearer than `far`, up or down the z axis.
    const auto isDrawn = [&](float x, float y, float from, float far) {
        const float toward = from > 0 ? -1.0f : 1.0f;
        scene::CameraView view = scene::CameraView::LookAt({x, y, from}, {x, y, from + toward}, {0, 1, 0});
        view.projection = scene::Projection::Orthographic;
        view.height = 0.2f;
        view.zFar = far;
        TraceSettings settings;
        settings.extent = {16, 16};
        settings.camera = ToRecord(view);
        return DrawnPlacements(settings) == 1u;
    };
    for (const float margin : {0.25f, -0.25f})  // inside the box, and outside of it
        for (const bool isHigh : {false, true}) {
            SCOPED_TRACE(std::to_string(margin) + (isHigh ? " high" : " low"));
            const glm::vec3 at = isHigh ? high - margin : low + margin;
            const glm::vec3 middle = 0.5f * (low + high);
            EXPECT_EQ(isDrawn(at.x, middle.y, 20, 40), margin > 0);
            EXPECT_EQ(isDrawn(middle.x, at.y, 20, 40), margin > 0);
            EXPECT_EQ(isDrawn(middle.x, middle.y, isHigh ? 20.0f : -20.0f, 20 - std::abs(at.z)), margin > 0);
            for (const bool isOtherHigh : {false, true}) {
                const float y = isOtherHigh ? high.y - margin : low.y + margin;
                EXPECT_EQ(isDrawn(at.x, y, isHigh ? 20.0f : -20.0f, 20 - std::abs(at.z)), margin > 0);
            }
        }
}

TEST_F(RasterHits, AnEmptySceneIsAllMisses) {
    render.scene.SetScene({});
    const SceneRender::Hits hits = Draw(LookAt({0, 0, 5}, {0, 0, 0}, 0.6f, 8));
    for (const glm::uvec4& id : hits.ids) EXPECT_EQ(id, glm::uvec4(kMiss));
}

TEST_F(RasterHits, NothingIsBuiltThatOnlyRaysNeed) {
    render.scene.SetScene(SceneOf({BoxMesh(0.4f)}, {OneSided(glm::vec3(0.5f))}));
    EXPECT_EQ(Draw(LookAt({0, 0, 5}, {0, 0, 0}, 0.2f, 8)).ids[36].x, 0u);
    EXPECT_EQ(render.scene.Statistics().blasBuilds, 0u);
    EXPECT_EQ(render.scene.Statistics().tlasRebuilds, 0u);
    EXPECT_EQ(render.PrimaryHits(LookAt({0, 0, 5}, {0, 0, 0}, 0.2f, 8)).ids[36].x, 0u) << "rays come later";
}

TEST_F(RasterHits, RaysSeeWhatMovedWhileOnlyTheRasterViewWasShown) {
    const TraceSettings settings = LookAt({0, 0, 5}, {0, 0, 0}, 0.2f, 8);
    render.scene.SetScene(SceneOf({BoxMesh(0.4f), BoxMesh(0.4f)}, {OneSided(glm::vec3(0.5f))},
                                  {Translation({0, 0, 0}), Translation({5, 0, 0})}));
    for (int frame = 0; frame < 8; ++frame)
        render.PrimaryHits(settings);  // until after compaction, when updates follow
    EXPECT_EQ(render.PrimaryHits(settings).ids[36].x, 0u);
    render.scene.SetTransform(0, Translation({-5, 0, 0}));
    EXPECT_EQ(Draw(settings).ids[36].x, kMiss);
    render.scene.SetTransform(1, Translation({0, 0, 0}));
    EXPECT_EQ(Draw(settings).ids[36].x, 1u);
    EXPECT_EQ(Draw(settings).ids[36].x, 1u);
    EXPECT_EQ(render.PrimaryHits(settings).ids[36].x, 1u);
}

}  // namespace raygraph::testing::raster_hits_test

// Tests round primitives in raster views, which rays find in front of the drawn triangles.
namespace raygraph::testing::raster_capsules_test {

using passes::FilmPosition;
using passes::Rasterizer;
using passes::TraceSettings;

namespace {

class RasterCapsules : public VulkanTest {
  protected:
    SceneRender::Hits Draw(const TraceSettings& settings, Rasterizer rasterizer, bool isBehindGlass = false) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, settings, FilmPosition::Center, rasterizer);
        if (isBehindGlass) seen = passes::DrawBehindGlass(render.renderer, ids, settings, seen);
        return render.ReadHits(passes::RasterHits(render.renderer, ids, settings, seen));
    }

    // Compares both views of a scene of so many instances, all of which are visible.
    void ExpectAgreement(size_t instanceCount) {
        const TraceSettings settings = LookAt({0.5f, 0.7f, 5}, {0, 0, 0}, 0.6f, 96);
        const SceneRender::Hits traced = render.PrimaryHits(settings);
        for (const Rasterizer rasterizer : {Rasterizer::Compute, Rasterizer::Device}) {
            const SceneRender::Hits drawn = Draw(settings, rasterizer);
            uint32_t different = 0;
            std::vector<uint32_t> seen(instanceCount);
            for (size_t i = 0; i < drawn.ids.size(); ++i) {
                different += drawn.ids[i] != traced.ids[i];
                if (drawn.ids[i] != traced.ids[i] || drawn.ids[i].x == 0xFFFFFFFFu) continue;
                seen.at(drawn.ids[i].x)++;
                ASSERT_LT(glm::distance(traced.position.values[i], drawn.position.values[i]), 1e-3f) << i;
                ASSERT_LT(glm::distance(traced.normal.values[i], drawn.normal.values[i]), 5e-3f) << i;
            }
            EXPECT_LE(different, rasterizer == Rasterizer::Compute ? 4u : 60u);
            for (const uint32_t count : seen) EXPECT_GT(count, 30u) << "each is there";
        }
    }

    SceneRender render{Device()};
};

scene::Material Glass() {
    scene::Material glass;
    glass.transmissionFactor = 1.0f;
    glass.metallicFactor = 0.0f;
    return glass;
}

}  // namespace

// The scene has a wall that cuts a ball and a bar, and another ball behind it.
TEST_F(RasterCapsules, AreSeenBeforeAndBehindTrianglesAsRaysSeeThem) {
    render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), RoundSphere(0.5f, 1, {-0.3f, 0, 0}),
                                   RoundMesh({{-1.5f, -0.8f, -1}, {1.5f, 0.8f, 1}}, {0, 1}, {0.1f}, 1),
                                   RoundSphere(0.4f, 1, {0.9f, 0.9f, -0.5f})},
                                  {Lambert(glm::vec3(0.5f)), Lambert({0.2f, 0.6f, 0.4f})}));
    ExpectAgreement(4);
}

// They are before the wall, and exist for half of the rays.
TEST_F(RasterCapsules, BlendedOnesAreSeenAsRaysSeeThem) {
    scene::Material veil = Lambert(glm::vec3(0.5f));
    veil.alphaMode = scene::AlphaMode::Blend;
    veil.baseColorFactor.a = 0.5f;
    render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), RoundSphere(0.3f, 1, {0.6f, -0.6f, 0.4f})},
                                  {Lambert(glm::vec3(0.5f)), veil}));
    ExpectAgreement(2);
}

// With more surfaces than are looked through, the glass must not be taken for what is behind it.
TEST_F(RasterCapsules, BehindMuchGlassIsNoGlass) {
    std::vector<scene::Mesh> meshes{QuadMesh(2.0f, 0)};
    for (int i = 0; i < 18; ++i) meshes.push_back(RoundSphere(0.1f, 1, {0, 0, 0.5f + 0.3f * float(i)}));
    render.scene.SetScene(SceneOf(std::move(meshes), {Lambert(glm::vec3(0.5f)), Glass()}));
    const TraceSettings settings = LookAt({0, 0, 9}, {0, 0, 0}, 0.01f, 4);
    for (const Rasterizer rasterizer : {Rasterizer::Compute, Rasterizer::Device})
        for (const glm::uvec4& ids : Draw(settings, rasterizer, true).ids) EXPECT_EQ(ids.x, 0u);
}

TEST_F(RasterCapsules, WhatIsBehindGlassIsFoundBehindRoundGlass) {
    // A ball of glass before a ball of chalk before a wall
    render.scene.SetScene(
        SceneOf({QuadMesh(2.0f, 0), RoundSphere(0.5f, 1, {0, 0, 2}), RoundSphere(0.2f, 0, {0, 0, 1})},
                {Lambert(glm::vec3(0.5f)), Glass()}));
    const TraceSettings settings = LookAt({0, 0, 6}, {0, 0, 0}, 0.25f, 32);
    const auto middle = [](const SceneRender::Hits& hits) { return hits.ids[16 * 32 + 16].x; };
    const auto besideIt = [](const SceneRender::Hits& hits) { return hits.ids[16 * 32 + 24].x; };
    for (const Rasterizer rasterizer : {Rasterizer::Compute, Rasterizer::Device}) {
        EXPECT_EQ(middle(Draw(settings, rasterizer)), 1u);
        EXPECT_EQ(middle(Draw(settings, rasterizer, true)), 2u);
        EXPECT_EQ(besideIt(Draw(settings, rasterizer)), 1u);
        EXPECT_EQ(besideIt(Draw(settings, rasterizer, true)), 0u);
    }
}

// The sun is behind a ball, whose shadow is on the floor, also if maps are requested.
TEST_F(RasterCapsules, CastShadowsOnWhatIsDrawn) {
    scene::SceneData scene =
        SceneOf({QuadMesh(2.0f, 0), RoundSphere(0.5f, 0, {0, 0, 2})}, {Lambert(glm::vec3(0.5f))});
    scene::Light sun;  // along -z
    sun.type = scene::LightType::Directional;
    sun.intensity = 2.0f;
    scene.lights = {sun};
    render.scene.SetScene(std::move(scene));
    passes::FilteredEnvironment environment("environment");
    for (const passes::RasterShadows shadows : {passes::RasterShadows::Rays, passes::RasterShadows::Maps})
        for (const auto& [x, share] : {std::pair{0.0f, 0.0f}, {0.48f, 0.0f}, {0.52f, 1.0f}}) {
            const TraceSettings settings = LookAt({x, 0, 1}, {x, 0, 0}, 1e-3f, 4);
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            const Readback readback = render.renderer.ReadBack(passes::AnyRasterShade(
                render.renderer, ids, settings, FilmPosition::Center, environment, {.shadows = shadows}));
            render.renderer.Execute();
            EXPECT_NEAR(ToFloatImage(readback).Mean().y, share * 0.5 * 2.0 / 3.14159265, 1e-3) << x;
        }
}

}  // namespace raygraph::testing::raster_capsules_test
