#include "editor/cli/shard.h"

#include <cstdlib>
#include <limits>
#include <optional>

#include "base/printable.h"
#include "base/text.h"
#include "editor/session/settings/parse.h"

namespace raygraph::cli {

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
