// The output files of a command: they are checked to be writable before the work starts, and written
// independently of each other (OutputWriter).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "editor/cli/exit_code.h"
#include "rhi/format.h"
#include "shaders/shared/choice.h"

namespace raygraph::cli {

//   Png, Jpg: 8-bit, tone-mapped
//   Exr: linear float32 with channels and settings
//   Hdr: linear RGBE
#define RAYGRAPH_OUTPUT_KINDS(X, Of)                           \
    X(Of, Png, 0, ".png", "tone-mapped")                       \
    X(Of, Jpg, 1, ".jpg", "the same without alpha")            \
    X(Of, Exr, 2, ".exr", "linear, with AOVs, can be resumed") \
    X(Of, Hdr, 3, ".hdr", "linear")
RAYGRAPH_CHOICE(OutputKind, RAYGRAPH_OUTPUT_KINDS)

struct OutputFile {
    std::filesystem::path path;
    OutputKind kind = OutputKind::Png;
};

// Is written by `render` if it is given no output.
inline constexpr const char* kDefaultPicture = "render.png";
inline constexpr const char* kDefaultFrames = "render.####.png";
inline constexpr rhi::Extent2D kSheetPicture{320, 320};  // is the default size of each in a contact sheet

inline constexpr auto kOutputKinds =
    std::to_array({OutputKind::Png, OutputKind::Jpg, OutputKind::Exr, OutputKind::Hdr});

// Returns whether a picture of this kind is shown as it is: tone-mapped, with eight bits a channel.
constexpr bool IsDisplayed(OutputKind kind) {
    return kind == OutputKind::Png || kind == OutputKind::Jpg;
}

// Returns the kind by the extension, in any case; .jpeg is a .jpg. Throws Error{Usage} for one that is not of
// these kinds, and for a folder.
OutputFile ParseOutput(const std::filesystem::path& path, std::span<const OutputKind> kinds = kOutputKinds);

// Throws unless AtomicFile can write every path: Error{Io} with the reason, or Error{Usage} for a path that
// is named twice or is an existing file among those that are read (`inputs`). It leaves no trace, and opens
// no device and no pipe. Returns a warning for each file that will not be replaced atomically.
std::vector<std::string> CheckOutputs(std::span<const std::filesystem::path> paths,
                                      std::span<const std::filesystem::path> inputs);

// Checks the log of a command that writes `outputs` and reads `inputs` in the same way. Messages are appended
// to it from the start, so this comes before it is opened. A device or a pipe is always accepted.
void CheckLogFile(const std::filesystem::path& log, std::span<const std::filesystem::path> outputs,
                  std::span<const std::filesystem::path> inputs);

// OutputWriter writes the outputs of a command independently: a failure of one does not prevent the others.
class OutputWriter {
  public:
    // Is called for each output that fails, with a line that names the output.
    using Say = std::function<void(const std::filesystem::path& file, std::string_view why)>;
    explicit OutputWriter(Say say) : m_say(std::move(say)) {}

    // `write` throws if it fails.
    void Add(const std::filesystem::path& file, std::function<void()> write);
    // Writes what was added since the last call, in that order, but devices and pipes after all files: one
    // whose reader is missing or slow delays no file.
    void WriteAll();

    // Returns the files that were written, in order.
    const std::vector<std::filesystem::path>& Written() const { return m_written; }
    bool HasWritten(const std::filesystem::path& file) const;
    // Returns whether writing has failed and has left an incomplete file in place of the old one
    // (IncompleteFile).
    bool IsTorn(const std::filesystem::path& file) const;
    // Returns Done, or the status of the first output that failed.
    ExitCode Result() const { return m_result; }

  private:
    struct Output {
        std::filesystem::path file;
        std::function<void()> write;
    };

    Say m_say;
    std::vector<Output> m_outputs;
    std::vector<std::filesystem::path> m_written, m_torn;
    ExitCode m_result = ExitCode::Done;
};

}  // namespace raygraph::cli
