#include "editor/session/choice_memory.h"

#include <algorithm>
#include <fstream>
#include <span>
#include <vector>

#include "base/atomic_file.h"

namespace raygraph::session {

namespace {

struct Line {
    std::string key, known;
};

std::vector<Line> ReadLines(const std::filesystem::path& file) {
    std::vector<Line> lines;
    std::ifstream stream(file);
    for (std::string text; std::getline(stream, text);)
        if (const size_t tab = text.find('\t'); tab != std::string::npos)
            lines.push_back({text.substr(0, tab), text.substr(tab + 1)});
    return lines;
}

std::string AsKey(std::string_view text) {
    std::string key(text);
    std::ranges::replace_if(
        key, [](char c) { return c == '\t' || c == '\n'; }, ' ');
    return key;
}

}  // namespace

std::optional<std::string> ChoiceMemory::Find(std::string_view key) const {
    if (m_file.empty()) return std::nullopt;
    for (const Line& line : ReadLines(m_file))
        if (line.key == AsKey(key)) return line.known;
    return std::nullopt;
}

void ChoiceMemory::Remember(std::string_view key, std::string_view known) const {
    if (m_file.empty()) return;
    const std::string asKey = AsKey(key);
    std::string text;
    for (const Line& line : ReadLines(m_file))
        if (line.key != asKey) text += line.key + '\t' + line.known + '\n';
    text.append(asKey).append(1, '\t').append(known).append(1, '\n');
    try {
        std::filesystem::create_directories(m_file.parent_path());
        AtomicFile file(m_file);
        file.Write(std::as_bytes(std::span(text)));
        file.Commit();
    } catch (const std::exception&) {
        // It is measured again
    }
}

}  // namespace raygraph::session
