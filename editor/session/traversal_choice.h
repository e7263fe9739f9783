// Whether own traversal is faster than the driver's on a device: measured once, and remembered. For
// editor/session/ and editor/cli/ alone.
#pragma once

#include <filesystem>

#include "editor/session/picture_settings.h"
#include "rhi/device.h"

namespace raygraph::session {

inline constexpr double kLeastTraversalRatio = 1.5;

// The driver's time over that of own traversal, of incoherent rays through a small scene that is always the
// same: nearest hits. By CPU time where the device is the CPU. 0 of a device without timestamps.
double MeasureTraversal(rhi::Device& device);

// Own where that ratio is kLeastTraversalRatio or more: the ratio that is remembered in the file for device,
// driver and version, or was measured by this process; if there is none, it is measured. An empty path:
// nothing is remembered but by the process. Threads: any.
passes::Traversal ChooseTraversal(rhi::Device& device, const std::filesystem::path& memory);

}  // namespace raygraph::session
