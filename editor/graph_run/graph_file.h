// GraphFile: a render graph described in JSON (docs/graph.md), for experiments without C++. Reading one needs
// no device. Threads: any.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "rhi/format.h"

namespace raygraph::graph_run {

// All files are relative to the folder of the description, and below it.
struct FileTexture {
    rhi::Format format = rhi::Format::Rgba32Float;
    rhi::Extent2D size{};  // empty: it is that of `sizeOf`, or of the picture in `file`
    std::string sizeOf;
    uint32_t layers = 1;
    bool isPersistent = false;   // keeps its contents from frame to frame; begins with zeros
    std::filesystem::path file;  // not empty: begins with this picture, or with the texels of a .bin
};

struct FileBuffer {
    uint64_t bytes = 0;  // 0: it is that of `file`
    bool isPersistent = false;
    std::filesystem::path file;  // not empty: begins with the bytes of this file
};

struct FrameNumber {};  // from 0
using ConstantValue = std::variant<FrameNumber, std::vector<double>>;

struct FilePass {
    std::string name;                               // no other pass has it
    std::filesystem::path shader;                   // .comp, or .frag for the whole of its targets
    std::map<std::string, std::string> bind;        // names of the shader: textures and buffers
    std::vector<std::string> targets;               // of a .frag, at least one
    std::map<std::string, ConstantValue> push;      // push constants
    std::map<std::string, double> specialize;       // specialization constants
    std::string over;                               // dispatched over this texture; "": the first written one
    std::optional<std::array<uint32_t, 3>> groups;  // or in so many workgroups
    bool isAsync = false;                           // on the compute queue
};

struct FileOutput {
    std::string file;  // .png, .exr or .bin, without a folder
    std::string resource;
    uint32_t layer = 0;  // of a picture; a .bin has all layers
};

struct GraphFile {
    std::string name;              // of the description, for messages
    std::filesystem::path folder;  // of the description
    std::map<std::string, FileTexture> textures;
    std::map<std::string, FileBuffer> buffers;
    std::vector<FilePass> passes;
    std::vector<FileOutput> outputs;
    uint32_t frames = 1;
};

// Limits of a description.
inline constexpr uint32_t kMaxFrames = 1'000'000;
inline constexpr uint64_t kMaxResourceBytes = uint64_t{1} << 32;

// Throws Error{BadInput} of one line, "blur.json: passes[1].dispatch: ...", for text that is not JSON, for an
// unknown or a repeated key, a value of another kind or out of range, and a name that nothing has.
GraphFile ParseGraphFile(std::string_view text, std::string_view name);
// Reads a description of at most 1 MiB. Throws Error{BadInput} also if it cannot be read.
GraphFile ReadGraphFile(const std::filesystem::path& path);

// Returns the bytes of a texture's first level.
uint64_t TextureBytes(rhi::Format format, rhi::Extent2D size, uint32_t layers);

}  // namespace raygraph::graph_run
