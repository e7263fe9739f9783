// What `raygraph bench --compare-traversal` says. Threads: any.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "editor/cli/bench_traversal.h"

namespace raygraph::cli {

nlohmann::ordered_json ToJson(const TraversalResult& result);
void PrintForPeople(const TraversalResult& result);  // to stderr

}  // namespace raygraph::cli
