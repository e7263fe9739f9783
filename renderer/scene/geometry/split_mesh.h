// Primitives that are too large for a device, in pieces that are not. A device limits how many triangles one
// acceleration structure holds, and how many bytes one buffer does.
//
//   for (PrimitivePiece& piece : SplitPrimitive(std::move(primitive), {.maxTriangles = 1 << 29})) ...
//
// Together the pieces are the primitive: each triangle is in one of them, with the bits of its vertices. They
// are split in space, at the median of the centroids along the longest axis, so that few rays meet several;
// the same input gives the same pieces. Round primitives are split likewise, their capsules count as
// triangles.
//
// Threads: a pure function, for any thread.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "base/api.h"
#include "renderer/scene/model/mesh_data.h"

namespace raygraph::scene {

// Holds the limits of each piece. Bytes are those of all its streams on the host.
struct PieceLimits {
    uint64_t maxTriangles = std::numeric_limits<uint64_t>::max();
    uint64_t maxVertices = std::numeric_limits<uint64_t>::max();
    uint64_t maxBytes = std::numeric_limits<uint64_t>::max();
};

struct PrimitivePiece {
    // Has its own bounds, and its own boxes for the deformation by joints and targets.
    Primitive primitive;
    // The original index of each triangle (or capsule), ascending. Empty: the piece is all of the primitive.
    std::vector<uint32_t> originals;
};

// Returns one piece if the primitive is within the limits: it is then moved, not looked at.
// Error{OutOfMemory} if a single triangle is beyond them; the primitive is then, and when memory ends, as it
// was. Takes O(n log n) time for n triangles, and with the pieces twice the primitive's memory at its end.
RAYGRAPH_API std::vector<PrimitivePiece> SplitPrimitive(Primitive&& primitive, const PieceLimits& limits);

// Returns the host bytes of all streams.
RAYGRAPH_API uint64_t StreamBytes(const Primitive& primitive);

}  // namespace raygraph::scene
