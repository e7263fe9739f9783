#include "passes/accumulate.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <future>
#include <numeric>
#include <string>
#include <utility>

#include "base/check.h"
#include "base/in_parts.h"
#include "base/text.h"
#include "passes/add_compute.h"
#include "renderer/graph/readback_values.h"
#include "shaders/shared/exact_sums.h"

namespace raygraph::passes {

const char* Name(ResetCause cause) {
    switch (cause) {
        case ResetCause::Start:
            return "start";
        case ResetCause::Camera:
            return "camera";
        case ResetCause::Transform:
            return "transform";
        case ResetCause::Material:
            return "material";
        case ResetCause::Light:
            return "light";
        case ResetCause::Geometry:
            return "geometry";
        case ResetCause::Environment:
            return "environment";
        case ResetCause::Resize:
            return "resize";
        case ResetCause::Settings:
            return "settings";
        case ResetCause::Count:
            break;
    }
    return "unknown";
}

// Holds the state of an Accumulation after the declared passes; it takes effect when the frame is submitted.
class AccumulationStep {
  public:
    // Begins a step of the open frame.
    AccumulationStep(Renderer& renderer, Accumulation& accumulation, Extent2D extent, bool hasVariance)
        : m_accumulation(accumulation),
          m_frame(renderer.OpenFrame()),
          m_before(accumulation.Current()),
          m_resetCount(accumulation.m_resetCount) {
        m_after = {.progress = m_before.progress, .hasVariance = hasVariance, .extent = extent};
    }

    // Returns the number of samples in the mean before the pass.
    uint32_t SampleCount() const { return m_sampleCount; }

    // `isLost` says that the persistent textures have no contents.
    void ResetIfNeeded(bool isLost) {
        if (m_after.progress.IsAtStart()) return;
        if (m_after.hasVariance && !m_before.hasVariance)
            m_cause = ResetCause::Settings;
        else if (isLost || !(m_before.extent == m_after.extent))
            m_cause = ResetCause::Resize;
        if (m_cause != ResetCause::Count) m_after.progress = {};
    }
    // Takes a tile of so many samples; if it is a part of the picture, the number must be one.
    void TakeTile(const Region& region, uint32_t sampleCount) {
        Accumulation::Progress& progress = m_after.progress;
        m_sampleCount = progress.sampleCount;
        if (!progress.cursor.IsNext(m_after.extent, region))
            throw MakeError(ErrorKind::Usage,
                            "accumulation \"{}\": a tile at {}, {} is not the next one; the current sample "
                            "is complete up to {}, {}",
                            m_accumulation.Name(), region.x, region.y, progress.cursor.X(),
                            progress.cursor.Y());
        if (progress.cursor.Advance(m_after.extent, region)) progress.sampleCount += sampleCount;
    }
    // Returns whether these are the first samples.
    bool TakeListed(uint32_t sampleCount) {
        m_sampleCount = m_after.progress.sampleCount;
        m_after.progress.sampleCount += sampleCount;
        return m_sampleCount == 0;
    }
    void TakeSamples(uint32_t sampleCount) { m_after.progress = {.sampleCount = sampleCount, .cursor = {}}; }

    // Makes the passes that come after this one in the frame go on from here.
    void Declare() const {
        m_accumulation.m_declared = m_after;
        m_accumulation.m_declaredIn = m_frame;
    }
    void Commit(CommandList& commands) const {
        commands.OnSubmitted([step = *this] { step.Apply(); });
    }

  private:
    void Apply() const {
        if (m_cause != ResetCause::Count) m_accumulation.m_resets[static_cast<size_t>(m_cause)]++;
        m_accumulation.m_state = m_after;
        if (m_accumulation.m_resetCount != m_resetCount) m_accumulation.m_state.progress = {};
    }

