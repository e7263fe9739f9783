// meshopt_encodeFilterExp, whose newer versions take a mode: the first one, an exponent a component.
#pragma once

#include <meshoptimizer.h>

#include <cstddef>

namespace raygraph::test {

template <typename... Mode>
void EncodeExponentialsBy(void (*encode)(void*, size_t, size_t, int, const float*, Mode...),
                          void* destination, size_t count, size_t stride, int bits, const float* values) {
    encode(destination, count, stride, bits, values, Mode{}...);
}

// `stride` is the bytes of an element, of whole floats; `bits` those of a mantissa, 1 to 24.
inline void EncodeExponentials(void* destination, size_t count, size_t stride, int bits,
                               const float* values) {
    EncodeExponentialsBy(meshopt_encodeFilterExp, destination, count, stride, bits, values);
}

}  // namespace raygraph::test
