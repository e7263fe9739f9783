// Which files a command reads and writes, but for its log and those that its scene names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/log.h"
#include "editor/cli/arguments.h"
#include "editor/cli/picture_list.h"

namespace raygraph::cli {

struct CommandFiles {
    std::vector<std::filesystem::path> inputs;   // not to be written
    std::vector<std::filesystem::path> updated;  // read before the outputs are written
    std::vector<std::filesystem::path> outputs;
    std::vector<std::filesystem::path> replacing;  // those of the outputs that may be one of `updated`
};

// What is not given is not in the lists.
CommandFiles FilesOf(const RenderArguments& arguments);
// Those of one picture; of an empty name, the patterns themselves.
CommandFiles FilesOf(const RenderArguments& arguments, const PictureName& name);
CommandFiles FilesOf(const BenchArguments& arguments);
CommandFiles FilesOf(const InfoArguments& arguments);
CommandFiles FilesOf(const GraphArguments& arguments);
CommandFiles FilesOf(const MergeArguments& arguments);
CommandFiles FilesOf(const EditArguments& arguments);

// CheckOutputs for all outputs. `log` gets its warnings.
void CheckWritable(const CommandFiles& files, const Log& log);

// The pictures that `render` writes: those that are given; if there is none, the file that is resumed, else
// kDefaultPicture, or kDefaultFrames where there are frames. As they are named for one picture.
std::vector<OutputFile> PicturesOf(const RenderArguments& arguments, const PictureName& name = {});

}  // namespace raygraph::cli