    Accumulation& m_accumulation;
    std::weak_ptr<const void> m_frame;
    Accumulation::State m_before, m_after;
    uint32_t m_sampleCount = 0;
    uint64_t m_resetCount;
    ResetCause m_cause = ResetCause::Count;  // Count: it goes on
};

uint32_t Accumulation::ResetCount() const {
    return std::accumulate(m_resets.begin(), m_resets.end(), 0u);
}

void Accumulation::Reset(ResetCause cause) {
    m_state.progress = {};
    m_declaredIn.reset();
    ++m_resetCount;
    m_resets[static_cast<size_t>(cause)]++;
}

namespace {

// The shaders use these names; a texture has the name of its accumulation, and one of these.
constexpr std::array<const char*, ExactSums::kPlanes> kSumNames{"sum0", "sum1", "sum2", "sum3"};
constexpr std::array<const char*, ExactSums::kPlanes> kSquareNames{"squares0", "squares1", "squares2",
                                                                   "squares3"};

std::string NameOf(const Accumulation& accumulation, const char* what) {
    return accumulation.Name() + "." + what;
}

void UpdateSums(PassBuilder& pass, AccumulatedIds& ids) {
    for (size_t k = 0; k < ExactSums::kPlanes; ++k) ids.sums[k] = pass.Updates(kSumNames[k], ids.sums[k]);
    for (size_t k = 0; k < ExactSums::kPlanes && ids.squares[0].IsValid(); ++k)
        ids.squares[k] = pass.Updates(kSquareNames[k], ids.squares[k]);
}

void DeclareSums(Renderer& renderer, TextureId tile, const SampleRows& rows, const Region& region,
                 const AccumulationStep& step, AccumulatedIds& ids) {
    const bool withVariance = ids.squares[0].IsValid();
    struct Constants {
        uint32_t offset[2];
        uint32_t isFirst;
        uint32_t sampleCount;
        uint32_t sampleRows;
    };
    renderer.AddPass(
        "Accumulate", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute(withVariance ? "post/accumulate_variance.comp" : "post/accumulate.comp");
            pass.Reads("newSamples", tile);
            pass.Constants(
                Constants{{region.x, region.y}, step.SampleCount() == 0 ? 1u : 0u, rows.count, rows.height});
            UpdateSums(pass, ids);
        },
        [step, extent = region.Extent()](CommandList& commands) {
            commands.DispatchOver(extent);
            step.Commit(commands);
        });
}

// Is culled unless something shown uses the mean, or the variance where it is valid.
void DeclareMean(Renderer& renderer, const Region& region, uint32_t sampleCount, AccumulatedIds& ids) {
    const bool withVariance = ids.variance.IsValid();
    struct Constants {
        uint32_t offset[2];
        uint32_t extent[2];
        gpu::ExactDivisor divisor;
        uint32_t sampleCount;
    };
    renderer.AddPass(
        "ResolveSums", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute(withVariance ? "post/resolve_sums_variance.comp" : "post/resolve_sums.comp");
            ReadSums(pass, ids, withVariance);
            pass.Constants(Constants{{region.x, region.y},
                                     {region.width, region.height},
                                     gpu::DivisorOf(std::max(sampleCount, 1u)),
                                     sampleCount});
            // A tile is an update: the texels outside of it keep their contents.
            const bool isWhole = WholeOf(renderer.Desc(ids.mean).extent) == region;
            ids.mean = isWhole ? pass.Writes("mean", ids.mean) : pass.Updates("mean", ids.mean);
            if (withVariance) ids.variance = pass.Writes("variance", ids.variance);
        },
        [extent = region.Extent()](CommandList& commands) { commands.DispatchOver(extent); });
}

}  // namespace

void ReadSums(PassBuilder& pass, const AccumulatedIds& accumulated, bool withSquares) {
    for (size_t k = 0; k < ExactSums::kPlanes; ++k) pass.Reads(kSumNames[k], accumulated.sums[k]);
    for (size_t k = 0; k < ExactSums::kPlanes && withSquares; ++k)
        pass.Reads(kSquareNames[k], accumulated.squares[k]);
}

