#include "editor/cli/picture_list.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <string>

#include "base/printable.h"
#include "base/text.h"
#include "editor/cli/arguments.h"
#include "editor/session/settings/parse.h"

namespace raygraph::cli {

namespace {

constexpr std::string_view kCameraPlace = "{camera}";

}  // namespace

bool HasCameraPlaceholder(const std::filesystem::path& path) {
    return path.filename().string().find(kCameraPlace) != std::string::npos;
}

std::filesystem::path Named(const std::filesystem::path& path, const PictureName& name) {
    const std::filesystem::path numbered = name.number ? Numbered(path, *name.number) : path;
    if (!name.camera) return numbered;
    std::string text = numbered.filename().string();
    for (size_t at = text.find(kCameraPlace); at != text.npos;
         at = text.find(kCameraPlace, at + name.camera->size()))
        text.replace(at, kCameraPlace.size(), *name.camera);
    return numbered.parent_path() / text;
}

std::string CameraFileName(const std::string& camera, size_t index) {
    if (camera.empty() || camera.find_first_of(" ,") != camera.npos) return std::to_string(index);
    std::string text = camera;
    for (char& c : text)
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_') c = '_';
    return text;
}

std::vector<PlannedPicture> PicturesToRender(const RenderArguments& arguments) {
    const uint32_t frameCount = arguments.frames ? arguments.frames->Count() : 1;
    const size_t cameraCount = std::max<size_t>(arguments.cameras.size(), 1);
    std::vector<PlannedPicture> pictures;
    pictures.reserve(frameCount * cameraCount);
    for (uint32_t frame = 0; frame < frameCount; ++frame) {
        for (size_t camera = 0; camera < cameraCount; ++camera) {
            PlannedPicture picture;
            if (arguments.frames) {
                picture.name.number = arguments.frames->NumberOf(frame);
                picture.at = arguments.frames->TimeOf(frame);
                picture.label = Text("frame {} of {}", frame + 1, frameCount);
            }
            if (!arguments.cameras.empty()) {
                picture.camera = arguments.cameras[camera];
                if (arguments.turntable)
                    picture.name.number = static_cast<int64_t>(camera);
                else
                    picture.name.camera = CameraFileName(*picture.camera, camera);
                picture.label +=
                    Text("{}camera {} of {}", picture.label.empty() ? "" : ", ", camera + 1, cameraCount);
            }
            pictures.push_back(std::move(picture));
        }
    }
    return pictures;
}

// --- Ranges of frames ---

namespace {

// Times with decimal digits have rounding errors of up to this fraction of a step.
constexpr double kRounding = 1e-6;

double Steps(const FrameRange& range) {
    return (range.last - range.first) / range.step;
}

uint32_t Skipped(const FrameRange& range) {
    return range.part ? range.part->begin : 0;
}

}  // namespace

uint32_t FrameRange::Count() const {
    if (part) return part->end - part->begin;
    return static_cast<uint32_t>(std::floor(Steps(*this) + kRounding)) + 1;
}

// Rounding gives a frame the same time in each part of a sequence: 3 * 0.1 is not 0.3.
double FrameRange::TimeOf(uint32_t frame) const {
    return std::round((first + (Skipped(*this) + frame) * step) * 1e9) / 1e9;
}

int64_t FrameRange::NumberOf(uint32_t frame) const {
    return std::llround(first / step) + Skipped(*this) + frame;
}

FrameRange PartOf(const Shard& shard, const FrameRange& frames) {
    FrameRange range = frames;
    range.part = PartOf(shard, frames.Count());
    return range;
}

FrameRange ParseFrames(std::string_view text) {
    const size_t a = text.find(':'), b = text.rfind(':');
    if (a == text.npos || a == b) throw MakeError(ErrorKind::Usage, "{} is not A:B:STEP", Quoted(text));
    const auto seconds = [](std::string_view part) { return session::ParseNumber(part, -1e6, 1e6); };
    const FrameRange range{.first = seconds(text.substr(0, a)),
                           .last = seconds(text.substr(a + 1, b - a - 1)),
                           .step = session::ParseNumber(text.substr(b + 1), 1e-6, 1e6)};
    if (range.last < range.first) throw MakeError(ErrorKind::Usage, "{} ends before it begins", Quoted(text));
    if (Steps(range) + kRounding >= FrameRange::kMaxCount)
        throw MakeError(ErrorKind::Usage, "{} has more than {} frames", Quoted(text), FrameRange::kMaxCount);
    return range;
}

bool HasNumberPlaceholder(const std::filesystem::path& path) {
    const std::string name = path.filename().string();
    const size_t first = name.find('#');
    return first != name.npos &&
           name.find('#', std::min(name.find_first_not_of('#', first), name.size())) == name.npos;
}

std::filesystem::path Numbered(const std::filesystem::path& path, int64_t number) {
    std::string name = path.filename().string();
    const size_t first = name.find('#');
    if (first == name.npos) return path;  // an empty path, for example of a report that is not written
    const size_t width = std::min(name.find_first_not_of('#', first), name.size()) - first;
    name.replace(first, width, Text("{:0{}}", number, width));
    return path.parent_path() / name;
}

// --- Shards ---

namespace {

class Reader {
  public:
    explicit Reader(const Variables& variables) : m_variables(variables) {}

