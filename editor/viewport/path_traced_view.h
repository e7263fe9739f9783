// PathTracedView: the path-traced picture of a viewport: samples, tiles of one, and what is shown before
// there is one.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "editor/viewport/frame_budget.h"
#include "editor/viewport/view_settings.h"
#include "passes/accumulate.h"

namespace raygraph::viewport {

class PathTracedView {
  public:
    explicit PathTracedView(const std::string& name);

    struct Ids {
        TextureId radiance;  // rgba32f, what there is to show, in the picture's extent
        // Of the accumulation; what they hold of pixels without a sample is undefined.
        TextureId mean, variance;
        // The finest whole picture that there is, and how much coarser it is.
        TextureId base;
        uint32_t baseScale = 1;
        // The coarse picture that this frame adds a tile to, without completing it.
        TextureId finer;
        passes::Region finerTile{};
    };
    // Declares what a frame adds, and what to show. All of it is culled, and adds nothing, unless an id leads
    // to something shown. `settings.extent` is not empty.
    Ids Declare(Renderer& renderer, const SceneIds& scene, passes::TraceSettings settings,
                const FrameBudget& budget, const BudgetSettings& limits);
    void Reset(passes::ResetCause cause);
    // Gives the memory back; between frames.
    void Forget(Renderer& renderer);

    const passes::Accumulation& Samples() const { return m_full; }
    // Of submitted frames: how much coarser than the picture what is shown is. 1: every pixel has a sample;
    // 0: nothing is there yet.
    uint32_t Coarseness() const;
    // What the frame declared last traces, if it is executed.
    struct Tile {
        uint32_t height = 0;  // of the picture that it is a tile of
        passes::Region region;
        bool isOfSample = true;  // not of a coarser picture
    };
    const std::vector<Tile>& DeclaredTiles() const { return m_tiles; }
    // Those of the accumulation itself.
    std::vector<passes::Region> TilesOfSamples() const;

  private:
    // One sample of the picture at a lower resolution.
    struct Level {
        uint32_t scale;
        passes::Accumulation sample;
    };
    // Levels a picture needs: the coarsest has at most FrameBudget::kFirstPixels pixels.
    size_t LevelCount(Extent2D extent) const;
    static Extent2D ExtentAt(Extent2D extent, uint32_t scale);

    passes::AccumulatedIds DeclareTile(Renderer& renderer, const SceneIds& scene,
                                       passes::TraceSettings settings, const passes::Region& region,
                                       passes::Accumulation& into, bool withVariance);
    Ids DeclareSamples(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                       const FrameBudget& budget, const BudgetSettings& limits);
    Ids DeclareFirstSample(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                           const FrameBudget& budget);
    // The finest level that there is, or none.
    Level* Finest(Extent2D extent);
    // The next finer one; null: that is the picture itself.
    Level* FinerThan(const Level& level);
    // Where to begin: the finest level that fits the budget, else the coarsest; null: the picture itself
    // fits.
    Level* FirstToTrace(Extent2D extent, const FrameBudget& budget);

    passes::Accumulation m_full;
    std::deque<Level> m_levels;  // scales 2, 4, 8, ...; never moved: frames refer to them
    std::vector<Tile> m_tiles;
};

}  // namespace raygraph::viewport