AccumulatedIds StoredAccumulation(Renderer& renderer, const Accumulation& accumulation, Extent2D extent,
                                  bool withVariance) {
    const GraphTextureDesc words{extent, Format::Rgba32Uint};
    AccumulatedIds ids;
    ids.mean = renderer.Persist(NameOf(accumulation, "mean"), {extent, Format::Rgba32Float});
    for (size_t k = 0; k < ExactSums::kPlanes; ++k) {
        ids.sums[k] = renderer.Persist(NameOf(accumulation, kSumNames[k]), words);
        if (withVariance) ids.squares[k] = renderer.Persist(NameOf(accumulation, kSquareNames[k]), words);
    }
    return ids;
}

namespace {

AccumulatedIds PersistWithVariance(Renderer& renderer, const Accumulation& accumulation, Extent2D extent,
                                   bool withVariance) {
    AccumulatedIds ids = StoredAccumulation(renderer, accumulation, extent, withVariance);
    if (withVariance)
        ids.variance =
            renderer.CreateTexture(NameOf(accumulation, "variance"), {extent, Format::Rgba32Float});
    return ids;
}

}  // namespace

AccumulatedIds Resolve(Renderer& renderer, const Accumulation& accumulation, Extent2D extent,
                       bool withVariance) {
    AccumulatedIds ids = PersistWithVariance(renderer, accumulation, extent, withVariance);
    DeclareMean(renderer, WholeOf(extent), accumulation.Declared().sampleCount, ids);
    return ids;
}

AccumulatedIds Resolve(Renderer& renderer, const Accumulation& accumulation, TextureId counts,
                       Extent2D extent, bool withVariance) {
    AccumulatedIds ids = PersistWithVariance(renderer, accumulation, extent, withVariance);
    struct Constants {
        uint32_t offset[2];
        uint32_t extent[2];
    };
    AddCompute(renderer, "ResolveSums",
               withVariance ? "post/resolve_counts_variance.comp" : "post/resolve_counts.comp", extent,
               [&](PassBuilder& pass) {
                   ReadSums(pass, ids, withVariance);
                   pass.Reads("counts", counts);
                   pass.Constants(Constants{{0, 0}, {extent.width, extent.height}});
                   ids.mean = pass.Writes("mean", ids.mean);
                   if (withVariance) ids.variance = pass.Writes("variance", ids.variance);
               });
    return ids;
}

SumsReadback::SumsReadback(Renderer& renderer, const AccumulatedIds& accumulated)
    : m_hasSquares(accumulated.squares[0].IsValid()) {
    for (size_t k = 0; k < m_sums.size(); ++k) {
        m_sums[k] = renderer.ReadBack(accumulated.sums[k]);
        if (m_hasSquares) m_squares[k] = renderer.ReadBack(accumulated.squares[k]);
    }
}

std::vector<Readback> SumsReadback::Readbacks() const {
    std::vector<Readback> all(m_sums.begin(), m_sums.end());
    if (m_hasSquares) all.insert(all.end(), m_squares.begin(), m_squares.end());
    return all;
}

// Each plane gets a thread, since memory that is written for the first time is slow to come.
ExactSums SumsReadback::Values() const {
    ExactSums values;
    std::vector<std::future<ExactSums::Plane>> sums, squares;
    const auto take = [](const Readback& from) {
        from.Wait();
        return std::async(std::launch::async | std::launch::deferred,
                          [from] { return ValuesOf<uint32_t, ExactSums::Plane>(from); });
    };
    for (const Readback& from : m_sums) sums.push_back(take(from));
    for (size_t k = 0; k < m_squares.size() && m_hasSquares; ++k) squares.push_back(take(m_squares[k]));
    for (size_t k = 0; k < sums.size(); ++k) values.sums[k] = sums[k].get();
    for (size_t k = 0; k < squares.size(); ++k) values.squares[k] = squares[k].get();
    return values;
}