    bool Has(const char* name) const { return m_variables(name) != nullptr; }

    uint32_t Count(const char* name, uint32_t least = 0) const {
        const char* text = m_variables(name);
        if (text == nullptr) throw MakeError(ErrorKind::Usage, "{} is not set", name);
        try {
            return session::ParseCount(text, least);
        } catch (const Error& error) {
            throw MakeError(ErrorKind::Usage, "{}: {}", name, error.what());
        }
    }

  private:
    const Variables& m_variables;
};

// The indices of an array may start anywhere, with a constant step (--array=10-40:10). Those of a list
// (--array=1,2,7) do not determine a task's part.
std::optional<Shard> ArrayTaskIndex(const Reader& variables) {
    if (!variables.Has("SLURM_ARRAY_TASK_ID")) return std::nullopt;
    const uint32_t id = variables.Count("SLURM_ARRAY_TASK_ID"),
                   count = variables.Count("SLURM_ARRAY_TASK_COUNT", 1),
                   first = variables.Count("SLURM_ARRAY_TASK_MIN"),
                   last = variables.Count("SLURM_ARRAY_TASK_MAX"),
                   step = variables.Count("SLURM_ARRAY_TASK_STEP", 1);
    if (first > id || id > last || (id - first) % step != 0 || (last - first) / step != count - 1)
        throw MakeError(
            ErrorKind::Usage,
            "SLURM_ARRAY_TASK_ID {} of SLURM_ARRAY_TASK_COUNT {}, _MIN {}, _MAX {}, _STEP {}: these are "
            "not the tasks of one range, as --array=0-15; give --shard I/N",
            id, count, first, last, step);
    return Shard{(id - first) / step, count};
}

Shard Ranked(const Reader& variables, const char* rank, const char* size) {
    const Shard shard{variables.Count(rank), variables.Count(size, 1)};
    if (shard.index >= shard.count)
        throw MakeError(ErrorKind::Usage, "{} {} is not below {} {}", rank, shard.index, size, shard.count);
    return shard;
}

// Finds the process among those that one command has started. mpirun comes first: within a job of Slurm, its
// processes also have the SLURM_PROCID of the process that started them, which is the same for all on a node.
// SLURM_STEP_ID identifies srun; the job script itself has SLURM_PROCID 0 too, but is alone.
std::optional<Shard> ProcessOfLaunch(const Reader& variables, bool isInArray) {
    if (variables.Has("OMPI_COMM_WORLD_RANK") || variables.Has("OMPI_COMM_WORLD_SIZE"))
        return Ranked(variables, "OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE");
    if (variables.Has("SLURM_STEP_ID")) return Ranked(variables, "SLURM_PROCID", "SLURM_NTASKS");
    if (!isInArray && variables.Has("SLURM_JOB_ID"))
        throw Error(
            ErrorKind::Usage,
            "SLURM_ARRAY_TASK_ID is not set, and neither is SLURM_STEP_ID: this job is no array (sbatch "
            "--array=0-15) and the program was not started by srun");
    return std::nullopt;
}

Shard ShardOfProcess(const Variables& values) {
    const Reader variables(values);
    const std::optional<Shard> task = ArrayTaskIndex(variables),
                               process = ProcessOfLaunch(variables, task.has_value());
    if (!task && !process)
        throw Error(
            ErrorKind::Usage,
            "none of SLURM_ARRAY_TASK_ID, SLURM_PROCID and OMPI_COMM_WORLD_RANK is set: this is no task of a "
            "job array, of srun or of mpirun; give I/N");
    if (!task) return *process;
    if (!process) return *task;
    const uint64_t count = uint64_t{task->count} * process->count;
    if (count > std::numeric_limits<uint32_t>::max())
        throw MakeError(ErrorKind::Usage, "SLURM_ARRAY_TASK_COUNT {} times {} processes are too many",
                        task->count, process->count);
    return {task->index * process->count + process->index, static_cast<uint32_t>(count)};
}

}  // namespace

ShardPart PartOf(const Shard& shard, uint32_t total) {
    const auto begin = [&](uint64_t index) { return static_cast<uint32_t>(total * index / shard.count); };
    return {begin(shard.index), begin(uint64_t{shard.index} + 1)};
}

const char* VariableOfProcess(const char* name) {
    return std::getenv(name);
}

Shard ParseShard(std::string_view text, const Variables& variables) {
    if (text == "auto") try {
            return ShardOfProcess(variables);
        } catch (const Error& error) {
            throw MakeError(error.Kind(), "auto: {}", error.what());
        }
    const size_t slash = text.find('/');
    if (slash == text.npos) throw MakeError(ErrorKind::Usage, "{} is neither I/N nor auto", Quoted(text));
    const Shard shard{session::ParseCount(text.substr(0, slash)),
                      session::ParseCount(text.substr(slash + 1), 1)};
    if (shard.index >= shard.count)
        throw MakeError(ErrorKind::Usage, "{}: the {} are numbered from 0 to {}", Quoted(text), shard.count,
                        shard.count - 1);
    return shard;
}

std::string Describe(const Shard& shard) {
    return Text("shard {} of 0 to {}", shard.index, shard.count - 1);
}

}  // namespace raygraph::cli
