#include "renderer/scene/geometry/split_place.h"

namespace raygraph::scene {

// A file and a loop of its own: where GCC 12 makes vectors of it, it leaves out the rounding to float.
SplitPlace Split(const glm::dvec3& place) {
    SplitPlace split;
    for (int i = 0; i < 3; ++i) {
        const volatile float rounded = static_cast<float>(place[i]);
        split.rounded[i] = rounded;
        split.rest[i] = static_cast<float>(place[i] - static_cast<double>(rounded));
    }
    return split;
}

}  // namespace raygraph::scene