void Release(Renderer& renderer, const Accumulation& accumulation) {
    renderer.Release(NameOf(accumulation, "mean"));
    for (const char* what : kSumNames) renderer.Release(NameOf(accumulation, what));
    for (const char* what : kSquareNames) renderer.Release(NameOf(accumulation, what));
}

namespace {

AccumulatedIds AccumulateRows(Renderer& renderer, TextureId tile, const SampleRows& rows, Extent2D picture,
                              const Region& region, Accumulation& accumulation, bool withVariance) {
    AccumulatedIds ids = StoredAccumulation(renderer, accumulation, picture, withVariance);
    AccumulationStep step(renderer, accumulation, picture, withVariance);
    step.ResetIfNeeded(renderer.IsFresh(ids.sums[0]) || (withVariance && renderer.IsFresh(ids.squares[0])));
    step.TakeTile(region, rows.count);
    DeclareSums(renderer, tile, rows, region, step, ids);
    DeclareMean(renderer, region, step.SampleCount() + rows.count, ids);
    step.Declare();
    return ids;
}

}  // namespace

AccumulatedIds AccumulateTile(Renderer& renderer, TextureId tile, Extent2D picture, const Region& region,
                              Accumulation& accumulation, bool withVariance) {
    if (!(renderer.Desc(tile).extent == region.Extent()))
        throw MakeError(ErrorKind::Usage, "accumulation \"{}\": a tile of {}x{} texels for a region of {}x{}",
                        accumulation.Name(), renderer.Desc(tile).extent.width,
                        renderer.Desc(tile).extent.height, region.width, region.height);
    return AccumulateRows(renderer, tile, {.count = 1, .height = region.height}, picture, region,
                          accumulation, withVariance);
}

AccumulatedIds Accumulate(Renderer& renderer, TextureId samples, const SampleRows& rows,
                          Accumulation& accumulation, bool withVariance) {
    Extent2D picture = renderer.Desc(samples).extent;
    SampleRows all = rows;
    if (all.height == 0 && all.count > 0) all.height = picture.height / all.count;
    const uint64_t rowsOfTile = uint64_t{all.count} * all.height;
    if (rowsOfTile == 0 || picture.height % rowsOfTile != 0)
        throw MakeError(ErrorKind::Usage,
                        "accumulation \"{}\": {} samples of {} rows in a texture of {} rows, which is no "
                        "multiple of that",
                        accumulation.Name(), rows.count, rows.height, picture.height);
    picture.height /= all.count;
    return AccumulateRows(renderer, samples, all, picture, WholeOf(picture), accumulation, withVariance);
}

AccumulatedIds Accumulate(Renderer& renderer, TextureId sample, Accumulation& accumulation,
                          bool withVariance) {
    return Accumulate(renderer, sample, SampleRows{}, accumulation, withVariance);
}

