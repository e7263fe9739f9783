// Measurements: numbers that are measured once on a device, and kept on disk for later processes.
//
// There is one text file per device model and driver version, named as that of the pipeline cache. Its lines
// have a name, a tab and the number. Threads: any. Never throws except for lack of memory.
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
    // The name has neither a tab nor a line break. If processes write at the same time, the numbers of the
    // last one stay. A failure to write is ignored: the number is measured again next time.
    void Remember(std::string_view name, double value);

  private:
    mutable std::mutex m_mutex;
    std::filesystem::path m_file;
    std::map<std::string, double, std::less<>> m_values;
};

}  // namespace raygraph::rhi
