// The two ways of tracing rays, by the driver or by Raygraph's own shaders, and which one is faster on a
// device. Threads: that of the device's Renderers.
#pragma once

#include "base/api.h"
#include "shaders/shared/choice.h"

namespace raygraph {

namespace rhi {
class Device;
}

// The choice is one of speed: hits are the same, but at edges.
//   Auto:   the faster one on the device (FasterTraversal)
//   Driver: the device's acceleration structures, by its own traversal
//   Own:    trees of triangles, by shaders (shaders/scene/own_traversal.glsl)
#define RAYGRAPH_TRAVERSALS(X, Of) \
    X(Of, Auto, 0, "auto", "")     \
    X(Of, Driver, 1, "driver", "") \
    X(Of, Own, 2, "own", "")
RAYGRAPH_CHOICE(Traversal, RAYGRAPH_TRAVERSALS)

// Returns Driver or Own, a property of the device and its driver, whatever the scene. On a CPU it is Own,
// which was faster wherever it was measured (docs/performance.md). On a GPU it is Own where own rays are at
// least a tenth faster than the driver's (MeasureSoftwareSpeed), which is measured once and remembered
// (rhi::Device::StoreMeasurement). Driver on a device without timestamps.
RAYGRAPH_API Traversal FasterTraversal(rhi::Device& device);

// Returns the speed of Own relative to Driver in rays a second, measured on a GPU: half a million incoherent
// rays through a terrain of 18,432 triangles, by kernels that do nothing else, in turns. 0 on a device
// without timestamps.
RAYGRAPH_API double MeasureSoftwareSpeed(rhi::Device& device);

}  // namespace raygraph