AccumulatedIds AccumulateListed(Renderer& renderer, TextureId samples, uint32_t count,
                                const ListedPixels& pixels, Extent2D picture, Accumulation& accumulation,
                                bool withVariance) {
    Extent2D texels = renderer.Desc(samples).extent;
    texels.height /= count;
    const Extent2D tiles{texels.width / pixels.extent.width, texels.height / pixels.extent.height};
    const Extent2D whole{tiles.width * picture.width, tiles.height * picture.height};
    const bool isAll = pixels.count == uint64_t{picture.width} * picture.height;
    AccumulatedIds ids = StoredAccumulation(renderer, accumulation, whole, withVariance);
    AccumulationStep step(renderer, accumulation, whole, withVariance);
    step.ResetIfNeeded(renderer.IsFresh(ids.sums[0]));
    const bool isFirst = step.TakeListed(isAll ? count : 0);
    if (isFirst && !isAll)
        throw MakeError(ErrorKind::Usage,
                        "accumulation \"{}\": its first samples are of {} pixels, not of all",
                        accumulation.Name(), pixels.count);
    struct Constants {
        uint32_t offset[2];
        uint32_t isFirst, sampleCount, sampleRows, listWidth, listCount, padding;
        uint32_t pictureSize[2];
        uint32_t list[2];
    };
    renderer.AddPass(
        "Accumulate", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute(withVariance ? "post/accumulate_listed_variance.comp"
                                      : "post/accumulate_listed.comp");
            pass.Reads("newSamples", samples);
            pass.ReadsByAddress(pixels.list);
            pass.Constants(Constants{{0, 0},
                                     isFirst ? 1u : 0u,
                                     count,
                                     pixels.extent.height,
                                     pixels.extent.width,
                                     pixels.count,
                                     0,
                                     {picture.width, picture.height},
                                     {pixels.AddressLow(), pixels.AddressHigh()}});
            UpdateSums(pass, ids);
        },
        [step, texels](CommandList& commands) {
            commands.DispatchOver(texels);
            step.Commit(commands);
        });
    step.Declare();
    return ids;
}

VarianceIds RecordVariance(Renderer& renderer, const Accumulation& accumulation, const ListedPixels& pixels,
                           uint32_t sampleIndex, uint32_t sampleCount, VarianceIds noted) {
    const AccumulatedIds ids =
        StoredAccumulation(renderer, accumulation, renderer.Desc(noted.variance).extent, true);
    struct Constants {
        uint32_t list[2];
        uint32_t listCount, sampleIndex, sampleCount;
    };
    renderer.AddPass(
        "RecordVariance", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/note_samples.comp");
            pass.ReadsByAddress(pixels.list);
            ReadSums(pass, ids, true);
            pass.Constants(Constants{
                {pixels.AddressLow(), pixels.AddressHigh()}, pixels.count, sampleIndex, sampleCount});
            noted.variance = pass.Updates("variance", noted.variance);
            noted.mean = pass.Updates("mean", noted.mean);
            pass.KeepAlive();  // they are read in a later frame
        },
        // All devices have at least 65535 groups.
        [count = pixels.count](CommandList& commands) {
            commands.Dispatch(std::min((count + 63u) / 64u, 65535u));
        });
    return noted;
}

namespace {

TextureId Upload(Renderer& renderer, const std::string& name, TextureId target,
                 const ExactSums::Plane& texels, std::function<void(CommandList&)> andThen) {
    const Extent2D extent = renderer.Desc(target).extent;
    const size_t expected = size_t{4} * extent.width * extent.height;
    if (texels.size() != expected)
        throw MakeError(ErrorKind::Usage, "accumulation \"{}\": {} words to restore, a plane of {}x{} has {}",
                        name, texels.size(), extent.width, extent.height, expected);
    BufferId staging = renderer.CreateBuffer(
        name + ".restored", {.size = std::span(texels).size_bytes(), .memory = rhi::MemoryKind::Upload});
    renderer.AddPass(
        "Restore", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(staging);
            target = pass.CopiesTo(target);
            pass.KeepAlive();
        },
        [staging, target, texels, andThen = std::move(andThen)](CommandList& commands,
                                                                const PassResources& resources) {
            const rhi::Buffer& buffer = resources.Buffer(staging);
            std::memcpy(buffer.Mapped().data(), texels.data(), std::span(texels).size_bytes());
            commands.CopyToTexture(buffer, 0, resources.Texture(target));
            if (andThen) andThen(commands);
        });
    return target;
}

}  // namespace

