// Runs a graph that a file describes. Threads: one at a time.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "editor/graph_run/graph_file.h"
#include "rhi/device.h"

namespace raygraph::graph_run {

struct PassCost {
    std::string name;
    double gpuMs = 0.0;  // the median over the frames
};

// The values of an output after the last frame.
struct OutputValues {
    rhi::Format format = rhi::Format::Undefined;  // of a texture
    rhi::Extent2D extent{};
    std::vector<std::byte> bytes;
};

struct GraphRun {
    std::string plan, dot;              // of the last frame, as text and for Graphviz
    std::vector<PassCost> passes;       // that the last frame executed, in order
    std::vector<OutputValues> outputs;  // those of the description
};

// Executes the frames. Throws Error{BadInput} with one line for what the description or a file of it has
// wrong, and as rhi::CompileGlsl does for a shader.
GraphRun RunGraph(rhi::Device& device, const GraphFile& graph);

// Writes a .png, .exr or .bin, as the name of the file says. The numbers are written as they are: a .png
// shows 0 as black and 1 as white. Throws Error{Io} if it cannot be written.
void WriteOutput(const OutputValues& values, const std::filesystem::path& file);

}  // namespace raygraph::graph_run
