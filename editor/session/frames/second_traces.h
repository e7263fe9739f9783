// SecondTraces traces samples again, each time without one of the biases: see bias.h.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "editor/session/file/render_file.h"
#include "editor/session/settings/bias.h"
#include "passes/accumulate.h"

namespace raygraph::session {

// Tells for each Bias whether samples are traced again.
using RetracedBiases = std::array<bool, kBiasCount>;

// Biases that are off need no second traces. `continues` is the render that is continued, or null. If
// samples of it were traced twice, biases that it lacks are not traced, either: all biases share one sample
// count.
RetracedBiases BiasesToRetrace(const passes::BiasSettings& biases, const RenderFile* continues);

class SecondTraces {
  public:
    explicit SecondTraces(const RetracedBiases& biases);

    bool HasAny() const { return !m_kept.empty(); }
    // Must be called in a frame of its own: continues from the sums in the file.
    void Restore(Renderer& renderer, const RenderFile& render);
    // Must be called in each frame: traces `sample` again for each bias if it is due. It was traced with
    // `settings`; `trace` traces it with others.
    using TraceSample = std::function<TextureId(const passes::TraceSettings&)>;
    void Declare(Renderer& renderer, const passes::TraceSettings& settings, TextureId sample,
                 const TraceSample& trace);
    // Must be called in a frame without a sample: reads back what Take returns.
    void ReadBack(Renderer& renderer, Extent2D extent);
    // Must be called next: fills in the removed light, zeros if no sample was traced again.
    void Take(RenderFile& render, bool withSums) const;
    // Frees the memory of readbacks.
    void DropReadbacks();

  private:
    struct Kept {
        explicit Kept(Bias which);
        Bias bias;
        passes::Accumulation accumulation;
        Readback mean, variance;  // set by ReadBack
        passes::SumsReadback sums;
    };
    std::vector<Kept> m_kept;  // never resized: frames refer to its accumulations
};

}  // namespace raygraph::session
