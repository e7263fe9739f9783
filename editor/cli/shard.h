// One of the equal parts into which a job array or a launcher of processes splits a render.
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

// Of `total` things those from `begin` to before `end`. The parts of all shards are disjoint, lie in the
// order of their indices, differ by at most one in size, and have all of the things; some have none where
// there are more shards than things.
struct ShardPart {
    uint32_t begin = 0;
    uint32_t end = 0;
};
ShardPart PartOf(const Shard& shard, uint32_t total);

// The value of a variable; nullptr: it is not set.
using Variables = std::function<const char*(const char* name)>;
const char* VariableOfProcess(const char* name);

// "2/16", or "auto": by the variables that a job array of Slurm, mpirun of Open MPI, or srun sets. In a task
// of an array that starts several processes, these are the parts of the task's part. Error{Usage} naming the
// variables that are missing, malformed or do not fit together.
Shard ParseShard(std::string_view text, const Variables& variables = VariableOfProcess);

// "shard 2 of 0 to 15".
std::string Describe(const Shard& shard);

}  // namespace raygraph::cli
