// LogHistory keeps the newest messages of the program's log for the log panel. Threads: LogHistory: any;
// everything else: pure functions.
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
    std::string time;  // local, e.g. "14:03:59"
    LogLevel level = LogLevel::Info;
    std::string category;
    std::string text;
};

// Selects the messages that the panel shows.
struct LogFilter {
    LogLevel minLevel = LogLevel::Debug;
    std::string category;  // "": all
    std::string text;      // substring of category or text, in any case; "": all

    bool Accepts(const LogEntry& entry) const;
};

// Returns the message as text: "14:03:59 warning scene: cornell.gltf: ..."
std::string LineOf(const LogEntry& entry);

class LogHistory {
  public:
    static constexpr size_t kMax = 5000;  // entries; older ones are dropped

    void Add(const LogMessage& message);
    void Clear();
    // Returns a number that changes with every added message and every Clear.
    uint64_t Revision() const;
    // Returns how many messages of this level were added since Clear.
    uint32_t CountOf(LogLevel level) const;
    // Passes the messages to `look`, oldest first. `look` must not call back.
    void Read(const std::function<void(const std::deque<LogEntry>&)>& look) const;
    // Returns the lines that pass the filter, each ended by a line break.
    std::string Text(const LogFilter& filter) const;

  private:
    mutable std::mutex m_mutex;
    std::deque<LogEntry> m_entries;
    std::array<uint32_t, static_cast<size_t>(LogLevel::Off)> m_counts{};
    uint64_t m_revision = 0;
};

}  // namespace raygraph::editor
