#include "passes/draw_list.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "passes/scene_bindings.h"
#include "shaders/shared/draw_records.h"

namespace raygraph::passes {

namespace {

constexpr uint32_t kGroupSize = 64;

// Holds push constants of raster/reset_draws.comp and raster/cull_instances.comp.
struct ResetConstants {
    uint32_t count;
    uint32_t slotsPerPlacement;
};
struct CullConstants {
    glm::vec2 shift;
    uint32_t count;
};

}  // namespace

gpu::TraceParameters RasterParameters(const SceneIds& scene, const TraceSettings& settings) {
    gpu::TraceParameters parameters = ParametersFor(scene, settings);
    parameters.camera.lensRadius = 0.0f;
    return parameters;
}

uint32_t GroupsFor(uint32_t count) {
    // A share of the 65535 groups that every device has.
    constexpr uint32_t kMaxGroups = 4096;
    return std::min((count + kGroupSize - 1) / kGroupSize, kMaxGroups);
}

uint32_t DrawCount(const SceneIds& scene) {
    return scene.drawsOfKind.back().first + scene.drawsOfKind.back().count;
}

DrawClasses ClassesOf(const SceneIds& scene) {
    const auto classOf = [&](const char* name, DrawKind kind, bool isTested, bool isCulled) {
        return DrawClass{name, scene.drawsOfKind[static_cast<size_t>(kind)], isTested, isCulled};
    };
    return {classOf("Opaque", DrawKind::Opaque, false, true),
            classOf("OpaqueTwoSided", DrawKind::OpaqueTwoSided, false, false),
            classOf("AlphaTested", DrawKind::AlphaTested, true, true),
            classOf("AlphaTestedTwoSided", DrawKind::AlphaTestedTwoSided, true, false)};
}

// Returns a point of a low-discrepancy sequence over the pixel: additive recurrence by the powers of 1 / g,
// where g is the real root of x^3 = x + 1. The first point is the pixel's center.
glm::vec2 FilmOffset(FilmPosition film, uint32_t sampleIndex) {
    if (film == FilmPosition::Center) return glm::vec2(0.5f);
    const auto place = [&](double step) {
        const double x = 0.5 + step * sampleIndex;
        return static_cast<float>(x - std::floor(x));
    };
    return {place(0.75487766624669276), place(0.56984029099805327)};
}

glm::vec2 ClipOffset(const glm::vec2& filmOffset, Extent2D extent) {
    return 2.0f * (glm::vec2(0.5f) - filmOffset) / glm::vec2(extent.width, extent.height);
}

void RequireIndirectDraws(const Renderer& renderer, const char* pass) {
    const rhi::DeviceInfo& device = renderer.Device().Info();
    if (!device.optional.drawIndirectFirstInstance)
        throw MakeError(ErrorKind::Usage, "{}: the device {} lacks drawIndirectFirstInstance", pass,
                        device.name);
}

void ResetDraws(Renderer& renderer, const SceneIds& scene, DrawList& list, uint32_t slotsPerPlacement) {
    const ResetConstants constants{DrawCount(scene), slotsPerPlacement};
    renderer.AddPass(
        "ResetDraws", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/reset_draws.comp");
            pass.Reads("draws", scene.draws);
            list.commands = pass.Writes("commands", list.commands);
            pass.Constants(constants);
        },
        [constants](CommandList& commands) { commands.Dispatch(GroupsFor(constants.count)); });
}

DrawList ListDraws(Renderer& renderer, const SceneIds& scene, const gpu::TraceParameters& parameters,
                   const glm::vec2& shift) {
    const uint32_t drawCount = DrawCount(scene), placementCount = scene.placementCount;
    DrawList list{
        .commands = renderer.CreateBuffer("drawCommands",
                                          {.size = std::max(1u, drawCount) * sizeof(gpu::DrawCommand)}),
        .visiblePlacements = renderer.CreateBuffer("visiblePlacements",
                                                   {.size = std::max(1u, placementCount) * sizeof(uint32_t)}),
    };
    ResetDraws(renderer, scene, list, 1);
    renderer.AddPass(
        "CullInstances", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/cull_instances.comp");
            pass.Uniform("parameters", parameters);
            pass.Reads("instances", scene.instances);
            pass.Reads("draws", scene.draws);
            list.commands = pass.Updates("commands", list.commands);
            list.visiblePlacements = pass.Writes("visiblePlacements", list.visiblePlacements);
            pass.Constants(CullConstants{shift, placementCount});
        },
        [placementCount](CommandList& commands) { commands.Dispatch(GroupsFor(placementCount)); });
    return list;
}

}  // namespace raygraph::passes