void Restore(Renderer& renderer, Accumulation& accumulation, Extent2D extent, uint32_t sampleCount,
             const ExactSums& sums) {
    AccumulationStep step(renderer, accumulation, extent, sums.HasSquares());
    step.TakeSamples(sampleCount);
    AccumulatedIds ids = StoredAccumulation(renderer, accumulation, extent, sums.HasSquares());
    for (size_t k = 0; k < ExactSums::kPlanes && sums.HasSquares(); ++k)
        ids.squares[k] =
            Upload(renderer, NameOf(accumulation, kSquareNames[k]), ids.squares[k], sums.squares[k], {});
    for (size_t k = 1; k < ExactSums::kPlanes; ++k)
        ids.sums[k] = Upload(renderer, NameOf(accumulation, kSumNames[k]), ids.sums[k], sums.sums[k], {});
    ids.sums[0] = Upload(renderer, NameOf(accumulation, kSumNames[0]), ids.sums[0], sums.sums[0],
                         [step](CommandList& commands) { step.Commit(commands); });
}

// --- ExactSums, on the host ---

namespace {

static_assert(ExactSums::kPlanes == gpu::kSumWords && ExactSums::kPlanes + 1 == gpu::kSquareWords);

void RequireComparable(size_t pixels, size_t otherPixels, bool isAlike) {
    if (pixels != otherPixels || !isAlike)
        throw MakeError(ErrorKind::Usage, "exact sums: {} pixels to add to {}{}", otherPixels, pixels,
                        (isAlike ? "" : ", and the squares of one side alone"));
}

// Adds a word with the carry from the word below, and leaves its own.
void AddWord(uint32_t& word, uint32_t added, uint32_t& carry) {
    const uint64_t sum = uint64_t{word} + added + carry;
    word = static_cast<uint32_t>(sum);
    carry = static_cast<uint32_t>(sum >> 32);
}

// Returns word k of the squares of a channel.
template <typename Planes>
auto& SquareWord(Planes& squares, size_t pixel, size_t channel, size_t k) {
    return k < ExactSums::kPlanes ? squares[k][4 * pixel + channel] : squares[channel][4 * pixel + 3];
}

gpu::ExactSum SumOf(const ExactSums& sums, size_t pixel, size_t channel) {
    gpu::ExactSum sum;
    for (size_t k = 0; k < ExactSums::kPlanes; ++k) sum.words[k] = sums.sums[k][4 * pixel + channel];
    return sum;
}

}  // namespace

ExactSums MakeExactSums(size_t pixelCount, bool withSquares) {
    ExactSums sums;
    sums.sums.fill(ExactSums::Plane(4 * pixelCount, 0u));
    if (withSquares) sums.squares = sums.sums;
    return sums;
}

void AddSample(ExactSums& sums, std::span<const float> rgba) {
    RequireComparable(sums.PixelCount(), rgba.size() / 4, true);
    for (size_t i = 0; i < rgba.size(); ++i) {
        const gpu::ExactValue value = gpu::ExactSample(std::bit_cast<uint32_t>(rgba[i]));
        const gpu::ExactWords words = gpu::WordsOf(value);
        uint32_t carry = words.complement & 1u;
        for (int k = 0; k < gpu::kSumWords; ++k) AddWord(sums.sums[k][i], gpu::WordOf(words, k), carry);
        if (!sums.HasSquares() || i % 4 == 3) continue;
        const gpu::ExactWords square = gpu::WordsOf(gpu::ExactSquare(value));
        carry = 0;
        for (int k = 0; k < gpu::kSquareWords; ++k)
            AddWord(SquareWord(sums.squares, i / 4, i % 4, k), gpu::WordOf(square, k), carry);
    }
}

void AddSums(ExactSums& sums, const ExactSums& others) {
    RequireComparable(sums.PixelCount(), others.PixelCount(), sums.HasSquares() == others.HasSquares());
    InParts(sums.PixelCount(), [&](size_t first, size_t end) {
        for (size_t i = 4 * first; i < 4 * end; ++i) {
            uint32_t carry = 0;
            for (size_t k = 0; k < ExactSums::kPlanes; ++k)
                AddWord(sums.sums[k][i], others.sums[k][i], carry);
            if (!sums.HasSquares() || i % 4 == 3) continue;
            carry = 0;
            for (size_t k = 0; k <= ExactSums::kPlanes; ++k)
                AddWord(SquareWord(sums.squares, i / 4, i % 4, k),
                        SquareWord(others.squares, i / 4, i % 4, k), carry);
        }
    });
}

