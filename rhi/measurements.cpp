#include "rhi/measurements.h"

#include <charconv>
#include <fstream>
#include <span>

#include "base/atomic_file.h"
#include "base/text.h"

namespace raygraph::rhi {
namespace {

std::map<std::string, double, std::less<>> ReadLines(const std::filesystem::path& file) {
    std::map<std::string, double, std::less<>> values;
    std::ifstream stream(file);
    for (std::string text; std::getline(stream, text);) {
        const size_t tab = text.find('\t');
        if (tab == std::string::npos) continue;
        double value = 0.0;
        const char* const end = text.data() + text.size();
        const auto [parsed, error] = std::from_chars(text.data() + tab + 1, end, value);
        if (error == std::errc{} && parsed == end) values[text.substr(0, tab)] = value;
    }
    return values;
}

}  // namespace

void Measurements::SetFile(std::filesystem::path file) {
    const std::lock_guard lock(m_mutex);
    m_file = std::move(file);
    m_values.merge(ReadLines(m_file));
}

std::optional<double> Measurements::Find(std::string_view name) const {
    const std::lock_guard lock(m_mutex);
    const auto found = m_values.find(name);
    return found != m_values.end() ? std::optional(found->second) : std::nullopt;
}

void Measurements::Remember(std::string_view name, double value) {
    const std::lock_guard lock(m_mutex);
    m_values.insert_or_assign(std::string(name), value);
    if (m_file.empty()) return;
    std::string text;
    for (const auto& [known, number] : m_values) text += Text("{}\t{}\n", known, number);
    try {
        std::filesystem::create_directories(m_file.parent_path());
        AtomicFile file(m_file);
        file.Write(std::as_bytes(std::span(text)));
        file.Commit();
    } catch (const std::exception&) {
        // The number is measured again
    }
}

}  // namespace raygraph::rhi
