#include "editor/session/frames/sample_time.h"

#include "shaders/shared/mix_bits.h"

namespace raygraph::session {

double ShutterPosition(uint32_t sampleIndex, uint32_t seed) {
    const uint32_t scramble = gpu::MixBits(seed ^ 0x5bd1e995u);
    uint32_t above = 1;  // The bits so far behind a leading 1, which tells their number.
    double position = 0.0, half = 0.5;
    for (uint32_t bit = 0; bit < 32; ++bit, half *= 0.5) {
        const uint32_t unscrambled = (sampleIndex >> bit) & 1u;
        const uint32_t flip = gpu::MixBits(above ^ gpu::MixBits(scramble + bit)) & 1u;
        if ((unscrambled ^ flip) != 0) position += half;
        above = (above << 1u) | unscrambled;
    }
    return position;
}

}  // namespace raygraph::session