std::vector<float> MeanOf(const ExactSums& sums, uint32_t sampleCount) {
    RG_CHECK(sampleCount > 0);
    const gpu::ExactDivisor divisor = gpu::DivisorOf(sampleCount);
    std::vector<float> mean(4 * sums.PixelCount());
    InParts(sums.PixelCount(), [&](size_t first, size_t end) {
        for (size_t i = 4 * first; i < 4 * end; ++i)
            mean[i] = std::bit_cast<float>(gpu::MeanOfExactSum(SumOf(sums, i / 4, i % 4), divisor));
    });
    return mean;
}

std::vector<float> VarianceOf(const ExactSums& sums, uint32_t sampleCount) {
    RG_CHECK(sums.HasSquares());
    std::vector<float> variance(4 * sums.PixelCount(), 0.0f);
    InParts(sums.PixelCount(), [&](size_t first, size_t end) {
        for (size_t i = 4 * first; i < 4 * end; ++i) {
            if (i % 4 == 3) continue;
            gpu::ExactSquares squares;
            for (size_t k = 0; k <= ExactSums::kPlanes; ++k)
                squares.words[k] = SquareWord(sums.squares, i / 4, i % 4, k);
            variance[i] = std::bit_cast<float>(
                gpu::VarianceOfExactSums(SumOf(sums, i / 4, i % 4), squares, sampleCount));
        }
    });
    return variance;
}

// A record has the words of each channel's sum, lowest first; then those of its squares.
size_t WordsOfRecord(bool withSquares) {
    return 4 * ExactSums::kPlanes + (withSquares ? 3 * (ExactSums::kPlanes + 1) : 0);
}

namespace {

// Calls `move(word of the record, word of the planes)` for each word.
template <typename Words, typename Sums, typename Move>
void ForEachWord(Words records, Sums& sums, size_t firstPixel, Move&& move) {
    const bool withSquares = sums.HasSquares();
    const size_t count = records.size() / WordsOfRecord(withSquares);
    RG_CHECK(firstPixel + count <= sums.PixelCount());
    size_t at = 0;
    for (size_t pixel = firstPixel; pixel < firstPixel + count; ++pixel) {
        for (size_t c = 0; c < 4; ++c)
            for (size_t k = 0; k < ExactSums::kPlanes; ++k) move(records[at++], sums.sums[k][4 * pixel + c]);
        for (size_t c = 0; c < 3 && withSquares; ++c)
            for (size_t k = 0; k <= ExactSums::kPlanes; ++k)
                move(records[at++], SquareWord(sums.squares, pixel, c, k));
    }
}

}  // namespace

void PackSums(const ExactSums& sums, size_t firstPixel, std::span<uint32_t> records) {
    ForEachWord(records, sums, firstPixel, [](uint32_t& record, uint32_t word) { record = word; });
}

void UnpackSums(std::span<const uint32_t> records, size_t firstPixel, ExactSums& sums) {
    ForEachWord(records, sums, firstPixel, [](uint32_t record, uint32_t& word) { word = record; });
}

void AddRecords(std::span<uint32_t> records, std::span<const uint32_t> others, bool withSquares) {
    RG_CHECK_EQ(records.size(), others.size());
    size_t at = 0;
    const auto addNumber = [&](size_t words) {
        uint32_t carry = 0;
        for (size_t k = 0; k < words; ++k, ++at) AddWord(records[at], others[at], carry);
    };
    while (at < records.size()) {
        for (size_t c = 0; c < 4; ++c) addNumber(ExactSums::kPlanes);
        for (size_t c = 0; c < 3 && withSquares; ++c) addNumber(ExactSums::kPlanes + 1);
    }
}

}  // namespace raygraph::passes
