// The pictures of one `render`, one per frame and camera, with the files to which they are written; and its
// frames (FrameRange) and parts (Shard).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace raygraph::cli {

struct RenderArguments;

// Holds the values for the placeholders in the last part of a file's name.
struct PictureName {
    std::optional<int64_t> number;      // for the run of '#'
    std::optional<std::string> camera;  // for {camera}
};

// Fills in the placeholders. Those without a value are left as they are.
std::filesystem::path Named(const std::filesystem::path& path, const PictureName& name);

// Returns whether the name has a placeholder for the camera.
bool HasCameraPlaceholder(const std::filesystem::path& path);

// Returns the camera for names of files. A name or an index is used as text, with '_' for each character
// other than letters, digits, '-' and '_'; a camera of ten numbers is named by its index in the list.
std::string CameraFileName(const std::string& camera, size_t index);

struct PlannedPicture {
    PictureName name;
    std::optional<double> at;           // time of the frame; none: the settings' time
    std::optional<std::string> camera;  // none: the settings' camera
    std::string label;                  // e.g. "frame 2 of 10, camera 1 of 3"; "": the only picture
};

// Returns at least one picture, ordered by frame and then by camera.
std::vector<PlannedPicture> PicturesToRender(const RenderArguments& arguments);

// Shard is one of the equal parts into which a job array or a process launcher splits a render.
struct Shard {
    uint32_t index = 0;
    uint32_t count = 1;

    bool operator==(const Shard&) const = default;
};

// Covers the indices from `begin` to before `end` of `total`. The parts of all shards are disjoint, ordered,
// differ by at most one in size, and cover everything; some are empty if there are more shards than things.
struct ShardPart {
    uint32_t begin = 0;
    uint32_t end = 0;
};
ShardPart PartOf(const Shard& shard, uint32_t total);

// Returns the value of an environment variable; nullptr: it is not set.
using Variables = std::function<const char*(const char* name)>;
const char* VariableOfProcess(const char* name);

// Parses "2/16", or "auto", which uses the variables of a Slurm job array, of Open MPI's mpirun, or of srun.
// If a task of an array starts several processes, these split the task's part. Throws Error{Usage} that names
// missing, malformed or inconsistent variables.
Shard ParseShard(std::string_view text, const Variables& variables = VariableOfProcess);

// Returns e.g. "shard 2 of 0 to 15".
std::string Describe(const Shard& shard);

// FrameRange gives the frames of an animation that one command renders.
struct FrameRange {
    double first = 0.0, last = 0.0, step = 1.0;  // in seconds
    std::optional<ShardPart> part = {};          // the shard's part of these frames; none: all

    static constexpr uint32_t kMaxCount = 100'000;

    // `last` is included if it is a whole number of steps after `first`.
    uint32_t Count() const;
    // Returns the time in seconds, rounded to a billionth; `frame` is relative to the part.
    double TimeOf(uint32_t frame) const;
    // Returns the number in file names, counted as if the animation began at 0, so that ranges that are
    // rendered separately fit together.
    int64_t NumberOf(uint32_t frame) const;
};

// Returns the frames that the shard renders.
FrameRange PartOf(const Shard& shard, const FrameRange& frames);

// Parses "A:B:STEP". Throws Error{Usage}.
FrameRange ParseFrames(std::string_view text);

// Returns whether the file's name, without its folder, has a place for the number: exactly one run of '#'.
bool HasNumberPlaceholder(const std::filesystem::path& path);
// Puts the number there, padded with zeros to the width of the run: "a.####.exr" becomes "a.0007.exr".
std::filesystem::path Numbered(const std::filesystem::path& path, int64_t number);

}  // namespace raygraph::cli
