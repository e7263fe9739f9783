#include "passes/shadow_maps.h"

#include <algorithm>

#include "base/text.h"
#include "passes/draw_list.h"
#include "passes/raster_bindings.h"
#include "passes/scene_bindings.h"
#include "shaders/shared/draw_records.h"
#include "shaders/shared/shadow_records.h"

namespace raygraph::passes {

namespace {

struct CullConstants {
    uint32_t count;
    uint32_t viewSlots;
};
struct PlaceConstants {
    uint32_t punctualLights;
    uint32_t viewSlots;
    uint32_t tileSize;
};

BufferId SceneBounds(Renderer& renderer, const SceneIds& scene) {
    BufferId bounds = renderer.CreateBuffer("sceneBounds", {.size = sizeof(gpu::SceneBoundsRecord)});
    renderer.AddPass(
        "ResetBounds", PassKind::Transfer, [&](PassBuilder& pass) { bounds = pass.CopiesTo(bounds); },
        [bounds](CommandList& commands, const PassResources& resources) {
            commands.Fill(resources.Buffer(bounds), 0);
        });
    renderer.AddPass(
        "SceneBounds", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/scene_bounds.comp");
            BindInstances(pass, scene);
            pass.Reads("draws", scene.draws);
            bounds = pass.Updates("bounds", bounds);
            pass.Constants(scene.placementCount);
        },
        [count = scene.placementCount](CommandList& commands) { commands.Dispatch(GroupsFor(count)); });
    return bounds;
}

void PlaceViews(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                const PlaceConstants& constants, ShadowMapIds& ids) {
    const BufferId bounds = SceneBounds(renderer, scene);
    ids.views = renderer.CreateBuffer("shadowViews", {.size = constants.viewSlots * sizeof(gpu::ShadowView)});
    ids.lights =
        renderer.CreateBuffer("shadowLights", {.size = scene.punctualLights * sizeof(gpu::ShadowLight)});
    renderer.AddPass(
        "PlaceShadowViews", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/place_shadow_views.comp");
            pass.Uniform("parameters", RasterParameters(scene, settings));
            pass.Reads("lights", scene.lights);
            pass.Reads("bounds", bounds);
            ids.views = pass.Writes("shadowViews", ids.views);
            ids.lights = pass.Writes("shadowLights", ids.lights);
            pass.Constants(constants);
        },
        [](CommandList& commands) { commands.Dispatch(1); });
}

DrawList ListCasters(Renderer& renderer, const SceneIds& scene, BufferId views, uint32_t viewSlots) {
    DrawList list{
        .commands = renderer.CreateBuffer(
            "shadowCommands", {.size = std::max(1u, DrawCount(scene)) * sizeof(gpu::DrawCommand)}),
        .visiblePlacements = renderer.CreateBuffer(
            "casters",
            {.size = uint64_t{std::max(1u, scene.placementCount)} * viewSlots * sizeof(gpu::ShadowCaster)}),
    };
    ResetDraws(renderer, scene, list, viewSlots);
    const CullConstants constants{scene.placementCount, viewSlots};
    renderer.AddPass(
        "CullCasters", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/cull_casters.comp");
            BindInstances(pass, scene);
            pass.Reads("draws", scene.draws);
            pass.Reads("shadowViews", views);
            list.commands = pass.Updates("commands", list.commands);
            list.visiblePlacements = pass.Writes("casters", list.visiblePlacements);
            pass.Constants(constants);
        },
        [constants](CommandList& commands) {
            commands.Dispatch(GroupsFor(constants.count), constants.viewSlots);
        });
    return list;
}

}  // namespace

ShadowMapIds DrawShadowMaps(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                            const ShadowMapSettings& shadows) {
    RequireIndirectDraws(renderer, "DrawShadowMaps");
    if (!renderer.Device().Info().optional.clipDistance)
        throw MakeError(ErrorKind::Usage, "DrawShadowMaps: the device {} lacks shaderClipDistance",
                        renderer.Device().Info().name);
    const uint32_t viewSlots = std::clamp(gpu::kShadowFaces * scene.punctualLights, 1u, gpu::kMaxShadowViews);
    ShadowMapIds ids;
    while (ids.tilesPerSide * ids.tilesPerSide < viewSlots) ++ids.tilesPerSide;
    const uint32_t tileSize = shadows.atlasSize / ids.tilesPerSide;
    if (tileSize <= 4 * gpu::kShadowMargin)
        throw MakeError(ErrorKind::Usage, "DrawShadowMaps: an atlas of {} texels leaves {} a tile",
                        shadows.atlasSize, tileSize);
    const uint32_t side = tileSize * ids.tilesPerSide;
    PlaceViews(renderer, scene, settings, {scene.punctualLights, viewSlots, tileSize}, ids);
    const DrawList list = ListCasters(renderer, scene, ids.views, viewSlots);
    ids.atlas = renderer.CreateTexture("shadowAtlas", {{side, side}, Format::D32Float});
    const gpu::TraceParameters parameters = RasterParameters(scene, settings);
    bool isFirst = true;
    for (const DrawClass& drawn : ClassesOf(scene)) {
        // Without any draw, the first pass still clears
        if (drawn.range.count == 0 && (DrawCount(scene) > 0 || !isFirst)) continue;
        renderer.AddPass(
            std::string("Shadow") + drawn.name, PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("raster/shadow.vert");
                if (drawn.isTested) pass.Fragment("raster/shadow_tested.frag");
                // A shadow ray meets front faces: the light sees their other side
                pass.Raster({.cull = drawn.isCulled ? rhi::CullMode::Front : rhi::CullMode::None,
                             .depthCompare = rhi::DepthCompare::Greater});
                BindInstances(pass, scene);
                pass.Reads("casters", list.visiblePlacements);
                pass.Reads("shadowViews", ids.views);
                pass.ReadsArguments(list.commands);
                pass.Constants(ids.tilesPerSide);
                if (drawn.isTested) {
                    pass.Uniform("parameters", parameters);
                    BindAlphaTest(pass, scene, settings.sampler);
                }
                ids.atlas = pass.DepthTarget(ids.atlas, {.clear = isFirst, .value = 0.0f});
            },
            [range = drawn.range, list](CommandList& commands, const PassResources& resources) {
                commands.DrawIndirect(resources.Buffer(list.commands), range.first, range.count);
            });
        isFirst = false;
    }
    return ids;
}

}  // namespace raygraph::passes
