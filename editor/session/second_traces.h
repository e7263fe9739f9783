// The second traces of a render's samples, each without one of its biases: see bias.h.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "editor/session/bias.h"
#include "editor/session/render_file.h"
#include "passes/accumulate.h"

namespace raygraph::session {

// For which biases samples are traced again, by Bias.
using TracedAgain = std::array<bool, kBiasCount>;

// Nothing is ever traced for a bias that is off. `continues`: the render that is gone on with, or null. If
// samples of it were traced twice, then nothing is traced for a bias that it lacks, either: what was removed
// has one count of samples for all biases.
TracedAgain BiasesTracedAgain(const passes::BiasSettings& biases, const RenderFile* continues);

class SecondTraces {
  public:
    explicit SecondTraces(const TracedAgain& biases);

    bool HasAny() const { return !m_kept.empty(); }
    // In a frame of its own: continues from the sums in the file.
    void Restore(Renderer& renderer, const RenderFile& render);
    // In each frame: traces `sample` again for each bias, if it is due. It was traced with `settings`;
    // `trace` traces it with others.
    using TraceSample = std::function<TextureId(const passes::TraceSettings&)>;
    void Declare(Renderer& renderer, const passes::TraceSettings& settings, TextureId sample,
                 const TraceSample& trace);
    // In a frame without a sample: reads back what Take returns.
    void ReadBack(Renderer& renderer, Extent2D extent);
    // After it: fills what was removed, zeros if no sample was traced again.
    void Take(RenderFile& render, bool withSums) const;
    // Frees the memory of what was read back.
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
