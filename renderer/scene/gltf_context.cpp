#include "renderer/scene/gltf_context.h"

#include <algorithm>

#include "base/error.h"
#include "renderer/scene/uri.h"

namespace raygraph::scene {

void Warnings::Add(std::string_view topic, std::string text) {
    const auto found =
        std::find_if(m_entries.begin(), m_entries.end(), [&](const Entry& e) { return e.topic == topic; });
    constexpr size_t kMaxTopics = 64;  // A file may name a million extensions.
    if (found == m_entries.end() && m_entries.size() == kMaxTopics) {
        m_entries.push_back({"", "further kinds of warnings are not shown", 1});
    } else if (found == m_entries.end() && m_entries.size() < kMaxTopics) {
        m_entries.push_back({std::string(topic), std::move(text), 1});
    } else if (found != m_entries.end()) {
        ++found->count;
    }
}

std::vector<std::string> Warnings::Take() {
    std::vector<std::string> lines;
    for (Entry& entry : m_entries) {
        if (entry.count > 1) entry.text += " (and " + std::to_string(entry.count - 1) + " more)";
        lines.push_back(std::move(entry.text));
    }
    m_entries.clear();
    return lines;
}

void GltfContext::Fail(const std::string& path, const std::string& why) const {
    throw Error(ErrorKind::BadInput, label + ": " + (path.empty() ? "" : path + ": ") + why);
}

void GltfContext::Warn(const std::string& path, std::string_view topic, const std::string& what) {
    warnings.Add(topic, label + ": " + (path.empty() ? "" : path + ": ") + what);
}

void GltfContext::FailMemory(const std::string& path, const char* what) const {
    Fail(path, std::string(what) + " the limit of " + std::to_string(MemoryLimit()) +
                   " bytes for a file of " + std::to_string(bytesRead) + " bytes");
}

void GltfContext::ChargeGeometry(const Place& where, uint64_t bytes) {
    const uint64_t limit = MemoryLimit();
    if (bytes > limit || geometryBytes > limit - bytes) FailMemory(where, "decoded geometry exceeds");
    geometryBytes += bytes;
}

void GltfContext::CheckModelBytes(uint64_t bytes) const {
    if (bytes > MemoryLimit()) FailMemory("", "a model of its objects exceeds");
}

void GltfContext::Progress(std::string_view stage, float fraction) const {
    if (options.progress) options.progress(stage, fraction);
}

std::vector<std::byte> GltfContext::ReadUri(const std::string& uri, const Place& where) {
    const uint64_t bytesLeft = options.limits.maxFileBytes - bytesRead;
    try {
        std::vector<std::byte> bytes =
            IsDataUri(uri) ? DecodeDataUri(uri, bytesLeft) : folder.Read(uri, bytesLeft);
        bytesRead += bytes.size();
        return bytes;
    } catch (const Error& error) {
        Fail(where, error.what());
    }
}

}  // namespace raygraph::scene
