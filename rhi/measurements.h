// Measurements: numbers that were measured once on a device, and are remembered from one process to the next.
//
// One text file a device model and driver version, named as that of the pipeline cache: lines of a name, a
// tab and the number. Threads: any. Never throws, but for lack of memory.
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace raygraph::rhi {

class Measurements {
  public:
    // Numbers are kept in memory alone until a file is set.
    void SetFile(std::filesystem::path file);

    std::optional<double> Find(std::string_view name) const;
    // The name has neither a tab nor an end of a line. Of processes that write at the same time the last one
    // keeps its numbers. A file that cannot be written is left alone: the number is measured again next time.
    void Remember(std::string_view name, double value);

  private:
    mutable std::mutex m_mutex;
    std::filesystem::path m_file;
    std::map<std::string, double, std::less<>> m_values;
};

}  // namespace raygraph::rhi
