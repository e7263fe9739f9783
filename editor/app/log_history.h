// The newest messages of the program's log, for the log panel. Pure; LogHistory: any thread.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>

#include "base/log.h"

namespace raygraph::editor {

struct LogEntry {
    std::string time;  // "14:03:59", local
    LogLevel level = LogLevel::Info;
    std::string category;
    std::string text;
};

// What the panel shows.
struct LogFilter {
    LogLevel minLevel = LogLevel::Debug;
    std::string category;  // "": all
    std::string text;      // that category or text have in them, whatever the case; "": all

    bool Lets(const LogEntry& entry) const;
};

// "14:03:59 warning scene: cornell.gltf: ..."
std::string LineOf(const LogEntry& entry);

class LogHistory {
  public:
    static constexpr size_t kMax = 5000;  // older ones are forgotten

    void Add(const LogMessage& message);
    void Clear();
    // Counts additions and clearings: the same as before, nothing has changed.
    uint64_t Revision() const;
    // How many of this level were added since Clear.
    uint32_t CountOf(LogLevel level) const;
    // Oldest first. `look` must not call back.
    void Read(const std::function<void(const std::deque<LogEntry>&)>& look) const;
    // The lines that the filter lets through, each ended by a line break.
    std::string Text(const LogFilter& filter) const;

  private:
    mutable std::mutex m_mutex;
    std::deque<LogEntry> m_entries;
    std::array<uint32_t, static_cast<size_t>(LogLevel::Off)> m_counts{};
    uint64_t m_revision = 0;
};

}  // namespace raygraph::editor
