// PathTracedView declares the path-traced picture of a viewport: samples, tiles of a sample, and coarser
// pictures before the first sample.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "editor/viewport/frame_budget.h"
#include "editor/viewport/view_settings.h"
#include "passes/accumulate.h"
#include "passes/trace.h"

namespace raygraph::viewport {

// TracePrograms chooses the path tracer's program for a frame that does not wait for pipelines.
//
// A program has the features of a scene compiled in. One with more features gives the right picture, only
// slower: it stays in use when the scene comes to need less, so that no pipeline is made for a light that is
// off for a moment. Once the picture has kSettledSamples, the scene's own program is made on another thread,
// and replaces it when it is ready.
class TracePrograms {
  public:
    static constexpr uint32_t kSettledSamples = 64;

    struct Choice {
        bool isReady = false;  // false: it is being made, and no other program fits
        TraceFeatures more;    // further features of the program (passes::WithFeatures)
    };
    // Chooses the program of the open frame. `samples` is the picture's count so far. Without `mayMake` none
    // is made, since other pipelines come first.
    Choice Choose(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                  uint32_t samples, bool mayMake);

    // Records that a frame has used a program without asking.
    void MarkUsed() { m_isUsed = true; }

  private:
    TraceFeatures m_features;  // features of the program that was used last
    // Is false if no program exists, and reading its shaders takes longer than reading those of a preview.
    bool m_isUsed = false;
};

// PathTracedView declares samples, tiles of a sample, and coarser pictures before the first sample.
class PathTracedView {
  public:
    explicit PathTracedView(const std::string& name);

    struct Ids {
        TextureId radiance;              // rgba32f, the picture to show, in its full extent
        passes::AccumulatedIds samples;  // undefined in pixels without a sample
        // Is the finest complete picture, with the factor by which it is coarser.
        TextureId base;
        uint32_t baseScale = 1;
        // Is the coarse picture to which this frame adds a tile without completing it.
        TextureId finer;
        passes::Region finerTile{};
        bool isPreview = false;  // `base` is a preview; none of the samples is shown
        bool isHeld = false;     // as isPreview, but the preview is not ready: the last picture stays
    };
    // Tells how to show a frame that must not wait for pipelines (PreparingView::Preview).
    struct PreviewSettings {
        bool isOn = false;
        bool canHold = false;  // a last picture exists
        float gain = 1.0f;     // see passes::Preview
    };
    // Declares the tracing of a frame, and returns what to show. All of it is culled, and adds nothing,
    // unless one of the ids is used for something shown. `settings.extent` is not empty.
    Ids Declare(Renderer& renderer, const SceneIds& scene, passes::TraceSettings settings,
                const FrameBudget& budget, const BudgetSettings& limits, bool isChanging,
                const PreviewSettings& preview);
    // Declares samples alone, for a frame that shows another picture until there are enough: none is coarser.
    passes::AccumulatedIds DeclareSamples(Renderer& renderer, const SceneIds& scene,
                                          const passes::TraceSettings& settings, const FrameBudget& budget,
                                          const BudgetSettings& limits);
    void Reset(passes::ResetCause cause);
    // Releases the memory. Must be called between frames.
    void Release(Renderer& renderer);

    const passes::Accumulation& Samples() const { return m_full; }
    // Returns the factor by which the shown picture of submitted frames is coarser. 1: every pixel has a
    // sample; 0: there is no picture yet.
    uint32_t Coarseness() const;
    // Describes a tile that the last declared frame traces, if it is executed.
    struct Tile {
        uint32_t height = 0;  // height of the picture to which the tile belongs
        passes::Region region;
        bool isOfSample = true;    // false: of a coarser picture
        uint32_t sampleCount = 1;  // per pixel
        PassId first, end;         // passes that trace it: from `first` to before `end`
    };
    const std::vector<Tile>& DeclaredTiles() const { return m_tiles; }
    // Returns whether a picture that is coarser by this factor is known to take longer than `milliseconds`.
    static bool Exceeds(Extent2D extent, uint32_t scale, const FrameBudget& budget, double milliseconds);
    // Returns the tiles of the accumulation itself.
    std::vector<passes::Region> TilesOfSamples() const;

  private:
    // Holds one sample of the picture at a lower resolution.
    struct Level {
        uint32_t scale;
        passes::Accumulation sample;
    };
    // Limits the samples of a frame, their number in the end, and the scale of the first picture.
    struct FrameLimits {
        uint32_t mostSamples, endSample, coarsest;
    };
    static FrameLimits LimitsOf(Extent2D extent, const FrameBudget& budget, const BudgetSettings& settings,
                                bool isChanging);
    // Returns how many levels a picture needs: the coarsest has at most FrameBudget::kFirstPixels pixels, or
    // the scale `coarsest`.
    size_t LevelCount(Extent2D extent, uint32_t coarsest) const;
    static Extent2D ExtentAt(Extent2D extent, uint32_t scale);

    // Traces a tile; several samples at once only for the whole picture.
    passes::AccumulatedIds DeclareTile(Renderer& renderer, const SceneIds& scene,
                                       passes::TraceSettings settings, const passes::Region& region,
                                       uint32_t sampleCount, passes::Accumulation& into, bool withVariance);
    Ids DeclareTraced(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                      const FrameBudget& budget, const FrameLimits& limits);
    Ids DeclareSamples(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                       const FrameBudget& budget, const FrameLimits& limits);
    Ids DeclareFirstSample(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                           const FrameBudget& budget, uint32_t coarsest);
    Ids DeclarePreview(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                       const PreviewSettings& preview);
    // Returns the finest complete level; null: none.
    Level* Finest();
    // Returns the next finer level; null: it is the full picture.
    Level* FinerThan(const Level& level);
    // Returns the first level to trace: the finest that fits the budget, else the coarsest; null: the full
    // picture fits.
    Level* FirstToTrace(Extent2D extent, const FrameBudget& budget, uint32_t coarsest);

    passes::Accumulation m_full;
    std::deque<Level> m_levels;  // scales 2, 4, 8, ...; never moved: frames refer to them
    std::vector<Tile> m_tiles;
    TracePrograms m_programs;
    bool m_isPreviewReady = false;  // the preview's pipelines exist
};

}  // namespace raygraph::viewport
