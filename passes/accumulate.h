// Accumulate: mean, and variance if asked for, of samples that come frame by frame; ExactSums: the sums of
// Accumulate on the host. Threads: that of the Renderer; ExactSums: any, as plain values and pure functions,
// which with large pictures have other threads work for them until they return.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/api.h"
#include "base/large_pages.h"
#include "passes/pixel_list.h"
#include "passes/tiles.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// ExactSums: sums to be stored, restored, and added to the sums of other samples. How a sample becomes an
// integer is in shaders/shared/exact_sums.h.
//
// Texels of four words, rows from the top, as the device keeps them in textures of rgba32ui: component c of
// plane k is word k of the sum of channel c. Squares are of the channels 0 to 2 and have a fifth word, which
// is component 3 of plane c. Component 3 of the last plane of squares is unused.
struct ExactSums {
    static constexpr size_t kPlanes = 4;
    using Plane = LargeArray<uint32_t>;
    std::array<Plane, kPlanes> sums;
    std::array<Plane, kPlanes> squares;  // empty: not accumulated

    bool IsEmpty() const { return sums[0].empty(); }
    bool HasSquares() const { return !squares[0].empty(); }
    size_t PixelCount() const { return sums[0].size() / 4; }
    bool operator==(const ExactSums&) const = default;
};

// Returns the sums of no samples: zeros.
RAYGRAPH_API ExactSums MakeExactSums(size_t pixelCount, bool withSquares);

// Adds a sample of every pixel, RGBA, or the sums over other samples. The bits do not depend on the order.
// Error{Usage} unless both are of as many pixels, and with or without squares.
RAYGRAPH_API void AddSample(ExactSums& sums, std::span<const float> rgba);
RAYGRAPH_API void AddSums(ExactSums& sums, const ExactSums& others);

// Return the mean of `sampleCount` samples, at least 1, and their unbiased variance, 0 below two: RGBA, each
// the float nearest to the exact value. w of the variance is 0. The bits are those of Accumulate.
RAYGRAPH_API std::vector<float> MeanOf(const ExactSums& sums, uint32_t sampleCount);
RAYGRAPH_API std::vector<float> VarianceOf(const ExactSums& sums, uint32_t sampleCount);

// Sums on their way to another process: pixel by pixel a record, which holds all words of its channels.
// Words of one record.
RAYGRAPH_API size_t WordsOfRecord(bool withSquares);
// The records of as many pixels as `records` has room for, from `firstPixel` on; and back.
RAYGRAPH_API void PackSums(const ExactSums& sums, size_t firstPixel, std::span<uint32_t> records);
RAYGRAPH_API void UnpackSums(std::span<const uint32_t> records, size_t firstPixel, ExactSums& sums);
// Adds records as AddSums adds sums; both sides have the same number.
RAYGRAPH_API void AddRecords(std::span<uint32_t> records, std::span<const uint32_t> others, bool withSquares);

// Names the reason for which an accumulation was restarted. Exposure and tone mapping are no causes: they are
// applied after it.
enum class ResetCause : uint8_t {
    Start,
    Camera,
    Transform,
    Material,
    Light,
    Geometry,
    Environment,
    Resize,
    Settings,
    Count
};
RAYGRAPH_API const char* Name(ResetCause cause);

// Holds the state of one accumulation between frames. One object per accumulated image; `name` keys the
// persistent textures. A pass takes effect when its frame is submitted: one that is culled, or whose frame is
// dropped, adds nothing and resets nothing. Reset takes effect at once.
//
// A sample may be added in tiles: then the pixels before the cursor have one sample more than SampleCount
// says, and each pixel's mean is over its own samples.
class RAYGRAPH_API Accumulation {
  public:
    explicit Accumulation(std::string name) : m_name(std::move(name)) {}

    struct Progress {
        uint32_t sampleCount = 0;  // complete
        TileCursor cursor;         // the cursor of the sample after those
        bool operator==(const Progress&) const = default;
        bool IsAtStart() const { return sampleCount == 0 && cursor.IsAtStart(); }
    };

    // The next sample starts a new mean. A frame that has been declared but not executed may still show its
    // sample within the old mean; it is not counted.
    void Reset(ResetCause cause);
    // Returns the number of samples in the mean, for every pixel.
    uint32_t SampleCount() const { return m_state.progress.sampleCount; }
    // Returns the state after the frames that were submitted.
    const Progress& Submitted() const { return m_state.progress; }
    // Returns the state including what the open frame has declared so far: its next pass continues from
    // there.
    const Progress& Declared() const { return Current().progress; }
    uint32_t ResetCount(ResetCause cause) const { return m_resets[static_cast<size_t>(cause)]; }
    uint32_t ResetCount() const;  // for any cause
    const std::string& Name() const { return m_name; }

  private:
    friend class AccumulationStep;
    struct State {
        Progress progress;
        bool hasVariance = false;  // true if all samples in the mean have squares
        Extent2D extent;
    };
    const State& Current() const { return m_declaredIn.expired() ? m_state : m_declared; }

    std::string m_name;
    uint64_t m_resetCount = 0;  // lets a declaration detect a later reset
    State m_state;
    State m_declared;                        // the future m_state
    std::weak_ptr<const void> m_declaredIn;  // the frame of m_declared
    std::array<uint32_t, static_cast<size_t>(ResetCause::Count)> m_resets{};
};

// How samples are stacked in a texture: `count` blocks of `height` rows each, in every tile if the texture
// has several (TraceIds::lightGroups).
struct SampleRows {
    uint32_t count = 1;
    uint32_t height = 0;  // 0: all rows of the picture
};

