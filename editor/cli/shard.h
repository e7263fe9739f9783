// Shard is one of the equal parts into which a job array or a process launcher splits a render.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace raygraph::cli {

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

}  // namespace raygraph::cli
