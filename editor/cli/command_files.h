// Lists the files that a command reads and writes, except for its log and the files that its scene names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/log.h"
#include "editor/cli/arguments.h"
#include "editor/cli/picture_list.h"

namespace raygraph::cli {

struct CommandFiles {
    std::vector<std::filesystem::path> inputs;   // must not be written
    std::vector<std::filesystem::path> updated;  // read before the outputs are written
    std::vector<std::filesystem::path> outputs;
    std::vector<std::filesystem::path> replacing;  // outputs that may be one of `updated`
};

// Returns the files of the command; arguments without a file add nothing.
CommandFiles FilesOf(const RenderArguments& arguments);
// Returns the files of one picture; for an empty name, the patterns themselves.
CommandFiles FilesOf(const RenderArguments& arguments, const PictureName& name);
CommandFiles FilesOf(const BenchArguments& arguments);
CommandFiles FilesOf(const InfoArguments& arguments);
CommandFiles FilesOf(const GraphArguments& arguments);
// The outputs are named by the description.
CommandFiles FilesOf(const GraphRunArguments& arguments);
CommandFiles FilesOf(const ExplainArguments& arguments);
CommandFiles FilesOf(const MergeArguments& arguments);
CommandFiles FilesOf(const DenoiseArguments& arguments);
CommandFiles FilesOf(const CompareArguments& arguments);
CommandFiles FilesOf(const VerifyArguments& arguments);
CommandFiles FilesOf(const EditArguments& arguments);

// Calls CheckOutputs for all outputs. `log` gets its warnings.
void CheckWritable(const CommandFiles& files, const Log& log);

// Returns the pictures that `render` writes, named for one picture: those of the command line; if there are
// none, the file that is resumed, else kDefaultPicture, or kDefaultFrames with frames or a turntable.
std::vector<OutputFile> PicturesOf(const RenderArguments& arguments, const PictureName& name = {});

}  // namespace raygraph::cli