struct AccumulatedIds {
    TextureId mean;  // rgba32f
    // rgba32f, the unbiased variance of one sample, 0 below two. Only Resolve makes it, on request.
    TextureId variance;
    // rgba32ui, the planes of ExactSums. To go on accumulating without computing a mean, present one of
    // these.
    std::array<TextureId, ExactSums::kPlanes> sums, squares;
};

// Adds the sample to sums in integers, which never round (ExactSums), and takes the mean from these: the
// float nearest to the exact one of any number of samples, whatever their order and grouping. `withVariance`:
// adds up squares as well, from which Resolve and Probe take a variance. A changed extent resets with
// ResetCause::Resize; squares of samples that were taken without them reset with ResetCause::Settings.
// `accumulation` outlives the frame. Values that are not finite count as 0, so the bits are defined for any
// sample; reporting them is up to the pass that makes the samples.
[[nodiscard]] RAYGRAPH_API AccumulatedIds Accumulate(Renderer& renderer, TextureId sample,
                                                     Accumulation& accumulation, bool withVariance = false);
// Adds several samples at once.
[[nodiscard]] RAYGRAPH_API AccumulatedIds Accumulate(Renderer& renderer, TextureId samples,
                                                     const SampleRows& rows, Accumulation& accumulation,
                                                     bool withVariance = false);

// Adds `count` stacked samples to each pixel of a list; the other pixels of the picture keep theirs. The
// first call must list every pixel. Only calls that list every pixel raise SampleCount: Resolve is told the
// counts of the pixels. Does not update the mean. If `samples` is larger than the list's samples, it holds
// several tiles (TraceIds::lightGroups), each of which is accumulated.
[[nodiscard]] RAYGRAPH_API AccumulatedIds AccumulateListed(Renderer& renderer, TextureId samples,
                                                           uint32_t count, const ListedPixels& pixels,
                                                           Extent2D picture, Accumulation& accumulation,
                                                           bool withVariance = false);
// Holds two r32f textures of the picture's extent, for RecordVariance.
struct VarianceIds {
    TextureId variance, mean;
};
// For the listed pixels whose next sample has the index `sampleIndex`, and which have `sampleCount` samples:
// writes the variance of one sample and the mean, each summed over R, G and B.
[[nodiscard]] RAYGRAPH_API VarianceIds RecordVariance(Renderer& renderer, const Accumulation& accumulation,
                                                      const ListedPixels& pixels, uint32_t sampleIndex,
                                                      uint32_t sampleCount, VarianceIds noted);

// Takes a tile of a sample, the texels of `region`, into a picture of that size. `region` is one that
// accumulation.Declared().cursor.Next gives; Error{Usage} for others. Once all tiles are in, the bits are
// those of the sample in one piece. Several may come in one frame. Pixels without a sample are undefined, and
// the mean outside of `region` is the last that a frame used.
[[nodiscard]] RAYGRAPH_API AccumulatedIds AccumulateTile(Renderer& renderer, TextureId tile, Extent2D picture,
                                                         const Region& region, Accumulation& accumulation,
                                                         bool withVariance = false);

// Returns the stored state without a new sample: the mean as of the last frame that used it, and the sums.
[[nodiscard]] RAYGRAPH_API AccumulatedIds StoredAccumulation(Renderer& renderer,
                                                             const Accumulation& accumulation,
                                                             Extent2D extent, bool withVariance);

// Returns the stored state without a new sample, with mean and variance of all samples in it, including what
// the open frame has declared so far. There must be at least one complete sample and no partial one.
[[nodiscard]] RAYGRAPH_API AccumulatedIds Resolve(Renderer& renderer, const Accumulation& accumulation,
                                                  Extent2D extent, bool withVariance);

// Resolves pixels that have different numbers of samples: `counts` (r32ui, at least 1) holds that of each,
// and of each tile of the picture if it has several.
[[nodiscard]] RAYGRAPH_API AccumulatedIds Resolve(Renderer& renderer, const Accumulation& accumulation,
                                                  TextureId counts, Extent2D extent, bool withVariance);

// Declares that the pass reads the sums, and the squares, as shaders/post/pixel_sums.glsl does.
RAYGRAPH_API void ReadSums(PassBuilder& pass, const AccumulatedIds& accumulated, bool withSquares);

// Brings the sums of `accumulated`, and the squares if there are any, to the host.
class RAYGRAPH_API SumsReadback {
  public:
    SumsReadback() = default;
    SumsReadback(Renderer& renderer, const AccumulatedIds& accumulated);
    // Returns all readbacks that Values reads.
    std::vector<Readback> Readbacks() const;
    // Waits for the readbacks and returns their values.
    ExactSums Values() const;

  private:
    std::array<Readback, ExactSums::kPlanes> m_sums, m_squares;
    bool m_hasSquares = false;
};

// Releases the memory. Called between frames; the accumulation must be reset.
RAYGRAPH_API void Release(Renderer& renderer, const Accumulation& accumulation);

// Continues from stored sums of `sampleCount` samples, with squares if their variance is to be accumulated.
// Declares an upload into the persistent textures: in a frame of its own, executed before the first
// Accumulate. `accumulation` outlives the frame and changes when it is submitted.
RAYGRAPH_API void Restore(Renderer& renderer, Accumulation& accumulation, Extent2D extent,
                          uint32_t sampleCount, const ExactSums& sums);

}  // namespace raygraph::passes
