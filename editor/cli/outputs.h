// The output files of a command: checked to be writable before the work starts.
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

// What `render` writes if nothing else is asked for.
inline constexpr const char* kDefaultPicture = "render.png";
inline constexpr const char* kDefaultFrames = "render.####.png";

// By the extension, case aside. Error{Usage} for another one.
OutputFile ParseOutput(const std::filesystem::path& path);

// Throws unless every path can be written, as AtomicFile will: Error{Io} with the reason why not,
// Error{Usage} when a path is named twice or is one of the files that are read (`inputs`; one that does not
// exist is no conflict). Leaves no trace, and opens no device and no pipe. Returns a warning for each file
// that is not replaced as a whole.
std::vector<std::string> CheckOutputs(std::span<const std::filesystem::path> paths,
                                      std::span<const std::filesystem::path> inputs);

// The same for the log of a command that writes `outputs` and reads `inputs`. It is appended to from the
// start, so this comes before it is opened. A device or a pipe is always taken.
void CheckLogFile(const std::filesystem::path& log, std::span<const std::filesystem::path> outputs,
                  std::span<const std::filesystem::path> inputs);

}  // namespace raygraph::cli
