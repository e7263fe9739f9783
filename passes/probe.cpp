#include "passes/probe.h"

#include "base/text.h"

#include "passes/same_extent.h"

namespace raygraph::passes {

BufferId Probe(Renderer& renderer, TextureId mean, TextureId variance, glm::uvec2 pixel) {
    const Extent2D extent = RequireAlike(renderer, "Probe", mean, variance, Format::Rgba32Float);
    if (pixel.x >= extent.width || pixel.y >= extent.height)
        throw MakeError(ErrorKind::Usage, "Probe: pixel {}, {} of a picture of {}x{}", pixel.x, pixel.y,
                        extent.width, extent.height);
    BufferId texels = renderer.CreateBuffer("probe", {.size = sizeof(ProbedTexels)});
    renderer.AddPass(
        "Probe", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/probe.comp");
            pass.Reads("mean", mean);
            pass.Reads("variance", variance);
            pass.Constants(glm::ivec2(pixel));
            texels = pass.Writes("texels", texels);
        },
        [](CommandList& commands) { commands.Dispatch(1); });
    return texels;
}

BufferId ProbeGrid(Renderer& renderer, TextureId mean, TextureId variance, Extent2D grid) {
    const Extent2D extent = RequireAlike(renderer, "ProbeGrid", mean, variance, Format::Rgba32Float);
    if (grid.IsEmpty() || grid.width > extent.width || grid.height > extent.height)
        throw MakeError(ErrorKind::Usage, "ProbeGrid: {}x{} of the pixels of a picture of {}x{}", grid.width,
                        grid.height, extent.width, extent.height);
    BufferId texels =
        renderer.CreateBuffer("probes", {.size = uint64_t{grid.width} * grid.height * sizeof(ProbedTexels)});
    renderer.AddPass(
        "ProbeGrid", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/probe_grid.comp");
            pass.Reads("mean", mean);
            pass.Reads("variance", variance);
            pass.Constants(glm::uvec2(grid.width, grid.height));
            texels = pass.Writes("texels", texels);
        },
        [grid](CommandList& commands) { commands.DispatchOver(grid); });
    return texels;
}

}  // namespace raygraph::passes
