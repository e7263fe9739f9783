// Which form of the integrator and which traversal are the fastest for a scene on a device: measured once,
// and remembered. For editor/session/ and editor/cli/ alone.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "editor/session/choice_memory.h"
#include "editor/session/device_scene.h"
#include "editor/session/pass_times.h"

namespace raygraph::session {

struct TracingChoice {
    passes::FormSettings form;
    passes::Traversal traversal = passes::Traversal::Auto;

    bool operator==(const TracingChoice&) const = default;
};

// "own wavefront:8". Error{Usage} for what is no such text.
TracingChoice ParseTracing(std::string_view text);
std::string TracingText(const TracingChoice& choice);

struct TracingTime {
    TracingChoice choice;
    double msPerSample = 0.0;  // of the device, for a sample of every pixel
};

// Of the passes of Trace in a frame, in any form: the sum of their medians.
double MsOfTrace(const PassTimes& times);

// Renders a few frames of each; the samples are lost. A choice has the median of several frames. None of a
// device without timestamps.
std::vector<TracingTime> MeasureTracing(DeviceScene& scene, std::span<const TracingChoice> choices);

// How the paths of the scene's picture are traced the fastest. What `wanted` has other than Auto stays, but
// for own traversal of a scene that has no trees for it: the driver's.
//
// On a CPU: the loop, by own traversal, which were faster wherever they have been measured
// (docs/performance.md): compiling kernels to measure them takes longer than most pictures. Else what is
// remembered for device, driver, version, shader features, number of pixels and size of the scene; if nothing
// is, the fastest of a few, measured. With a shutter, as instances may move in each sample, by the driver,
// unless the device is a CPU and instances are few.
TracingChoice ChooseTracing(DeviceScene& scene, const TracingChoice& wanted, const ChoiceMemory& memory);

// Says that own traversal was asked for and is not possible.
void WarnOfDriver(const Log& log, const std::string& whyNotOwn);

}  // namespace raygraph::session
