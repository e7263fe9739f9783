#include "passes/probe.h"

#include "base/text.h"
#include "passes/add_compute.h"

namespace raygraph::passes {

BufferId Probe(Renderer& renderer, const AccumulatedIds& samples, const Accumulation::Progress& progress,
               const Region& region, Extent2D grid) {
    RequireWithin(renderer.Desc(samples.sums[0]).extent, region);
    if (grid.IsEmpty() || grid.width > region.width || grid.height > region.height)
        throw MakeError(ErrorKind::Usage, "Probe: {}x{} of the pixels of a region of {}x{}", grid.width,
                        grid.height, region.width, region.height);
    struct Constants {
        uint32_t offset[2], size[2], grid[2];
        uint32_t sampleCount, doneRows, doneColumns, bandHeight;
    };
    const TileCursor& cursor = progress.cursor;
    BufferId texels =
        renderer.CreateBuffer("probed", {.size = uint64_t{grid.width} * grid.height * sizeof(ProbedPixel)});
    AddCompute(renderer, "Probe", "post/probe.comp", grid, [&](PassBuilder& pass) {
        ReadSums(pass, samples, true);
        pass.Constants(Constants{{region.x, region.y},
                                 {region.width, region.height},
                                 {grid.width, grid.height},
                                 progress.sampleCount,
                                 cursor.Y(),
                                 cursor.X(),
                                 cursor.BandHeight()});
        texels = pass.Writes("texels", texels);
    });
    return texels;
}

}  // namespace raygraph::passes
