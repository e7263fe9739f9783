// Handles the output files of a command, which are checked to be writable before the work starts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "shaders/shared/choice.h"

namespace raygraph::cli {

//   Png: 8-bit, tone-mapped
//   Exr: linear float32 with channels and settings
//   Hdr: linear RGBE
#define RAYGRAPH_OUTPUT_KINDS(X, Of)                           \
    X(Of, Png, 0, ".png", "tone-mapped")                       \
    X(Of, Exr, 1, ".exr", "linear, with AOVs, can be resumed") \
    X(Of, Hdr, 2, ".hdr", "linear")
RAYGRAPH_CHOICE(OutputKind, RAYGRAPH_OUTPUT_KINDS)

struct OutputFile {
    std::filesystem::path path;
    OutputKind kind = OutputKind::Png;
};

// Is written by `render` if it is given no output.
inline constexpr const char* kDefaultPicture = "render.png";
inline constexpr const char* kDefaultFrames = "render.####.png";

// Returns the kind by the extension, in any case. Throws Error{Usage} for an unknown one.
OutputFile ParseOutput(const std::filesystem::path& path);

// Throws unless AtomicFile can write every path: Error{Io} with the reason, or Error{Usage} for a path that
// is named twice or is an existing file among those that are read (`inputs`). It leaves no trace, and opens
// no device and no pipe. Returns a warning for each file that will not be replaced atomically.
std::vector<std::string> CheckOutputs(std::span<const std::filesystem::path> paths,
                                      std::span<const std::filesystem::path> inputs);

// Checks the log of a command that writes `outputs` and reads `inputs` in the same way. Messages are appended
// to it from the start, so this comes before it is opened. A device or a pipe is always accepted.
void CheckLogFile(const std::filesystem::path& log, std::span<const std::filesystem::path> outputs,
                  std::span<const std::filesystem::path> inputs);

}  // namespace raygraph::cli
