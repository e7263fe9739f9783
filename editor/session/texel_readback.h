// Values that were read back from the device.
#pragma once

#include <vector>

#include "passes/accumulate.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::session {

// Waits for it. T is the format's channel.
template <typename T>
std::vector<T> WaitForValues(const Readback& readback) {
    readback.Wait();
    return ValuesOf<T>(readback);
}

// The sums of an accumulated picture on their way to the host.
class SumsReadback {
  public:
    SumsReadback() = default;
    SumsReadback(Renderer& renderer, const passes::AccumulatedIds& ids)
        : m_hasSquares(ids.variance.IsValid()) {
        for (size_t k = 0; k < m_sums.size(); k++) {
            m_sums[k] = renderer.ReadBack(ids.sums[k]);
            if (m_hasSquares) m_squares[k] = renderer.ReadBack(ids.squares[k]);
        }
    }
    // Waits for it.
    passes::ExactSums Values() const {
        passes::ExactSums values;
        for (size_t k = 0; k < m_sums.size(); k++) {
            values.sums[k] = WaitForValues<uint32_t>(m_sums[k]);
            if (m_hasSquares) values.squares[k] = WaitForValues<uint32_t>(m_squares[k]);
        }
        return values;
    }

  private:
    std::array<Readback, passes::ExactSums::kPlanes> m_sums, m_squares;
    bool m_hasSquares = false;
};

}  // namespace raygraph::session
