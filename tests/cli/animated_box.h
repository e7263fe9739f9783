// Writes a scene with animations.
#pragma once

#include "tests/support/temporary_folder.h"

namespace raygraph::test {

// Writes box.gltf: the Cornell box, in which "rise" lifts the first node that has a mesh by 0.1 m per second,
// and "sink" lowers it.
void WriteBox(const TemporaryFolder& folder);

}  // namespace raygraph::test
