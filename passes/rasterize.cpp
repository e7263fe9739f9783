#include "passes/rasterize.h"

#include <algorithm>
#include <array>

#include "passes/scene_bindings.h"
#include "shaders/shared/draw_records.h"

namespace raygraph::passes {

namespace {

// Groups loop over the remaining work, so that their number affects only speed.
constexpr uint32_t kMaxChunkGroups = 8192;
constexpr uint32_t kTileGroups = 1024;

// Holds push constants of shaders/raster/rasterize.glsl and resolve_visibility.comp.
struct RasterizeConstants {
    glm::vec2 shift;
    Extent2D size;
    uint32_t drawCount;
    std::array<uint32_t, kDrawKindCount> firstOfKind;
};
struct ResolveConstants {
    glm::vec2 shift;
    uint32_t drawCount;
};

// Returns the bytes of one 64-bit key a pixel.
uint64_t KeyBytes(Extent2D extent) {
    return uint64_t{extent.width} * extent.height * sizeof(uint64_t);
}

struct ChunkIds {
    BufferId firstChunks;  // uint[], one a draw, and the number of all
    BufferId tiles;        // a count, and gpu::TriangleTile[]
    BufferId nearest;      // uint64_t[], one a pixel
};

ChunkIds NumberChunks(Renderer& renderer, const SceneIds& scene, const RasterVisibility& seen,
                      Extent2D extent) {
    const uint32_t drawCount = DrawCount(scene);
    ChunkIds ids{
        .firstChunks =
            renderer.CreateBuffer("firstChunks", {.size = (drawCount + uint64_t{1}) * sizeof(uint32_t)}),
        .tiles = renderer.CreateBuffer(
            "tiles", {.size = sizeof(uint32_t) + gpu::kTileCapacity * sizeof(gpu::TriangleTile)}),
        .nearest = renderer.CreateBuffer("nearest", {.size = KeyBytes(extent)}),
    };
    renderer.AddPass(
        "NumberChunks", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/number_chunks.comp");
            pass.Reads("draws", scene.draws);
            pass.Reads("commands", seen.drawCommands);
            ids.firstChunks = pass.Writes("firstChunks", ids.firstChunks);
            ids.tiles = pass.Writes("tiles", ids.tiles);
            pass.Constants(drawCount);
        },
        [](CommandList& commands) { commands.Dispatch(1); });
    renderer.AddPass(
        "ClearNearest", PassKind::Transfer,
        [&](PassBuilder& pass) { ids.nearest = pass.CopiesTo(ids.nearest); },
        [nearest = ids.nearest](CommandList& commands, const PassResources& resources) {
            commands.Fill(resources.Buffer(nearest), 0);
        });
    return ids;
}

void BindChunks(PassBuilder& pass, const SceneIds& scene, const gpu::TraceParameters& parameters,
                const RasterVisibility& seen, const ChunkIds& ids) {
    pass.Uniform("parameters", parameters);
    BindInstances(pass, scene);
    pass.Reads("visiblePlacements", seen.visiblePlacements);
    pass.Reads("draws", scene.draws);
    pass.Reads("firstChunks", ids.firstChunks);
}

}  // namespace

bool CanRasterize(const Renderer& renderer, const SceneIds& scene, Extent2D extent) {
    const rhi::DeviceInfo& device = renderer.Device().Info();
    return device.optional.bufferInt64Atomics && scene.chunkCount <= gpu::kMaxChunks &&
           KeyBytes(extent) <= device.maxStorageBufferBytes;
}

void RasterizeHits(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                   RasterVisibility& seen, GlassDrawn glass) {
    const gpu::TraceParameters parameters = RasterParameters(scene, settings);
    ChunkIds ids = NumberChunks(renderer, scene, seen, settings.extent);
    RasterizeConstants constants{
        ClipOffset(seen.filmOffset, settings.extent), settings.extent, DrawCount(scene), {}};
    for (size_t kind = 0; kind < kDrawKindCount; ++kind)
        constants.firstOfKind[kind] = scene.drawsOfKind[kind].first;
    const bool hasTested = constants.firstOfKind[2] < constants.drawCount;
    const uint32_t drawn =
        (hasTested ? gpu::kDrawnAlpha : 0u) | (glass == GlassDrawn::Yes ? gpu::kDrawnGlass : 0u);
    const auto bind = [&](PassBuilder& pass) {
        BindChunks(pass, scene, parameters, seen, ids);
        BindAlphaTest(pass, scene, settings.sampler);
        pass.Specialize("kDrawn", drawn);
        pass.Constants(constants);
        ids.nearest = pass.Updates("nearest", ids.nearest);
    };
    const auto groups = static_cast<uint32_t>(std::min<uint64_t>(
        (scene.chunkCount * gpu::kChunkTriangles + gpu::kChunkGroupSize - 1) / gpu::kChunkGroupSize,
        kMaxChunkGroups));
    renderer.AddPass(
        "RasterizeChunks", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/rasterize_chunks.comp");
            bind(pass);
            ids.tiles = pass.Updates("tiles", ids.tiles);
        },
        [groups](CommandList& commands) { commands.Dispatch(groups); });
    renderer.AddPass(
        "RasterizeTiles", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/rasterize_tiles.comp");
            bind(pass);
            pass.Reads("tiles", ids.tiles);
        },
        [](CommandList& commands) { commands.Dispatch(kTileGroups); });
    renderer.AddPass(
        "ResolveVisibility", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/resolve_visibility.comp");
            BindChunks(pass, scene, parameters, seen, ids);
            pass.Reads("nearest", ids.nearest);
            pass.Constants(ResolveConstants{constants.shift, constants.drawCount});
            seen.hits = pass.Writes("visibility", seen.hits);
            seen.depth = pass.Writes("rasterDepth", seen.depth);
        },
        [extent = settings.extent](CommandList& commands) { commands.DispatchOver(extent); });
}

}  // namespace raygraph::passes
