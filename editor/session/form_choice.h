// Which form of the integrator is the fastest on a device: measured once, and remembered. For
// editor/session/ and editor/cli/ alone.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "editor/session/choice_memory.h"
#include "editor/session/device_scene.h"
#include "editor/session/pass_times.h"

namespace raygraph::session {

// A ChoiceMemory of forms.
class FormMemory {
  public:
    explicit FormMemory(std::filesystem::path file) : m_memory(std::move(file)) {}

    // None of lines that are no choice, too.
    std::optional<passes::FormSettings> Find(std::string_view key) const;
    void Remember(std::string_view key, const passes::FormSettings& form) const;

  private:
    ChoiceMemory m_memory;
};

struct FormTime {
    passes::FormSettings form;
    double msPerSample = 0.0;  // of the device, for a sample of every pixel
};

// Of the passes of Trace in a frame, in any form: the sum of their medians.
double MsOfTrace(const PassTimes& times);

// Renders a few frames of each; the samples are lost. A form of several frames has its median. None of a
// device without timestamps.
std::vector<FormTime> MeasureForms(DeviceScene& scene, std::span<const passes::FormSettings> forms);

// The form in which the paths of the scene's picture are traced the fastest. On a CPU the loop: the forms
// differ by less there than compiling the kernels of both takes. Else the one that is remembered for device,
// driver, version, shader features and number of pixels; if there is none, the fastest of a few, measured.
passes::FormSettings ChooseForm(DeviceScene& scene, const FormMemory& memory);

}  // namespace raygraph::session
