#include "editor/app/log_history.h"

#include "base/os.h"
#include "base/text.h"
#include "editor/app/input.h"

namespace raygraph::editor {

bool LogFilter::Accepts(const LogEntry& entry) const {
    if (entry.level < minLevel || (!category.empty() && entry.category != category)) return false;
    return HasPart(entry.text, text) || HasPart(entry.category, text);
}

std::string LineOf(const LogEntry& entry) {
    return raygraph::Text("{} {} {}: {}", entry.time, Name(entry.level), entry.category, entry.text);
}

void LogHistory::Add(const LogMessage& message) {
    LogEntry entry{.time = os::LocalTimeOfDay(),
                   .level = message.level,
                   .category = std::string(message.category),
                   .text = std::string(message.text)};
    const std::scoped_lock lock(m_mutex);
    m_entries.push_back(std::move(entry));
    if (m_entries.size() > kMax) m_entries.pop_front();
    m_counts[static_cast<size_t>(message.level)]++;
    ++m_revision;
}

void LogHistory::Clear() {
    const std::scoped_lock lock(m_mutex);
    m_entries.clear();
    m_counts = {};
    ++m_revision;
}

uint64_t LogHistory::Revision() const {
    const std::scoped_lock lock(m_mutex);
    return m_revision;
}

uint32_t LogHistory::CountOf(LogLevel level) const {
    const std::scoped_lock lock(m_mutex);
    return m_counts[static_cast<size_t>(level)];
}

void LogHistory::Read(const std::function<void(const std::deque<LogEntry>&)>& look) const {
    const std::scoped_lock lock(m_mutex);
    look(m_entries);
}

std::string LogHistory::Text(const LogFilter& filter) const {
    std::string text;
    Read([&](const std::deque<LogEntry>& entries) {
        for (const LogEntry& entry : entries)
            if (filter.Accepts(entry)) text += LineOf(entry) + "\n";
    });
    return text;
}

}  // namespace raygraph::editor
