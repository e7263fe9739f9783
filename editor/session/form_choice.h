// Which form of the integrator is the fastest on a device: measured once, and remembered. For
// editor/session/ and editor/cli/ alone.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "editor/session/device_scene.h"
#include "editor/session/pass_times.h"

namespace raygraph::session {

// A text file of choices: lines of a key, a tab and a form. Threads: one at a time; processes may share a
// file, of which the last one to write keeps its choice.
class FormMemory {
  public:
    // An empty path: nothing is remembered.
    explicit FormMemory(std::filesystem::path file) : m_file(std::move(file)) {}

    // None where it is not known: without a file, and of lines that are no choice, too.
    std::optional<passes::FormSettings> Find(std::string_view key) const;
    // A file that cannot be written is left alone: the choice is measured again next time.
    void Remember(std::string_view key, const passes::FormSettings& form) const;

  private:
    std::filesystem::path m_file;
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
